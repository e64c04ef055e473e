#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Synthesise the core, or another entity, into one checked Verilog netlist, and print where it is."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from quadshade.cli.options import generic_option
from quadshade.contract.formats import parse_generics
from quadshade.engine.netlist import TOP, write_netlist
from quadshade.errors import QuadshadeError
from quadshade.files.atomic import write_text

PATH = click.Path(dir_okay=False, path_type=Path)


@click.command(help=__doc__)
@click.option("--top", default=TOP, show_default=True, help="Entity.")
@click.option("--file", "files", type=PATH, multiple=True, help="VHDL file to add to the RTL (repeatable).")
@generic_option
@click.option("-o", "--output", type=PATH, help="Copy the netlist to this file and print its name instead.")
def main(top: str, files: tuple[Path, ...], generics: tuple[str, ...], output: Path | None) -> None:
    try:
        netlist = write_netlist(parse_generics(generics), top, [path.resolve() for path in files])
        if output is not None:
            output.parent.mkdir(parents=True, exist_ok=True)
            write_text(output, netlist.read_text())
    except (QuadshadeError, OSError) as error:
        click.echo(f"netlist: error: {error}", err=True)
        sys.exit(2)
    click.echo(output or netlist)


if __name__ == "__main__":
    main()
