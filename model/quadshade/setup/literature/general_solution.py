# SPDX-License-Identifier: Apache-2.0
"""The quadratic's coefficients as six equations in six unknowns, solved by elimination in any float type."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt
from numba import njit

from quadshade.contract.arrays import Floats

Six: TypeAlias = tuple[float, float, float, float, float, float]
"""T0 to T5, or samples I1, I2, I3, I12, I13, I23."""
Legs: TypeAlias = tuple[float, float, float, float]
"""X and Y of the second and of the third vertex, counted from the first."""


@njit(cache=True, error_model="numpy")
def _leg(legs: Legs, corner: int, axis: int) -> float:
    """x or y of a corner counted from the first; halves of their sums are exact, so nothing is lost here."""
    return legs[2 * corner - 2 + axis] if corner else legs[0] - legs[0]


@njit(cache=True, error_model="numpy")
def general(samples: Six, legs: Legs, rows: Floats) -> Six:
    """
    T0 to T5 from six equations in six unknowns (Barrera et al., equations 8-11), with partial pivoting.

    ``rows`` is room for them, (6, 7); its type is that of the arithmetic. Every product is of two of its
    entries, so that no literal widens it.
    """
    for place in range(6):
        first, second = (0, 1, 2, 0, 0, 1)[place], (0, 1, 2, 1, 2, 2)[place]
        x = 0.5 * (_leg(legs, first, 0) + _leg(legs, second, 0))
        y = 0.5 * (_leg(legs, first, 1) + _leg(legs, second, 1))
        row = rows[place]
        row[0], row[1], row[2], row[6] = 1.0, y, x, samples[place]
        row[3], row[4], row[5] = row[1] * row[1], row[1] * row[2], row[2] * row[2]
    for column in range(6):
        pivot = column
        for place in range(column + 1, 6):
            if abs(rows[place, column]) > abs(rows[pivot, column]):
                pivot = place
        for entry in range(column, 7):
            rows[column, entry], rows[pivot, entry] = rows[pivot, entry], rows[column, entry]
        for place in range(column + 1, 6):
            factor = rows[place, column] / rows[column, column]
            for entry in range(column, 7):
                rows[place, entry] -= factor * rows[column, entry]
    for column in range(5, -1, -1):
        for entry in range(column + 1, 6):
            rows[column, 6] -= rows[column, entry] * rows[entry, 6]
        rows[column, 6] /= rows[column, column]
    return rows[0, 6], rows[1, 6], rows[2, 6], rows[3, 6], rows[4, 6], rows[5, 6]


def general_in(
    dtype: type[np.floating[Any]], legs: np.ndarray, samples: np.ndarray
) -> npt.NDArray[np.floating[Any]]:
    """
    The general solution in a type of floating point.

    Parameters
    ----------
    dtype : type
      ``numpy.float32`` or ``numpy.float64``.
    legs, samples : (n, 4), (n, 6) of this type

    Returns
    -------
    (n, 6) of this type
      T0 to T5.
    """
    out, rows = np.empty((len(samples), 6), dtype), np.empty((6, 7), dtype)
    for index in range(len(samples)):
        out[index] = general(tuple(samples[index]), tuple(legs[index]), rows)
    return out
