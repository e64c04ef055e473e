# SPDX-License-Identifier: Apache-2.0
"""Least squares whose places count differently: the peaks of the error are lowered by what they weigh."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from scipy import sparse

from quadshade.contract.arrays import Floats, Ints
from quadshade.fit.elements import Elements
from quadshade.fit.places import Places
from quadshade.fit.solve import TOLERANCE, Solution, least_squares, normal_equations, smooth_squares

ROUNDS = 16
"""Of weighting the largest errors more, ``minimax``."""
FLOOR = 0.02
"""Weight that a place without error keeps in a round."""

GENTLE_ROUNDS = 1
"""Of lowering the peaks of least squares."""
GENTLE = 4
"""Power of the error that is added to a weight there: at the peak it doubles."""
ROUGHLY = 0.1
"""Tolerance of these rounds, of what the new weights leave."""
AT_MOST = 1.0025
"""What the squared error may grow by for it: a hundredth of a decibel."""


@dataclass(frozen=True)
class Weighted:
    """
    What is fitted, whatever the places weigh.

    Attributes
    ----------
    elements : Elements
    places : Places
    target : (p, c) float64
    beyond : (n,) float64
      Weight of each of a triangle's six points: it holds what no place sees near them.
    lowest, largest : float
      The range of values.
    """

    elements: Elements
    places: Places
    target: Floats
    beyond: Floats
    lowest: float
    largest: float

    def solve(self, weight: Floats, begin: Floats | None = None, tolerance: float = TOLERANCE) -> Solution:
        """Values of the least squared error, places (p,) weighted; see :func:`least_squares`."""
        normal = normal_equations(self.elements, self.beyond, self.places, self.target, weight)
        return least_squares(self.elements, normal, self.lowest, self.largest, begin, tolerance)

    def solve_smooth(self, penalty: sparse.csr_array) -> Solution:
        """The same with a penalty on the unknowns, each place by its area; see :func:`smooth_squares`."""
        normal = normal_equations(self.elements, self.beyond, self.places, self.target, self.places.area)
        return smooth_squares(self.elements, normal, self.lowest, self.largest, penalty)

    def drawn(self, values: Floats) -> Floats:
        """(p, c) what values (m, c) are at the places."""
        return _drawn(self.places.triangle, self.places.weights, values[self.elements.index])

    def errors(self, values: Floats) -> Floats:
        """(p,) the error of the channel where it is largest."""
        samples = values[self.elements.index]
        return _errors(self.places.triangle, self.places.weights, samples, self.target)


def smallest_peak(system: Weighted, values: Floats) -> Floats:
    """Lawson's iteration: each round weights a place by its error, and the best round counts."""
    area = system.places.area
    best, least, weight = values, np.inf, area
    for number in range(ROUNDS + 1):
        error = system.errors(values)
        top = error.max(initial=0.0)
        if top < least:
            best, least = values, top
        if number == ROUNDS:
            break
        weight = weight * (FLOOR + error / max(top, 1e-12))
        weight *= area.sum() / weight.sum()
        values = system.solve(weight, begin=values).values
    return best


def lower_peaks(system: Weighted, values: Floats) -> Floats:
    """Least squares with its largest error lowered, as far as that costs next to nothing in the mean."""
    area = weight = system.places.area
    error = system.errors(values)
    most = AT_MOST * float(area @ error**2)
    best, least = values, error.max(initial=0.0)
    for _ in range(GENTLE_ROUNDS):
        weight = _raised(weight, error, GENTLE)
        values = system.solve(weight, begin=values, tolerance=ROUGHLY).values
        error = system.errors(values)
        if float(area @ error**2) > most:
            break
        if error.max(initial=0.0) < least:
            best, least = values, error.max()
    return best


@njit(cache=True)
def _shape(weights: Floats, shape: Floats) -> None:
    """The six shape functions at barycentric coordinates (3,)."""
    one, two, three = weights[0], weights[1], weights[2]
    shape[0], shape[1], shape[2] = one * (2 * one - 1), two * (2 * two - 1), three * (2 * three - 1)
    shape[3], shape[4], shape[5] = 4 * one * two, 4 * one * three, 4 * two * three


@njit(cache=True)
def _errors(triangle: Ints, weights: Floats, samples: Floats, target: Floats) -> Floats:
    """(p,) largest difference of any channel between quadratics (n, 6, c) and their target (p, c)."""
    out, shape = np.zeros(len(triangle)), np.empty(6)
    for place in range(len(triangle)):
        _shape(weights[place], shape)
        own = samples[triangle[place]]
        for channel in range(target.shape[1]):
            value = -target[place, channel]
            for point in range(6):
                value += shape[point] * own[point, channel]
            out[place] = max(out[place], abs(value))
    return out


@njit(cache=True)
def _raised(weight: Floats, error: Floats, power: int) -> Floats:
    """Weights (p,), up to twice as large where errors (p,) are large."""
    out, top = weight.copy(), 1e-12
    for place in range(len(error)):
        top = max(top, error[place])
    for place in range(len(error)):
        share, raised = error[place] / top, 1.0
        for _ in range(power):
            raised *= share
        out[place] *= 1 + raised
    return out


@njit(cache=True)
def _drawn(triangle: Ints, weights: Floats, samples: Floats) -> Floats:
    """(p, c) quadratics through (n, 6, c) samples at places."""
    out = np.zeros((len(triangle), samples.shape[2]))
    shape = np.empty(6)
    for place in range(len(triangle)):
        _shape(weights[place], shape)
        for channel in range(samples.shape[2]):
            for point in range(6):
                out[place, channel] += shape[point] * samples[triangle[place], point, channel]
    return out
