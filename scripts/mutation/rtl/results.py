# SPDX-License-Identifier: Apache-2.0
"""
What became of each mutant: a line of JSON each, appended, so that a run goes on where it was stopped.

The report's numbers hold it too, in fewer bytes, so that a run goes on from another machine's.
"""

from __future__ import annotations

import contextlib
import datetime
import json
from collections.abc import Iterable
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from scripts.mutation.report import REPORT
from scripts.mutation.rtl.benches import ROOT

BUILD = ROOT / "build" / "mutation"
RESULTS = BUILD / "results.jsonl"
CLEAN = BUILD / "clean.jsonl"
"""How long the benches' cases take on the clean RTL."""
NUMBERS = REPORT.with_name("mutation_rtl.json")
"""The report's numbers: ``named`` are results whose text is of no more use, many names each; ``not_killed``
the others, whole."""
SHARED = ("unit", "original", "source", "verdict", "by", "stage", "benches", "seed", "date")
"""What results of one entry of ``named`` have in common; ``original`` of a netlist only."""
OUTDATED = "outdated"
"""Verdict on a mutant of a netlist that is another by now: it counts nowhere."""


@dataclass(frozen=True)
class Result:
    """
    A mutant and its fate.

    Attributes
    ----------
    name, unit, file, line, kind, original, what
      Of the mutant; ``file`` is empty for one of a netlist, whose ``original`` is its configuration.
    source : str
      ``text`` or ``netlist``.
    verdict : str
      ``killed``, ``survived``, ``equivalent``, ``stillborn``: no hardware can be made of it, or
      ``OUTDATED``.
    by : str
      The case that killed it, or how it was proved.
    detail : str
      What the first failing test said.
    stage : str
      ``own`` or ``above``: whose bench killed it; how far a survivor came: ``own``, ``proof``, ``above``.
    benches : str
      Digest of the benches of its stage.
    seed : int
      Of the sample.
    date : str
      Of the day when it was found.
    """

    name: str
    unit: str
    file: str
    line: int
    kind: str
    original: str
    what: str
    source: str
    verdict: str
    by: str = ""
    detail: str = ""
    stage: str = "own"
    benches: str = ""
    seed: int = 1
    date: str = field(default_factory=lambda: datetime.date.today().isoformat())


def read_lines(path: Path) -> list[dict[str, Any]]:
    """Every whole line of a file of JSON lines; one that a kill cut off is left out."""
    found = []
    for line in path.read_text().splitlines() if path.is_file() else []:
        with contextlib.suppress(json.JSONDecodeError):
            found.append(json.loads(line))
    return found


def append_line(path: Path, content: dict[str, Any]) -> None:
    """Add a line; one write, so that processes do not mix theirs."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("a") as file:
        file.write(json.dumps(content) + "\n")


def load(path: Path = RESULTS) -> dict[str, Result]:
    """The last result of every mutant in a file of lines, by its name."""
    return {line["name"]: Result(**line) for line in read_lines(path)}


def known(numbers: Path = NUMBERS, path: Path = RESULTS) -> dict[str, Result]:
    """The last result of every mutant: what was published, and what was found here since."""
    return published(json.loads(numbers.read_text())) | load(path)


def published(content: dict[str, Any]) -> dict[str, Result]:
    """The results that the report's numbers hold; of those in ``named`` line and change are empty."""
    found = [Result(**one) for one in content["not_killed"]]
    for shared in content["named"]:
        names = shared.pop("names").split()
        found += [Result(name=name, file="", line=0, kind="", what="", **shared) for name in names]
    return {result.name: result for result in found}


def publishable(results: Iterable[Result]) -> dict[str, list[dict[str, Any]]]:
    """Results as :func:`published` reads them, for the report's numbers."""
    whole, alike = [], {}
    for result in sorted(results, key=lambda one: (one.unit, one.line, one.name)):
        content = asdict(result)
        if result.verdict in ("survived", "equivalent"):
            whole.append(content)
            continue
        if result.source == "text":
            content["original"] = ""
        alike.setdefault(tuple(content[name] for name in SHARED), []).append(result.name)
    named = [
        dict(zip(SHARED, shared, strict=True)) | {"names": " ".join(names)} for shared, names in alike.items()
    ]
    return {"not_killed": whole, "named": named}


def append(result: Result, path: Path = RESULTS) -> None:
    """Add what became of a mutant."""
    append_line(path, asdict(result))
