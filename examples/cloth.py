# SPDX-License-Identifier: Apache-2.0
"""A reflectance function for ``quadshade render --reflectance cloth.py:cloth``."""

from __future__ import annotations

import numpy as np


def cloth(point: np.ndarray, normal: np.ndarray, to_light: np.ndarray, to_viewer: np.ndarray) -> np.ndarray:
    """
    Velvet: darker than Lambert's law where it faces the viewer, brighter at its rim.

    Parameters
    ----------
    point, normal, to_light, to_viewer : (n, 3) float64
      In scene units; the last three have unit length.

    Returns
    -------
    (n, 3) float64
      The share of the light that is reflected, for red, green and blue.
    """
    facing = (normal * to_light).sum(axis=1).clip(0)
    rim = 1 - (normal * to_viewer).sum(axis=1).clip(0)
    return (facing * (0.4 + 0.6 * rim))[:, None] * (0.8, 0.2, 0.3)
