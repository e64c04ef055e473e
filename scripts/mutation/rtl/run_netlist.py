# SPDX-License-Identifier: Apache-2.0
"""
Mutants of a unit's netlist by Yosys' `mutate`, simulated by Icarus with the unit's own bench.

One configuration of generics a unit: of those that were measured, the one whose simulation takes the least
time when a run begins. Yosys picks cells of the unit itself, not of those in it, evenly over cells, ports,
bits and what they are made of.
"""

from __future__ import annotations

import hashlib
import re
import shutil
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from quadshade.engine.netlist import write_netlist
from quadshade.errors import QuadshadeError
from quadshade.synthesis.flow import run_yosys
from scripts.mutation.rtl.benches import Case, cases_of, digest
from scripts.mutation.rtl.clean import has_run, usual_seconds
from scripts.mutation.rtl.equivalence import proved
from scripts.mutation.rtl.fork_names import PORT
from scripts.mutation.rtl.results import Result
from scripts.mutation.rtl.simulate_case import Ran, run_verilog

PORT_BITS = 16
NO_HARDWARE = re.compile(r"-cell (\$memrd\S* -port EN|\$meminit)")
"""A memory's reading without a clock has no enable, nor has what it holds at first: Yosys aborts there."""


@dataclass(frozen=True)
class NetlistMutant:
    """One change of a netlist: Yosys' options of `mutate`, and a name that is the hash of them."""

    name: str
    options: str

    @property
    def kind(self) -> str:
        return "netlist " + self._option("mode")

    @property
    def what(self) -> str:
        place = f"{self._option('cell')} {self._option('port')}[{self._option('portbit')}]"
        return f"{place}, {self._option('ctrlbit')}" if "-ctrlbit" in self.options else place

    def _option(self, name: str) -> str:
        found = re.search(rf"-{name} (\S+)", self.options)
        return found[1] if found else ""


class NetlistRun:
    """
    A unit's netlist in one configuration, and its mutants.

    Parameters
    ----------
    unit : str
    folder : Path
      Made anew; Yosys and Icarus work in it.
    count, seed : int
      Of the sample.
    label : str
      Of the bench's configuration, where an earlier run has chosen it.

    Raises
    ------
    QuadshadeError
      A tool fails, or the bench on the netlist as it is.
    """

    def __init__(self, unit: str, folder: Path, count: int, seed: int, label: str = "") -> None:
        self.unit, self.folder, self.seed = unit, folder / f"{unit}_netlist", seed
        shutil.rmtree(self.folder, ignore_errors=True)
        self.folder.mkdir(parents=True)
        cases = cases_of(unit)
        kept = [case for case in cases if case.label == label]
        measured = [case for case in cases if has_run(case)]
        self.case: Case = kept[0] if kept else min(measured or cases, key=usual_seconds)
        # A mutant's name holds its line: what stands above the first module is cut off.
        text = write_netlist(dict(self.case.generics), unit).read_text()
        (self.folder / f"{unit}.v").write_text(text[text.index("\nmodule ") + 1 :])
        self.read = [
            f"read_verilog {unit}.v",
            f"hierarchy -check -top {unit}",
            "proc",
            "opt_expr",
            "opt_clean",
        ]
        self.mutants = self._listed(count)

    def _listed(self, count: int, number: int = 0) -> list[NetlistMutant]:
        """So many mutants, of more that are asked for where some are no hardware."""
        listing = f"mutate -list {number or count} -seed {self.seed} -o mutants.txt {self.unit}"
        run_yosys([*self.read, listing, "write_verilog -noattr clean.v"], self.folder)
        listed = (self.folder / "mutants.txt").read_text().splitlines()
        lines = [line for line in listed if not NO_HARDWARE.search(line)]
        if len(lines) < count and len(listed) == (number or count):
            return self._listed(count, len(listed) + count - len(lines))
        keys = [f"{self.unit}|{self.case.label}|{line}" for line in lines]
        names = [hashlib.sha256(key.encode()).hexdigest()[:10] for key in keys]
        return [NetlistMutant(*pair) for pair in zip(names, lines, strict=True)]

    def _write(self, mutants: Sequence[NetlistMutant]) -> Path:
        """One netlist that holds some mutants, of which a port chooses one."""
        chosen = [
            f"{mutant.options} -ctrl {PORT} {PORT_BITS} {number}"
            for number, mutant in enumerate(mutants, start=1)
        ]
        # A register whose output is changed loses its value at power-up: with inverters every one is 0.
        values = "setundef -zero -init t:$dff"
        run_yosys([*self.read, "zinit -all", *chosen, values, "write_verilog -noattr mutants.v"], self.folder)
        return self.folder / "mutants.v"

    def own(self, mutants: Sequence[NetlistMutant]) -> Iterator[Result]:
        """On the unit's own bench, as they end; mutant 0 first: how long the clean netlist takes."""
        if not mutants:
            return
        netlist = self._write(mutants)
        (clean,) = run_verilog(netlist, self.case, 1)
        if clean.verdict != "passed":
            raise QuadshadeError(
                f"{self.case.name} fails on the clean netlist: {clean.detail}", "mend it first"
            )
        outcomes = zip(
            [None, *mutants], run_verilog(netlist, self.case, len(mutants) + 1, clean.ns), strict=True
        )
        for mutant, ran in outcomes:
            # What has no results and began no test was interrupted: it is run again.
            if mutant is not None and ran.verdict != "stillborn":
                yield self._result(mutant, ran)

    def _result(self, mutant: NetlistMutant, ran: Ran) -> Result:
        result = Result(
            mutant.name, self.unit, "", 0, mutant.kind, self.case.label, mutant.what, "netlist",
            "survived", detail=ran.detail, benches=digest(self.unit), seed=self.seed,
        )  # fmt: skip
        if ran.verdict == "passed":
            return result
        return replace(result, verdict="killed", by=self.case.name, detail=f"{ran.verdict}: {ran.detail}")

    def prove(self, mutant: NetlistMutant, survivor: Result) -> Result:
        """The survivor as equivalent, if a proof says so."""
        run_yosys([*self.read, "zinit -all", mutant.options, "write_verilog -noattr one.v"], self.folder)
        gold, gate = ((self.folder / name).read_text() for name in ("clean.v", "one.v"))
        if proved(gold, gate, self.unit, self.folder / "proof"):
            return replace(survivor, verdict="equivalent", stage="proof", by="1 netlist", detail="")
        return replace(survivor, stage="proof", detail="no proof")
