# SPDX-License-Identifier: Apache-2.0
"""
Packed words to set-up words: what the line carries, to what the core takes. Bit by bit, as the hardware.

``docs/reference/packing.md`` explains the packed stream.
The widths of fields stay from packet to packet until they are changed, and so do the
channels' orders; reset forgets both.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numba import njit

from quadshade.contract.arrays import Int, Ints, Words32, record_dtype
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


class _Place:
    """
    Columns of how far the unpacker is.

    ``bit`` is read next; ``word`` is the set-up word that is begun, ``word_bits`` how many of its bits are
    there; ``count`` set-up words are whole.
    """

    bit: int
    word: int
    word_bits: int
    count: int


_PLACE = record_dtype(_Place)


class _Layout(NamedTuple):
    """
    What the kernels need of the formats.

    ``fields`` (k, 3) are bits, address and fill of each field, those of the second section from ``second_at``
    on; ``kinds`` and ``built`` are each channel's kind and highest order, ``width_bits`` and ``address_bits``
    those of a change.
    """

    fields: Ints
    second_at: int
    kinds: Ints
    built: Ints
    word_width: int
    width_bits: int
    address_bits: int


class StarvedError(Exception):
    """The words end within a packet."""


@njit(cache=True)
def _take(words: Words32, place: _Place) -> Int:
    """The next bit of the packed words."""
    if place.bit >= SETUP_WORD_BITS * len(words):
        raise StarvedError
    bit = (np.int64(words[place.bit // SETUP_WORD_BITS]) >> (place.bit % SETUP_WORD_BITS)) & 1
    place.bit += 1
    return bit


@njit(cache=True)
def _number(words: Words32, place: _Place, bits: int) -> Int:
    """The next few bits, the lowest first."""
    value: Int = np.int64(0)
    for index in range(bits):
        value = value | _take(words, place) << index
    return value


@njit(cache=True)
def _give(bit: Int, place: _Place, out: Words32) -> None:
    """Another bit of the set-up words."""
    place.word = int(place.word | bit << place.word_bits)
    place.word_bits += 1
    if place.word_bits == SETUP_WORD_BITS:
        out[place.count] = place.word
        place.count += 1
        place.word = place.word_bits = 0


@njit(cache=True)
def _field(words: Words32, place: _Place, out: Words32, length: int, below: int, top: int, fill: int) -> None:
    """Zeros below bit ``below``, bits from the line up to bit ``top``, then the fill; 2: the last of them."""
    last: Int = np.int64(fill == _ONE)
    for position in range(length):
        bit: Int = last
        if position < below:
            bit = np.int64(0)
        elif position <= top:
            bit = _take(words, place)
            if fill == _SIGN:
                last = bit
        _give(bit, place, out)


@njit(cache=True)
def _pad(place: _Place, out: Words32) -> None:
    """Zeros up to the end of a set-up word."""
    while place.word_bits > 0:
        _give(np.int64(0), place, out)


@njit(cache=True)
def _changes(words: Words32, place: _Place, widths: Ints, layout: _Layout) -> None:
    """Widths that are new for this packet and those behind it; no more than there are addresses."""
    for _ in range(1 << layout.address_bits):
        if not _take(words, place):
            return
        address = _number(words, place, layout.address_bits)
        widths[address] = _number(words, place, layout.width_bits)


@njit(cache=True)
def _packet(words: Words32, place: _Place, widths: Ints, orders: Ints, layout: _Layout, out: Words32) -> bool:
    """One packet, from its start bit on; False if only zeros are left."""
    started = False
    while not started:
        if place.bit == SETUP_WORD_BITS * len(words):
            return False
        started = _take(words, place) == 1
    _changes(words, place, widths, layout)
    flags = _number(words, place, NUM_RAW)
    for index in range(NUM_RAW):
        _give((flags >> index) & 1, place, out)
    same = _take(words, place)
    for index in range(2 * len(layout.kinds)):
        if not same:
            orders[index] = _take(words, place)
        _give(orders[index], place, out)
    for index in range(len(layout.fields) if flags & 1 else layout.second_at):
        if index == layout.second_at:
            _pad(place, out)
        length, address, fill = layout.fields[index]
        _field(words, place, out, length, 0, widths[address], fill)
    _pad(place, out)
    for channel in range(len(layout.kinds)):
        order = min(orders[2 * channel] + 2 * orders[2 * channel + 1], QUADRATIC, layout.built[channel])
        for difference in range(DIFFERENCES_OF_ORDER[order]):
            address = KIND_WIDTHS * layout.kinds[channel] + 2 * difference
            _field(words, place, out, layout.word_width, widths[address], widths[address + 1], _SIGN)
            _pad(place, out)
    return True


TAKES, GIVES, RESTS = 1, 2, 4
"""What the hardware does in a clock: takes a bit of the line, gives one to the core, waits for a packet."""


@njit(cache=True)
def _add(clocks: Ints, size: int, what: int, count: int) -> int:
    """So many clocks of one kind behind ``size`` others; how many there are then."""
    for index in range(count):
        clocks[size + index] = what
    return size + count


@njit(cache=True)
def _field_clocks(clocks: Ints, size: int, length: int, below: int, top: int) -> int:
    """Clocks of a field's bits, one each."""
    for position in range(length):
        sent = below <= position <= top
        clocks[size + position] = GIVES | TAKES if sent else GIVES
    return size + length


