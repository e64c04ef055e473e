# SPDX-License-Identifier: Apache-2.0
"""
The values for which the weighted squared error is least: normal equations, by conjugate gradients.

The matrix is symmetric and positive definite, and is kept as a block of 6 x 6 numbers a triangle. The steps
begin at the six points and are scaled by the diagonal.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numba import njit
from scipy import sparse
from scipy.sparse.linalg import LinearOperator, cg

from quadshade.contract.arrays import Bools, Floats, Ints
from quadshade.errors import QuadshadeError
from quadshade.fit.elements import Elements
from quadshade.fit.places import Places

HOLD = 1e-3
"""Pixels that speak for a six-point value: what no place sees stays as it was sampled."""

TOLERANCE = 1e-5
"""Of the residual that the six points leave."""
MOST_STEPS = 2000
ROUNDS = 8
"""Of holding what leaves the range."""


@dataclass(frozen=True)
class Normal:
    """
    Normal equations, before neighbours' shares are added up.

    Attributes
    ----------
    block : (n, 6, 6) float64
      Of each triangle: its samples' shape functions with each other, over its places.
    right : (n, 6, c) float64
      Of each triangle: shape functions with the targets.
    """

    block: Floats
    right: Floats


def normal_equations(count: int, places: Places, shape: Floats, target: Floats, weight: Floats) -> Normal:
    """
    Sum over places, triangle by triangle.

    Parameters
    ----------
    count : int
      Triangles.
    places : Places
    shape : (p, 6) float64
      Shape functions at the places.
    target : (p, c) float64
    weight : (p,) float64
      Of each place's squared error.

    Returns
    -------
    Normal
    """
    block, right = np.zeros((count, 6, 6)), np.zeros((count, 6, target.shape[1]))
    _add_up(places.triangle, shape, target, weight, block, right)
    return Normal(block, right)


def least_squares(
    elements: Elements,
    normal: Normal,
    largest: float,
    penalty: sparse.csr_array | None = None,
    begin: Floats | None = None,
) -> Floats:
    """
    Solve for the unknowns.

    Parameters
    ----------
    elements : Elements
    normal : Normal
    largest : float
      No value is below 0 or above this.
    penalty : (m, m) sparse, optional
      A quadratic form of the unknowns that is to be small as well.
    begin : (m, c) float64, optional
      Where the steps begin; by default the six points.

    Returns
    -------
    (m, c) float64

    Raises
    ------
    QuadshadeError
      The steps do not end.
    """
    start, index = elements.start, elements.index
    count = len(start)
    begin = start if begin is None else begin
    diagonal = np.full(count, HOLD)
    np.add.at(diagonal, index, np.einsum("nii->ni", normal.block))
    if penalty is not None:
        diagonal += penalty.diagonal()
    right = HOLD * start
    np.add.at(right, index, normal.right)

    found = np.empty_like(start)
    for channel in range(start.shape[1]):
        found[:, channel] = _bounded(
            lambda vector: _times(normal.block, index, penalty, vector),
            diagonal,
            right[:, channel],
            begin[:, channel],
            largest,
        )
    # Numbers that are none leave the six points.
    return np.where(np.isfinite(found), found, start)


def _times(block: Floats, index: Ints, penalty: sparse.csr_array | None, vector: Floats) -> Floats:
    """The matrix times a vector of unknowns."""
    product = HOLD * vector
    _multiply(block, index, vector, product)
    return product if penalty is None else product + penalty @ vector


def _bounded(
    times: Callable[[Floats], Floats],
    diagonal: Floats,
    right: Floats,
    begin: Floats,
    largest: float,
) -> Floats:
    """
    Solve for unknowns of 0 .. ``largest``: those that leave the range stay at its border, the others go on.

    A clamped solution would be no least one: its neighbours have counted on the value that it lost.
    """
    free = np.ones(len(begin), dtype=bool)
    values = np.clip(begin, 0, largest)
    for _ in range(ROUNDS):
        missing = np.where(free, right - times(values), 0.0)

        def matvec(vector: Floats, free: Bools = free) -> Floats:
            inside = np.where(free, vector.reshape(-1), 0.0)
            return np.where(free, times(inside), vector.reshape(-1))

        shape = (len(begin), len(begin))
        matrix = LinearOperator(shape, matvec=matvec, dtype=np.float64)
        jacobi = LinearOperator(shape, matvec=lambda vector: vector / diagonal, dtype=np.float64)
        change, unfinished = cg(matrix, missing, rtol=TOLERANCE, maxiter=MOST_STEPS, M=jacobi)
        if unfinished:
            raise QuadshadeError(
                f"the fit has no solution after {MOST_STEPS} steps",
                "give a smaller --smoothness, or another --fit",
            )
        solved = values + np.where(free, change, 0.0)
        values = np.clip(solved, 0, largest)
        outside = free & (values != solved)
        if not outside.any():
            break
        free &= ~outside
    return values


@njit(cache=True)
def _add_up(
    triangle: Ints, shape: Floats, target: Floats, weight: Floats, block: Floats, right: Floats
) -> None:
    """Add every place to the block and the right side of its triangle."""
    for place in range(len(triangle)):
        owner, share = triangle[place], weight[place]
        for row in range(6):
            here = share * shape[place, row]
            for column in range(6):
                block[owner, row, column] += here * shape[place, column]
            for channel in range(target.shape[1]):
                right[owner, row, channel] += here * target[place, channel]


@njit(cache=True)
def _multiply(block: Floats, index: Ints, vector: Floats, product: Floats) -> None:
    """Add the blocks times a vector of unknowns to ``product``."""
    for triangle in range(len(index)):
        for row in range(6):
            total = 0.0
            for column in range(6):
                total += block[triangle, row, column] * vector[index[triangle, column]]
            product[index[triangle, row]] += total
