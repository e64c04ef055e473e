# SPDX-License-Identifier: Apache-2.0
"""One channel from its words to its output values (``rtl/core/channel_lane.vhd``)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from quadshade.contract.formats import Formats
from quadshade.golden.core.output_clamp import output_clamp
from quadshade.golden.core.pixel_channel import PixelChannel
from quadshade.golden.core.scanline_channel import ScanlineChannel


class ChannelLane:
    """
    A channel of a primitive: steps along the major edge, walks spans, clamps.

    Parameters
    ----------
    words : sequence of int
      Six raw differences (``formats.DIFFERENCES``).
    channel : int
      Index of the carried channel: which formats it has.
    formats : Formats
    """

    def __init__(self, words: Sequence[int], channel: int, formats: Formats) -> None:
        self.word_width = formats.word_width
        self.frac_bits = formats.channel_frac_bits[channel]
        self.value_bits = formats.channel_value_bits[channel]
        self.scanline = ScanlineChannel(words, formats.channel_max_order[channel], formats.word_width)

    def span(self, pixels: int) -> Iterator[int]:
        """Output values of the current scanline's first ``pixels`` pixels."""
        pixel = PixelChannel(*self.scanline.span(), self.word_width)
        for _ in range(pixels):
            yield output_clamp(pixel.value, self.word_width, self.frac_bits, self.value_bits)
            pixel.step()

    def step(self, carry: int) -> None:
        """One scanline down."""
        self.scanline.step(carry)
