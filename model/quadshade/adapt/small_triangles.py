# SPDX-License-Identifier: Apache-2.0
"""Where small triangles have pixels: an error there is known, not estimated from a grid."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from quadshade.contract.formats import CONSTANT, Formats
from quadshade.contract.triangles import ScreenTriangles
from quadshade.engine import draw
from quadshade.scene.project import Projected, doubled_area
from quadshade.shading.reference import barycentric

FEW = 64
"""A triangle of no more pixels is judged by them."""
LARGE = 2 * FEW
"""Pixels of area from which a triangle is not asked for its pixels."""


@dataclass(frozen=True)
class PixelCentres:
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
    whole : (k, ``FEW``, 3) float64
      The same in the triangles of which these are parts. A part's corners are rounded, so its own shading is
      not quite the whole's, and where normals turn within a pixel that can be seen.
    used : (k, ``FEW``) bool
      Which of the points are pixels.
    """

    pixels: np.ndarray
    rows: np.ndarray
    points: np.ndarray
    whole: np.ndarray
    used: np.ndarray

    def groups(self) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]]:
        """Rows, points, whole and used of triangles of up to 4, of up to 16, and of up to ``FEW`` pixels."""
        count, least = self.used.sum(axis=1), 0
        for most in (4, 16, FEW):
            mine = np.flatnonzero((count > least) & (count <= most))
            least = most
            if len(mine):
                yield (
                    self.rows[mine],
                    self.points[mine, :most],
                    self.whole[mine, :most],
                    self.used[mine, :most],
                )


def pixel_centres(projected: Projected, formats: Formats, whole: Projected, root: np.ndarray) -> PixelCentres:
    """
    Find the pixels of small triangles, as the core covers them.

    Parameters
    ----------
    projected : Projected
    formats : Formats
    whole : Projected
    root : (n,) int
      The triangle of ``whole`` of which each is a part.

    Returns
    -------
    PixelCentres
    """
    count = abs(doubled_area(projected.vertices)) / 2 / 4.0**formats.subpixel_bits
    small = np.flatnonzero(count < LARGE)
    plain = {"num_channels": 1, "max_order": CONSTANT, "with_depth": 0, "with_shade": 0}
    plain_formats = formats.with_generics(plain | {"stream_width": 32})
    vertices = projected.vertices[small]
    shape = (len(small), 1)
    triangles = ScreenTriangles(
        projected.width, projected.height, vertices, np.zeros((*shape, 6)), np.zeros(shape, int), None, ("c",)
    )
    pixels = draw(triangles, plain_formats).pixels
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
    used = np.zeros((len(rows), FEW), dtype=bool)
    used[row, slot] = True
    own, of_whole = np.full((2, len(rows), FEW, 3), 1 / 3)
    for points, corners, triangle in (
        (own, vertices, owner),
        (of_whole, whole.vertices, root[small[owner]]),
    ):
        points[row, slot] = barycentric(
            corners, triangle, pixels.x[order], pixels.y[order], formats.subpixel_bits
        )
    return PixelCentres(count, small[rows], own, of_whole, used)
