# SPDX-License-Identifier: Apache-2.0
"""
Powell and Sabin's split of triangles into six, on the sub-pixel lattice, without a change of coverage.

A point inside each triangle (the incentre) is joined to the corners and to a point on every edge. On an edge
that two triangles share, this point lies where the line between their inner points crosses it. Rounded to a
sub-pixel it is hardly ever on the edge; it is taken where no pixel's centre lies between the edge and its two
halves, so that the parts of a triangle cover exactly the pixels that the triangle covers, whatever is on the
other side of the edge.

M. J. D. Powell, M. A. Sabin, "Piecewise quadratic approximations on triangles" (1977).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from quadshade.contract.arrays import Bools, Floats, Ints
from quadshade.fit.columns import first_column
from quadshade.fit.elements import ENDS, Elements, Neighbours

SIDES = np.array([[0, 1, 0], [1, 2, 2], [2, 0, 1]])
"""A triangle's sides as they go round it: from and to which corner, and which of the samples' edges it is."""

NEAR, FAR = 24, 64
"""Sub-pixels along an edge within which its point is looked for: one shared by two triangles, another one."""


class Split(NamedTuple):
    """
    Where triangles would be split.

    Attributes
    ----------
    centre : (n, 2) int64
      Inner points, sub-pixels.
    point : (n, 3, 2) int64
      Points on the edges 12, 13, 23.
    share : (n, 3) float64
      Where they divide their edges, from the edge's first end in the order of ``ENDS``.
    sound : (n,) bool
      Whether all six parts have an area and turn as the triangle does, and cover what it covers.
    """

    centre: Ints
    point: Ints
    share: Floats
    sound: Bools


def split_of(
    elements: Elements, neighbours: Neighbours, vertices: Ints, subpixel_bits: int, moves: Ints
) -> Split:
    """
    Find the split of every triangle of a mesh.

    Parameters
    ----------
    elements : Elements
    neighbours : Neighbours
    vertices : (n, 3, 2) int64
      Sub-pixels.
    subpixel_bits : int
    moves : (k, 2) int64
      Sub-pixels: coverage stays the same wherever the triangles are moved by one of these.

    Returns
    -------
    Split
    """
    vertices = np.asarray(vertices, dtype=np.int64)
    centre = _incentres(vertices)
    partner = np.full((len(vertices), 3), -1)
    for side in (0, 1):
        partner[tuple(neighbours.pairs[:, side].T)] = neighbours.pairs[:, 1 - side, 0]
    point, share, sound = _edge_points(
        elements.index, vertices, centre, partner, ENDS, 1 << subpixel_bits, moves
    )
    sound &= _sound(vertices, centre, point, SIDES)
    return Split(centre, point, share, sound)


def _incentres(vertices: Ints) -> Ints:
    """(n, 2) sub-pixels nearest to the centres of the inscribed circles."""
    place = vertices.astype(np.float64)
    opposite = np.linalg.norm(place[:, [1, 2, 0]] - place[:, [2, 0, 1]], axis=2)
    around = np.maximum(opposite.sum(axis=1), 1.0)
    return np.rint((place * opposite[:, :, None]).sum(axis=1) / around[:, None]).astype(np.int64)


@njit(cache=True)
def _same_columns(one: Ints, two: Ints, point: Ints, scale: int) -> bool:
    """Whether an edge and its two halves over a point leave the same pixel centres on either side."""
    if one[1] > two[1]:
        one, two = two, one
    if not one[1] <= point[1] <= two[1]:
        return False
    if one[1] == two[1]:
        return bool(point[1] == one[1])
    half = scale // 2
    for row in range(-((half - one[1]) // scale), -((half - two[1]) // scale)):
        y = row * scale + half
        whole = first_column(one, two, y, scale)
        part = first_column(one, point, y, scale) if y < point[1] else first_column(point, two, y, scale)
        if whole != part:
            return False
    return True


@njit(cache=True)
def _edge_point(one: Ints, two: Ints, share: float, reach: int, scale: int, moves: Ints, out: Ints) -> bool:
    """The sub-pixel on the edge nearest to a share of it that changes no coverage, if there is one."""
    run = two - one
    axis = 0 if abs(run[0]) >= abs(run[1]) else 1
    length = run[axis]
    if length == 0:
        return False
    begin = np.int64(np.rint(share * length))
    for step in range(2 * reach + 1):
        along = begin + ((step + 1) // 2 if step % 2 else -(step // 2))
        if not 0 < along * np.sign(length) < abs(length):
            continue
        out[axis] = one[axis] + along
        out[1 - axis] = one[1 - axis] + np.int64(np.rint(along * run[1 - axis] / length))
        same = True
        for move in moves:
            same = same and _same_columns(one + move, two + move, out + move, scale)
        if same:
            return True
    return False


@njit(cache=True)
def _edge_points(
    index: Ints, vertices: Ints, centre: Ints, partner: Ints, ends: Ints, scale: int, moves: Ints
) -> tuple[Ints, Floats, Bools]:
    """Points on edges, their shares, and whether a triangle has found all three."""
    count = len(index)
    point, share = np.zeros((count, 3, 2), np.int64), np.zeros((count, 3))
    sound = np.ones(count, np.bool_)
    one, two, out = np.empty(2, np.int64), np.empty(2, np.int64), np.empty(2, np.int64)
    for row in range(count):
        for edge in range(3):
            start, end = ends[edge]
            # Both sides look along the edge in the same sense, so that they find the same point.
            turned = index[row, start] > index[row, end]
            if turned:
                start, end = end, start
            one[:], two[:] = vertices[row, start], vertices[row, end]
            other, wanted = partner[row, edge], 0.5
            if other >= 0:
                run_x, run_y = two[0] - one[0], two[1] - one[1]
                first, last = centre[min(row, other)], centre[max(row, other)]
                before = run_x * (first[1] - one[1]) - run_y * (first[0] - one[0])
                after = run_x * (last[1] - one[1]) - run_y * (last[0] - one[0])
                if before != after:
                    far = before / (before - after)
                    x = first[0] + far * (last[0] - first[0]) - one[0]
                    y = first[1] + far * (last[1] - first[1]) - one[1]
                    wanted = (x * run_x + y * run_y) / max(run_x * run_x + run_y * run_y, 1)
            reach = FAR if other < 0 else NEAR
            if not _edge_point(one, two, wanted, reach, scale, moves, out):
                sound[row] = False
                continue
            point[row, edge] = out
            run_x, run_y = float(two[0] - one[0]), float(two[1] - one[1])
            along = (out[0] - one[0]) * run_x + (out[1] - one[1]) * run_y
            there = along / (run_x * run_x + run_y * run_y)
            share[row, edge] = 1 - there if turned else there
    return point, share, sound


@njit(cache=True)
def _area(one: Ints, two: Ints, three: Ints) -> int:
    """The doubled area of three points."""
    return int((two[0] - one[0]) * (three[1] - one[1]) - (three[0] - one[0]) * (two[1] - one[1]))


@njit(cache=True)
def _sound(vertices: Ints, centre: Ints, point: Ints, sides: Ints) -> Bools:
    """(n,) whether all parts, of split and of whole edges, have an area and turn as their triangle does."""
    sound = np.zeros(len(vertices), np.bool_)
    for row in range(len(vertices)):
        turn = np.sign(_area(vertices[row, 0], vertices[row, 1], vertices[row, 2]))
        good = turn != 0
        for side in range(3):
            one, two = vertices[row, sides[side, 0]], vertices[row, sides[side, 1]]
            on = point[row, sides[side, 2]]
            good = good and turn * _area(one, two, centre[row]) > 0
            good = good and turn * _area(one, on, centre[row]) > 0
            good = good and turn * _area(on, two, centre[row]) > 0
        sound[row] = good
    return sound
