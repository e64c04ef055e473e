# SPDX-License-Identifier: Apache-2.0
"""
The values for which the weighted squared error is least: normal equations, by conjugate gradients.

The matrix is symmetric and positive definite; it is kept as a block of 6 x 6 numbers a triangle, of
which half are sent through the memory. The steps begin at the six points and are scaled by the diagonal.
Over a triangle's area such a matrix is well conditioned whatever the mesh: some ten steps do. With a weight
on jumps it is not, and is factorised.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from scipy import sparse
from scipy.sparse.linalg import splu

from quadshade.contract.arrays import Bools, Floats, Ints
from quadshade.fit.elements import Elements
from quadshade.fit.places import Places

HALF = 21
"""Numbers on and below the diagonal of a block."""
FULL = np.array([[max(i, j) * (max(i, j) + 1) // 2 + min(i, j) for j in range(6)] for i in range(6)])
"""(6, 6) where each number of a block stands among these: row by row."""
HOLD = 1e-3
"""Pixels that speak for a six-point value: what no place sees stays as it was sampled."""

TOLERANCE = 3e-2
"""Of the residual that the six points leave: with a third of it the mean error is less by 1e-4 of itself."""
CLOSELY = 1e-4
"""The same where the steps stand for factors: what is badly conditioned changes slowly."""
MOST_STEPS = 2000
MOST_FACTORISED = 400_000
"""Unknowns of a system that is factorised; a larger one is solved by steps, in memory that grows with it."""
ROUNDS = 8
"""Of holding what leaves the range."""


@dataclass(frozen=True)
class Normal:
    """
    Normal equations, before neighbours' shares are added up.

    Attributes
    ----------
    half : (n, 21) float64
      Of each triangle: its samples' shape functions with each other, over its places, as :data:`FULL` says.
    right : (n, 6, c) float64
      Of each triangle: shape functions with the targets.
    """

    half: Floats
    right: Floats

    @property
    def block(self) -> Floats:
        """(n, 6, 6) float64 the same, both halves."""
        return self.half[:, FULL]


@dataclass(frozen=True)
class Solution:
    """
    Values, and whether the steps came to their end.

    Attributes
    ----------
    values : (m, c) float64
    ended : bool
      Else they are the best after ``MOST_STEPS``, which is no worse than where the steps began.
    """

    values: Floats
    ended: bool


class System(NamedTuple):
    """
    A symmetric matrix: blocks of triangles (n, 21) at unknowns (n, 6), a sparse one, and a diagonal.

    Attributes
    ----------
    half, unknown : (n, 21) float64, (n, 6) int64
    starts, columns, entries
      Rows of the sparse matrix, as in SciPy's CSR; none where ``starts`` is [0].
    hold : float
      On the diagonal.
    """

    half: Floats
    unknown: Ints
    starts: Ints
    columns: Ints
    entries: Floats
    hold: float


def _system(half: Floats, unknown: Ints, matrix: sparse.csr_array | None, hold: float) -> System:
    """Blocks, and a sparse matrix if there is one."""
    if matrix is None:
        return System(half, unknown, np.zeros(1, np.int64), np.zeros(0, np.int64), np.zeros(0), hold)
    starts, columns = matrix.indptr.astype(np.int64), matrix.indices.astype(np.int64)
    return System(half, unknown, starts, columns, matrix.data, hold)


def normal_equations(
    elements: Elements, beyond: Floats, places: Places, target: Floats, weight: Floats
) -> Normal:
    """
    Sum over places, triangle by triangle.

    Parameters
    ----------
    elements : Elements
    beyond : (n,) float64
      Weight of each of a triangle's six points.
    places : Places
    target : (p, c) float64
    weight : (p,) float64
      Of each place's squared error.

    Returns
    -------
    Normal
    """
    count = len(elements.index)
    half, right = np.zeros((count, HALF)), np.zeros((count, 6, target.shape[1]))
    _add_six(elements.index, elements.start, beyond, half, right)
    _add_up(places.triangle, places.weights, target, weight, half, right)
    return Normal(half, right)


def least_squares(
    elements: Elements,
    normal: Normal,
    lowest: float,
    largest: float,
    begin: Floats | None = None,
    tolerance: float = TOLERANCE,
) -> Solution:
    """
    Solve for the unknowns, by steps.

    Parameters
    ----------
    elements : Elements
    normal : Normal
    lowest, largest : float
      No value is outside. A clamped solution would be no least one: its neighbours have counted on the value
      that it lost. So what leaves the range is held at its border, and the others are solved for again.
    begin : (m, c) float64, optional
      Where the steps begin; by default the six points.
    tolerance : float
      Of the residual there.

    Returns
    -------
    Solution
    """
    start, index = elements.start, elements.index
    diagonal = np.full(len(start), HOLD)
    _scatter(index, normal.half[:, FULL.diagonal(), None], diagonal[:, None])
    system = _system(normal.half, index, None, HOLD)
    goal = np.ascontiguousarray(_right_side(elements, normal).T)
    values = np.ascontiguousarray(np.clip(start if begin is None else begin, lowest, largest).T)
    free, ended = np.ones(values.shape, dtype=bool), True
    for _ in range(ROUNDS):
        solved = values.copy()
        ended = bool(_steps(system, diagonal, goal, free, solved, tolerance, MOST_STEPS))
        values = np.clip(solved, lowest, largest)
        outside = free & (values != solved)
        if not outside.any():
            break
        free &= ~outside
    # Numbers that are none leave the six points.
    return Solution(np.where(np.isfinite(values.T), values.T, start), ended)


def smooth_squares(
    elements: Elements, normal: Normal, lowest: float, largest: float, penalty: sparse.csr_array
) -> Solution:
    """
    Solve for the unknowns with a penalty (m, m), a quadratic form of them that is to be small as well.

    The other arguments are those of :func:`least_squares`, whose range is kept in the same way.
    """
    start, index = elements.start, elements.index
    rows, columns = np.broadcast_arrays(index[:, :, None], index[:, None, :])
    entries = normal.block.reshape(-1), (rows.reshape(-1), columns.reshape(-1))
    squares = sparse.coo_array(entries, shape=penalty.shape).tocsr()
    matrix = sparse.csr_array(squares + penalty + HOLD * sparse.eye_array(len(start)))
    right = _right_side(elements, normal)
    found = solved_directly(matrix, right, start)
    values = np.where(np.isfinite(found.values), found.values, start)
    return Solution(np.clip(values, lowest, largest), found.ended)


def _right_side(elements: Elements, normal: Normal) -> Floats:
    """(m, c) of the normal equations, neighbours' shares added up."""
    right = HOLD * elements.start
    _scatter(elements.index, normal.right, right)
    return right


