# SPDX-License-Identifier: Apache-2.0
"""
Weighted fits of polynomials in compiled loops.

What is chosen by these is drawn and compared, so products are added up in the order that is fastest.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from quadshade.contract.arrays import Floats, Int
from quadshade.shading.point_sets import PointSets

RIDGE = 1e-10
SIZES = (1, 3, 6)
"""Samples of an order."""
SHAPE_ROWS = np.array([0, 1, 4])
"""Where an order's shape functions begin among :func:`shape_rows`."""
ALL_SHAPES = 10
FAST = {"reassoc", "contract", "nsz"}
"""Products are added up in the order that is fastest."""


WIDTH = 16
"""Rows of numbers are filled up with zeros to a multiple of this, so that loops over them are all vectors."""


@njit(cache=True, forceinline=True)
def padded(count: Int) -> Int:
    """The length of a row that holds so many numbers."""
    return (count + WIDTH - 1) // WIDTH * WIDTH


@njit(cache=True, error_model="numpy", fastmath=FAST, forceinline=True)
def shape_rows(points: Floats, begin: Int, count: Int, out: Floats) -> None:
    """
    What the samples of each order contribute at points of a triangle: ``out`` (10, ``padded(count)``).

    One row for a constant, three for a linear and six for a quadratic polynomial: I1, I2, I3, I12, I13, I23
    (Abbas et al., section 3).
    """
    out[:, count : padded(count)] = 0.0
    for p in range(count):
        a, b, c = points[begin + p, 0], points[begin + p, 1], points[begin + p, 2]
        out[0, p], out[1, p], out[2, p], out[3, p] = 1.0, a, b, c
        out[4, p], out[5, p], out[6, p] = a * (2 * a - 1), b * (2 * b - 1), c * (2 * c - 1)
        out[7, p], out[8, p], out[9, p] = 4 * a * b, 4 * a * c, 4 * b * c


@njit(cache=True, error_model="numpy", forceinline=True)
def solve(matrix: Floats, right: Floats, size: Int) -> None:
    """Solve a positive definite system of the first ``size`` unknowns in place (Cholesky)."""
    for row in range(size):
        for column in range(row):
            total = matrix[row, column]
            for k in range(column):
                total -= matrix[row, k] * matrix[column, k]
            matrix[row, column] = total * matrix[column, column]
        total, rest = matrix[row, row], right[row]
        for k in range(row):
            total -= matrix[row, k] * matrix[row, k]
            rest -= matrix[row, k] * right[k]
        # The reciprocal of the factor's diagonal stands there.
        matrix[row, row] = 1 / np.sqrt(total)
        right[row] = rest * matrix[row, row]
    for row in range(size - 1, -1, -1):
        total = right[row]
        for k in range(row + 1, size):
            total -= matrix[k, row] * right[k]
        right[row] = total * matrix[row, row]


@njit(cache=True, error_model="numpy", fastmath=FAST, forceinline=True)
def one_fit(
    shape: Floats, size: Int, value: Floats, weight: Floats, part: Floats, matrix: Floats, out: Floats
) -> None:
    """
    One weighted fit: ``out`` (size) of values and weights (p,) at places with ``shape`` (size, p or more).

    ``part`` (p or more) and ``matrix`` (size, size) are room. Of several fits the one nearest to a constant.
    A place of weight 0 does not count.
    """
    places = len(value)
    total = mean = 0.0
    for p in range(places):
        total += weight[p]
        mean += weight[p] * value[p]
    mean /= total
    if size == 1:
        out[0] = mean
        return
    trace = 0.0
    for i in range(size):
        mine = shape[i]
        right = 0.0
        for p in range(places):
            part[p] = weight[p] * mine[p]
            right += part[p] * (value[p] - mean)
        out[i] = right
        for j in range(i + 1):
            other = shape[j]
            both = 0.0
            for p in range(places):
                both += part[p] * other[p]
            matrix[i, j] = both
        trace += matrix[i, i]
    for i in range(size):
        # Shape functions sum to 1, so what this pulls to zero is the distance from the mean.
        matrix[i, i] += RIDGE * trace
    solve(matrix, out, size)
    for i in range(size):
        out[i] += mean


