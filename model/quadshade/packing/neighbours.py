# SPDX-License-Identifier: Apache-2.0
"""
An order of triangles in which neighbours follow each other, for packets that carry vertices.

Corners can be named as long as they are among the last that were sent. Meshes from generators come in strips;
files of flat parts often come feature by feature, and then most corners are sent again and again.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from quadshade.contract.arrays import Floats, Ints
from quadshade.contract.formats import Formats
from quadshade.contract.triangles import ScreenTriangles
from quadshade.contract.vertex_program import check_formats

REMEMBERED = 61
"""Corners that can surely be named: those of the board's table that the next triangle does not overwrite."""

MOST_SENT = 0.8
"""Corners sent a triangle up to which an order stays: strips send about half a one, part.stl's file two."""

_LOOKED_AT = 8
"""Most triangles of an edge that are looked at; a surface has two."""


@njit(cache=True)
def _sent(places: Ints, count: int) -> int:
    """Corners that are sent in an order: those whose place is none of the last ones."""
    last = np.full(count, -REMEMBERED - 1, np.int64)
    sent = 0
    for place in places:
        if sent - last[place] > REMEMBERED:
            last[place] = sent
            sent += 1
    return sent


@njit(cache=True)
def _walk(runs: Ints, starts: Ints, colours: Floats) -> Ints:
    """
    From each triangle to the neighbour whose colours are nearest, else to the oldest one passed by.

    ``runs`` has the triangles of every edge, edge by edge, doubled, and one more for the last one of an edge;
    ``starts`` (n, 3) is where a triangle's edges begin in it.
    """
    count = len(starts)
    order = np.empty(count, np.int64)
    passed = np.empty(3 * _LOOKED_AT * count, np.int64)
    done = np.zeros(count, np.bool_)
    head = tail = first = 0
    current = -1
    for at in range(count):
        if current < 0:
            while head < tail and done[passed[head]]:
                head += 1
            if head < tail:
                current = passed[head]
            else:
                while done[first]:
                    first += 1
                current = first
        order[at], done[current] = current, True
        best, nearest = -1, np.inf
        for edge in range(3):
            start = starts[current, edge]
            for place in range(start, min(start + _LOOKED_AT, len(runs))):
                other = runs[place] >> 1
                if not done[other]:
                    off = np.abs(colours[other] - colours[current]).sum()
                    if off < nearest:
                        best, nearest = other, off
                    passed[tail] = other
                    tail += 1
                if runs[place] & 1:
                    break
        current = best
    return order


def _neighbour_order(triangles: ScreenTriangles) -> Ints:
    """(n,) int64: an order for the line, their own where that has neighbours near already."""
    own = np.arange(len(triangles))
    if len(triangles) < 2:
        return own
    flat = triangles.vertices.reshape(-1, 2).astype(np.int64)
    _, places = np.unique(flat[:, 0] << 32 | flat[:, 1] & 0xFFFFFFFF, return_inverse=True)
    places = places.reshape(-1)
    count = int(places.max()) + 1
    if _sent(places, count) <= MOST_SENT * len(triangles):
        return own
    corners = places.reshape(-1, 3)
    ends = np.sort(corners[:, [[0, 1], [0, 2], [1, 2]]], axis=2).reshape(-1, 2)
    edges = ends[:, 0] * count + ends[:, 1]
    by_edge = np.argsort(edges, kind="stable")
    ordered = edges[by_edge]
    is_last = np.append(ordered[1:] != ordered[:-1], True)
    starts = np.searchsorted(ordered, edges).reshape(-1, 3)
    return _walk(by_edge // 3 << 1 | is_last, starts, triangles.samples.mean(axis=2))


def ordered_for_vertices(triangles: ScreenTriangles, formats: Formats) -> ScreenTriangles:
    """
    Triangles in the order in which they go as vertices.

    Parameters
    ----------
    triangles : ScreenTriangles
    formats : Formats

    Returns
    -------
    ScreenTriangles
      As they are where the order is that of painting: without depth.

    Raises
    ------
    QuadshadeError
      There is no ``vertex_unpacker`` for the formats.
    """
    check_formats(formats)
    if triangles.depth is None or not formats.with_depth:
        return triangles
    return triangles.ordered(_neighbour_order(triangles))
