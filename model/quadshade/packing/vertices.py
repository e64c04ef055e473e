# SPDX-License-Identifier: Apache-2.0
"""
Triangles to packets that carry vertices (``docs/reference/vertices.md``): points, and tokens of the line.

A triangle that shares an edge with the one before it names the corner that it drops. Other corners and edge
middles are named from the tables of the last 64, or sent as what is left of a prediction, in codes of
Exponential-Golomb: of hard edges some is left, of smooth surfaces little.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from quadshade.contract.arrays import Bools, Int, Ints
from quadshade.contract.vertex_program import LARGEST_TRIM, LONGEST_PREFIX, MIDDLES, VERTICES
from quadshade.packing.vertex_code import BITS, COLOUR, DEPTH, MIDDLE, ONES, PLACE, RUN, Tokens

MOST_TOKENS = 48
"""More than a triangle has."""

_RING = 64
_BUCKETS = 1024


class Points(NamedTuple):
    """
    What triangles' packets say, an entry a primitive.

    Attributes
    ----------
    corners : (n, 3, r) int64
      x, y, colours, depth if there is one; whole numbers of the unit that each is sent in.
    middles : (n, 3, c) int64
      Of the edges from corner 0 to 1, 0 to 2, 1 to 2.
    quadratic : (n,) bool
    trims : (n, 2) int64
      Scanlines without a pixel at top and bottom.
    sent : (n,) bool
      The others are packed words.
    """

    corners: Ints
    middles: Ints
    quadratic: Bools
    trims: Ints
    sent: Bools


class _Tables(NamedTuple):
    """
    What the board has: rings of corners and middles, how many were put in; the last triangle's places.

    Most points are looked for in vain: ``corners_by`` and ``middles_by`` count those in the ring by what
    :func:`_bucket` says of them.
    """

    corners: Ints
    middles: Ints
    corners_by: Ints
    middles_by: Ints
    counts: Ints
    at: Ints
    middles_at: Ints


@njit(cache=True)
def _equal(first: Ints, second: Ints) -> bool:
    for index in range(len(first)):
        if first[index] != second[index]:
            return False
    return True


@njit(cache=True)
def _bucket(point: Ints, columns: int) -> Int:
    """One of ``_BUCKETS`` of a point's first numbers; equal ones are in the same."""
    mixed = np.int64(0)
    for column in range(columns):
        mixed = 1021 * mixed + point[column]
    return (mixed ^ (mixed >> 12)) & (_BUCKETS - 1)


@njit(cache=True)
def _put_in(ring: Ints, by: Ints, count: int, point: Ints, columns: int) -> int:
    """Put a point into a ring, in place of the oldest one; its place."""
    place = count % _RING
    if count >= _RING:
        by[_bucket(ring[place], columns)] -= 1
    by[_bucket(point, columns)] += 1
    ring[place] = point
    return place


@njit(cache=True)
def _stays(place: int, count: int) -> bool:
    """Whether a place of a ring is not among the next three that are written."""
    return (place - count) % _RING >= 3


@njit(cache=True)
def _find(ring: Ints, count: int, point: Ints) -> int:
    """Place of a point in a ring where it stays, -1 if there is none; the newest one first."""
    for age in range(min(count, _RING - 3)):
        place = (count - 1 - age) & (_RING - 1)
        if ring[place, 0] == point[0] and _equal(ring[place], point):
            return place
    return -1


@njit(cache=True)
def _find_corner(ring: Ints, count: int, point: Ints, colours: int) -> tuple[int, int]:
    """As :func:`_find`, of a corner, and of one at the same place and depth, whatever its colours."""
    there = -1
    for age in range(min(count, _RING - 3)):
        place = (count - 1 - age) & (_RING - 1)
        # Most differ in x already.
        if ring[place, 0] != point[0] or ring[place, 1] != point[1]:
            continue
        if _equal(ring[place, 2 + colours :], point[2 + colours :]):
            if _equal(ring[place, 2 : 2 + colours], point[2 : 2 + colours]):
                return place, place
            if there < 0:
                there = place
    return -1, there


