# SPDX-License-Identifier: Apache-2.0
"""
What a board with ``vertex_unpacker`` makes of triangles' corners and middles, without running its program.

The same whole numbers as those of ``contract/vertex_text.py``, bit for bit, in a tenth of the time: a packer
has to know what each triangle becomes before it sends it. Sums and products wrap at 64 bits where the
board's do at 50, so what they give is cut to 50 bits before it is shifted right or divided.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from quadshade.contract.arrays import Bools, Int, Ints
from quadshade.contract.formats import Formats
from quadshade.contract.vertex_program import RATIO_FRAC, SAMPLE_FRAC, WIDTH
from quadshade.golden.link.vertex_alu import cut, div, mulf
from quadshade.packing.vertices import Points

HEADER = ("y", "rows_first", "rows_second", "has_second", "mirror")
EDGES = ("major", "minor", "second")
EDGE = ("column", "error", "step", "increment", "decrement")
"""Columns of a cover: the header's, then those of each edge."""

COVER_WIDTH = len(HEADER) + len(EDGES) * len(EDGE)


class Board(NamedTuple):
    """Widths of the board, and what parameters say: fraction bits of samples, and what rounds."""

    subpixel_bits: int
    column_bits: int
    word_low: int
    word_width: int
    num_channels: int
    with_depth: int
    shift_colour: int
    shift_depth: int
    half_depth: int


def board_of(formats: Formats, shift_colour: int, shift_depth: int) -> Board:
    """The board with formats and the last two parameters."""
    depth_low = RATIO_FRAC + SAMPLE_FRAC - formats.frac_bits + formats.depth_frac_bits * formats.with_depth
    return Board(
        formats.subpixel_bits,
        formats.column_bits,
        RATIO_FRAC + SAMPLE_FRAC - formats.frac_bits,
        formats.word_width,
        formats.num_channels,
        formats.with_depth,
        shift_colour,
        shift_depth,
        (1 << shift_depth << depth_low) >> 1,
    )


@njit(cache=True)
def _cut(value: Int) -> Int:
    return cut(value, WIDTH)


@njit(cache=True)
def _edge(
    board: Board, xa: Int, ya: Int, dx: Int, dy: Int, row: Int, rows: Int, mirror: int, out: Ints
) -> None:
    """An edge's fields from its upper corner, its extent, and the rows from ``row`` on; ``out`` (5,)."""
    subpixel, column_bits = board.subpixel_bits, board.column_bits
    down = ((2 * row + 1) << subpixel) - 2 * ya
    over = (dy << subpixel) - 1 + 2 * dy * cut(xa, 22) + dx * cut(down, 20)
    place = _cut(over) >> (subpixel + 1)
    if mirror:
        place, dx = dy - place - 1, -dx
    wide = dy << column_bits
    rest, quotient = div(_cut(wide + place), 2 * wide, np.int64(0), 1 + column_bits)
    rest = (rest + 2 * wide if rest < 0 else rest) >> (1 + column_bits)
    turn = 1 << column_bits
    out[0] = quotient - turn
    if dx == 0 or rows == 1:
        out[1], out[2], out[3], out[4] = -1, 0, 0, -1
        return
    left, quotient = div(_cut(wide + dx), 2 * wide, np.int64(0), 1 + column_bits)
    left = (left + 2 * wide if left < 0 else left) >> (1 + column_bits)
    out[1], out[2], out[3], out[4] = left - dy + rest, quotient - turn, left, left - dy


@njit(cache=True)
def _ratio(over: Int, under: Int) -> Int:
    """A ratio with ``RATIO_FRAC`` bits of fraction: 16 times the divisor is added before, and taken away."""
    _, quotient = div(_cut(over), _cut(under), np.int64(0), RATIO_FRAC + 5)
    return quotient - (np.int64(1) << (RATIO_FRAC + 4))


@njit(cache=True)
def _product(first: Int, second: Int) -> Int:
    return _cut(mulf(np.int64(0), _cut(first), _cut(second), 36) << 4)


@njit(cache=True)
def _word(board: Board, total: Int, shift: int) -> Int:
    return cut((_cut(total) >> shift) >> board.word_low, board.word_width)


