# SPDX-License-Identifier: Apache-2.0
"""
Areas of a plane out of an SDRAM: runs and words of each, at every pace, also of those that are stopped.

Behind the unit stand the controller's model and a chip whose words are all different.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import cocotb
import pytest

from cocotb_tests.support.bench import SPEEDS, Bench, StreamSink
from cocotb_tests.support.resets import reset_amid
from cocotb_tests.support.sdram import Memory, chip_place, words_of
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.golden.common.sdram_controller import SdramGenerics
from quadshade.golden.screen.sdram_read_out import area_runs

AREA = ("area_x", "area_y", "area_width", "area_plane")
INPUTS = ("stop", "area_valid", *AREA, "run_ready", "read_valid", "read_data", "word_ready")


@dataclass(frozen=True)
class Config:
    """Generics of ``sdram_read_out``."""

    width: int = 24
    height: int = 5
    coord_bits: int = 6
    data_bits: int = 16
    run_words: int = 8


CONFIGS = [
    Config(),
    Config(width=64, height=3, coord_bits=7, run_words=32),
    Config(width=6, height=8, coord_bits=3, data_bits=9, run_words=2),
]


@pytest.mark.parametrize("config", CONFIGS, ids=identifier)
def test_sdram_read_out(config: Config) -> None:
    simulate("sdram_read_out", config)


@cache
def different_words(data_bits: int) -> dict[tuple[int, int, int], int]:
    """By bank, row and column: a word says where it stands. As many as the largest screen here has."""
    organisation = SdramGenerics()
    words = {}
    for address in range(3 * 64 * 8 + 64 * 8):
        words[chip_place(address, organisation)] = (address * 40503 >> 3) % (1 << data_bits)
    return words


class Reader:
    """The unit, its memory, and who takes the words."""

    def __init__(self, bench: Bench, speed: str) -> None:
        config = bench.config
        self.bench, self.dut = bench, bench.dut
        generics = SdramGenerics(
            data_bits=config.data_bits, run_words=config.run_words, refresh_clocks=150, power_up_refreshes=2
        )
        self.memory = Memory(bench, generics, 0.02)
        self.memory.chip.words = different_words(config.data_bits)
        self.sink = StreamSink(
            bench, self.dut.word_valid, self.dut.word_ready, [self.dut.word_data], SPEEDS[speed](bench.draw)
        )

    async def cycle(self) -> None:
        """One clock."""
        self.sink.drive()
        await self.memory.edge()
        self.sink.sample(self.bench.cycle)

    def expected(self, area: tuple[int, int, int, int]) -> tuple[list, list[int]]:
        """Runs of an area, and its words."""
        (x, y, columns, plane), config = area, self.bench.config
        runs = list(area_runs(plane, x, y, columns, config.width, config.height, config.run_words))
        places = [run.address + index for run in runs for index in range(run.more + 1)]
        return runs, words_of(self.memory.chip, self.memory.generics, places)

    async def read(self, most: int | None = None) -> None:
        """Any area to its end, or stopped after so many words; others are asked for meanwhile in vain."""
        bench, dut, config = self.bench, self.dut, self.bench.config
        x = bench.draw.randrange(config.width)
        columns = bench.draw.choice((1, config.width - x, bench.draw.randint(1, config.width - x)))
        area = (x, bench.draw.randrange(config.height), columns, bench.draw.randrange(3))
        for name, value in zip(AREA, area, strict=True):
            getattr(dut, name).value = value
        dut.area_valid.value = 1
        self.memory.runs.clear()
        self.sink.words.clear()
        self.sink.held = None
        await self.cycle()
        bench.check("idle", bool(dut.idle.value), True)
        dut.area_x.value, dut.area_width.value = bench.draw.randrange(config.width), 1
        runs, words = self.expected(area)
        clocks = bench.draw.randrange(3 * config.run_words + 30) if most is None else 0
        while len(self.sink.words) < len(words) and not (most is None and clocks == 0):
            dut.area_valid.value = bench.draw.randrange(2)
            await self.cycle()
            clocks -= 1
        dut.area_valid.value = 0
        got = [word for (word,) in self.sink.words]
        if most is None:
            dut.stop.value = 1
            await self.cycle()
            dut.stop.value = 0
            got = [word for (word,) in self.sink.words]
            bench.check_all("word before the stop", got, words[: len(got)])
            self.sink.held = None
            await self.cycle()
            bench.check("a word after the stop", bool(dut.word_valid.value), False)
            bench.check("a run after the stop", bool(dut.run_valid.value), False)
            while not dut.idle.value:
                await self.cycle()
                bench.check("a word after the stop", bool(dut.word_valid.value), False)
                bench.check("a run after the stop", bool(dut.run_valid.value), False)
        else:
            bench.check_all("word", got, words)
            bench.check_all("run", self.memory.runs, runs)
            await self.cycle()
            bench.check("idle behind the last word", bool(dut.idle.value), True)
            for _ in range(bench.draw.randrange(4)):
                await self.cycle()


@cocotb.test(timeout_time=10, timeout_unit="ms")
@cocotb.parametrize(speed=list(SPEEDS))
async def areas(dut: Any, speed: str) -> None:
    bench = Bench(dut, Config, f"areas {speed}")
    await bench.start(*INPUTS)
    reader = Reader(bench, speed)
    for index in range(24):
        await reader.read(most=None if index % 2 else 1)
    bench.finish(at_least=150)


@cocotb.test(timeout_time=10, timeout_unit="ms")
async def resets(dut: Any) -> None:
    """Of the unit and its controller together."""
    bench = Bench(dut, Config, "resets")
    await bench.start(*INPUTS)

    async def work() -> None:
        reader = Reader(bench, "throttled")
        await reader.read(most=1)
        await reader.read()

    events = ("area_valid", ("run_valid", "run_ready"), "read_valid", ("word_valid", "word_ready"), "stop")
    await reset_amid(bench, work, events, 6, quiet=("run_valid", "word_valid"))
    bench.finish(at_least=40)
