# SPDX-License-Identifier: Apache-2.0
"""The RTL's part of docs/reports/mutation.md, and its numbers in mutation_rtl.json."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from textwrap import fill

from quadshade.engine.tool_runner import package_version, tool_command, tool_version
from quadshade.files.atomic import write_json
from quadshade.files.markdown import markdown_table
from scripts.mutation.report import REPORT, score, write_section
from scripts.mutation.rtl.benches import cases_of, rtl_paths
from scripts.mutation.rtl.clean import usual_seconds
from scripts.mutation.rtl.results import Result
from scripts.mutation.rtl.run_text import digest_of, own_units

REVIEWED = [Path(__file__).with_name(f"reviewed{kind}.toml") for kind in ("", "_netlist")]
NUMBERS = REPORT.with_name("mutation_rtl.json")
HEADER = (
    "unit", "text", "netlist", "killed by its bench", "by one above", "equivalent, proved", "argued", "alive",
    "score, 95 % interval",
)  # fmt: skip
SHOWN = 110


@dataclass(frozen=True)
class Review:
    """Why a mutant that survives can be noticed by no test; its line and change are there for the reader."""

    name: str
    file: str
    original: str
    what: str
    reason: str


def reviews() -> dict[str, Review]:
    """Every entry of the reviewed lists, by the mutant's name."""
    entries = [entry for path in REVIEWED for entry in tomllib.loads(path.read_text()).get("mutant", [])]
    return {entry["name"]: Review(**entry) for entry in entries}


@dataclass(frozen=True)
class Tally:
    """Numbers of mutants; ``alive`` are those that survived and are not reviewed."""

    text: int
    netlist: int
    own: int
    above: int
    proved: int
    argued: int
    alive: int

    def row(self, name: str) -> list[object]:
        """A row of the report's table."""
        numbers = [self.text, self.netlist, self.own, self.above, self.proved, self.argued, self.alive]
        return [name, *numbers, score(self.own + self.above, self.alive)]


def tally(results: Iterable[Result], argued: dict[str, Review]) -> Tally:
    """Count what became of mutants; the stillborn ones are left out."""
    found = [result for result in results if result.verdict != "stillborn"]
    killed = [result.stage for result in found if result.verdict == "killed"]
    survivors = [result for result in found if result.verdict == "survived"]
    reviewed = sum(result.name in argued for result in survivors)
    return Tally(
        sum(result.source == "text" for result in found),
        sum(result.source == "netlist" for result in found),
        killed.count("own"),
        killed.count("above"),
        sum(result.verdict == "equivalent" for result in found),
        reviewed,
        len(survivors) - reviewed,
    )


def _cell(text: str) -> str:
    """Text as a cell of a table: code in it stays code, and nothing ends the cell."""
    short = text if len(text) <= SHOWN else text[: SHOWN - 3] + "..."
    return short.replace("|", "\\|")


def _listed(results: Sequence[Result], argued: dict[str, Review]) -> str:
    rows = []
    for result in sorted(results, key=lambda result: (result.unit, result.line, result.name)):
        place = result.original if result.source == "text" else f"netlist, {result.original}"
        row = [result.unit, f"`{_cell(place)}`", _cell(result.what)]
        rows.append([*row, argued[result.name].reason] if result.name in argued else row)
    reason = ["reason"] * any(len(row) > 3 for row in rows)
    return markdown_table(["unit", "line", "change", *reason], rows)


def missing(results: Sequence[Result], asked: Mapping[str, tuple[int, int]]) -> str:
    """A sentence on what a sample that is not complete lacks; empty if it lacks nothing."""
    lacking = {}
    for unit, numbers in asked.items():
        found = tally([result for result in results if result.unit == unit], {})
        lacks = max(0, numbers[0] - found.text) + max(0, numbers[1] - found.netlist)
        if lacks:
            lacking[unit] = lacks
    if not lacking:
        return ""
    whole = sum(map(sum, asked.values()))
    units = ", ".join(f"{unit} {lacks}" for unit, lacks in lacking.items())
    return (
        f"The sample is not complete: of {whole} mutants {sum(lacking.values())} were not run yet ({units})."
    )


