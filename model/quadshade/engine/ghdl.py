# SPDX-License-Identifier: Apache-2.0
"""The RTL in GHDL, through ``sim/render_core_tb.vhd``: state and beats in files, pixels out of a file."""

from __future__ import annotations

import contextlib
import hashlib
import os
import shutil
import signal
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from quadshade.contract.formats import Formats
from quadshade.contract.shade_state import ShadeState
from quadshade.errors import QuadshadeError
from quadshade.golden.compiled import EmittedPixels

TESTBENCH = "render_core_tb"


def repository_root() -> Path:
    """
    The checkout that holds ``rtl`` and ``sim``.

    Raises
    ------
    QuadshadeError
      The package was installed without its repository.
    """
    root = Path(os.environ.get("QUADSHADE_ROOT", Path(__file__).resolve().parents[3]))
    if not (root / "rtl" / "files.f").is_file():
        raise QuadshadeError(f"no rtl/files.f below {root}", "set QUADSHADE_ROOT to a checkout of Quadshade")
    return root


def rtl_files(root: Path) -> list[Path]:
    """Every RTL file, bottom-up, from ``rtl/files.f``."""
    lines = (root / "rtl" / "files.f").read_text().splitlines()
    return [root / line.strip() for line in lines if line.strip() and not line.startswith("#")]


def run_tool(command: list[str], cwd: Path) -> str:
    """
    Run a simulator's command and return what it printed on its standard output.

    Raises
    ------
    QuadshadeError
      The tool is missing, or fails; with the first line it printed that names an error.
    """
    try:
        process = subprocess.Popen(
            command,
            cwd=cwd,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            errors="replace",
            # A group of its own, which can be ended as a whole.
            start_new_session=True,
        )
    except FileNotFoundError:
        raise QuadshadeError(
            f"{command[0]} is not installed", "run `make setup`, or use --engine model"
        ) from None
    try:
        output, errors = process.communicate()
    except BaseException:
        # With what it has started: GHDL runs the program that it built, Verilator make and the compiler.
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
        raise
    if process.returncode != 0:
        said = [line for line in (output + errors).splitlines() if line.strip()]
        named = [line for line in said if "error" in line.lower() or "failure" in line]
        reason = (named or said or [_ending(process.returncode)])[0].strip()
        raise QuadshadeError(f"{Path(command[0]).name} failed: {reason}")
    return output


def _ending(code: int) -> str:
    """How a program ended that said nothing: its exit code, or the signal that ended it."""
    return f"exit code {code}" if code > 0 else f"ended by signal {-code}"


def analyse(root: Path, testbench: str = TESTBENCH) -> Path:
    """Analyse RTL and a test bench once for each state of the sources; returns the work library's folder."""
    ghdl = os.environ.get("GHDL", "ghdl")
    sources = [*rtl_files(root), root / "sim" / f"{testbench}.vhd"]
    digest = hashlib.sha256(f"{ghdl} {os.environ.get('GHDL_BACKEND', '')}".encode())
    for source in sources:
        digest.update(source.read_bytes())
    library = root / "build" / "ghdl" / digest.hexdigest()[:16]
    if not library.is_dir():
        library.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=library.parent) as scratch:
            work = Path(scratch) / "work"
            work.mkdir()
            run_tool([ghdl, "-a", "--std=08", f"--workdir={work}", *map(str, sources)], work)
            try:
                work.rename(library)
            except OSError:
                # Another process was first with the same sources.
                if not library.is_dir():
                    raise
    return library


def write_beats(words: np.ndarray, formats: Formats, path: Path) -> None:
    """Beats as hexadecimal lines, the first lane rightmost."""
    beats = words.astype(np.uint32).reshape(-1, formats.stream_lanes)[:, ::-1]
    row = "%08x" * formats.stream_lanes
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
      32-bit lanes, whole packets, each of which draws at least one pixel on its last scanline: the packet
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
        command = [os.environ.get("GHDL", "ghdl"), "--elab-run", "--std=08", f"--workdir={library}"]
        command += [TESTBENCH]
        command += [f"-g{name}={value}" for name, value in generics.items()]
        command += ["--ieee-asserts=disable"]
        if waves is not None:
            command += [f"--wave={folder / 'waves.ghw'}"]
        run_tool(command, folder)
        if waves is not None:
            try:
                shutil.move(folder / "waves.ghw", waves)
            except OSError as problem:
                raise QuadshadeError(f"cannot write {waves}: {problem.strerror}") from None
        return read_pixels(folder / "pixels.txt", formats)
