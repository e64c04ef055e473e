# SPDX-License-Identifier: Apache-2.0
"""Words to packets: edges as bit fields, then the channels' differences (``rtl/core/setup_loader.vhd``)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from quadshade.contract.formats import (
    DIFFERENCES,
    DIFFERENCES_OF_ORDER,
    QUADRATIC,
    SECTIONS,
    SETUP_WORD_BITS,
    Formats,
)
from quadshade.errors import QuadshadeError


@dataclass
class Packet:
    """
    What the loader holds when a packet is complete.

    Attributes
    ----------
    fields : dict of int
      Raw value of every bit field of the sections ``edge`` and ``second`` (zero where that was not sent).
    words : list of list of int
      Six raw differences a carried channel; differences that were not sent are zero.
    beats : int
      Beats the packet took.
    """

    fields: dict[str, int]
    words: list[list[int]]
    beats: int


def built_order(group: Sequence[int], formats: Formats) -> int:
    """Highest order that the channels of a group are built for."""
    return max(formats.channel_max_order[channel] for channel in group)


def group_order(orders: int, group: Sequence[int], formats: Formats) -> int:
    """Highest order that a group's channels are sent in, of the field ``orders``."""
    sent = max(min((orders >> (2 * channel)) & 3, QUADRATIC) for channel in group)
    return min(sent, built_order(group, formats))


def packet_beats(header: int, formats: Formats) -> int:
    """Beats of a packet, which its first set-up word names."""
    raw = {
        name: (header >> offset) & ((1 << width) - 1)
        for name, (offset, width) in formats.section("edge").items()
    }
    count = formats.section_beats("edge") + raw["has_second"] * formats.section_beats("second")
    for group in formats.channel_groups:
        order = group_order(raw["orders"], group, formats)
        count += DIFFERENCES_OF_ORDER[order] * formats.difference_beats
    return count


class SentPacket(NamedTuple):
    """Beats of a packet in a stream, from ``start`` on; not ``whole`` where ``setup_last`` has cut it."""

    start: int
    beats: int
    whole: bool


def sent_packets(words: Sequence[int], lasts: Sequence[bool], formats: Formats) -> Iterator[SentPacket]:
    """
    Packets of a stream as a loader built ``with_last`` sees them: a beat that is the sender's last ends one.

    Parameters
    ----------
    words : sequence of int
      32-bit set-up words, whole beats.
    lasts : sequence of bool
      ``setup_last`` of every beat.
    formats : Formats

    Yields
    ------
    SentPacket

    Raises
    ------
    QuadshadeError
      The stream ends within a packet, and its last beat is not the sender's last.
    """
    position = 0
    while position < len(lasts):
        beats = packet_beats(words[position * formats.beat_words], formats)
        come = lasts[position : position + beats]
        if not any(come) and len(come) < beats:
            raise QuadshadeError("the set-up stream ends within a packet", "send whole packets")
        until = list(come).index(True) + 1 if any(come) else beats
        yield SentPacket(position, until, until == beats)
        position += until


def whole_packets(words: Sequence[int], lasts: Sequence[bool], formats: Formats) -> list[int]:
    """Set-up words of the packets that ``setup_last`` does not cut; see :func:`sent_packets`."""
    width = formats.beat_words
    return [
        word
        for packet in sent_packets(words, lasts, formats)
        if packet.whole
        for word in words[packet.start * width : (packet.start + packet.beats) * width]
    ]


def load_packets(words: Sequence[int], formats: Formats) -> Iterator[Packet]:
    """
    Read packets from the set-up stream.

    Parameters
    ----------
    words : sequence of int
      32-bit set-up words, whole beats.
    formats : Formats

    Yields
    ------
    Packet

    Raises
    ------
    QuadshadeError
      The stream ends within a packet.
    """
    beat_words = formats.beat_words
    position = 0

    def beats(count: int) -> int:
        """The next beats as one integer, first set-up word lowest."""
        nonlocal position
        end = position + count * beat_words
        if end > len(words):
            raise QuadshadeError("the set-up stream ends within a packet", "send whole packets")
        value = sum(int(word) << (SETUP_WORD_BITS * index) for index, word in enumerate(words[position:end]))
        position = end
        return value

    while position < len(words):
        start = position
        fields: dict[str, int] = {}
        for name, _ in SECTIONS:
            sent = name == "edge" or fields["has_second"]
            bits = beats(formats.section_beats(name)) if sent else 0
            for field, (offset, width) in formats.section(name).items():
                fields[field] = (bits >> offset) & ((1 << width) - 1)
        channel_words = [[0] * len(DIFFERENCES) for _ in range(formats.carried_channels)]
        for group in formats.channel_groups:
            order = group_order(fields["orders"], group, formats)
            for difference in range(DIFFERENCES_OF_ORDER[order]):
                bits = beats(formats.difference_beats)
                for place, channel in enumerate(group):
                    word = bits >> (SETUP_WORD_BITS * formats.difference_words * place)
                    channel_words[channel][difference] = word & ((1 << formats.word_width) - 1)
        yield Packet(fields, channel_words, (position - start) // beat_words)
