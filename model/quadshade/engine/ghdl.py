# SPDX-License-Identifier: Apache-2.0
"""The RTL in GHDL, through ``sim/render_core_tb.vhd``: state and beats in files, pixels out of a file."""

from __future__ import annotations

import os
import shutil
import tempfile
from pathlib import Path

import numpy as np

from quadshade.contract.formats import Formats
from quadshade.contract.shade_state import ShadeState
from quadshade.engine.build_cache import build_key, build_once
from quadshade.engine.sources import repository_root, rtl_files
from quadshade.engine.tool_runner import INSTALL_OR_MODEL, announce, run_tool, tool_command
from quadshade.errors import QuadshadeError
from quadshade.files.atomic import write_atomically
from quadshade.golden.compiled import EmittedPixels

TESTBENCH = "render_core_tb"


def analyse(root: Path, testbench: str = TESTBENCH) -> Path:
    """Analyse RTL and a test bench once for each state of the sources; returns the work library's folder."""
    ghdl = tool_command("GHDL")
    sources = [*rtl_files(root), root / "sim" / f"{testbench}.vhd"]

    def make(library: Path) -> None:
        announce("analysing the VHDL for GHDL, once for this state of it")
        run_tool([*ghdl, "-a", "--std=08", f"--workdir={library}", *sources], library, INSTALL_OR_MODEL)

    key = build_key(*ghdl, os.environ.get("GHDL_BACKEND", ""), *sources)
    return build_once(root / "build" / "ghdl", key, make)


def write_beats(words: np.ndarray, formats: Formats, path: Path) -> None:
    """Beats as hexadecimal lines, the first set-up word rightmost."""
    beats = words.astype(np.uint32).reshape(-1, formats.beat_words)[:, ::-1]
    row = "%08x" * formats.beat_words
    path.write_text("".join(f"{row % tuple(beat)}\n" for beat in beats.tolist()))


def write_state(state: ShadeState | None, path: Path) -> None:
    """Addresses and words as hexadecimal lines; none where there is no state."""
    rows = [] if state is None else state.writes().tolist()
    path.write_text("".join(f"{address:08x} {word:08x}\n" for address, word in rows))


def read_pixels(path: Path, formats: Formats) -> EmittedPixels:
    """Pixels and clocks from what the test bench wrote."""
    lines = path.read_text().splitlines()
    if not lines or not lines[-1].startswith("clocks "):
        raise QuadshadeError("the simulation ended before the core was idle", f"see {path}")
    rows = np.array(
        [[int(field, 16) for field in line.split()] for line in lines[:-1]], dtype=object
    ).reshape(-1, 5)
    last, y, x, depth = (rows[:, column].astype(np.int64) for column in range(4))
    packet = np.concatenate([[0], np.cumsum(last)])[: len(last)]
    mask = (1 << formats.value_bits) - 1
    value = [
        (rows[:, 4] >> (formats.value_bits * channel)) & mask for channel in range(formats.emitted_channels)
    ]
    value += [depth] * formats.with_depth
    values = np.stack([column.astype(np.int64) for column in value], axis=1)
    clocks = int(lines[-1].split()[1])
    return EmittedPixels(
        packet.astype(np.int32),
        x.astype(np.int32),
        y.astype(np.int32),
        values.astype(np.int32),
        clocks,
        int(last.sum()),
    )


def draw_ghdl(
    words: np.ndarray,
    formats: Formats,
    waves: Path | None = None,
    stall_period: int = 0,
    state: ShadeState | None = None,
) -> EmittedPixels:
    """
    Draw a stream of set-up words with the RTL.

    Parameters
    ----------
    words : (m,) uint32
      Set-up words of whole packets, each of which draws at least one pixel on its last scanline: the packet
      of a pixel is counted by the core's flag of a primitive's last pixel.
    formats : Formats
    waves : Path, optional
      GHW file to write.
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
      GHDL is missing or fails.
    """
    try:
        return _draw(words, formats, waves, stall_period, state)
    except OSError as problem:
        raise QuadshadeError(f"GHDL's files: {problem}", "use --engine model") from None


def _draw(
    words: np.ndarray, formats: Formats, waves: Path | None, stall_period: int, state: ShadeState | None
) -> EmittedPixels:
    library = analyse(repository_root())
    with tempfile.TemporaryDirectory(prefix="quadshade-") as scratch:
        folder = Path(scratch)
        write_beats(words, formats, folder / "beats.txt")
        write_state(state, folder / "state.txt")
        generics = formats.generics() | {
            "state_file": folder / "state.txt",
            "beats_file": folder / "beats.txt",
            "pixels_file": folder / "pixels.txt",
        }
        generics["stall_period"] = stall_period
        command = [*tool_command("GHDL"), "--elab-run", "--std=08", f"--workdir={library}"]
        command += [TESTBENCH]
        command += [f"-g{name}={value}" for name, value in generics.items()]
        command += ["--ieee-asserts=disable"]
        if waves is not None:
            command += [f"--wave={folder / 'waves.ghw'}"]
        run_tool(command, folder, INSTALL_OR_MODEL)
        if waves is not None:
            write_atomically(waves, lambda temporary: shutil.copyfile(folder / "waves.ghw", temporary))
        return read_pixels(folder / "pixels.txt", formats)
