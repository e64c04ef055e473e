# SPDX-License-Identifier: Apache-2.0
"""
Primitives cut to a rectangle of the picture, on the lattice: the same pixels with the same bits.

A primitive's words are a polynomial P(m, N) over whole steps m down and N along, modulo 2**word_width, and a
part of it has a lattice of its own: another first pixel, another step along its major edge, perhaps mirrored.
Either lattice has every pixel of the part, so the part's words are whole sums of the primitive's, and nothing
is rounded anew. The part's edges are the primitive's, further down, or the rectangle's border.

With ``fractional`` stepping N counts from the major edge's own carries, which the rectangle's border does not
have: such a primitive is cut into single scanlines, unless all of it is on the rectangle.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numba import njit

from quadshade.contract.arrays import Bools, Ints, Records
from quadshade.contract.formats import CONSTANT, LINEAR, Formats
from quadshade.setup.edges import MAX_PRIMITIVES, Cut, EdgeState, Head, empty_cut, join_sides
from quadshade.setup.packet import Primitives, cut_of, edges_of, header_of
from quadshade.setup.sides import Extent, Line, Sides, empty_sides, line_column, push_edge


class Rectangle(NamedTuple):
    """A part of a picture, in pixels."""

    left: int
    top: int
    width: int
    height: int

    @property
    def right(self) -> int:
        """Column behind the last one."""
        return self.left + self.width

    @property
    def bottom(self) -> int:
        """Scanline behind the last one."""
        return self.top + self.height


@njit(cache=True)
def _line(edge: EdgeState, since: int, mirror: int) -> Line:
    """An edge in x from its first scanline on. Mirrored: -floor(m / dy) = floor((dy - 1 - m) / dy)."""
    m = edge.column * edge.height + edge.remainder
    dx = edge.step * edge.height + edge.increment
    if mirror:
        return Line(edge.height - 1 - m, -dx, edge.height, since)
    return Line(m, dx, edge.height, since)


@njit(cache=True)
def _push(runs: Records, count: int, line: Line, end: int, height: int, width: int) -> int:
    """Append to a side the scanlines of a line that are on the rectangle, before ``end``."""
    m, dx, dy, since = line
    start = max(since, 0)
    moved = Line(m + (start - since) * dx, dx, dy, start)
    return push_edge(runs, count, min(end, height), moved, 0, 0, width)


@njit(cache=True)
def _moved(line: Line, left: int) -> Line:
    """A line, its columns counted from another one."""
    return Line(line.m - left * line.dy, line.dx, line.dy, line.y)


@njit(cache=True)
def _part(head: Head, edges: Records, where: Rectangle, sides: Sides, out: Cut, count: int) -> int:
    """Append the parts of one primitive that are on a rectangle, in the rectangle's coordinates."""
    mirror, y = head.mirror, head.y - where.top
    knee, end = y + head.rows_first, y + head.rows_first + head.rows_second
    first, last = max(y, 0), min(end, where.height)
    if first >= last:
        return count
    major = _moved(_line(edges[0], y, mirror), where.left)
    minor = _moved(_line(edges[1], y, mirror), where.left)
    long, broken = (sides.right, sides.left) if mirror else (sides.left, sides.right)
    longs = _push(long, 0, major, end, where.height, where.width)
    brokens = _push(broken, 0, minor, knee, where.height, where.width)
    if end > knee:
        second = _moved(_line(edges[2], knee, mirror), where.left)
        brokens = _push(broken, brokens, second, end, where.height, where.width)
    extent = Extent(first, last, brokens, longs) if mirror else Extent(first, last, longs, brokens)
    return join_sides(head.triangle, sides, extent, where.width, out, count)


@njit(cache=True)
def _scanlines(head: Head, edges: Records, where: Rectangle, out: Cut, count: int) -> int:
    """Append the scanlines of one primitive that are on a rectangle, each by itself."""
    low, high = where.left, where.left + where.width
    if head.mirror:
        low, high = -high, -low
    for row in range(head.rows_first + head.rows_second):
        y = head.y + row - where.top
        first = row < head.rows_first
        minor = edges[1] if first else edges[2]
        start = max(line_column(_line(edges[0], 0, 0), row), low)
        end = min(line_column(_line(minor, 0, 0), row if first else row - head.rows_first), high)
        if start >= end or not 0 <= y < where.height:
            continue
        part = out.heads[count]
        part.triangle, part.y, part.mirror = head.triangle, y, head.mirror
        part.rows_first, part.rows_second = 1, 0
        shift = where.left if head.mirror else -where.left
        for edge, column in ((0, start), (1, end)):
            state = out.edges[count, edge]
            state.column, state.height = column + shift, 1
        count += 1
    return count