@njit(cache=True, error_model="numpy")
def raise_order(samples: Floats, order: Int, out: Floats) -> None:
    """``out`` (6) of the polynomial of the order below that samples (6) are."""
    for i in range(3):
        out[i] = samples[i if order == 2 else 0]
    if order == 2:
        out[3], out[4], out[5] = (out[0] + out[1]) / 2, (out[0] + out[2]) / 2, (out[1] + out[2]) / 2


@njit(cache=True, error_model="numpy", fastmath=FAST, forceinline=True)
def drawn_by(shape: Floats, size: Int, samples: Floats, count: Int, out: Floats) -> None:
    """``out`` (count) of the polynomial that samples (size) are."""
    for p in range(count):
        out[p] = 0.0
    for i in range(size):
        mine, sample = shape[i], samples[i]
        for p in range(count):
            out[p] += sample * mine[p]


@njit(cache=True, error_model="numpy", fastmath=FAST, forceinline=True)
def reweighted(weights: Floats, rest: Floats, worst: float) -> None:
    """Lawson's step: weights (p,) grow where the rest (p or more) is large; their sum becomes 1."""
    total, scale = 0.0, 1 / max(worst, 1e-12)
    for p in range(len(weights)):
        weights[p] *= rest[p] * scale + 1e-3
        total += weights[p]
    scale = 1 / max(total, 1e-300)
    for p in range(len(weights)):
        weights[p] *= scale


@njit(cache=True, error_model="numpy", fastmath=FAST, forceinline=True)
def _measured(
    shape: Floats, samples: Floats, value: Floats, full: float, drawn: Floats, rest: Floats
) -> tuple[float, float]:
    """Clamp samples; write what is left at each place; return the largest and the sum of squares."""
    size, count = len(samples), len(value)
    for i in range(size):
        samples[i] = min(max(samples[i], 0.0), full)
    drawn_by(shape, size, samples, count, drawn)
    worst = total = 0.0
    for p in range(count):
        level = drawn[p] if drawn[p] > 0 else 0.0
        level = min(full, level)
        off = abs(level - value[p])
        rest[p] = off
        worst = max(worst, off)
        total += off * off
    return worst, total


@njit(cache=True, error_model="numpy")
def lawson_fits(
    sets: PointSets, values: Floats, order: int, full: float, largest: bool, rounds: int
) -> tuple[Floats, Floats, Floats]:
    """
    The best of Lawson's rounds for every triangle and channel: weights grow where the difference is large.

    Parameters
    ----------
    sets : PointSets
    values : (channels, m) float64
    order : int
    full : float
      Largest value of the output; samples, and what they draw, are clamped to it.
    largest : bool
      The measure is the largest difference, else the mean square.
    rounds : int

    Returns
    -------
    samples : (n, channels, 6) float64
    largest, square : (n, channels) float64
    """
    count, channels, size, room = len(sets.number), len(values), SIZES[order], sets.number.max()
    samples = np.zeros((count, channels, 6))
    most, square = np.full((count, channels), np.inf), np.full((count, channels), np.inf)
    matrix, tried, width = np.empty((size, size)), np.empty(size), padded(room)
    shapes, scratch = np.empty((ALL_SHAPES, width)), np.empty((5, width))
    for index in range(count):
        number, at = sets.number[index], sets.at[index]
        wide = padded(number)
        shape_rows(sets.points, sets.begin[index], number, shapes)
        shape, weights, value = shapes[SHAPE_ROWS[order] :], scratch[0, :wide], scratch[4, :wide]
        value[number:] = 0.0
        for channel in range(channels):
            value[:number] = values[channel, at : at + number]
            weights[:number], weights[number:] = 1.0, 0.0
            for _ in range(rounds):
                one_fit(shape, size, value, weights, scratch[1], matrix, tried)
                worst, total = _measured(shape, tried, value, full, scratch[2], scratch[3])
                better = worst < most[index, channel] if largest else total / number < square[index, channel]
                if better:
                    most[index, channel], square[index, channel] = worst, total / number
                    samples[index, channel, :size] = tried
                reweighted(weights, scratch[3], worst)
    return samples, most, square
