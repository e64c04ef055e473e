# SPDX-License-Identifier: Apache-2.0
"""
Scanlines out of an SDRAM: the runs of each, and how long its last word takes beside a port that always asks.

Behind the unit stand the controller's model and a chip that refuses.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cocotb
import pytest

from cocotb_tests.support.bench import Bench
from cocotb_tests.support.resets import reset_amid
from cocotb_tests.support.sdram import FIRST, Memory
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.golden.common.sdram_controller import SdramGenerics
from quadshade.golden.screen.sdram_line_fetch import line_runs, most_line_clocks

INPUTS = ("line_start", "line_first", "plane", "run_ready")


@dataclass(frozen=True)
class Config:
    """Generics of ``sdram_line_fetch``."""

    width: int = 640
    height: int = 480
    run_words: int = 64

    def runs(self, plane: int, y: int) -> list:
        """Of a scanline."""
        return line_runs(plane, y, self.width, self.height, self.run_words)


CONFIGS = [Config(), Config(width=24, height=5, run_words=8), Config(width=4, height=2, run_words=2)]


@pytest.mark.parametrize("config", CONFIGS, ids=identifier)
def test_sdram_line_fetch(config: Config) -> None:
    simulate("sdram_line_fetch", config)


async def lines(bench: Bench, count: int, beside: float) -> int:
    """Scanlines of a reset unit, the picture's second one first; the most clocks that one took."""
    dut, config = bench.dut, bench.config
    # Refreshes come amid many scanlines, and not too often for the others.
    generics = SdramGenerics(
        run_words=config.run_words, refresh_clocks=4 * config.run_words + 90, power_up_refreshes=2
    )
    memory = Memory(bench, generics, beside, FIRST)
    while not memory.controller.free:
        await memory.edge()
    y, longest = 0, 0
    for index in range(count):
        first = y == config.height - 1 or bench.chance(0.1)
        y = 0 if first else y + 1
        plane = bench.draw.randrange(2)
        for _ in range(bench.draw.randrange(40)):
            dut.line_first.value, dut.plane.value = bench.draw.randrange(2), bench.draw.randrange(2)
            await memory.edge()
        dut.line_start.value, dut.line_first.value, dut.plane.value = 1, int(first), plane
        memory.runs.clear()
        memory.given.clear()
        await memory.edge()
        begin = bench.cycle
        dut.line_start.value = 0
        while len(memory.given) < config.width:
            dut.line_first.value = bench.draw.randrange(2)
            await memory.edge()
        longest = max(longest, bench.cycle - begin)
        bench.check_all("run", memory.runs, config.runs(plane, y), lambda _, index=index: index)
        most = most_line_clocks(config.width, generics)
        bench.check("clocks of a scanline", bench.cycle - begin <= most, True, index, bench.cycle - begin)
    return longest


@cocotb.test(timeout_time=10, timeout_unit="ms")
@cocotb.parametrize(beside=[0.0, 0.02, 1.0])
async def scanlines(dut: Any, beside: float) -> None:
    bench = Bench(dut, Config, f"scanlines {beside}")
    await bench.start(*INPUTS)
    count = 4 if bench.default else 20
    longest = await lines(bench, count, beside)
    dut._log.info("a scanline took up to %d clocks", longest)
    bench.finish(at_least=2 * count)


@cocotb.test(timeout_time=10, timeout_unit="ms")
async def resets(dut: Any) -> None:
    """Of the unit and its controller together: no run is asked for until a scanline is wanted."""
    bench = Bench(dut, Config, "resets")
    await bench.start(*INPUTS)

    async def work() -> None:
        await lines(bench, 1 if bench.default else 3, 0.02)

    events = ("line_start", ("run_valid", "run_ready"))
    await reset_amid(bench, work, events, 3 if bench.default else 16, quiet=("run_valid",))
    bench.finish(at_least=10)
