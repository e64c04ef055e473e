# SPDX-License-Identifier: Apache-2.0
"""
Families of FPGAs: a file each in ``synth/families`` says how Yosys, nextpnr and the packer are told.

A new family is a file more. What stands in braces is filled in when a text is used: ``{run}`` is the device's
synthesis pass up to its ``-run``, ``{top}`` the module on top, ``{pins}``, ``{routed}`` and
``{packed}`` are files, ``{mhz}`` is the system clock, other names are those of ``numbers``.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import MISSING, dataclass, field, fields
from functools import cache
from pathlib import Path
from typing import Any

from quadshade.engine.sources import repository_root
from quadshade.errors import QuadshadeError


@dataclass(frozen=True)
class Counted:
    """
    What a netlist's cells are counted as.

    Attributes
    ----------
    luts : mapping of str to int
      LUTs of four inputs that a cell takes.
    carries : tuple of str
      Carry cells.
    flip_flops, block_rams, multipliers : str
      Patterns of whole names.
    """

    luts: Mapping[str, int]
    carries: tuple[str, ...]
    flip_flops: str
    block_rams: str
    multipliers: str


@dataclass(frozen=True)
class Clocks:
    """
    Cells of a family that make or take a clock.

    Attributes
    ----------
    makes : mapping of str to tuple of str
      Cells that make clocks, and their outputs that are clocks; the others belong to no clock.
    takes : mapping of str to str
      Cells with registers inside, and the port of their clock.
    without : tuple of str
      Cells of pins, whose outputs are their inputs.
    """

    makes: Mapping[str, Sequence[str]]
    takes: Mapping[str, str]
    without: tuple[str, ...] = ()


@dataclass(frozen=True)
class Device:
    """
    One device at one speed grade, and how the tools are told so.

    Attributes
    ----------
    name : str
    yosys : str
      Synthesis pass and options.
    nextpnr : tuple of str
      Options that name the device.
    aim_mhz : int
      Frequency that placement aims at: above what the device reaches, so that it never stops trying.
    pack : tuple of str
      Options of the packer that name the device.
    """

    name: str
    yosys: str
    nextpnr: tuple[str, ...]
    aim_mhz: int
    pack: tuple[str, ...] = ()

    @property
    def family(self) -> str:
        """Name of the file in ``synth/families`` that has it."""
        return self.name.split("-")[0]

    @property
    def described(self) -> Family:
        """Its family."""
        return find_family(self.family)

    @property
    def place(self) -> list[str]:
        """Command and options of nextpnr."""
        return [*self.described.nextpnr, *self.nextpnr]


@dataclass(frozen=True)
class Family:
    """
    A family of FPGAs, as its file has it.

    Attributes
    ----------
    name : str
    nextpnr : tuple of str
      Command and options of every run.
    unconstrained, constrained : tuple of str
      Options where nothing has a pin, and with a file of pins.
    routed : tuple of str
      Options that name what nextpnr writes.
    pin : str
      Pattern of a port and its pin in a file of pins; groups ``port`` and ``pin``.
    packer : tuple of str
      Command from ``{routed}`` to ``{packed}``; options of the board and the device follow its first word.
    suffix : str
      Of a bitstream.
    packages : tuple of str
      Python packages that place, route and pack.
    declared : tuple of str
      Yosys' files that declare all cells, for tops that hold some.
    share : str
      Folder of Yosys with ``cells_sim.v``.
    simulated : str
      The device that cells are mapped for where they are simulated.
    passes, finish : tuple of str
      Yosys' commands that map a design, and those that follow once it is flat.
    cells : mapping of str to mapping
      Entities with a file in ``synth/cells``: ``named`` is what GHDL adds to the name, ``parameters`` are
      the numbers in it.
    area : mapping of str to str
      What the report of bitstreams shows, and nextpnr's name of it.
    clocks : Clocks
    counted : Counted
    devices : mapping of str to Device
    extra : str
      Of ``pyproject.toml``, which has the packages where ``make setup`` does not install them.
    held : str
      Yosys' file that declares cells which a netlist holds before it is mapped.
    harness : str
      Pins of a design that is measured alone, where nextpnr leaves none to itself.
    absorbs_registers : bool
      Registers behind block RAM are moved into it.
    numbers : mapping of str to int
      Limits that ``passes`` use.
    """

    name: str
    nextpnr: tuple[str, ...]
    unconstrained: tuple[str, ...]
    constrained: tuple[str, ...]
    routed: tuple[str, ...]
    pin: str
    packer: tuple[str, ...]
    suffix: str
    packages: tuple[str, ...]
    declared: tuple[str, ...]
    share: str
    simulated: str
    passes: tuple[str, ...]
    cells: Mapping[str, Mapping[str, Any]]
    area: Mapping[str, str]
    clocks: Clocks
    counted: Counted
    devices: Mapping[str, Device]
    finish: tuple[str, ...] = ()
    extra: str = ""
    held: str = ""
    harness: str = ""
    absorbs_registers: bool = False
    numbers: Mapping[str, int] = field(default_factory=dict)

    @property
    def library(self) -> list[str]:
        """Yosys' commands that declare the cells that a netlist holds before it is mapped."""
        return [f"read_verilog -lib {self.held}"] if self.held else []

    def pins(self, text: str) -> list[tuple[str, str]]:
        """Ports and their pins in a file of pins, in its order."""
        return [(found["port"], found["pin"]) for found in re.finditer(self.pin, text)]


