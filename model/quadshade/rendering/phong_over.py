# SPDX-License-Identifier: Apache-2.0
"""Phong shading over what a picture shows, where its own coverage is that of the undivided scene."""

from __future__ import annotations

import numpy as np

from quadshade.choices import FITS, STYLES
from quadshade.contract.formats import Formats
from quadshade.contract.triangles import Drawing
from quadshade.image import paint
from quadshade.rendering.settings import RenderSettings
from quadshade.rendering.shade import ShownScene
from quadshade.shading.reference import phong


def is_whole(settings: RenderSettings, scene: ShownScene, drawing: Drawing) -> bool:
    """Whether a drawing's triangles are those of the scene, none of them in parts, moved or styled."""
    choice, style = settings.scene, settings.style
    plain = style.style == STYLES[0] and not style.kinds and choice.supersample == 1
    stats = drawing.stats
    one_each = stats["packets"] == stats["triangles_drawn"] and stats["triangles"] == len(scene.projected)
    return plain and choice.fit == FITS[0] and one_each and scene.faces == len(scene.whole)


def phong_over(scene: ShownScene, triangle: np.ndarray, formats: Formats) -> np.ndarray:
    """(h, w, 3) uint8: Phong shading where a drawing shows its triangles."""
    covered = triangle >= 0
    rows, columns = np.nonzero(covered)
    value = phong(scene.projected, triangle[covered], columns, rows, scene.lights, scene.surface, formats)
    place = np.full(triangle.shape, -1, np.int64)
    place[covered] = np.arange(len(rows))
    return paint(place, value.astype(np.float32), scene.ground, (1 << formats.value_bits) - 1)
