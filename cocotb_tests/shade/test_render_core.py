# SPDX-License-Identifier: Apache-2.0
"""The core with the shade unit against the model: pixels, clocks, and when it says idle and takes a state."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import count, repeat
from typing import Any

import cocotb
import numpy as np
import pytest

from cocotb_tests.support.bench import SPEEDS, Bench, StreamSource, full_speed
from cocotb_tests.support.core_run import Run, mixed_packets, stimulus
from cocotb_tests.support.resets import reset_amid
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.contract.formats import Formats
from quadshade.contract.shade_state import ShadeState
from quadshade.golden.shade.render_core import draw
from tests.support.shade_stimuli import random_state

FIRST_PIXEL_LATENCY = 11
"""Of the core without shade, and without its span chain."""

INPUTS = ("setup_valid", "setup_data", "state_valid", "state_address", "state_data", "pixel_ready")


@dataclass(frozen=True)
class Config(Formats):
    """Generics of the core."""

    with_shade: int = 1
    num_channels: int = 2
    coord_bits: int = 7


CONFIGS = [
    Config(),
    Config(with_shade=0, num_channels=1, max_order=1),
    Config(num_channels=4, num_specular=2, stream_width=64, shade_guard_bits=4, max_order=1),
    Config(num_channels=1, with_depth=0, stream_width=128, value_bits=6, shade_guard_bits=5, span_depth=1),
]


@pytest.mark.parametrize("config", CONFIGS, ids=identifier)
def test_render_core(config: Config) -> None:
    simulate("render_core", config)


def state_source(bench: Bench, state: ShadeState) -> StreamSource:
    """A stream of a state's words."""
    dut = bench.dut
    words = map(tuple, state.writes().tolist())
    return StreamSource(
        dut.state_valid, dut.state_ready, [dut.state_address, dut.state_data], words, full_speed(bench.draw)
    )


async def load(bench: Bench, state: ShadeState) -> None:
    """Write a state; a core without shade takes and forgets it."""
    source = state_source(bench, state)
    while not source.empty:
        source.drive()
        await bench.edge()
        source.sample(bench.cycle)


@cocotb.test(timeout_time=2, timeout_unit="ms")
@cocotb.parametrize(stall_period=[0, 3])
async def clocks(dut: Any, stall_period: int) -> None:
    """Full speed, then a sink that is not ready in every third clock from the first beat on."""
    bench = Bench(dut, Config, f"clocks {stall_period}")
    formats = bench.config
    await bench.start(*INPUTS)
    state = random_state(formats, bench.rng)
    await load(bench, state)
    words = stimulus(bench, 28 if stall_period == 0 else 14)
    takes = (stall_period == 0 or cycle % stall_period != 0 for cycle in count(1))
    run = Run(bench, words, repeat(True), takes, state)
    run.sink.exact = True
    await run.finish()
    bench.check("clocks", run.clocks, draw(words, formats, state, stall_period).clocks)
    if stall_period == 0:
        first_packet = sorted(run.settled)[1]
        latency = run.sink.taken_at[0] - run.source.accepted_at[first_packet - 1]
        behind = formats.shade_stages + 1 if formats.with_shade else 0
        bench.check("latency", latency, FIRST_PIXEL_LATENCY + formats.span_depth + behind)
    bench.finish(at_least=200)


@cocotb.test(timeout_time=2, timeout_unit="ms")
@cocotb.parametrize(
    (
        ("source", "sink"),
        [("full_speed", "throttled"), ("throttled", "full_speed"), ("throttled", "throttled")],
    )
)
async def slowed(dut: Any, source: str, sink: str) -> None:
    bench = Bench(dut, Config, f"slowed {source} {sink}")
    await bench.start(*INPUTS)
    state = random_state(bench.config, bench.rng)
    await load(bench, state)
    offers, takes = SPEEDS[source](bench.draw), SPEEDS[sink](bench.draw)
    run = Run(bench, stimulus(bench, 14), offers, takes, state)
    await run.finish()
    bench.finish(at_least=200)


@cocotb.test(timeout_time=2, timeout_unit="ms")
async def state_waits_until_idle(dut: Any) -> None:
    """A state offered amid a drawing is taken behind its last pixel, and holds for the next drawing."""
    bench = Bench(dut, Config, "state_waits_until_idle")
    await bench.start(*INPUTS)
    states = [random_state(bench.config, bench.rng) for _ in range(2)]
    await load(bench, states[0])
    run = Run(bench, stimulus(bench, 7), repeat(True), SPEEDS["throttled"](bench.draw), states[0])
    while not run.source.accepted_at:
        await run.cycle()
    source = state_source(bench, states[1])
    while not run.source.empty or len(run.sink.words) < len(run.expected):
        source.drive()
        await run.cycle()
        accepted = source.sample(bench.cycle)
        if bench.config.with_shade and not dut.idle.value:
            bench.check("state taken amid a drawing", accepted, False)
    while not source.empty:
        source.drive()
        await bench.edge()
        source.sample(bench.cycle)
    bench.check_all("pixel", run.sink.words, run.expected, run.inputs)
    run = Run(bench, stimulus(bench, 7), repeat(True), repeat(True), states[1])
    await run.finish()
    bench.finish(at_least=200)


@cocotb.test(timeout_time=2, timeout_unit="ms")
@cocotb.parametrize(sink=list(SPEEDS))
async def resets(dut: Any, sink: str) -> None:
    """A reset at any stage of a drawing forgets its pixels and keeps the state."""
    bench = Bench(dut, Config, f"resets {sink}")
    await bench.start(*INPUTS)
    state = random_state(bench.config, bench.rng)
    await load(bench, state)

    packets = mixed_packets(bench, 14)

    async def work() -> None:
        words = np.concatenate([next(packets) for _ in range(3)])
        run = Run(bench, words, repeat(True), SPEEDS[sink](bench.draw), state)
        await run.finish()
        if sink == "full_speed":
            bench.check("clocks", run.clocks, draw(words, bench.config, state).clocks)

    events = (("setup_valid", "setup_ready"), "pixel_valid")
    await reset_amid(bench, work, events, 12, quiet=("pixel_valid",))
    bench.finish(at_least=100)
