# SPDX-License-Identifier: Apache-2.0
"""A stream of packets in numba, before its pixels: fields, differences and scanlines."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numba
import numpy as np

from quadshade.contract.arrays import Int, Ints, Record, Records, Words32
from quadshade.contract.formats import (
    DIFFERENCES,
    DIFFERENCES_OF_ORDER,
    EDGE_FIELDS,
    EDGES,
    HEADER_FIELDS,
    QUADRATIC,
    SETUP_WORD_BITS,
    Formats,
)
from quadshade.errors import QuadshadeError
from quadshade.golden.core.setup_loader import built_order

EDGE = np.dtype([(field.name, np.int64) for field in EDGE_FIELDS])
"""An edge of a packet."""

PACKET = np.dtype([(field.name, np.int64) for field in HEADER_FIELDS] + [(edge, EDGE) for edge in EDGES])
"""A packet's fields; those of a second section that was not sent are zero."""

FIELDS = tuple(field.name for field in HEADER_FIELDS) + tuple(
    f"{edge}_{field.name}" for edge in EDGES for field in EDGE_FIELDS
)
"""Names of the numbers of :data:`PACKET`, in order, as ``Formats.section`` has them."""

SIGNED_FIELDS = ("rows_first", "rows_second") + tuple(
    f"{edge}_{name}" for edge in EDGES for name in ("error", "decrement")
)

CHANNEL = np.dtype([(name, np.int64) for name in DIFFERENCES])
"""A channel's differences in a packet."""


class PacketLayout(NamedTuple):
    """
    What the kernels need of the formats. Lengths are in set-up words.

    ``offsets``, ``widths`` and ``signs`` (what a field's sign bit is worth, 0 without one) are those of
    :data:`FIELDS`; from index ``second_from`` on they stand in the second section. ``built`` is each group's
    highest order; ``channel_differences``, ``frac_bits`` and ``limits`` (the greatest value that is emitted)
    have an entry a channel.
    """

    orders_offset: int
    orders_width: int
    offsets: Ints
    widths: Ints
    signs: Ints
    second_from: int
    edge_words: int
    second_words: int
    group_words: int
    difference_words: int
    group_size: int
    built: Ints
    channel_differences: Ints
    frac_bits: Ints
    limits: Ints
    word_width: int
    coord_mask: int
    column_mask: int
    error_mask: int


class Scanlines(NamedTuple):
    """
    Every scanline of every packet.

    ``first_rows`` (n + 1) is the index of each packet's first one, and their number; ``start`` the column u
    of the span, ``pixels`` how many it has, ``carries`` whether the major edge carries behind it.
    """

    first_rows: Ints
    start: Ints
    pixels: Ints
    carries: np.ndarray


@lru_cache
def _layout(formats: Formats) -> PacketLayout:
    """The layout of the packets; the formats' own tables are evaluated once."""
    fields = formats.section("edge") | formats.section("second")
    groups = formats.channel_groups
    signs = [1 << (fields[name][1] - 1) if name in SIGNED_FIELDS else 0 for name in FIELDS]
    return PacketLayout(
        *fields["orders"],
        offsets=np.array([fields[name][0] for name in FIELDS]),
        widths=np.array([fields[name][1] for name in FIELDS]),
        signs=np.array(signs),
        second_from=len(FIELDS) - len(EDGE_FIELDS),
        edge_words=formats.section_beats("edge") * formats.beat_words,
        second_words=formats.section_beats("second") * formats.beat_words,
        group_words=formats.difference_beats * formats.beat_words,
        difference_words=formats.difference_words,
        group_size=len(groups[0]),
        built=np.array([built_order(group, formats) for group in groups]),
        channel_differences=np.array(DIFFERENCES_OF_ORDER)[list(formats.channel_max_order)],
        frac_bits=np.array(formats.channel_frac_bits),
        limits=(1 << np.array(formats.channel_value_bits)) - 1,
        word_width=formats.word_width,
        coord_mask=(1 << formats.coord_bits) - 1,
        column_mask=(1 << formats.column_bits) - 1,
        error_mask=(1 << formats.error_bits) - 1,
    )


@numba.njit(cache=True)
def _field(words: Words32, at: int, offset: int, width: int) -> Int:
    """A raw bit field of at most 32 bits of the section at a set-up word; it may stand in two words."""
    at += offset // SETUP_WORD_BITS
    shift = offset % SETUP_WORD_BITS
    raw = np.int64(words[at]) >> shift
    if shift + width > SETUP_WORD_BITS:
        raw |= np.int64(words[at + 1]) << (SETUP_WORD_BITS - shift)
    return raw & ((np.int64(1) << width) - 1)


@numba.njit(cache=True)
def _group_end(group: int, layout: PacketLayout) -> int:
    """The channel behind a group's last one."""
    return min((group + 1) * layout.group_size, len(layout.channel_differences))


@numba.njit(cache=True)
def _group_differences(orders: Int, group: int, layout: PacketLayout) -> int:
    """Differences that a channel group sends."""
    order: Int = 0
    for channel in range(group * layout.group_size, _group_end(group, layout)):
        order = max(order, min((orders >> (2 * channel)) & 3, QUADRATIC))
    return DIFFERENCES_OF_ORDER[min(order, layout.built[group])]


@numba.njit(cache=True)
def _find_packets(words: Words32, layout: PacketLayout) -> Ints:
    """First set-up word of every packet, and the end, which is beyond the stream if a packet is cut off."""
    starts = [0]
    at = 0
    while at < len(words):
        if at + layout.edge_words > len(words):
            starts.append(at + layout.edge_words)
            break
        orders = _field(words, at, layout.orders_offset, layout.orders_width)
        at += layout.edge_words + layout.second_words * (words[at] & 1)
        for group in range(len(layout.built)):
            at += layout.group_words * _group_differences(orders, group, layout)
        starts.append(at)
    return np.array(starts)


