# SPDX-License-Identifier: Apache-2.0
"""The output's two registers against the model, every port in every cycle."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import repeat
from typing import Any

import cocotb
import pytest

from cocotb_tests.support.bench import SPEEDS, Bench
from cocotb_tests.support.resets import at_random
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.golden.common.skid_buffer import SkidBuffer

CYCLES = 500


@dataclass(frozen=True)
class Config:
    """Generics of ``skid_buffer``."""

    data_bits: int = 8


CONFIGS = [Config(), Config(data_bits=1), Config(data_bits=75)]


@pytest.mark.parametrize("config", CONFIGS, ids=identifier)
def test_skid_buffer(config: Config) -> None:
    simulate("skid_buffer", config)


async def compare(bench: Bench, source: str, sink: str, resets: Iterator[bool]) -> int:
    """Every port in every cycle; words that passed."""
    dut = bench.dut
    await bench.start("input_valid", "input_data", "output_ready")
    offers, wants = SPEEDS[source](bench.draw), SPEEDS[sink](bench.draw)
    model = SkidBuffer()
    offered, passed = None, 0
    for index in range(CYCLES):
        reset = next(resets)
        if offered is None and next(offers):
            offered = bench.bits(bench.config.data_bits)
        ready = next(wants)
        dut.reset.value = int(reset)
        dut.input_valid.value = int(offered is not None)
        dut.input_data.value = 0 if offered is None else offered
        dut.output_ready.value = int(ready)
        await bench.edge()
        inputs = {"offered": offered, "output_ready": ready, "reset": reset}
        bench.check("input_ready", bool(dut.input_ready.value), model.input_ready, index, inputs)
        bench.check("output_valid", bool(dut.output_valid.value), model.front is not None, index, inputs)
        if model.front is not None:
            bench.check("output_data", int(dut.output_data.value), model.front, index, inputs)
            passed += ready
        taken = model.input_ready
        model.clock(offered, ready)
        if reset:
            model = SkidBuffer()
        if taken:
            offered = None
    return passed


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(source=list(SPEEDS), sink=list(SPEEDS))
async def every_cycle(dut: Any, source: str, sink: str) -> None:
    bench = Bench(dut, Config, f"every_cycle {source} {sink}")
    passed = await compare(bench, source, sink, repeat(False))
    if source == sink == "full_speed":
        # One word a cycle: all but the latency of one.
        bench.check("words passed at full speed", passed, CYCLES - 1)
    bench.finish(at_least=2 * CYCLES)


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(source=list(SPEEDS), sink=list(SPEEDS))
async def resets(dut: Any, source: str, sink: str) -> None:
    """A reset forgets what is held."""
    bench = Bench(dut, Config, f"resets {source} {sink}")
    await compare(bench, source, sink, at_random(bench.draw, 20))
    bench.finish(at_least=2 * CYCLES)
