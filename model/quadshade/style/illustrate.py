# SPDX-License-Identifier: Apache-2.0
"""A scene in a style with its edges, in one call: what ``render --style ... --edges ...`` does."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from quadshade.choices import EDGE_KINDS
from quadshade.contract.formats import Formats
from quadshade.image import paint, visible
from quadshade.scene.project import Projected
from quadshade.shading.lights import default_lights
from quadshade.shading.material import Material
from quadshade.shading.sample import sample
from quadshade.shading.specular import sample_specular, specular_formats
from quadshade.shading.toon import toon_curves
from quadshade.style.cartoon import smooth_tones
from quadshade.style.edges import draw_edges, find_edges
from quadshade.style.gbuffer import draw_gbuffer
from quadshade.style.gooch import gooch_material
from quadshade.style.hatch import hatch

PAPER = (255, 255, 255)
TOON_STEPS = 4
"""Levels of a cartoon's diffuse light."""


def illustrate(
    projected: Projected,
    style: str = "none",
    material: Material | None = None,
    kinds: Sequence[str] = EDGE_KINDS,
    variant: str = "diagonal",
    engine: str = "model",
) -> np.ndarray:
    """
    Draw a scene on white paper.

    Parameters
    ----------
    projected : Projected
    style : str
      ``none``, ``cartoon``, ``gooch`` or ``hatch``.
    material : Material, optional
    kinds : sequence of str
      Edges over it: ``profile``, ``inner``.
    variant : str
      ``diagonal`` or ``eight``.
    engine : str

    Returns
    -------
    (h, w, 3) uint8
    """
    from quadshade.engine import draw

    material = Material() if material is None else material
    lights, formats = default_lights(projected.axes), Formats()
    if style == "cartoon":
        formats = specular_formats({}, projected, lights, material, through_tables=True)
        curves = toon_curves(TOON_STEPS, material.exponent)
        triangles = sample_specular(projected, "quadratic-specular", lights, material, formats, curves=curves)
    elif style == "gooch":
        toned, key = gooch_material(material, lights)
        triangles = sample(projected, "quadratic", key, toned, formats)
    else:
        triangles = sample(projected, "quadratic", lights, material, formats)
    pixels = draw(triangles, formats, engine).pixels
    shown = visible(pixels, projected.width, projected.height)
    picture = paint(shown, pixels.value, PAPER)
    if style == "hatch":
        picture = hatch(picture, shown >= 0)
    elif style == "cartoon":
        picture = smooth_tones(picture, shown >= 0)
    gbuffer, _ = draw_gbuffer(projected, engine=engine)
    return draw_edges(picture, find_edges(gbuffer, variant), kinds)
