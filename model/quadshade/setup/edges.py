# SPDX-License-Identifier: Apache-2.0
"""
Exact edges: triangles cut at the screen's border into primitives of whole scanlines, a DDA for each side.

An edge from its own top vertex (xa, ya) to (xb, yb), in sub-pixels, S to a pixel, dx = xb - xa, dy = yb - ya,
meets scanline y at the column ``ceil(x(y + 1/2) - 1/2) = floor(m / dy)`` with

    m = floor((2 xa dy + (S (2y + 1) - 2 ya) dx + S dy - 1) / 2S),    one scanline down: m += dx.

The low bits dropped by the division by 2S never change, so the DDA is exact for every edge. Pixels
left <= x < right are covered: the top-left rule, and an edge shared by two triangles has the same columns in
both.

Widths: a vertex lies in [-2**25, 2**26) at most (13 + 12 bits, three screens), so dx, dy < 2**26.6, every
product above is below 2**54.3 and their sum below 2**55.5: int64 holds all of it, with seven bits to spare.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from quadshade.contract.arrays import Ints, Records, record_dtype
from quadshade.setup.sides import (
    MAX_RUNS,
    Extent,
    Line,
    Sides,
    Window,
    cut_sides,
    empty_sides,
    first_scanline,
    last_covered,
    line_column,
    line_of,
    next_covered,
    run_at,
    run_line,
    sorted_corners,
)


class Head:
    """
    Columns of a primitive's head.

    ``y`` is the first scanline, ``major_top`` and ``major_bottom`` are the two vertices of the triangle's
    edge that is the major edge (-1: it is the border of the screen), ``mirror`` is 0 or 1.
    """

    triangle: int
    y: int
    rows_first: int
    rows_second: int
    mirror: int
    major_top: int
    major_bottom: int


class EdgeState:
    """Columns of an edge at its first scanline: floor(m / dy), m mod dy, dx div dy, dx mod dy, dy."""

    column: int
    remainder: int
    step: int
    increment: int
    height: int


HEAD, EDGE_STATE = record_dtype(Head), record_dtype(EdgeState)

MAX_PRIMITIVES = 2 * MAX_RUNS
"""Each primitive but the last uses up at least one run of a side."""


class Cut(NamedTuple):
    """
    Primitives before colour: what covers which pixels.

    Attributes
    ----------
    heads : (n,) records of :class:`Head`
    edges : (n, 3) records of :class:`EdgeState`
      Major, minor, second edge (zeros where there is none), in u (mirrored: u = -1 - x).
    """

    heads: Records
    edges: Records


def empty_cut(size: int) -> Cut:
    """Room for primitives."""
    return Cut(np.zeros(size, HEAD), np.zeros((size, 3), EDGE_STATE))


@njit(cache=True)
def _between(long: Line, broken: Line, area: int, y: int) -> bool:
    """Whether scanline y has a pixel between a triangle's long edge and one of the other two."""
    if area > 0:
        return line_column(long, y) < line_column(broken, y)
    return line_column(broken, y) < line_column(long, y)


@njit(cache=True)
def _set_state(state: EdgeState, line: Line, y: int, rows: int, mirror: bool) -> None:
    """The DDA of a line from scanline y on, in u. Mirrored: -floor(m / dy) = floor((dy - 1 - m) / dy)."""
    m, dx, dy, since = line
    m += (y - since) * dx
    if mirror:
        m, dx = dy - 1 - m, -dx
    column = m // dy
    if dx == 0 or rows == 1:
        state.column, state.remainder, state.step, state.increment, state.height = column, 0, 0, 0, 1
        return
    step = dx // dy
    state.column, state.remainder = column, m - column * dy
    state.step, state.increment, state.height = step, dx - step * dy, dy


@njit(cache=True)
def _inside(corners: Ints, right: int, bottom: int) -> bool:
    """Whether a triangle lies on the screen, its border included."""
    for corner in range(3):
        if not (0 <= corners[corner, 0] <= right and 0 <= corners[corner, 1] <= bottom):
            return False
    return True


