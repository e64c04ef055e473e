# SPDX-License-Identifier: Apache-2.0
"""The core in numba: the same integers as ``raster_core.draw_scalar``, thousands of times as fast."""

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np

from quadshade.contract.arrays import Records
from quadshade.contract.formats import Formats
from quadshade.golden.clocks import count_clocks
from quadshade.golden.compiled_packets import (
    DecodedPackets,
    PacketLayout,
    Scanlines,
    decode_packets,
)


@dataclass
class EmittedPixels:
    """
    Pixels in the order in which the core emits them.

    Attributes
    ----------
    packet : (n,) int32
    x, y : (n,) int32
    value : (n, c) int32
      Every carried channel, depth last.
    clocks : int
    packets : int
    """

    packet: np.ndarray
    x: np.ndarray
    y: np.ndarray
    value: np.ndarray
    clocks: int
    packets: int


@numba.njit(cache=True)
def _draw(
    packets: Records, differences: Records, scanlines: Scanlines, layout: PacketLayout
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Every pixel: packet, x, y, and (n, c) clamped values. int64 wraps modulo 2**64, so modulo 2**W too."""
    first_rows, start, pixels, carries = scanlines
    coord_mask, limits = layout.coord_mask, layout.limits
    total = pixels.sum()
    channels = differences.shape[1]
    packet_of = np.empty(total, np.int32)
    x = np.empty(total, np.int32)
    y = np.empty(total, np.int32)
    value = np.empty((total, channels), np.int32)
    # The sign bit moves to the top of 64, the fraction out at the bottom.
    spare = 64 - layout.word_width
    shift = spare + layout.frac_bits
    # A column of these arrays is what one lane of the core holds.
    word, d_row, d_col, dd_row, dd_mixed, dd_col = np.empty((6, channels), np.int64)
    position = 0
    for packet in range(len(packets)):
        fields = packets[packet]
        mask = coord_mask if fields["mirror"] else 0
        scanline = fields["y"]
        fractional = fields["fractional"] != 0
        for channel in range(channels):
            sent = differences[packet, channel]
            word[channel], d_row[channel], d_col[channel] = sent["value"], sent["d_row"], sent["d_col"]
            dd_row[channel], dd_mixed[channel] = sent["dd_row"], sent["dd_mixed"]
            dd_col[channel] = sent["dd_col"]
        for row in range(first_rows[packet], first_rows[packet + 1]):
            stop = position + pixels[row]
            column = start[row] - position
            for index in range(position, stop):
                packet_of[index] = packet
                x[index] = ((column + index) & coord_mask) ^ mask
                y[index] = scanline
            for channel in range(channels):
                span, more = word[channel], dd_col[channel]
                step, lowest, limit = d_col[channel] + more, shift[channel], limits[channel]
                for index in range(position, stop):
                    value[index, channel] = min(max((span << spare) >> lowest, 0), limit)
                    span += step
                    step += more
            carry = carries[row] != 0 and not fractional
            for channel in range(channels):
                if carry:
                    d_col[channel] += dd_mixed[channel] + dd_col[channel]
                    word[channel] += d_row[channel] + d_col[channel]
                    d_row[channel] += dd_row[channel] + dd_mixed[channel]
                else:
                    d_col[channel] += dd_mixed[channel]
                    word[channel] += d_row[channel]
                    d_row[channel] += dd_row[channel]
            position = stop
            scanline = (scanline + 1) & coord_mask
    return packet_of, x, y, value


@numba.njit(cache=True)
def draw_packets(
    decoded: DecodedPackets, first: int, last: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Pixels of packets ``first`` to below ``last``: packet (counted from the first), x, y, (n, c) values."""
    scanlines = decoded.scanlines
    low, high = scanlines.first_rows[first], scanlines.first_rows[last]
    rows = Scanlines(
        scanlines.first_rows[first : last + 1] - low,
        scanlines.start[low:high],
        scanlines.pixels[low:high],
        scanlines.carries[low:high],
    )
    return _draw(decoded.packets[first:last], decoded.differences[first:last], rows, decoded.layout)


def draw_fast(
    words: np.ndarray,
    formats: Formats,
    stall_period: int = 0,
    stages_behind: int = 0,
    single_buffer: bool = False,
) -> EmittedPixels:
    """
    Draw a stream of set-up words, and predict the clocks.

    Parameters
    ----------
    words : (m,) uint32
      32-bit set-up words, whole packets.
    formats : Formats
    stall_period : int
      The sink is not ready in every n-th clock; 0: always ready.
    stages_behind : int
      Stages of a pipeline behind the core, which ends in a skid buffer; 0: the sink takes the core's pixels.
    single_buffer : bool
      Generic of ``raster_core``.

    Returns
    -------
    EmittedPixels

    Raises
    ------
    QuadshadeError
      The stream ends within a packet.
    """
    starts, packets, differences, scanlines, layout = decode_packets(words, formats)
    packet_of, x, y, value = _draw(packets, differences, scanlines, layout)
    beats = np.diff(starts) // formats.beat_words
    rows = (scanlines.first_rows, scanlines.pixels)
    clocks = count_clocks(beats, *rows, formats, stall_period, stages_behind, single_buffer)
    return EmittedPixels(packet_of, x, y, value, clocks, len(packets))