@njit(cache=True)
def _whole(head: Head, edges: Records, where: Rectangle, out: Cut, count: int) -> int:
    """Append a primitive as it is, in a rectangle's coordinates."""
    part, shift = out.heads[count], where.left if head.mirror else -where.left
    part.triangle, part.y, part.mirror = head.triangle, head.y - where.top, head.mirror
    part.rows_first, part.rows_second = head.rows_first, head.rows_second
    out.edges[count] = edges
    for edge in range(3 if head.rows_second else 2):
        out.edges[count, edge].column += shift
    return count + 1


@njit(cache=True)
def _value(words: Ints, m: int, n: int) -> int:
    """The polynomial of a channel's six words on its lattice; int64 wraps, so it is right modulo 2**60."""
    triangular = m * (m - 1) // 2 * words[3] + n * (n + 1) // 2 * words[5]
    value: int = words[0] + m * words[1] + n * words[2] + m * n * words[4] + triangular
    return value


@njit(cache=True)
def _steps(head: Head, edges: Records) -> tuple[int, int]:
    """Greatest m and N of a primitive's pixels."""
    rows = head.rows_first + head.rows_second
    along = 0
    for edge, since, end in ((1, 0, head.rows_first), (2, head.rows_first, rows)):
        if end > since:
            line = _line(edges[edge], since, 0)
            # A floor of what is linear is greatest at an end.
            for row in (since, end - 1):
                lattice = edges[0].column + row * edges[0].step
                along = max(along, line_column(line, row) - 1 - lattice)
    return rows - 1, along


@njit(cache=True)
def _restep(
    whole: Cut, parts: Cut, where: Rectangle, fractional: Bools, words: Ints, orders: Ints, half: int
) -> tuple[Ints, Ints]:
    """Words and orders of parts (``head.triangle`` is the primitive that each is of)."""
    out = np.zeros((len(parts.heads), words.shape[1], 6), np.int64)
    levels = np.zeros((len(parts.heads), words.shape[1]), np.int64)
    for p in range(len(parts.heads)):
        head, edges = parts.heads[p], parts.edges[p]
        q = head.triangle
        old, major = whole.heads[q], whole.edges[q, 0]
        rows, columns = _steps(head, edges)
        m = head.y + where.top - old.y
        # u of the primitive is sign * u of the part + shift.
        sign = 1 if head.mirror == old.mirror else -1
        shift = -where.left if old.mirror else where.left
        if sign < 0:
            shift -= 1
        start = sign * edges[0].column + shift
        along = sign * edges[0].step - major.step
        n = start - major.column - m * major.step
        if fractional[q]:
            n = start - line_column(_line(major, 0, 0), m)
        for channel in range(words.shape[1]):
            given, made = words[q, channel], out[p, channel]
            here, back = _value(given, m, n), _value(given, m, n - sign)
            made[0] = here
            if columns > 0:
                made[2] = here - back
                made[5] = here - 2 * back + _value(given, m, n - 2 * sign)
            if rows > 0:
                below = _value(given, m + 1, n + along)
                made[1] = below - here
                if columns > 0:
                    made[4] = below - _value(given, m + 1, n + along - sign) - here + back
                if rows > 1:
                    made[3] = _value(given, m + 2, n + 2 * along) - 2 * below + here
            levels[p, channel] = CONSTANT
            for difference in range(6):
                made[difference] = ((made[difference] + half) & (2 * half - 1)) - half
                if made[difference] != 0 and difference > 0:
                    level = LINEAR if difference < 3 else orders[q, channel]
                    levels[p, channel] = max(levels[p, channel], level)
    return out, levels


