# SPDX-License-Identifier: Apache-2.0
"""The RTL's part of docs/reports/mutation.md, and its numbers in mutation_rtl.json."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Collection, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from textwrap import fill

from quadshade.engine.tool_runner import package_version, tool_command, tool_version
from quadshade.files.markdown import markdown_table
from scripts.mutation.report import score, write_numbers, write_section
from scripts.mutation.rtl.benches import cases_of, rtl_paths
from scripts.mutation.rtl.clean import usual_seconds
from scripts.mutation.rtl.results import NUMBERS, Result, publishable
from scripts.mutation.rtl.run_text import digest_of, own_units

REVIEWED = [Path(__file__).with_name(f"reviewed{kind}.toml") for kind in ("", "_netlist", "_netlist_link")]
HEADER = (
    "unit", "text", "netlist", "killed by its bench", "by one above", "equivalent, proved", "argued", "alive",
    "score, 95 % interval", "since",
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
    """Numbers of mutants; ``alive`` survived and are not reviewed; ``since`` is the oldest result's date."""

    text: int
    netlist: int
    own: int
    above: int
    proved: int
    argued: int
    alive: int
    since: str = ""

    def row(self, name: str) -> list[object]:
        """A row of the report's table."""
        numbers = [self.text, self.netlist, self.own, self.above, self.proved, self.argued, self.alive]
        return [name, *numbers, score(self.own + self.above, self.alive), self.since]

    @property
    def sampled(self) -> tuple[int, int]:
        """Mutants of text and of netlist."""
        return self.text, self.netlist


@dataclass(frozen=True)
class Earlier:
    """
    A unit's sample of which no more is kept than its numbers, and each mutant that was not killed.

    A mutant fewer that is known by its name was killed then, by the unit's own bench. A later run finds the
    names again, until it knows as many.
    """

    text: int
    netlist: int
    since: str

    def lost(self, found: Tally) -> tuple[int, int]:
        """Kills of text and of netlist that have no name."""
        return max(0, self.text - found.text), max(0, self.netlist - found.netlist)


def tallies(
    results: Collection[Result], argued: dict[str, Review], earlier: Mapping[str, Earlier]
) -> dict[str, Tally]:
    """The numbers of every unit of which any are known, and of all of them together, as ``all``."""
    found = {}
    for unit in rtl_paths():
        numbers = tally([result for result in results if result.unit == unit], argued)
        lost = earlier[unit].lost(numbers) if unit in earlier else (0, 0)
        if any(lost):
            numbers = replace(
                numbers,
                text=numbers.text + lost[0],
                netlist=numbers.netlist + lost[1],
                own=numbers.own + sum(lost),
                since=min(earlier[unit].since, numbers.since or earlier[unit].since),
            )
        if any(numbers.sampled):
            found[unit] = numbers
    parts = [asdict(numbers) for numbers in found.values()]
    sums = {name: sum(part[name] for part in parts) for name in asdict(tally([], {})) if name != "since"}
    since = min((part["since"] for part in parts), default="")
    return found | {"all": Tally(**sums, since=since)}


def tally(results: Collection[Result], argued: dict[str, Review]) -> Tally:
    """Count what became of mutants that have a name; the stillborn ones are left out."""
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
        min((result.date for result in found), default=""),
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


def missing(found: Mapping[str, Tally], asked: Mapping[str, tuple[int, int]]) -> str:
    """A sentence on what a sample that is not complete lacks; empty if it lacks nothing."""
    lacking = {}
    for unit, numbers in asked.items():
        there = found[unit].sampled if unit in found else (0, 0)
        lacks = sum(max(0, want - number) for want, number in zip(numbers, there, strict=True))
        if lacks:
            lacking[unit] = lacks
    if not lacking:
        return ""
    whole = sum(map(sum, asked.values()))
    units = ", ".join(f"{unit} {lacks}" for unit, lacks in lacking.items())
    return (
        f"The sample is not complete: of {whole} mutants {sum(lacking.values())} were not run yet ({units})."
    )


def unnamed(results: Collection[Result], earlier: Mapping[str, Earlier]) -> str:
    """A sentence on kills of which only the number is kept; empty if there are none."""
    lost = {}
    for unit, numbers in earlier.items():
        lost[unit] = sum(numbers.lost(tally([result for result in results if result.unit == unit], {})))
    number, units = sum(lost.values()), ", ".join(unit for unit in lost if lost[unit])
    if not number:
        return ""
    return (
        f"Of {number} of those killed only the number is kept, and their benches may have changed since: "
        f"a run of their units names them ({units})."
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
    results: Sequence[Result],
    seed: int,
    candidates: int,
    asked: Mapping[str, tuple[int, int]],
    earlier: Mapping[str, Earlier],
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
    earlier : mapping
      Samples of units of which not every mutant's name is kept.
    """
    argued = reviews()
    found = tallies(results, argued, earlier)
    whole = found["all"]
    survivors = [result for result in results if result.verdict == "survived"]
    tools = ", ".join(
        [
            tool_version(tuple(tool_command("GHDL"))).splitlines()[0],
            *map(package_version, ("cocotb", "pyosys")),
        ]
    )
    conditions = fill(
        f"Written by `make mutation`, with seed {seed}: of {candidates} changes of the VHDL's text and of "
        f"what Yosys' `mutate` finds in the netlists. What is no hardware is not counted. "
        "A netlist is of one configuration of its bench. A bench runs with its own seed, 1, and ends at its "
        "first fault; a mutant is killed too where one "
        f"takes over four times the clean run's simulated time. {tools}. "
        + " ".join(filter(None, [changed(results), unnamed(results, earlier), missing(found, asked)])),
        130,
    )
    parts = [
        f"**{score(whole.own + whole.above, whole.alive)}** of those that are not equivalent are killed.",
        conditions,
        markdown_table(HEADER, [numbers.row(name) for name, numbers in found.items()], right=HEADER[1:]),
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
            "From `reviewed.toml` and `reviewed_netlist*.toml` in `scripts/mutation/rtl`.",
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
    before = json.loads(NUMBERS.read_text())
    earlier = {unit: Earlier(**numbers) for unit, numbers in before["earlier"].items()}
    again = {entry["unit"]: entry for entry in before["kill_again"]}
    for unit in rtl_paths():
        cases = {case.name: case for own in own_units(unit) for case in cases_of(own)}
        killed = [result for result in results if result.unit == unit and result.by in cases]
        killed = [one for one in killed if (one.source, one.verdict, one.stage) == ("text", "killed", "own")]
        if killed and again.get(unit, {}).get("name") not in {one.name for one in killed}:
            quickest = min(killed, key=lambda result: usual_seconds(cases[result.by]))
            again[unit] = {"unit": unit, "name": quickest.name, "case": quickest.by}
    found = tallies(results, reviews(), earlier)
    lost = {unit for unit, numbers in earlier.items() if unnamed(results, {unit: numbers})}
    content = {
        "seed": seed,
        "candidates": candidates,
        "all": asdict(found["all"]),
        "units": {unit: asdict(numbers) for unit, numbers in found.items() if unit != "all"},
        "earlier": {unit: asdict(earlier[unit]) for unit in sorted(lost)},
        "kill_again": sorted(again.values(), key=lambda entry: entry["unit"]),
        **publishable(results),
    }
    write_section("rtl", section(results, seed, candidates, asked, earlier))
    write_numbers(NUMBERS, content)
