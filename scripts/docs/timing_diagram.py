# SPDX-License-Identifier: Apache-2.0
"""A unit's timing diagram: its ports, simulated, drawn by WaveDrom. ``diagrams.toml`` says which clocks."""

from __future__ import annotations

import json
import re
import tomllib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import wavedrom

from quadshade.engine.build_cache import build_key
from quadshade.errors import QuadshadeError
from scripts.docs import simulate_unit
from scripts.docs.entity import ROOT, Declaration, Unit

CACHE = ROOT / "build" / "docs_diagrams"
DECIMAL_BITS = 12
"""Wider values are shown in hexadecimal."""

FIRST_VALUE = re.compile(
    r'(<g id="wavelane_draw_\d+_0"[^>]*><use transform="translate\(0\)" xlink:href="#vvv-2" />(?:(?!</g>).)*?'
    r'<text text-anchor="middle" x=")(\d+)'
)
"""The text of a value that stands from the first clock on, which WaveDrom in Python draws too far left."""


@dataclass(frozen=True)
class Window:
    """
    Which clocks of which test a diagram shows.

    Attributes
    ----------
    config : dict
      Settings of the test's configuration that are not its defaults: small numbers are read more easily.
    test : str
      The cocotb test, as a regular expression of its name; the first one if empty.
    start : str
      A port: the diagram begins some clocks before it is first high.
    before : int
      How many clocks before.
    after : int
      Clocks before which that does not count; without a port, the first one shown.
    clocks : int
      How many are shown.
    ports : list of str
      In their order, inputs before outputs; all but the clock if empty.
    simulated : int
      Clocks of the simulation.
    text : str
      What is to be seen.
    """

    config: dict[str, int] = field(default_factory=dict)
    test: str = ""
    start: str = ""
    before: int = 1
    after: int = 1
    clocks: int = 16
    ports: list[str] = field(default_factory=list)
    simulated: int = 300
    text: str = ""


def windows() -> dict[str, Window]:
    """The window of every unit that ``diagrams.toml`` names."""
    tables = tomllib.loads((Path(__file__).parent / "diagrams.toml").read_text())
    return {name: Window(**table) for name, table in tables.items()}


def diagram(unit: Unit) -> str:
    """
    A unit's diagram as Markdown; combinational units have none.

    Raises
    ------
    QuadshadeError
      The simulation failed.
    """
    if "clk" not in {port.name for port in unit.ports}:
        return "There is no diagram: the unit is combinational, and its outputs follow its inputs at once."
    window = windows().get(unit.name, Window())
    stored = CACHE / f"{unit.name}-{_fingerprint(unit, window)}.svg"
    if not stored.is_file():
        values = simulate_unit.ports_per_clock(unit, window.config, window.test, window.simulated)
        CACHE.mkdir(parents=True, exist_ok=True)
        for old in CACHE.glob(f"{unit.name}-*.svg"):
            old.unlink()
        stored.write_text(_svg(unit, window, values))
    given = ", ".join(f"`{name}={value}`" for name, value in window.config.items())
    source = f"From a simulation of the VHDL by its own test{f', with {given}' if given else ''}."
    text = f"{' '.join(window.text.split())} {source}".strip()
    return f'<div class="wide wave" data-search-exclude>{stored.read_text()}</div>\n\n{text}'


def _fingerprint(unit: Unit, window: Window) -> str:
    """Changes with everything that the diagram is made of: the VHDL, tests, models, and how it is drawn."""
    folders = (ROOT / "rtl", ROOT / "cocotb_tests", ROOT / "model" / "quadshade" / "golden")
    files = sorted(path for folder in folders for path in folder.rglob("*.*"))
    files = [path for path in files if path.suffix in (".vhd", ".py", ".f")]
    return build_key(unit.name, repr(window), *files, Path(__file__), Path(simulate_unit.__file__))


def _svg(unit: Unit, window: Window, values: dict[str, list[str]]) -> str:
    """The picture, without WaveDrom's own style: the site's has the colours and the font."""
    first = _first_clock(window, values)
    if first + window.clocks > len(values["clk"]):
        raise QuadshadeError(f"{unit.name}: the diagram ends after the simulation", "simulate more clocks")
    shown = [port for port in unit.ports if port.name != "clk"]
    if window.ports:
        by_name = {port.name: port for port in unit.ports}
        shown = [by_name[name] for name in window.ports]
    lanes: list[Any] = [{"name": "clk", "wave": "p" + "." * (window.clocks - 1)}]
    for direction in ("in", "out"):
        group = [
            _lane(port, values[port.name][first : first + window.clocks])
            for port in shown
            if port.direction == direction
        ]
        lanes += [{}, [direction, *group]] if group else []
    longest = max((len(text) for lane in lanes for text in _texts(lane)), default=1)
    scale = 1 if longest <= 4 else 2 if longest <= 9 else 3
    source = {"signal": lanes, "config": {"hscale": scale}}
    picture = wavedrom.render(json.dumps(source)).tostring()
    picture = re.sub(r"<style.*?</style>", "", picture, flags=re.DOTALL)
    return re.sub(FIRST_VALUE, lambda found: f"{found[1]}{int(found[2]) + 20}", picture)


def _first_clock(window: Window, values: dict[str, list[str]]) -> int:
    if not window.start:
        return window.after
    high = [clock for clock, bits in enumerate(values[window.start]) if bits == "1" and clock >= window.after]
    if not high:
        raise QuadshadeError(
            f"{window.start} is never high", "choose other clocks in scripts/docs/diagrams.toml"
        )
    return max(0, high[0] - window.before)


def _lane(port: Declaration, bits: list[str]) -> dict[str, Any]:
    """A port's wave; a clock without a change has a dot."""
    wave, data = "", []
    for before, now in zip([None, *bits], bits, strict=False):
        if now == before:
            wave += "."
        elif set(now) - {"0", "1"}:
            wave += "x"
        elif port.kind == "std_ulogic":
            wave += now
        else:
            wave += "="
            data.append(_number(port, now))
    return {"name": port.name, "wave": wave, "data": data}


def _number(port: Declaration, bits: str) -> str:
    value = int(bits, 2)
    if len(bits) > DECIMAL_BITS:
        return f"{value:x}"
    return str(value - (int(bits[0]) << len(bits)) if port.kind == "u_signed" else value)


def _texts(lane: Any) -> list[str]:
    """All values that stand in a lane or a group of lanes."""
    if isinstance(lane, list):
        return [text for part in lane[1:] for text in _texts(part)]
    return lane.get("data", [])
