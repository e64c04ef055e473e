# SPDX-License-Identifier: Apache-2.0
"""
The core as one Verilog netlist, by GHDL's synthesis: what Verilator, Icarus, Yosys and sby read.

GHDL 2.0 writes a constant wider than 32 bits as a Verilog string of its digits, which every reader takes for
ASCII. Such strings become sized binary constants here, and a netlist in which a quote remains is refused.
It also keeps a signal's name that is a word of SystemVerilog, which some readers then do not take.
"""

from __future__ import annotations

import re
import tempfile
import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path

from quadshade.contract.formats import Formats
from quadshade.engine.build_cache import build_key, build_once
from quadshade.engine.sources import repository_root, rtl_files
from quadshade.engine.tool_runner import run_tool, tool_command, tool_version
from quadshade.errors import QuadshadeError

TOP = "raster_core"
RENDER_TOP = "render_core"
"""The core with what follows it: what the simulators run."""


KEYWORDS = frozenset(
    re.findall(
        r"\w+",
        """
    accept_on alias always_comb always_ff always_latch assert assume before bind bins binsof bit
    break byte chandle checker class clocking const constraint context continue cover covergroup
    coverpoint cross dist do enum eventually expect export extends extern final first_match foreach
    forkjoin global iff ignore_bins illegal_bins implements implies import inside int interconnect
    interface intersect join_any join_none let local logic longint matches modport nettype new
    nexttime null package packed priority program property protected pure rand randc randcase
    randsequence ref reject_on restrict return sequence shortint shortreal soft solve static string
    strong struct super tagged this throughout timeprecision timeunit type typedef union unique
    unique0 until until_with untyped uwire var virtual void wait_order weak wildcard with within
    """,
    )
)
"""Words of SystemVerilog (IEEE 1800-2017) that Verilog does not have, as far as they may name a signal."""

DECLARED = re.compile(
    r"^ *(?:input|output|inout|wire|reg)(?: (?:wire|reg))?(?: *\[[^\]]*\])? +(\w+)", re.MULTILINE
)


def core_of(formats: Formats) -> tuple[str, dict[str, int]]:
    """The entity that is a core of these formats, and its generics: without shade, ``raster_core``."""
    if formats.with_shade:
        return RENDER_TOP, formats.generics()
    return TOP, formats.core_generics()


def repair_constants(verilog: str) -> str:
    """
    Verilog with its constants that are strings of digits as sized binary constants.

    Parameters
    ----------
    verilog : str
      What ``ghdl --synth --out=verilog`` printed.

    Returns
    -------
    str

    Raises
    ------
    QuadshadeError
      A quote that is not around such a constant.
    """
    repaired = re.sub(r'"([01xzXZ]+)"', lambda match: f"{len(match[1])}'b{match[1]}", verilog)
    for number, line in enumerate(repaired.splitlines(), start=1):
        if '"' in line:
            raise QuadshadeError(
                f"line {number} of the netlist has a quote that is not a constant's: {line.strip()[:80]}",
                "write the VHDL of that signal so that GHDL's synthesis needs no string",
            )
    return repaired


def check_names(verilog: str) -> None:
    """
    Refuse a netlist with a signal that has a word of SystemVerilog as its name, or two modules of one name.

    Raises
    ------
    QuadshadeError
      There is one.
    """
    modules = re.findall(r"^module (\w+)", verilog, re.MULTILINE)
    for name in modules:
        if modules.count(name) > 1:
            raise QuadshadeError(
                f"two modules of the netlist are called {name!r}", "rename yours: Verilog has no libraries"
            )
    for name in DECLARED.findall(verilog):
        if name in KEYWORDS:
            raise QuadshadeError(
                f"a signal is called {name!r}, a word of SystemVerilog", "rename it in the VHDL"
            )


def netlist_header(top: str, generics: Mapping[str, int | str]) -> str:
    """What a netlist says of itself, as comments."""
    given = ", ".join(f"{name} = {value}" for name, value in generics.items()) or "all have their defaults"
    lines = [
        "SPDX-License-Identifier: Apache-2.0",
        "",
        f"{top} of Quadshade as a Verilog netlist, written by GHDL from the VHDL that its comments name.",
        "Its generics are fixed; another configuration is another netlist:",
        *textwrap.wrap(given, 100),
    ]
    return "".join(f"// {line}".rstrip() + "\n" for line in lines)


def write_netlist(
    generics: Mapping[str, int | str],
    top: str = TOP,
    more: Sequence[Path] = (),
    root: Path | None = None,
    library: str = "work",
) -> Path:
    """
    Synthesise an entity into one checked Verilog file, once for each state of the sources.

    Parameters
    ----------
    generics : mapping of str to int or str
      Generics of the entity, under their VHDL names; what is left out has its default.
    top : str
      The entity, from ``rtl/files.f`` or ``more``.
    more : sequence of Path
      VHDL files to analyse after those of ``rtl/files.f``, into the library ``work``.
    root : Path, optional
      Checkout of Quadshade; the one that holds this package if left out.
    library : str
      That of the files of ``rtl/files.f``; with another one than ``work`` the entity is one of ``more``.

    Returns
    -------
    Path
      ``build/netlist/<hash>/<top>.v``; its module has the entity's name, and its hash is that of everything
      that it was made of.

    Raises
    ------
    QuadshadeError
      GHDL is missing or fails, warnings included, or the netlist cannot be repaired.
    """
    root = root or repository_root()
    ghdl = tool_command("GHDL")
    own = rtl_files(root)
    settings = [f"-g{name}={value}" for name, value in generics.items()]

    def make(folder: Path) -> None:
        with tempfile.TemporaryDirectory() as work:
            command = [*ghdl, "--synth", "--std=08", f"--workdir={work}", "-Werror", "--no-formal"]
            command += ["--out=verilog", *settings, f"--work={library}", *map(str, own), "--work=work"]
            command += [*map(str, more), "-e", top]
            verilog = repair_constants(run_tool(command, Path(work)))
        check_names(verilog)
        # Comments say where a line comes from; the folder of a checkout is nobody else's.
        verilog = verilog.replace(f"{root}/", "")
        (folder / f"{top}.v").write_text(netlist_header(top, generics) + verilog)

    key = build_key(tool_version(tuple(ghdl)), top, library, *settings, Path(__file__), *own, *more)
    return build_once(root / "build" / "netlist", key, make) / f"{top}.v"