@numba.njit(cache=True)
def _read_fields(words: Words32, starts: Ints, layout: PacketLayout) -> Ints:
    """(n, FIELDS) fields of all packets, sign extended where they have one."""
    table = np.zeros((len(starts) - 1, len(layout.offsets)), np.int64)
    for index in range(len(layout.offsets)):
        offset, width, sign = layout.offsets[index], layout.widths[index], layout.signs[index]
        for packet in range(len(table)):
            at = starts[packet]
            raw: Int = 0
            if index < layout.second_from:
                raw = _field(words, at, offset, width)
            elif words[at] & 1:
                raw = _field(words, at + layout.edge_words, offset, width)
            table[packet, index] = (raw ^ sign) - sign
    return table


@numba.njit(cache=True)
def _read_differences(words: Words32, starts: Ints, packets: Records, layout: PacketLayout) -> Ints:
    """(n, c, 6) raw differences; those that were not sent, or are not connected, are zero."""
    channels = len(layout.channel_differences)
    out = np.zeros((len(packets), channels, len(DIFFERENCES)), np.int64)
    for packet in range(len(packets)):
        fields = packets[packet]
        at = starts[packet] + layout.edge_words + layout.second_words * fields["has_second"]
        for group in range(len(layout.built)):
            first = group * layout.group_size
            for difference in range(_group_differences(fields["orders"], group, layout)):
                for channel in range(first, _group_end(group, layout)):
                    if difference < layout.channel_differences[channel]:
                        begin = at + (channel - first) * layout.difference_words
                        for part in range(layout.difference_words):
                            raw = np.int64(words[begin + part])
                            out[packet, channel, difference] |= raw << (SETUP_WORD_BITS * part)
                at += layout.group_words
    return out


@numba.njit(cache=True)
def _packet_rows(fields: Record) -> int:
    """Scanlines that a packet walks."""
    rows = max(fields["rows_first"] + 2, 1)
    return rows + max(fields["rows_second"] + 2, 1) if fields["has_second"] else rows


@numba.njit(cache=True)
def _walk_edges(packets: Records, layout: PacketLayout) -> Scanlines:
    """Every scanline of every packet."""
    column_mask, error_mask = layout.column_mask, layout.error_mask
    sign = (column_mask + 1) >> 1
    error_sign = (error_mask + 1) >> 1
    first_rows = np.zeros(len(packets) + 1, np.int64)
    for packet in range(len(packets)):
        first_rows[packet + 1] = first_rows[packet] + _packet_rows(packets[packet])
    total = first_rows[len(packets)]
    start = np.empty(total, np.int64)
    pixels = np.empty(total, np.int64)
    carries = np.empty(total, np.uint8)
    for packet in range(len(packets)):
        fields = packets[packet]
        major, minor = fields["major"], fields["minor"]
        u, error = major["column"], major["error"]
        end, end_error = minor["column"], minor["error"]
        switch = first_rows[packet] + max(fields["rows_first"] + 2, 1)
        for row in range(first_rows[packet], first_rows[packet + 1]):
            if row == switch:
                minor = fields["second"]
                end, end_error = minor["column"], minor["error"]
            count = (end - u - 2) & column_mask
            if count & sign:
                count -= column_mask + 1
            start[row] = u
            pixels[row] = count + 2 if count >= 0 else count & 1
            carries[row] = error >= 0
            if error >= 0:
                u = (u + major["step"] + 1) & column_mask
                error += major["decrement"]
            else:
                u = (u + major["step"]) & column_mask
                error += major["increment"]
            if end_error >= 0:
                end = (end + minor["step"] + 1) & column_mask
                end_error += minor["decrement"]
            else:
                end = (end + minor["step"]) & column_mask
                end_error += minor["increment"]
            error = ((error + error_sign) & error_mask) - error_sign
            end_error = ((end_error + error_sign) & error_mask) - error_sign
    return Scanlines(first_rows, start, pixels, carries)


class DecodedPackets(NamedTuple):
    """
    A stream before its pixels: where packets start, their fields and differences, and every scanline.

    Attributes
    ----------
    starts : (n + 1,) int64
      Set-up words.
    packets : (n,) records of :data:`PACKET`
    differences : (n, c) records of :data:`CHANNEL`
    scanlines
      Of all packets.
    layout
      Of the packets, for the loops.
    """

    starts: Ints
    packets: Records
    differences: Records
    scanlines: Scanlines
    layout: PacketLayout


def decode_packets(words: np.ndarray, formats: Formats) -> DecodedPackets:
    """
    Read packets and walk their edges.

    Parameters
    ----------
    words : (m,) uint32
    formats : Formats

    Returns
    -------
    DecodedPackets

    Raises
    ------
    QuadshadeError
      The stream ends within a packet.
    """
    layout = _layout(formats)
    words = np.ascontiguousarray(words, dtype=np.uint32)
    starts = _find_packets(words, layout)
    if starts[-1] != len(words):
        raise QuadshadeError("the set-up stream ends within a packet", "send whole packets")
    packets = _read_fields(words, starts, layout).view(PACKET)[:, 0]
    differences = _read_differences(words, starts, packets, layout).view(CHANNEL)[..., 0]
    return DecodedPackets(starts, packets, differences, _walk_edges(packets, layout), layout)
