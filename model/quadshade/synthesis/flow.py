# SPDX-License-Identifier: Apache-2.0
"""
From a netlist to clock and area: Yosys once, nextpnr once for each seed.

Area is counted on the netlist alone; the clock is that of the netlist in its harness (``harness.py``).
"""

from __future__ import annotations

import inspect
import json
import os
import re
import statistics
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from joblib import Parallel, delayed

from quadshade.engine.build_cache import build_key, build_once
from quadshade.engine.netlist import TOP, write_netlist
from quadshade.engine.sources import repository_root
from quadshade.engine.tool_runner import package_version, run_tool
from quadshade.errors import QuadshadeError
from quadshade.synthesis import block_registers
from quadshade.synthesis.block_registers import absorb_in_file
from quadshade.synthesis.cells import with_cells
from quadshade.synthesis.families import Device, filled
from quadshade.synthesis.harness import HARNESS, module_ports, write_harness
from quadshade.synthesis.mapping import CHECKED, mapping_commands
from quadshade.synthesis.tool_reports import (
    Area,
    CriticalPath,
    area_from_stat,
    critical_path,
    fmax_mhz,
    fullest,
)

YOSYS = "pyosys"
"""Native Yosys as a Python module; the WebAssembly one ends without a word while it maps the core."""

NO_PLACE = re.compile(r"BELs remaining|legal placement|expand region")

LESS_MEMORY = "give a smaller screen, colour_bits=6 or 4, buffers=1, with_edge_map=0 or with_depth=0"
LESS_LOGIC = "give fewer channels, shorter words, single_buffer=1, another seed or another device"
"""What makes a design smaller, by what is full."""

PINS = "harness.pins"
"""The pins of a design that is measured alone."""

RUN_SCRIPT = "import sys; from pyosys import libyosys as y; y.run_pass('script ' + sys.argv[1], y.Design())"


@dataclass(frozen=True)
class Placed:
    """
    One run of nextpnr.

    Attributes
    ----------
    seed : int
    fmax_mhz : float
    path : CriticalPath
      The register-to-register path that limits the clock.
    """

    seed: int
    fmax_mhz: float
    path: CriticalPath


