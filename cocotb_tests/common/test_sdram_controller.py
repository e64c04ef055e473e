# SPDX-License-Identifier: Apache-2.0
"""
The SDRAM's controller against the model, every port in every cycle, and against a chip that refuses.

The chip is that of a data sheet: it raises at the first command that comes too early or too late. What is
read is compared with what was written, in the order in which the runs were accepted.
"""

from __future__ import annotations

import dataclasses
import subprocess
from collections import deque
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import cocotb
import pytest

from cocotb_tests.support.bench import SPEEDS, Bench
from cocotb_tests.support.resets import at_random
from cocotb_tests.support.sdram import ChipPins
from cocotb_tests.support.simulation import STANDARD, elaborated, identifier, simulate
from quadshade.golden.common.sdram_chip import CHIPS, Command, Pins, SdramChip
from quadshade.golden.common.sdram_controller import Run, SdramController, SdramGenerics

INPUTS = (
    *("first_valid", "first_address", "first_more"),
    *("second_valid", "second_write", "second_address", "second_more", "write_data", "write_keep"),
    "sdram_data_in",
)
ROWS = 16
"""Of the chip that is refreshed so often that a test sees it: fewer rows in a shorter time."""


@dataclass(frozen=True)
class Config(SdramGenerics):
    """Generics of ``sdram_controller``; short runs and a short rest after power-up if left out."""

    run_words: int = 8
    refresh_clocks: int = 60
    power_up_refreshes: int = 3


FAST = {"cas_clocks": 2, "rcd_clocks": 2, "rp_clocks": 2}
SLOW = {"cas_clocks": 2, "rcd_clocks": 1, "rp_clocks": 1, "ras_clocks": 3, "rc_clocks": 4, "rfc_clocks": 4}
CONFIGS = [
    Config(),
    Config(**FAST),
    Config(**SLOW, wr_clocks=1, run_words=2, refresh_clocks=30),
    Config(data_bits=32, row_bits=11, column_bits=8, run_words=64, refresh_clocks=130, power_up_refreshes=2),
]


@pytest.mark.parametrize("config", CONFIGS, ids=identifier)
def test_sdram_controller(config: Config) -> None:
    simulate("sdram_controller", config)


@pytest.mark.parametrize(("clocks", "code"), [(0, 1), (1, 0)])
def test_refuses_refreshes_too_near(clocks: int, code: int) -> None:
    """Between two of them there is room for the longest run, from its request on, and a refresh."""
    config = Config(**FAST)
    longest = 1 + config.run_clocks(config.run_words, True) + config.rfc_clocks
    command = ["ghdl", "-r", STANDARD, "sdram_controller", "--stop-time=1ns"]
    command += [f"-grun_words={config.run_words}", f"-grefresh_clocks={longest + clocks}"]
    command += [f"-g{name}={value}" for name, value in FAST.items()]
    library = elaborated("sdram_controller")
    done = subprocess.run(command, cwd=library, capture_output=True, text=True, check=False)
    assert done.returncode == code, done.stdout
    assert ("must be longer than the longest run and a refresh" in done.stdout + done.stderr) == bool(code)


def chip_of(config: Config) -> SdramChip:
    """The chip whose times the configuration's clocks are; its rows are few, and refreshed so often."""
    frequency = 50e6 if config.rcd_clocks == 1 else 100e6
    name = "AS4C16M16SA-7" if config.rcd_clocks == 3 else "MT48LC16M16A2-75"
    timing = CHIPS[name]
    late = config.run_clocks(config.run_words, True) + config.rfc_clocks
    clocks = ROWS * config.refresh_clocks + late
    timing = dataclasses.replace(
        timing, rows=ROWS, columns=1 << config.column_bits, t_ref=clocks * 1e9 / frequency
    )
    return SdramChip(timing, frequency, 1e9 / frequency * config.refresh_clocks)


