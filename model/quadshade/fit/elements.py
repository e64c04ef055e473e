# SPDX-License-Identifier: Apache-2.0
"""
Quadratic Lagrange elements over the mesh on the screen: one unknown a vertex, one an edge.

Six values, at the vertices and the middles of the edges, are a quadratic. Neighbours that share an edge share
its three values, so they meet in value all along it. Where the six points differ (a crease, a seam between
colours, a border), each side keeps values of its own.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

from quadshade.contract.arrays import Bools, Floats, Ints
from quadshade.contract.triangles import ScreenTriangles

SAME = 256
"""Corners at one place share an unknown if their colours are equal to 1 / 256 of an output unit."""

ENDS = np.array([[0, 1], [0, 2], [1, 2]])
"""Corners that edges 12, 13 and 23 join, in the order of the samples."""


@dataclass(frozen=True)
class Elements:
    """
    The unknowns of a mesh.

    Attributes
    ----------
    index : (n, 6) int64
      Unknown of each triangle's sample, in the order of ``ScreenTriangles.samples``.
    start : (m, c) float64
      The six points' values of the unknowns.
    """

    index: Ints
    start: Floats

    def samples(self, values: Floats) -> Floats:
        """(n, c, 6) samples of (m, c) values."""
        return values[self.index].transpose(0, 2, 1)


@dataclass(frozen=True)
class Neighbours:
    """
    What lies on the other side of edges.

    Attributes
    ----------
    pairs : (s, 2, 2) int64
      Triangle and edge (12, 13, 23) on both sides of edges that two triangles share, one on each side.
    odd : (n, 3) bool
      Edges that more than two triangles share, or two on the same side.
    """

    pairs: Ints
    odd: Bools


def shared_elements(triangles: ScreenTriangles) -> Elements:
    """
    Number the unknowns of quadratic triangles.

    Parameters
    ----------
    triangles : ScreenTriangles
      Sampled at six points.

    Returns
    -------
    Elements
    """
    count, channels = triangles.samples.shape[:2]
    samples = np.ascontiguousarray(triangles.samples.transpose(0, 2, 1))
    keys = np.empty((3 * count, 2 + channels), dtype=np.int64)
    _corner_keys(np.asarray(triangles.vertices, dtype=np.int64), samples, keys)
    corner = _row_numbers(keys).reshape(count, 3)
    _edge_keys(corner, samples, keys)
    index = np.empty((count, 6), dtype=np.int64)
    index[:, :3] = corner
    index[:, 3:] = _row_numbers(keys).reshape(count, 3) + (corner.max(initial=-1) + 1)
    start = np.empty((int(index.max(initial=-1)) + 1, channels))
    start[index.reshape(-1)] = samples.reshape(-1, channels)
    return Elements(index, start)


@njit(cache=True)
def _colour_key(value: float) -> int:
    """A colour in steps of 1 / ``SAME``; what is no number, or beyond all colours, is the same as such."""
    return int(np.rint(value * SAME)) if abs(value) < 1e9 else -(1 << 62)


@njit(cache=True)
def _corner_keys(vertices: Ints, samples: Floats, keys: Ints) -> None:
    """Place and colour of each corner."""
    for triangle in range(len(vertices)):
        for corner in range(3):
            key = keys[3 * triangle + corner]
            key[0], key[1] = vertices[triangle, corner, 0], vertices[triangle, corner, 1]
            for channel in range(samples.shape[2]):
                key[2 + channel] = _colour_key(samples[triangle, corner, channel])


@njit(cache=True)
def _edge_keys(corner: Ints, samples: Floats, keys: Ints) -> None:
    """Both ends' numbers, and the colour of the middle, of edges 12, 13 and 23."""
    for triangle in range(len(corner)):
        for edge in range(3):
            one, two = corner[triangle, edge // 2], corner[triangle, 1 + (edge + 1) // 2]
            key = keys[3 * triangle + edge]
            key[0], key[1] = min(one, two), max(one, two)
            for channel in range(samples.shape[2]):
                key[2 + channel] = _colour_key(samples[triangle, 3 + edge, channel])


def neighbours_of(elements: Elements, vertices: Ints) -> Neighbours:
    """
    Find the edges across which a colour can be smooth.

    Parameters
    ----------
    elements : Elements
    vertices : (n, 3, 2) int64
      Sub-pixels.

    Returns
    -------
    Neighbours
    """
    middles = elements.index[:, 3:].reshape(-1)
    order = np.argsort(middles, kind="stable")
    counts = np.bincount(middles, minlength=len(elements.start))
    first = (np.cumsum(counts) - counts)[counts == 2]
    both = np.stack([order[first], order[first + 1]], axis=1)
    pairs = np.stack([both // 3, both % 3], axis=2)
    odd = (counts[middles] > 2).reshape(-1, 3)
    apart = _on_both_sides(vertices, pairs)
    for side in (0, 1):
        odd[tuple(pairs[~apart][:, side].T)] = True
    return Neighbours(pairs[apart], odd)


def _on_both_sides(vertices: Ints, pairs: Ints) -> Bools:
    """(s,) whether the third corners of (s, 2, 2) triangles and edges lie on both sides of their edge."""
    one, two = (vertices[pairs[:, 0, 0], ENDS[pairs[:, 0, 1], end]] for end in (0, 1))
    along, side = two - one, []
    for which in (0, 1):
        off = vertices[pairs[:, which, 0], 2 - pairs[:, which, 1]] - one
        side.append(np.sign(along[:, 0] * off[:, 1] - along[:, 1] * off[:, 0]))
    return side[0] * side[1] < 0


@njit(cache=True)
def _row_numbers(rows: Ints) -> Ints:
    """(k,) a number for each distinct row of (k, w) int64, in the order in which they appear."""
    count, width = rows.shape
    size = 16
    while size < 2 * count:
        size *= 2
    slots, first = np.full(size, -1), np.empty(count, np.int64)
    numbers, known = np.empty(count, np.int64), 0
    for row in range(count):
        mixed = 0
        for column in range(width):
            mixed = (mixed ^ rows[row, column]) * 0x9E3779B97F4A7C1
            mixed ^= mixed >> 29
        at = mixed & (size - 1)
        while slots[at] >= 0:
            other, same = first[slots[at]], True
            for column in range(width):
                same = same and rows[other, column] == rows[row, column]
            if same:
                break
            at = (at + 1) & (size - 1)
        if slots[at] < 0:
            slots[at], first[known] = known, row
            known += 1
        numbers[row] = slots[at]
    return numbers
