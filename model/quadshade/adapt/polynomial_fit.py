# SPDX-License-Identifier: Apache-2.0
"""Polynomials through or nearest to the shading at points of a triangle, and how far they stay off."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from quadshade.adapt import polynomial_loops
from quadshade.contract.formats import CONSTANT, LINEAR, QUADRATIC
from quadshade.shading.point_sets import PointSets, used_points

DEGREE = 6
EQUALISING = 6
"""Steps towards equal extremes."""
ORDERS = (CONSTANT, LINEAR, QUADRATIC)


def _grid() -> np.ndarray:
    steps = [(i, j, DEGREE - i - j) for i in range(DEGREE, -1, -1) for j in range(DEGREE - i, -1, -1)]
    return np.array(steps) / DEGREE


POINTS = _grid()
"""(28, 3) barycentric coordinates; the vertices and the middles of the edges are among them."""


def shape_functions(points: np.ndarray, order: int) -> np.ndarray:
    """
    What the samples of a channel contribute at points.

    Parameters
    ----------
    points : (..., 3) float
      Barycentric coordinates.
    order : int

    Returns
    -------
    (..., 1, 3 or 6) float64
      For the samples that the order uses: I1, I2, I3, I12, I13, I23 (Abbas et al., section 3).
    """
    if order == CONSTANT:
        return np.ones((*points.shape[:-1], 1))
    if order == LINEAR:
        return points
    first, second, third = np.moveaxis(points, -1, 0)
    middles = np.stack([4 * first * second, 4 * first * third, 4 * second * third], axis=-1)
    return np.concatenate([points * (2 * points - 1), middles], axis=-1)


NODES = [
    [int(np.flatnonzero((abs(POINTS - node) < 1e-9).all(axis=1))[0]) for node in nodes]
    for nodes in (
        np.full((1, 3), 1 / 3),
        np.eye(3),
        np.concatenate([np.eye(3), [[0.5, 0.5, 0], [0.5, 0, 0.5], [0, 0.5, 0.5]]]),
    )
]
"""Points of the grid at which a polynomial of each order is sampled where it is not fitted."""
SHAPES = [shape_functions(POINTS, order) for order in ORDERS]
NEAREST = [np.linalg.pinv(shape) for shape in SHAPES]


@dataclass(frozen=True)
class Fit:
    """
    Polynomials of one order for every triangle and channel.

    Attributes
    ----------
    samples : (n, channels, 6) float64
      What :class:`quadshade.contract.triangles.ScreenTriangles` takes; unused ones are zero.
    largest : (n, channels) float64
      Largest difference at the grid's points.
    square : (n, channels) float64
      Mean square of the differences.
    """

    samples: np.ndarray
    largest: np.ndarray
    square: np.ndarray

    def by(self, measure: str) -> np.ndarray:
        """(n, channels) the error by a measure."""
        return self.largest if measure == "max" else self.square


def _evaluated(samples: np.ndarray, values: np.ndarray, order: int, full: float) -> Fit:
    """The fit that samples are, once brought into the range that the core takes."""
    samples = np.clip(samples, 0, full)
    rest = abs(np.clip(samples @ SHAPES[order].T, 0, full) - values)
    padded = np.zeros((*values.shape[:2], 6))
    padded[..., : samples.shape[2]] = samples
    return Fit(padded, rest.max(axis=2), (rest**2).mean(axis=2))


def fit(values: np.ndarray, order: int, full: float, measure: str) -> Fit:
    """
    The best of three polynomials: through the samples, nearest in the mean, and that moved to equal extremes.

    Parameters
    ----------
    values : (n, channels, 28) float64
      The shading at ``POINTS``, in output units.
    order : int
    full : float
      Largest value of the output.
    measure : str
      ``max`` takes the one whose largest difference is least, ``rms`` the one whose mean square is.

    Returns
    -------
    Fit
    """
    nearest = values @ NEAREST[order].T
    rest = values - nearest @ SHAPES[order].T
    moved = nearest + (rest.max(axis=2, keepdims=True) + rest.min(axis=2, keepdims=True)) / 2
    best = _evaluated(values[..., NODES[order]], values, order, full)
    for samples in (nearest, moved):
        best = better_fit(best, _evaluated(samples, values, order, full), measure)
    return best


def fit_at(
    points: np.ndarray, used: np.ndarray, values: np.ndarray, order: int, full: float, measure: str
) -> Fit:
    """
    As :func:`fit`, at other points in each triangle.

    Parameters
    ----------
    points : (1 or n, p, 3) float
      Barycentric coordinates.
    used : (1 or n, p) bool
      Which of them count, at least one.
    values : (n, channels, p) float64
    order, full, measure
      As for :func:`fit`.

    Returns
    -------
    Fit
    """
    used = np.broadcast_to(used, (len(values), used.shape[1]))
    values = np.ascontiguousarray(values.transpose(1, 0, 2)[:, used])
    return fit_sets(used_points(points, used), values, order, full, measure)


def fit_sets(sets: PointSets, values: np.ndarray, order: int, full: float, measure: str) -> Fit:
    """As :func:`fit_at`, with (channels, m) values."""
    if not len(sets.number):
        nothing = np.empty((0, len(values)))
        return Fit(np.empty((*nothing.shape, 6)), nothing, nothing)
    largest = measure == "max"
    rounds = 1 + EQUALISING * largest
    return Fit(*polynomial_loops.lawson_fits(sets, values, order, full, largest, rounds))


def better_fit(best: Fit, tried: Fit, measure: str) -> Fit:
    """Of two fits the better, for each triangle and channel."""
    better = tried.by(measure) < best.by(measure)
    return Fit(
        np.where(better[..., None], tried.samples, best.samples),
        np.where(better, tried.largest, best.largest),
        np.where(better, tried.square, best.square),
    )


def _halves() -> list[list[np.ndarray]]:
    """Indices of the grid's points in the two halves of a triangle whose edge 0-1, 1-2 or 2-0 is split."""
    halves = []
    for one, other in ((0, 1), (1, 2), (2, 0)):
        ahead = POINTS[:, one] - POINTS[:, other]
        halves.append([np.flatnonzero(side * ahead >= -1e-9) for side in (1, -1)])
    return halves


