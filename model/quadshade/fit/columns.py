# SPDX-License-Identifier: Apache-2.0
"""Where an edge passes a scanline, exactly as the core has it."""

from __future__ import annotations

from numba import njit

from quadshade.contract.arrays import Ints


@njit(cache=True)
def first_column(top: Ints, bottom: Ints, y: int, scale: int) -> int:
    """
    The first pixel column whose centre is not left of an edge: ceil(x(y) - 1/2).

    Parameters
    ----------
    top, bottom : (2,) int64
      Ends of the edge in sub-pixels, not at one height.
    y : int
      Height, sub-pixels.
    scale : int
      Sub-pixels of a pixel.

    Returns
    -------
    int
    """
    dx, dy = bottom[0] - top[0], bottom[1] - top[1]
    return int(-((-(top[0] - scale // 2) * dy - (y - top[1]) * dx) // (scale * dy)))
