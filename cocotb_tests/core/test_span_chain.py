# SPDX-License-Identifier: Apache-2.0
"""The chain of spans against the model, every port in every cycle."""

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
from quadshade.golden.core.span_chain import SpanChain

CYCLES = 500


@dataclass(frozen=True)
class Config:
    """Generics of ``span_chain``."""

    data_bits: int = 8
    depth: int = 3


CONFIGS = [Config(), Config(depth=1), Config(depth=2), Config(data_bits=100, depth=7)]


@pytest.mark.parametrize("config", CONFIGS, ids=identifier)
def test_span_chain(config: Config) -> None:
    simulate("span_chain", config)


async def compare(bench: Bench, source: str, sink: str, resets: Iterator[bool]) -> int:
    """Every port in every cycle; spans that passed."""
    dut = bench.dut
    await bench.start("input_valid", "input_data", "output_ready")
    offers, wants = SPEEDS[source](bench.draw), SPEEDS[sink](bench.draw)
    depth = bench.config.depth
    model = SpanChain(depth)
    offered, passed = None, 0
    for index in range(CYCLES):
        reset = next(resets)
        if offered is None and next(offers):
            offered = bench.bits(bench.config.data_bits)
        # Now and then a consumer that takes nothing, long enough for the chain to fill up.
        stalls = sink == "throttled" and index % 100 < 2 * depth
        ready = next(wants) and not stalls
        dut.reset.value = int(reset)
        dut.input_valid.value = int(offered is not None)
        dut.input_data.value = 0 if offered is None else offered
        dut.output_ready.value = int(ready)
        await bench.edge()
        inputs = {"offered": offered, "output_ready": ready, "reset": reset, "stages": list(model.stages)}
        taken = model.input_ready(ready)
        held = any(stage is not None for stage in model.stages)
        bench.check("input_ready", bool(dut.input_ready.value), taken, index, inputs)
        bench.check("output_valid", bool(dut.output_valid.value), model.output is not None, index, inputs)
        bench.check("busy", bool(dut.busy.value), held, index, inputs)
        if model.output is not None:
            bench.check("output_data", int(dut.output_data.value), model.output, index, inputs)
            passed += ready
        model.clock(offered, ready)
        full = all(stage is not None for stage in model.stages)
        bench.check("full_next", bool(dut.full_next.value), full, index, inputs)
        if reset:
            model = SpanChain(depth)
        if taken:
            offered = None
    return passed


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(source=list(SPEEDS), sink=list(SPEEDS))
async def every_cycle(dut: Any, source: str, sink: str) -> None:
    bench = Bench(dut, Config, f"every_cycle {source} {sink}")
    passed = await compare(bench, source, sink, repeat(False))
    if source == sink == "full_speed":
        # One span a cycle: all but the latency of `depth` cycles.
        bench.check("spans passed at full speed", passed, CYCLES - bench.config.depth)
    bench.finish(at_least=3 * CYCLES)


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(source=list(SPEEDS), sink=list(SPEEDS))
async def resets(dut: Any, source: str, sink: str) -> None:
    """A reset forgets every span."""
    bench = Bench(dut, Config, f"resets {source} {sink}")
    await compare(bench, source, sink, at_random(bench.draw, 20))
    bench.finish(at_least=3 * CYCLES)
