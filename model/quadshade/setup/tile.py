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


class Rows(NamedTuple):
    """Which scanlines are drawn: every ``stride``-th one from ``first`` on, as a picture of their own."""

    stride: int
    first: int


EVERY_ROW = Rows(1, 0)


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
def _place(y: int, rows: Rows, top: int) -> int:
    """The first scanline of a rectangle that is drawn and not above a scanline of the picture."""
    return -((rows.first - y) // rows.stride) - top


@njit(cache=True)
def _push(runs: Records, count: int, line: Line, end: int, rows: Rows, where: Rectangle) -> int:
    """Append to a side the scanlines of a line, before ``end`` of the picture, that are on the rectangle."""
    m, dx, dy, since = line
    start = max(_place(since, rows, where.top), 0)
    behind = (start + where.top) * rows.stride + rows.first - since
    moved = Line(m + behind * dx - where.left * dy, dx * rows.stride, dy, start)
    last = min(_place(end, rows, where.top), where.height)
    return push_edge(runs, count, last, moved, 0, 0, where.width)


@njit(cache=True)
def _part(
    head: Head, edges: Records, where: Rectangle, rows: Rows, sides: Sides, out: Cut, count: int
) -> int:
    """Append the parts of one primitive that are on a rectangle, in the rectangle's coordinates."""
    mirror, y = head.mirror, head.y
    knee, end = y + head.rows_first, y + head.rows_first + head.rows_second
    first, last = max(_place(y, rows, where.top), 0), min(_place(end, rows, where.top), where.height)
    if first >= last:
        return count
    long, broken = (sides.right, sides.left) if mirror else (sides.left, sides.right)
    longs = _push(long, 0, _line(edges[0], y, mirror), end, rows, where)
    brokens = _push(broken, 0, _line(edges[1], y, mirror), knee, rows, where)
    if end > knee:
        brokens = _push(broken, brokens, _line(edges[2], knee, mirror), end, rows, where)
    extent = Extent(first, last, brokens, longs) if mirror else Extent(first, last, longs, brokens)
    return join_sides(head.triangle, sides, extent, where.width, out, count)


@njit(cache=True)
def _scanlines(head: Head, edges: Records, where: Rectangle, rows: Rows, out: Cut, count: int) -> int:
    """Append the scanlines of one primitive that are on a rectangle, each by itself."""
    low, high = where.left, where.left + where.width
    if head.mirror:
        low, high = -high, -low
    for row in range(head.rows_first + head.rows_second):
        y = _place(head.y + row, rows, where.top)
        is_drawn = (head.y + row - rows.first) % rows.stride == 0 and 0 <= y < where.height
        first = row < head.rows_first
        minor = edges[1] if first else edges[2]
        start = max(line_column(_line(edges[0], 0, 0), row), low)
        end = min(line_column(_line(minor, 0, 0), row if first else row - head.rows_first), high)
        if start >= end or not is_drawn:
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
    whole: Cut,
    parts: Cut,
    where: Rectangle,
    drawn: Rows,
    fractional: Bools,
    words: Ints,
    orders: Ints,
    half: int,
) -> tuple[Ints, Ints]:
    """Words and orders of parts (``head.triangle`` is the primitive that each is of)."""
    out = np.zeros((len(parts.heads), words.shape[1], 6), np.int64)
    levels = np.zeros((len(parts.heads), words.shape[1]), np.int64)
    for p in range(len(parts.heads)):
        head, edges = parts.heads[p], parts.edges[p]
        q = head.triangle
        old, major = whole.heads[q], whole.edges[q, 0]
        rows, columns = _steps(head, edges)
        m, down = (head.y + where.top) * drawn.stride + drawn.first - old.y, drawn.stride
        # u of the primitive is sign * u of the part + shift.
        sign = 1 if head.mirror == old.mirror else -1
        shift = -where.left if old.mirror else where.left
        if sign < 0:
            shift -= 1
        start = sign * edges[0].column + shift
        along = sign * edges[0].step - down * major.step
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
                below = _value(given, m + down, n + along)
                made[1] = below - here
                if columns > 0:
                    made[4] = below - _value(given, m + down, n + along - sign) - here + back
                if rows > 1:
                    made[3] = _value(given, m + 2 * down, n + 2 * along) - 2 * below + here
            levels[p, channel] = CONSTANT
            for difference in range(6):
                made[difference] = ((made[difference] + half) & (2 * half - 1)) - half
                if made[difference] != 0 and difference > 0:
                    level = LINEAR if difference < 3 else orders[q, channel]
                    levels[p, channel] = max(levels[p, channel], level)
    return out, levels


@njit(cache=True)
def _cut(
    whole: Cut,
    chosen: Ints,
    inside: Bools,
    where: Rectangle,
    rows: Rows,
    fractional: Bools,
    sides: Sides,
    out: Cut,
) -> int:
    """Cut chosen primitives to a rectangle, ``inside`` those that are all on it; how many parts there are."""
    count = 0
    for k in range(len(chosen)):
        head, edges = whole.heads[chosen[k]], whole.edges[chosen[k]]
        if inside[k]:
            count = _whole(head, edges, where, out, count)
        elif fractional[chosen[k]]:
            count = _scanlines(head, edges, where, rows, out, count)
        else:
            count = _part(head, edges, where, rows, sides, out, count)
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
        chosen = self.touching(where)
        left, top, right, bottom = self.extents[chosen].T
        inside = (left >= where.left) & (right <= where.right) & (top >= where.top) & (bottom <= where.bottom)
        return self._cut_out(chosen, inside, where, EVERY_ROW)

    def interleaved(self, cores: int, core: int, width: int, height: int) -> Primitives:
        """
        The scanlines of one of several cores that draw every ``cores``-th one, as rows 0, 1, 2 of its own.

        Parameters
        ----------
        cores : int
        core : int
          From 0: it draws scanlines core, core + cores and so on.
        width, height : int
          Of the whole picture.

        Returns
        -------
        Primitives
          As of :meth:`to`.
        """
        rows = Rows(cores, core)
        where = Rectangle(0, 0, width, max(-((core - height) // cores), 0))
        everything = np.arange(len(self.primitives))
        return self._cut_out(everything, np.full(len(everything), cores == 1), where, rows)

    def _cut_out(self, chosen: Ints, inside: Bools, where: Rectangle, rows: Rows) -> Primitives:
        """Chosen primitives on a rectangle of scanlines that are drawn; ``inside`` those that are whole."""
        whole = self.primitives
        most = np.where(self._fractional[chosen], self.extents[chosen, 3], 0) - self.extents[chosen, 1]
        parts = empty_cut(int(np.maximum(most, MAX_PRIMITIVES).sum()) + MAX_PRIMITIVES)
        count = _cut(self._cut, chosen, inside, where, rows, self._fractional, self._sides, parts)
        parts = Cut(parts.heads[:count], parts.edges[:count])
        half = 1 << (self.formats.word_width - 1)
        words, orders = _restep(
            self._cut, parts, where, rows, self._fractional, self._words, self._orders, half
        )
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
