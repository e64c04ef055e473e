# SPDX-License-Identifier: Apache-2.0
"""
The first clocks of a unit's own cocotb test, from GHDL: what stood at its ports in each clock.

The test drives the RTL as in `make test`; the simulation only ends earlier, and GHDL writes a VCD file.
"""

from __future__ import annotations

import contextlib
import dataclasses
import fcntl
import json
import re
from importlib import import_module
from pathlib import Path
from typing import Any
from unittest.mock import patch

from cocotb_tools.runner import get_runner

from cocotb_tests.support.bench import PERIOD_NS
from cocotb_tests.support.simulation import module_of
from quadshade.engine.build_cache import build_key
from quadshade.engine.sources import rtl_files
from quadshade.errors import QuadshadeError
from scripts.docs.entity import ROOT, Unit

WAVES = ROOT / "build" / "docs_waves"
"""A folder for each state of the RTL, with GHDL's library: each file is analysed once for all units."""

FS_PER_CLOCK = PERIOD_NS * 1_000_000


def ports_per_clock(unit: Unit, settings: dict[str, int], test: str, clocks: int) -> dict[str, list[str]]:
    """
    Values of all ports of a unit, clock by clock.

    Parameters
    ----------
    unit : Unit
    settings : dict of int
      Of the configuration of the unit's test, where they are not the default.
    test : str
      Name of the cocotb test, and of its parameters, as a regular expression; empty for the first.
    clocks : int
      How many are simulated.

    Returns
    -------
    dict of list of str
      For each port its bits, highest first, as they stood just before the clock edge that ends a clock.

    Raises
    ------
    QuadshadeError
      The simulation did not get that far.
    """
    sources = rtl_files(ROOT)
    folder = WAVES / build_key(*sources)
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / ".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        return _simulated(unit, settings, test, clocks, folder)


def _simulated(
    unit: Unit, settings: dict[str, int], test: str, clocks: int, folder: Path
) -> dict[str, list[str]]:
    """As :func:`ports_per_clock`, in a folder that nobody else writes to."""
    module, config, generics = _as_tested(unit, settings)
    waves, log = folder / f"{unit.name}.vcd", folder / f"{unit.name}.log"
    waves.unlink(missing_ok=True)
    runner = get_runner("ghdl")
    options = ["--std=08"]
    try:
        runner.build(
            sources=rtl_files(ROOT),
            hdl_toplevel=unit.name,
            build_args=options,
            build_dir=folder,
            always=True,
            log_file=log,
        )
    except (RuntimeError, SystemExit):
        raise QuadshadeError(f"{unit.name}: GHDL does not compile it", f"see {log}") from None
    # A simulation that ends amid its test is a failure to the runner; whether it ran is in the waves.
    with contextlib.suppress(RuntimeError, SystemExit):
        runner.test(
            test_module=module,
            hdl_toplevel=unit.name,
            test_args=options,
            parameters=generics,
            test_filter=test or None,
            plusargs=[
                "--ieee-asserts=disable",
                f"--vcd={waves}",
                f"--stop-time={clocks * PERIOD_NS}ns",
            ],
            build_dir=folder,
            test_dir=folder,
            results_xml=str(folder / f"{unit.name}.xml"),
            log_file=log,
            extra_env={
                "QUADSHADE_CONFIG": json.dumps(dataclasses.asdict(config)),
                "QUADSHADE_UNIT": unit.name,
                "COCOTB_REWRITE_ASSERTION_FILES": "",
            },
        )
    names = [port.name for port in unit.ports]
    values = _read_vcd(waves, unit.name, names) if waves.is_file() else {}
    if len(values.get("clk", [])) < clocks - 1:
        raise QuadshadeError(f"{unit.name}: no waves of {clocks} clocks", f"see {log}")
    return values


def _as_tested(unit: Unit, settings: dict[str, int]) -> tuple[str, Any, dict[str, int]]:
    """Module of a unit's tests, a configuration, and the generics that the pytest function makes of it."""
    name = module_of(unit.name)
    module = import_module(name)
    config = module.Config(**settings)
    with patch.object(module, "simulate") as simulate:
        getattr(module, f"test_{unit.name}")(config)
    (_, config, *generics), named = simulate.call_args
    given = generics[0] if generics else named.get("generics")
    return name, config, given or dataclasses.asdict(config)


def _read_vcd(path: Path, scope: str, names: list[str]) -> dict[str, list[str]]:
    """Values of the ports of a top level before each clock edge but the first, from a VCD file of GHDL."""
    definitions, _, changes = path.read_text().partition("$enddefinitions $end")
    _, _, top = definitions.partition(f"$scope module {scope} $end")
    top = top.split("$scope")[0]
    ports = {code: name for code, name in re.findall(r"\$var reg \d+ (\S+) (\w+)", top) if name in names}
    now = dict.fromkeys(ports.values(), "")
    values: dict[str, list[str]] = {name: [] for name in now}
    edge = FS_PER_CLOCK // 2 + FS_PER_CLOCK
    for line in changes.split("\n"):
        if line.startswith("#"):
            while int(line[1:]) >= edge:
                for name, bits in now.items():
                    values[name].append(bits)
                edge += FS_PER_CLOCK
        elif line.startswith(("b", "B")):
            bits, code = line[1:].split(" ")
            if code in ports:
                now[ports[code]] = bits
        elif line and line[1:] in ports:
            now[ports[line[1:]]] = line[0]
    return values
