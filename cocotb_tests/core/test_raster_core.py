# SPDX-License-Identifier: Apache-2.0
"""The core against the model: every pixel, every channel, order, last flag, clocks, and when it says idle."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import count, repeat
from typing import Any

import cocotb
import numpy as np
import pytest

from cocotb_tests.support.bench import SPEEDS, Bench
from cocotb_tests.support.core_run import Run, mixed_packets, stimulus
from cocotb_tests.support.resets import reset_amid
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.contract.formats import Formats
from quadshade.golden.compiled import draw_fast

FIRST_PIXEL_LATENCY = 11
"""Cycles from a packet's last beat to its first pixel, but for the span chain's."""


@dataclass(frozen=True)
class Config(Formats):
    """Generics of the core; with a single buffer there are the same pixels, later."""

    single_buffer: int = 0


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
    Config(
        num_channels=1,
        with_depth=0,
        word_width=20,
        frac_bits=10,
        subpixel_bits=4,
        coord_bits=9,
        single_buffer=1,
    ),
    Config(num_channels=2, coord_bits=6, stream_width=64, single_buffer=1),
]


@pytest.mark.parametrize("config", CONFIGS, ids=identifier)
def test_raster_core(config: Config) -> None:
    simulate("raster_core", config, config.core_generics())


def clocks_of(bench: Bench, words: np.ndarray, stall_period: int = 0) -> int:
    """What the model counts."""
    config = bench.config
    return draw_fast(words, config, stall_period, single_buffer=bool(config.single_buffer)).clocks


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(stall_period=[0, 3])
async def clocks(dut: Any, stall_period: int) -> None:
    """Full speed, then a sink that is not ready in every third clock from the first beat on."""
    bench = Bench(dut, Config, f"clocks {stall_period}")
    await bench.start("setup_valid", "setup_data", "pixel_ready")
    words = stimulus(bench, 42 if stall_period == 0 else 21)
    takes = (stall_period == 0 or cycle % stall_period != 0 for cycle in count(1))
    run = Run(bench, words, repeat(True), takes)
    run.sink.exact = True
    await run.finish()
    bench.check("clocks", run.clocks, clocks_of(bench, words, stall_period))
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
@cocotb.parametrize(sink=list(SPEEDS))
async def resets(dut: Any, sink: str) -> None:
    """Amid a packet, a span, a wait for ready: nothing is left, and what follows takes its own clocks."""
    bench = Bench(dut, Config, f"resets {sink}")
    await bench.start("setup_valid", "setup_data", "pixel_ready")

    packets = mixed_packets(bench, 14)

    async def work() -> None:
        words = np.concatenate([next(packets) for _ in range(3)])
        run = Run(bench, words, repeat(True), SPEEDS[sink](bench.draw))
        await run.finish()
        if sink == "full_speed":
            bench.check("clocks", run.clocks, clocks_of(bench, words))

    events = (("setup_valid", "setup_ready"), "pixel_valid")
    await reset_amid(bench, work, events, 12, quiet=("pixel_valid",))
    bench.finish(at_least=200)
