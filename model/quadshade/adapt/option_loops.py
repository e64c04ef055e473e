# SPDX-License-Identifier: Apache-2.0
"""What combinations of orders of cosines leave in the colour, and the cheapest of them, in compiled loops."""

from __future__ import annotations

import numpy as np
from numba import njit

from quadshade.adapt.cosine_loops import (
    FIRST_WEIGHT,
    PART,
    ROOM,
    VALUE,
    CosineKind,
    clamped_powers,
    fill_room,
    measure_fit,
)
from quadshade.adapt.polynomial_loops import ALL_SHAPES, FAST, SHAPE_ROWS, SIZES, one_fit, padded, shape_rows
from quadshade.contract.arrays import Floats, Int, Ints
from quadshade.shading.point_sets import PointSets


@njit(cache=True, error_model="numpy")
def half_cosines(
    kind: CosineKind,
    points: Floats,
    facing: Floats,
    towards: Floats,
    halves: Ints,
    counts: Ints,
    options: Ints,
) -> Floats:
    """
    What the nearest polynomials to parts of the points leave, all channels of an option together.

    Parameters
    ----------
    kind : CosineKind
    points : (p, 3) float64
      The same in all triangles.
    facing, towards : (lights, n * p) float64
    halves : (h, p) int64
      Points of each part, the first ``counts`` of a row.
    counts : (h,) int64
    options : (n, k, 2 lights) int64

    Returns
    -------
    (n, h, k) float64
      Sums over the channels.
    """
    lights, number = len(facing), len(points)
    count = len(options)
    out = np.zeros((count, len(halves), options.shape[1]))
    wide = padded(number)
    room, shapes, part = np.empty((ROOM, wide)), np.empty((ALL_SHAPES, wide)), np.empty((number, 3))
    matrix, tried, left = np.empty((6, 6)), np.empty(6), np.empty((2 * lights, kind.orders))
    here, there = np.empty(number), np.empty(number)
    for half in range(len(halves)):
        used = counts[half]
        for p in range(used):
            part[p] = points[halves[half, p]]
        shape_rows(part, 0, used, shapes)
        for index in range(count):
            for channel in range(2 * lights):
                light, specular = channel % lights, channel >= lights
                for p in range(used):
                    at = index * number + halves[half, p]
                    here[p], there[p] = facing[light, at], towards[light, at]
                fill_room(kind, here[:used], there[:used], specular, kind.scale[lights + light], room)
                for order in range(kind.orders):
                    size, shape = SIZES[order], shapes[SHAPE_ROWS[order] :]
                    value, weight = room[VALUE, : padded(used)], room[FIRST_WEIGHT, : padded(used)]
                    one_fit(shape, size, value, weight, room[PART], matrix, tried)
                    largest, square = measure_fit(
                        kind, shape, size, tried, used, specular, kind.scale[channel], room
                    )
                    left[channel, order] = largest if kind.largest else square
            for option in range(options.shape[1]):
                for channel in range(2 * lights):
                    out[index, half, option] += left[channel, options[index, option, channel]]
    return out


@njit(cache=True, error_model="numpy", fastmath=FAST)
def joint_errors(
    kind: CosineKind,
    sets: PointSets,
    facing: Floats,
    towards: Floats,
    drawn: Floats,
    options: Ints,
    rows: Ints,
    out: Floats,
) -> None:
    """
    How far colours are off with each option.

    Parameters
    ----------
    kind, sets, facing, towards, rows
      As for :func:`fit_cosines`: the true cosines.
    drawn : (2 lights, orders, m) float64
      Cosines as each order draws them.
    options : (k, o, 2 lights) int64
      Orders, diffuse channels first.
    out : (k, o) float64
      Written.
    """
    lights = len(facing)
    most = sets.number.max() if len(sets.number) else 0
    room, shines, true = np.empty((ROOM, most)), np.empty((lights, kind.orders, most)), np.empty((3, most))
    level = np.empty(most)
    for index in range(len(sets.number)):
        count, at, row = sets.number[index], sets.at[index], rows[index]
        here = slice(at, at + count)
        for light in range(lights):
            clamped_powers(towards[light, here], kind, room, count, shines[light, 0])
            for colour in range(3):
                if light == 0:
                    true[colour, :count] = kind.ambient[colour]
                add_light(kind, light, colour, facing[light, here], shines[light, 0], true[colour])
        for colour in range(3):
            for p in range(count):
                true[colour, p] = min(max(true[colour, p], 0.0), kind.full)
        for light in range(lights):
            for order in range(kind.orders):
                clamped_powers(drawn[lights + light, order, here], kind, room, count, shines[light, order])
        for option in range(options.shape[1]):
            largest = total = 0.0
            for colour in range(3):
                level[:count] = kind.ambient[colour]
                for light in range(lights):
                    shine = shines[light, options[row, option, lights + light]]
                    cosine = drawn[light, options[row, option, light], here]
                    add_light(kind, light, colour, cosine, shine, level)
                wanted = true[colour]
                for p in range(count):
                    made = level[p] if level[p] > 0 else 0.0
                    off = abs((min(kind.full, made)) - wanted[p])
                    largest = max(largest, off)
                    total += off * off
            out[row, option] = largest if kind.largest else total / count


@njit(cache=True, error_model="numpy", fastmath=FAST, forceinline=True)
def add_light(
    kind: CosineKind, light: Int, colour: Int, facing: Floats, shine: Floats, level: Floats
) -> None:
    """What a light adds to a colour where its diffuse cosine (p,) is positive."""
    diffuse, specular = kind.diffuse[light, colour], kind.specular[light, colour]
    for p in range(len(facing)):
        more = facing[p] * diffuse + shine[p] * specular
        level[p] += more if facing[p] > 0 else 0.0


@njit(cache=True, error_model="numpy")
def choose_options(
    errors: Floats, words: Floats, options: Ints, goal: Floats, largest: bool
) -> tuple[Ints, Floats, Floats]:
    """
    The cheapest options.

    Parameters
    ----------
    errors : (n, h, k) float64
      Of each triangle, or of some parts of each.
    words : (n, k) float64
    options : (n, k, channels) int64
    goal : (n,) float64
      See :meth:`quadshade.adapt.shader.Shader.choose`.
    largest : bool
      The measure is ``max``.

    Returns
    -------
    orders : (n, h, channels) int64
    error, words : (n, h) float64
    """
    count, parts, number = errors.shape
    orders = np.empty((count, parts, options.shape[2]), np.int64)
    left, spent = np.empty((count, parts)), np.empty((count, parts))
    for index in range(count):
        for part in range(parts):
            best, least = 0, np.inf
            for option in range(number):
                error, price = errors[index, part, option], words[index, option]
                if not largest:
                    score = error + goal[index] * price
                elif error <= goal[index]:
                    # Of as many words the better; where none is good, the best.
                    score = price + error * 1e-6
                else:
                    score = 1e6 * (1 + error)
                if score < least:
                    best, least = option, score
            orders[index, part] = options[index, best]
            left[index, part], spent[index, part] = errors[index, part, best], words[index, best]
    return orders, left, spent
