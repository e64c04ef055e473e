# SPDX-License-Identifier: Apache-2.0
"""What Yosys and nextpnr report, as numbers: area, clock, and the path that limits it."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from quadshade.errors import QuadshadeError
from quadshade.synthesis.families import Counted

USED = re.compile(r"^Info:\s+(\w+):\s+(\d+)/\s*(\d+)\s+\d+%", re.MULTILINE)
"""nextpnr's log: a kind of cell, how many are used, how many there are."""


@dataclass(frozen=True)
class Area:
    """
    Cells of a netlist, without a harness.

    Attributes
    ----------
    lut4 : int
      LUTs of four inputs, a carry cell of ECP5 counted as two. On iCE40 a carry lies beside a LUT.
    carry : int
      Carry cells (ECP5: two bits each, iCE40: one).
    carry_luts : int
      LUTs that the carry cells are.
    ff, bram, dsp : int
      Flip-flops, block RAMs, multipliers.
    """

    lut4: int
    carry: int
    carry_luts: int
    ff: int
    bram: int
    dsp: int


@dataclass(frozen=True)
class CriticalPath:
    """
    A path from register to register.

    Attributes
    ----------
    source, sink : str
      Registers, by the name of the signal that they drive.
    logic_ns, routing_ns : float
      Delay in cells (clock to output, set-up time included) and on wires.
    levels : int
      LUTs and multiplexers on the way; a carry chain is one.
    """

    source: str
    sink: str
    logic_ns: float
    routing_ns: float
    levels: int


def area_from_stat(stat: Mapping[str, Any], counted: Counted) -> Area:
    """
    Area from Yosys' ``stat -json`` of a mapped, flat design.

    Parameters
    ----------
    stat : mapping
    counted : Counted
      Of the device's family.

    Raises
    ------
    QuadshadeError
      The report holds no cells.
    """
    cells = stat.get("design", {}).get("num_cells_by_type")
    if not cells:
        raise QuadshadeError("Yosys reports no cells", "look at the netlist: is everything optimised away?")

    def count(kind: str) -> int:
        return sum(number for name, number in cells.items() if re.fullmatch(kind, name))

    return Area(
        lut4=sum(number * counted.luts.get(name, 0) for name, number in cells.items()),
        carry=sum(cells.get(name, 0) for name in counted.carries),
        carry_luts=sum(cells.get(name, 0) * counted.luts.get(name, 0) for name in counted.carries),
        ff=count(counted.flip_flops),
        bram=count(counted.block_rams),
        dsp=count(counted.multipliers),
    )


def fmax_mhz(report: Mapping[str, Any]) -> float:
    """
    Clock that nextpnr's report says a design of one clock reaches.

    Raises
    ------
    QuadshadeError
      The report has not exactly one clock.
    """
    clocks = report.get("fmax", {})
    if len(clocks) != 1:
        raise QuadshadeError(f"nextpnr reports {len(clocks)} clocks, one expected")
    return float(next(iter(clocks.values()))["achieved"])


def signal_names(cells: Mapping[str, Any]) -> dict[int, str]:
    """
    The most readable name of each bit of a mapped module.

    GHDL and Yosys number what they make; the VHDL's own names lie beside these as aliases.

    Parameters
    ----------
    cells : mapping
      A module of Yosys' JSON.
    """

    def effort(name: str) -> tuple[int, int]:
        made = len(re.findall(r"(?:\bn\d+_[oq]\b|TRELLIS|SB_|LUT4|CCU2C|PFUMX|L6MUX|\$)", name))
        return made, len(name)

    best: dict[int, str] = {}
    for name, net in cells["netnames"].items():
        for index, bit in enumerate(net["bits"]):
            if isinstance(bit, int):
                label = f"{name}[{index}]" if len(net["bits"]) > 1 else name
                if bit not in best or effort(label) < effort(best[bit]):
                    best[bit] = label
    return best


def register_name(cell: str, cells: Mapping[str, Any], names: Mapping[int, str]) -> str:
    """Name of the signal that a register drives; the cell's own name if it is no register of the netlist."""
    # On iCE40 a LUT and the register behind it are one cell, which nextpnr names after one of them.
    found = cells["cells"].get(cell) or cells["cells"].get(re.sub(r"_(?:DFF)?LC$", "", cell), {})
    wires = found.get("connections", {})
    if "O" in wires:
        behind = (other["connections"] for other in cells["cells"].values() if "DFF" in other["type"])
        wires = next((other for other in behind if other["D"] == wires["O"]), {})
    for bit in wires.get("Q", []):
        return re.sub(r"^dut\.", "", names.get(bit, cell))
    return re.sub(r"^dut\.", "", cell)


def critical_path(report: Mapping[str, Any], cells: Mapping[str, Any]) -> CriticalPath:
    """
    The slowest path between registers in nextpnr's report.

    Parameters
    ----------
    report : mapping
      nextpnr's ``--report``.
    cells : mapping
      The module in Yosys' JSON that nextpnr read.

    Raises
    ------
    QuadshadeError
      The report has no such path.
    """
    for path in report.get("critical_paths", []):
        if path["from"].startswith("posedge") and path["to"].startswith("posedge"):
            steps = path["path"]
            break
    else:
        raise QuadshadeError("nextpnr reports no path from register to register")
    names = signal_names(cells)
    routing = sum(step["delay"] for step in steps if step["type"] == "routing")
    logic = sum(step["delay"] for step in steps if step["type"] != "routing")
    # A wire without delay lies inside a slice: it belongs to the carry chain or the wide LUT before it.
    levels = sum(step["type"] == "routing" and step["delay"] > 0 for step in steps) - 1
    return CriticalPath(
        register_name(steps[0]["from"]["cell"], cells, names),
        register_name(steps[-1]["to"]["cell"], cells, names),
        round(logic, 2),
        round(routing, 2),
        levels,
    )


def fullest(log: str, cells: Sequence[str]) -> tuple[str, int, int] | None:
    """
    The kind of cell that fills a device most, how many are used, and how many it has; from nextpnr's log.

    Parameters
    ----------
    log : str
    cells : sequence of str
      Kinds that are looked at: not those which are taken as long as there are any, as global buffers.

    Returns
    -------
    (str, int, int) or None
      None where the log says nothing of them.
    """
    kinds = [
        (kind, int(used), int(there))
        for kind, used, there in USED.findall(log)
        if int(there) and kind in cells
    ]
    return max(kinds, key=lambda found: found[1] / found[2], default=None)
