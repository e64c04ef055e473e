# SPDX-License-Identifier: Apache-2.0
"""A channel along the major edge (``rtl/core/scanline_channel.vhd``)."""

from __future__ import annotations

from collections.abc import Sequence

from quadshade.contract.formats import CONSTANT, LINEAR


class ScanlineChannel:
    """
    Forward differences from scanline to scanline, modulo 2**word_width.

    Parameters
    ----------
    words : sequence of int
      Six raw differences (``formats.DIFFERENCES``).
    max_order : int
      What the channel is built for: words of higher orders are not connected.
    word_width : int
    """

    def __init__(self, words: Sequence[int], max_order: int, word_width: int) -> None:
        self.modulus = 1 << word_width
        self.value = words[0]
        self.row, self.col = words[1:3] if max_order > CONSTANT else (0, 0)
        self.dd_row, self.dd_mixed, self.dd_col = words[3:6] if max_order > LINEAR else (0, 0, 0)

    def span(self) -> tuple[int, int, int]:
        """Value, first difference and second difference along the span at its first pixel."""
        return self.value, (self.col + self.dd_col) % self.modulus, self.dd_col

    def step(self, carry: int) -> None:
        """One scanline down; a carry is one more pixel step."""
        self.col = (self.col + self.dd_mixed + carry * self.dd_col) % self.modulus
        self.value = (self.value + self.row + carry * self.col) % self.modulus
        self.row = (self.row + self.dd_row + carry * self.dd_mixed) % self.modulus
