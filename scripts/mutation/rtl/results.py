# SPDX-License-Identifier: Apache-2.0
"""What became of each mutant: a line of JSON each, appended, so that a run goes on where it was stopped."""

from __future__ import annotations

import contextlib
import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from scripts.mutation.rtl.benches import ROOT

BUILD = ROOT / "build" / "mutation"
RESULTS = BUILD / "results.jsonl"
CLEAN = BUILD / "clean.jsonl"
"""How long the benches' cases take on the clean RTL."""
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
    """The last result of every mutant, by its name."""
    return {line["name"]: Result(**line) for line in read_lines(path)}


def append(result: Result, path: Path = RESULTS) -> None:
    """Add what became of a mutant."""
    append_line(path, asdict(result))
