# SPDX-License-Identifier: Apache-2.0
"""
Primitives to packed words, the form in which set-up packets travel (``docs/reference/packing.md``).

Widths of fields stay as they are until a packet changes them. Which packet changes which, and to what, is
chosen for the fewest bits: for each width a shortest path over the packets, past which it may stay wider than
they need or change at the price of an address and a value.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numba import njit

from quadshade.choices import PACK_ERROR
from quadshade.contract.arrays import Bools, Int, Ints, Words32
from quadshade.contract.formats import DIFFERENCES_OF_ORDER, SETUP_WORD_BITS, Formats
from quadshade.contract.packed_format import (
    CHANNEL_KINDS,
    KIND_WIDTHS,
    RAW_FIELDS,
    channel_kinds,
    packed_fields,
    second_at,
    size_of,
)
from quadshade.contract.shade_state import ShadeState, channel_gains
from quadshade.errors import QuadshadeError
from quadshade.golden.link.word_unpacker import WordUnpacker
from quadshade.golden.shade.render_core import needed_writes
from quadshade.packing.widths import Needs, field_tops, hold, word_tops
from quadshade.setup.packet import Primitives, field_values
from quadshade.setup.short_edges import short_edges
from quadshade.setup.short_words import NUM_DIFFERENCES, short_words

LEAST_GAIN = 2.0**-20
"""A channel that counts less than this in a colour is taken as one that counts this much."""

NUM_RAW = len(RAW_FIELDS)


@dataclass(frozen=True)
class Packed:
    """
    A batch of packets for the line.

    Attributes
    ----------
    words : (m,) uint32
      Whole words: batches may follow each other.
    primitives : Primitives
      What is drawn by them: their words and edges are those that the board unpacks.
    starts : (n + 1,) int64
      Bit at which each packet starts, and where the last one ends.
    added : float
      Most that shorter words add to the error of a colour at any pixel, in grey levels.
    vertices : bool
      The words are for a board with ``vertex_unpacker``; the others cannot read them.
    sent_vertices : int
      Primitives that go as vertices.
    """

    words: np.ndarray
    primitives: Primitives
    starts: np.ndarray
    added: float
    vertices: bool = False
    sent_vertices: int = 0


@njit(cache=True)
def _put(out: Words32, at: int, value: Int, bits: int) -> int:
    """Write up to 64 bits of a value, the lowest first; what stands there is zero."""
    if bits:
        shift = np.uint64(at % SETUP_WORD_BITS)
        left = np.uint64(value) & (np.uint64(0xFFFFFFFFFFFFFFFF) >> np.uint64(64 - bits))
        out[at // SETUP_WORD_BITS] |= np.uint32((left << shift) & np.uint64(0xFFFFFFFF))
        left >>= np.uint64(SETUP_WORD_BITS) - shift
        place = at // SETUP_WORD_BITS + 1
        while left:
            out[place] |= np.uint32(left & np.uint64(0xFFFFFFFF))
            left >>= np.uint64(SETUP_WORD_BITS)
            place += 1
    return at + bits


class _Packets(NamedTuple):
    """
    What packets are written from, an entry a packet.

    ``flags`` are the bits of :data:`RAW_FIELDS`; ``fields`` (n, k) the fields from ``y`` on, of which the
    first ``num_fields`` are sent; ``widths`` (n, a) the width at each address, ``used`` where a packet needs
    it; ``aligned`` where it begins with a whole word.
    """

    flags: Ints
    orders: Ints
    fields: Ints
    num_fields: Ints
    words: Ints
    widths: Ints
    used: Ints
    aligned: Bools


class _Layout(NamedTuple):
    """
    What is the same for all packets.

    ``field_bits`` and ``field_addresses`` are those of the fields from ``y`` on, ``kinds`` the channels',
    ``width_bits`` and ``address_bits`` those of a change.
    """

    field_bits: Ints
    field_addresses: Ints
    kinds: Ints
    width_bits: int
    address_bits: int


@njit(cache=True)
def _write(packets: _Packets, layout: _Layout, out: Words32, starts: Ints) -> int:
    """Write all packets; ``starts`` gets their bits. Returns how many bits there are."""
    orders, widths, used, kinds = packets.orders, packets.widths, packets.used, layout.kinds
    held = np.full(widths.shape[1], -1, np.int64)
    last_orders = np.full(orders.shape[1], -1, np.int64)
    at = 0
    for p in range(len(packets.flags)):
        if packets.aligned[p]:
            at += -at % SETUP_WORD_BITS
        starts[p] = at
        at = _put(out, at, 1, 1)
        for address in range(len(held)):
            if used[p, address] and held[address] != widths[p, address]:
                held[address] = widths[p, address]
                at = _put(out, at, 1, 1)
                at = _put(out, at, address, layout.address_bits)
                at = _put(out, at, held[address], layout.width_bits)
        at = _put(out, at, 0, 1)
        at = _put(out, at, packets.flags[p], NUM_RAW)
        same = (orders[p] == last_orders).all()
        at = _put(out, at, np.int64(same), 1)
        if not same:
            last_orders[:] = orders[p]
            for channel in range(len(kinds)):
                at = _put(out, at, orders[p, channel], 2)
        for index in range(packets.num_fields[p]):
            width = widths[p, layout.field_addresses[index]]
            at = _put(out, at, packets.fields[p, index], min(width + 1, layout.field_bits[index]))
        for channel in range(len(kinds)):
            for difference in range(DIFFERENCES_OF_ORDER[orders[p, channel]]):
                address = KIND_WIDTHS * kinds[channel] + 2 * difference
                below, top = widths[p, address], widths[p, address + 1]
                at = _put(out, at, packets.words[p, channel, difference] >> below, max(top + 1 - below, 0))
    starts[len(packets.flags)] = at
    return at


@lru_cache
def _most_bits(formats: Formats) -> int:
    """More bits than a packet has, whatever it says."""
    change = 1 + size_of("width_address_bits", formats) + size_of("width_bits", formats)
    widths = change << size_of("width_address_bits", formats)
    fields = sum(bits for _, bits, _, _ in packed_fields(formats))
    words = formats.carried_channels * (2 + NUM_DIFFERENCES * formats.word_width)
    return 3 + NUM_RAW + widths + fields + words + SETUP_WORD_BITS


def _zeros_below(primitives: Primitives, formats: Formats) -> np.ndarray:
    """(kinds, n, 6) zero bits at the end of all words that share a width: what need not be sent."""
    kinds = np.array(channel_kinds(formats))
    shifts = np.zeros((len(CHANNEL_KINDS), len(primitives), NUM_DIFFERENCES), np.int64)
    sent = np.array(DIFFERENCES_OF_ORDER)[primitives.orders][:, :, None] > np.arange(NUM_DIFFERENCES)
    for kind in sorted(set(channel_kinds(formats))):
        words = np.bitwise_or.reduce((primitives.words * sent)[:, kinds == kind], axis=1)
        # Below the lowest bit that is set; of words of 0, as many as there are.
        below = np.bitwise_count((words & -words) - 1).astype(np.int64)
        most = np.where(words == 0, formats.word_width - 1, below)
        shifts[kind] = hold(most, sent[:, kinds == kind].sum(axis=1), None, formats)
    return shifts


class _FieldTable(NamedTuple):
    """
    Columns of :func:`packed_fields`, an entry a field.

    ``halves`` (k,) are what a field's highest bit counts, 0 if it is never below zero; ``is_signed`` (k,)
    where that bit stands above.
    """

    names: tuple[str, ...]
    bits: Ints
    addresses: Ints
    halves: Ints
    is_signed: Bools


@lru_cache
def _field_table(formats: Formats) -> _FieldTable:
    names, bits, addresses, fills = zip(*packed_fields(formats), strict=True)
    halves = [0 if fill == "zero" else 1 << (width - 1) for width, fill in zip(bits, fills, strict=True)]
    is_signed = np.array([fill == "sign" for fill in fills])
    return _FieldTable(names, np.array(bits), np.array(addresses), np.array(halves), is_signed)


@lru_cache
def _difference_table(formats: Formats) -> np.ndarray:
    """(3, k) int64: of each difference that a packet may have its channel, number, and the channel's kind."""
    kinds, orders = channel_kinds(formats), formats.channel_max_order
    rows = [
        (channel, difference, kind)
        for channel, (kind, order) in enumerate(zip(kinds, orders, strict=True))
        for difference in range(DIFFERENCES_OF_ORDER[order])
    ]
    return np.array(rows, np.int64).T


