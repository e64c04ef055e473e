# SPDX-License-Identifier: Apache-2.0
"""What a picture costs in bytes and clocks, and how far it is from Phong shading."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from quadshade.choices import MAX_ERROR
from quadshade.contract.formats import Formats
from quadshade.contract.shade_state import ShadeState
from quadshade.contract.triangles import Pixels, ScreenTriangles
from quadshade.engine import draw
from quadshade.golden.shade.render_core import needed_writes
from quadshade.scene.project import Projected
from quadshade.setup.packet import pack, packet_words
from quadshade.setup.triangle_setup import setup_triangles
from quadshade.shading.lights import Light
from quadshade.shading.material import Material
from quadshade.shading.reference import phong


@dataclass(frozen=True)
class ErrorFigures:
    """
    Drawn pixels against Phong shading of the undivided mesh, over every pixel drawn and all channels.

    Attributes
    ----------
    largest, rms : float
      Output units.
    exceeding : float
      Share of the pixels in which any channel is off by more than was allowed.
    """

    largest: float
    rms: float
    exceeding: float


def pixel_errors(
    pixels: Pixels,
    root: np.ndarray,
    projected: Projected,
    lights: Sequence[Light] | None = None,
    material: Material | None = None,
    formats: Formats | None = None,
) -> np.ndarray:
    """
    How far drawn pixels are from Phong shading.

    Parameters
    ----------
    pixels : Pixels
    root : (n,) int
      For each drawn triangle, the one of ``projected`` that it is a part of.
    projected : Projected
      The undivided mesh.
    lights, material, formats
      As for :func:`adapt`.

    Returns
    -------
    (m, 3) float64
      Differences without sign, in output units; the reference is not rounded.
    """
    true = phong(projected, root[pixels.triangle], pixels.x, pixels.y, lights, material, formats)
    return abs(pixels.value - true)


def error_figures(errors: np.ndarray, allowed: float = np.inf) -> ErrorFigures:
    """Figures of (m, 3) errors from :func:`pixel_errors`."""
    if not errors.size:
        return ErrorFigures(0.0, 0.0, 0.0)
    over = (errors > allowed).any(axis=1).mean()
    return ErrorFigures(float(errors.max()), float(np.sqrt((errors**2).mean())), float(over))


def shade_bytes(state: ShadeState | None, first: int = 0) -> int:
    """Bytes of the shade unit's state: colours, and power tables from an entry on."""
    return 0 if state is None else 4 * state.num_writes(first)


def state_bytes(triangles: ScreenTriangles, formats: Formats) -> int:
    """Bytes of the shade unit's state that triangles are drawn with: of tables what their pixels read."""
    state = triangles.shade
    if state is None or not state.tables.size:
        return shade_bytes(state)
    words = pack(setup_triangles(triangles, formats, limit=MAX_ERROR), formats)
    return 4 * len(needed_writes(words, state, formats))


def stream_bytes(triangles: ScreenTriangles, formats: Formats) -> int:
    """Bytes of the set-up stream and, before it, of the shade unit's state."""
    primitives = setup_triangles(triangles, formats, limit=MAX_ERROR)
    words = packet_words(primitives.orders, primitives.header["has_second"], formats)
    return 4 * int(words.sum()) + state_bytes(triangles, formats)


def core_clocks(triangles: ScreenTriangles, formats: Formats) -> int:
    """Clocks that the core takes, from the golden model."""
    return draw(triangles, formats).stats["clocks"]
