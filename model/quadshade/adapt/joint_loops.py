# SPDX-License-Identifier: Apache-2.0
"""Cosines of one triangle fitted together: what counts is the colour that they make."""

from __future__ import annotations

import numpy as np
from numba import njit

from quadshade.adapt.cosine_loops import CosineKind
from quadshade.adapt.polynomial_loops import solve
from quadshade.contract.arrays import Floats, Int, Ints
from quadshade.shading.phong_loops import power
from quadshade.shading.point_sets import PointSets

DAMPING = 1e-6
"""Of the mean diagonal; ten times as much after a step that made the error worse."""


@njit(cache=True, error_model="numpy")
def fit_together(
    kind: CosineKind,
    sets: PointSets,
    orders: Ints,
    samples: Floats,
    true: Floats,
    rounds: Int,
) -> Floats:
    """
    Steps of Gauss and Newton, with Lawson's weights, from samples to those of a smaller largest error.

    Parameters
    ----------
    kind : CosineKind
    sets : PointSets
    orders : (n, channels) int64
      Diffuse channels first.
    samples : (n, channels, 6) float64
      Cosines; overwritten with the best.
    true : (3, m) float64
      Colours in output units.
    rounds : int

    Returns
    -------
    (n,) float64
      The largest difference at the points.
    """
    ambient, diffuse, specular, full = kind.ambient, kind.diffuse, kind.specular, kind.full
    count, most_places = len(sets.number), sets.number.max()
    lights = len(diffuse)
    channels = 2 * lights
    out = np.empty(count)
    sizes = np.empty(channels, np.int64)
    shape = np.empty((3, most_places, 6))
    matrix, right = np.empty((6 * channels, 6 * channels)), np.empty(6 * channels)
    row = np.empty(6 * channels)
    weights, rest = np.empty((most_places, 3)), np.empty((most_places, 3))
    slopes = np.empty((most_places, 3, channels))
    now = np.empty((channels, 6))
    for index in range(count):
        unknowns, places, begin, at = 0, sets.number[index], sets.begin[index], sets.at[index]
        for channel in range(channels):
            order = orders[index, channel]
            sizes[channel] = 1 if order == 0 else 3 if order == 1 else 6
            unknowns += sizes[channel]
        for p in range(places):
            a, b, c = sets.points[begin + p, 0], sets.points[begin + p, 1], sets.points[begin + p, 2]
            shape[0, p, 0] = 1.0
            shape[1, p, 0], shape[1, p, 1], shape[1, p, 2] = a, b, c
            shape[2, p, 0], shape[2, p, 1], shape[2, p, 2] = a * (2 * a - 1), b * (2 * b - 1), c * (2 * c - 1)
            shape[2, p, 3], shape[2, p, 4], shape[2, p, 5] = 4 * a * b, 4 * a * c, 4 * b * c
            for colour in range(3):
                weights[p, colour] = 1.0
        now[:] = samples[index]
        best = np.inf
        damping = DAMPING
        for step in range(rounds):
            most = 0.0
            for p in range(places):
                for colour in range(3):
                    level = ambient[colour]
                    for light in range(lights):
                        d, s = 0.0, 0.0
                        for i in range(sizes[light]):
                            d += now[light, i] * shape[orders[index, light], p, i]
                        for i in range(sizes[lights + light]):
                            s += now[lights + light, i] * shape[orders[index, lights + light], p, i]
                        slopes[p, colour, light] = 0.0
                        slopes[p, colour, lights + light] = 0.0
                        if d > 0:
                            inside = min(max(s, 0.0), 1.0)
                            raised = power(inside, kind.exponent, kind.whole)
                            level += d * diffuse[light, colour] + raised * specular[light, colour]
                            slopes[p, colour, light] = diffuse[light, colour]
                            if inside > 1e-6:
                                slopes[p, colour, lights + light] = (
                                    specular[light, colour] * kind.exponent * raised / inside
                                )
                    off = min(max(level, 0.0), full) - true[colour, at + p]
                    rest[p, colour] = off
                    if level > full and true[colour, at + p] >= full - 1e-9:
                        for channel in range(channels):
                            slopes[p, colour, channel] = 0.0
                    most = max(most, abs(off))
            if most < best:
                best = most
                samples[index] = now
            elif step:
                damping = min(damping * 10, 1.0)
            if step == rounds - 1 or best < 1e-3:
                break
            total = 0.0
            for p in range(places):
                for colour in range(3):
                    weights[p, colour] *= abs(rest[p, colour]) / max(most, 1e-12) + 1e-2
                    total += weights[p, colour]
            matrix[:unknowns, :unknowns] = 0.0
            right[:unknowns] = 0.0
            for p in range(places):
                for colour in range(3):
                    weights[p, colour] /= max(total, 1e-300)
                    weight = weights[p, colour]
                    first = 0
                    for channel in range(channels):
                        for i in range(sizes[channel]):
                            row[first + i] = slopes[p, colour, channel] * shape[orders[index, channel], p, i]
                        first += sizes[channel]
                    for i in range(unknowns):
                        part = weight * row[i]
                        right[i] -= part * rest[p, colour]
                        for j in range(i + 1):
                            matrix[i, j] += part * row[j]
            trace = 0.0
            for i in range(unknowns):
                trace += matrix[i, i]
            if not trace > 0:
                break
            for i in range(unknowns):
                matrix[i, i] += damping * trace / unknowns
            solve(matrix, right, unknowns)
            first = 0
            for channel in range(channels):
                for i in range(sizes[channel]):
                    now[channel, i] = min(max(now[channel, i] + right[first + i], -1.0), 1.0)
                first += sizes[channel]
        out[index] = best
    return out