def _left_over(shape: np.ndarray) -> np.ndarray:
    """(k, k) what remains of values at k points when the nearest polynomial is taken away."""
    return np.eye(len(shape)) - shape @ np.linalg.pinv(shape)


HALVES = _halves()
HALF_COUNTS = np.array([len(points) for pair in HALVES for points in pair])
HALF_POINTS = np.zeros((len(HALF_COUNTS), len(POINTS)), dtype=np.int64)
"""The same as an array, the first ``HALF_COUNTS`` of each row."""
for _row, _points in zip(HALF_POINTS, [points for pair in HALVES for points in pair], strict=True):
    _row[: len(_points)] = _points
LEFT_OVER = [[[_left_over(shape[points]) for points in pair] for pair in HALVES] for shape in SHAPES]


def split_errors(values: np.ndarray, order: int, measure: str) -> np.ndarray:
    """
    What is left when a triangle is halved and each half fitted, from the samples of the whole.

    Parameters
    ----------
    values : (n, channels, 28) float64
    order : int
    measure : str
      ``max``: half the range of the differences; ``rms``: their mean square.

    Returns
    -------
    (n, 3, 2, channels) float64
      For each split edge (0-1, 1-2, 2-0) and half.
    """
    out = np.empty((len(values), 3, 2, values.shape[1]))
    for edge, halves in enumerate(HALVES):
        for half, points in enumerate(halves):
            rest = values[..., points] @ LEFT_OVER[order][edge][half]
            if measure == "max":
                out[:, edge, half] = (rest.max(axis=2) - rest.min(axis=2)) / 2
            else:
                out[:, edge, half] = np.einsum("nck,nck->nc", rest, rest) / len(points)
    return out


def bend(samples: np.ndarray) -> np.ndarray:
    """
    Bound of how far a quadratic lies from the plane through its vertices.

    The difference is 4 (m12 l1 l2 + m13 l1 l3 + m23 l2 l3) with barycentric l and m the deviation of an
    edge's middle from the mean of its ends (an eighth of the second difference along the edge): at most 4/3
    of the largest m, which it is at the centre where all three are equal.

    Parameters
    ----------
    samples : (..., 6) float

    Returns
    -------
    (...) float64
    """
    first, second, third = np.moveaxis(samples[..., :3], -1, 0)
    means = np.stack([first + second, first + third, second + third], axis=-1) / 2
    return 4 / 3 * abs(samples[..., 3:] - means).max(axis=-1)
