# SPDX-License-Identifier: Apache-2.0
"""Weighted fits of cosines in compiled loops, and what they leave in the colour."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from quadshade.adapt.polynomial_loops import one_fit
from quadshade.contract.arrays import Bools, Floats, Int, Ints
from quadshade.shading.phong_loops import power

FAINT = 1e-4
"""Weight of a point without specular light."""


class CosineKind(NamedTuple):
    """
    How a cosine that is drawn differs from the one that it should be.

    Attributes
    ----------
    specular : bool
      It is raised to a power; else it counts where it is positive.
    exponent : float
    whole : int
      The exponent where it is an integer, else -1.
    largest : bool
      The measure is ``max``, else the mean square.
    secants, equalising : int
      Repetitions.
    """

    specular: bool
    exponent: float
    whole: int
    largest: bool
    secants: int
    equalising: int


@njit(cache=True, error_model="numpy", forceinline=True)
def _measured(
    kind: CosineKind,
    shape: Floats,
    row: Int,
    samples: Floats,
    value: Floats,
    extra: Floats,
    raised: Floats,
    used: Bools,
    scale: float,
    drawn: Floats,
    rest: Floats,
) -> tuple[float, float]:
    """
    Clamp samples; write what they draw and leave at each place; return the largest and the mean square.

    ``extra`` is the specular term of a diffuse cosine's light, or 1 where a specular one is lit; ``raised``
    the power of ``value``.
    """
    places, size = shape.shape[1], shape.shape[2]
    for i in range(size):
        samples[i] = min(max(samples[i], -1.0), 1.0)
    largest = total = 0.0
    count = 0
    for p in range(places):
        cosine = 0.0
        for i in range(size):
            cosine += samples[i] * shape[row, p, i]
        drawn[p] = cosine
        off = 0.0
        if used[p]:
            if kind.specular:
                if extra[p] != 0:
                    shine = power(min(max(cosine, 0.0), 1.0), kind.exponent, kind.whole)
                    off = abs(shine - raised[p]) * scale
            else:
                off = abs(max(cosine, 0.0) - max(value[p], 0.0)) * scale
                if (cosine > 0) != (value[p] > 0):
                    off += extra[p]
            count += 1
            total += off * off
            largest = max(largest, off)
        rest[p] = off
    return largest, total / max(count, 1)


@njit(cache=True, error_model="numpy")
def best_cosines(
    kind: CosineKind,
    shape: Floats,
    value: Floats,
    weight: Floats,
    used: Bools,
    extra: Floats,
    scale: Floats,
    others: Floats,
) -> tuple[Floats, Floats, Floats]:
    """
    The best of several polynomials for every triangle and light.

    Parameters
    ----------
    kind : CosineKind
    shape : (1 or n, p, m) float64
    value, weight, extra : (n, lights, p) float64
    used : (n, lights, p) bool
    scale : (lights,) float64
      Output units for a full value.
    others : (k, n, lights, m) float64
      Samples that are tried before the weighted fits.

    Returns
    -------
    samples : (n, lights, 6) float64
    largest, square : (n, lights) float64
    """
    count, lights, places = value.shape
    size = shape.shape[2]
    samples = np.zeros((count, lights, 6))
    largest, square = np.empty((count, lights)), np.empty((count, lights))
    matrix, tried = np.empty((size, size)), np.empty(size)
    weights, drawn, rest, raised = np.empty(places), np.empty(places), np.empty(places), np.empty(places)
    for index in range(count):
        row = index if len(shape) > 1 else 0
        for light in range(lights):
            here, mine = value[index, light], used[index, light]
            lit, full = extra[index, light], scale[light]
            for p in range(places):
                weights[p] = 1.0 if mine[p] else 0.0
                raised[p] = 0.0
                if kind.specular:
                    raised[p] = power(min(max(here[p], 0.0), 1.0), kind.exponent, kind.whole)
            best = np.inf
            steps = 1 + len(others) + 1 + (kind.secants if kind.specular else 0)
            if kind.largest and size > 1:
                steps += kind.equalising
            reweighted = 2 + len(others) + (kind.secants if kind.specular else 0)
            for step in range(steps):
                if 1 <= step <= len(others):
                    for i in range(size):
                        tried[i] = others[step - 1, index, light, i]
                else:
                    if step == 1 + len(others):
                        for p in range(places):
                            weights[p] = weight[index, light, p]
                    elif step >= reweighted:
                        most, total = 1e-12, 0.0
                        for p in range(places):
                            most = max(most, rest[p])
                        for p in range(places):
                            weights[p] *= rest[p] / most + 1e-3
                            total += weights[p]
                        for p in range(places):
                            weights[p] /= max(total, 1e-300)
                    elif step > 1 + len(others):
                        for p in range(places):
                            apart = abs(drawn[p] - here[p])
                            slope = weight[index, light, p] * kind.exponent
                            if apart > 1e-9:
                                shine = power(min(max(drawn[p], 0.0), 1.0), kind.exponent, kind.whole)
                                slope = abs(shine - raised[p]) / apart
                            lowest = lit[p] * slope / kind.exponent + FAINT
                            weights[p] = lowest if mine[p] else 0.0
                    one_fit(shape, row, here, weights, matrix, tried)
                most_off, mean_square = _measured(
                    kind, shape, row, tried, here, lit, raised, mine, full, drawn, rest
                )
                score = most_off if kind.largest else mean_square
                if score < best or step == 0:
                    best = score
                    largest[index, light], square[index, light] = most_off, mean_square
                    for i in range(size):
                        samples[index, light, i] = tried[i]
    return samples, largest, square


@njit(cache=True, error_model="numpy")
def half_cosines(
    kind: CosineKind,
    shape: Floats,
    value: Floats,
    weight: Floats,
    used: Bools,
    extra: Floats,
    scale: Floats,
    halves: Ints,
    counts: Ints,
) -> tuple[Floats, Floats]:
    """
    What the nearest polynomials to parts of the points leave.

    Parameters
    ----------
    kind, value, weight, used, extra, scale
      As for :func:`best_cosines`.
    shape : (p, m) float64
    halves : (k, p) int64
      Points of each part, the first ``counts`` of a row.
    counts : (k,) int64

    Returns
    -------
    largest, square : (n, k, lights) float64
    """
    count, lights = value.shape[:2]
    size = shape.shape[1]
    largest, square = np.empty((count, len(halves), lights)), np.empty((count, len(halves), lights))
    matrix, tried = np.empty((size, size)), np.empty(size)
    for half in range(len(halves)):
        number = counts[half]
        part = np.empty((1, number, size))
        for p in range(number):
            part[0, p] = shape[halves[half, p]]
        mine = np.empty(number, np.bool_)
        here, weights, lit, raised, drawn, rest = np.empty((6, number))
        for index in range(count):
            for light in range(lights):
                for p in range(number):
                    at = halves[half, p]
                    here[p], weights[p] = value[index, light, at], weight[index, light, at]
                    lit[p], mine[p] = extra[index, light, at], used[index, light, at]
                    raised[p] = 0.0
                    if kind.specular:
                        raised[p] = power(min(max(here[p], 0.0), 1.0), kind.exponent, kind.whole)
                one_fit(part, 0, here, weights, matrix, tried)
                largest[index, half, light], square[index, half, light] = _measured(
                    kind, part, 0, tried, here, lit, raised, mine, scale[light], drawn, rest
                )
    return largest, square


@njit(cache=True, error_model="numpy")
def joint_errors(
    kind: CosineKind,
    facing: Floats,
    towards: Floats,
    options: Ints,
    true: Floats,
    used: Bools,
    ambient: Floats,
    diffuse: Floats,
    specular: Floats,
    full: float,
) -> Floats:
    """
    How far colours are off with each option.

    Parameters
    ----------
    kind : CosineKind
      Of the specular cosines.
    facing, towards : (n, lights, orders, p) float64
      Diffuse and specular cosines as each order draws them.
    options : (n, k, channels) int64
      Diffuse channels first.
    true : (n, p, 3) float64
    used : (1 or n, p) bool
    ambient, diffuse, specular : (3,), (lights, 3) and (lights, 3) float64
      Output units.
    full : float

    Returns
    -------
    (n, k) float64
    """
    count, lights, orders, places = facing.shape
    out = np.empty(options.shape[:2])
    shine = np.empty((lights, orders, places))
    for index in range(count):
        row = index if len(used) > 1 else 0
        for light in range(lights):
            for order in range(orders):
                for p in range(places):
                    cosine = min(max(towards[index, light, order, p], 0.0), 1.0)
                    shine[light, order, p] = power(cosine, kind.exponent, kind.whole)
        for option in range(options.shape[1]):
            largest = total = 0.0
            number = 0
            for p in range(places):
                if not used[row, p]:
                    continue
                number += 1
                for colour in range(3):
                    level = ambient[colour]
                    for light in range(lights):
                        cosine = facing[index, light, options[index, option, light], p]
                        if cosine > 0:
                            level += cosine * diffuse[light, colour]
                            raised = shine[light, options[index, option, lights + light], p]
                            level += raised * specular[light, colour]
                    off = abs(min(max(level, 0.0), full) - true[index, p, colour])
                    largest = max(largest, off)
                    total += off * off
            out[index, option] = largest if kind.largest else total / number
    return out