def _laid_out(
    primitives: Primitives, shifts: np.ndarray, has_second: np.ndarray, formats: Formats
) -> tuple[np.ndarray, Needs]:
    """(n, fields) values of the packets' fields from y on, and what widths they and the words need."""
    size = len(primitives)
    needs, table = Needs(size, formats), _field_table(formats)
    values = np.empty((len(table.names), size), np.int64)
    for row, name in zip(values, table.names, strict=True):
        row[:] = field_values(primitives, name, formats)
    sent = np.ones(values.shape, np.bool_)
    sent[second_at(formats) :] = has_second
    tops = np.empty_like(values)
    field_tops(values, table.halves, table.is_signed, sent, tops)
    needs.tops(table.addresses, tops, sent)
    channels, differences, kinds = _difference_table(formats)
    tops = np.empty((len(channels), size), np.int64)
    word_tops(primitives.words, channels, differences, tops)
    sent = np.array(DIFFERENCES_OF_ORDER)[primitives.orders].T[channels] > differences[:, None]
    needs.differences(KIND_WIDTHS * kinds + 2 * differences, shifts[kinds, :, differences], tops, sent)
    return np.ascontiguousarray(values.T), needs


def error_budgets(formats: Formats, error: float, state: ShadeState | None = None) -> np.ndarray:
    """
    How much of an error in the colour each channel may add, in its own output units.

    Parameters
    ----------
    formats : Formats
    error : float
      Grey levels of a pixel's colour; of depth as many units.
    state : ShadeState, optional
      Of the shade unit, where channels add up: each gets an equal share, over what the unit makes of it.

    Returns
    -------
    (c,) float64
    """
    budgets = np.full(formats.carried_channels, float(error))
    if formats.with_shade and state is not None:
        budgets[: formats.num_channels] /= formats.num_channels * np.maximum(
            channel_gains(state, formats), LEAST_GAIN
        )
    return budgets


