# SPDX-License-Identifier: Apache-2.0
"""
The two sides of a triangle on the screen, as runs of scanlines along an edge or along the screen's border.

:mod:`quadshade.setup.edges` has the arithmetic and why it is exact.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from quadshade.contract.arrays import Ints, Records, record_dtype


class Line(NamedTuple):
    """An edge from scanline ``y`` on: ``m`` there, and its extent."""

    m: int
    dx: int
    dy: int
    y: int


class Run:
    """
    Columns of a part of a side: the scanlines from ``start`` to before ``end``, along one edge.

    ``m`` is that at ``start``; ``top`` and ``bottom`` are the edge's two vertices (-1: the border).
    """

    start: int
    end: int
    m: int
    dx: int
    dy: int
    top: int
    bottom: int


class Window(NamedTuple):
    """The part of the screen that is cut to: its size in pixels, the sub-pixel bits of the vertices."""

    width: int
    height: int
    bits: int


class Extent(NamedTuple):
    """
    What of a triangle's sides counts: scanlines from ``first`` to before ``end``, none where these do not
    follow each other, and the runs of each side.
    """

    first: int
    end: int
    left_count: int
    right_count: int


class Sides(NamedTuple):
    """Room for the runs of both sides of a triangle, records of :class:`Run`."""

    left: Records
    right: Records


RUN = record_dtype(Run)

MAX_RUNS = 6
"""A side is at most two edges, each at most border, edge, border."""


def empty_sides() -> Sides:
    """Room for the sides of one triangle."""
    return Sides(np.zeros(MAX_RUNS, RUN), np.zeros(MAX_RUNS, RUN))


@njit(cache=True)
def first_scanline(y: int, bits: int) -> int:
    """First scanline whose centre is at or below y: ceil(y / S - 1/2), S = 2**bits."""
    return -(((1 << bits) - 2 * y) >> (bits + 1))


@njit(cache=True)
def line_of(corners: Ints, top: int, bottom: int, y: int, bits: int) -> Line:
    """The edge between two vertices from scanline y on."""
    xa, ya = corners[top, 0], corners[top, 1]
    dx, dy = corners[bottom, 0] - xa, corners[bottom, 1] - ya
    # Relative to the edge's own top vertex, everything fits; the shift floors.
    down = ((2 * y + 1) << bits) - 2 * ya
    return Line((2 * xa * dy + down * dx + (dy << bits) - 1) >> (bits + 1), dx, dy, y)


@njit(cache=True)
def line_column(line: Line, y: int) -> int:
    """Column of a line from :func:`line_of` at scanline y."""
    m, dx, dy, since = line
    return (m + (y - since) * dx) // dy


@njit(cache=True)
def _clamp(value: int, low: int, high: int) -> int:
    return min(max(value, low), high)


@njit(cache=True)
def _push(runs: Records, count: int, end: int, line: Line, top: int, bottom: int) -> int:
    """Append the run of a line up to ``end``; an empty one is dropped, a border that goes on is extended."""
    if line.y >= end:
        return count
    if count and top < 0:
        last = runs[count - 1]
        if last.top < 0 and last.m == line.m:
            last.end = end
            return count
    run = runs[count]
    run.start, run.end, run.m, run.dx, run.dy = line.y, end, line.m, line.dx, line.dy
    run.top, run.bottom = top, bottom
    return count + 1


@njit(cache=True)
def push_edge(runs: Records, count: int, end: int, line: Line, top: int, bottom: int, width: int) -> int:
    """Append a line up to ``end``, replaced by the border where its column leaves 0 .. width."""
    m, dx, dy, start = line
    if start >= end:
        return count
    limit = (width + 1) * dy
    rows = end - start
    before, after = 0, width
    if dx > 0:
        enter = _clamp(-(m // dx), 0, rows)
        leave = _clamp(-((m - limit) // dx), 0, rows)
    elif dx < 0:
        before, after = width, 0
        enter = _clamp((m - limit) // -dx + 1, 0, rows)
        leave = _clamp(m // -dx + 1, 0, rows)
    else:
        enter = rows if m < 0 else 0
        leave = 0 if m >= limit else rows
    count = _push(runs, count, start + enter, Line(before, 0, 1, start), -1, -1)
    within = Line(m + enter * dx, dx, dy, start + enter)
    count = _push(runs, count, start + leave, within, top, bottom)
    return _push(runs, count, end, Line(after, 0, 1, start + max(leave, enter)), -1, -1)


@njit(cache=True)
def run_line(run: Run) -> Line:
    return Line(run.m, run.dx, run.dy, run.start)


@njit(cache=True)
def _column(run: Run, y: int) -> int:
    return line_column(run_line(run), y)


@njit(cache=True)
def run_at(runs: Records, y: int) -> int:
    index = 0
    while runs[index].end <= y:
        index += 1
    return index


@njit(cache=True)
def next_covered(sides: Sides, y: int, end: int, width: int) -> int:
    """First scanline from y on that has a pixel, or end."""
    while y < end:
        a, b = sides.left[run_at(sides.left, y)], sides.right[run_at(sides.right, y)]
        if _column(a, y) < _column(b, y):
            return y
        # Whole runs beyond the border are skipped, so that a tall triangle beside the screen costs nothing.
        if a.top < 0 and a.m == width:
            y = a.end
        elif b.top < 0 and b.m == 0:
            y = b.end
        else:
            y += 1
    return end


@njit(cache=True)
def last_covered(sides: Sides, first: int, y: int, width: int) -> int:
    """Last scanline from y upwards that has a pixel, or first - 1."""
    while y >= first:
        a, b = sides.left[run_at(sides.left, y)], sides.right[run_at(sides.right, y)]
        if _column(a, y) < _column(b, y):
            return y
        if a.top < 0 and a.m == width:
            y = a.start - 1
        elif b.top < 0 and b.m == 0:
            y = b.start - 1
        else:
            y -= 1
    return first - 1


@njit(cache=True)
def sorted_corners(corners: Ints) -> tuple[int, int, int, int]:
    """Indices of the top, middle and bottom vertex; where the middle one is: > 0 right of the long edge."""
    top, middle, bottom = 0, 1, 2
    if corners[top, 1] > corners[middle, 1]:
        top, middle = middle, top
    if corners[middle, 1] > corners[bottom, 1]:
        middle, bottom = bottom, middle
    if corners[top, 1] > corners[middle, 1]:
        top, middle = middle, top
    area = (corners[middle, 0] - corners[top, 0]) * (corners[bottom, 1] - corners[top, 1]) - (
        corners[bottom, 0] - corners[top, 0]
    ) * (corners[middle, 1] - corners[top, 1])
    return top, middle, bottom, area


@njit(cache=True)
def cut_sides(corners: Ints, window: Window, sides: Sides) -> Extent:
    """Write both sides of a triangle on the screen."""
    width, height, bits = window
    top, middle, bottom, area = sorted_corners(corners)
    first = max(first_scanline(corners[top, 1], bits), 0)
    end = min(first_scanline(corners[bottom, 1], bits), height)
    if first >= end or area == 0:
        return Extent(0, 0, 0, 0)
    knee = _clamp(first_scanline(corners[middle, 1], bits), first, end)
    long, broken = (sides.left, sides.right) if area > 0 else (sides.right, sides.left)
    broken_count = 0
    long_count = push_edge(long, 0, end, line_of(corners, top, bottom, first, bits), top, bottom, width)
    if first < knee:
        upper = line_of(corners, top, middle, first, bits)
        broken_count = push_edge(broken, 0, knee, upper, top, middle, width)
    if knee < end:
        lower = line_of(corners, middle, bottom, knee, bits)
        broken_count = push_edge(broken, broken_count, end, lower, middle, bottom, width)
    if area > 0:
        return Extent(first, end, long_count, broken_count)
    return Extent(first, end, broken_count, long_count)
