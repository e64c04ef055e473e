#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""
Area, block RAM and clock of the units behind the pixel stream, by place-and-route.

Writes docs/reports/screen.md and .json.
"""

from __future__ import annotations

from pathlib import Path

import click

from quadshade.files.markdown import markdown_table
from quadshade.synthesis import find_device, implement
from scripts.experiments.report_writer import LICENCE, REPORTS, output_option, write_report
from scripts.one_line_errors import one_line_errors

REPORT = REPORTS / "screen.md"
LARGE = {"width": 320, "height": 240}
SMALL = {"width": 160, "height": 120}
DOUBLE = {"buffers": 2, "colour_bits": 4}

CASES: list[tuple[str, str, dict[str, int]]] = [
    ("depth_test", "ecp5-85k-6", LARGE),
    ("framebuffer", "ecp5-85k-6", LARGE),
    ("framebuffer", "ecp5-85k-6", LARGE | DOUBLE),
    ("read_out", "ecp5-85k-6", LARGE),
    ("edge_map", "ecp5-85k-6", {"max_width": 320}),
    ("scan_out", "ecp5-85k-6", {"width": 320}),
    ("pixel_packer", "ecp5-85k-6", {}),
    ("sdram_controller", "ecp5-85k-6", {}),
    ("sdram_depth_test", "ecp5-25k-6", {}),
    ("depth_test", "ecp5-25k-6", SMALL),
    ("framebuffer", "ecp5-25k-6", SMALL),
    ("framebuffer", "ecp5-25k-6", SMALL | DOUBLE),
    ("framebuffer", "ecp5-25k-6", SMALL | DOUBLE | {"colour_bits": 6}),
    ("framebuffer", "ice40-hx8k", {"width": 96, "height": 64, "value_bits": 8}),
    ("depth_test", "ice40-hx8k", {"width": 64, "height": 48, "value_bits": 8, "depth_bits": 15}),
]
"""Unit, device, generics that are not defaults."""


def measure(unit: str, device: str, generics: dict[str, int], seeds: int) -> dict:
    """One row: what the unit takes, and the median of its clock; without a seed, it is not placed."""
    result = implement(generics, find_device(device), range(1, seeds + 1), unit)
    area = result.area
    return {
        "unit": unit,
        "device": device,
        "generics": generics,
        "lut4": area.lut4,
        "ff": area.ff,
        "bram": area.bram,
        "dsp": area.dsp,
        "fmax_mhz": round(result.fmax_mhz, 1) if seeds else None,
        "critical_path": f"{result.typical.path.source} to {result.typical.path.sink}" if seeds else None,
    }


def report(results: dict) -> str:
    """The report's text, from nothing but the numbers of the JSON file."""
    seeds = results["seeds"]
    placed = f"then nextpnr, median of {seeds} seed{'s' * (seeds > 1)}" if seeds else "not placed"
    header = ["unit", "device", "generics", "LUT4", "FF", "block RAM", "multipliers"]
    header += ["MHz", "limited by"] * bool(seeds)
    columns = ["lut4", "ff", "bram", "dsp"] + ["fmax_mhz", "critical_path"] * bool(seeds)
    rows = []
    for row in results["rows"]:
        generics = " ".join(f"{name}={value}" for name, value in row["generics"].items())
        rows.append((row["unit"], row["device"], generics, *(row[name] for name in columns)))
    return f"""\
{LICENCE}
# The units behind the pixel stream

Written by `make screen SEEDS={seeds}`: Yosys, {placed}. Generics that are not named have their
defaults; a carry cell of ECP5 counts as two LUT4. [What the units do](../reference/screen.md).

{markdown_table(header, rows)}
"""


@click.command(help=__doc__)
@click.option(
    "--seeds", type=click.IntRange(0), default=1, show_default=True, help="Runs of nextpnr; 0: none."
)
@output_option(REPORT)
@one_line_errors(REPORT.stem)
def main(seeds: int, output: Path) -> None:
    rows = []
    for unit, device, generics in CASES:
        rows.append(measure(unit, device, generics, seeds))
        click.echo(f"{unit} {device} {generics}: {rows[-1]}")
    results = {"seeds": seeds, "rows": rows}
    write_report(output, report(results), results)


if __name__ == "__main__":
    main()