@njit(cache=True)
def _linear(board: Board, first: Int, d: Int, e: Int, r: Ints, shift: int, half: Int, out: Ints) -> None:
    """The three words of a linear channel; ``r`` are u, v, and their steps down and along."""
    d, e = cut(d, 18), cut(e, 18)
    out[0] = _word(board, (first << RATIO_FRAC) + half + r[0] * d + r[1] * e, shift)
    out[1] = _word(board, r[2] * d + r[3] * e, shift)
    out[2] = _word(board, r[4] * d + r[5] * e, shift)


@njit(cache=True)
def _products(r: Ints, s: Ints) -> None:
    """Of the ratios ``r``, the factors of a, b, c in each of the six differences: ``s`` (6, 3)."""
    u, v, pu, pv, qu, qv = r[0], r[1], r[2], r[3], r[4], r[5]
    s[0, 0], s[0, 1], s[0, 2] = _product(u, u), _product(v, v), _product(u, v)
    s[3, 0], s[3, 1], s[3, 2] = _product(pu, pu), _product(pv, pv), _product(pu, pv)
    s[5, 0], s[5, 1], s[5, 2] = _product(qu, qu), _product(qv, qv), _product(qu, qv)
    s[1, 0] = _product(2 * u, pu) + s[3, 0]
    s[1, 1] = _product(2 * v, pv) + s[3, 1]
    s[1, 2] = _product(u + pu, v + pv) - s[0, 2]
    s[2, 0] = _product(2 * u, qu) - s[5, 0]
    s[2, 1] = _product(2 * v, qv) - s[5, 1]
    s[2, 2] = _product(u + qu, v + qv) - s[0, 2] - 2 * s[5, 2]
    s[4, 0] = _product(2 * pu, qu)
    s[4, 1] = _product(2 * pv, qv)
    s[4, 2] = _product(pu + qu, pv + qv) - s[3, 2] - s[5, 2]


@njit(cache=True)
def _quadratic(board: Board, i: Ints, m: Ints, r: Ints, s: Ints, half: Int, out: Ints) -> None:
    """The six words of a quadratic channel with corners ``i`` and middles ``m`` (0 to 1, 0 to 2, 1 to 2)."""
    c = (m[2] - m[0] - m[1] + i[0]) << 2
    a, b = (i[0] + i[1] - 2 * m[0]) << 1, (i[0] + i[2] - 2 * m[1]) << 1
    d, e = cut(i[1] - i[0] - a, 18), cut(i[2] - i[0] - b, 18)
    for difference in range(6):
        # Second differences once along one way have twice the square.
        twice = 1 if difference == 3 or difference == 5 else 0
        total = s[difference, 0] * cut(a << twice, 18) + s[difference, 1] * cut(b << twice, 18)
        total += s[difference, 2] * cut(c << twice, 18)
        if difference < 3:
            total += r[2 * difference] * d + r[2 * difference + 1] * e
        if difference == 0:
            total += (i[0] << RATIO_FRAC) + half
        out[difference] = _word(board, total, board.shift_colour)


@njit(cache=True)
def _cover(board: Board, x: Ints, y: Ints, trims: Ints, out: Ints) -> None:
    """Header and edges of a triangle whose corners go down; ``out`` (COVER_WIDTH,)."""
    subpixel = board.subpixel_bits
    centre = (1 << subpixel) - 1
    x2, y2, x3, y3 = x[1] - x[0], y[1] - y[0], x[2] - x[0], y[2] - y[0]
    area = x2 * cut(y3, 18) - x3 * cut(y2, 18)
    top = ((2 * y[0] + centre) >> (subpixel + 1)) + trims[0]
    knee = (2 * y[1] + centre) >> (subpixel + 1)
    bottom = ((2 * y[2] + centre) >> (subpixel + 1)) - trims[1]
    both = top < knee < bottom
    mirror = 1 if both and area < 0 else 0
    out[0], out[3], out[4] = top, int(both), mirror
    out[1], out[2] = (knee - top, bottom - knee) if both else (bottom - top, 0)
    long, short = (5, 10) if both or area >= 0 else (10, 5)
    _edge(board, x[0], y[0], x3, y3, top, bottom - top, mirror, out[long : long + 5])
    if top < knee:
        _edge(board, x[0], y[0], x2, y2, top, out[1], mirror, out[short : short + 5])
    else:
        _edge(board, x[1], y[1], x3 - x2, y3 - y2, top, out[1], mirror, out[short : short + 5])
    if both:
        _edge(board, x[1], y[1], x3 - x2, y3 - y2, knee, out[2], mirror, out[15:20])


