# SPDX-License-Identifier: Apache-2.0
"""A unit's mutants of VHDL text: against its own bench, a proof, and the benches of the units above it."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from quadshade.errors import QuadshadeError
from scripts.mutation.rtl.benches import ROOT, Case, above, cases_of, digest, rtl_paths, used_by
from scripts.mutation.rtl.clean import Clean, known_clean, remember, usual_seconds
from scripts.mutation.rtl.equivalence import netlist_of, proved
from scripts.mutation.rtl.results import Result
from scripts.mutation.rtl.simulate_case import Stillborn, VhdlBuild
from scripts.mutation.rtl.vhdl_text import TextMutant, mutants_of

ABOVE_SECONDS = 60
"""Processor time of a survivor on the benches of the units above, cheap ones first."""


def sampled(unit: str, seed: int) -> list[TextMutant]:
    """All of a unit's mutants in a seed's order: a larger sample begins with a smaller one."""
    path = rtl_paths()[unit]
    mutants = mutants_of(str(path.relative_to(ROOT)), path.read_text())
    return sorted(mutants, key=lambda mutant: hashlib.sha256(f"{seed}{mutant.name}".encode()).digest())


def own_units(unit: str) -> list[str]:
    """Whose bench is a unit's own: its own, and for a package those of the units that use it."""
    return [unit] if cases_of(unit) else sorted(user for user in used_by()[unit] if cases_of(user))


def digest_of(units: Sequence[str]) -> str:
    """Hash of several benches."""
    return hashlib.sha256("".join(digest(unit) for unit in units).encode()).hexdigest()[:12]


class TextRun:
    """
    Runs mutants of one unit; knows how long the clean cases take and which of them kill.

    Parameters
    ----------
    unit : str
    folder : Path
      For the analysed RTL and the simulations.
    """

    def __init__(self, unit: str, folder: Path) -> None:
        self.unit, self.build, self.folder = unit, VhdlBuild(folder / unit), folder
        self.clean: dict[Case, Clean] = {}
        self.kills: Counter[Case] = Counter()
        self.gold: dict[Case, str] = {}

    def _order(self, units: Sequence[str]) -> list[Case]:
        """The cases of some units: cheap ones first, and those that killed often."""
        cases = [case for unit in units for case in cases_of(unit)]
        return sorted(cases, key=lambda case: usual_seconds(case) / (1 + self.kills[case]))

    def _clean_ns(self, case: Case) -> float:
        """Simulated time of a case on the clean RTL, which passes it."""
        if case not in self.clean:
            self.clean[case] = known_clean(case) or self._measured(case)
        return self.clean[case].ns

    def _measured(self, case: Case) -> Clean:
        self.build.make(case.unit)
        ran = self.build.run(case)
        if ran.verdict != "passed":
            raise QuadshadeError(f"{case.name} fails on the clean RTL: {ran.detail}", "mend it first")
        clean = Clean(case.name, digest(case.unit), ran.ns, ran.seconds)
        remember(clean)
        return clean

    @contextmanager
    def _mutated(self, mutant: TextMutant) -> Iterator[None]:
        text = (ROOT / mutant.file).read_text()
        self.build.mutate(mutant.file, mutant.apply(text))
        try:
            yield
        finally:
            self.build.mutate(mutant.file, None)

    def _judge(self, mutant: TextMutant, units: Sequence[str], stage: str, seed: int) -> Result:
        """Run a mutant on some units' benches until one kills it, or those above were given their time."""
        spent = 0.0
        survivor = Result(
            mutant.name, self.unit, mutant.file, mutant.line, mutant.kind, mutant.original,
            mutant.what, "text", "survived", stage=stage, benches=digest_of(units), seed=seed,
        )  # fmt: skip
        for case in self._order(units):
            if stage == "above" and spent + usual_seconds(case) > ABOVE_SECONDS:
                break
            most_ns = self._clean_ns(case)
            with self._mutated(mutant):
                try:
                    self.build.make(case.unit)
                except Stillborn as problem:
                    return replace(survivor, verdict="stillborn", detail=str(problem))
                ran = self.build.run(case, most_ns)
                spent += ran.seconds
                if ran.verdict == "passed":
                    continue
                broken = ran.verdict == "crashed" and not self.build.synthesises(case)
            if broken or ran.verdict == "stillborn":
                return replace(survivor, verdict="stillborn", by=case.name, detail=ran.detail)
            self.kills[case] += 1
            return replace(survivor, verdict="killed", by=case.name, detail=f"{ran.verdict}: {ran.detail}")
        return survivor

    def own(self, mutant: TextMutant, seed: int) -> Result:
        """
        On its own bench.

        Raises
        ------
        QuadshadeError
          A bench fails on the clean RTL.
        """
        return self._judge(mutant, own_units(self.unit), "own", seed)

    def above(self, mutant: TextMutant, seed: int) -> Result:
        """On the benches of the units above; raises as :meth:`own`."""
        return self._judge(mutant, above(self.unit), "above", seed)

    def prove(self, mutant: TextMutant, survivor: Result) -> Result:
        """The survivor as equivalent, if its netlists are in every configuration of its own bench."""
        cases = [case for unit in own_units(self.unit) for case in cases_of(unit)]
        for case in cases:
            if case not in self.gold:
                self.build.make(case.unit)
                self.gold[case] = netlist_of(self.build, case)
        with self._mutated(mutant):
            for case in cases:
                self.build.make(case.unit)
                gate = netlist_of(self.build, case)
                if not gate or not proved(self.gold[case], gate, case.unit, self.folder / "proof"):
                    return replace(survivor, stage="proof", detail=f"no proof in {case.name}")
        return replace(survivor, verdict="equivalent", stage="proof", by=f"{len(cases)} netlists", detail="")
