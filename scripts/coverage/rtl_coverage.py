# SPDX-License-Identifier: Apache-2.0
"""Statements and branches of the RTL that the benches ran, and the lines that need not be run."""

from __future__ import annotations

import tomllib
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from cocotb_tests.support.cover import SOURCES
from quadshade.engine.build_cache import build_key
from scripts.coverage.arcs import Function, read_counters, read_graph
from scripts.coverage.vhdl_lines import assertion_lines, decision_lines

KINDS = ("statement", "branch")


@dataclass
class FileCoverage:
    """
    What was run of a file.

    Attributes
    ----------
    statements : dict of int to int
      How often each line was executed, by its number.
    branches : dict of int to list of int
      How often each way of a line's decisions was gone.
    """

    statements: dict[int, int] = field(default_factory=dict)
    branches: dict[int, list[int]] = field(default_factory=dict)

    def missing(self, kind: str) -> Counter[int]:
        """Lines that were not executed, or from which ways were not gone, with their number."""
        if kind == "statement":
            return Counter(line for line, count in self.statements.items() if not count)
        return Counter(
            {
                line: counts.count(0)
                for line, counts in self.branches.items()
                # A decision that was never reached is a statement that is missing.
                if 0 in counts and self.statements.get(line)
            }
        )

    def total(self, kind: str) -> int:
        """Lines, or ways."""
        if kind == "statement":
            return len(self.statements)
        return sum(map(len, self.branches.values()))


def read_counts(data: Path, libraries: Path, sources: Sequence[Path]) -> list[Function]:
    """
    Every function of the RTL with its counts, over all units' programs and runs.

    Parameters
    ----------
    data : Path
      A folder for each unit's library, with the counters of its runs.
    libraries : Path
      The libraries, with the graphs.
    sources : sequence of Path
      What they were compiled from.

    Raises
    ------
    ValueError
      There are no counts, or they are of other sources, or two units compiled one to different code.
    """
    now = build_key(*sources)
    if not list(data.glob("*/*.gcda")):
        raise ValueError(f"{data} has no counts")
    graphs: dict[tuple[str, int], Function] = {}
    sums: dict[tuple[str, int], list[int]] = {}
    for path in sorted(data.glob("*/*.gcda")):
        if path.stem.startswith("e~"):
            continue
        if (path.parent / SOURCES).read_text() != now:
            raise ValueError(f"{path.parent} was run on other sources")
        graph = read_graph(libraries / path.parent.name / f"{path.stem}.gcno")
        for number, (checksum, counters) in read_counters(path).items():
            key = path.stem, number
            known = graphs.setdefault(key, graph[number])
            if known.checksum != checksum:
                raise ValueError(f"{path}: {known.name} was compiled from another source")
            old = sums.get(key, [0] * len(counters))
            sums[key] = [one + more for one, more in zip(old, counters, strict=True)]
    for key, function in graphs.items():
        function.solve(sums[key])
    return list(graphs.values())


def coverage_of(
    functions: Iterable[Function], root: Path, sources: Sequence[Path]
) -> dict[str, FileCoverage]:
    """
    Coverage of every source, by its path below the root.

    A file that nothing ran has no lines here; :func:`check` says so. Lines of assertions count as executed
    where they were reached, whatever they would have said; their conditions are no branches.
    """
    found = {str(path.relative_to(root)): FileCoverage() for path in sources}
    texts = {name: (root / name).read_text() for name in found}
    decisions = {name: decision_lines(text) for name, text in texts.items()}
    messages = {name: assertion_lines(text) for name, text in texts.items()}
    names = {str(path): str(path.relative_to(root)) for path in sources}
    for function in functions:
        for (path, line), count in function.executed().items():
            if (name := names.get(path)) and not (line in messages[name] and not count):
                lines = found[name].statements
                lines[line] = max(lines.get(line, 0), count)
        for (path, line), count in function.branches():
            if (name := names.get(path)) and line in decisions[name] - messages[name]:
                found[name].branches.setdefault(line, []).append(count)
    return found


def read_exceptions(path: Path) -> list[dict[str, str]]:
    """Lines that need not be run, each with its reason."""
    return tomllib.loads(path.read_text()).get("exception", [])


def check(
    found: Mapping[str, FileCoverage], exceptions: Sequence[Mapping[str, str]], root: Path
) -> tuple[list[str], Counter[tuple[str, str]]]:
    """
    What was not run and has no reason, and reasons without a line.

    Parameters
    ----------
    found : mapping of str to FileCoverage
    exceptions : sequence of mappings
      ``file``, ``line`` (its text, without blanks around it), ``kind``, ``why``; a ``branch`` has ``ways``
      too, their number on each such line.
    root : Path

    Returns
    -------
    list of str, Counter
      A sentence each; and how many were excused, by file and kind.
    """
    faults: list[str] = []
    excused: Counter[tuple[str, str]] = Counter()
    used: set[int] = set()
    for name, file in found.items():
        text = (root / name).read_text().splitlines()
        if not file.statements:
            faults.append(f"{name}: nothing of it was run")
        for kind in KINDS:
            for line, ways in sorted(file.missing(kind).items()):
                source = text[line - 1].strip()
                reasons = {
                    number
                    for number, row in enumerate(exceptions)
                    if (row["file"], row["line"], row["kind"]) == (name, source, kind)
                    and (kind == "statement" or row["ways"] == ways)
                }
                used |= reasons
                if reasons:
                    excused[name, kind] += ways
                else:
                    what = "not executed" if kind == "statement" else f"{ways} ways not gone"
                    faults.append(f"{name}:{line}: {what}: {source}")
    for number, row in enumerate(exceptions):
        if number not in used:
            faults.append(f"{row['file']}: the reason for {row['line']!r} ({row['kind']}) has no such line")
    return faults, excused