def solved_directly(matrix: sparse.csr_array, right: Floats, begin: Floats) -> Solution:
    """
    Solve a sparse, symmetric, positive definite system of any condition; unknowns that nothing asks for stay.

    Parameters
    ----------
    matrix : (m, m) sparse
    right, begin : (m, c) float64

    Returns
    -------
    Solution
    """
    idle = matrix.diagonal() <= 0
    full = sparse.csr_array(matrix + sparse.diags_array(idle.astype(np.float64)))
    goal = np.where(idle[:, None], begin, right)
    if len(begin) <= MOST_FACTORISED:
        try:
            factors = splu(
                sparse.csc_array(full),
                permc_spec="MMD_AT_PLUS_A",
                diag_pivot_thresh=0.0,
                options={"SymmetricMode": True},
            )
            values = factors.solve(goal)
            if np.isfinite(values).all():
                return Solution(values, True)
        except (RuntimeError, MemoryError):
            # What rounding has made singular has many solutions: the steps go to one of them.
            pass
    system = _system(np.zeros((0, HALF)), np.zeros((0, 6), np.int64), full, 0.0)
    steps = np.ascontiguousarray(begin.T)
    free = np.ones(steps.shape, dtype=bool)
    aim = np.ascontiguousarray(goal.T)
    ended = bool(_steps(system, full.diagonal(), aim, free, steps, CLOSELY, MOST_STEPS))
    return Solution(steps.T, ended)


@njit(cache=True)
def _add_six(index: Ints, start: Floats, beyond: Floats, half: Floats, right: Floats) -> None:
    """Let triangles' six points count."""
    for triangle in range(len(index)):
        for row in range(6):
            half[triangle, FULL[row, row]] += beyond[triangle]
            for channel in range(start.shape[1]):
                right[triangle, row, channel] += beyond[triangle] * start[index[triangle, row], channel]


