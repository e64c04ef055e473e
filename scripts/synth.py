#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Clock and area of the core on FPGAs: GHDL, Yosys and nextpnr, several seeds each."""

from __future__ import annotations

from collections.abc import Iterator

import click
from rich.console import Console
from rich.table import Table

from quadshade.cli.options import generic_option
from quadshade.contract.formats import Formats, parse_generics
from quadshade.engine.netlist import core_of
from quadshade.engine.sources import repository_root
from quadshade.errors import QuadshadeError
from quadshade.files.atomic import write_text
from quadshade.synthesis import find_board, find_device, implement
from quadshade.synthesis import table as resources
from quadshade.synthesis.flow import Placed
from scripts.one_line_errors import Failure, one_line_errors

seeds_option = click.option(
    "--seeds", default=5, show_default=True, type=click.IntRange(1, 99), help="Seeds of nextpnr, from 1."
)
console = Console(stderr=True)


def told(what: str):
    """A function that reports one run of nextpnr."""
    return lambda run: console.print(f"{what}, seed {run.seed}: {run.fmax_mhz:.1f} MHz", highlight=False)


@click.group(help=__doc__)
def main() -> None:
    pass


@main.command()
@click.option("--device", help="For example ecp5-25k-6.")
@click.option("--board", help="For example ulx3s-85f: the device in synth/boards.")
@seeds_option
@generic_option(board=False)
@one_line_errors("synth")
def run(device: str | None, board: str | None, seeds: int, generics: tuple[str, ...]) -> None:
    """Synthesise the core for one device or board; fails if the table has a higher clock for it."""
    root = repository_root()
    if (device is None) == (board is None):
        raise QuadshadeError("give a device or a board", "DEVICE=ecp5-25k-6 or BOARD=ulx3s-85f, for example")
    chosen = find_device(device) if device else find_board(board, root)
    settings = parse_generics(generics)
    top, _ = core_of(Formats().with_generics(settings))
    result = implement(settings, chosen, range(1, seeds + 1), top, progress=told(chosen.name))
    area, path = result.area, result.typical.path
    print(f"{chosen.name}: {result.fmax_mhz:.1f} MHz, median of {seeds} seeds")
    print(
        f"  LUT4 {area.lut4} (of these in {area.carry} carry cells: {area.carry_luts}), "
        f"flip-flops {area.ff}, block RAM {area.bram}, multipliers {area.dsp}"
    )
    print(f"  critical path: {path.source} to {path.sink}")
    print(f"  {path.logic_ns} ns logic in {path.levels} levels, {path.routing_ns} ns routing")
    row = resources.find_row(resources.read_table(root), chosen.name, settings)
    if row and result.fmax_mhz < row["floor_mhz"]:
        raise Failure(f"{result.fmax_mhz:.1f} MHz; the floor of {row['name']!r} is {row['floor_mhz']} MHz")


def measure_all(table: dict, seeds: int) -> Iterator[dict]:
    """Every row of the table, measured afresh, one after another."""
    root = repository_root()
    for row in table["rows"]:

        def report(what: str, placed: Placed, row: dict = row) -> None:
            told(f"{row['name']}, {row['device']}, {what}")(placed)

        yield resources.measure_row(row, range(1, seeds + 1), root, report)


def show(rows: list[dict]) -> None:
    """Print rows with what limits each."""
    header = ("configuration", "device", "LUT4", "FF", "MHz", "lone", "ratio", "critical path")
    shown = Table(*header)
    for row in rows:
        path = row["critical_path"]
        shown.add_row(
            row["name"],
            row["device"],
            str(row["area"]["lut4"]),
            str(row["area"]["ff"]),
            f"{row['fmax_mhz']:.1f}",
            f"{row['lone_mhz']:.1f}",
            f"{row['ratio']:.3f}",
            f"{path['source']} to {path['sink']}: {path['logic_ns']} ns logic, "
            f"{path['routing_ns']} ns routing",
        )
    printer = Console()
    printer.width = max(printer.width, 150)
    printer.print(shown)


@main.command()
@seeds_option
@one_line_errors("synth")
def limits(seeds: int) -> None:
    """Measure every row of the table, the core beside a lone accumulator, and write the table."""
    root = repository_root()
    table = resources.read_table(root)
    if seeds != table["seeds"]:
        raise QuadshadeError(
            f"the table is of {table['seeds']} seeds, not {seeds}", "`make synth` takes any number"
        )
    rows = list(table["rows"])
    measured, failures = [], []
    # Written row by row: a run of an hour that is interrupted keeps what it has measured.
    for index, row in enumerate(measure_all(table, seeds)):
        measured.append(row)
        too_slow = resources.timing_failures(row)
        failures += too_slow
        if not too_slow:
            rows[index] = row
            fresh = {"seeds": seeds, "tools": resources.tools(rows), "rows": rows}
            write_text(resources.table_path(root), resources.dumps(fresh))
    show(measured)
    if failures:
        raise Failure("; ".join(failures))


@main.command()
@one_line_errors("synth")
def check() -> None:
    """Measure every row again and compare it with the table: the same cells, no clock under its floor."""
    table = resources.read_table(repository_root())
    rows = list(measure_all(table, table["seeds"]))
    show(rows)
    pairs = zip(table["rows"], rows, strict=True)
    found = [line for row, fresh in pairs for line in resources.differences(row, fresh)]
    if found:
        raise Failure("; ".join(found))


if __name__ == "__main__":
    main()
