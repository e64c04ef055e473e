# SPDX-License-Identifier: Apache-2.0
"""Loops over triangles and edges, compiled: places and edges that are shared, and parts of triangles."""

from __future__ import annotations

import numpy as np
from numba import njit

from quadshade.contract.arrays import Bools, Floats, Ints


@njit(cache=True)
def _slot(one: int, other: int, mask: int) -> int:
    """Where a pair of numbers is looked for first."""
    mixed = one * 0x9E3779B1 + other * 0x85EBCA77
    return (mixed ^ (mixed >> 17) ^ (mixed >> 31)) & mask


@njit(cache=True)
def empty_slots(count: int) -> Ints:
    """An empty table for so many pairs, at least half free."""
    size = 16
    while size < 2 * count:
        size *= 2
    return np.full(size, -1)


@njit(cache=True)
def numbered(slots: Ints, pairs: Ints, count: int, one: int, other: int) -> int:
    """The number of a pair among ``count`` ones; one that is new gets the next."""
    mask = len(slots) - 1
    at = _slot(one, other, mask)
    while slots[at] >= 0:
        known = slots[at]
        if pairs[known, 0] == one and pairs[known, 1] == other:
            return known
        at = (at + 1) & mask
    slots[at] = count
    pairs[count, 0], pairs[count, 1] = one, other
    return count


@njit(cache=True)
def place_numbers(vertices: Ints) -> tuple[Ints, Ints]:
    """(n, 3) a number for each place that (n, 3, 2) vertices take, and (places, 2) the places."""
    ids = np.empty(vertices.shape[:2], np.int64)
    slots, places, count = empty_slots(ids.size), np.empty((ids.size, 2), np.int64), 0
    for index in range(len(vertices)):
        for corner in range(3):
            number = numbered(slots, places, count, vertices[index, corner, 0], vertices[index, corner, 1])
            count = max(count, number + 1)
            ids[index, corner] = number
    return ids, places[:count]


@njit(cache=True)
def edge_numbers(ids: Ints, places: Ints) -> tuple[Ints, Bools, Ints]:
    """(n, 3) numbers of edges 0-1, 1-2, 2-0, whether they are run from the second end, (edges, 2, 2) ends."""
    index, turned = np.empty(ids.shape, np.int64), np.empty(ids.shape, np.bool_)
    slots, pairs, count = empty_slots(ids.size), np.empty((ids.size, 2), np.int64), 0
    for row in range(len(ids)):
        for corner in range(3):
            start, end = ids[row, corner], ids[row, (corner + 1) % 3]
            x, y = places[end, 0] - places[start, 0], places[end, 1] - places[start, 1]
            turned[row, corner] = x < 0 or (x == 0 and y < 0)
            if turned[row, corner]:
                start, end = end, start
            number = numbered(slots, pairs, count, start, end)
            count = max(count, number + 1)
            index[row, corner] = number
    ends = np.empty((count, 2, 2), np.int64)
    for number in range(count):
        for end in range(2):
            ends[number, end] = places[pairs[number, end]]
    return index, turned, ends


@njit(cache=True)
def touching(vertices: Ints, chosen: Ints) -> Bools:
    """(n,) whether triangles have a corner at one of (k, 2) places."""
    slots, places, count = empty_slots(len(chosen)), np.empty((len(chosen), 2), np.int64), 0
    for index in range(len(chosen)):
        number = numbered(slots, places, count, chosen[index, 0], chosen[index, 1])
        count = max(count, number + 1)
    mask, out = len(slots) - 1, np.zeros(len(vertices), np.bool_)
    for index in range(len(vertices)):
        for corner in range(3):
            x, y = vertices[index, corner, 0], vertices[index, corner, 1]
            at = _slot(x, y, mask)
            while slots[at] >= 0 and not out[index]:
                out[index] = places[slots[at], 0] == x and places[slots[at], 1] == y
                at = (at + 1) & mask
    return out


@njit(cache=True)
def with_neighbours(ids: Ints, chosen: Bools) -> Bools:
    """(n,) chosen triangles and those that share a place with one."""
    touched = np.zeros(3 * len(ids), np.bool_)
    for index in range(len(ids)):
        if chosen[index]:
            for corner in range(3):
                touched[ids[index, corner]] = True
    out = np.zeros(len(ids), np.bool_)
    for index in range(len(ids)):
        out[index] = touched[ids[index, 0]] or touched[ids[index, 1]] or touched[ids[index, 2]]
    return out


