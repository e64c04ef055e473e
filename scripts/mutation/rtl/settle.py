# SPDX-License-Identifier: Apache-2.0
"""Which mutants of a unit are run, and by what: its own bench, a proof, the benches of the units above it."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Callable, Collection
from dataclasses import replace
from pathlib import Path

from scripts.mutation.rtl import results as store
from scripts.mutation.rtl.benches import above, cases_of, rtl_paths
from scripts.mutation.rtl.report import reviews
from scripts.mutation.rtl.results import BUILD, OUTDATED, Result
from scripts.mutation.rtl.run_netlist import NetlistRun
from scripts.mutation.rtl.run_text import TextRun, digest_of, own_units, sampled

STEPS = ("own", "netlist", "proof", "above")
"""Text on the own bench, netlists on it, proofs of what survives, benches of the units above."""

TEXT_SHARE = 0.5
LEAST_TEXT, LEAST_NETLIST = 20, 30
"""Mutants of a unit at least, or as many as it has."""


def counts(total: int, seed: int) -> dict[str, tuple[int, int]]:
    """How many mutants of each unit's text and netlist a sample of ``total`` has, in their proportion."""
    places = {unit: len(sampled(unit, seed)) for unit in rtl_paths()}
    every = sum(places.values())
    shares = {unit: total * number / every for unit, number in places.items()}
    return {
        unit: (
            min(max(LEAST_TEXT, round(TEXT_SHARE * share)), places[unit]),
            max(LEAST_NETLIST, round((1 - TEXT_SHARE) * share)) if cases_of(unit) else 0,
        )
        for unit, share in shares.items()
    }


def alive(name: str, known: dict[str, Result]) -> bool:
    """Whether a mutant counts: hardware can be made of it."""
    return name in known and known[name].verdict != "stillborn"


def tried(result: Result, old: Result | None) -> Result:
    """A mutant that survives again, after a proof in vain, needs no other: its netlists are the same."""
    again = old is not None and result.verdict == old.verdict == "survived" and old.stage != "own"
    return replace(result, stage="proof") if again else result


class Settling:
    """
    Goes through one unit's sample, and appends what becomes of each mutant.

    Parameters
    ----------
    unit : str
    counts : tuple of int
      Mutants of its text and of its netlist that hardware can be made of.
    seed : int
    steps : collection of str
      Of ``STEPS``.
    again : bool
      Whether what was killed is run once more where the benches are others by now, as survivors always are:
      a changed bench draws other random numbers, and need not kill what it once did.
    report : callable
      Called with every new result.
    """

    def __init__(
        self,
        unit: str,
        counts: tuple[int, int],
        seed: int,
        steps: Collection[str],
        again: bool,
        report: Callable[[Result], None],
    ) -> None:
        self.unit, self.counts, self.seed, self.steps = unit, counts, seed, steps
        self.again, self.report = again, report
        self.known, self.argued = store.known(), reviews()
        self.own_benches = digest_of(own_units(unit))
        self.above_benches = f"{self.own_benches}+{digest_of(above(unit))}"

    def _keep(self, result: Result) -> Result:
        store.append(result)
        self.known[result.name] = result
        self.report(result)
        return result

    def stale(self, old: Result) -> bool:
        """Whether an earlier result is to be found anew, with the benches of today: no argued one is."""
        if old.benches.startswith(self.own_benches) or old.name in self.argued:
            return False
        return old.verdict == "survived" or (self.again and (old.verdict, old.stage) == ("killed", "own"))

    def run(self) -> None:
        """All steps that are asked for and not done yet."""
        BUILD.mkdir(parents=True, exist_ok=True)
        folder = Path(tempfile.mkdtemp(dir=BUILD, prefix=f"{self.unit}_"))
        try:
            self._text(folder)
            if "netlist" in self.steps and self.counts[1]:
                self._netlist(folder)
        finally:
            shutil.rmtree(folder, ignore_errors=True)

    def _text(self, folder: Path) -> None:
        run = None
        mutants = sampled(self.unit, self.seed)
        living = 0
        chosen = []
        for mutant in mutants:
            if living == self.counts[0]:
                break
            old = self.known.get(mutant.name)
            new = old is None and "own" in self.steps
            if new or (old is not None and self.stale(old) and "own" in self.steps):
                run = run or TextRun(self.unit, folder)
                self._keep(tried(run.own(mutant, self.seed), old))
            chosen.append(mutant)
            living += alive(mutant.name, self.known)
        for step in ("proof", "above"):
            for mutant in chosen if step in self.steps else []:
                result = self.known.get(mutant.name)
                if result is None or result.verdict != "survived" or result.name in self.argued:
                    continue
                if step == "proof" and result.stage == "own":
                    run = run or TextRun(self.unit, folder)
                    self._keep(run.prove(mutant, result))
                if step == "above" and result.benches != self.above_benches and above(self.unit):
                    run = run or TextRun(self.unit, folder)
                    self._keep(replace(run.above(mutant, self.seed), benches=self.above_benches))

    def _netlist(self, folder: Path) -> None:
        before = [one for one in self.known.values() if (one.unit, one.source) == (self.unit, "netlist")]
        label = before[0].original if before else ""
        run = NetlistRun(self.unit, folder, self.counts[1], self.seed, label)
        there = {mutant.name for mutant in run.mutants}
        for old in before:
            if old.name not in there and old.verdict != OUTDATED:
                self._keep(replace(old, verdict=OUTDATED, detail="of another netlist or sample"))
        todo = []
        for mutant in run.mutants:
            old = self.known.get(mutant.name)
            if old is None or old.verdict == OUTDATED or self.stale(old):
                todo.append(mutant)
        for result in run.own(todo):
            found = replace(result, benches=self.own_benches)
            self._keep(tried(found, self.known.get(result.name)))
        for mutant in run.mutants if "proof" in self.steps else []:
            old = self.known.get(mutant.name)
            waits = old is not None and old.verdict == "survived" and old.stage == "own"
            if waits and mutant.name not in self.argued:
                self._keep(run.prove(mutant, old))
