#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Synthesise the core, or another entity, into one checked Verilog netlist, and print where it is."""

from __future__ import annotations

from pathlib import Path

import click

from quadshade.cli.options import generic_option
from quadshade.contract.formats import parse_generics
from quadshade.engine.netlist import TOP, write_netlist
from quadshade.files.atomic import write_text
from scripts.one_line_errors import one_line_errors

PATH = click.Path(dir_okay=False, path_type=Path)


@click.command(help=__doc__)
@click.option("--top", default=TOP, show_default=True, help="Entity.")
@click.option("--file", "files", type=PATH, multiple=True, help="VHDL file to add to the RTL (repeatable).")
@click.option("--library", default="work", show_default=True, help="That of the RTL; a --file is in work.")
@generic_option(board=False)
@click.option("-o", "--output", type=PATH, help="Copy the netlist to this file and print its name instead.")
@one_line_errors("netlist")
def main(
    top: str, files: tuple[Path, ...], library: str, generics: tuple[str, ...], output: Path | None
) -> None:
    more = [path.resolve() for path in files]
    netlist = write_netlist(parse_generics(generics), top, more, library=library)
    if output is not None:
        output.parent.mkdir(parents=True, exist_ok=True)
        write_text(output, netlist.read_text())
    click.echo(output or netlist)


if __name__ == "__main__":
    main()
