# SPDX-License-Identifier: Apache-2.0
"""
Where a signal goes from one clock to another, or comes from a pin: found in Yosys' netlist of a board's top.

A crossing is a flip-flop whose new value depends on a register of another clock, a pin, or a PLL's lock.
"""

from __future__ import annotations

import json
import re
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from quadshade.errors import QuadshadeError
from quadshade.synthesis.families import clock_cells

Bit = int | str
"""Of Yosys' JSON: a net's number, or a constant."""

CHOICES = ("$mux", "$pmux")

NOT_LOGIC = ("$dlatch", "$adlatch", "$sr", "$ff", "$paramod")
"""What else Yosys' own cells' names begin with."""

KINDS = ("synchroniser", "held")
TIMED = "timed"
"""In the table, of what the netlist does not protect: a data sheet says when the value stands still."""


@dataclass(frozen=True)
class Crossing:
    """
    A way from one clock to another.

    Attributes
    ----------
    source, source_clock : str
      The register, pin or lock that it comes from, and its clock; none for what is no register.
    sink, sink_clock : str
      The register that it goes to.
    kind : str
      ``synchroniser``: two registers in a row, and nothing looks at the first one but the second.
      ``held``: the sink's own clock chooses when it is taken, so it may stand still by then. Else empty.
    """

    source: str
    source_clock: str
    sink: str
    sink_clock: str
    kind: str


def _rank(name: str) -> tuple[bool, int, str]:
    """Which of a net's names is shown: the VHDL's before GHDL's own, a short one before a long one."""
    return re.search(r"\bn[0-9]+_[a-z]+$", name) is not None, len(name), name


@dataclass(frozen=True)
class _Logic:
    """What gives a bit without a clock: kind and inputs of a cell, and the bit's place in its output."""

    kind: str
    inputs: Mapping[str, list[Bit]]
    place: int

    @property
    def bits(self) -> list[Bit]:
        """All inputs."""
        return [bit for bits in self.inputs.values() for bit in bits]


@dataclass
class _Register:
    """A clocked cell: what it takes, what it gives, in bits of nets."""

    name: str
    clock: Bit
    plain: bool
    """A flip-flop without enable and reset, whose data and outputs are in step."""
    data: list[Bit] = field(default_factory=list)
    other: list[Bit] = field(default_factory=list)
    outputs: list[Bit] = field(default_factory=list)


