# SPDX-License-Identifier: Apache-2.0
"""A sample of the mutants that the report says are killed, run again by the very tests that killed them."""

from __future__ import annotations

import functools
import hashlib
import json
import tempfile
from collections.abc import Iterator
from itertools import islice
from pathlib import Path

from scripts.mutation.python.mutants import Mutant, changed_lines, mutants_of, mutated
from scripts.mutation.python.report import NUMBERS, ROOT

PACKAGE = ROOT / "model" / "quadshade"
SLOW = 0.4
"""Seconds of processor time: a test that takes longer, all loops interpreted, is not run."""
DRAWN = 3
"""Mutants drawn for each that is run: of some the tests are slow, or the line has changed since."""


@functools.cache
def _of_file(path: str) -> list[Mutant]:
    return mutants_of(PACKAGE / path, PACKAGE)


def _found(entry: dict[str, str]) -> Mutant | None:
    """The mutant that an entry of the report is about, if the line is still what it was."""
    target = PACKAGE / entry["path"]
    if not target.exists():
        return None
    source = target.read_text()
    lines = source.splitlines()
    for mutant in _of_file(entry["path"]):
        if (mutant.operator, mutant.where) != (entry["operator"], entry["where"]):
            continue
        # Much quicker than to make every mutant.
        if lines[mutant.line - 1].strip() not in entry["old"]:
            continue
        if changed_lines(source, mutated(mutant, source)) == (entry["old"], entry["new"]):
            return mutant
    return None


def _is_there(test: str) -> bool:
    """Whether a test is still in the file that it was in."""
    name, _, function = test.partition("::")
    path = ROOT / name
    return bool(function) and path.exists() and f"def {function.split('[')[0]}(" in path.read_text()


def recorded(seed: int) -> Iterator[tuple[Mutant, str]]:
    """Killed mutants in an order that the seed repeats, each with the test that killed it."""

    def rank(entry: dict[str, str]) -> bytes:
        text = [str(seed), *(entry[name] for name in ("path", "where", "old", "new"))]
        return hashlib.sha256("\0".join(text).encode()).digest()

    for entry in sorted(json.loads(NUMBERS.read_text())["mutants"], key=rank):
        # What a loop that is left out should have written may be what an array of np.empty holds by chance.
        if entry["state"] != "killed" or entry["operator"] == "ZeroIterationForLoop":
            continue
        if _is_there(entry["test"]):
            mutant = _found(entry)
            if mutant:
                yield mutant, entry["test"]


def run_kept(count: int, seed: int) -> tuple[int, list[Mutant]]:
    """
    Run mutants again that were killed.

    Parameters
    ----------
    count, seed : int
      At most how many, and which.

    Returns
    -------
    run : int
      How many were run.
    survivors : list of Mutant
      Those that no test notices any more.

    Raises
    ------
    RuntimeError
      The tests cannot be collected, or fail without a change.
    """
    from scripts.mutation.python.runner import Session, run_session

    chosen = list(islice(recorded(seed), DRAWN * count))
    run: list[Mutant] = []
    survivors: list[Mutant] = []

    def work(session: Session) -> None:
        quick = {item.nodeid for item in session.items}
        for mutant, _ in islice((pair for pair in chosen if pair[1] in quick), count):
            run.append(mutant)
            if session.run(mutant).state == "survived":
                survivors.append(mutant)

    tests = sorted({test for _, test in chosen})
    with tempfile.TemporaryDirectory() as folder:
        problem = run_session(ROOT, Path(folder), ("",), tests, SLOW, work)
    if problem:
        raise RuntimeError(problem)
    return len(run), survivors