@njit(cache=True)
def _token(tokens: Tokens, at: int, kind: int, value: Int, bits: int) -> int:
    tokens.kinds[at], tokens.values[at], tokens.bits[at] = kind, value, bits
    return at + 1


@njit(cache=True)
def _corner(
    tables: _Tables, point: Ints, base: Ints, colours: int, slot: int, tokens: Tokens, at: int
) -> int:
    """Name a corner or send it; its place is then ``tables.at[slot]``."""
    place, there = -1, -1
    if tables.corners_by[_bucket(point, 2)]:
        place, there = _find_corner(tables.corners, tables.counts[0], point, colours)
    if place >= 0:
        tables.at[slot] = place
        at = _token(tokens, at, BITS, np.int64(0), 1)
        return _token(tokens, at, BITS, np.int64(place), 6)
    if there >= 0:
        at = _token(tokens, at, BITS, np.int64(0b11), 2)
        at = _token(tokens, at, BITS, np.int64(there), 6)
    else:
        at = _token(tokens, at, BITS, np.int64(0b10), 2)
        at = _token(tokens, at, PLACE, point[0] - base[0], 0)
        at = _token(tokens, at, PLACE, point[1] - base[1], 0)
    before = np.int64(0)
    for index in range(2, 2 + colours):
        left = point[index] - base[index]
        at = _token(tokens, at, COLOUR, left - before, 0)
        before = left
    if there < 0 and len(point) > 2 + colours:
        at = _token(tokens, at, DEPTH, point[2 + colours] - base[2 + colours], 0)
    place = _put_in(tables.corners, tables.corners_by, tables.counts[0], point, 2)
    tables.counts[0] += 1
    tables.at[slot] = place
    return at


@njit(cache=True)
def _middle(
    tables: _Tables, point: Ints, first: Ints, second: Ints, slot: int, tokens: Tokens, at: int
) -> int:
    """Name a middle or send it; its place is then ``tables.middles_at[slot]``."""
    place = -1
    if tables.middles_by[_bucket(point, len(point))]:
        place = _find(tables.middles, tables.counts[1], point)
    if place >= 0:
        tables.middles_at[slot] = place
        at = _token(tokens, at, BITS, np.int64(0), 1)
        return _token(tokens, at, BITS, np.int64(place), 6)
    at = _token(tokens, at, BITS, np.int64(1), 1)
    before = np.int64(0)
    for index in range(len(point)):
        left = point[index] - ((first[2 + index] + second[2 + index]) >> 1)
        at = _token(tokens, at, MIDDLE, left - before, 0)
        before = left
    place = _put_in(tables.middles, tables.middles_by, tables.counts[1], point, len(point))
    tables.counts[1] += 1
    tables.middles_at[slot] = place
    return at


@njit(cache=True)
def _pair(first: int, second: int) -> int:
    """Index of the middle between two corners."""
    return first + second - 1


@njit(cache=True)
def _shared(tables: _Tables, points: Points, p: int, was_quadratic: bool, order: Ints) -> int:
    """The corner that a triangle drops of the last one, 3 if it shares no edge; ``order`` gets corners."""
    corners, middles = points.corners[p], points.middles[p]
    for drop in range(3):
        first, second = (1 if drop == 0 else 0), (1 if drop == 2 else 2)
        a, b = tables.at[first], tables.at[second]
        if not (_stays(a, tables.counts[0]) and _stays(b, tables.counts[0])):
            continue
        i = j = -1
        for corner in range(3):
            if i < 0 and _equal(corners[corner], tables.corners[a]):
                i = corner
            elif j < 0 and _equal(corners[corner], tables.corners[b]):
                j = corner
        if i < 0 or j < 0:
            continue
        if points.quadratic[p]:
            place = tables.middles_at[_pair(first, second)]
            if not (was_quadratic and _stays(place, tables.counts[1])):
                continue
            if not _equal(middles[_pair(i, j)], tables.middles[place]):
                continue
        order[0], order[1], order[2] = i, j, 3 - i - j
        return drop
    order[0], order[1], order[2] = 0, 1, 2
    return 3


