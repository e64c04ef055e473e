# SPDX-License-Identifier: Apache-2.0
"""
Widths of the fields of packed packets: what packets need of them, and which packet changes which.

For each width a shortest path over the packets is found, past which it may stay wider than they need or
change at the price of an address and a value.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from quadshade.contract.arrays import Bools, Int, Ints
from quadshade.contract.formats import Formats
from quadshade.contract.packed_format import size_of

NEVER = 1 << 60
"""A cost that no path has."""


@njit(cache=True)
def _top_bit(value: Int, is_signed: bool) -> Int:
    """
    The number of the highest bit of a value that has to be sent; 0 if none has to.

    ``is_signed``: what stands above is that bit, and not known.
    """
    left = ~value if value < 0 else value
    length = np.int64(0)
    while left:
        left >>= 1
        length += 1
    return length if is_signed else max(length - 1, np.int64(0))


@njit(cache=True)
def field_tops(values: Ints, halves: Ints, is_signed: Bools, sent: Bools, out: Ints) -> None:
    """Sign extend values (k, n) of fields in place, 0 where they are not sent; write their top bits."""
    for row in range(len(values)):
        half = halves[row]
        for p in range(values.shape[1]):
            # Two's complement, but for what is never below zero.
            value = ((values[row, p] + half) & (2 * half - 1)) - half
            values[row, p] = value if sent[row, p] else 0
            out[row, p] = _top_bit(values[row, p], is_signed[row])


@njit(cache=True)
def word_tops(words: Ints, channels: Ints, differences: Ints, out: Ints) -> None:
    """Write the top bits of words (n, c, 6), difference by difference (k, n)."""
    for row in range(len(channels)):
        for p in range(len(words)):
            out[row, p] = _top_bit(words[p, channels[row], differences[row]], True)


@njit(cache=True)
def _hold_one(
    need: Ints, count: Ints, below: Ints, is_top: bool, change: int, states: int, out: Ints
) -> None:
    """The cheapest values of one width over the packets (``out``): at most ``need``, for a top at least."""
    cost = np.zeros(states, np.int64)
    changed = np.zeros((len(need), states), np.bool_)
    best = np.full(len(need), -1, np.int64)
    cheapest, known = 0, False
    for p in range(len(need)):
        if count[p] == 0:
            continue
        best[p] = cheapest
        anew = cost[cheapest] + change
        first, last = (need[p], states) if is_top else (0, need[p] + 1)
        least = NEVER
        for value in range(states):
            if value < first or value >= last:
                changed[p, value] = not known or anew < cost[value]
                cost[value] = NEVER
                continue
            before = cost[value]
            if not known or anew < before:
                changed[p, value] = True
                before = anew
            bits = max(value + 1 - below[p], 0) if is_top else -value
            cost[value] = before + count[p] * bits
            if cost[value] < least:
                least, cheapest = cost[value], value
        known = True
    value = cheapest
    for p in range(len(need) - 1, -1, -1):
        out[p] = value
        if best[p] >= 0 and changed[p, value]:
            value = best[p]


@njit(cache=True)
def _hold_rows(need: Ints, count: Ints, below: Ints, is_top: bool, change: int, out: Ints) -> None:
    """
    As :func:`_hold_one` of each row (k, n), of values as they are.

    ``out`` stays where no packet sends a field.
    """
    for index in range(len(need)):
        lowest, highest = NEVER, -NEVER
        for p in range(need.shape[1]):
            if count[index, p] > 0:
                lowest, highest = min(lowest, need[index, p]), max(highest, need[index, p])
        if highest >= lowest:
            # No other value is ever the cheapest.
            states = 1 + highest - lowest
            row = out[index]
            _hold_one(need[index] - lowest, count[index], below[index] - lowest, is_top, change, states, row)
            row += lowest


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
    out = np.zeros(need.shape[::-1], np.int64)
    lower = need if below is None else below
    needed, counted, least = (np.ascontiguousarray(table.T) for table in (need, count, lower))
    _hold_rows(needed, counted, least, below is not None, change, out)
    return out.T


@njit(cache=True)
def _count_sent(addresses: Ints, sent: Bools, count: Ints) -> None:
    """Add fields that packets send to those at each address (``count``, (addresses, n))."""
    for row, address in enumerate(addresses):
        for p in range(sent.shape[1]):
            count[address, p] += sent[row, p]


@njit(cache=True)
def _need_tops(addresses: Ints, tops: Ints, sent: Bools, need: Ints, count: Ints) -> None:
    """As :meth:`Needs.tops`; ``need`` and ``count`` (addresses, n)."""
    for row, address in enumerate(addresses):
        for p in range(sent.shape[1]):
            if sent[row, p]:
                need[address, p] = max(need[address, p], tops[row, p])
    _count_sent(addresses, sent, count)


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

    def tops(self, addresses: Ints, tops: Ints, sent: Bools) -> None:
        """
        Fields (k, n) that need their bits up to ``tops``, in the packets that send them.

        ``addresses`` (k,) of their widths may come more than once.
        """
        _need_tops(addresses, tops, sent, self.need.T, self.count.T)

    def differences(self, addresses: Ints, shifts: Ints, tops: Ints, sent: Bools) -> None:
        """Differences (k, n) of channels, without their bits below ``shifts``."""
        self.tops(addresses + 1, tops, sent)
        self.is_below[addresses] = True
        self.below.T[addresses + 1] = self.need.T[addresses] = shifts
        _count_sent(addresses, sent, self.count.T)

    def widths(self, formats: Formats) -> np.ndarray:
        """(n, addresses) int64: the widths of every packet. Bits below are held already."""
        tops = np.flatnonzero(~self.is_below)
        # Address by address: a whole row of memory each.
        widths = self.need.T.copy()
        need, count, below = (table.T[tops].T for table in (self.need, self.count, self.below))
        widths[tops] = hold(need, count, below, formats).T
        return np.ascontiguousarray(widths.T)
