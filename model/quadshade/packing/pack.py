# SPDX-License-Identifier: Apache-2.0
"""
Primitives to packed words, the form in which set-up packets travel (``docs/reference/packing.md``).

Widths of fields stay as they are until a packet changes them. Which packet changes which, and to what, is
chosen for the fewest bits: for each width a shortest path over the packets, past which it may stay wider than
they need or change at the price of an address and a value.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numba import njit

from quadshade.choices import PACK_ERROR
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
    """

    words: np.ndarray
    primitives: Primitives
    starts: np.ndarray
    added: float


@njit(cache=True)
def _bits_sent(value, below, is_top):
    return max(value + 1 - below, 0) if is_top else -value


@njit(cache=True)
def _hold_one(need, count, below, is_top, change, states, out):
    """The cheapest values of one width over the packets (``out``): at most ``need``, for a top at least."""
    cost, before = np.zeros(states), np.zeros(states)
    changed = np.zeros((len(need), states), np.bool_)
    best = np.zeros(len(need), np.int64)
    known = False
    for p in range(len(need)):
        if count[p] == 0:
            best[p] = -1
            continue
        before[:] = cost
        best[p] = np.argmin(before)
        for value in range(states):
            if not known or before[best[p]] + change < before[value]:
                changed[p, value] = True
                cost[value] = before[best[p]] + change
            if value < need[p] if is_top else value > need[p]:
                cost[value] = np.inf
            else:
                cost[value] += count[p] * _bits_sent(value, below[p], is_top)
        known = True
    value = np.argmin(cost)
    for p in range(len(need) - 1, -1, -1):
        out[p] = value
        if best[p] >= 0 and changed[p, value]:
            value = best[p]


def hold(need: np.ndarray, count: np.ndarray, below: np.ndarray | None, formats: Formats) -> np.ndarray:
    """
    Values of widths over the packets, each held as long as that takes the fewest bits.

    Parameters
    ----------
    need : (n, k) int64
      What each packet needs of each of k widths: of a top at least this, of bits below at most this.
    count : (n, k) int64
      Fields that each packet sends with it; where 0 anything will do.
    below : (n, k) int64 or None
      For tops the bits below, which are not sent.
    formats : Formats

    Returns
    -------
    (n, k) int64
    """
    change = 1 + size_of("width_address_bits", formats) + size_of("width_bits", formats)
    out = np.zeros_like(need)
    for index in range(need.shape[1]):
        asked = need[count[:, index] > 0, index]
        if not len(asked):
            continue
        # No other value is ever the cheapest.
        lowest, values = asked.min(), 1 + asked.max() - asked.min()
        column = np.zeros(len(need), np.int64)
        _hold_one(
            need[:, index] - lowest,
            np.ascontiguousarray(count[:, index]),
            column if below is None else below[:, index] - lowest,
            below is not None,
            float(change),
            values,
            column,
        )
        out[:, index] = column + lowest
    return out