@njit(cache=True)
def _add_up(
    triangle: Ints, weights: Floats, target: Floats, weight: Floats, half: Floats, right: Floats
) -> None:
    """Add every place to the block and the right side of its triangle."""
    shape = np.empty(6)
    channels = target.shape[1]
    for place in range(len(triangle)):
        owner, share = triangle[place], weight[place]
        one, two, three = weights[place, 0], weights[place, 1], weights[place, 2]
        shape[0], shape[1], shape[2] = one * (2 * one - 1), two * (2 * two - 1), three * (2 * three - 1)
        shape[3], shape[4], shape[5] = 4 * one * two, 4 * one * three, 4 * two * three
        for row in range(6):
            here = share * shape[row]
            for column in range(row + 1):
                half[owner, FULL[row, column]] += here * shape[column]
            for channel in range(channels):
                right[owner, row, channel] += here * target[place, channel]


@njit(cache=True)
def _scatter(index: Ints, local: Floats, out: Floats) -> None:
    """Add what triangles have (n, 6, c) to their unknowns (m, c)."""
    for triangle in range(len(index)):
        for row in range(6):
            for channel in range(out.shape[1]):
                out[index[triangle, row], channel] += local[triangle, row, channel]


@njit(cache=True)
def _times(system: System, vectors: Floats, out: Floats) -> None:
    """The matrix times vectors (c, m)."""
    half, index, starts, columns, entries, hold = system
    for channel in range(len(vectors)):
        for row in range(vectors.shape[1]):
            out[channel, row] = hold * vectors[channel, row]
        for row in range(len(starts) - 1):
            for at in range(starts[row], starts[row + 1]):
                out[channel, row] += entries[at] * vectors[channel, columns[at]]
    # A block is read once for all channels: it is the memory that takes the time.
    for triangle in range(len(index)):
        own, b = index[triangle], half[triangle]
        for channel in range(len(vectors)):
            v, o = vectors[channel], out[channel]
            one, two, three = v[own[0]], v[own[1]], v[own[2]]
            four, five, six = v[own[3]], v[own[4]], v[own[5]]
            for row in range(6):
                at = FULL[row]
                total = b[at[0]] * one + b[at[1]] * two + b[at[2]] * three
                o[own[row]] += total + b[at[3]] * four + b[at[4]] * five + b[at[5]] * six


@njit(cache=True, fastmath={"contract", "reassoc"})
def _steps(
    system: System,
    diagonal: Floats,
    right: Floats,
    free: Bools,
    values: Floats,
    tolerance: float,
    most: int,
) -> bool:
    """
    Conjugate gradients for channels (c, m), in place; what is not free stays. Whether they came to an end.

    Hestenes and Stiefel (1952), scaled by the diagonal. Sums are taken in the loops that need their terms
    anyway: a BLAS product of vectors would read them once more, and start threads for it.
    """
    channels, count = values.shape
    rest, ahead, product = np.empty_like(values), np.zeros_like(values), np.empty_like(values)
    scale = 1 / diagonal
    left, new, old, enough = np.zeros(channels), np.zeros(channels), np.zeros(channels), np.zeros(channels)
    _times(system, values, product)
    for channel in range(channels):
        square, scaled = 0.0, 0.0
        for row in range(count):
            here = (right[channel, row] - product[channel, row]) * free[channel, row]
            rest[channel, row] = here
            square += here * here
            scaled += here * here * scale[row]
        left[channel], new[channel], enough[channel] = square, scaled, tolerance**2 * square
    for _ in range(most):
        ready = True
        for channel in range(channels):
            # A channel that is ready, or is no number, stays where it is.
            if not left[channel] > enough[channel]:
                ahead[channel] = 0.0
                continue
            ready = False
            turn = new[channel] / old[channel] if old[channel] > 0 else 0.0
            for row in range(count):
                ahead[channel, row] = rest[channel, row] * scale[row] + turn * ahead[channel, row]
            old[channel] = new[channel]
        if ready:
            return True
        _times(system, ahead, product)
        for channel in range(channels):
            along = 0.0
            for row in range(count):
                along += ahead[channel, row] * product[channel, row] * free[channel, row]
            if along > 0:
                stride, square, scaled = old[channel] / along, 0.0, 0.0
                for row in range(count):
                    values[channel, row] += stride * ahead[channel, row]
                    here = rest[channel, row] - stride * product[channel, row] * free[channel, row]
                    rest[channel, row] = here
                    square += here * here
                    scaled += here * here * scale[row]
                left[channel], new[channel] = square, scaled
    return False