@njit(cache=True)
def _swap(places: Ints, first: int, second: int) -> None:
    places[first], places[second] = places[second], places[first]


@njit(cache=True)
def _settle(tables: _Tables, order: Ints) -> None:
    """Corners, and ``order``, as the board keeps them: by y, then round with the area above 0."""
    at, middles = tables.at, tables.middles_at
    for step in range(3):
        low = step % 2
        if tables.corners[at[low + 1], 1] < tables.corners[at[low], 1]:
            _swap(at, low, low + 1)
            _swap(order, low, low + 1)
            _swap(middles, 1 - low, 2 - low)
    one, two, three = tables.corners[at[0]], tables.corners[at[1]], tables.corners[at[2]]
    area = (two[0] - one[0]) * (three[1] - one[1]) - (three[0] - one[0]) * (two[1] - one[1])
    if area < 0:
        _swap(at, 1, 2)
        _swap(order, 1, 2)
        _swap(middles, 0, 1)


@njit(cache=True)
def tokens_of(points: Points, tokens: Tokens, settled: Ints) -> int:
    """
    What the line carries for all primitives, written; how many tokens that are.

    ``settled`` (n, 3) gets the corners of each that is sent, in the order in which the board keeps them. Of
    those that are packed words, a token of kind ``RUN`` with their number stands for a run of them.
    """
    width, colours = points.corners.shape[2], points.middles.shape[2]
    tables = _Tables(
        np.zeros((_RING, width), np.int64),
        np.zeros((_RING, colours), np.int64),
        np.zeros(_BUCKETS, np.int64),
        np.zeros(_BUCKETS, np.int64),
        np.zeros(2, np.int64),
        np.zeros(3, np.int64),
        np.zeros(3, np.int64),
    )
    order, base = np.zeros(3, np.int64), np.zeros(width, np.int64)
    at, run, begun, was_quadratic = 0, 0, False, False
    for p in range(len(points.sent)):
        if not points.sent[p]:
            run += 1
            continue
        if run:
            at = _token(tokens, at, RUN, np.int64(run), 0)
            run = 0
        corners, middles, quadratic = points.corners[p], points.middles[p], points.quadratic[p]
        at = _token(tokens, at, BITS, np.int64(2), 2)
        at = _token(tokens, at, ONES, points.trims[p, 0], 0)
        at = _token(tokens, at, ONES, points.trims[p, 1], 0)
        at = _token(tokens, at, BITS, np.int64(quadratic), 1)
        drop = _shared(tables, points, p, was_quadratic, order) if begun else 3
        at = _token(tokens, at, BITS, np.int64(drop), 2)
        if drop == 3:
            order[0], order[1], order[2] = 0, 1, 2
            base[:] = tables.corners[tables.at[2]]
            at = _corner(tables, corners[0], base, colours, 0, tokens, at)
            at = _corner(tables, corners[1], corners[0], colours, 1, tokens, at)
            if quadratic:
                at = _middle(tables, middles[0], corners[0], corners[1], 0, tokens, at)
            base[:] = corners[1]
        else:
            base[:] = corners[order[0]] + corners[order[1]] - tables.corners[tables.at[drop]]
            kept = tables.middles_at[_pair(1 if drop == 0 else 0, 1 if drop == 2 else 2)]
            if drop == 0:
                tables.at[0], tables.at[1] = tables.at[1], tables.at[2]
            elif drop == 1:
                tables.at[1] = tables.at[2]
            tables.middles_at[0] = kept
        third = corners[order[2]]
        at = _corner(tables, third, base, colours, 2, tokens, at)
        if quadratic:
            for slot in range(2):
                place = _pair(order[slot], order[2])
                at = _middle(tables, middles[place], corners[order[slot]], third, slot + 1, tokens, at)
        _settle(tables, order)
        settled[p] = order
        begun, was_quadratic = True, quadratic
    if run:
        at = _token(tokens, at, RUN, np.int64(run), 0)
    return at


assert VERTICES == MIDDLES == _RING and LARGEST_TRIM == LONGEST_PREFIX
