# SPDX-License-Identifier: Apache-2.0
"""
An SDRAM behind a unit: the controller's model and a chip, or the chip alone at the unit's pins.

The chip raises where a command comes too early or too late.
"""

from __future__ import annotations

from collections.abc import Iterable

from cocotb.triggers import RisingEdge

from cocotb_tests.support.bench import Bench
from quadshade.golden.common.sdram_chip import CHIPS, Command, Pins, SdramChip
from quadshade.golden.common.sdram_controller import Run, SdramController, SdramGenerics

FIRST, SECOND = 0, 1
"""Ports of the controller."""

CHIP = "AS4C16M16SA-7"


class ChipPins:
    """The pins between a unit and its chip."""

    def __init__(self, bench: Bench) -> None:
        self.bench, dut = bench, bench.dut
        self.data = dut.sdram_data_out
        self.whole = getattr(dut, "sdram_command", None)
        if self.whole is None:
            self.parts = (dut.sdram_ras_n, dut.sdram_cas_n, dut.sdram_we_n)
        self.others = [getattr(dut, f"sdram_{name}") for name in ("bank", "address", "mask", "drive")]

    def command(self) -> Command:
        """What the chip is told."""
        if self.whole is not None:
            return Command(int(self.whole.value))
        ras, cas, we = (int(port.value) for port in self.parts)
        return Command(ras << 2 | cas << 1 | we)

    def read(self) -> Pins:
        """What the chip sees; before the first command some of it is unknown, and data that nobody drives."""
        bank, address, mask, drive = (self.bench.unqualified(port) for port in self.others)
        data = int(self.data.value) if drive else 0
        return Pins(self.command(), bank, address, bool(mask), bool(drive), data)


def chip_place(address: int, generics: SdramGenerics) -> tuple[int, int, int]:
    """Bank, row and column of the controller's address."""
    page, column = divmod(address, 1 << generics.column_bits)
    row, bank = divmod(page, 1 << generics.bank_bits)
    return bank, row, column


def words_of(chip: SdramChip, generics: SdramGenerics, addresses: Iterable[int]) -> list[int]:
    """The chip's words at addresses; −1 where none was written."""
    return [chip.words.get(chip_place(address, generics), -1) for address in addresses]


def write_words(
    chip: SdramChip, generics: SdramGenerics, addresses: Iterable[int], words: Iterable[int]
) -> None:
    """Set the chip's words, past its pins."""
    for address, word in zip(addresses, words, strict=True):
        chip.words[chip_place(address, generics)] = word


class Memory:
    """
    The controller's model, the chip, and the unit at one of both ports; the other one asks at random.

    Parameters
    ----------
    bench : Bench
      Of a unit with a run's ports; those of words it may have.
    generics : SdramGenerics
    beside : float
      How probably the other port asks in a clock; 1: always, for the longest runs.
    port : int
      The unit's.
    """

    def __init__(self, bench: Bench, generics: SdramGenerics, beside: float, port: int = SECOND) -> None:
        self.bench, self.dut, self.beside, self.port = bench, bench.dut, beside, port
        self.generics = generics
        self.controller = SdramController(self.generics)
        self.chip = SdramChip(CHIPS[CHIP], 100e6, 1000)
        self.other: Run | None = None
        self.runs: list[Run] = []
        self.accepted: list[int] = []
        self.given: list[int] = []
        """Clocks in which the unit's words came."""
        names = ("run_ready", "read_valid", "read_data", "write_next")
        self.inputs = {name: getattr(self.dut, name, None) for name in names}
        self.writes = getattr(self.dut, "run_write", None)

    def drive(self, name: str, value: int) -> None:
        """Set an input, if the unit has it."""
        port = self.inputs[name]
        if port is not None:
            port.value = value

    async def edge(self) -> None:
        """One clock of all three."""
        dut, controller, draw = self.dut, self.controller, self.bench.draw
        if self.other is None and self.bench.chance(self.beside):
            most = self.generics.run_words
            self.other = Run(0, most - 1 if self.beside == 1 else draw.randrange(most), False)
        first = self.port == FIRST
        given = self.chip.data
        comes = controller.coming[0] == self.port
        self.drive("run_ready", int(controller.free and (first or self.other is None)))
        self.drive("read_valid", int(comes))
        if controller.read_data is not None:
            self.drive("read_data", controller.read_data)
        self.drive("write_next", int(controller.write_next))
        await self.bench.edge()
        if comes:
            self.given.append(self.bench.cycle)
        unit = None
        if dut.run_valid.value:
            writes = self.writes is not None and bool(self.writes.value)
            unit = Run(int(dut.run_address.value), int(dut.run_more.value), writes)
        word, keeps = 0, False
        if controller.write_next:
            word, keeps = int(dut.write_data.value), bool(dut.write_keep.value)
        asked = (unit, self.other) if first else (self.other, unit)
        goes = controller.free and (asked[0] or asked[1])
        if goes and goes is unit:
            self.runs.append(goes)
            self.accepted.append(self.bench.cycle)
        self.chip.clock(controller.pins)
        controller.clock(*asked, word, given, keeps)
        if goes and goes is not unit:
            self.other = None


async def at_pins(bench: Bench, chip: SdramChip) -> None:
    """A chip at the unit's pins, from now on."""
    dut, pins, given = bench.dut, ChipPins(bench), None
    edge = RisingEdge(dut.clk)
    while True:
        await edge
        # While nothing is said the other pins are not looked at, which takes most of the time.
        silent = pins.command() == Command.NOTHING and not dut.sdram_drive.value
        chip.clock(Pins(Command.NOTHING, mask=bool(dut.sdram_mask.value)) if silent else pins.read())
        if chip.data != given or not silent:
            given = chip.data
            dut.sdram_data_in.value = bench.bits(16) if given is None else given
