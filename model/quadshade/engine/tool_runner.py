# SPDX-License-Identifier: Apache-2.0
"""Programs that Quadshade runs: simulators, synthesis, place and route, provers."""

from __future__ import annotations

import contextlib
import os
import shlex
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

TOOLS = {"GHDL": "ghdl", "VERILATOR": "verilator", "CXX": "g++"}
"""Environment variables that replace a program's command, arguments included, and the usual command."""


def announce(text: str) -> None:
    """Say on standard error what begins now and takes seconds, to a terminal and to a log alike."""
    print(f"quadshade: {text} ...", file=sys.stderr, flush=True)


def tool_command(variable: str) -> list[str]:
    """
    The command of a program that an environment variable can replace: ``CXX="ccache g++ -m64"`` for example.

    Parameters
    ----------
    variable : str
      One of ``TOOLS``; one that is not set or empty stands for the usual command.

    Returns
    -------
    list of str
      The program and its first arguments.

    Raises
    ------
    QuadshadeError
      The variable has a quote that is not closed.
    """
    text = os.environ.get(variable, "")
    try:
        return shlex.split(text) or [TOOLS[variable]]
    except ValueError as problem:
        raise QuadshadeError(
            f"{variable} is {text!r}: {problem}", f"give a command, as {TOOLS[variable]}"
        ) from None


def is_replaced(variable: str) -> bool:
    """Whether an environment variable names another command than the usual one."""
    return os.environ.get(variable, "").strip() not in ("", TOOLS[variable])


def missing_tool(variables: Sequence[str]) -> str:
    """
    What is wrong with the first of some programs that cannot run here; nothing if all can.

    Parameters
    ----------
    variables : sequence of str
      Of ``TOOLS``.

    Returns
    -------
    str
      One clause, with the variable where it is to blame.
    """
    for variable in variables:
        try:
            program = tool_command(variable)[0]
        except QuadshadeError as problem:
            return problem.message
        if shutil.which(program) is None:
            given = f"{variable} is {os.environ[variable]!r}: " if is_replaced(variable) else ""
            return f"{given}{program} is not installed"
    return ""


@cache
def tool_version(command: tuple[str, ...]) -> str:
    """What a program prints for ``--version``; raises a :class:`QuadshadeError` if it is missing or fails."""
    return run_tool([*command, "--version"], Path.cwd(), INSTALL_OR_MODEL)


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