@njit(cache=True)
def _side(one: Ints, two: Ints, three: Ints) -> int:
    """-1, 0 or 1: the sense of three points."""
    area = (two[0] - one[0]) * (three[1] - one[1]) - (three[0] - one[0]) * (two[1] - one[1])
    return int(area > 0) - int(area < 0)


@njit(cache=True)
def _six(vertices: Ints, middle: Ints, index: Ints, points: Ints) -> None:
    """A triangle's corners, then the new vertices on its edges 0, 1, 2."""
    for corner in range(3):
        for axis in range(2):
            points[corner, axis] = vertices[corner, axis]
            points[3 + corner, axis] = middle[index[corner], axis]


@njit(cache=True)
def _code(marks: Bools, index: Ints) -> int:
    """Split edges of a triangle, bit e: edge e."""
    return marks[index[0]] + 2 * marks[index[1]] + 4 * marks[index[2]]


@njit(cache=True)
def _apart(one: Ints, other: Ints) -> int:
    """The squared distance of two points."""
    return (one[0] - other[0]) ** 2 + (one[1] - other[1]) ** 2


@njit(cache=True)
def _diagonal(points: Ints, code: int) -> int:
    """Which diagonal is shorter in the quadrilateral that two splits leave; 0 for other splits."""
    for by in range(3):
        if code == 1 << by | 1 << (by + 1) % 3:
            one = _apart(points[by], points[3 + (by + 1) % 3])
            return int(_apart(points[3 + by], points[(by + 2) % 3]) < one)
    return 0


@njit(cache=True)
def _keep(vertices: Ints, row: int, at: int, parent: Ints, barycentric: Floats, out: Ints) -> None:
    """A triangle as its own only part, number ``at``."""
    parent[at] = row
    for corner in range(3):
        barycentric[at, corner, corner] = 1
        out[at, corner, 0], out[at, corner, 1] = vertices[row, corner, 0], vertices[row, corner, 1]


@njit(cache=True)
def new_vertices(ends: Ints, share: Floats, marks: Bools) -> Ints:
    """
    (edges, 2) vertices that divide edges; a mark is taken away where one would be an end of its edge.

    They are found from the edges' ends alone: whoever shares an edge gets the same. ``share`` (edges,) says
    where an edge is split, from its first end; the middle where it is empty.
    """
    out = np.empty((len(ends), 2), np.int64)
    for edge in range(len(ends)):
        same_one = same_two = True
        for axis in range(2):
            one, two = ends[edge, 0, axis], ends[edge, 1, axis]
            if len(share) == 0:
                out[edge, axis] = (one + two) >> 1
            else:
                out[edge, axis] = one + np.int64(np.rint(share[edge] * (two - one)))
            same_one, same_two = same_one and out[edge, axis] == one, same_two and out[edge, axis] == two
        marks[edge] = marks[edge] and not same_one and not same_two
    return out


@njit(cache=True)
def sound_marks(
    vertices: Ints, index: Ints, marks: Bools, middle: Ints, children: Ints, counts: Ints
) -> None:
    """Take marks away, in place, until no part of a triangle is without area or turned over."""
    points, wrong = np.empty((6, 2), np.int64), np.zeros(len(vertices), np.bool_)
    again = True
    while again:
        again = False
        for row in range(len(vertices)):
            code = _code(marks, index[row])
            wrong[row] = False
            if code == 0:
                continue
            _six(vertices[row], middle, index[row], points)
            which, turn = _diagonal(points, code), _side(points[0], points[1], points[2])
            for child in range(counts[code, which]):
                part = children[code, which, child]
                wrong[row] |= _side(points[part[0]], points[part[1]], points[part[2]]) != turn
        for row in range(len(vertices)):
            if wrong[row]:
                again = True
                for edge in range(3):
                    marks[index[row, edge]] = False