def pack_primitives(
    primitives: Primitives,
    formats: Formats,
    error: float = PACK_ERROR,
    state: ShadeState | None = None,
    aligned: np.ndarray | None = None,
) -> Packed:
    """
    Pack primitives for the line.

    Parameters
    ----------
    primitives : Primitives
    formats : Formats
      With a set-up stream of 32 bits.
    error : float
      Grey levels that shorter words may add to the error at a pixel; 0: edges and words stay as they are.
    state : ShadeState, optional
      Of the shade unit, for formats that have it.
    aligned : (n,) bool, optional
      Packets that begin with a whole word.

    Returns
    -------
    Packed

    Raises
    ------
    QuadshadeError
      A stream of another width, or an error that is no number from 0 on.
    """
    WordUnpacker.check(formats)
    if not 0.0 <= error < np.inf:
        raise QuadshadeError(f"the error of packing is {error!r}", "give grey levels, 0 or more")
    size, before = len(primitives), primitives.bound
    zeros = np.zeros(size, np.int64)
    shifts = np.zeros((len(CHANNEL_KINDS), size, NUM_DIFFERENCES), np.int64)
    if error > 0.0 and size:
        primitives, shifts = short_words(
            replace(primitives, edges=short_edges(primitives)),
            formats,
            error_budgets(formats, error, state),
            lambda most, sent: hold(most, sent, None, formats),
        )
    elif size:
        shifts = _zeros_below(primitives, formats)
    header = primitives.header
    has_second = header["has_second"] != 0
    values, needs = _laid_out(primitives, shifts, has_second, formats)
    packets = _Packets(
        sum((header[name].astype(np.int64) << place for place, name in enumerate(RAW_FIELDS)), start=zeros),
        primitives.orders.astype(np.int64),
        values,
        np.where(has_second, values.shape[1], second_at(formats)),
        primitives.words,
        needs.widths(formats),
        needs.count,
        np.zeros(size, np.bool_) if aligned is None else aligned,
    )
    layout = _Layout(
        _field_table(formats).bits,
        _field_table(formats).addresses,
        np.array(channel_kinds(formats)),
        size_of("width_bits", formats),
        size_of("width_address_bits", formats),
    )
    starts = np.zeros(size + 1, np.int64)
    room = np.zeros(size * _most_bits(formats) // SETUP_WORD_BITS + 1, np.uint32)
    bits = _write(packets, layout, room, starts)
    words = room[: -(-bits // SETUP_WORD_BITS)].copy()
    added = (primitives.bound - before)[:, : formats.num_channels]
    return Packed(words, primitives, starts, float(added.max(initial=0.0)))


def unpack(words: np.ndarray, formats: Formats) -> np.ndarray:
    """
    The set-up words of whole packets: the inverse of :func:`pack_primitives`.

    Parameters
    ----------
    words : (m,) uint32
    formats : Formats

    Returns
    -------
    (k,) uint32

    Raises
    ------
    QuadshadeError
      The words end within a packet.
    """
    unpacker = WordUnpacker(formats)
    setup_words = unpacker.feed(words)
    if unpacker.within:
        raise QuadshadeError("the packed words end within a packet", "send whole packets")
    return setup_words


def packed_writes(words: np.ndarray, state: ShadeState, formats: Formats) -> np.ndarray:
    """(k, 2) uint32 addresses and data that load a state for packed words: of its tables what they read."""
    if not state.tables.size:
        return state.writes()
    return needed_writes(unpack(words, formats), state, formats)
