# SPDX-License-Identifier: Apache-2.0
"""What a core's generics cost in cells: GHDL's netlist through Yosys, without place-and-route."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path

from quadshade.contract.formats import Formats
from quadshade.engine.build_cache import build_key, build_once
from quadshade.engine.netlist import core_of, write_netlist
from quadshade.engine.sources import repository_root
from quadshade.engine.tool_runner import package_version
from quadshade.errors import QuadshadeError
from quadshade.synthesis import find_device
from quadshade.synthesis.cells import with_cells
from quadshade.synthesis.flow import YOSYS, run_yosys
from quadshade.synthesis.mapping import CHECKED, mapping_commands
from quadshade.synthesis.tool_reports import area_from_stat

DEVICE = "ecp5-25k-6"
STAT = "stat.json"


def no_tools(device: str = DEVICE) -> str:
    """
    Why cells cannot be counted here.

    Returns
    -------
    str
      Empty where GHDL, Yosys and the RTL are at hand.

    Raises
    ------
    QuadshadeError
      There is no such device.
    """
    find_device(device)
    try:
        package_version(YOSYS)
        write_netlist(Formats().core_generics())
    except QuadshadeError as problem:
        return str(problem)
    except OSError as problem:
        return f"GHDL does not run: {problem.strerror}"
    return ""


def count_cells(formats: Formats, device: str = DEVICE) -> dict[str, int]:
    """
    Map a core to a device's cells and count them; the result is kept below ``build/synth/counted``.

    Parameters
    ----------
    formats : Formats
    device : str
      One of :func:`quadshade.synthesis.devices.find_device`.

    Returns
    -------
    dict of str to int
      ``lut4`` (carry cells included), ``carry``, ``carry_luts``, ``ff``, ``bram``, ``dsp``.

    Raises
    ------
    QuadshadeError
      A tool is missing or fails.
    """
    root = repository_root()
    top, generics = core_of(formats)
    netlist = write_netlist(generics, top)
    verilog = with_cells(netlist.read_text(), find_device(device).family, root)
    commands = [
        f"read_verilog {netlist.name}",
        *find_device(device).described.library,
        f"hierarchy -check -top {top}",
        *CHECKED,
    ]
    commands += [*mapping_commands(find_device(device), top), f"tee -q -o {STAT} stat -json -top {top}"]

    def make(folder: Path) -> None:
        (folder / netlist.name).write_text(verilog)
        run_yosys(commands, folder)

    key = build_key(verilog, *commands, package_version(YOSYS))
    folder = build_once(root / "build" / "synth" / "counted", key, make)
    return asdict(
        area_from_stat(json.loads((folder / STAT).read_text()), find_device(device).described.counted)
    )
