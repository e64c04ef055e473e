# SPDX-License-Identifier: Apache-2.0
"""Weighted fits of cosines in compiled loops."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from quadshade.adapt.polynomial_loops import (
    ALL_SHAPES,
    FAST,
    SHAPE_ROWS,
    SIZES,
    drawn_by,
    one_fit,
    padded,
    raise_order,
    reweighted,
    shape_rows,
)
from quadshade.contract.arrays import Floats, Int, Ints
from quadshade.shading.phong_loops import raise_all
from quadshade.shading.point_sets import PointSets

FAINT = 1e-4
"""Weight of a point without specular light."""
DARK = 0.02
"""Weight of a point in the dark, where a diffuse cosine only has to be negative."""


class CosineKind(NamedTuple):
    """
    How a picture's colours follow from cosines, and how fits to them are looked for.

    Attributes
    ----------
    exponent : float
      What specular cosines are raised to.
    whole : int
      The exponent where it is an integer, else -1.
    powered : bool
      They are; else they are powers already.
    ambient : (3,) float64
    diffuse, specular : (lights, 3) float64
      Output units that a full cosine, or power, adds.
    scale : (2 lights,) float64
      The same by the measure, diffuse cosines first.
    full : float
      Largest value of the output.
    largest : bool
      The measure is ``max``, else the mean square.
    secants, equalising : int
      Repetitions with the power's slope between the cosine and what it became, and towards equal extremes.
    orders : int
      How many there are.
    fine : float
      An error, by the measure, for which nothing better is looked for.
    """

    exponent: float
    whole: int
    powered: bool
    ambient: Floats
    diffuse: Floats
    specular: Floats
    scale: Floats
    full: float
    largest: bool
    secants: int
    equalising: int
    orders: int
    fine: float


# Rows of the room that a channel's fit works in.
VALUE, RAISED, LIT, WEIGHT, FIRST_WEIGHT, DRAWN, REST, PART, SHINE = range(9)
ROOM = 9


@njit(cache=True, error_model="numpy", fastmath=FAST, forceinline=True)
def clamped_powers(values: Floats, kind: CosineKind, room: Floats, count: Int, out: Floats) -> None:
    """``out`` of values clamped to 0 .. 1 and raised; the room's row ``PART`` is overwritten."""
    part = room[PART]
    for p in range(count):
        level = values[p] if values[p] > 0 else 0.0
        part[p] = level if level < 1 else 1.0
    raise_all(part, count, kind.exponent, kind.whole, out)


@njit(cache=True, error_model="numpy", fastmath=FAST, forceinline=True)
def fill_room(
    kind: CosineKind, facing: Floats, towards: Floats, specular: bool, scale: float, room: Floats
) -> None:
    """
    Fill the room for a channel: its value, that raised, and weights.

    ``LIT`` is 1 where a specular cosine counts; of a diffuse one the specular term, which appears or vanishes
    with the cosine's sign.
    """
    count, wide = len(facing), padded(len(facing))
    room[:, count:wide] = 0.0
    value, raised, lit, first = room[VALUE], room[RAISED], room[LIT], room[FIRST_WEIGHT]
    clamped_powers(towards, kind, room, count, raised)
    if not specular:
        for p in range(count):
            value[p], lit[p] = facing[p], raised[p] * scale
            first[p] = 1.0 if facing[p] > 0 else DARK
        return
    part = room[PART]
    for p in range(count):
        level = towards[p] if towards[p] > 0 else 0.0
        part[p] = level if level < 1 else 1.0
    raise_all(part, count, kind.exponent - 1, kind.whole - 1 if kind.whole > 0 else -1, first)
    for p in range(count):
        value[p] = towards[p]
        shines = towards[p] > 0 or not kind.powered
        lit[p] = 1.0 if facing[p] > 0 and shines else 0.0
        first[p] = lit[p] * first[p] + FAINT


@njit(cache=True, error_model="numpy", fastmath=FAST, forceinline=True)
def measure_fit(
    kind: CosineKind,
    shape: Floats,
    size: Int,
    samples: Floats,
    count: Int,
    specular: bool,
    scale: float,
    room: Floats,
) -> tuple[float, float]:
    """Clamp samples; write what they draw and leave at each place; return the largest and the mean square."""
    for i in range(size):
        samples[i] = min(max(samples[i], -1.0), 1.0)
    value, raised, lit, drawn, rest, shine = (
        room[VALUE], room[RAISED], room[LIT], room[DRAWN], room[REST], room[SHINE],
    )  # fmt: skip
    wide = padded(count)
    drawn_by(shape, size, samples, wide, drawn)
    largest = total = 0.0
    if specular:
        clamped_powers(drawn, kind, room, wide, shine)
        for p in range(wide):
            rest[p] = abs(shine[p] - raised[p]) * scale * lit[p]
    else:
        for p in range(wide):
            made = drawn[p] if drawn[p] > 0 else 0.0
            true = value[p] if value[p] > 0 else 0.0
            flip = lit[p] if (drawn[p] > 0) != (value[p] > 0) else 0.0
            rest[p] = abs(made - true) * scale + flip
    for p in range(wide):
        largest = max(largest, rest[p])
        total += rest[p] * rest[p]
    return largest, total / count


@njit(cache=True, error_model="numpy", forceinline=True)
def _level(kind: CosineKind, count: Int, room: Floats) -> float:
    """The best constant of a specular channel: halfway between the extremes of the power, or its mean."""
    high, low, total, number = 0.0, 1.0, 0.0, 0
    for p in range(count):
        if room[LIT, p] != 0:
            high, low = max(high, room[RAISED, p]), min(low, room[RAISED, p])
            total += room[RAISED, p]
            number += 1
    level = (high + min(low, high)) / 2 if kind.largest else total / max(number, 1)
    return level ** (1 / kind.exponent)


