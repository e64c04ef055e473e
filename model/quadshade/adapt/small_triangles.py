# SPDX-License-Identifier: Apache-2.0
"""Where small triangles have pixels: an error there is known, not estimated from a grid."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from quadshade.contract.arrays import Floats, Int, Ints
from quadshade.scene.project import Projected, doubled_area
from quadshade.setup.coverage import MeshRows, mesh_rows
from quadshade.setup.edges import cut_triangles

FEW = 64
"""A triangle of no more pixels is judged by them."""
LARGE = 2 * FEW
"""Pixels of area from which a triangle is not asked for its pixels."""


class PixelCentres(NamedTuple):
    """
    Pixels of triangles that have few of them.

    Attributes
    ----------
    pixels : (n,) float64
      How many each triangle has: counted where its area is less than ``LARGE``, else its area.
    rows : (k,) int64
      Triangles with 1 to ``FEW`` of them.
    have : (k,) int64
      How many these have.
    points : (m, 3) float64
      Barycentric coordinates of their centres, one triangle after the other.
    whole : (m, 3) float64
      The same in the triangles of which these are parts. A part's corners are rounded, so its own shading is
      not quite the whole's, and where normals turn within a pixel that can be seen.
    """

    pixels: Floats
    rows: Ints
    have: Ints
    points: Floats
    whole: Floats


@njit(cache=True, error_model="numpy", forceinline=True)
def _put_weights(corners: Ints, x: Int, y: Int, subpixel_bits: Int, out: Floats) -> None:
    """Barycentric coordinates of a pixel's centre, as :func:`quadshade.shading.reference.barycentric`."""
    x0, y0 = 2 * corners[0, 0], 2 * corners[0, 1]
    ax, ay, bx, by = (
        2 * corners[1, 0] - x0, 2 * corners[1, 1] - y0, 2 * corners[2, 0] - x0, 2 * corners[2, 1] - y0,
    )  # fmt: skip
    px, py = ((2 * x + 1) << subpixel_bits) - x0, ((2 * y + 1) << subpixel_bits) - y0
    area = ax * by - bx * ay
    out[1], out[2] = (px * by - bx * py) / area, (ax * py - px * ay) / area
    out[0] = 1 - out[1] - out[2]


@njit(cache=True, error_model="numpy")
def _few_pixels(
    covered: MeshRows,
    small: Ints,
    vertices: Ints,
    whole: Ints,
    root: Ints,
    subpixel_bits: Int,
    pixels: Floats,
) -> tuple[Ints, Ints, Floats, Floats]:
    """The last four columns of :class:`PixelCentres`, from what ``small`` (s,) triangles cover."""
    few, total = 0, 0
    for index in range(len(small)):
        have = covered.places[covered.rows[index + 1]] - covered.places[covered.rows[index]]
        pixels[small[index]] = have
        if 0 < have <= FEW:
            few += 1
            total += have
    rows, count = np.empty(few, np.int64), np.empty(few, np.int64)
    own, of_whole = np.empty((total, 3)), np.empty((total, 3))
    few, at = 0, 0
    for index in range(len(small)):
        first, last = covered.rows[index], covered.rows[index + 1]
        have = covered.places[last] - covered.places[first]
        if not 0 < have <= FEW:
            continue
        triangle = small[index]
        rows[few], count[few] = triangle, have
        few += 1
        for row in range(first, last):
            for step in range(covered.places[row + 1] - covered.places[row]):
                x, y = covered.left[row] + step, covered.top[index] + row - first
                _put_weights(vertices[triangle], x, y, subpixel_bits, own[at])
                _put_weights(whole[root[triangle]], x, y, subpixel_bits, of_whole[at])
                at += 1
    return rows, count, own, of_whole


def pixel_centres(
    projected: Projected, subpixel_bits: int, whole: Projected, root: np.ndarray
) -> PixelCentres:
    """
    Find the pixels of small triangles, as the core covers them.

    Parameters
    ----------
    projected : Projected
    subpixel_bits : int
    whole : Projected
    root : (n,) int
      The triangle of ``whole`` of which each is a part.

    Returns
    -------
    PixelCentres
    """
    pixels = abs(doubled_area(projected.vertices)) / 2 / 4.0**subpixel_bits
    small = np.flatnonzero(pixels < LARGE)
    vertices = np.ascontiguousarray(projected.vertices, dtype=np.int64)
    cut = cut_triangles(vertices[small], projected.width, projected.height, subpixel_bits)
    covered = mesh_rows(cut, len(small))
    given = np.ascontiguousarray(whole.vertices, dtype=np.int64), np.asarray(root)
    return PixelCentres(pixels, *_few_pixels(covered, small, vertices, *given, subpixel_bits, pixels))
