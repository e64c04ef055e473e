# SPDX-License-Identifier: Apache-2.0
"""The core's netlist in Verilator, through ``sim/verilator``: millions of clocks a second."""

from __future__ import annotations

import shlex
import shutil
import tempfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from quadshade.contract.formats import Formats
from quadshade.contract.shade_state import ShadeState
from quadshade.engine.build_cache import build_key, build_once
from quadshade.engine.netlist import RENDER_TOP, write_netlist
from quadshade.engine.simplify_netlist import fold
from quadshade.engine.sources import repository_root
from quadshade.engine.tool_runner import (
    INSTALL_OR_MODEL,
    announce,
    missing_tool,
    run_tool,
    tool_command,
    tool_version,
)
from quadshade.errors import QuadshadeError
from quadshade.golden.compiled import EmittedPixels

MACROS = ("stream_width", "emitted_channels", "value_bits")
"""What the C++ harness takes as macros, in capitals; other widths it has from the ports' types."""

VERILATOR_OPTIONS = (
    *("--cc", "--exe", "--build", "-O3", "--x-assign", "fast", "--x-initial", "fast", "--noassert"),
    # GHDL writes plain Verilog, in which SystemVerilog's words are names.
    *("--default-language", "1364-2005"),
    # GHDL writes initial values with `<=`; nothing else drives at time 0.
    "-Wno-INITIALDLY",
    # A case of GHDL's names the values that can occur.
    "-Wno-CASEINCOMPLETE",
    # Bits of one vector that depend on each other in a row, where fold leaves them: no loop, only slower.
    "-Wno-UNOPTFLAT",
)

MAKE_FLAGS = "OPT_FAST=-O2 OPT_GLOBAL=-O1 OPT_SLOW=-O0"
"""Only what runs every clock is worth the compiler's time."""


PROGRAMS = ("GHDL", "VERILATOR", "CXX")
"""What makes a simulation, by the variables of :func:`quadshade.engine.tool_runner.tool_command`."""


def missing_program() -> str:
    """What is wrong with the first program that this engine needs and cannot run; nothing if all can."""
    return missing_tool(PROGRAMS) or ("" if shutil.which("make") else "make is not installed")


def verilator_available() -> bool:
    """Whether this engine can draw here: its programs are installed, and the RTL is at hand."""
    try:
        repository_root()
    except QuadshadeError:
        return False
    return not missing_program()


def build_verilator(formats: Formats, kept: Path | None = None) -> Path:
    """
    Compile the simulation of the core with some generics: see :func:`compile_netlist`.

    Returns
    -------
    Path
      The program ``<hash>/render_core``; its arguments stand in the harness.
    """
    macros = {name: getattr(formats, name) for name in MACROS}
    return compile_netlist(RENDER_TOP, formats.generics(), "the core", macros, kept)


def compile_netlist(
    top: str,
    generics: Mapping[str, int],
    what: str,
    macros: Mapping[str, int] | None = None,
    kept: Path | None = None,
) -> Path:
    """
    Compile the simulation of an entity with some generics, once for each netlist, harness and tool.

    Parameters
    ----------
    top : str
      The entity; ``sim/verilator/<top>_main.cpp`` is its harness.
    generics : mapping of str to int
    what : str
      What a terminal is told is compiled.
    macros : mapping of str to int, optional
      What the harness takes as macros, in capitals.
    kept : Path, optional
      Folder of the programs; ``build/verilator`` of the checkout if left out.

    Returns
    -------
    Path
      The program ``<hash>/<top>`` in that folder.

    Raises
    ------
    QuadshadeError
      A tool is missing or fails.
    """
    if problem := missing_program():
        raise QuadshadeError(problem, INSTALL_OR_MODEL)
    root = repository_root()
    harness = root / "sim" / "verilator" / f"{top}_main.cpp"
    netlist = fold(write_netlist(generics, top, root=root).read_text())
    verilator, compiler = tool_command("VERILATOR"), tool_command("CXX")
    command = [*verilator, *VERILATOR_OPTIONS, "--top-module", top, "-o", top]
    if macros:
        command += ["-CFLAGS", " ".join(f"-D{name.upper()}={value}" for name, value in macros.items())]
    command += ["-MAKEFLAGS", f"{MAKE_FLAGS} {_make_settings(compiler)}"]

    def make(folder: Path) -> None:
        announce(f"compiling {what} for Verilator, once for these generics")
        # Not below the checkout, whose path is the user's, and by bare names: Verilator's make file refuses a
        # folder with a blank and takes no file with a blank or a sign.
        with tempfile.TemporaryDirectory(prefix="quadshade-") as scratch:
            if scratch.split() != [scratch]:
                raise QuadshadeError(
                    f"Verilator cannot build in {Path(scratch).parent}: make takes no path with a blank",
                    "set TMPDIR to a folder without one",
                )
            work = Path(scratch)
            (work / f"{top}.v").write_text(netlist)
            shutil.copy(harness, work)
            run_tool([*command, "--Mdir", ".", f"{top}.v", harness.name], work, INSTALL_OR_MODEL)
            shutil.move(work / top, folder / top)

    versions = tool_version(tuple(verilator)), tool_version(tuple(compiler))
    key = build_key(*command, *versions, netlist, harness)
    return build_once(kept or root / "build" / "verilator", key, make) / top