class ClockNetlist:
    """
    A flat netlist as ``proc``, ``flatten`` and ``memory_collect`` leave it.

    Parameters
    ----------
    module : mapping
      The top of Yosys' JSON.

    Raises
    ------
    QuadshadeError
      A cell that this module does not know has a clock or may have one.
    """

    def __init__(self, module: Mapping[str, Any]) -> None:
        self.known = clock_cells()
        self.names: dict[Bit, str] = {}
        for name, net in module["netnames"].items():
            for bit in net["bits"]:
                if not net["hide_name"] and (bit not in self.names or _rank(name) < _rank(self.names[bit])):
                    self.names[bit] = name
        self.registers: list[_Register] = []
        self.logic: dict[Bit, _Logic] = {}
        self.origin: dict[Bit, tuple[str, Bit]] = {}
        """By bit: name and clock of what it begins at; the clock is empty for a pin or a lock."""
        self.loads: defaultdict[Bit, int] = defaultdict(int)
        for name, port in module["ports"].items():
            for bit in port["bits"]:
                if port["direction"] != "output":
                    self.origin[bit] = name, ""
                else:
                    self.loads[bit] += 1
        for name, cell in module["cells"].items():
            self._add(name, cell)
        for register in self.registers:
            for bit in register.outputs:
                self.origin[bit] = self.names.get(bit, register.name), register.clock

    def _add(self, name: str, cell: Mapping[str, Any]) -> None:
        kind, ports, ways = cell["type"], cell["connections"], cell["port_directions"]
        inputs = {port: bits for port, bits in ports.items() if ways[port] != "output"}
        for bits in inputs.values():
            for bit in bits:
                self.loads[bit] += 1
        outputs = [bit for port, bits in ports.items() if ways[port] == "output" for bit in bits]
        if kind in self.known.makes:
            for port, bits in ports.items():
                if ways[port] == "output" and port not in self.known.makes[kind]:
                    self.origin[bits[0]] = f"{name} {port}", ""
        elif kind == "$mem_v2":
            self._add_memory(name, cell)
        elif "CLK" in ports or kind in self.known.takes:
            clock_port = self.known.takes.get(kind, "CLK")
            (clock,) = ports[clock_port]
            other = [bit for port, bits in inputs.items() if port not in ("D", clock_port) for bit in bits]
            self.registers.append(_Register(name, clock, kind == "$dff", ports.get("D", []), other, outputs))
        elif kind in self.known.without or (kind.startswith("$") and not kind.startswith(NOT_LOGIC)):
            for place, bit in enumerate(outputs):
                self.logic[bit] = _Logic(kind, inputs, place)
        else:
            raise QuadshadeError(
                f"{name} is a {kind}, whose clock is not known", "enter it in its family, synth/families"
            )

    def _add_memory(self, name: str, cell: Mapping[str, Any]) -> None:
        """A memory is a register where it is written or read by a clock, else logic of its address."""
        ports, parameters = cell["connections"], cell["parameters"]
        clocks = {bit for bit in ports["WR_CLK"] if isinstance(bit, int)}
        by_clock = parameters["RD_CLK_ENABLE"][::-1]
        clocks |= {bit for bit, used in zip(ports["RD_CLK"], by_clock, strict=True) if used == "1"}
        if len(clocks) > 1:
            raise QuadshadeError(
                f"memory {name} has two clocks", "give each side a clock of its own by a FIFO"
            )
        if "1" in by_clock and "0" in by_clock:
            raise QuadshadeError(f"memory {name} is read with and without a clock", "read it in one way")
        written = [bit for port in ("WR_ADDR", "WR_DATA", "WR_EN") for bit in ports[port]]
        read = [*ports["RD_ADDR"], *ports["RD_EN"]]
        if not clocks:
            for place, bit in enumerate(ports["RD_DATA"]):
                self.logic[bit] = _Logic("memory", {"RD_ADDR": ports["RD_ADDR"]}, place)
            return
        (clock,) = clocks
        if "1" in by_clock:
            self.registers.append(_Register(name, clock, False, [], written + read, list(ports["RD_DATA"])))
            return
        # What is read depends on what was written, and on the address at once.
        contents = f"{name} contents"
        self.origin[contents] = name, clock
        self.registers.append(_Register(name, clock, False, [], written, []))
        inputs = {"RD_ADDR": ports["RD_ADDR"], "contents": [contents]}
        for place, bit in enumerate(ports["RD_DATA"]):
            self.logic[bit] = _Logic("memory", inputs, place)

    def clock_name(self, clock: Bit) -> str:
        """The name of a clock's net; empty for no clock."""
        return self.names.get(clock, str(clock))

    def origins(self, bit: Bit) -> frozenset[Bit]:
        """Bits of registers, pins and locks that a bit depends on without a clock between."""
        found: set[Bit] = set()
        seen: set[Bit] = set()
        open_bits = [bit]
        while open_bits:
            at = open_bits.pop()
            if at in seen:
                continue
            seen.add(at)
            if at in self.origin:
                found.add(at)
            elif at in self.logic:
                open_bits += self.logic[at].bits
        return frozenset(found)

    def _clocks(self) -> dict[Bit, set[Bit]]:
        """By bit: clocks of all that it depends on; computed once for every bit, as paths are shared."""
        found: dict[Bit, set[Bit]] = {bit: {clock} for bit, (_, clock) in self.origin.items()}
        for start in self.logic:
            stack = [start]
            while stack:
                bit = stack[-1]
                if bit in found:
                    stack.pop()
                    continue
                inputs = self.logic[bit].bits
                missing = [one for one in inputs if one in self.logic and one not in found]
                if missing:
                    stack += missing
                    continue
                found[bit] = set().union(*(found.get(one, set()) for one in inputs))
                stack.pop()
        return found

    def _kind(self, register: _Register, bit: Bit, place: int | None) -> str:
        """How a register takes a bit that is not, or not only, of its own clock."""
        if place is None:
            return ""
        clocks = {self.origin[one][1] for one in self.origins(bit)}
        second = [
            other
            for other in self.registers
            if other.clock == register.clock and other.plain and register.outputs[place] in other.data
        ]
        alone = self.loads[register.outputs[place]] == 1
        if register.plain and register.clock not in clocks and second and alone:
            return "synchroniser"
        return "held" if self._is_chosen(bit, register.clock) else ""

    def _is_chosen(self, bit: Bit, clock: Bit) -> bool:
        """Whether foreign bits come only as a choice's values, and the choice is the clock's own."""
        if all(self.origin[one][1] == clock for one in self.origins(bit)):
            return True
        if bit not in self.logic or self.logic[bit].kind not in CHOICES:
            return False
        choice = self.logic[bit]
        if any(self.origin[one][1] != clock for select in choice.inputs["S"] for one in self.origins(select)):
            return False
        # What is chosen is a register of another clock itself, or another such choice.
        first, others = choice.inputs["A"], choice.inputs["B"]
        values = [first[choice.place], *others[choice.place :: len(first)]]
        return all(
            one in self.origin or isinstance(one, str) or self._is_chosen(one, clock) for one in values
        )

    def crossings(self) -> list[Crossing]:
        """Every crossing once, bits of one register together; their kind is that of the worst bit."""
        clocks = self._clocks()
        found: dict[tuple[str, str, str, str], set[str]] = defaultdict(set)
        for register in self.registers:
            places: list[int | None] = [*range(len(register.data)), *([None] * len(register.other))]
            for bit, place in zip([*register.data, *register.other], places, strict=True):
                if not clocks.get(bit, set()) - {register.clock}:
                    continue
                kind = self._kind(register, bit, place)
                sink = (
                    register.name if place is None else self.names.get(register.outputs[place], register.name)
                )
                for name, clock in (self.origin[origin] for origin in self.origins(bit)):
                    if clock != register.clock:
                        way = (name, self.clock_name(clock), sink, self.clock_name(register.clock))
                        found[way].add(kind)
        return [Crossing(*way, min(kinds)) for way, kinds in sorted(found.items())]


