# SPDX-License-Identifier: Apache-2.0
"""The transmitter against the model in every cycle, and against cocotbext-uart, with rates 2 % off."""

from __future__ import annotations

import logging
from dataclasses import dataclass
from typing import Any

import cocotb
import pytest
from cocotbext.uart import UartSink

from cocotb_tests.support.bench import PERIOD_NS, SPEEDS, Bench, StreamSource, full_speed
from cocotb_tests.support.resets import at_random
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.contract.protocol import PHASE_BITS
from quadshade.golden.link.uart_tx import UartTx


@dataclass(frozen=True)
class Config:
    """``uart_tx`` has no generics."""


@pytest.mark.parametrize("config", [Config()], ids=identifier)
def test_uart_tx(config: Config) -> None:
    simulate("uart_tx", config)


EDGE_STEPS = [parts * (1 << PHASE_BITS) // 3 + more for parts in (1, 2) for more in (0, 1)]
"""Steps of which some bit ends just in time, or just misses a cycle: each bit of the phase decides on one."""


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(step=EDGE_STEPS)
async def steps_at_the_edge(dut: Any, step: int) -> None:
    await compare(Bench(dut, Config, f"steps_at_the_edge {step}"), "full_speed", step, 500)


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(source=list(SPEEDS), clocks=[4, 8.333, 33.3])
async def every_cycle(dut: Any, source: str, clocks: float) -> None:
    step = round((1 << PHASE_BITS) / clocks)
    await compare(Bench(dut, Config, f"every_cycle {source} {clocks}"), source, step, 2500)


async def compare(bench: Bench, source: str, step: int, cycles: int) -> None:
    """The unit beside its model, with resets."""
    dut = bench.dut
    await bench.start("phase_step", "byte_valid", "byte_data")
    dut.phase_step.value = step
    model, go, offered = UartTx(), SPEEDS[source](bench.draw), None
    reset = at_random(bench.draw, int(30 * (1 << PHASE_BITS) / step))
    for index in range(cycles):
        # A reset in the middle leaves a line that is high.
        resets = next(reset)
        if offered is None and next(go) and index > 10:
            offered = bench.bits(8)
        dut.reset.value = int(resets)
        dut.byte_valid.value = int(offered is not None)
        dut.byte_data.value = offered or 0
        await bench.edge()
        got = (int(dut.tx.value), bool(dut.busy.value), bool(dut.byte_ready.value))
        ready = model.ready(step)
        bench.check("tx, busy, ready", got, (model.tx, model.busy, ready), index, {"offered": offered})
        model.clock(offered, step)
        if ready:
            offered = None
        if resets:
            model = UartTx()
    bench.finish(at_least=cycles)


@cocotb.test(timeout_time=4, timeout_unit="ms")
@cocotb.parametrize(clocks=[8.333, 33.3, 100], skew=[-0.02, 0.0, 0.02])
async def to_another_uart(dut: Any, clocks: float, skew: float) -> None:
    bench = Bench(dut, Config, f"to_another_uart {clocks} {skew}")
    await bench.start("phase_step")
    bit_ns = round(clocks * PERIOD_NS)
    dut.phase_step.value = round((1 << PHASE_BITS) * (1 + skew) * PERIOD_NS / bit_ns)
    sink = UartSink(dut.tx, baud=1e9 / bit_ns - 1e-3)
    sink.log.setLevel(logging.WARNING)
    sent = bytes([0, 255, 0x55, 0xAA, *(bench.bits(8) for _ in range(12))])
    words = [(byte,) for byte in sent]
    source = StreamSource(dut.byte_valid, dut.byte_ready, [dut.byte_data], words, full_speed(bench.draw))
    for _ in range(int(10.3 * clocks * len(sent)) + 100):
        source.drive()
        await bench.edge()
        source.sample(bench.cycle)
    bench.check("bytes", bytes(sink.read_nowait()), sent)
    # Ten bits from each character to the next, none between.
    took = source.accepted_at[-1] - source.accepted_at[0]
    wanted = 10 * (len(sent) - 1) * clocks / (1 + skew)
    bench.check("cycles within 1 %", abs(took - wanted) <= 2 + wanted / 100, True, inputs=(took, wanted))
    bench.finish(at_least=2)
