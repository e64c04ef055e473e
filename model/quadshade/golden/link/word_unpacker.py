# SPDX-License-Identifier: Apache-2.0
"""
Packed words to set-up words: what the line carries, to what the core takes. Bit by bit, as the hardware.

``docs/reference/packing.md`` explains the packed stream.
The widths of fields stay from packet to packet until they are changed, and so do the
channels' orders; reset forgets both.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numba import njit

from quadshade.contract.formats import DIFFERENCES_OF_ORDER, QUADRATIC, SETUP_WORD_BITS, Formats
from quadshade.contract.packed_format import (
    FILLS,
    KIND_WIDTHS,
    RAW_FIELDS,
    channel_kinds,
    packed_fields,
    second_at,
    size_of,
)
from quadshade.errors import QuadshadeError

NUM_RAW = len(RAW_FIELDS)
_ONE, _SIGN = FILLS.index("one"), FILLS.index("sign")
_BIT, _WORD, _WORD_BITS, _COUNT = range(4)
"""Where the next bit is read; the set-up word that is begun, its bits; how many set-up words are whole."""


class StarvedError(Exception):
    """The words end within a packet."""


@njit(cache=True)
def _take(words, place):
    """The next bit of the packed words."""
    if place[_BIT] >= SETUP_WORD_BITS * len(words):
        raise StarvedError
    bit = (np.int64(words[place[_BIT] // SETUP_WORD_BITS]) >> (place[_BIT] % SETUP_WORD_BITS)) & 1
    place[_BIT] += 1
    return bit


@njit(cache=True)
def _number(words, place, bits):
    """The next few bits, the lowest first."""
    value = np.int64(0)
    for index in range(bits):
        value |= _take(words, place) << index
    return value


@njit(cache=True)
def _give(bit, place, out):
    """Another bit of the set-up words."""
    place[_WORD] |= bit << place[_WORD_BITS]
    place[_WORD_BITS] += 1
    if place[_WORD_BITS] == SETUP_WORD_BITS:
        out[place[_COUNT]] = place[_WORD]
        place[_COUNT] += 1
        place[_WORD] = place[_WORD_BITS] = 0


@njit(cache=True)
def _field(words, place, out, length, below, top, fill):
    """Zeros below bit ``below``, bits from the line up to bit ``top``, then the fill; 2: the last of them."""
    last = np.int64(fill == _ONE)
    for position in range(length):
        bit = last
        if position < below:
            bit = np.int64(0)
        elif position <= top:
            bit = _take(words, place)
            if fill == _SIGN:
                last = bit
        _give(bit, place, out)


@njit(cache=True)
def _pad(place, out):
    """Zeros up to the end of a set-up word."""
    while place[_WORD_BITS] > 0:
        _give(np.int64(0), place, out)


@njit(cache=True)
def _changes(words, place, widths, width_bits, address_bits):
    """Widths that are new for this packet and those behind it; no more than there are addresses."""
    for _ in range(1 << address_bits):
        if not _take(words, place):
            return
        address = _number(words, place, address_bits)
        widths[address] = _number(words, place, width_bits)


@njit(cache=True)
def _packet(words, place, widths, orders, fields, second_at, kinds, built, word_width, sizes, out):
    """One packet, from its start bit on; False if only zeros are left."""
    started = False
    while not started:
        if place[_BIT] == SETUP_WORD_BITS * len(words):
            return False
        started = _take(words, place) == 1
    _changes(words, place, widths, sizes[0], sizes[1])
    flags = _number(words, place, NUM_RAW)
    for index in range(NUM_RAW):
        _give((flags >> index) & 1, place, out)
    same = _take(words, place)
    for index in range(2 * len(kinds)):
        if not same:
            orders[index] = _take(words, place)
        _give(orders[index], place, out)
    for index in range(len(fields) if flags & 1 else second_at):
        if index == second_at:
            _pad(place, out)
        length, address, fill = fields[index]
        _field(words, place, out, length, 0, widths[address], fill)
    _pad(place, out)
    for channel in range(len(kinds)):
        order = min(orders[2 * channel] + 2 * orders[2 * channel + 1], QUADRATIC, built[channel])
        for difference in range(DIFFERENCES_OF_ORDER[order]):
            address = KIND_WIDTHS * kinds[channel] + 2 * difference
            _field(words, place, out, word_width, widths[address], widths[address + 1], _SIGN)
            _pad(place, out)
    return True


class WordUnpacker:
    """
    Unpacks words as they come.

    Parameters
    ----------
    formats : Formats

    Raises
    ------
    QuadshadeError
      A set-up stream of another width than 32 bits.

    Attributes
    ----------
    within : bool
      The words so far end within a packet.
    begun : list of int
      Set-up words that the hardware has already put out of a packet whose words are not all there.
    """

    def __init__(self, formats: Formats) -> None:
        self.check(formats)
        self._fields = np.array(
            [(bits, address, FILLS.index(fill)) for _, bits, address, fill in packed_fields(formats)]
        )
        self._second_at = second_at(formats)
        self._kinds = np.array(channel_kinds(formats))
        self._built = np.array(formats.channel_max_order)
        self._word_width = formats.word_width
        self._sizes = (size_of("width_bits", formats), size_of("width_address_bits", formats))
        sections = formats.section_beats("edge") + formats.section_beats("second")
        self.most_words = sections + DIFFERENCES_OF_ORDER[QUADRATIC] * formats.difference_words * len(
            self._kinds
        )
        self.reset()

    @staticmethod
    def check(formats: Formats) -> None:
        """Raise :class:`QuadshadeError` where the set-up stream has another width than 32 bits."""
        if formats.stream_width != SETUP_WORD_BITS:
            raise QuadshadeError(
                f"generic stream_width is {formats.stream_width}", f"packed words need {SETUP_WORD_BITS}"
            )

    def reset(self) -> None:
        """Forget widths, orders and a begun packet."""
        self._widths = np.zeros(1 << self._sizes[1], np.int64)
        self._orders = np.zeros(2 * len(self._kinds), np.int64)
        self._rest = np.zeros(0, np.uint32)
        self._skip = 0
        self.within, self.begun = False, []

    @property
    def widths(self) -> list[int]:
        """Widths by address, as the packets so far have left them."""
        return self._widths.tolist()

    def packets(self, words: Sequence[int] | np.ndarray) -> Iterator[tuple[int, int, np.ndarray]]:
        """
        Take packed words, packet by packet.

        Parameters
        ----------
        words : (n,) uint32

        Yields
        ------
        start, end : int
          Bits of the packet, counted from the first of these words; a packet may have begun before it.
        setup_words : (m,) uint32
        """
        before = SETUP_WORD_BITS * len(self._rest)
        words = np.concatenate([self._rest, np.asarray(words, np.uint32)])
        place = np.zeros(4, np.int64)
        place[_BIT] = self._skip
        out = np.zeros(self.most_words, np.uint32)
        self.within, self.begun = False, []
        while True:
            start = place[_BIT]
            widths, orders = self._widths.copy(), self._orders.copy()
            try:
                more = _packet(
                    words, place, widths, orders, self._fields, self._second_at, self._kinds, self._built,
                    self._word_width, self._sizes, out,
                )  # fmt: skip
            except StarvedError:
                self.within, self.begun = True, out[: place[_COUNT]].tolist()
                place[_BIT] = start
                break
            if not more:
                break
            self._widths, self._orders = widths, orders
            yield int(start) - before, int(place[_BIT]) - before, out[: place[_COUNT]].copy()
            place[_COUNT] = 0
        done = place[_BIT] // SETUP_WORD_BITS
        self._rest, self._skip = words[done:], int(place[_BIT] % SETUP_WORD_BITS)

    def feed(self, words: Sequence[int] | np.ndarray) -> np.ndarray:
        """
        Take packed words.

        Parameters
        ----------
        words : (n,) uint32

        Returns
        -------
        (m,) uint32
          Set-up words of the packets that are whole now.
        """
        setup_words = [setup_words for _, _, setup_words in self.packets(words)]
        return np.concatenate(setup_words) if setup_words else np.zeros(0, np.uint32)
