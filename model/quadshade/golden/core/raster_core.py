# SPDX-License-Identifier: Apache-2.0
"""The core, plain and scalar: what ``rtl/core/raster_core.vhd`` emits for a stream of set-up words."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from quadshade.contract.formats import Formats
from quadshade.golden.core.channel_lane import ChannelLane
from quadshade.golden.core.edge_walker import walk_edges
from quadshade.golden.core.setup_loader import load_packets
from quadshade.golden.core.span_walker import walk_span


class EmittedPixel(NamedTuple):
    """A pixel as the core emits it; ``value`` holds every carried channel, depth last."""

    packet: int
    last: bool
    x: int
    y: int
    value: tuple[int, ...]


def draw_scalar(words: Sequence[int], formats: Formats) -> list[EmittedPixel]:
    """
    Draw a stream of set-up words.

    Parameters
    ----------
    words : sequence of int
      32-bit set-up words, whole packets.
    formats : Formats

    Returns
    -------
    list of EmittedPixel
      In the order in which the core emits them.

    Raises
    ------
    QuadshadeError
      The stream ends within a packet.
    """
    pixels = []
    for number, packet in enumerate(load_packets(words, formats)):
        lanes = [
            ChannelLane(differences, channel, formats) for channel, differences in enumerate(packet.words)
        ]
        for scanline in walk_edges(packet.fields, formats):
            values = zip(*(lane.span(scanline.pixels) for lane in lanes), strict=True)
            for (x, y, last), value in zip(walk_span(scanline, formats), values, strict=True):
                pixels.append(EmittedPixel(number, last, x, y, value))
            for lane in lanes:
                lane.step(scanline.carry)
    return pixels
