# SPDX-License-Identifier: Apache-2.0
"""
One simulation from a pytest function: build a unit with a configuration's generics, run its cocotb tests.

``QUADSHADE_SIM`` names the simulator (``ghdl`` if not given). ``QUADSHADE_NETLIST`` replaces the VHDL by a
Verilog netlist: ``ghdl`` for GHDL's synthesis of it, ``ice40`` or ``ecp5`` for that mapped to cells.
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

ROOT = Path(__file__).resolve().parents[2]
SIMULATOR = os.environ.get("QUADSHADE_SIM", "ghdl")
NETLIST = os.environ.get("QUADSHADE_NETLIST", "")
WAVES = bool(int(os.environ.get("QUADSHADE_WAVES") or os.environ.get("WAVES") or 0))


def identifier(config: Any) -> str:
    """What differs from a configuration's defaults, as ``name=value-name=value``."""
    changed = [
        f"{field.name}={getattr(config, field.name)}"
        for field in dataclasses.fields(config)
        if getattr(config, field.name) != field.default
    ]
    return "-".join(changed) or "default"


def source_files(unit: str, generics: dict[str, int]) -> list[Path]:
    """The VHDL, or the netlist that stands for it."""
    # Here, because this module is imported inside every simulation too, and these take seconds to load.
    if NETLIST:
        from quadshade.synthesis.mapped import netlist_files

        return netlist_files(NETLIST, unit, generics)
    from quadshade.engine.sources import rtl_files

    return rtl_files(ROOT)


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
    generics = generics or dataclasses.asdict(config)
    folder.mkdir(parents=True, exist_ok=True)
    log = folder / "simulation.log"
    log.unlink(missing_ok=True)
    results = folder / "results.xml"
    simulator = "icarus" if verilog else SIMULATOR
    runner = get_runner(simulator)
    vhdl = simulator == "ghdl"
    standard = ["--std=08"] if vhdl else []
    runner.build(
        sources=verilog or source_files(unit, generics),
        parameters=generics if verilog else {},
        hdl_toplevel=unit,
        build_args=standard,
        build_dir=folder,
        timescale=None if vhdl else ("1ns", "1ps"),
        waves=WAVES,
        always=True,
        log_file=folder / "build.log",
    )
    try:
        runner.test(
            test_module=module_of(tests),
            hdl_toplevel=unit,
            test_args=standard,
            plusargs=["--ieee-asserts=disable"] if vhdl else [],
            parameters={} if NETLIST or verilog else generics,
            build_dir=folder,
            test_dir=folder,
            results_xml=str(results),
            waves=WAVES,
            log_file=log,
            extra_env={
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
