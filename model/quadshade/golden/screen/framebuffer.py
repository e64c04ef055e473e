# SPDX-License-Identifier: Apache-2.0
"""The picture memory (``rtl/screen/framebuffer.vhd``): its buffers, and colours in fewer bits than a byte."""

from __future__ import annotations

import numpy as np

from quadshade.golden.screen.depth_test import empty_depths, kept_pixels

BYTE_BITS = 8
HALF_STEP = 8
"""The threshold of a clear, which is one colour."""


def channel_bits(channel: int, colour_bits: int) -> int:
    """Bits that are kept of a channel: ``colour_bits``, but of channel 1 five for 6, and six for 5."""
    return 11 - colour_bits if channel == 1 and colour_bits in (5, 6) else colour_bits


def thresholds(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """
    Thresholds of ordered dithering at places: each of 0 to 15 once in a square of 4 by 4.

    Parameters
    ----------
    x, y : (...) int

    Returns
    -------
    (...) int

    Notes
    -----
    The matrix of B. E. Bayer, *An optimum method for two-level rendition of continuous-tone pictures*.
    """
    across = x ^ y
    return (across & 1) << 3 | (y & 1) << 2 | (across >> 1 & 1) << 1 | (y >> 1 & 1)


def kept_colours(value: np.ndarray, threshold: np.ndarray | int, colour_bits: int) -> np.ndarray:
    """
    Colours as they are read again, of fewer bits than a byte.

    Parameters
    ----------
    value : (..., c) int
      0 .. 255.
    threshold : (...) int or int
      0 .. 15: :func:`thresholds` of the places, or ``HALF_STEP``.
    colour_bits : int
      8, 6 (of channel 1 five), 5 (of channel 1 six) or 4.

    Returns
    -------
    (..., c) int
      A colour that so many bits can show is as it was, whatever the threshold.
    """
    channels = []
    for channel in range(value.shape[-1]):
        bits, byte = channel_bits(channel, colour_bits), value[..., channel].astype(np.int64)
        if bits < BYTE_BITS:
            kept = byte - (byte >> bits) + (threshold >> (bits - 4)) >> (BYTE_BITS - bits)
            byte = kept << (BYTE_BITS - bits) | kept >> (2 * bits - BYTE_BITS)
        channels.append(byte)
    return np.stack(channels, axis=-1)


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
