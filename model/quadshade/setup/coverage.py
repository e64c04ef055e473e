# SPDX-License-Identifier: Apache-2.0
"""The pixels that the core covers, from the set-up's own edges: no colour, no packet."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from quadshade.contract.arrays import Ints
from quadshade.setup.edges import Cut


class MeshRows(NamedTuple):
    """
    The pixels of every triangle, row by row.

    Attributes
    ----------
    top : (n,) int64
      First scanline of each triangle.
    rows : (n + 1,) int64
      Where its scanlines begin among all.
    left : (scanlines,) int64
      First column of each.
    places : (scanlines + 1,) int64
      Where its pixels begin among all.
    """

    top: Ints
    rows: Ints
    left: Ints
    places: Ints


@njit(cache=True)
def mesh_rows(cut: Cut, count: int) -> MeshRows:
    """
    The pixels of triangles.

    Parameters
    ----------
    cut : Cut
      From :func:`quadshade.setup.edges.cut_triangles`.
    count : int
      Triangles.

    Returns
    -------
    MeshRows
    """
    heads, edges = cut
    top, bottom = np.full(count, np.int64(1) << 60), np.full(count, -1)
    for head in heads:
        triangle = head.triangle
        top[triangle] = min(top[triangle], head.y)
        bottom[triangle] = max(bottom[triangle], head.y + head.rows_first + head.rows_second - 1)
    rows = np.zeros(count + 1, np.int64)
    for triangle in range(count):
        rows[triangle + 1] = rows[triangle] + max(bottom[triangle] - top[triangle] + 1, 0)
    left, places = np.zeros(rows[count], np.int64), np.zeros(rows[count] + 1, np.int64)
    for primitive in range(len(heads)):
        head = heads[primitive]
        major, minor = edges[primitive, 0], edges[primitive, 1]
        begin, from_begin = major.column, major.remainder
        end, from_end = minor.column, minor.remainder
        at = rows[head.triangle] + head.y - top[head.triangle]
        for row in range(head.rows_first + head.rows_second):
            if row == head.rows_first:
                minor = edges[primitive, 2]
                end, from_end = minor.column, minor.remainder
            width = max(end - begin, 0)
            left[at + row] = -begin - width if head.mirror else begin
            places[at + row + 1] = width
            begin, from_begin = begin + major.step, from_begin + major.increment
            if from_begin >= major.height:
                begin, from_begin = begin + 1, from_begin - major.height
            end, from_end = end + minor.step, from_end + minor.increment
            if from_end >= minor.height:
                end, from_end = end + 1, from_end - minor.height
    for row in range(len(left)):
        places[row + 1] += places[row]
    return MeshRows(top, rows, left, places)


@njit(cache=True)
def pixels_of(pixels: MeshRows) -> tuple[Ints, Ints, Ints]:
    """Triangle, x and y of every pixel."""
    triangle, x, y = np.empty((3, pixels.places[-1]), np.int64)
    for index in range(len(pixels.top)):
        for row in range(pixels.rows[index], pixels.rows[index + 1]):
            for place in range(pixels.places[row], pixels.places[row + 1]):
                triangle[place], x[place] = index, pixels.left[row] + place - pixels.places[row]
                y[place] = pixels.top[index] + row - pixels.rows[index]
    return triangle, x, y
