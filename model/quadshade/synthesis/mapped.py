# SPDX-License-Identifier: Apache-2.0
"""Netlists to simulate: GHDL's, as it is or with unknown registers, or a family's cells with models."""

from __future__ import annotations

import inspect
import re
from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path

from quadshade.engine.build_cache import build_key, build_once
from quadshade.engine.netlist import write_netlist
from quadshade.engine.sources import repository_root
from quadshade.engine.tool_runner import package_version
from quadshade.engine.unknown_registers import without_initial_values
from quadshade.errors import QuadshadeError
from quadshade.synthesis import block_registers
from quadshade.synthesis.cells import with_cells
from quadshade.synthesis.families import Device, families, find_family
from quadshade.synthesis.flow import YOSYS, run_yosys, write_mapped
from quadshade.synthesis.mapping import mapping_commands

GENERIC = "ghdl"
UNKNOWN = "unknown"
"""GHDL's, with every register unknown at power-up."""

KINDS = (GENERIC, UNKNOWN, *families())


def cell_models(family: str) -> str:
    """
    Yosys' Verilog models of a family's cells, in one text that Icarus 11 reads without options.

    Raises
    ------
    QuadshadeError
      pyosys is not installed.
    """
    package_version(YOSYS)
    spec = find_spec(YOSYS)
    assert spec is not None and spec.submodule_search_locations is not None
    (package,) = spec.submodule_search_locations
    folder = Path(package) / "share" / find_family(family).share
    text = (folder / "cells_sim.v").read_text()
    # Default values of ports, and cells under older names: Icarus does not take either.
    defines = "`define NO_ICE40_DEFAULT_ASSIGNMENTS 1\n`define NO_INCLUDES 1\n"
    text = re.sub(
        r'`include "(common_sim|ccu2c_sim)\.vh"', lambda at: (folder / f"{at[1]}.vh").read_text(), text
    )
    return defines + "".join(line for line in text.splitlines(keepends=True) if "$error(" not in line)


def simulation_models(family: str, root: Path) -> str:
    """
    Models of all of a family's cells: Yosys' own, and those of ``synth/models`` for what it has none of.

    Raises
    ------
    QuadshadeError
      pyosys is not installed.
    """
    text = cell_models(family)
    for path in sorted((root / "synth" / "models" / family).glob("*.v")):
        black_box = rf"^\(\* blackbox \*\)\s*module {path.stem}\b.*?^endmodule$"
        text = re.sub(black_box, "", text, flags=re.DOTALL | re.MULTILINE) + path.read_text()
    return text


def write_simulated(
    commands: Sequence[str], folder: Path, unit: str, device: Device, root: Path
) -> list[Path]:
    """
    Map a design as for nextpnr, and write it as Verilog with the models of its cells.

    Parameters
    ----------
    commands : sequence of str
      That read and map it: :func:`quadshade.synthesis.mapping.mapping_commands`.
    folder : Path
      With what they read; the files are written there.
    unit : str
      Its module.
    device : Device
    root : Path
      Checkout of Quadshade.

    Returns
    -------
    list of Path
      Netlist and models.

    Raises
    ------
    QuadshadeError
      Yosys fails.
    """
    write_mapped(commands, folder / "mapped.json", unit, device)
    run_yosys(["read_json mapped.json", "write_verilog -noattr mapped.v"], folder)
    (folder / "cells.v").write_text(simulation_models(device.family, root))
    return [folder / "mapped.v", folder / "cells.v"]


def netlist_files(kind: str, unit: str, generics: Mapping[str, int]) -> list[Path]:
    """
    Verilog that stands for an entity in a simulation.

    Parameters
    ----------
    kind : str
      One of ``KINDS``.
    unit : str
      Entity of the RTL.
    generics : mapping of str to int

    Returns
    -------
    list of Path

    Raises
    ------
    QuadshadeError
      Unknown kind, a missing tool, or one that fails.
    """
    if kind not in KINDS:
        raise QuadshadeError(f"there is no netlist {kind!r}", f"the netlists are {', '.join(KINDS)}")
    root = repository_root()
    netlist = write_netlist(generics, unit, root=root)
    if kind == GENERIC:
        return [netlist]
    if kind == UNKNOWN:
        stripped = without_initial_values(netlist.read_text())

        def write(folder: Path) -> None:
            (folder / f"{unit}.v").write_text(stripped)

        return [build_once(root / "build" / "unknown", build_key(stripped), write) / f"{unit}.v"]
    family = find_family(kind)
    device = family.devices[family.simulated]
    verilog = with_cells(netlist.read_text(), kind, root)
    commands = [f"read_verilog {unit}.v", *mapping_commands(device, unit)]

    def make(folder: Path) -> None:
        (folder / f"{unit}.v").write_text(verilog)
        write_simulated(commands, folder, unit, device, root)

    absorbing = inspect.getsource(block_registers)
    models = simulation_models(kind, root)
    key = build_key(verilog, *commands, models, absorbing, package_version(YOSYS))
    folder = build_once(root / "build" / "mapped", key, make)
    return [folder / "mapped.v", folder / "cells.v"]