@njit(cache=True)
def parts(
    vertices: Ints,
    index: Ints,
    turned: Bools,
    marks: Bools,
    middle: Ints,
    share: Floats,
    children: Ints,
    counts: Ints,
) -> tuple[Ints, Floats, Ints]:
    """
    Parts of triangles, in their order: parents (m,), corners (m, 3, 3) barycentric, vertices (m, 3, 2).

    ``share`` (edges,) is that of :func:`new_vertices`.
    """
    points, total = np.empty((6, 2), np.int64), 0
    for row in range(len(vertices)):
        total += counts[_code(marks, index[row]), 0]
    parent = np.empty(total, np.int64)
    barycentric, out = np.zeros((total, 3, 3)), np.empty((total, 3, 2), np.int64)
    at = 0
    for row in range(len(vertices)):
        code = _code(marks, index[row])
        if code == 0:
            _keep(vertices, row, at, parent, barycentric, out)
            at += 1
            continue
        _six(vertices[row], middle, index[row], points)
        which = _diagonal(points, code)
        for child in range(counts[code, which]):
            parent[at] = row
            for corner in range(3):
                point = children[code, which, child, corner]
                out[at, corner, 0], out[at, corner, 1] = points[point, 0], points[point, 1]
                if point < 3:
                    barycentric[at, corner, point] = 1
                else:
                    edge = point - 3
                    along = share[index[row, edge]] if len(share) else 0.5
                    along = 1 - along if turned[row, edge] else along
                    barycentric[at, corner, edge] = 1 - along
                    barycentric[at, corner, (edge + 1) % 3] = along
            at += 1
    return parent, barycentric, out


@njit(cache=True)
def parts_around(
    vertices: Ints, chosen: Ints, barycentric: Floats, inside: Ints
) -> tuple[Ints, Floats, Ints]:
    """
    As :func:`parts`: some triangles divided into three at points inside; the others whole.

    ``chosen`` (n,) is a row of ``barycentric`` (k, 3) and of ``inside`` (k, 2), or -1. Where a part would be
    without area or turned over the triangle stays whole.
    """
    good = np.zeros(len(vertices), np.bool_)
    for row in range(len(vertices)):
        if chosen[row] >= 0:
            one, two, three = vertices[row]
            point, turn = inside[chosen[row]], _side(one, two, three)
            good[row] = _side(point, two, three) == turn and _side(one, point, three) == turn
            good[row] &= _side(one, two, point) == turn
    total = len(vertices) + 2 * good.sum()
    parent = np.empty(total, np.int64)
    corners, out = np.zeros((total, 3, 3)), np.empty((total, 3, 2), np.int64)
    at = 0
    for row in range(len(vertices)):
        for part in range(3 if good[row] else 1):
            _keep(vertices, row, at, parent, corners, out)
            if good[row]:
                out[at, part], corners[at, part] = inside[chosen[row]], barycentric[chosen[row]]
            at += 1
    return parent, corners, out


@njit(cache=True, error_model="numpy")
def interpolated(
    parent: Ints, corners: Floats, weight: Floats, depth: Floats, carried: Floats
) -> tuple[Floats, Floats, Floats]:
    """
    Weights (m, 3), depths (m, 3) and what else is carried (kinds, m, 3, 3) at corners of parts.

    ``carried`` (kinds, n, 3, 3) is interpolated with perspective; a depth stays within its triangle's. The
    parts of a triangle follow each other; one that has no other part is the triangle.
    """
    count = len(parent)
    weights, depths = np.empty((count, 3)), np.empty((count, 3))
    out = np.empty((len(carried), count, 3, 3))
    share = np.empty(3)
    for part in range(count):
        row = parent[part]
        if (part == 0 or parent[part - 1] != row) and (part + 1 == count or parent[part + 1] != row):
            # A triangle that is whole.
            for corner in range(3):
                weights[part, corner], depths[part, corner] = weight[row, corner], depth[row, corner]
                for kind in range(len(carried)):
                    for axis in range(3):
                        out[kind, part, corner, axis] = carried[kind, row, corner, axis]
            continue
        low, high = depth[row].min(), depth[row].max()
        for corner in range(3):
            total = far = 0.0
            for one in range(3):
                share[one] = corners[part, corner, one] * weight[row, one]
                total += share[one]
                far += corners[part, corner, one] * depth[row, one]
            weights[part, corner] = total
            depths[part, corner] = min(max(far, low), high)
            share /= total
            for kind in range(len(carried)):
                for axis in range(3):
                    out[kind, part, corner, axis] = (
                        share[0] * carried[kind, row, 0, axis]
                        + share[1] * carried[kind, row, 1, axis]
                        + share[2] * carried[kind, row, 2, axis]
                    )
    return weights, depths, out
