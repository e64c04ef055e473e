# SPDX-License-Identifier: Apache-2.0
"""
``synth/resources.json``: what each configuration costs and how fast it is, beside the fabric's own limit.

A row is given by name, device, generics and floor; the rest is measured. ``scripts/readme.py`` writes the
tables of README and pages from it.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from quadshade.contract.formats import Formats
from quadshade.engine.netlist import core_of
from quadshade.engine.tool_runner import package_version
from quadshade.errors import QuadshadeError
from quadshade.synthesis.devices import find_device
from quadshade.synthesis.flow import YOSYS, Implementation, Placed, implement

LONE = "lone_accumulator"


def table_path(root: Path) -> Path:
    """The table's file in a checkout."""
    return root / "synth" / "resources.json"


def read_table(root: Path) -> dict[str, Any]:
    """
    The table.

    Raises
    ------
    QuadshadeError
      It is missing or no JSON.
    """
    path = table_path(root)
    try:
        return json.loads(path.read_text())
    except FileNotFoundError:
        raise QuadshadeError(f"there is no {path}") from None
    except json.JSONDecodeError as problem:
        raise QuadshadeError(f"{path} is no JSON: {problem}") from None


def dumps(table: Mapping[str, Any]) -> str:
    """The table as it stands in its file: what is measured of a row on a few lines."""
    rows = []
    for row in table["rows"]:
        fields = [f"   {json.dumps(key)}: {json.dumps(value)}" for key, value in row.items()]
        rows.append("  {\n" + ",\n".join(fields) + "\n  }")
    head = [f" {json.dumps(key)}: {json.dumps(table[key])}" for key in ("seeds", "tools")]
    return "{\n" + ",\n".join(head) + ',\n "rows": [\n' + ",\n".join(rows) + "\n ]\n}\n"


def find_row(table: Mapping[str, Any], device: str, generics: Mapping[str, int]) -> dict[str, Any] | None:
    """The row of a device and of generics that mean the same, or None."""
    wanted = Formats().with_generics(dict(generics))
    for row in table["rows"]:
        if row["device"] == device and Formats().with_generics(row["generics"]) == wanted:
            return row
    return None


def measure_lone(
    device: str,
    word_width: int,
    seeds: Sequence[int],
    root: Path,
    progress: Callable[[Placed], None] | None = None,
) -> Implementation:
    """The lone accumulator on a device, in the same harness and flow as the core."""
    source = root / "synth" / "harness" / f"{LONE}.vhd"
    return implement(
        {"word_width": word_width}, find_device(device), seeds, LONE, [source], progress=progress
    )


def measured(core: Implementation, lone: Implementation) -> dict[str, Any]:
    """The measured part of a row."""
    typical = core.typical

    def clocks(runs: Sequence[Placed]) -> list[float]:
        return [round(run.fmax_mhz, 1) for run in runs]

    return {
        "area": asdict(core.area),
        "fmax_mhz": round(core.fmax_mhz, 1),
        "runs_mhz": clocks(core.runs),
        "lone_mhz": round(lone.fmax_mhz, 1),
        "lone_runs_mhz": clocks(lone.runs),
        "ratio": round(core.fmax_mhz / lone.fmax_mhz, 3),
        "critical_path": asdict(typical.path),
    }


def measure_row(
    row: Mapping[str, Any],
    seeds: Sequence[int],
    root: Path,
    progress: Callable[[str, Placed], None] | None = None,
) -> dict[str, Any]:
    """
    A row, measured afresh: the core and the lone accumulator on the same device and seeds, in the same run.

    Parameters
    ----------
    row : mapping
      With ``name``, ``device``, ``generics`` and ``floor_mhz``.
    seeds : sequence of int
    root : Path
      Checkout of Quadshade.
    progress : function of a str and a Placed, optional
      Called after each run of nextpnr, with what was placed.

    Raises
    ------
    QuadshadeError
      A tool fails, or the configuration does not fit.
    """
    formats = Formats().with_generics(row["generics"])

    def report(what: str) -> Callable[[Placed], None] | None:
        return None if progress is None else lambda run: progress(what, run)

    core = implement(
        row["generics"], find_device(row["device"]), seeds, core_of(formats)[0], progress=report("core")
    )
    lone = measure_lone(row["device"], formats.word_width, seeds, root, report("lone accumulator"))
    given = {key: row[key] for key in ("name", "device", "generics", "floor_mhz")}
    return given | measured(core, lone)


def tools(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """Versions of the tools that made some rows."""
    packages = {YOSYS} | {find_device(row["device"]).place[0] for row in rows}
    return [package_version(package) for package in sorted(packages)]


def differences(row: Mapping[str, Any], fresh: Mapping[str, Any]) -> list[str]:
    """What is wrong with a fresh measurement of a row: other cells, or a clock under its floor."""
    found = [
        f"{row['name']} on {row['device']}: {kind} is {fresh['area'][kind]}, the table says {number}"
        for kind, number in row["area"].items()
        if fresh["area"][kind] != number
    ]
    return found + timing_failures(fresh)


def timing_failures(row: Mapping[str, Any]) -> list[str]:
    """A line if the row's clock is under its floor."""
    if row["fmax_mhz"] >= row["floor_mhz"]:
        return []
    return [
        f"{row['name']} on {row['device']}: {row['fmax_mhz']:.1f} MHz, the floor is {row['floor_mhz']} MHz"
    ]


def cells(table: Mapping[str, Any]) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """The table's header and rows, as text, for the pages."""
    header = (
        "configuration",
        "set-up stream",
        "device",
        "LUT4",
        "flip-flops",
        "block RAM",
        "multipliers",
        "MHz",
    )
    rows: list[tuple[str, ...]] = []
    for row in table["rows"]:
        area = row["area"]
        rows.append(
            (
                row["name"],
                f"{Formats().with_generics(row['generics']).stream_width} bits",
                row["device"],
                *(str(area[kind]) for kind in ("lut4", "ff", "bram", "dsp")),
                f"{row['fmax_mhz']:.0f}",
                f"{row['lone_mhz']:.0f}",
                f"{row['ratio']:.2f}",
            )
        )
    return (*header, "lone accumulator", "ratio"), rows