def read_clocks(path: Path, top: str) -> ClockNetlist:
    """A netlist from Yosys' JSON."""
    return ClockNetlist(json.loads(path.read_text())["modules"][top])


def compare(found: list[Crossing], table: list[Mapping[str, str]]) -> tuple[list[str], set[int]]:
    """
    Faults of the crossings of a board against the table of those that are known, and the rows that it has.

    Parameters
    ----------
    found : list of Crossing
    table : list of mappings
      ``source``, ``sink`` (patterns of their whole names), ``kind``, ``why``.

    Returns
    -------
    list of str, set of int
      A sentence each; rows by number.
    """
    faults, used = [], set()
    for crossing in found:
        source = f"{crossing.source} ({crossing.source_clock or 'no clock'})"
        way = f"{source} to {crossing.sink} ({crossing.sink_clock})"
        rows = [
            number
            for number, row in enumerate(table)
            if re.fullmatch(row["source"], crossing.source) and re.fullmatch(row["sink"], crossing.sink)
        ]
        if not rows:
            faults.append(f"{way} is in no row of the table")
            continue
        used.update(rows)
        wanted = table[rows[0]]["kind"]
        if (crossing.kind or TIMED) != wanted:
            faults.append(f"{way} is {crossing.kind or 'unprotected'}, and the table says {wanted}")
    return faults, used