@njit(cache=True)
def _cut_inside(triangle: int, corners: Ints, bits: int, out: Cut, count: int) -> int:
    """
    Append the one primitive of a triangle that lies on the screen, if it has a pixel.

    The same as :func:`cut_one`, where no side meets the border: the long edge is the major one if the other
    side's knee lies between its scanlines, else the left one.
    """
    top, middle, bottom, area = sorted_corners(corners)
    y, end = first_scanline(corners[top, 1], bits), first_scanline(corners[bottom, 1], bits)
    if y >= end or area == 0:
        return count
    knee = first_scanline(corners[middle, 1], bits)
    long = line_of(corners, top, bottom, y, bits)
    upper = line_of(corners, top, middle, y, bits) if y < knee else long
    lower = line_of(corners, middle, bottom, knee, bits) if knee < end else long
    while y < end and not _between(long, upper if y < knee else lower, area, y):
        y += 1
    if y >= end:
        return count
    while not _between(long, upper if end <= knee else lower, area, end - 1):
        end -= 1
    split = y < knee < end
    mirror = split and area < 0
    minor = upper if y < knee else lower
    major_top, major_bottom = top, bottom
    if split or area > 0:
        major = long
    else:
        major, minor = minor, long
        major_top, major_bottom = (top, middle) if y < knee else (middle, bottom)
    rows_first = knee - y if split else end - y
    head = out.heads[count]
    head.triangle, head.y, head.mirror = triangle, y, mirror
    head.rows_first, head.rows_second = rows_first, end - y - rows_first
    head.major_top, head.major_bottom = major_top, major_bottom
    _set_state(out.edges[count, 0], major, y, end - y, mirror)
    _set_state(out.edges[count, 1], minor, y, rows_first, mirror)
    if split:
        _set_state(out.edges[count, 2], lower, knee, end - knee, mirror)
    return count + 1


@njit(cache=True)
def cut_one(triangle: int, corners: Ints, window: Window, sides: Sides, out: Cut, count: int) -> int:
    """Append the primitives of one triangle; the longest possible one first, which gives the least number."""
    return join_sides(triangle, sides, cut_sides(corners, window, sides), window.width, out, count)


@njit(cache=True)
def join_sides(triangle: int, sides: Sides, extent: Extent, width: int, out: Cut, count: int) -> int:
    """Append the primitives between two sides; ``extent`` says of which scanlines and runs."""
    left, right = sides
    first, end, left_count, right_count = extent
    y = next_covered(sides, first, end, width)
    if y >= end:
        return count
    end = last_covered(sides, y, end - 1, width) + 1
    while y < end:
        i, j = run_at(left, y), run_at(right, y)
        left_end, right_end = left[i].end, right[j].end
        left_next = left[i + 1].end if i + 1 < left_count else left_end
        right_next = right[j + 1].end if j + 1 < right_count else right_end
        left_reach = min(left_end, right_next, end)
        right_reach = min(right_end, left_next, end)
        mirror = right_reach > left_reach
        reach = max(left_reach, right_reach)
        stop = last_covered(sides, y, reach - 1, width) + 1
        major, minor, k = (right[j], left, i) if mirror else (left[i], right, j)
        rows_first = min(minor[k].end, stop) - y
        head = out.heads[count]
        head.triangle, head.y, head.mirror = triangle, y, mirror
        head.rows_first, head.rows_second = rows_first, stop - y - rows_first
        head.major_top, head.major_bottom = major.top, major.bottom
        edges = out.edges[count]
        _set_state(edges[0], run_line(major), y, stop - y, mirror)
        _set_state(edges[1], run_line(minor[k]), y, rows_first, mirror)
        if stop - y > rows_first:
            _set_state(edges[2], run_line(minor[k + 1]), y + rows_first, stop - y - rows_first, mirror)
        count += 1
        y = next_covered(sides, reach, end, width)
    return count


@njit(cache=True)
def _cut(vertices: Ints, start: int, window: Window, sides: Sides, out: Cut) -> tuple[int, int]:
    """Cut triangles from ``start`` on until ``out`` is full; the next triangle, the primitives written."""
    width, height, bits = window
    count = 0
    for triangle in range(start, len(vertices)):
        if count + MAX_PRIMITIVES > len(out.heads):
            return triangle, count
        corners = vertices[triangle]
        if _inside(corners, width << bits, height << bits):
            count = _cut_inside(triangle, corners, bits, out, count)
        else:
            count = cut_one(triangle, corners, window, sides, out, count)
    return len(vertices), count


def cut_triangles(vertices: np.ndarray, width: int, height: int, subpixel_bits: int) -> Cut:
    """
    Cut triangles into primitives that lie on the screen, and set up their edges.

    Rows above and below the screen are left out; where a side lies beyond the left or right border, the
    border takes its place. A primitive is one run of its major side and at most two of its minor side, and
    the major side is chosen for the fewest primitives. Its first and last scanlines hold pixels; there are no
    primitives without pixels.

    Parameters
    ----------
    vertices : (n, 3, 2) int64
      x and y in sub-pixels, inside ``Formats.guard_band``.
    width, height : int
      Screen size in pixels.
    subpixel_bits : int

    Returns
    -------
    Cut
      In triangle order, top to bottom within a triangle.
    """
    vertices = np.ascontiguousarray(vertices, dtype=np.int64)
    window, sides = Window(width, height, subpixel_bits), empty_sides()
    parts: list[Cut] = []
    start = 0
    while start < len(vertices) or not parts:
        room = empty_cut((len(vertices) - start) * 5 // 4 + MAX_PRIMITIVES)
        start, count = _cut(vertices, start, window, sides, room)
        parts.append(Cut(room.heads[:count], room.edges[:count]))
    if len(parts) == 1:
        return parts[0]
    return Cut(*(np.concatenate(column) for column in zip(*parts, strict=True)))