@njit(cache=True)
def _cut(
    whole: Cut, chosen: Ints, inside: Bools, where: Rectangle, fractional: Bools, sides: Sides, out: Cut
) -> int:
    """Cut chosen primitives to a rectangle, ``inside`` those that are all on it; how many parts there are."""
    count = 0
    for k in range(len(chosen)):
        head, edges = whole.heads[chosen[k]], whole.edges[chosen[k]]
        if inside[k]:
            count = _whole(head, edges, where, out, count)
        elif fractional[chosen[k]]:
            count = _scanlines(head, edges, where, out, count)
        else:
            count = _part(head, edges, where, sides, out, count)
    return count


@njit(cache=True)
def _extents(whole: Cut) -> Ints:
    """(n, 4) first column and scanline of every primitive's pixels, and those behind the last ones."""
    out = np.zeros((len(whole.heads), 4), np.int64)
    for p in range(len(whole.heads)):
        head, edges = whole.heads[p], whole.edges[p]
        knee, end = head.rows_first, head.rows_first + head.rows_second
        low = high = edges[0].column
        for edge, since, until in ((0, 0, end), (1, 0, knee), (2, knee, end)):
            if until > since:
                line = _line(edges[edge], since, 0)
                for row in (since, until - 1):
                    column = line_column(line, row)
                    low, high = min(low, column), max(high, column)
        if head.mirror:
            low, high = -high, -low
        out[p, 0], out[p, 1], out[p, 2], out[p, 3] = low, head.y, high, head.y + end
    return out


class Cuttable:
    """
    The primitives of a whole picture, to be cut to rectangles of it.

    Parameters
    ----------
    primitives : Primitives
      From :func:`quadshade.setup.triangle_setup.setup_triangles` for the whole picture.
    formats : Formats
      They were set up for.

    Attributes
    ----------
    extents : (n, 4) int64
      Left, top, right and bottom of every primitive's pixels, the last two not included.
    """

    def __init__(self, primitives: Primitives, formats: Formats) -> None:
        self.primitives, self.formats = primitives, formats
        self._cut, self._sides = cut_of(primitives), empty_sides()
        self._fractional = primitives.header["fractional"] != 0
        self._words = np.ascontiguousarray(primitives.words, np.int64)
        self._orders = np.ascontiguousarray(primitives.orders, np.int64)
        self.extents = _extents(self._cut)

    def touching(self, where: Rectangle) -> np.ndarray:
        """(k,) int64: primitives that may have a pixel on a rectangle, in order."""
        left, top, right, bottom = self.extents.T
        beside = (left >= where.right) | (right <= where.left)
        return np.flatnonzero(~beside & (top < where.bottom) & (bottom > where.top))

    def bounds(self, where: Rectangle) -> Rectangle | None:
        """The part of a rectangle that may have pixels; None if there is none."""
        near = self.extents[self.touching(where)]
        if not len(near):
            return None
        left, top = max(int(near[:, 0].min()), where.left), max(int(near[:, 1].min()), where.top)
        right, bottom = min(int(near[:, 2].max()), where.right), min(int(near[:, 3].max()), where.bottom)
        return Rectangle(left, top, right - left, bottom - top)

    def to(self, where: Rectangle) -> Primitives:
        """
        The primitives on a rectangle, in order, in the rectangle's coordinates.

        Parameters
        ----------
        where : Rectangle

        Returns
        -------
        Primitives
          They draw every pixel of the whole that is on the rectangle, once, with the same value and depth. A
          channel's order is lower where its part needs no more.
        """
        chosen, whole = self.touching(where), self.primitives
        left, top, right, bottom = self.extents[chosen].T
        inside = (left >= where.left) & (right <= where.right) & (top >= where.top) & (bottom <= where.bottom)
        most = np.where(self._fractional[chosen], bottom - top, MAX_PRIMITIVES)
        parts = empty_cut(int(most.sum()) + MAX_PRIMITIVES)
        count = _cut(self._cut, chosen, inside, where, self._fractional, self._sides, parts)
        parts = Cut(parts.heads[:count], parts.edges[:count])
        half = 1 << (self.formats.word_width - 1)
        words, orders = _restep(self._cut, parts, where, self._fractional, self._words, self._orders, half)
        owner = parts.heads["triangle"]
        return replace(
            whole,
            triangle=whole.triangle[owner],
            header=header_of(parts, whole.header["fractional"][owner]),
            edges=edges_of(parts),
            orders=orders,
            words=words,
            bound=whole.bound[owner],
            undefined=whole.undefined[owner],
        )