@njit(cache=True)
def _put(out, at, value, bits):
    """Write bits, the lowest first; without words to write to only count them."""
    if len(out):
        for index in range(bits):
            place = at + index
            out[place // SETUP_WORD_BITS] |= np.uint32(((value >> index) & 1) << (place % SETUP_WORD_BITS))
    return at + bits


@njit(cache=True)
def _write(flags, orders, fields, num_fields, words, widths, used, table, kinds, sizes, out, starts):
    """Write all packets; ``starts`` gets their bits. Returns how many bits there are."""
    held = np.full(widths.shape[1], -1, np.int64)
    last_orders = np.full(orders.shape[1], -1, np.int64)
    at = 0
    for p in range(len(flags)):
        starts[p] = at
        at = _put(out, at, 1, 1)
        for address in range(len(held)):
            if used[p, address] and held[address] != widths[p, address]:
                held[address] = widths[p, address]
                at = _put(out, at, 1, 1)
                at = _put(out, at, address, sizes[1])
                at = _put(out, at, held[address], sizes[0])
        at = _put(out, at, 0, 1)
        at = _put(out, at, flags[p], NUM_RAW)
        same = (orders[p] == last_orders).all()
        at = _put(out, at, np.int64(same), 1)
        if not same:
            last_orders[:] = orders[p]
            for channel in range(len(kinds)):
                at = _put(out, at, orders[p, channel], 2)
        for index in range(num_fields[p]):
            at = _put(out, at, fields[p, index], min(widths[p, table[index, 1]] + 1, table[index, 0]))
        for channel in range(len(kinds)):
            for difference in range(DIFFERENCES_OF_ORDER[orders[p, channel]]):
                address = KIND_WIDTHS * kinds[channel] + 2 * difference
                below, top = widths[p, address], widths[p, address + 1]
                at = _put(out, at, words[p, channel, difference] >> below, max(top + 1 - below, 0))
    starts[len(flags)] = at
    return at


def _top_bits(values: np.ndarray, fill: str) -> np.ndarray:
    """The number of the highest bit that has to be sent of each value; 0 if none has to."""
    magnitude = np.where(values < 0, ~values, values)
    length = np.zeros(values.shape, np.int64)
    for step in (32, 16, 8, 4, 2, 1):
        more = magnitude >> step > 0
        length += step * more
        magnitude = np.where(more, magnitude >> step, magnitude)
    length += magnitude > 0
    return length if fill == "sign" else np.maximum(length - 1, 0)


def _signed(values: np.ndarray, bits: int) -> np.ndarray:
    """Two's complement of some bits, sign extended."""
    half = 1 << (bits - 1)
    return ((values + half) & (2 * half - 1)) - half


class Needs:
    """
    What packets need of each width, address by address.

    Attributes
    ----------
    need, count, below : (n, addresses) int64
      As for :func:`hold`.
    is_below : (addresses,) bool
      Addresses of numbers of bits that are not sent.
    """

    def __init__(self, size: int, formats: Formats) -> None:
        addresses = 1 << size_of("width_address_bits", formats)
        # Address by address in memory.
        self.need, self.count, self.below = (np.zeros((addresses, size), np.int64).T for _ in range(3))
        self.is_below = np.zeros(addresses, bool)

    def top(self, address: int, top: np.ndarray, sent: np.ndarray) -> None:
        """A field that needs its bits up to ``top``, in the packets that send it."""
        self.need[:, address] = np.maximum(self.need[:, address], np.where(sent, top, 0))
        self.count[:, address] += sent

    def difference(self, address: int, shifts: np.ndarray, top: np.ndarray, sent: np.ndarray) -> None:
        """A difference of a channel, without its bits below ``shifts``."""
        self.top(address + 1, top, sent)
        self.is_below[address] = True
        self.below[:, address + 1] = self.need[:, address] = shifts
        self.count[:, address] += sent

    def widths(self, formats: Formats) -> np.ndarray:
        """(n, addresses) int64: the widths of every packet. Bits below are held already."""
        widths, tops = self.need.copy(order="C"), ~self.is_below
        widths[:, tops] = hold(self.need[:, tops], self.count[:, tops], self.below[:, tops], formats)
        return widths


def _laid_out(
    primitives: Primitives, shifts: np.ndarray, has_second: np.ndarray, formats: Formats
) -> tuple[np.ndarray, Needs]:
    """(n, fields) values of the packets' fields from y on, and what widths they and the words need."""
    size, first_second = len(primitives), second_at(formats)
    needs = Needs(size, formats)
    values = np.zeros((size, len(packed_fields(formats))), np.int64)
    for index, (name, bits, address, fill) in enumerate(packed_fields(formats)):
        sent = has_second if index >= first_second else np.ones(size, bool)
        raw = field_values(primitives, name, formats)
        values[:, index] = np.where(sent, raw if fill == "zero" else _signed(raw, bits), 0)
        needs.top(address, _top_bits(values[:, index], fill), sent)
    differences = np.array(DIFFERENCES_OF_ORDER)[primitives.orders]
    for channel, (kind, order) in enumerate(
        zip(channel_kinds(formats), formats.channel_max_order, strict=True)
    ):
        for difference in range(DIFFERENCES_OF_ORDER[order]):
            top = _top_bits(primitives.words[:, channel, difference], "sign")
            address = KIND_WIDTHS * kind + 2 * difference
            needs.difference(address, shifts[kind, :, difference], top, differences[:, channel] > difference)
    return values, needs


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
    primitives: Primitives, formats: Formats, error: float = PACK_ERROR, state: ShadeState | None = None
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
    shifts = np.zeros((len(CHANNEL_KINDS), size, NUM_DIFFERENCES), np.int64)
    if error > 0.0 and size:
        primitives, shifts = short_words(
            replace(primitives, edges=short_edges(primitives)),
            formats,
            error_budgets(formats, error, state),
            lambda most, sent: hold(most, sent, None, formats),
        )
    header = primitives.header
    has_second = header["has_second"] != 0
    values, needs = _laid_out(primitives, shifts, has_second, formats)
    packets = (
        sum(header[name].astype(np.int64) << place for place, name in enumerate(RAW_FIELDS)),
        primitives.orders.astype(np.int64),
        values,
        np.where(has_second, values.shape[1], second_at(formats)),
        primitives.words,
        needs.widths(formats),
        needs.count,
        np.array([(bits, address) for _, bits, address, _ in packed_fields(formats)]),
        np.array(channel_kinds(formats)),
        (size_of("width_bits", formats), size_of("width_address_bits", formats)),
    )
    starts = np.zeros(size + 1, np.int64)
    bits = _write(*packets, np.zeros(0, np.uint32), starts)
    words = np.zeros(-(-bits // SETUP_WORD_BITS), np.uint32)
    _write(*packets, words, starts)
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