@njit(cache=True)
def _packet_clocks(
    words: Words32, place: _Place, widths: Ints, orders: Ints, layout: _Layout, clocks: Ints
) -> int:
    """What the hardware does for one packet, clock by clock, where nothing makes it wait; 0 without one."""
    size = 0
    started = False
    while not started:
        if place.bit == SETUP_WORD_BITS * len(words):
            return _add(clocks, 0, TAKES | RESTS, size)
        started = _take(words, place) == 1
        size += 1
    size = _add(clocks, 0, TAKES | RESTS, size)
    changes, most = 0, 1 << layout.address_bits
    while changes < most:
        size = _add(clocks, size, TAKES, 1)
        if not _take(words, place):
            break
        address = _number(words, place, layout.address_bits)
        widths[address] = _number(words, place, layout.width_bits)
        size = _add(clocks, size, TAKES, layout.address_bits + layout.width_bits)
        # It is stored.
        size = _add(clocks, size, 0, 1)
        changes += 1
    flags = _number(words, place, NUM_RAW)
    size = _add(clocks, size, TAKES | GIVES, NUM_RAW)
    same = _take(words, place)
    size = _add(clocks, size, TAKES, 1)
    for index in range(2 * len(layout.kinds)):
        if not same:
            orders[index] = _take(words, place)
        size = _add(clocks, size, GIVES if same else TAKES | GIVES, 1)
    given = NUM_RAW + 2 * len(layout.kinds)
    for index in range(len(layout.fields) if flags & 1 else layout.second_at):
        length, address, _ = layout.fields[index]
        if index == layout.second_at:
            size = _add(clocks, size, GIVES, -given % SETUP_WORD_BITS)
            size, given = _add(clocks, size, 0, 1), 0
        size = _add(clocks, size, 0, 1)
        size = _field_clocks(clocks, size, length, 0, widths[address])
        _number(words, place, min(widths[address] + 1, length))
        given += length
    size = _add(clocks, size, GIVES, -given % SETUP_WORD_BITS)
    size = _add(clocks, size, 0, 1)
    for channel in range(len(layout.kinds)):
        order = min(orders[2 * channel] + 2 * orders[2 * channel + 1], QUADRATIC, layout.built[channel])
        for difference in range(DIFFERENCES_OF_ORDER[order]):
            address = KIND_WIDTHS * layout.kinds[channel] + 2 * difference
            # The width is fetched, then read.
            size = _add(clocks, size, 0, 2)
            size = _field_clocks(clocks, size, layout.word_width, widths[address], widths[address + 1])
            _number(words, place, max(widths[address + 1] + 1 - widths[address], 0))
            size = _add(clocks, size, GIVES, -layout.word_width % SETUP_WORD_BITS)
            size = _add(clocks, size, 0, 1)
    return size


@njit(cache=True)
def _all_clocks(words: Words32, place: _Place, layout: _Layout, most: int) -> Ints:
    """:func:`_packet_clocks` of all packets, and of the bits behind the last one."""
    widths = np.zeros(1 << layout.address_bits, np.int64)
    orders = np.zeros(2 * len(layout.kinds), np.int64)
    piece, out = np.zeros(most, np.int64), np.zeros(most, np.int64)
    size = 0
    while place.bit < SETUP_WORD_BITS * len(words):
        count = _packet_clocks(words, place, widths, orders, layout, piece)
        while size + count > len(out):
            out = np.concatenate((out, np.zeros(len(out), np.int64)))
        out[size : size + count] = piece[:count]
        size += count
    return out[:size]


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
        fields = packed_fields(formats)
        self._layout = _Layout(
            np.array([(bits, address, FILLS.index(fill)) for _, bits, address, fill in fields]),
            second_at(formats),
            np.array(channel_kinds(formats)),
            np.array(formats.channel_max_order),
            formats.word_width,
            size_of("width_bits", formats),
            size_of("width_address_bits", formats),
        )
        sections = formats.section_beats("edge") + formats.section_beats("second")
        differences = DIFFERENCES_OF_ORDER[QUADRATIC] * formats.carried_channels
        self.most_words = sections + differences * formats.difference_words
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
        self._widths = np.zeros(1 << self._layout.address_bits, np.int64)
        self._orders = np.zeros(2 * len(self._layout.kinds), np.int64)
        self._rest = np.zeros(0, np.uint32)
        self._skip = 0
        self.within = False
        self.begun: list[int] = []

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
        place = np.zeros(1, _PLACE)[0]
        place["bit"] = self._skip
        out = np.zeros(self.most_words, np.uint32)
        self.within, self.begun = False, []
        while True:
            start = int(place["bit"])
            widths, orders = self._widths.copy(), self._orders.copy()
            try:
                more = _packet(words, place, widths, orders, self._layout, out)
            except StarvedError:
                self.within, self.begun = True, out[: place["count"]].tolist()
                place["bit"] = start
                break
            if not more:
                break
            self._widths, self._orders = widths, orders
            yield start - before, int(place["bit"]) - before, out[: place["count"]].copy()
            place["count"] = 0
        done, self._skip = divmod(int(place["bit"]), SETUP_WORD_BITS)
        self._rest = words[done:]

    def clocks(self, words: np.ndarray) -> np.ndarray:
        """
        What the hardware does with words after a reset, clock by clock, where nothing makes it wait.

        Parameters
        ----------
        words : (n,) uint32
          Whole packets.

        Returns
        -------
        (k,) int64
          Sums of ``TAKES``, ``GIVES`` and ``RESTS``.
        """
        bits = SETUP_WORD_BITS * (self.most_words + len(self._widths)) + 8 * len(self._widths)
        place = np.zeros(1, _PLACE)[0]
        return _all_clocks(np.asarray(words, np.uint32), place, self._layout, bits + SETUP_WORD_BITS)

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
