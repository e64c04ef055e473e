# SPDX-License-Identifier: Apache-2.0
"""The boards' serialiser: bits on its TMDS data channels against its words, at every phase of both clocks."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cocotb
import pytest
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, RisingEdge, Timer

from cocotb_tests.support.bench import Bench
from cocotb_tests.support.simulation import identifier, simulate

ROOT = Path(__file__).resolve().parents[2]
PIXEL_NS, SHIFT_NS = 40, 8
RESET_CLOCKS = 8
CLOCK_CHANNEL = 0b0000011111


@dataclass(frozen=True)
class Config:
    """What stands around ``gpdi``, which has no parameters: the system's clocks of a pixel, the pins."""

    clocks: int = 4
    family: str = "ecp5"


@pytest.mark.parametrize("config", [Config(), Config(2, "gowin")], ids=identifier)
def test_gpdi(config: Config) -> None:
    sources = [ROOT / "synth" / "boards" / name for name in ("gpdi.v", f"ddr_pair_{config.family}.v")]
    simulate("gpdi", config, {}, verilog=[*sources, Path(__file__).with_name(f"pins_{config.family}.v")])


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(phase_ps=[100, 1300, 2500, 3700, 4900, 6100, 7900], first=[0, 1, 2, 3])
async def every_bit(dut: Any, phase_ps: int, first: int) -> None:
    bench = Bench(dut, Config, f"every_bit {phase_ps} {first}")
    clocks = bench.config.clocks
    dut.word_next.value, dut.words.value, dut.reset.value = 0, 0, 1
    Clock(dut.clk, PIXEL_NS // clocks, "ns").start(start_high=False)
    words: list[int] = []
    bits: list[int] = []

    async def shift() -> None:
        await Timer(phase_ps, "ps")
        Clock(dut.clk_shift, SHIFT_NS, "ns").start(start_high=False)

    async def watch() -> None:
        # In the middle of each half of a cycle.
        while True:
            for edge in (RisingEdge, FallingEdge):
                await edge(dut.clk_shift)
                await Timer(SHIFT_NS * 250, "ps")
                bits.append(int(dut.gpdi_dp.value))
                if bench.config.family == "gowin":
                    bench.check("the other pin of each pair", int(dut.gpdi_dn.value), bits[-1] ^ 0xF)

    cocotb.start_soon(shift())
    cocotb.start_soon(watch())
    for index in range(60 * clocks):
        await RisingEdge(dut.clk)
        dut.reset.value = int(index < RESET_CLOCKS)
        # The words change with the edge that ends a cycle of word_next.
        if index % clocks == (first + 1) % clocks and index > RESET_CLOCKS + clocks:
            words.append(bench.draw.getrandbits(30))
            dut.words.value = words[-1]
        dut.word_next.value = int(index % clocks == first % clocks and index >= RESET_CLOCKS + clocks)

    # What was there before the reset is over by then.
    serial = [bit >> 3 & 1 for bit in bits]
    begin = next(at for at in range(20, len(serial)) if serial[at] and not serial[at - 1])
    got = []
    for at in range(begin, len(bits) - 10, 10):
        four = [sum((bits[at + bit] >> number & 1) << bit for bit in range(10)) for number in range(4)]
        bench.check("clock channel", four[3], CLOCK_CHANNEL, at)
        got.append(four[0] | four[1] << 10 | four[2] << 20)
    bench.check("many words came", len(got) > 50, True)
    # From the first on; none is lost, none comes twice.
    bench.check("words", got, words[: len(got)])
    bench.finish(at_least=50)
