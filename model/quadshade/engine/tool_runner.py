# SPDX-License-Identifier: Apache-2.0
"""Programs that Quadshade runs: simulators, synthesis, place and route, provers."""

from __future__ import annotations

import contextlib
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Mapping, Sequence
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from quadshade.errors import QuadshadeError

INSTALL = "run `make setup`"
INSTALL_OR_MODEL = f"{INSTALL}, or use --engine model"


def find_tool(command: str, hint: str = INSTALL) -> str:
    """
    Where a program is: beside this Python, as those of PyPI's packages are, or on the path.

    Parameters
    ----------
    command : str
    hint : str
      What a user can do where it is missing.

    Raises
    ------
    QuadshadeError
      It is nowhere.
    """
    beside = Path(sys.executable).parent / command
    found = str(beside) if beside.is_file() else shutil.which(command)
    if found is None:
        raise QuadshadeError(f"{command} is not installed", hint)
    return found


@cache
def package_version(package: str) -> str:
    """
    Name and version of a tool's Python package.

    Raises
    ------
    QuadshadeError
      It is not installed.
    """
    try:
        return f"{package} {version(package)}"
    except PackageNotFoundError:
        raise QuadshadeError(f"{package} is not installed", INSTALL) from None


def run_to_end(
    command: Sequence[str | Path],
    folder: Path,
    hint: str = INSTALL,
    environment: Mapping[str, str] | None = None,
    seconds: float | None = None,
) -> subprocess.CompletedProcess[str]:
    """
    Run a program in a folder, and end it with all that it has started if it is interrupted.

    Parameters
    ----------
    command : sequence of str or Path
      The program's name, looked up by :func:`find_tool`, and its arguments.
    folder : Path
    hint : str
      What a user can do where the program is missing.
    environment : mapping of str to str, optional
      This process's own if left out.
    seconds : float, optional
      After which it is ended.

    Returns
    -------
    subprocess.CompletedProcess
      Exit code, standard output and error; a program that fails raises nothing here.

    Raises
    ------
    QuadshadeError
      The program is not installed.
    subprocess.TimeoutExpired
      It took longer than ``seconds``.
    """
    process = subprocess.Popen(
        [find_tool(str(command[0]), hint), *map(str, command[1:])],
        cwd=folder,
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        errors="replace",
        # A group of its own, which can be ended as a whole.
        start_new_session=True,
    )
    try:
        output, errors = process.communicate(timeout=seconds)
    except BaseException:
        # With what it has started: GHDL runs the program that it built, Verilator make and the compiler.
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
        raise
    return subprocess.CompletedProcess(process.args, process.returncode, output, errors)


def run_tool(command: Sequence[str | Path], folder: Path, hint: str = INSTALL) -> str:
    """
    Run a program in a folder and return what it printed on its standard output.

    Parameters
    ----------
    command, folder, hint
      As for :func:`run_to_end`.

    Raises
    ------
    QuadshadeError
      The program is not installed, or fails; with the first line it printed that names an error.
    """
    done = run_to_end(command, folder, hint)
    if done.returncode != 0:
        said = [line for line in (done.stdout + done.stderr).splitlines() if line.strip()]
        named = [line for line in said if "error" in line.lower() or "failure" in line]
        reason = (named or said or [_ending(done.returncode)])[0].strip()
        raise QuadshadeError(f"{Path(command[0]).name} failed: {reason}")
    return done.stdout


def _ending(code: int) -> str:
    """How a program ended that said nothing: its exit code, or the signal that ended it."""
    return f"exit code {code}" if code > 0 else f"ended by signal {-code}"
