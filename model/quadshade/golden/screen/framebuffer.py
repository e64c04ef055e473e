# SPDX-License-Identifier: Apache-2.0
"""The picture memory (``rtl/screen/framebuffer.vhd``)."""

from __future__ import annotations

import numpy as np

from quadshade.golden.screen.depth_test import empty_depths, kept_pixels


class Framebuffer:
    """
    A picture, one pixel at a time.

    Parameters
    ----------
    width, height : int
      Of the screen, pixels.
    clear_value : int
      Value of every place at first.

    Attributes
    ----------
    words : list of int
      Value of every place in scanline order.
    """

    def __init__(self, width: int, height: int, clear_value: int = 0) -> None:
        self.width, self.height = width, height
        self.clear(clear_value)

    def clear(self, value: int) -> None:
        """Set every place to one value."""
        self.words = [value] * (self.width * self.height)

    def write(self, x: int, y: int, value: int) -> None:
        """Keep a pixel; one outside the screen is dropped."""
        if x < self.width and y < self.height:
            self.words[y * self.width + x] = value


def draw_pixels(
    x: np.ndarray,
    y: np.ndarray,
    value: np.ndarray,
    depth: np.ndarray | None,
    width: int,
    height: int,
    depth_bits: int = 16,
    clear_value: tuple[int, ...] = (0, 0, 0),
) -> np.ndarray:
    """
    What the framebuffer holds after a clear and many pixels, through the z-buffer if they have depth.

    Parameters
    ----------
    x, y : (n,) int
      In the order of drawing; not negative.
    value : (n, c) int
    depth : (n,) int or None
      Without, the last pixel of a place stays.
    width, height : int
    depth_bits : int
    clear_value : c ints

    Returns
    -------
    (height, width, c) int64

    Raises
    ------
    QuadshadeError
      A negative coordinate or depth.
    """
    if depth is not None:
        kept = kept_pixels(x, y, depth, empty_depths(width, height, depth_bits))
    else:
        kept = (x < width) & (y < height)
    picture = np.empty((height, width, len(clear_value)), dtype=np.int64)
    picture[:] = clear_value
    # Of several pixels at a place the last one stays: said by hand, as NumPy promises no order.
    place = y[kept].astype(np.int64) * width + x[kept]
    last = np.full(width * height, -1)
    np.maximum.at(last, place, np.arange(len(place)))
    drawn = last >= 0
    picture.reshape(width * height, -1)[drawn] = value[kept][last[drawn]]
    return picture
