# SPDX-License-Identifier: Apache-2.0
"""A stream of set-up words through a core, every pixel compared with the model's."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import accumulate

import numpy as np

from cocotb_tests.support.bench import Bench, StreamSink, StreamSource
from cocotb_tests.support.cover import Cover
from quadshade.contract.formats import SETUP_WORD_BITS, Formats
from quadshade.contract.shade_state import ShadeState
from quadshade.golden.core.raster_core import EmittedPixel
from quadshade.golden.core.setup_loader import load_packets
from quadshade.golden.shade.render_core import draw_scalar
from tests.support.golden_stimuli import malformed_words, triangle_words

QUIET_CYCLES = 20
"""How long the core is watched after it says idle."""

CORE_BINS = {
    "channels": ("1", "2", "3", "4"),
    "order": ("0", "1", "2"),
    "second_edge": ("0", "1"),
    "mirror": ("0", "1"),
    "held": ("0", "1"),
}
"""Channels of the core, a channel's order, the packet's edges, and whether a pixel had to wait in the run."""

PORTS = ("pixel_last", "pixel_y", "pixel_x", "pixel_depth", "pixel_value")


def beats_of(words: np.ndarray, formats: Formats) -> list[tuple[int]]:
    """Beats of a stream of set-up words, the first one lowest."""
    rows = words.reshape(-1, formats.beat_words).tolist()
    return [(sum(word << (SETUP_WORD_BITS * index) for index, word in enumerate(row)),) for row in rows]


def port_words(pixel: EmittedPixel, formats: Formats) -> tuple[int, ...]:
    """A pixel of the model as it stands at the ports."""
    bits = formats.value_bits
    colours = pixel.value[: formats.emitted_channels]
    value = sum(v << (bits * channel) for channel, v in enumerate(colours))
    depth = pixel.value[-1] if formats.with_depth else 0
    return int(pixel.last), pixel.y, pixel.x, depth, value


class Run:
    """
    One stream of words through the core.

    Parameters
    ----------
    bench : Bench
    words : (m,) uint32
    offers, takes : iterator of bool
      Whether to offer the next word, to take a pixel, in each cycle.
    state : ShadeState, optional
      Of the shade unit, where there is one.
    """

    def __init__(
        self,
        bench: Bench,
        words: np.ndarray,
        offers: Iterator[bool],
        takes: Iterator[bool],
        state: ShadeState | None = None,
    ) -> None:
        self.bench, dut, formats = bench, bench.dut, bench.config
        packets = list(load_packets(words.tolist(), formats))
        self.pixels = draw_scalar(words.tolist(), formats, state)
        self.expected = [port_words(pixel, formats) for pixel in self.pixels]
        self.fields = [packet.fields for packet in packets]
        self.beats = beats_of(words, formats)
        # Where a packet ends: beats up to there, and the pixels that have come out once the core is idle.
        drawn = np.bincount([pixel.packet for pixel in self.pixels], minlength=len(packets))
        ends = accumulate(packet.beats for packet in packets)
        self.settled = {0: 0} | dict(zip(ends, np.cumsum(drawn).tolist(), strict=True))
        self.source = StreamSource(dut.setup_valid, dut.setup_ready, [dut.setup_data], self.beats, offers)
        data = [getattr(dut, port) for port in PORTS]
        self.held = False
        self.sink = StreamSink(bench, dut.pixel_valid, dut.pixel_ready, data, takes)

    async def cycle(self) -> bool:
        """One clock; true if the core is idle. It must not say so while anything is on its way."""
        bench = self.bench
        self.source.drive()
        self.sink.drive()
        await bench.edge()
        idle = bool(bench.dut.idle.value)
        if idle:
            accepted = len(self.source.accepted_at)
            bench.check("pixels out when idle", len(self.sink.words), self.settled.get(accepted), accepted)
        self.source.sample(bench.cycle)
        taken = len(self.sink.words)
        self.sink.sample(bench.cycle)
        for word, expected in zip(self.sink.words[taken:], self.expected[taken:], strict=False):
            bench.check("pixel", word, expected, taken, self.inputs(taken) if word != expected else None)
        self.held |= self.sink.held is not None
        return idle

    async def finish(self) -> None:
        """Up to the end of the stream, and until nothing more comes."""
        while not self.source.empty:
            await self.cycle()
        while not await self.cycle():
            pass
        for _ in range(QUIET_CYCLES):
            self.bench.check("idle at the end", await self.cycle(), True)
        bench = self.bench
        bench.check("beats accepted", len(self.source.accepted_at), len(self.beats))
        bench.check("number of pixels", len(self.sink.words), len(self.expected))
        bench.check("setup_cut without setup_last", int(bench.dut.setup_cut.value), 0)
        self.cover()

    def cover(self) -> None:
        """Count what every packet asked of each channel."""
        formats = self.bench.config
        cover = Cover("core", CORE_BINS)
        for fields in self.fields:
            for channel in range(formats.num_channels):
                order = min(fields["orders"] >> (2 * channel) & 3, formats.max_order)
                cover.sample(
                    channels=formats.num_channels,
                    order=order,
                    second_edge=fields["has_second"],
                    mirror=fields["mirror"],
                    held=int(self.held),
                )
        cover.save()

    def inputs(self, index: int) -> str:
        """What drew a pixel."""
        packet = self.pixels[index].packet
        return f"packet {packet} {self.fields[packet]}; pixel is (last, y, x, depth, value)"

    @property
    def clocks(self) -> int:
        """First beat accepted to last pixel out, both included; 0 where no pixel came out."""
        if not self.sink.taken_at:
            return 0
        return self.sink.taken_at[-1] - self.source.accepted_at[0] + 1


def stimulus(bench: Bench, triangles: int) -> np.ndarray:
    """Real triangles first, the awkward kinds among them, then packets of nonsense."""
    formats = bench.config
    real = triangle_words(formats, bench.rng, triangles)
    return np.concatenate([real, malformed_words(formats, bench.rng, triangles // 2)])


def mixed_packets(bench: Bench, triangles: int) -> Iterator[np.ndarray]:
    """Packets of a stimulus, one at a time and at random, without end."""
    formats = bench.config
    words, packets = stimulus(bench, triangles), []
    for packet in load_packets(words.tolist(), formats):
        count = packet.beats * formats.beat_words
        packets.append(words[:count])
        words = words[count:]
    while True:
        yield bench.draw.choice(packets)
