# SPDX-License-Identifier: Apache-2.0
"""Where a fit takes the error: at the pixels that are drawn, or at some points of every triangle."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from quadshade.contract.arrays import Floats, Ints
from quadshade.contract.formats import CONSTANT, Formats
from quadshade.contract.triangles import ScreenTriangles
from quadshade.engine import draw
from quadshade.errors import QuadshadeError
from quadshade.scene.project import Projected, doubled_area
from quadshade.shading.reference import barycentric

PLACES = ("pixels", "points")
STEPS = 3
"""``points``: a triangle's edges are cut into so many parts; a point stands in the middle of each piece."""


BEYOND = 0.02
"""``pixels``: what a pixel's area counts where it is not drawn."""


@dataclass(frozen=True)
class Places:
    """
    Points of triangles.

    Attributes
    ----------
    triangle : (p,) int64
    weights : (p, 3) float64
      Barycentric coordinates on the screen.
    area : (p,) float64
      Pixels that the place stands for.
    """

    triangle: Ints
    weights: Floats
    area: Floats


def places_of(kind: str, projected: Projected, formats: Formats) -> Places:
    """
    The places of a kind.

    Parameters
    ----------
    kind : str
      ``pixels``: the centres of all pixels that the core draws. ``points``: 9 of every triangle.
    projected : Projected
    formats : Formats

    Returns
    -------
    Places

    Raises
    ------
    QuadshadeError
      An unknown kind.
    """
    points = _points(projected, formats)
    if kind == "points":
        return points
    if kind == "pixels":
        drawn = _pixels(projected, formats)
        return Places(
            np.concatenate([drawn.triangle, points.triangle]),
            np.concatenate([drawn.weights, points.weights]),
            np.concatenate([drawn.area, BEYOND * points.area]),
        )
    raise QuadshadeError(f"a fit at {kind!r}", f"give {' or '.join(PLACES)}")


def _pixels(projected: Projected, formats: Formats) -> Places:
    """Exact coverage, from the golden model: a channel of constant colour, no depth."""
    count = len(projected)
    plain = replace(formats.core, num_channels=1, with_depth=0)
    flat = ScreenTriangles(
        projected.width,
        projected.height,
        projected.vertices,
        np.zeros((count, 1, 6)),
        np.full((count, 1), CONSTANT, dtype=np.int64),
        None,
        ("none",),
    )
    pixels = draw(flat, plain, "model").pixels
    owner = pixels.triangle.astype(np.int64)
    weights = barycentric(projected.vertices, owner, pixels.x, pixels.y, formats.subpixel_bits)
    return Places(owner, weights, np.ones(len(owner)))


def _points(projected: Projected, formats: Formats) -> Places:
    """The middles of the ``STEPS``**2 equal pieces that a triangle is cut into."""
    corners = [
        (np.array([first, second, STEPS - first - second - 1]) + turn) / STEPS
        for first in range(STEPS)
        for second in range(STEPS - first)
        for turn in ([1 / 3] * 3, [2 / 3, 2 / 3, -1 / 3])
    ]
    inside = np.array([corner for corner in corners if corner.min() > 0])
    area = np.abs(doubled_area(projected.vertices)) / 2 / 4.0**formats.subpixel_bits
    return Places(
        np.repeat(np.arange(len(projected)), len(inside)),
        np.tile(inside, (len(projected), 1)),
        np.repeat(area / len(inside), len(inside)),
    )