@njit(cache=True)
def usual_order(points: Points) -> Ints:
    """(n, 3) int64: the order in which the board keeps corners that are sent as they are."""
    order = np.zeros((len(points.corners), 3), np.int64)
    for p in range(len(order)):
        corners, kept = points.corners[p], order[p]
        kept[1], kept[2] = 1, 2
        for step in range(3):
            low = step % 2
            if corners[kept[low + 1], 1] < corners[kept[low], 1]:
                kept[low], kept[low + 1] = kept[low + 1], kept[low]
        one, two, three = corners[kept[0]], corners[kept[1]], corners[kept[2]]
        if (two[0] - one[0]) * (three[1] - one[1]) < (three[0] - one[0]) * (two[1] - one[1]):
            kept[1], kept[2] = kept[2], kept[1]
    return order


@njit(cache=True)
def set_up(points: Points, order: Ints, todo: Bools, board: Board, covers: Ints, words: Ints) -> None:
    """
    Set up triangles.

    Parameters
    ----------
    points : Points
      Of n triangles.
    order : (n, 3) int64
      The corners in the order in which the board keeps them: by y, then round with an area above zero.
    todo : (n,) bool
      Which ones; the others' rows stay as they are.
    board : Board
    covers : (n, COVER_WIDTH) int64, written
    words : (n, c, 6) int64, written
      Differences, signed; zeros above a channel's order.
    """
    x, y, i, m = np.zeros(3, np.int64), np.zeros(3, np.int64), np.zeros(3, np.int64), np.zeros(3, np.int64)
    r, s = np.zeros(6, np.int64), np.zeros((6, 3), np.int64)
    subpixel, depth = board.subpixel_bits, 2 + board.num_channels
    half = np.int64(1) << (RATIO_FRAC + SAMPLE_FRAC - 1 + board.shift_colour)
    for p in range(len(todo)):
        if not todo[p]:
            continue
        corners, middles, kept, cover = points.corners[p], points.middles[p], order[p], covers[p]
        # By y alone: of the last two the lower one comes last.
        swap = corners[kept[2], 1] < corners[kept[1], 1]
        for slot in range(3):
            place = 3 - slot if swap and slot else slot
            x[slot], y[slot] = corners[kept[place], 0], corners[kept[place], 1]
        _cover(board, x, y, points.trims[p], cover)
        for slot in range(3):
            x[slot], y[slot] = corners[kept[slot], 0], corners[kept[slot], 1]
        x2, y2, x3, y3 = x[1] - x[0], y[1] - y[0], x[2] - x[0], y[2] - y[0]
        area = x2 * cut(y3, 18) - x3 * cut(y2, 18)
        column, step, along = cover[5], cover[7], 1
        if cover[4]:
            column, step, along = -1 - column, -step, -1
        right = cut(((2 * column + 1) << subpixel) - 2 * x[0], 20)
        down = cut(((2 * cover[0] + 1) << subpixel) - 2 * y[0], 20)
        step = cut(step, 16)
        r[0] = _ratio((area << 5) + y3 * right - x3 * down, area << 6)
        r[1] = _ratio((area << 5) + x2 * down - y2 * right, area << 6)
        r[2] = _ratio(((y3 * step - x3) << (subpixel - 4)) + area, 2 * area)
        r[3] = _ratio(((x2 - y2 * step) << (subpixel - 4)) + area, 2 * area)
        r[4] = _ratio((along * y3 << (subpixel - 4)) + area, 2 * area)
        r[5] = _ratio((-along * y2 << (subpixel - 4)) + area, 2 * area)
        if points.quadratic[p]:
            _products(r, s)
        for channel in range(board.num_channels):
            for slot in range(3):
                i[slot] = corners[kept[slot], 2 + channel]
            if points.quadratic[p]:
                for slot in range(3):
                    ends = kept[0 if slot < 2 else 1] + kept[1 if slot < 1 else 2]
                    m[slot] = middles[ends - 1, channel]
                _quadratic(board, i, m, r, s, half, words[p, channel])
            else:
                _linear(board, i[0], i[1] - i[0], i[2] - i[0], r, board.shift_colour, half, words[p, channel])
        if board.with_depth:
            first = corners[kept[0], depth]
            d, e = corners[kept[1], depth] - first, corners[kept[2], depth] - first
            out = words[p, board.num_channels]
            _linear(board, first, d, e, r, board.shift_depth, np.int64(board.half_depth), out)
