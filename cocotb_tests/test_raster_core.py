# SPDX-License-Identifier: Apache-2.0
"""The core against the model: every pixel, every channel, order, last flag, clocks, and when it says idle."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import accumulate, count, repeat
from typing import Any

import cocotb
import numpy as np
import pytest

from bench import SPEEDS, Bench, StreamSink, StreamSource
from golden_stimuli import malformed_words, triangle_words
from quadshade.formats import LANE_BITS, Formats
from quadshade.golden.fast import draw_fast
from quadshade.golden.raster_core import EmittedPixel, draw_scalar
from quadshade.golden.setup_loader import load_packets
from simulation import identifier, simulate

FIRST_PIXEL_LATENCY = 11
"""Cycles from a packet's last beat to its first pixel, but for the span chain's."""

QUIET_CYCLES = 20
"""How long the core is watched after it says idle."""

PORTS = ("pixel_last", "pixel_y", "pixel_x", "pixel_depth", "pixel_value")


@dataclass(frozen=True)
class Config(Formats):
    """Generics of the core."""


CONFIGS = [
    Config(),
    Config(stream_width=64),
    Config(stream_width=128, span_depth=1),
    Config(word_width=24, frac_bits=14, span_depth=3),
    Config(word_width=40, frac_bits=30, subpixel_bits=4),
    Config(num_channels=2, word_width=40, frac_bits=28, stream_width=128),
    Config(num_channels=1, max_order=1, with_depth=0, span_depth=4),
    Config(num_channels=2, max_order=0, stream_width=64),
    Config(num_channels=4, with_depth=0, coord_bits=6, stream_width=128),
    Config(num_channels=1, max_order=1, depth_bits=20, value_bits=12, frac_bits=18, coord_bits=7),
    Config(num_channels=3, max_order=0, with_depth=0, subpixel_bits=0, coord_bits=3, stream_width=128),
]


@pytest.mark.parametrize("config", CONFIGS, ids=identifier)
def test_raster_core(config: Config) -> None:
    simulate("raster_core", config, config.core_generics())


def beats_of(words: np.ndarray, formats: Formats) -> list[tuple[int]]:
    """Beats of a stream of lanes, the first lane lowest."""
    rows = words.reshape(-1, formats.stream_lanes).tolist()
    return [(sum(word << (LANE_BITS * lane) for lane, word in enumerate(row)),) for row in rows]


def port_words(pixel: EmittedPixel, formats: Formats) -> tuple[int, ...]:
    """A pixel of the model as it stands at the ports."""
    bits = formats.value_bits
    value = sum(v << (bits * channel) for channel, v in enumerate(pixel.value[: formats.num_channels]))
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
    """

    def __init__(
        self, bench: Bench, words: np.ndarray, offers: Iterator[bool], takes: Iterator[bool]
    ) -> None:
        self.bench, dut, formats = bench, bench.dut, bench.config
        packets = list(load_packets(words.tolist(), formats))
        self.pixels = draw_scalar(words.tolist(), formats)
        self.expected = [port_words(pixel, formats) for pixel in self.pixels]
        self.fields = [packet.fields for packet in packets]
        self.beats = beats_of(words, formats)
        # Where a packet ends: beats up to there, and the pixels that have come out once the core is idle.
        drawn = np.bincount([pixel.packet for pixel in self.pixels], minlength=len(packets))
        ends = accumulate(packet.beats for packet in packets)
        self.settled = {0: 0} | dict(zip(ends, np.cumsum(drawn).tolist(), strict=True))
        self.source = StreamSource(dut.setup_valid, dut.setup_ready, [dut.setup_data], self.beats, offers)
        data = [getattr(dut, port) for port in PORTS]
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
        self.sink.sample(bench.cycle)
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
        bench.check_all("pixel", self.sink.words, self.expected, self.inputs)

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


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(stall_period=[0, 3])
async def clocks(dut: Any, stall_period: int) -> None:
    """Full speed, then a sink that is not ready in every third clock from the first beat on."""
    bench = Bench(dut, Config, f"clocks {stall_period}")
    await bench.start("setup_valid", "setup_data", "pixel_ready")
    words = stimulus(bench, 42 if stall_period == 0 else 21)
    takes = (stall_period == 0 or cycle % stall_period != 0 for cycle in count(1))
    run = Run(bench, words, repeat(True), takes)
    await run.finish()
    bench.check("clocks", run.clocks, draw_fast(words, bench.config, stall_period).clocks)
    if stall_period == 0:
        first_packet = sorted(run.settled)[1]
        latency = run.sink.taken_at[0] - run.source.accepted_at[first_packet - 1]
        bench.check("latency", latency, FIRST_PIXEL_LATENCY + bench.config.span_depth)
    bench.finish(at_least=200)


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(
    (
        ("source", "sink"),
        [("full_speed", "throttled"), ("throttled", "full_speed"), ("throttled", "throttled")],
    )
)
async def slowed(dut: Any, source: str, sink: str) -> None:
    bench = Bench(dut, Config, f"slowed {source} {sink}")
    await bench.start("setup_valid", "setup_data", "pixel_ready")
    offers, takes = SPEEDS[source](bench.draw), SPEEDS[sink](bench.draw)
    run = Run(bench, stimulus(bench, 20), offers, takes)
    await run.finish()
    bench.finish(at_least=200)


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def reset_recovers(dut: Any) -> None:
    bench = Bench(dut, Config, "reset_recovers")
    await bench.start("setup_valid", "setup_data", "pixel_ready")
    for speed in ("full_speed", "throttled", "full_speed"):
        words = stimulus(bench, 12)
        run = Run(bench, words, SPEEDS[speed](bench.draw), SPEEDS[speed](bench.draw))
        # Somewhere within a packet, with others on their way.
        while len(run.source.accepted_at) < len(run.beats) * 2 // 3:
            await run.cycle()
        while len(run.source.accepted_at) in run.settled:
            await run.cycle()
        got = run.sink.words
        bench.check_all("pixel before the reset", got, run.expected[: len(got)], run.inputs)
        dut.setup_valid.value = 0
        await bench.reset()
        words = stimulus(bench, 6)
        run = Run(bench, words, repeat(True), repeat(True))
        await run.finish()
        bench.check("clocks after the reset", run.clocks, draw_fast(words, bench.config).clocks)
    bench.finish(at_least=200)
