# SPDX-License-Identifier: Apache-2.0
"""A screen whose pictures and z-buffer are in an SDRAM (``rtl/screen/sdram_screen.vhd``)."""

from __future__ import annotations

import numpy as np

from quadshade.golden.screen.framebuffer import BYTE_BITS, channel_bits
from quadshade.golden.screen.screen import Screen
from quadshade.golden.screen.sdram_depth_test import DEPTH_PLANE

DATA_BITS = 16
"""Of a word of the memory."""


def colour_words(colour: np.ndarray, colour_bits: int) -> np.ndarray:
    """
    Words of a picture as the memory has them: the bits that are kept, channel 0 lowest.

    Parameters
    ----------
    colour : (..., c) uint8
      As it is read, so of no more than its bits.
    colour_bits : int
      8 or as :func:`kept_colours`.

    Returns
    -------
    (...) int64
    """
    words, place = np.zeros(colour.shape[:-1], np.int64), 0
    for channel in range(colour.shape[-1]):
        bits = channel_bits(channel, colour_bits)
        words |= (colour[..., channel].astype(np.int64) >> (BYTE_BITS - bits)) << place
        place += bits
    return words


class SdramScreen(Screen):
    """
    A screen of two pictures and a z-buffer, and the memory's words.

    Parameters
    ----------
    width, height, num_channels, depth_bits, colour_bits : int
      As of :class:`Screen`.

    Attributes
    ----------
    drawn : int
      The plane of the picture that is drawn and read; the other one is shown.
    """

    def __init__(
        self, width: int, height: int, num_channels: int = 3, depth_bits: int = 15, colour_bits: int = 5
    ) -> None:
        super().__init__(width, height, num_channels, depth_bits, False, colour_bits)
        self.drawn = 0

    def swap(self) -> None:
        super().swap()
        self.drawn = 1 - self.drawn

    def memory(self) -> np.ndarray:
        """(3, height, width) int64: words of both pictures and of the depths."""
        words = np.zeros((3, *self.depth.shape), np.int64)
        words[self.drawn] = colour_words(self.colour, self.colour_bits)
        words[1 - self.drawn] = colour_words(self.shown, self.colour_bits)
        empty = self.depth == 1 << (self.depth_bits or 0)
        words[DEPTH_PLANE] = np.where(empty, (1 << DATA_BITS) - 1, self.depth)
        return words