def filled(texts: Sequence[str], **values: object) -> list[str]:
    """Texts with what stands in their braces."""
    return [text.format(**values) for text in texts]


def _entries(kind: type, table: Mapping[str, Any], path: Path) -> dict[str, Any]:
    """
    A table's entries as a dataclass takes them: lists become tuples.

    Raises
    ------
    QuadshadeError
      One is missing, or one is not known.
    """
    known = {one.name: one for one in fields(kind)}
    needed = [
        name
        for name, one in known.items()
        if one.default is MISSING and one.default_factory is MISSING and name not in table
    ]
    if needed:
        raise QuadshadeError(
            f"{path.name} has no {needed[0]}", "quadshade.synthesis.families says what it is"
        )
    if unknown := sorted(table.keys() - known.keys()):
        raise QuadshadeError(f"{path.name} has {unknown[0]}, which no family has", "take it out")
    return {name: tuple(value) if isinstance(value, list) else value for name, value in table.items()}


def read_family(path: Path) -> Family:
    """
    A family from its file.

    Raises
    ------
    QuadshadeError
      It is no TOML, lacks an entry, or has one that is not known.
    """
    try:
        table = tomllib.loads(path.read_text())
    except tomllib.TOMLDecodeError as problem:
        raise QuadshadeError(f"{path}: {problem}") from None
    entries = _entries(Family, table | {"name": path.stem}, path)
    entries["clocks"] = Clocks(**_entries(Clocks, entries["clocks"], path))
    entries["counted"] = Counted(**_entries(Counted, entries["counted"], path))
    entries["devices"] = {
        name: Device(**_entries(Device, device | {"name": name}, path))
        for name, device in entries["devices"].items()
    }
    for name in entries["devices"]:
        if name.split("-")[0] != path.stem:
            raise QuadshadeError(f"{path.name} has the device {name}", f"call it {path.stem}-...")
    return Family(**entries)


@cache
def families() -> dict[str, Family]:
    """Every family by its name."""
    return {
        path.stem: read_family(path)
        for path in sorted((repository_root() / "synth" / "families").glob("*.toml"))
    }


def find_family(name: str) -> Family:
    """
    A family by name.

    Raises
    ------
    QuadshadeError
      There is no such family.
    """
    if name not in families():
        raise QuadshadeError(f"unknown family {name!r}", f"the families are {', '.join(families())}")
    return families()[name]


def clock_cells() -> Clocks:
    """Those of every family: no two have a cell of one name."""
    every = [family.clocks for family in families().values()]
    return Clocks(
        {cell: outputs for one in every for cell, outputs in one.makes.items()},
        {cell: port for one in every for cell, port in one.takes.items()},
        tuple(cell for one in every for cell in one.without),
    )


def devices() -> dict[str, Device]:
    """Every device by its name."""
    return {name: device for family in families().values() for name, device in family.devices.items()}
