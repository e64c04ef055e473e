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


def pins_of(bench: Bench) -> Pins:
    """What the chip sees; before the first command some of it is unknown, and data that nobody drives."""
    dut = bench.dut
    if hasattr(dut, "sdram_command"):
        command = int(dut.sdram_command.value)
    else:
        ras, cas, we = dut.sdram_ras_n, dut.sdram_cas_n, dut.sdram_we_n
        command = int(ras.value) << 2 | int(cas.value) << 1 | int(we.value)
    names = ("bank", "address", "mask", "drive")
    bank, address, mask, drive = (bench.unqualified(getattr(dut, f"sdram_{name}")) for name in names)
    data = int(dut.sdram_data_out.value) if drive else 0
    return Pins(Command(command), bank, address, bool(mask), bool(drive), data)


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

    def drive(self, name: str, value: int) -> None:
        """Set an input, if the unit has it."""
        port = getattr(self.dut, name, None)
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
            writes = not first and hasattr(dut, "run_write") and bool(dut.run_write.value)
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
    while True:
        await RisingEdge(bench.dut.clk)
        chip.clock(pins_of(bench))
        bench.dut.sdram_data_in.value = chip.data if chip.data is not None else bench.bits(16)