def _make_settings(compiler: list[str]) -> str:
    """A compiler with its arguments, for the shell and the make that Verilator starts; it links too."""
    text = shlex.join(compiler).replace("$", "$$")
    return " ".join(shlex.quote(f"{name}={text}") for name in ("CXX", "LINK"))


def record_type(formats: Formats) -> np.dtype:
    """What the harness writes for a pixel: its ``struct Record``."""
    value = ("value", np.uint32, (formats.emitted_channels,))
    return np.dtype(
        [("x", np.uint16), ("y", np.uint16), ("depth", np.uint32), value, ("last", np.uint16)], align=True
    )


def read_records(path: Path, formats: Formats, clocks: int) -> EmittedPixels:
    """Pixels from the file that the harness wrote."""
    records = np.fromfile(path, dtype=record_type(formats))
    last = records["last"].astype(np.int32)
    value = np.empty((len(records), formats.emitted_channels + formats.with_depth), np.int32)
    value[:, : formats.emitted_channels] = records["value"]
    if formats.with_depth:
        value[:, -1] = records["depth"].astype(np.int32)
    ended = np.cumsum(last, dtype=np.int32)
    x, y = records["x"].astype(np.int32), records["y"].astype(np.int32)
    return EmittedPixels(ended - last, x, y, value, clocks, int(last.sum()))


def draw_verilator(
    words: np.ndarray, formats: Formats, stall_period: int = 0, state: ShadeState | None = None
) -> EmittedPixels:
    """
    Draw a stream of set-up words with the core's netlist.

    Parameters
    ----------
    words : (m,) uint32
      Set-up words of whole packets, each of which draws at least one pixel on its last scanline: the packet
      of a pixel is counted by the core's flag of a primitive's last pixel.
    formats : Formats
    stall_period : int
      The sink is not ready in every n-th clock; 0: always ready.
    state : ShadeState, optional
      Written before the drawing; if left out, the unit is as after power-up.

    Returns
    -------
    EmittedPixels

    Raises
    ------
    QuadshadeError
      A tool is missing or fails.
    """
    try:
        return _draw(build_verilator(formats), words, formats, stall_period, state)
    except OSError as problem:
        raise QuadshadeError(f"Verilator's files: {problem}", "use --engine model") from None


def _draw(
    program: Path, words: np.ndarray, formats: Formats, stall_period: int, state: ShadeState | None
) -> EmittedPixels:
    with tempfile.TemporaryDirectory(prefix="quadshade-") as scratch:
        folder = Path(scratch)
        writes, beats, pixels = folder / "state.bin", folder / "beats.bin", folder / "pixels.bin"
        writes.write_bytes(b"" if state is None else state.writes().tobytes())
        np.ascontiguousarray(words, dtype=np.uint32).tofile(beats)
        printed = run_tool([program, writes, beats, pixels, str(stall_period)], folder)
        report = dict(line.split() for line in printed.splitlines())
        return read_records(pixels, formats, int(report["clocks"]))
