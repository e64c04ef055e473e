# SPDX-License-Identifier: Apache-2.0
"""The core in numba: the same integers as ``raster_core.draw_scalar``, thousands of times as fast."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numba
import numpy as np

from quadshade.contract.formats import (
    EDGE_FIELDS,
    EDGES,
    LANE_BITS,
    PLANES,
    PLANES_OF_ORDER,
    QUADRATIC,
    Formats,
)
from quadshade.errors import QuadshadeError
from quadshade.golden.clocks import count_clocks
from quadshade.golden.core.setup_loader import built_order

HEADER = ("has_second", "mirror", "fractional", "orders", "y", "rows_first", "rows_second")
COLUMNS = HEADER + tuple(f"{edge}_{name}" for edge in EDGES for name, _, _ in EDGE_FIELDS)
"""Columns of the table of packet fields."""

SIGNED_COLUMNS = ("rows_first", "rows_second") + tuple(
    f"{e}_{n}" for e in EDGES for n in ("error", "decrement")
)
HAS_SECOND, MIRROR, FRACTIONAL, ORDERS, Y, ROWS_FIRST, ROWS_SECOND, MAJOR, MINOR, SECOND = (
    *range(len(HEADER)),
    *(len(HEADER) + len(EDGE_FIELDS) * index for index in range(len(EDGES))),
)
COLUMN, ERROR, STEP, INCREMENT, DECREMENT = range(len(EDGE_FIELDS))


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
def _field(words: np.ndarray, lane: int, offset: int, width: int) -> int:
    """A raw bit field of at most 32 bits, read across a lane boundary where it stands there."""
    at = lane + offset // LANE_BITS
    shift = offset % LANE_BITS
    raw = np.int64(words[at]) >> shift
    if shift + width > LANE_BITS:
        raw |= np.int64(words[at + 1]) << (LANE_BITS - shift)
    return raw & ((np.int64(1) << width) - 1)


@numba.njit(cache=True)
def _packet_planes(
    orders: int, group: int, group_size: int, channels: int, built: np.ndarray, planes_of_order: np.ndarray
) -> int:
    """Planes that a channel group sends."""
    order = 0
    for channel in range(group * group_size, min((group + 1) * group_size, channels)):
        order = max(order, min((orders >> (2 * channel)) & 3, QUADRATIC))
    return planes_of_order[min(order, built[group])]


@numba.njit(cache=True)
def _find_packets(
    words: np.ndarray,
    orders_offset: int,
    orders_width: int,
    edge_lanes: int,
    second_lanes: int,
    plane_lanes: int,
    group_size: int,
    channels: int,
    built: np.ndarray,
    planes_of_order: np.ndarray,
) -> np.ndarray:
    """First lane of every packet, and the end; the last is beyond the stream where a packet is cut off."""
    starts = [0]
    lane = 0
    while lane < len(words):
        if lane + edge_lanes > len(words):
            starts.append(lane + edge_lanes)
            break
        orders = _field(words, lane, orders_offset, orders_width)
        lane += edge_lanes + second_lanes * (words[lane] & 1)
        for group in range(len(built)):
            lane += plane_lanes * _packet_planes(orders, group, group_size, channels, built, planes_of_order)
        starts.append(lane)
    return np.array(starts)


@numba.njit(cache=True)
def _read_fields(
    words: np.ndarray,
    starts: np.ndarray,
    offsets: np.ndarray,
    widths: np.ndarray,
    second: int,
    edge_lanes: int,
) -> np.ndarray:
    """(n, columns) raw fields; from column ``second`` on they stand in the second section, if any."""
    table = np.zeros((len(starts) - 1, len(offsets)), np.int64)
    for column in range(len(offsets)):
        offset, width = offsets[column], widths[column]
        for packet in range(len(table)):
            lane = starts[packet]
            if column < second:
                table[packet, column] = _field(words, lane, offset, width)
            elif words[lane] & 1:
                table[packet, column] = _field(words, lane + edge_lanes, offset, width)
    return table


@numba.njit(cache=True)
def _read_planes(
    words: np.ndarray,
    starts: np.ndarray,
    table: np.ndarray,
    edge_lanes: int,
    second_lanes: int,
    plane_lanes: int,
    word_lanes: int,
    group_size: int,
    built: np.ndarray,
    channel_planes: np.ndarray,
    planes_of_order: np.ndarray,
) -> np.ndarray:
    """(n, c, 6) raw channel words; planes that were not sent, or not connected, are zero."""
    channels = len(channel_planes)
    planes = np.zeros((len(table), channels, len(PLANES)), np.int64)
    for packet in range(len(table)):
        lane = starts[packet] + edge_lanes + second_lanes * table[packet, HAS_SECOND]
        for group in range(len(built)):
            count = _packet_planes(table[packet, ORDERS], group, group_size, channels, built, planes_of_order)
            for plane in range(count):
                for channel in range(group * group_size, min((group + 1) * group_size, channels)):
                    if plane < channel_planes[channel]:
                        at = lane + (channel - group * group_size) * word_lanes
                        for part in range(word_lanes):
                            planes[packet, channel, plane] |= np.int64(words[at + part]) << (LANE_BITS * part)
                lane += plane_lanes
    return planes


@numba.njit(cache=True)
def _walk_edges(table: np.ndarray, column_mask: int, error_mask: int) -> tuple:
    """Every scanline of every packet: first row of each packet, then y, column, pixels and carry a row."""
    packets = len(table)
    sign = (column_mask + 1) >> 1
    error_sign = (error_mask + 1) >> 1
    first_rows = np.zeros(packets + 1, np.int64)
    for packet in range(packets):
        rows = max(table[packet, ROWS_FIRST] + 2, 1)
        if table[packet, HAS_SECOND]:
            rows += max(table[packet, ROWS_SECOND] + 2, 1)
        first_rows[packet + 1] = first_rows[packet] + rows
    total = first_rows[packets]
    start = np.empty(total, np.int64)
    pixels = np.empty(total, np.int64)
    carries = np.empty(total, np.uint8)
    for packet in range(packets):
        fields = table[packet]
        major, minor = MAJOR, MINOR
        u = fields[major + COLUMN]
        error = fields[major + ERROR]
        end = fields[minor + COLUMN]
        end_error = fields[minor + ERROR]
        switch = first_rows[packet] + max(fields[ROWS_FIRST] + 2, 1)
        for row in range(first_rows[packet], first_rows[packet + 1]):
            if row == switch:
                minor = SECOND
                end = fields[minor + COLUMN]
                end_error = fields[minor + ERROR]
            count = (end - u - 2) & column_mask
            if count & sign:
                count -= column_mask + 1
            start[row] = u
            pixels[row] = count + 2 if count >= 0 else count & 1
            carries[row] = error >= 0
            if error >= 0:
                u = (u + fields[major + STEP] + 1) & column_mask
                error += fields[major + DECREMENT]
            else:
                u = (u + fields[major + STEP]) & column_mask
                error += fields[major + INCREMENT]
            if end_error >= 0:
                end = (end + fields[minor + STEP] + 1) & column_mask
                end_error += fields[minor + DECREMENT]
            else:
                end = (end + fields[minor + STEP]) & column_mask
                end_error += fields[minor + INCREMENT]
            error = ((error + error_sign) & error_mask) - error_sign
            end_error = ((end_error + error_sign) & error_mask) - error_sign
    return first_rows, start, pixels, carries


@numba.njit(cache=True)
def _draw(
    table: np.ndarray,
    planes: np.ndarray,
    first_rows: np.ndarray,
    start: np.ndarray,
    pixels: np.ndarray,
    carries: np.ndarray,
    coord_mask: int,
    word_width: int,
    frac_bits: np.ndarray,
    limits: np.ndarray,
) -> tuple:
    """Every pixel: packet, x, y, and (n, c) clamped values. int64 wraps modulo 2**64, so modulo 2**W too."""
    total = pixels.sum()
    channels = planes.shape[1]
    packet_of = np.empty(total, np.int32)
    x = np.empty(total, np.int32)
    y = np.empty(total, np.int32)
    value = np.empty((total, channels), np.int32)
    # The sign bit moves to the top of 64, the fraction out at the bottom.
    spare = 64 - word_width
    shift = spare + frac_bits
    # A row a plane: one lane of the core is a column.
    word, d_row, d_col, dd_row, dd_mixed, dd_col = np.empty((6, channels), np.int64)
    span, step = np.empty((2, channels), np.int64)
    position = 0
    for packet in range(len(table)):
        mask = coord_mask if table[packet, MIRROR] else 0
        scanline = table[packet, Y]
        fractional = table[packet, FRACTIONAL] != 0
        for channel in range(channels):
            plane = planes[packet, channel]
            word[channel], d_row[channel], d_col[channel] = plane[0], plane[1], plane[2]
            dd_row[channel], dd_mixed[channel], dd_col[channel] = plane[3], plane[4], plane[5]
        for row in range(first_rows[packet], first_rows[packet + 1]):
            stop = position + pixels[row]
            column = start[row] - position
            for channel in range(channels):
                span[channel], step[channel] = word[channel], d_col[channel] + dd_col[channel]
            for index in range(position, stop):
                packet_of[index] = packet
                x[index] = ((column + index) & coord_mask) ^ mask
                y[index] = scanline
                for channel in range(channels):
                    output = (span[channel] << spare) >> shift[channel]
                    value[index, channel] = min(max(output, 0), limits[channel])
                    span[channel] += step[channel]
                    step[channel] += dd_col[channel]
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


@dataclass(frozen=True)
class _Layout:
    """What the kernels need of the formats: lanes of the sections, columns of the table, channels."""

    orders: tuple[int, int]
    offsets: np.ndarray
    widths: np.ndarray
    edge_lanes: int
    second_lanes: int
    plane_lanes: int
    group_size: int
    built: np.ndarray
    planes_of_order: np.ndarray
    channel_planes: np.ndarray
    frac_bits: np.ndarray
    limits: np.ndarray


@lru_cache
def _layout(formats: Formats) -> _Layout:
    """The layout of the packets; the formats' own tables are evaluated once."""
    fields = formats.section("edge") | formats.section("second")
    groups = formats.channel_groups
    planes_of_order = np.array(PLANES_OF_ORDER)
    return _Layout(
        fields["orders"],
        np.array([fields[name][0] for name in COLUMNS]),
        np.array([fields[name][1] for name in COLUMNS]),
        formats.section_beats("edge") * formats.stream_lanes,
        formats.section_beats("second") * formats.stream_lanes,
        formats.plane_beats * formats.stream_lanes,
        len(groups[0]),
        np.array([built_order(group, formats) for group in groups]),
        planes_of_order,
        planes_of_order[list(formats.channel_max_order)],
        np.array(formats.channel_frac_bits),
        (1 << np.array(formats.channel_value_bits)) - 1,
    )


