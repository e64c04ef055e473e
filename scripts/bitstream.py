#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Bitstreams of the boards: build one, load one, and the page of what was built."""

from __future__ import annotations

import json
import sys
import tomllib
from pathlib import Path

import click
from rich.console import Console

from quadshade.board.settings import board_settings
from quadshade.contract.releases import definition_hash
from quadshade.engine.sources import repository_root
from quadshade.engine.tool_runner import announce, run_tool
from quadshade.errors import QuadshadeError
from quadshade.files.atomic import write_text
from quadshade.files.markdown import markdown_table
from quadshade.synthesis.bitstream import (
    BoardFile,
    Built,
    build,
    check_pins,
    missing_packages,
    program,
    read_board,
    tools_of,
)
from scripts.one_line_errors import Failure, one_line_errors

console = Console(stderr=True)
HEAD = """\
<!-- SPDX-License-Identifier: Apache-2.0 -->
# Bitstreams

Written by `make bitstream BOARD=...`, which builds through GHDL, Yosys and nextpnr and fails where a clock is
missed. On iCE40 a LUT and the flip-flop behind it are one logic cell; on Gowin a carry cell takes the place
of a LUT. The definition is the hash of formats, packet layout and protocol that HELLO answers
([protocol](../reference/protocol.md)): of another one a board has to be built anew.

"""


def board_of(name: str | None) -> BoardFile:
    """
    The board of the command line.

    Raises
    ------
    QuadshadeError
      None is given, its file is wrong, or it has generics that no board can have.
    """
    root = repository_root()
    if not name:
        names = ", ".join(sorted(path.stem for path in (root / "synth" / "boards").glob("*.toml")))
        raise QuadshadeError("no board is given", f"give BOARD=...: {names}")
    board = read_board(name, root)
    # Generics are what a simulated board's are checked for, before GHDL is asked.
    board_settings(None, None, board.generics)
    return board


def install(board: BoardFile, root: Path) -> None:
    """
    Install what places and routes a board where `make setup` has left it out for its size.

    Raises
    ------
    QuadshadeError
      pip fails.
    """
    extra = board.device.described.extra
    if not extra or not missing_packages(board):
        return
    announce(f"installing {', '.join(board.device.described.packages)} for {board.name}")
    pip = [sys.executable, "-m", "pip", "install", "-q", "--disable-pip-version-check"]
    run_tool([*pip, "--no-build-isolation", "-e", f".[{extra}]"], root)


def row_of(board: BoardFile, built: Built) -> dict:
    """What the report keeps of a build."""
    size = f"{board.generics['screen_width']} x {board.generics['screen_height']}"
    return {
        "device": board.device.name,
        "screen": size,
        "area": {name: list(pair) for name, pair in built.area.items()},
        "clocks": {name: [round(mhz, 1), least] for name, (mhz, least) in built.clocks.items()},
        "seed": built.seed,
        "definition": f"{definition_hash():08x}",
        "tools": tools_of(board),
    }


def page(rows: dict[str, dict]) -> str:
    """The report."""
    kinds = ("LUT4", "carry cells", "flip-flops", "block RAM", "SPRAM", "multipliers")
    header = ("board", "device", "screen", *kinds, "clocks, MHz reached / required", "seed", "definition")
    lines = []
    for name, row in sorted(rows.items()):
        cells = [" / ".join(map(str, row["area"][kind])) if kind in row["area"] else "" for kind in kinds]
        clocks = ", ".join(f"{clock} {mhz:.1f} / {least:g}" for clock, (mhz, least) in row["clocks"].items())
        lines.append(
            (name, row["device"], row["screen"], *cells, clocks, row["seed"], row.get("definition", "older"))
        )
    tools = sorted({tool for row in rows.values() for tool in row["tools"]})
    table = markdown_table(header, lines, right={*kinds, "seed"})
    return f"{HEAD}{table}\n\nMade with {', '.join(tools)}.\n"


@click.group(help=__doc__)
def main() -> None:
    pass


@main.command(name="build")
@click.option("--board", help="For example ulx3s-85f.")
@click.option("--seeds", default=5, show_default=True, type=click.IntRange(1, 99), help="Seeds to try.")
@one_line_errors("bitstream")
def build_command(board: str | None, seeds: int) -> None:
    """Build a bitstream, and enter it in the report."""
    root, chosen = repository_root(), board_of(board)
    check_pins(chosen)
    install(chosen, root)
    built = build(chosen, root, range(1, seeds + 1), lambda text: console.print(text, highlight=False))
    if built.too_slow:
        name, (mhz, least) = min(built.too_slow.items())
        raise Failure(
            f"{chosen.name}: clock {name} reaches {mhz:.1f} MHz of {least:g}, with the best of {seeds} seeds"
        )
    store = root / "docs" / "reports" / "bitstream.json"
    rows = json.loads(store.read_text()) if store.is_file() else {}
    rows[chosen.name] = row_of(chosen, built)
    # `make release` reads beside a bitstream which host it talks to.
    write_text(built.path.with_suffix(".json"), json.dumps(rows[chosen.name], indent=2) + "\n")
    write_text(store, json.dumps(rows, indent=2, sort_keys=True) + "\n")
    write_text(store.with_suffix(".md"), page(rows))
    print(built.path.relative_to(root))


@main.command(name="all")
@click.option("--seeds", default=5, show_default=True, type=click.IntRange(1, 99), help="Seeds to try.")
@click.pass_context
@one_line_errors("bitstream")
def all_command(context: click.Context, seeds: int) -> None:
    """Build the bitstream of every board that has a top: an hour or two."""
    for path in sorted((repository_root() / "synth" / "boards").glob("*.toml")):
        if "top" in tomllib.loads(path.read_text()):
            context.invoke(build_command, board=path.stem, seeds=seeds)


@main.command(name="program")
@click.option("--board", help="For example ulx3s-85f.")
@one_line_errors("bitstream")
def program_command(board: str | None) -> None:
    """Load a bitstream into a board."""
    print(" ".join(program(board_of(board), repository_root())))


if __name__ == "__main__":
    main()
