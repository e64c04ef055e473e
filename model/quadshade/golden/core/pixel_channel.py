# SPDX-License-Identifier: Apache-2.0
"""A channel along a span (``rtl/core/pixel_channel.vhd``)."""

from __future__ import annotations


class PixelChannel:
    """
    Forward differences from pixel to pixel, modulo 2**word_width.

    Parameters
    ----------
    value, d_col, dd_col : int
      The span's words.
    word_width : int
    """

    def __init__(self, value: int, d_col: int, dd_col: int, word_width: int) -> None:
        self.modulus = 1 << word_width
        self.value = value
        self.d_col = d_col
        self.dd_col = dd_col

    def step(self) -> None:
        """One pixel along."""
        self.value = (self.value + self.d_col) % self.modulus
        self.d_col = (self.d_col + self.dd_col) % self.modulus