@dataclass(frozen=True)
class Implementation:
    """
    A netlist on a device.

    Attributes
    ----------
    device : str
    area : Area
      Of the netlist alone.
    runs : tuple of Placed
      By seed.
    """

    device: str
    area: Area
    runs: tuple[Placed, ...]

    @property
    def fmax_mhz(self) -> float:
        """Median over the seeds."""
        return statistics.median(run.fmax_mhz for run in self.runs)

    @property
    def typical(self) -> Placed:
        """The run at the median, the slower one of the middle two."""
        return sorted(self.runs, key=lambda run: run.fmax_mhz)[(len(self.runs) - 1) // 2]


def run_nextpnr(command: Sequence[str], folder: Path, device: Device) -> None:
    """
    Run nextpnr, with its log in ``nextpnr.log`` and its report in ``report.json``.

    Raises
    ------
    QuadshadeError
      It fails; if it finds no place for a cell, with what fills the device and what may be left out.
    """
    try:
        run_tool([*command, "-q", "--log", "nextpnr.log", "--report", "report.json"], folder)
    except QuadshadeError as problem:
        log = folder / "nextpnr.log"
        kinds = device.described.area
        full = None
        if log.is_file() and NO_PLACE.search(str(problem)):
            full = fullest(log.read_text(), tuple(kinds.values()))
        if full is None:
            raise
        memory = full[0] in (kinds.get("block RAM"), kinds.get("SPRAM"))
        raise QuadshadeError(
            f"nextpnr finds no place for every cell on {device.name}: {full[1]} of {full[2]} {full[0]}",
            LESS_MEMORY if memory else LESS_LOGIC,
        ) from None


def run_yosys(commands: Sequence[str], folder: Path) -> None:
    """
    Run a list of Yosys commands, in a process of its own; they stay there as ``script.ys``.

    Raises
    ------
    QuadshadeError
      pyosys is not installed, or a command fails.
    """
    package_version(YOSYS)
    (folder / "script.ys").write_text("\n".join(commands) + "\n")
    run_tool([sys.executable, "-c", RUN_SCRIPT, "script.ys"], folder)


def write_mapped(commands: Sequence[str], path: Path, top: str, device: Device) -> int:
    """
    Run Yosys on a design and write what nextpnr reads, with registers in the block RAM of some families.

    Parameters
    ----------
    commands : sequence of str
      That read and map it: :func:`quadshade.synthesis.mapping.mapping_commands`.
    path : Path
      Of the JSON; Yosys works in its folder.
    top : str
    device : Device

    Returns
    -------
    int
      Flip-flops that went into block RAM.

    Raises
    ------
    QuadshadeError
      Yosys fails.
    """
    run_yosys([*commands, f"write_json {path.name}"], path.parent)
    return absorb_in_file(path, top) if device.described.absorbs_registers else 0


def map_netlist(netlist: Path, top: str, device: Device, root: Path) -> Path:
    """
    A netlist mapped to a device's cells, alone and in its harness.

    Parameters
    ----------
    netlist : Path
      From :func:`quadshade.engine.netlist.write_netlist`.
    top : str
      Its module.
    device : Device
    root : Path
      Checkout of Quadshade.

    Returns
    -------
    Path
      Folder with ``stat.json`` (the netlist alone) and ``harness.json`` (for nextpnr).

    Raises
    ------
    QuadshadeError
      The netlist has a latch or is otherwise not sound, or Yosys fails.
    """
    verilog = with_cells(netlist.read_text(), device.family, root)
    harness = write_harness(module_ports(verilog, top), top)
    parts = "".join(path.read_text() for path in sorted((root / "synth" / "harness").glob("*.v")))
    alone = [
        f"read_verilog {netlist.name}",
        *device.described.library,
        f"hierarchy -check -top {top}",
        *CHECKED,
    ]
    alone += [*mapping_commands(device, top), f"tee -q -o stat.json stat -json -top {top}"]
    whole = [f"read_verilog {netlist.name} parts.v harness.v", *mapping_commands(device, HARNESS)]

    def make(folder: Path) -> None:
        (folder / netlist.name).write_text(verilog)
        (folder / "parts.v").write_text(parts)
        (folder / "harness.v").write_text(harness)
        run_yosys(alone, folder)
        write_mapped(whole, folder / "harness.json", HARNESS, device)

    absorbing = inspect.getsource(block_registers)
    key = build_key(verilog, harness, parts, *alone, *whole, absorbing, package_version(YOSYS))
    return build_once(root / "build" / "synth" / "mapped", key, make)


def place(mapped: Path, device: Device, seed: int, root: Path) -> Placed:
    """
    Place and route a mapped netlist once.

    Parameters
    ----------
    mapped : Path
      From :func:`map_netlist`.
    device : Device
    seed : int
    root : Path
      Checkout of Quadshade.

    Raises
    ------
    QuadshadeError
      The netlist does not fit, or nextpnr fails otherwise.
    """
    command = [
        *device.place,
        *filled(device.described.unconstrained, pins=PINS),
        "--seed",
        str(seed),
        "--freq",
        str(device.aim_mhz),
        "--timing-allow-fail",
    ]

    def make(folder: Path) -> None:
        (folder / PINS).write_text(device.described.harness)
        # By a relative path: the WebAssembly nextpnr has a /tmp of its own.
        harness = os.path.relpath(mapped / "harness.json", folder)
        run_nextpnr([*command, "--json", harness], folder, device)

    key = build_key(mapped.name, device.described.harness, *command, package_version(command[0]))
    folder = build_once(root / "build" / "synth" / "placed", key, make)
    report = json.loads((folder / "report.json").read_text())
    cells = json.loads((mapped / "harness.json").read_text())["modules"][HARNESS]
    return Placed(seed, fmax_mhz(report), critical_path(report, cells))


def implement(
    generics: Mapping[str, int | str],
    device: Device,
    seeds: Sequence[int],
    top: str = TOP,
    more: Sequence[Path] = (),
    jobs: int | None = None,
    progress: Callable[[Placed], None] | None = None,
) -> Implementation:
    """
    Synthesise, place and route an entity.

    Parameters
    ----------
    generics : mapping of str to int or str
      Generics of the entity; what is left out has its default.
    device : Device
    seeds : sequence of int
      Of nextpnr; each is one run.
    top : str
      The entity, from ``rtl/files.f`` or ``more``.
    more : sequence of Path
      VHDL files to analyse after those of ``rtl/files.f``.
    jobs : int, optional
      Runs at the same time; the environment's ``JOBS``, or 2, if left out.
    progress : function of a Placed, optional
      Called after each run, in the order in which they end.

    Raises
    ------
    QuadshadeError
      A tool is missing or fails, or the entity does not fit on the device.
    """
    root = repository_root()
    mapped = map_netlist(write_netlist(generics, top, more), top, device, root)
    area = area_from_stat(json.loads((mapped / "stat.json").read_text()), device.described.counted)
    workers = Parallel(
        n_jobs=jobs or int(os.environ.get("JOBS") or 2), return_as="generator_unordered", prefer="threads"
    )
    runs = []
    for run in workers(delayed(place)(mapped, device, seed, root) for seed in seeds):
        runs.append(run)
        if progress is not None:
            progress(run)
    return Implementation(device.name, area, tuple(sorted(runs, key=lambda run: run.seed)))


def as_dict(result: Implementation) -> dict[str, Any]:
    """An implementation as what JSON can hold."""
    return asdict(result) | {"fmax_mhz": result.fmax_mhz}