@njit(cache=True, error_model="numpy", fastmath=FAST, forceinline=True)
def _secant_weights(kind: CosineKind, count: Int, room: Floats) -> None:
    """Weights by the power's slope between a cosine and what it became."""
    value, drawn, raised = room[VALUE], room[DRAWN], room[RAISED]
    shine, weights, first = room[SHINE], room[WEIGHT], room[FIRST_WEIGHT]
    for p in range(count):
        apart = abs(drawn[p] - value[p])
        slope = abs(shine[p] - raised[p]) / (apart if apart > 1e-9 else 1.0) / kind.exponent
        weights[p] = room[LIT, p] * (slope if apart > 1e-9 else first[p]) + FAINT


@njit(cache=True, error_model="numpy", fastmath=FAST, forceinline=True)
def _best(
    kind: CosineKind,
    shape: Floats,
    size: Int,
    count: Int,
    specular: bool,
    scale: float,
    nodes: Ints,
    room: Floats,
    matrix: Floats,
    tried: Floats,
    best: Floats,
) -> tuple[float, float]:
    """The best of several polynomials for one channel: ``best`` (size), its largest error and mean square."""
    wide = padded(count)
    weights = room[WEIGHT, :wide]
    weights[:count] = 1.0
    value, part = room[VALUE, :wide], room[PART]
    given = 1 if len(nodes) else 0
    levels = 1 if specular and size == 1 else 0
    secants = kind.secants if specular else 0
    weighted = 1 + given + levels
    steps = weighted + 1 + secants + (kind.equalising if kind.largest and size > 1 else 0)
    least, largest, square = np.inf, np.inf, np.inf
    for step in range(steps):
        if 1 <= step < weighted:
            if step <= given:
                for i in range(size):
                    tried[i] = room[VALUE, nodes[i]]
            else:
                tried[0] = _level(kind, count, room)
        else:
            if step == weighted:
                weights[:] = room[FIRST_WEIGHT, :wide]
            elif step > weighted + secants:
                most = 1e-12
                for p in range(wide):
                    most = max(most, room[REST, p])
                reweighted(weights, room[REST], most)
            elif step > weighted:
                _secant_weights(kind, count, room)
            one_fit(shape, size, value, weights, part, matrix, tried)
        most_off, mean = measure_fit(kind, shape, size, tried, count, specular, scale, room)
        score = most_off if kind.largest else mean
        if score < least or step == 0:
            least, largest, square = score, most_off, mean
            for i in range(size):
                best[i] = tried[i]
        if least <= kind.fine:
            break
    return largest, square


@njit(cache=True, error_model="numpy")
def fit_cosines(
    kind: CosineKind,
    sets: PointSets,
    facing: Floats,
    towards: Floats,
    nodes: Ints,
    rows: Ints,
    samples: Floats,
    own: Floats,
) -> Floats:
    """
    The best polynomials of every order for cosines at places of triangles.

    Parameters
    ----------
    kind : CosineKind
    sets : PointSets
    facing, towards : (lights, m) float64
      Diffuse and specular cosines there.
    nodes : (orders, 6) int64
      Places that a polynomial of each order may go through; none (0 orders) where all are fitted.
    rows : (n,) int64
      Where to write what is found out for each of the n triangles of ``sets``.
    samples : (k, 2 lights, orders, 6) float64
      Written: cosines, diffuse channels first.
    own : (k, 2 lights, orders) float64
      Written: the error that each leaves alone, the other channel being exact, by the measure.

    Returns
    -------
    (2 lights, orders, m) float64
      What the polynomials draw.
    """
    lights, total = facing.shape
    drawn = np.empty((2 * lights, kind.orders, total))
    most = sets.number.max() if len(sets.number) else 0
    wide = padded(most)
    room, shapes, matrix = np.empty((ROOM, wide)), np.empty((ALL_SHAPES, wide)), np.empty((6, 6))
    none = np.empty(0, np.int64)
    tried, best = np.empty(6), np.empty(6)
    for index in range(len(sets.number)):
        count, at, row = sets.number[index], sets.at[index], rows[index]
        shape_rows(sets.points, sets.begin[index], count, shapes)
        for channel in range(2 * lights):
            light, specular = channel % lights, channel >= lights
            here = slice(at, at + count)
            fill_room(
                kind, facing[light, here], towards[light, here], specular, kind.scale[lights + light], room
            )
            for order in range(kind.orders):
                size = SIZES[order]
                shape = shapes[SHAPE_ROWS[order] :]
                if order and own[row, channel, order - 1] <= kind.fine:
                    raise_order(samples[row, channel, order - 1], order, samples[row, channel, order])
                    own[row, channel, order] = own[row, channel, order - 1]
                    drawn[channel, order, here] = drawn[channel, order - 1, here]
                    continue
                through = nodes[order, :size] if len(nodes) else none
                # With a size that the compiler knows, loops over samples are unrolled.
                given = kind, shape
                if size == 1:
                    largest, square = _best(
                        *given, 1, count, specular, kind.scale[channel], through, room, matrix, tried, best
                    )
                elif size == 3:
                    largest, square = _best(
                        *given, 3, count, specular, kind.scale[channel], through, room, matrix, tried, best
                    )
                else:
                    largest, square = _best(
                        *given, 6, count, specular, kind.scale[channel], through, room, matrix, tried, best
                    )
                samples[row, channel, order, :size] = best[:size]
                own[row, channel, order] = largest if kind.largest else square
                drawn_by(shape, size, best, count, drawn[channel, order, here])
    return drawn
