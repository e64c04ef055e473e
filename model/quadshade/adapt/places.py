# SPDX-License-Identifier: Apache-2.0
"""Where small triangles have pixels: an error there is known, not estimated from a grid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from quadshade.engine import draw
from quadshade.formats import CONSTANT, Formats
from quadshade.scene.project import Projected, doubled_area
from quadshade.shading.reference import barycentric
from quadshade.triangles import ScreenTriangles

FEW = 64
"""A triangle of no more pixels is judged by them."""
LARGE = 2 * FEW
"""Pixels of area from which a triangle is not asked for its pixels."""


@dataclass(frozen=True)
class Places:
    """
    Pixels of triangles that have few of them.

    Attributes
    ----------
    pixels : (n,) float64
      How many each triangle has: counted where its area is less than ``LARGE``, else its area.
    rows : (k,) int64
      Triangles with 1 to ``FEW`` of them.
    points : (k, ``FEW``, 3) float64
      Barycentric coordinates of their centres.
    used : (k, ``FEW``) bool
      Which of the points are pixels.
    """

    pixels: np.ndarray
    rows: np.ndarray
    points: np.ndarray
    used: np.ndarray


def pixel_places(projected: Projected, formats: Formats) -> Places:
    """
    Find the pixels of small triangles, as the core covers them.

    Parameters
    ----------
    projected : Projected
    formats : Formats

    Returns
    -------
    Places
    """
    count = abs(doubled_area(projected.vertices)) / 2 / 4.0**formats.subpixel_bits
    small = np.flatnonzero(count < LARGE)
    plain = {"num_channels": 1, "max_order": CONSTANT, "with_depth": 0, "with_shade": 0}
    plain = formats.with_generics(plain | {"stream_width": 32})
    vertices = projected.vertices[small]
    shape = (len(small), 1)
    triangles = ScreenTriangles(
        projected.width, projected.height, vertices, np.zeros((*shape, 6)), np.zeros(shape, int), None, ("c",)
    )
    pixels = draw(triangles, plain).pixels
    have = np.bincount(pixels.triangle, minlength=len(small))
    count[small] = have
    few = (have > 0) & (have <= FEW)
    order = np.flatnonzero(few[pixels.triangle])
    order = order[np.argsort(pixels.triangle[order], kind="stable")]
    owner = pixels.triangle[order]
    rows = np.flatnonzero(few)
    first = np.cumsum(have[rows]) - have[rows]
    row = np.searchsorted(rows, owner)
    slot = np.arange(len(order)) - first[row]
    points = np.full((len(rows), FEW, 3), 1 / 3)
    used = np.zeros(points.shape[:2], dtype=bool)
    points[row, slot] = barycentric(vertices, owner, pixels.x[order], pixels.y[order], formats.subpixel_bits)
    used[row, slot] = True
    return Places(count, small[rows], points, used)