def changed(results: Sequence[Result]) -> str:
    """A sentence on kills by benches that have changed since; empty if there are none."""
    today = {unit: digest_of(own_units(unit)) for unit in {result.unit for result in results}}
    killed = [result for result in results if (result.verdict, result.stage) == ("killed", "own")]
    number = sum(result.benches != today[result.unit] for result in killed)
    if not number:
        return ""
    return f"{number} of those killed were killed by benches that have changed since."


def section(
    results: Sequence[Result], seed: int, candidates: int, asked: Mapping[str, tuple[int, int]]
) -> str:
    """
    The report's text.

    Parameters
    ----------
    results : sequence of Result
    seed : int
      Of the sample.
    candidates : int
      Places and changes of text that the sample was drawn from.
    asked : mapping
      Mutants of text and of netlist that the sample has of each unit, if it has as many.
    """
    argued = reviews()
    whole = tally(results, argued)
    units = [unit for unit in rtl_paths() if any(result.unit == unit for result in results)]
    rows = [tally([r for r in results if r.unit == unit], argued).row(unit) for unit in units]
    survivors = [result for result in results if result.verdict == "survived"]
    stillborn = sum(result.verdict == "stillborn" for result in results)
    tools = ", ".join(
        [
            tool_version(tuple(tool_command("GHDL"))).splitlines()[0],
            *map(package_version, ("cocotb", "pyosys")),
        ]
    )
    conditions = fill(
        f"Written by `make mutation`, with seed {seed}: of {candidates} changes of the VHDL's text and of "
        f"what Yosys' `mutate` finds in the netlists. {stillborn} more were no hardware and are not counted. "
        "A netlist is of one configuration of its bench. A bench runs with its own seed, 1, and ends at its "
        "first fault; a mutant is killed too where one "
        f"takes over four times the clean run's simulated time. {tools}. {changed(results)} "
        f"{missing(results, asked)}",
        130,
    )
    parts = [
        f"**{score(whole.own + whole.above, whole.alive)}** of those that are not equivalent are killed.",
        conditions,
        markdown_table(HEADER, [*rows, whole.row("all")], right=HEADER[1:]),
    ]
    alive = [result for result in survivors if result.name not in argued]
    if alive:
        parts += [
            "### Alive",
            "No test notices these, and nothing shows that none could.",
            _listed(alive, argued),
        ]
    known = [result for result in survivors if result.name in argued]
    if known:
        parts += [
            "### Equivalent by argument",
            "From `reviewed.toml` and `reviewed_netlist.toml` in `scripts/mutation/rtl`.",
            _listed(known, argued),
        ]
    proofs = [result for result in results if result.verdict == "equivalent"]
    if proofs:
        said = (
            "Both netlists do the same, by temporal induction: of a change of text in every configuration of "
            "the unit's bench."
        )
        parts += ["### Equivalent by proof", said, _listed(proofs, {})]
    return "\n\n".join(parts)


def write(
    results: Sequence[Result], seed: int, candidates: int, asked: Mapping[str, tuple[int, int]]
) -> None:
    """Write the section, and the numbers with a killed mutant of each unit for the tests to kill again."""
    argued = reviews()
    again = []
    for unit in rtl_paths():
        cases = {case.name: case for own in own_units(unit) for case in cases_of(own)}
        killed = [result for result in results if result.unit == unit and result.by in cases]
        killed = [one for one in killed if (one.source, one.verdict, one.stage) == ("text", "killed", "own")]
        if killed:
            quickest = min(killed, key=lambda result: usual_seconds(cases[result.by]))
            again.append({"unit": unit, "name": quickest.name, "case": quickest.by})
    kept = [asdict(result) for result in results if result.verdict in ("survived", "equivalent")]
    content = {
        "seed": seed,
        "candidates": candidates,
        "all": asdict(tally(results, argued)),
        "units": {
            unit: asdict(tally([r for r in results if r.unit == unit], argued))
            for unit in sorted(rtl_paths())
        },
        "kill_again": again,
        "not_killed": sorted(kept, key=lambda one: (one["unit"], one["line"], one["name"])),
    }
    write_section("rtl", section(results, seed, candidates, asked))
    write_json(NUMBERS, content)
