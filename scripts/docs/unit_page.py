# SPDX-License-Identifier: Apache-2.0
"""The page of an RTL unit, and the list of all units, as Markdown with links as in the repository."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path

from quadshade.contract.formats import GENERIC_HELP
from scripts.docs.entity import ROOT, Declaration, Unit

STAGES = {
    "common": "memories, checks and buffers that several stages use",
    "core": "set-up words to pixels",
    "shade": "interpolated cosines to colours",
    "screen": "pixels to a picture, and what can be read of it",
    "link": "the bytes of the line to words, and answers to bytes",
    "": "everything between two serial pins",
}
"""Folders of ``rtl/``, in the order of the list."""

PAGES = Path("docs/reference/units")
"""Where the pages stand; links are relative to it."""

UP = "../../.."


def unit_page(unit: Unit, all_units: dict[str, Unit], diagram: str) -> str:
    """
    The page of one unit.

    Parameters
    ----------
    unit : Unit
    all_units : dict of Unit
    diagram : str
      Markdown of the section on timing: the picture, or why there is none.
    """
    users = [other.name for other in all_units.values() if unit.name in other.parts]
    sections = [
        f"# {unit.name}",
        unit.purpose,
        _related("Made of", unit.parts),
        _related("Used in", users),
        "## Timing",
        unit.timing,
        diagram,
        "## Generics",
        generics_table(unit.generics),
        "## Ports",
        ports_table(unit.ports),
        "## Resources",
        _resources(unit.name),
        "## Sources",
        _sources(unit),
    ]
    return "\n\n".join(section for section in sections if section) + "\n"


def units_page(all_units: dict[str, Unit]) -> str:
    """The list of all units, folder by folder."""
    lines = ["# RTL units", "", "A page for every entity below `rtl/`, written from its VHDL.", ""]
    for stage, holds in STAGES.items():
        lines += [f"## {f'rtl/{stage}' if stage else 'rtl'}", "", f"{holds[0].upper()}{holds[1:]}.", ""]
        lines += ["| unit | what it does |", "| --- | --- |"]
        members = [unit for unit in all_units.values() if unit.stage == stage]
        lines += [f"| [`{unit.name}`]({unit.name}.md) | {_cell(unit.first_sentence)} |" for unit in members]
        lines.append("")
    return "\n".join(lines)


def _related(title: str, names: list[str]) -> str:
    links = ", ".join(f"[`{name}`]({name}.md)" for name in names)
    return f"{title}: {links}." if names else ""


def _cell(text: str) -> str:
    """Text that may stand in a table."""
    return text.replace("|", "\\|")


def generics_table(generics: list[Declaration]) -> str:
    """The generics of a unit, a row each."""
    if not generics:
        return "None."
    # Units that only hand a generic on leave its meaning to the contract.
    meanings = [g.meaning or GENERIC_HELP.get(g.name, "") for g in generics]
    rows = [
        f"| `{g.name}` | `{g.kind}` | `{g.default}` | {_cell(meaning)} |"
        for g, meaning in zip(generics, meanings, strict=True)
    ]
    return "\n".join(["| name | type | default | meaning |", "| --- | --- | ---: | --- |", *rows])


def ports_table(ports: list[Declaration]) -> str:
    """The ports of a unit, a row each."""
    rows = [
        f"| `{p.name}` | {p.direction} | `{p.kind}` | `{_cell(p.width)}` | {_cell(p.meaning)} |"
        for p in ports
    ]
    return "\n".join(
        ["| name | direction | type | bits | meaning |", "| --- | --- | --- | ---: | --- |", *rows]
    )


def _resources(name: str) -> str:
    """What place-and-route counted, from the tables in the repository."""
    rows = []
    for row in json.loads((ROOT / "docs/reports/screen.json").read_text())["rows"]:
        if row["unit"] == name:
            rows.append((row["device"], row["generics"], row, row["fmax_mhz"]))
    if name == "raster_core":
        for row in json.loads((ROOT / "synth/resources.json").read_text())["rows"]:
            rows.append((row["device"], row["generics"], row["area"], row["fmax_mhz"]))
    if name == "board":
        return f"Those of each board's bitstream stand in the [report]({UP}/docs/reports/bitstream.md)."
    if not rows:
        return "Not measured alone: the tables hold the [core](raster_core.md) and the units of the screen."
    lines = [
        "| device | generics that are not defaults | LUT4 | flip-flops | block RAM | multipliers | MHz |",
        "| --- | --- | ---: | ---: | ---: | ---: | ---: |",
    ]
    for device, generics, area, clock in rows:
        given = ", ".join(f"`{key}={value}`" for key, value in generics.items())
        counts = " | ".join(f"{area[kind]:,}" for kind in ("lut4", "ff", "bram", "dsp"))
        lines.append(f"| {device} | {given} | {counts} | {clock or 'not placed'} |")
    return "\n".join(lines)


def _sources(unit: Unit) -> str:
    """Links to the VHDL, model, test and proofs."""
    (model,) = (ROOT / "model/quadshade/golden").rglob(f"{unit.name}.py")
    (test,) = (ROOT / "cocotb_tests").rglob(f"test_{unit.name}.py")
    links = [("VHDL", unit.path), ("model", model), ("test", test)]
    rows = [f"- {what}: [`{path.relative_to(ROOT)}`]({UP}/{path.relative_to(ROOT)})" for what, path in links]
    for table in sorted((ROOT / "formal").glob("*/proofs.toml")):
        for name, proof in tomllib.loads(table.read_text()).items():
            if unit.name in proof.get("units", []):
                where = table.relative_to(ROOT)
                rows.append(f"- proof: {proof['claim']} (`{name}` of [`{where}`]({UP}/{where}))")
    return "\n".join(rows)
