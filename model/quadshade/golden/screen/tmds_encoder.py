# SPDX-License-Identifier: Apache-2.0
"""A byte as a word of a TMDS data channel (``rtl/screen/tmds_encoder.vhd``)."""

from __future__ import annotations

CONTROL_WORDS = (0b1101010100, 0b0010101011, 0b0101010100, 0b1010101011)
"""By the two control bits, bit 0 goes first (Digital Visual Interface 1.0, 3.3.3)."""


class TmdsEncoder:
    """
    One data channel's encoder (Digital Visual Interface 1.0, figure 3-5), a word at a time.

    Attributes
    ----------
    disparity : int
      Ones minus zeros since the channel was last inactive.
    """

    def __init__(self) -> None:
        self.disparity = 0

    def encode(self, value: int | None, control: int = 0) -> int:
        """
        The word of a byte, or of two control bits.

        Parameters
        ----------
        value : int or None
          0 .. 255; None while nothing is shown.
        control : int
          0 .. 3.

        Returns
        -------
        int
          Ten bits, bit 0 goes first.
        """
        if value is None:
            self.disparity = 0
            return CONTROL_WORDS[control]
        ones = value.bit_count()
        equal = ones > 4 or (ones == 4 and not value & 1)
        word = value & 1
        for index in range(1, 8):
            bit = (word >> (index - 1) ^ value >> index) & 1
            word |= (bit ^ equal) << index
        excess = 2 * word.bit_count() - 8
        if self.disparity == 0 or excess == 0:
            inverts = equal
            self.disparity += -excess if inverts else excess
        elif (self.disparity > 0) == (excess > 0):
            inverts = True
            self.disparity += 2 * (not equal) - excess
        else:
            inverts = False
            self.disparity += excess - 2 * equal
        return inverts << 9 | (not equal) << 8 | (word ^ 0xFF if inverts else word)


def decode(word: int) -> int:
    """The byte of a word that is no control word."""
    bits = word & 0xFF ^ (0xFF if word >> 9 else 0)
    moved = bits ^ bits << 1 & 0xFF
    return moved if word >> 8 & 1 else moved ^ 0xFE