def draw_fast(
    words: np.ndarray, formats: Formats, stall_period: int = 0, stages_behind: int = 0
) -> EmittedPixels:
    """
    Draw a stream of set-up words, and predict the clocks.

    Parameters
    ----------
    words : (m,) uint32
      32-bit lanes, whole packets.
    formats : Formats
    stall_period : int
      The sink is not ready in every n-th clock; 0: always ready.
    stages_behind : int
      Stages of a pipeline behind the core, which ends in a skid buffer; 0: the sink takes the core's pixels.

    Returns
    -------
    EmittedPixels

    Raises
    ------
    QuadshadeError
      The stream ends within a packet.
    """
    layout = _layout(formats)
    words = np.ascontiguousarray(words, dtype=np.uint32)
    starts = _find_packets(
        words, *layout.orders, layout.edge_lanes, layout.second_lanes, layout.plane_lanes, layout.group_size,
        len(layout.channel_planes), layout.built, layout.planes_of_order,
    )  # fmt: skip
    if starts[-1] != len(words):
        raise QuadshadeError("the set-up stream ends within a packet", "send whole packets")
    table = _read_fields(words, starts, layout.offsets, layout.widths, SECOND, layout.edge_lanes)
    for name in SIGNED_COLUMNS:
        column = COLUMNS.index(name)
        sign = np.int64(1) << np.int64(layout.widths[column] - 1)
        table[:, column] = (table[:, column] ^ sign) - sign
    planes = _read_planes(
        words, starts, table, layout.edge_lanes, layout.second_lanes, layout.plane_lanes, formats.word_lanes,
        layout.group_size, layout.built, layout.channel_planes, layout.planes_of_order,
    )  # fmt: skip
    first_rows, start, pixels, carries = _walk_edges(
        table, (1 << formats.column_bits) - 1, (1 << formats.error_bits) - 1
    )
    packet_of, x, y, value = _draw(
        table, planes, first_rows, start, pixels, carries, (1 << formats.coord_bits) - 1, formats.word_width,
        layout.frac_bits, layout.limits,
    )  # fmt: skip
    beats = np.diff(starts) // formats.stream_lanes
    clocks = count_clocks(beats, first_rows, pixels, formats, stall_period, stages_behind)
    return EmittedPixels(packet_of, x, y, value, clocks, len(table))
