# SPDX-License-Identifier: Apache-2.0
"""
The quadratic of Bishop and Weimer, "Fast Phong Shading": Taylor's at the middle of each triangle.

They expand what Phong shading computes at a pixel about the triangle's middle, up to second order. So the
picture is best there, and neighbours do not meet along their edge. The polynomial is given by its values at
the six points, as every other one, so that the same set-up draws it.
"""

from __future__ import annotations

import numpy as np

REACH = 1 / 64
"""Size of the two small triangles about the middle, over the triangle's, from which differences are taken."""


def _shape(points: np.ndarray) -> np.ndarray:
    """(k, 6) shares of the six samples in a quadratic's value at (k, 3) barycentric coordinates."""
    first, second, third = points.T
    middles = np.stack([4 * first * second, 4 * first * third, 4 * second * third], axis=-1)
    return np.concatenate([points * (2 * points - 1), middles], axis=-1)


def expansion(points: np.ndarray, middle: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """
    Taylor's polynomial of second order at a point, from values around it.

    Parameters
    ----------
    points : (6, 3) float64
      Where it is wanted, in barycentric coordinates.
    middle : (1, 3) float64
      Where it is expanded.

    Returns
    -------
    (12, 3) float64
      Where values are taken.
    (6, 12) float64
      Their shares in the polynomial at the points.
    """
    near = [middle + sign * REACH * (points - middle) for sign in (1, -1)]
    # The mean over a triangle and its mirror image: what is of third order cancels.
    shares = [np.linalg.inv(_shape(place)) / 2 for place in near]
    return np.concatenate(near), np.concatenate(shares, axis=1)
