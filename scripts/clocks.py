# SPDX-License-Identifier: Apache-2.0
"""Clock crossings of the boards' tops, found in their netlists, against the table synth/crossings.toml."""

from __future__ import annotations

import shutil
import tempfile
import tomllib
from collections.abc import Sequence
from pathlib import Path

import click

from quadshade.engine.netlist import write_netlist
from quadshade.engine.sources import repository_root
from quadshade.engine.tool_runner import announce, package_version
from quadshade.files.atomic import write_text
from quadshade.files.markdown import markdown_table
from quadshade.synthesis.bitstream import ENTITY, TOP, BoardFile, read_board
from quadshade.synthesis.crossings import TIMED, Crossing, compare, read_clocks
from quadshade.synthesis.families import find_family
from quadshade.synthesis.flow import YOSYS, run_yosys
from scripts.one_line_errors import Failure, one_line_errors

FLATTENED = (
    f"hierarchy -check -top {TOP}",
    "proc",
    "flatten",
    "opt_clean",
    "memory_collect",
    "opt_clean",
    "delete t:$scopeinfo",
    "blackbox =A:whitebox",
    "write_json flat.json",
)

HEAD = """\
<!-- SPDX-License-Identifier: Apache-2.0 -->
# Clock crossings

Written by `make clocks`, which fails where a crossing is in no row of `synth/crossings.toml` or is not of
the kind that the row says, and where a row has no crossing any more. A synchroniser is two registers in a
row without enable or logic between them, and nothing looks at the first one but the second. A held value is
chosen by the sink's own clock alone. [What it means](../explanation/clocks.md).

"""


def crossings_of(sources: Sequence[Path], family: str) -> list[Crossing]:
    """
    The crossings of a top.

    Parameters
    ----------
    sources : sequence of Path
      Verilog of the top and of all below it.
    family : str
      Whose cells it holds, of ``synth/families``.

    Raises
    ------
    QuadshadeError
      Yosys does not read it, or it has a cell whose clock is not known.
    """
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        for source in sources:
            shutil.copyfile(source, folder / source.name)
        names = " ".join(source.name for source in sources)
        library = f"read_verilog -lib {' '.join(find_family(family).declared)}"
        run_yosys([library, f"read_verilog {names}", *FLATTENED], folder)
        return read_clocks(folder / "flat.json", TOP).crossings()


def crossings_of_board(board: BoardFile, root: Path) -> list[Crossing]:
    """The crossings of a board, from the netlist that its bitstream is built of."""
    return crossings_of([write_netlist(board.generics, ENTITY, root=root), *board.sources], board.family)


def read_table(root: Path) -> list[dict[str, str]]:
    """The crossings that are known."""
    return tomllib.loads((root / "synth" / "crossings.toml").read_text())["crossing"]


def page(found: dict[str, list[Crossing]], table: Sequence[dict[str, str]]) -> str:
    """The report."""
    boards: dict[Crossing, list[str]] = {}
    for name, crossings in found.items():
        for crossing in crossings:
            boards.setdefault(crossing, []).append(name)
    rows = [
        (
            f"`{crossing.source}`",
            crossing.source_clock or "none",
            f"`{crossing.sink}`",
            crossing.sink_clock,
            crossing.kind or TIMED,
            next(row["why"] for row in table if not compare([crossing], [row])[0]),
            ", ".join(names),
        )
        for crossing, names in sorted(boards.items(), key=lambda item: (item[0].sink, item[0].source))
    ]
    header = ("from", "clock", "to", "clock there", "kind", "why that is enough", "boards")
    counts = ", ".join(f"{name} {len(crossings)}" for name, crossings in found.items())
    made = f"Crossings by board: {counts}. Netlists by GHDL and {package_version(YOSYS)}."
    return f"{HEAD}{markdown_table(header, rows)}\n\n{made}\n"


@click.command(help=__doc__)
@click.option("--board", "names", multiple=True, help="Only this one, and write no report.")
@one_line_errors("clocks")
def main(names: tuple[str, ...]) -> None:
    root = repository_root()
    table = read_table(root)
    every = [
        path.stem
        for path in sorted((root / "synth" / "boards").glob("*.toml"))
        if "top" in tomllib.loads(path.read_text())
    ]
    found, faults, used = {}, [], set()
    for name in names or every:
        announce(f"{name}: netlist and its clocks")
        found[name] = crossings_of_board(read_board(name, root), root)
        more, rows = compare(found[name], table)
        faults += [f"{name}: {fault}" for fault in more]
        used |= rows
    if not names:
        faults += [
            f"no board has {row['source']} to {row['sink']}" for n, row in enumerate(table) if n not in used
        ]
    if faults:
        raise Failure("\n".join(faults))
    if not names:
        report = root / "docs" / "reports" / "clocks.md"
        write_text(report, page(found, table))
        print(report.relative_to(root))


if __name__ == "__main__":
    main()