class Port:
    """One of both that ask: a request stands until it is accepted."""

    def __init__(self, bench: Bench, name: str, go: Any, rows: int) -> None:
        self.bench, self.dut, self.name, self.go = bench, bench.dut, name, go
        self.rows = rows
        self.wanted: Run | None = None

    def drive(self) -> None:
        """Set the signals for the next edge; what nobody asks for is anything."""
        bench, config = self.bench, self.bench.config
        if self.wanted is None:
            row, bank = bench.draw.randrange(self.rows), bench.draw.randrange(1 << config.bank_bits)
            # Two columns in most runs are the same, and some runs go over the row's end.
            column = bench.draw.choice((0, 1, (1 << config.column_bits) - 2, bench.bits(config.column_bits)))
            address = (row << config.bank_bits | bank) << config.column_bits | column
            more = bench.draw.choice((0, config.run_words - 1, bench.draw.randrange(config.run_words)))
            write = self.name == "second" and bench.chance(0.5)
            run = Run(address, more, write)
            getattr(self.dut, f"{self.name}_address").value = run.address
            getattr(self.dut, f"{self.name}_more").value = run.more
            if self.name == "second":
                self.dut.second_write.value = int(run.write)
            # The first port leaves time to the second, which waits for it.
            asks = next(self.go) and (self.name == "second" or bench.chance(0.05))
            self.wanted = run if asks else None
            getattr(self.dut, f"{self.name}_valid").value = int(self.wanted is not None)


def used(pins: Pins) -> Pins:
    """Without what stands on pins that the command does not use, which may be anything."""
    silent = pins.command in (Command.NOTHING, Command.REFRESH)
    return pins._replace(
        bank=0 if silent or pins.command == Command.PRECHARGE else pins.bank,
        address=0 if silent else pins.address,
        # Between reads the mask may stand.
        mask=pins.mask and pins.command in (Command.READ, Command.WRITE),
        data=pins.data if pins.drive else 0,
    )


class Traffic:
    """Two ports, the model, the chip, and what should be read; runs are in the first so many rows."""

    def __init__(self, bench: Bench, speed: str, rows: int = ROWS) -> None:
        self.bench, self.dut, self.config = bench, bench.dut, bench.config
        self.chip, self.pins = chip_of(self.config), ChipPins(bench)
        self.model = SdramController(self.config)
        self.ports = [Port(bench, name, SPEEDS[speed](bench.draw), rows) for name in ("first", "second")]
        self.words: dict[int, int] = {}
        self.unwritten: deque[int] = deque()
        self.unread: tuple[deque[int | None], ...] = (deque(), deque())
        self.runs = 0

    def accept(self, port: int, run: Run) -> None:
        """A run was accepted: its addresses, in order."""
        columns = 1 << self.config.column_bits
        page = run.address // columns * columns
        places = [page + (run.address + index) % columns for index in range(run.more + 1)]
        if run.write:
            self.unwritten.extend(places)
        else:
            # The runs before it are over when it begins.
            self.unread[port].extend(self.words.get(place) for place in places)
        self.ports[port].wanted = None
        self.runs += 1

    async def power_up(self, cycles: int) -> None:
        """So many clocks in which nothing is asked for and the chip is told nothing."""
        for index in range(cycles):
            await self.bench.edge()
            pins = self.pins.read()
            self.bench.check("command", pins.command, Command.NOTHING, index)
            self.chip.clock(pins)
            self.model.clock(None, None, 0, None)

    async def cycle(self, index: int, resets: bool = False, asks: bool = True) -> None:
        """One clock: drive, compare, and what follows of it."""
        bench, dut, model = self.bench, self.dut, self.model
        for port in self.ports:
            if asks:
                port.drive()
            elif port.wanted is None:
                getattr(dut, f"{port.name}_valid").value = 0
        word = bench.bits(self.config.data_bits)
        keeps = bench.chance(0.3)
        dut.write_data.value, dut.write_keep.value = word, int(keeps)
        given = self.chip.data
        driven = bench.bits(self.config.data_bits) if given is None else given
        dut.sdram_data_in.value = driven
        dut.reset.value = int(resets)
        await bench.edge()
        first, second = (port.wanted for port in self.ports)
        pins = self.pins.read()
        bench.check("pins", used(pins), used(model.pins), index)
        bench.check("first_ready", bool(dut.first_ready.value), model.free, index)
        if second is not None:
            bench.check("second_ready", bool(dut.second_ready.value), model.free and first is None, index)
        bench.check("write_next", bool(dut.write_next.value), model.write_next, index)
        for port, name in enumerate(("first", "second")):
            valid = bool(getattr(dut, f"{name}_data_valid").value)
            bench.check(f"{name}_data_valid", valid, model.coming[0] == port, index)
            if valid:
                read = int(dut.read_data.value)
                bench.check("read_data", read, model.read_data, index)
                expected = self.unread[port].popleft() if self.unread[port] else None
                if expected is not None:
                    bench.check(f"word of {name}", read, expected, index)
        if model.write_next:
            place = self.unwritten.popleft()
            if not keeps:
                self.words[place] = word
        if not resets and model.free and (first or second):
            self.accept(int(first is None), first or second)
        self.chip.clock(pins)
        model.clock(first, second, word, driven, keeps)
        if resets:
            model.reset()
            self.unread = (deque(), deque())
            # A word that was taken in the clock of the reset is not written, the others of its run neither.
            self.words = {}
            self.unwritten.clear()


