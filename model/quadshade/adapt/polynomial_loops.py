# SPDX-License-Identifier: Apache-2.0
"""Weighted fits of polynomials in compiled loops."""

from __future__ import annotations

import numpy as np
from numba import njit

from quadshade.contract.arrays import Bools, Floats, Int

RIDGE = 1e-10


@njit(cache=True, error_model="numpy", forceinline=True)
def solve(matrix: Floats, right: Floats, size: Int) -> None:
    """Solve a positive definite system of the first ``size`` unknowns in place (Cholesky)."""
    for row in range(size):
        for column in range(row + 1):
            total = matrix[row, column]
            for k in range(column):
                total -= matrix[row, k] * matrix[column, k]
            matrix[row, column] = np.sqrt(total) if row == column else total / matrix[column, column]
        total = right[row]
        for k in range(row):
            total -= matrix[row, k] * right[k]
        right[row] = total / matrix[row, row]
    for row in range(size - 1, -1, -1):
        total = right[row]
        for k in range(row + 1, size):
            total -= matrix[k, row] * right[k]
        right[row] = total / matrix[row, row]


@njit(cache=True, error_model="numpy", forceinline=True)
def one_fit(shape: Floats, row: Int, value: Floats, weight: Floats, matrix: Floats, out: Floats) -> None:
    """One weighted fit: ``out`` (m,) of (p,) values and weights, with shape[row] (p, m)."""
    places, size = shape.shape[1], shape.shape[2]
    total = mean = 0.0
    for p in range(places):
        total += weight[p]
        mean += weight[p] * value[p]
    mean /= total
    if size == 1:
        out[0] = mean
        return
    for i in range(size):
        out[i] = 0.0
        for j in range(i + 1):
            matrix[i, j] = 0.0
    for p in range(places):
        if weight[p] == 0:
            continue
        rest = value[p] - mean
        for i in range(size):
            part = weight[p] * shape[row, p, i]
            out[i] += part * rest
            for j in range(i + 1):
                matrix[i, j] += part * shape[row, p, j]
    trace = 0.0
    for i in range(size):
        trace += matrix[i, i]
    for i in range(size):
        # Shape functions sum to 1, so what this pulls to zero is the distance from the mean.
        matrix[i, i] += RIDGE * trace
    solve(matrix, out, size)
    for i in range(size):
        out[i] += mean


@njit(cache=True, error_model="numpy")
def weighted_fit(shape: Floats, values: Floats, weights: Floats) -> Floats:
    """(n, channels, m) samples; see :func:`quadshade.adapt.polynomial_fit.weighted_fit`."""
    count, channels = values.shape[:2]
    size = shape.shape[2]
    matrix, out = np.empty((size, size)), np.empty((count, channels, size))
    for index in range(count):
        row = index if len(shape) > 1 else 0
        for channel in range(channels):
            one_fit(shape, row, values[index, channel], weights[index, channel], matrix, out[index, channel])
    return out


@njit(cache=True, error_model="numpy")
def lawson_fits(
    shape: Floats, values: Floats, used: Bools, full: float, largest: bool, rounds: int
) -> tuple[Floats, Floats, Floats]:
    """
    The best of Lawson's rounds for every triangle and channel: weights grow where the difference is large.

    Parameters
    ----------
    shape : (1 or n, p, m) float64
    values : (n, channels, p) float64
    used : (1 or n, p) bool
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
    count, channels, places = values.shape
    size = shape.shape[2]
    samples = np.zeros((count, channels, 6))
    most, square = np.full((count, channels), np.inf), np.full((count, channels), np.inf)
    matrix, tried = np.empty((size, size)), np.empty(size)
    weights, rest = np.empty(places), np.empty(places)
    for index in range(count):
        row, mine = index if len(shape) > 1 else 0, index if len(used) > 1 else 0
        for channel in range(channels):
            value = values[index, channel]
            number = 0
            for p in range(places):
                weights[p] = 1.0 if used[mine, p] else 0.0
                number += used[mine, p]
            for _ in range(rounds):
                one_fit(shape, row, value, weights, matrix, tried)
                worst = total = 0.0
                for i in range(size):
                    tried[i] = min(max(tried[i], 0.0), full)
                for p in range(places):
                    level = 0.0
                    for i in range(size):
                        level += tried[i] * shape[row, p, i]
                    rest[p] = abs(min(max(level, 0.0), full) - value[p]) if used[mine, p] else 0.0
                    worst = max(worst, rest[p])
                    total += rest[p] * rest[p]
                better = worst < most[index, channel] if largest else total / number < square[index, channel]
                if better:
                    most[index, channel], square[index, channel] = worst, total / number
                    for i in range(size):
                        samples[index, channel, i] = tried[i]
                weight = 0.0
                for p in range(places):
                    weights[p] *= rest[p] / max(worst, 1e-12) + 1e-3
                    weight += weights[p]
                for p in range(places):
                    weights[p] /= max(weight, 1e-300)
    return samples, most, square
