# SPDX-License-Identifier: Apache-2.0
"""
Smooth borders between a cartoon's tones.

Nienhaus and Döllner, *Edge-Enhancement*, figure 9: taking the nearest tone makes borders jagged; sampling
neighbouring colours smooths them. A median first takes away specks that are smaller than a stroke.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import correlate1d, median_filter, minimum_filter

SPECK = 5
"""Side of the median's window, in pixels."""

WEIGHTS = np.array([1.0, 2.0, 1.0]) / 4
"""Of a pixel and its neighbours, along rows and along columns."""


def smooth_tones(picture: np.ndarray, covered: np.ndarray) -> np.ndarray:
    """
    Blend neighbouring tones; the outline stays as sharp as it was drawn.

    Parameters
    ----------
    picture : (h, w, 3) uint8
    covered : (h, w) bool
      Where something was drawn: only these pixels change, and only they are sampled.

    Returns
    -------
    (h, w, 3) uint8
    """
    if not covered.any():
        return picture.copy()
    cleaned = picture.astype(np.float64)
    # What lies within a tone only: a window that reaches the outline would take the background's colour.
    whole = minimum_filter(covered, SPECK, mode="nearest")
    cleaned[whole] = median_filter(picture, (SPECK, SPECK, 1), mode="nearest")[whole]
    weight = _blur(covered.astype(np.float64))
    blended = _blur(np.where(covered[..., None], cleaned, 0.0)) / np.maximum(weight, 1e-9)[..., None]
    return np.where(covered[..., None], np.rint(blended), picture).astype(np.uint8)


def _blur(values: np.ndarray) -> np.ndarray:
    """Weighted sums over a pixel and its eight neighbours."""
    rows = correlate1d(values, WEIGHTS, axis=0, mode="nearest")
    return correlate1d(rows, WEIGHTS, axis=1, mode="nearest")
