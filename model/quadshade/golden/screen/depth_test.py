# SPDX-License-Identifier: Apache-2.0
"""The z-buffer (``rtl/screen/depth_test.vhd``): which pixels of a stream are kept, in their order."""

from __future__ import annotations

import numba
import numpy as np

from quadshade.errors import QuadshadeError


class DepthTest:
    """
    A z-buffer, one pixel at a time.

    Parameters
    ----------
    width, height : int
      Of the screen, pixels.
    depth_bits : int

    Attributes
    ----------
    stored : list of int
      Nearest depth of every place in scanline order; 2**depth_bits where nothing was drawn.
    """

    def __init__(self, width: int, height: int, depth_bits: int) -> None:
        self.width, self.height, self.depth_bits = width, height, depth_bits
        self.clear()

    def clear(self) -> None:
        """Forget every pixel."""
        self.stored = [1 << self.depth_bits] * (self.width * self.height)

    def test(self, x: int, y: int, depth: int) -> bool:
        """Whether a pixel is kept: on the screen, and nearer than all before it at its place."""
        if x >= self.width or y >= self.height:
            return False
        address = y * self.width + x
        if depth >= self.stored[address]:
            return False
        self.stored[address] = depth
        return True


@numba.njit(cache=True)
def _test_all(x: np.ndarray, y: np.ndarray, depth: np.ndarray, stored: np.ndarray) -> np.ndarray:
    height, width = stored.shape
    kept = np.zeros(len(x), dtype=np.bool_)
    for index in range(len(x)):
        column, row = x[index], y[index]
        if column < width and row < height and depth[index] < stored[row, column]:
            stored[row, column] = depth[index]
            kept[index] = True
    return kept


def empty_depths(width: int, height: int, depth_bits: int) -> np.ndarray:
    """(height, width) int64 z-buffer after a clear."""
    return np.full((height, width), 1 << depth_bits, dtype=np.int64)


def kept_pixels(x: np.ndarray, y: np.ndarray, depth: np.ndarray, stored: np.ndarray) -> np.ndarray:
    """
    The z-buffer for many pixels, compiled: what :class:`DepthTest` says of each.

    Parameters
    ----------
    x, y, depth : (n,) int
      In the order of drawing; not negative.
    stored : (height, width) int64
      From :func:`empty_depths`, or of an earlier call; changed in place.

    Returns
    -------
    (n,) bool
      Pixels that are kept.

    Raises
    ------
    QuadshadeError
      A negative coordinate or depth.
    """
    x, y, depth = (np.ascontiguousarray(part, dtype=np.int64) for part in (x, y, depth))
    if any(len(part) and part.min() < 0 for part in (x, y, depth)):
        raise QuadshadeError("a pixel has a negative coordinate or depth", "the pixel stream is unsigned")
    return _test_all(x, y, depth, stored)
