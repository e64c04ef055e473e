# SPDX-License-Identifier: Apache-2.0
"""The receiver against the model in every cycle, and against cocotbext-uart, with rates 2 % off."""

from __future__ import annotations

import logging
from dataclasses import dataclass
from itertools import repeat
from typing import Any

import cocotb
import pytest
from cocotbext.uart import UartSource

from cocotb_tests.support.bench import PERIOD_NS, Bench
from cocotb_tests.support.resets import at_random
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.contract.protocol import BREAK_BITS, PHASE_BITS
from quadshade.golden.link.uart_rx import UartRx

STEPS = [1 << (PHASE_BITS - 2), round((1 << PHASE_BITS) / 8.333), round((1 << PHASE_BITS) / 33.3)]


@dataclass(frozen=True)
class Config:
    """``uart_rx`` has no generics."""


@pytest.mark.parametrize("config", [Config()], ids=identifier)
def test_uart_rx(config: Config) -> None:
    simulate("uart_rx", config)


def levels(bench: Bench, clocks: float) -> list[int]:
    """A line, clock by clock: characters, gaps, glitches, breaks, noise."""
    line: list[int] = []
    while len(line) < 90 * clocks + 2500:
        kind = bench.draw.choice(("character", "character", "gap", "glitch", "low", "break", "noise"))
        if kind == "character":
            bits = [0, *(bench.bits(8) >> index & 1 for index in range(8)), int(bench.chance(0.9))]
        elif kind == "noise":
            line += [bench.bits(1) for _ in range(30)]
            continue
        else:
            run = {"gap": 30, "glitch": 0.6, "low": 30, "break": 4}[kind] * bench.draw.random()
            # Just none, just one, and so long that a counter of its bits would come round.
            run += bench.draw.choice((BREAK_BITS - 2, BREAK_BITS - 2, 30, 62)) * (kind == "break")
            line += [int(kind == "gap")] * int(run * clocks) + [1]
            continue
        ends = [round((index + 1) * clocks) for index in range(10)]
        for start, end, value in zip([0, *ends], ends, bits, strict=False):
            line += [value] * (end - start)
    return line


async def compare(bench: Bench, model: UartRx, step: int, index: int) -> tuple[bool, bool, bool]:
    """Up to the next edge; what the model says of a byte, a framing error and a break."""
    dut = bench.dut
    await bench.edge()
    expected = model.outputs
    got = (bool(dut.byte_valid.value), bool(dut.framing_error.value), bool(dut.break_seen.value))
    wanted = (expected.valid, expected.framing_error, expected.break_seen)
    bench.check("valid, framing_error, break_seen", got, wanted, index, {"step": step})
    if expected.valid:
        bench.check("byte_data", int(dut.byte_data.value), expected.data, index, {"step": step})
    return wanted


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(step=STEPS, resets=[False, True])
async def every_cycle(dut: Any, step: int, resets: bool) -> None:
    bench = Bench(dut, Config, f"every_cycle {step} {resets}")
    dut.rx.value = 1
    await bench.start("phase_step")
    dut.rx.value = 1
    dut.phase_step.value = step
    for _ in range(4):
        await bench.edge()
    model, seen, clocks = UartRx(), [0, 0, 0], (1 << PHASE_BITS) / step
    reset = at_random(bench.draw, int(30 * clocks)) if resets else repeat(False)
    for index, level in enumerate(levels(bench, clocks)):
        resets_now = next(reset)
        dut.rx.value, dut.reset.value = level, int(resets_now)
        wanted = await compare(bench, model, step, index)
        seen = [count + value for count, value in zip(seen, wanted, strict=True)]
        model.clock(level, step)
        if resets_now:
            model.reset()
    bench.check("characters, framing errors and breaks were there", min(seen) > 0, True)
    bench.finish(at_least=2500)


def limit(bench: Bench) -> int:
    """A phase step with its low bits in use, by which a sample just falls in a clock or just misses it."""
    tries = []
    for _ in range(100):
        eighths = 8 * bench.draw.randint(1, 8) + bench.draw.choice((3, 4, 5))
        place = eighths << (PHASE_BITS - 3)
        clocks = round(eighths * bench.draw.uniform(4.1, 14) / 8)
        step = -(-place // clocks)
        if step * clocks > place:
            tries.append((step * clocks - place, step))
    return min(tries)[1] - bench.draw.randrange(2)


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def phases_at_their_limits(dut: Any) -> None:
    """Noise where a sample's clock is decided by the last bits of the phase."""
    bench = Bench(dut, Config, "phases_at_their_limits")
    dut.rx.value = 1
    await bench.start("phase_step")
    dut.rx.value = 1
    for _ in range(4):
        await bench.edge()
    model, bytes_seen = UartRx(), 0
    for index in range(60):
        step = limit(bench)
        clocks = (1 << PHASE_BITS) / step
        noise = [bench.bits(1) for _ in range(round(8 * clocks))]
        dut.phase_step.value = step
        for level in (*[1] * 4, *[0] * round(clocks), *noise, *[1] * round(12 * clocks)):
            dut.rx.value = level
            bytes_seen += (await compare(bench, model, step, index))[0]
            model.clock(level, step)
    bench.check("bytes were there", bytes_seen >= 60, True)
    bench.finish(at_least=2500)


@cocotb.test(timeout_time=4, timeout_unit="ms")
@cocotb.parametrize(clocks=[4.2, 8.333, 33.3, 100], skew=[-0.02, 0.0, 0.02])
async def from_another_uart(dut: Any, clocks: float, skew: float) -> None:
    bench = Bench(dut, Config, f"from_another_uart {clocks} {skew}")
    await bench.start("phase_step")
    # Its rate is in whole nanoseconds a bit.
    bit_ns = round(clocks * PERIOD_NS)
    source = UartSource(dut.rx, baud=1e9 / bit_ns - 1e-3)
    source.log.setLevel(logging.WARNING)
    dut.phase_step.value = round((1 << PHASE_BITS) * (1 + skew) * PERIOD_NS / bit_ns)
    await bench.reset()
    for _ in range(20):
        await bench.edge()
    sent = bytes([0, 255, 0x55, 0xAA, *(bench.bits(8) for _ in range(12))])
    source.write_nowait(sent)
    got = bytearray()
    for _ in range(int(10.2 * clocks * len(sent)) + 100):
        await bench.edge()
        if dut.byte_valid.value:
            got.append(int(dut.byte_data.value))
        bench.check("framing_error", bool(dut.framing_error.value), False)
    bench.check("bytes", bytes(got), sent)
    bench.finish(at_least=100)
