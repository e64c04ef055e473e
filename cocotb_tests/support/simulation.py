# SPDX-License-Identifier: Apache-2.0
"""
One simulation from a pytest function: build a unit with a configuration's generics, run its cocotb tests.

``QUADSHADE_SIM`` names the simulator (``ghdl`` if not given). ``QUADSHADE_NETLIST`` replaces the VHDL by a
Verilog netlist: ``ghdl`` for GHDL's synthesis of it, ``ice40`` or ``ecp5`` for that mapped to cells.
``QUADSHADE_COVERAGE`` is a folder for what gcc's counters saw of the VHDL: ``scripts/coverage`` reads it.
"""

from __future__ import annotations

import dataclasses
import json
import os
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from cocotb_tools.runner import get_runner

from cocotb_tests.support.cover import SOURCES

ROOT = Path(__file__).resolve().parents[2]
SIMULATOR = os.environ.get("QUADSHADE_SIM", "ghdl")
NETLIST = os.environ.get("QUADSHADE_NETLIST", "")
COVERAGE = os.environ.get("QUADSHADE_COVERAGE", "")
STANDARD = "--std=08"
COUNTED = ["-Wc,-fprofile-arcs", "-Wc,-ftest-coverage", "-Wl,--coverage"] if COVERAGE else []
WAVES = bool(int(os.environ.get("QUADSHADE_WAVES") or os.environ.get("WAVES") or 0))


def identifier(config: Any) -> str:
    """What differs from a configuration's defaults, as ``name=value-name=value``."""
    changed = [
        f"{field.name}={getattr(config, field.name)}"
        for field in dataclasses.fields(config)
        if getattr(config, field.name) != field.default
    ]
    return "-".join(changed) or "default"


def elaborated(unit: str) -> Path:
    """
    A unit analysed with all that it uses, and elaborated: once for each state of the sources.

    Its configurations share it: GHDL takes generics when it runs. Only what the unit needs is compiled.
    """
    from quadshade.engine.build_cache import build_key, build_once
    from quadshade.engine.sources import rtl_files
    from quadshade.engine.tool_runner import run_tool, tool_version

    sources = rtl_files(ROOT)

    def make(library: Path) -> None:
        run_tool(["ghdl", "-i", STANDARD, *sources], library)
        run_tool(["ghdl", "-m", STANDARD, *COUNTED, unit], library)

    # The program is cocotb's choice: its runner calls it by this name.
    key = build_key(tool_version(("ghdl",)), STANDARD, *COUNTED, unit, *sources)
    if COVERAGE:
        counts = Path(COVERAGE) / key
        counts.mkdir(parents=True, exist_ok=True)
        (counts / SOURCES).write_text(build_key(*sources))
    return build_once(ROOT / "build" / "cocotb" / "library", key, make)


def link_program(library: Path, unit: str, folder: Path) -> None:
    """Put the elaborated program, where GHDL's code generator makes one, into the folder that it runs in."""
    link = folder / unit
    link.unlink(missing_ok=True)
    if (library / unit).is_file():
        link.symlink_to(library / unit)


def failures(results: Path) -> list[str]:
    """Name and message of every cocotb test that failed."""
    if not results.is_file():
        return ["the simulation ended before its tests did"]
    found = []
    cases = list(ElementTree.parse(results).iter("testcase"))
    for case in cases:
        for kind in ("failure", "error"):
            for fault in case.findall(kind):
                text = fault.get("message") or fault.text or kind
                found.append(f"{case.get('name')}: {text}")
    return found if cases else ["no cocotb test was found"]


def module_of(tests: str) -> str:
    """The module of a unit's cocotb tests, whose folder is the unit's stage."""
    (path,) = (ROOT / "cocotb_tests").rglob(f"test_{tests}.py")
    return f"cocotb_tests.{path.parent.name}.{path.stem}"


def simulate(
    unit: str,
    config: Any,
    generics: dict[str, int] | None = None,
    verilog: list[Path] | None = None,
    tests: str | None = None,
) -> None:
    """
    Run the cocotb tests of ``test_<tests>.py`` on a unit.

    Parameters
    ----------
    unit : str
      The entity.
    config : dataclass
      What the tests read back with ``bench.configuration``.
    generics : dict of int, optional
      Generics of the entity; the fields of ``config`` if not given.
    verilog : list of Path, optional
      Files that stand for the unit, simulated by Icarus whatever the environment says.
    tests : str, optional
      Name of the module; the unit's if not given.

    Raises
    ------
    pytest.fail.Exception
      With what each failing cocotb test said.
    """
    name, tests = identifier(config), tests or unit
    kind = "verilog" if verilog else NETLIST or "vhdl"
    folder = ROOT / "build" / "cocotb" / kind / tests / name
    generics = dataclasses.asdict(config) if generics is None else generics
    folder.mkdir(parents=True, exist_ok=True)
    log = folder / "simulation.log"
    log.unlink(missing_ok=True)
    results = folder / "results.xml"
    simulator = "icarus" if verilog else SIMULATOR
    runner = get_runner(simulator)
    test_args, environment = [], {}
    if simulator == "ghdl":
        library = elaborated(unit)
        link_program(library, unit, folder)
        test_args = [STANDARD, f"--workdir={library}"]
        if COVERAGE:
            # Without the folders of the compilation, in whose place stands the library's.
            environment = {"GCOV_PREFIX": f"{COVERAGE}/{library.name}", "GCOV_PREFIX_STRIP": "99"}
    else:
        # Here, because this module is imported inside every simulation too, and this takes seconds to load.
        from quadshade.synthesis.mapped import netlist_files

        runner.build(
            sources=verilog or netlist_files(NETLIST, unit, generics),
            parameters=generics if verilog else {},
            hdl_toplevel=unit,
            build_dir=folder,
            timescale=("1ns", "1ps"),
            waves=WAVES,
            always=True,
            log_file=folder / "build.log",
        )
    try:
        runner.test(
            test_module=module_of(tests),
            hdl_toplevel=unit,
            hdl_toplevel_lang="vhdl" if simulator == "ghdl" else "verilog",
            hdl_toplevel_library="work" if simulator == "ghdl" else "top",
            test_args=test_args,
            plusargs=["--ieee-asserts=disable"] if simulator == "ghdl" else [],
            parameters=generics if simulator == "ghdl" else {},
            build_dir=folder,
            test_dir=folder,
            results_xml=str(results),
            waves=WAVES,
            log_file=log,
            extra_env={
                **environment,
                "QUADSHADE_CONFIG": json.dumps(dataclasses.asdict(config)),
                "QUADSHADE_UNIT": unit,
                # Else pytest's import hook compiles every library anew, seconds a simulation.
                "COCOTB_REWRITE_ASSERTION_FILES": "",
            },
        )
    except (RuntimeError, SystemExit) as problem:
        found = failures(results) or [str(problem)]
    else:
        found = failures(results)
    if found:
        pytest.fail("\n".join([*found, f"log: {log}"]), pytrace=False)