@cocotb.test(timeout_time=10, timeout_unit="ms")
@cocotb.parametrize(speed=list(SPEEDS))
async def every_cycle(dut: Any, speed: str) -> None:
    bench = Bench(dut, Config, f"every_cycle {speed}")
    await bench.start(*INPUTS)
    traffic = Traffic(bench, speed)
    config, chip = bench.config, traffic.chip
    begins = config.refresh_clocks * config.power_up_refreshes
    if speed == "throttled":
        await traffic.power_up(begins - 10)
    cycles = begins + 2 * ROWS * config.refresh_clocks
    for index in range(bench.cycle, cycles):
        await traffic.cycle(index)
    # What is on its way arrives.
    for index in range(4 * config.run_clocks(config.run_words, True)):
        await traffic.cycle(cycles + index, asks=False)
    bench.check("words left over", [len(left) for left in (*traffic.unread, traffic.unwritten)], [0, 0, 0])
    bench.check("traffic came", min(chip.reads, chip.writes, traffic.runs) > 30, True)
    bench.check("refreshes came", chip.refreshes >= 8 + (cycles - begins) // config.refresh_clocks - 1, True)
    bench.finish(at_least=cycles)


@cocotb.test(timeout_time=10, timeout_unit="ms")
async def resets(dut: Any) -> None:
    """In any cycle, also amid the order after power-up; the chip, with all its rows, finds nothing wrong."""
    bench = Bench(dut, Config, "resets throttled")
    await bench.start(*INPUTS)
    config = bench.config
    traffic = Traffic(bench, "throttled", 1 << config.row_bits)
    begins = config.refresh_clocks * config.power_up_refreshes + 8 * config.rfc_clocks
    resets_now = at_random(bench.draw, 3 * begins)
    timing = dataclasses.replace(traffic.chip.timing, rows=1 << config.row_bits, t_ref=1e9)
    traffic.chip.timing = timing
    for index in range(2000):
        await traffic.cycle(index, next(resets_now))
    bench.check("traffic came", traffic.runs > 10, True)
    bench.finish(at_least=2000)


@cocotb.test(timeout_time=10, timeout_unit="ms")
async def clocks(dut: Any) -> None:
    """What a run takes, and its first word, as the model's closed forms say."""
    bench = Bench(dut, Config, "clocks")
    await bench.start(*INPUTS)
    config, chip, all_pins = bench.config, chip_of(bench.config), ChipPins(bench)
    dut.second_valid.value = 1
    runs, accepted, arrived, expected = [], [], [], []
    refreshed = 0
    run = Run(0, config.run_words - 1, True)
    while len(accepted) < 12:
        dut.second_write.value = int(run.write)
        dut.second_more.value = run.more
        dut.sdram_data_in.value = chip.data or 0
        await bench.edge()
        arrived += [bench.cycle] * int(dut.second_data_valid.value)
        if dut.second_ready.value:
            # As if there had been no refresh.
            accepted.append(bench.cycle - refreshed)
            expected += [
                bench.cycle + config.latency() + word for word in range(0 if run.write else run.more + 1)
            ]
            runs.append(run)
            run = Run(0, bench.draw.randrange(config.run_words), bench.chance(0.5))
        pins = all_pins.read()
        refreshed += config.rfc_clocks * (pins.command == Command.REFRESH)
        chip.clock(pins)
    for index, (one, other) in enumerate(pairwise(accepted)):
        took = config.run_clocks(runs[index].more + 1, runs[index].write)
        bench.check("clocks of a run", other - one, took, index, runs[index])
    bench.check("words came", arrived, expected[: len(arrived)])
    bench.check("reads came", len(arrived) > 0, True)
    bench.finish(at_least=13)
