# SPDX-License-Identifier: Apache-2.0
"""
Write the archive of a release: VHDL in one order, netlists, benches, a FuseSoC file, built bitstreams.

Everything in it comes from the checkout, and two runs write the same bytes.
"""

from __future__ import annotations

import gzip
import hashlib
import io
import json
import re
import tarfile
import tomllib
from collections.abc import Collection, Sequence
from pathlib import Path

import click

import quadshade
from quadshade.contract.releases import definition_hash
from quadshade.engine.netlist import write_netlist
from quadshade.engine.sources import rtl_files
from quadshade.errors import QuadshadeError
from quadshade.files.atomic import write_bytes
from scripts.one_line_errors import one_line_errors

ROOT = Path(__file__).resolve().parents[2]
NETLISTS = ROOT / "synth" / "netlists.toml"
BITSTREAMS = ROOT / "build" / "bitstream"
BOARDS = ROOT / "synth" / "boards"
HOOK = ROOT / "synth" / "fusesoc" / "cells.py"
BENCH = ("core_tb.vhd", "core_tb.v", "triangles.json", "words.hex", "words.pixels.csv")

ABOUT = """\
# Quadshade {version}

Quadratic shading for small FPGAs. Format and protocol definition {definition:08x}.

| file | what it is |
| --- | --- |
| `rtl/files.f` | the VHDL-2008 files in the order in which they are compiled, into a library of their own |
| `quadshade.core` | the same for FuseSoC |
| `examples/design` | a bench in VHDL and one in Verilog, with words and expected pixels |
{rows}
| `CHANGES.md` | what has changed |
| `SHA256SUMS` | for `sha256sum --check` |

    ghdl -a --std=08 --work=quadshade $(grep -v '^#' rtl/files.f)
    ghdl -a --std=08 examples/design/core_tb.vhd
    ghdl -e --std=08 core_tb
    cp examples/design/words.* .
    ghdl -r --std=08 core_tb --ieee-asserts=disable

    cd examples/design && iverilog -o core core_tb.v ../../netlists/raster_core.v && vvp -n core
"""

NOT_BUILT = (
    "no bitstream of {names}; `make bitstream BOARD={first}` builds one, `make bitstreams` all, in hours"
)


def changes() -> str:
    """The changelog's newest section."""
    section = re.search(r"^## .*?(?=^## |\Z)", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE | re.DOTALL)
    if section is None:
        raise QuadshadeError("CHANGELOG.md has no section", "write one")
    return section[0].rstrip() + "\n"


def keep_lanes(verilog: bytes) -> bytes:
    """A netlist that says that the lanes are kept apart: merged, their copies of the control would be one."""
    return re.sub(
        rb"^(?=module channel_lane)", b'(* keep_hierarchy = "yes" *)\n', verilog, flags=re.MULTILINE
    )


def netlists() -> dict[str, tuple[str, bytes]]:
    """File name of each named configuration, with what it is and the netlist."""
    found = {}
    for name, entry in tomllib.loads(NETLISTS.read_text()).items():
        path = write_netlist(entry.get("generics", {}), entry["entity"], root=ROOT)
        found[f"netlists/{name}.v"] = (entry["text"], keep_lanes(path.read_bytes()))
    return found


def bitstreams(folder: Path) -> tuple[dict[str, tuple[str, bytes]], list[str]]:
    """
    What `make bitstream` has built.

    Returns
    -------
    dict
      File name of each, with what it is and its bytes.
    list of str
      Names of those that another host talks to, because formats or protocol were others.
    """
    found, old = {}, []
    for path in sorted(path for path in folder.glob("*") if path.suffix in (".bit", ".bin", ".fs")):
        about = path.with_suffix(".json")
        row = json.loads(about.read_text()) if about.is_file() else {"definition": ""}
        if row["definition"] != f"{definition_hash():08x}":
            old.append(path.name)
            continue
        clocks = ", ".join(f"{clock} {mhz:.1f} of {least:g}" for clock, (mhz, least) in row["clocks"].items())
        text = (
            f"`{path.stem}` for {row['device']}, screen {row['screen']}, MHz after place-and-route: {clocks}"
        )
        found[f"bitstreams/{path.name}"] = (text, path.read_bytes())
    return found, old


def without_bitstream(built: Collection[str], old: Sequence[str] = ()) -> str:
    """
    Names the boards that a bitstream can be built for and that have none.

    Parameters
    ----------
    built : collection of str
      Files of the archive.
    old : sequence of str
      Bitstreams that were left out, and are named elsewhere.

    Returns
    -------
    str
      A line without its end; empty where every board has one.
    """
    present = {Path(name).stem for name in (*built, *old)}
    names = [
        path.stem
        for path in sorted(BOARDS.glob("*.toml"))
        if "top" in tomllib.loads(path.read_text()) and path.stem not in present
    ]
    return NOT_BUILT.format(names=", ".join(names), first=names[0]) if names else ""


def files(folder: Path = BITSTREAMS) -> dict[str, bytes]:
    """Every file of the archive by name, with the bitstreams of a folder."""
    written, (built, _) = netlists(), bitstreams(folder)
    rows = [f"| `{name}` | {text} |" for name, (text, _) in (written | built).items()]
    about = ABOUT.format(version=quadshade.__version__, definition=definition_hash(), rows="\n".join(rows))
    if line := without_bitstream(built):
        about += f"\nIn this archive is {line} (in a checkout).\n"
    copied = [ROOT / "LICENSE", ROOT / "quadshade.core", ROOT / "rtl" / "files.f", *rtl_files(ROOT), HOOK]
    copied += [ROOT / "examples" / "design" / name for name in BENCH]
    content = {str(path.relative_to(ROOT)): path.read_bytes() for path in copied}
    content |= {name: data for name, (_, data) in (written | built).items()}
    content |= {"README.md": about.encode(), "CHANGES.md": changes().encode()}
    content["VERSION"] = f"{quadshade.__version__} {definition_hash():08x}\n".encode()
    sums = [f"{hashlib.sha256(data).hexdigest()}  {name}" for name, data in sorted(content.items())]
    return content | {"SHA256SUMS": ("\n".join(sums) + "\n").encode()}


def archive(content: dict[str, bytes], folder: str) -> bytes:
    """A .tar.gz of files in a folder, without times and owners."""
    packed = io.BytesIO()
    with (
        gzip.GzipFile(fileobj=packed, mode="wb", mtime=0) as compressed,
        tarfile.open(fileobj=compressed, mode="w") as tar,
    ):
        for name, data in sorted(content.items()):
            entry = tarfile.TarInfo(f"{folder}/{name}")
            entry.size = len(data)
            tar.addfile(entry, io.BytesIO(data))
    return packed.getvalue()


@click.command(help=__doc__)
@click.option(
    "-o", "--output", type=click.Path(file_okay=False, path_type=Path), default=ROOT / "build/release"
)
@one_line_errors("release")
def main(output: Path) -> None:
    folder = f"quadshade-{quadshade.__version__}"
    content = files()
    output.mkdir(parents=True, exist_ok=True)
    path = output / f"{folder}.tar.gz"
    write_bytes(path, archive(content, folder))
    built = sum(name.startswith("bitstreams/") for name in content)
    click.echo(f"{path}: {len(content)} files, {built} bitstreams")
    old = bitstreams(BITSTREAMS)[1]
    for name in old:
        click.echo(
            f"release: {name} is of another protocol, and left out;"
            f" `make bitstream BOARD={Path(name).stem}` builds it anew",
            err=True,
        )
    if line := without_bitstream(content, old):
        click.echo(f"release: {line}", err=True)


if __name__ == "__main__":
    main()
