# SPDX-License-Identifier: Apache-2.0
"""The chain of spans against the model, every port in every cycle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cocotb
import pytest

from cocotb_tests.support.bench import SPEEDS, Bench
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.golden.core.span_chain import SpanChain

CYCLES = 600
RESET_AT = 250


@dataclass(frozen=True)
class Config:
    """Generics of ``span_chain``."""

    data_bits: int = 8
    depth: int = 3


CONFIGS = [Config(), Config(depth=1), Config(depth=2), Config(data_bits=100, depth=7)]


@pytest.mark.parametrize("config", CONFIGS, ids=identifier)
def test_span_chain(config: Config) -> None:
    simulate("span_chain", config)


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(source=list(SPEEDS), sink=list(SPEEDS))
async def every_cycle(dut: Any, source: str, sink: str) -> None:
    bench = Bench(dut, Config, f"every_cycle {source} {sink}")
    await bench.start("input_valid", "input_data", "output_ready")
    offers, wants = SPEEDS[source](bench.draw), SPEEDS[sink](bench.draw)
    depth = bench.config.depth
    model = SpanChain(depth)
    offered, passed = None, 0
    for index in range(CYCLES):
        # A reset in the middle forgets what is held.
        resets = index == RESET_AT
        if offered is None and next(offers):
            offered = bench.bits(bench.config.data_bits)
        # Now and then a consumer that takes nothing, long enough for the chain to fill up.
        stalls = sink == "throttled" and index % 100 < 2 * depth
        ready = next(wants) and not stalls
        dut.reset.value = int(resets)
        dut.input_valid.value = int(offered is not None)
        dut.input_data.value = 0 if offered is None else offered
        dut.output_ready.value = int(ready)
        await bench.edge()
        inputs = {"offered": offered, "output_ready": ready, "reset": resets, "stages": list(model.stages)}
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
        if resets:
            model = SpanChain(depth)
        if taken:
            offered = None
    if source == sink == "full_speed":
        # One span a cycle: all but the latency of `depth` cycles, twice, and the reset's own cycle.
        bench.check("spans passed at full speed", passed, CYCLES - 2 * depth - 1 + (depth > 0))
    bench.finish(at_least=3 * CYCLES)
