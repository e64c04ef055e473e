# SPDX-License-Identifier: Apache-2.0
"""The set-up packet: an unpacker written from the description alone gives back what was packed."""

from __future__ import annotations

import numpy as np
import pytest

from quadshade.contract.formats import Formats
from quadshade.packing.read_primitives import read_primitives
from quadshade.setup.packet import pack, packet_words
from quadshade.setup.triangle_setup import setup_triangles
from tests.support.setup_reference import screen_triangles

CONFIGS = (
    {},
    {"stream_width": 64},
    {"stream_width": 128},
    {"stream_width": 128, "num_channels": 5, "coord_bits": 13, "subpixel_bits": 12},
    {"stream_width": 64, "word_width": 40, "frac_bits": 28},
    {"word_width": 60, "frac_bits": 40, "num_channels": 2, "with_depth": 0},
    {
        "num_channels": 8,
        "subpixel_bits": 0,
        "coord_bits": 6,
        "word_width": 17,
        "frac_bits": 7,
        "depth_bits": 8,
    },
    {"num_channels": 1, "with_depth": 0, "max_order": 1},
)


class Beats:
    """The stream as a row of beats, each one integer of ``stream_width`` bits."""

    def __init__(self, words: np.ndarray, stream_width: int) -> None:
        count = stream_width // 32
        assert len(words) % count == 0
        self.width = stream_width
        self.beats = [
            sum(int(word) << (32 * index) for index, word in enumerate(words[at : at + count]))
            for at in range(0, len(words), count)
        ]
        self.at = 0

    def take(self, bits: int) -> int:
        """The next whole beats that hold so many bits, as one integer, first beat lowest."""
        count = -(-bits // self.width)
        taken = self.beats[self.at : self.at + count]
        assert len(taken) == count, "the stream ends within a packet"
        self.at += count
        return sum(beat << (self.width * place) for place, beat in enumerate(taken))


def signed(value: int, bits: int) -> int:
    return value - (1 << bits) if value >> (bits - 1) & 1 else value


def split(value: int, widths: list[int]) -> list[int]:
    fields = []
    for width in widths:
        fields.append(value & ((1 << width) - 1))
        value >>= width
    assert value == 0, "padding is not zero"
    return fields


def unpack(words: np.ndarray, formats: Formats) -> list[dict]:
    """Packets of a stream."""
    channels = formats.num_channels + formats.with_depth
    coord, column = formats.coord_bits, formats.coord_bits + 1
    height = formats.coord_bits + formats.subpixel_bits + 2
    edge = [column, height + 1, column, height, height + 1]
    head = [1, 1, 1, 2 * channels, coord, column, column]
    beats, packets = Beats(words, formats.stream_width), []
    word_bits = 32 * (1 if formats.word_width <= 32 else 2)
    per_beat = max(1, formats.stream_width // word_bits)

    def read_edge(raw: list[int]) -> tuple[int, ...]:
        place, error, step, increment, decrement = raw
        return (
            signed(place, column),
            signed(error, height + 1),
            signed(step, column),
            increment,
            signed(decrement, height + 1),
        )

    while beats.at < len(beats.beats):
        widths = head + edge + edge
        fields = split(beats.take(sum(widths)), widths)
        has_second, mirror, fractional, orders, y, rows_first, rows_second = fields[:7]
        packet = {"mirror": mirror, "fractional": fractional, "y": y}
        packet["rows"] = (signed(rows_first, column) + 2, signed(rows_second, column) + 2)
        packet["major"], packet["minor"] = read_edge(fields[7:12]), read_edge(fields[12:17])
        if has_second:
            packet["second"] = read_edge(split(beats.take(sum(edge)), edge))
        order = [orders >> (2 * channel) & 3 for channel in range(channels)]
        packet["orders"] = order
        packet["words"] = [[0] * 6 for _ in range(channels)]
        for first in range(0, channels, per_beat):
            group = range(first, min(first + per_beat, channels))
            for difference in range((1, 3, 6)[max(order[channel] for channel in group)]):
                raw = beats.take(word_bits * len(group))
                for channel in group:
                    word = raw >> (word_bits * (channel - first)) & ((1 << word_bits) - 1)
                    assert word >> formats.word_width == 0, "padding is not zero"
                    packet["words"][channel][difference] = signed(word, formats.word_width)
        packets.append(packet)
    return packets


@pytest.mark.parametrize(
    "config", CONFIGS, ids=lambda c: "_".join(f"{k}{v}" for k, v in c.items()) or "default"
)
def test_round_trip(config: dict[str, int], rng: np.random.Generator) -> None:
    formats = Formats(**config)
    size = 60 << formats.subpixel_bits
    vertices = rng.integers(-size // 2, size, (300, 3, 2))
    samples = rng.uniform(0, 255, (300, formats.num_channels, 6))
    triangles = screen_triangles(vertices, formats, 50, 40, samples)
    triangles.orders = rng.integers(0, formats.max_order + 1, triangles.orders.shape)
    triangles.depth = rng.uniform(0, (1 << formats.depth_bits) - 1, (300, 3))
    primitives = setup_triangles(triangles, formats, fractional=bool(rng.integers(2)))
    words = pack(primitives, formats)
    assert words.dtype == np.uint32
    assert packet_words(primitives.orders, primitives.header["has_second"], formats).sum() == len(words)
    again = read_primitives(words, formats)
    assert np.array_equal(again.orders, primitives.orders) and np.array_equal(again.words, primitives.words)
    assert np.array_equal(pack(again, formats), words)
    packets = unpack(words, formats)
    assert len(packets) == len(primitives)
    names = ("column", "error", "step", "increment", "decrement")
    for index, packet in enumerate(packets):
        header = {key: int(value[index]) for key, value in primitives.header.items()}
        assert (packet["mirror"], packet["fractional"], packet["y"]) == (
            header["mirror"],
            header["fractional"],
            header["y"],
        )
        assert packet["rows"] == (header["rows_first"], header["rows_second"])
        assert ("second" in packet) == bool(header["has_second"]) == (header["rows_second"] > 0)
        for edge in ("major", "minor", "second"):
            if edge in packet:
                expected = tuple(int(primitives.edges[edge][part][index]) for part in names)
                column, error, step, increment, decrement = expected
                step = signed(step % (1 << (formats.coord_bits + 1)), formats.coord_bits + 1)
                column = signed(column % (1 << (formats.coord_bits + 1)), formats.coord_bits + 1)
                assert packet[edge] == (column, error, step, increment, decrement)
        assert packet["orders"] == primitives.orders[index].tolist()
        assert packet["words"] == primitives.words[index].tolist()


def test_nothing_to_draw() -> None:
    formats = Formats()
    primitives = setup_triangles(screen_triangles(np.zeros((0, 3, 2)), formats), formats)
    assert len(primitives) == 0
    assert len(pack(primitives, formats)) == 0
