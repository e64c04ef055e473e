# SPDX-License-Identifier: Apache-2.0
"""One simulation of a bench on a mutated unit, up to its first fault: VHDL by GHDL, a netlist by Icarus."""

from __future__ import annotations

import os
import resource
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from xml.etree import ElementTree

import cocotb_tools.config
import find_libpython

from cocotb_tests.support.simulation import failures
from quadshade.engine.sources import rtl_files
from quadshade.engine.tool_runner import run_tool, tool_command
from scripts.mutation.rtl.benches import ROOT, Case
from scripts.mutation.rtl.fork_names import FORKS, LOG, RESULTS

FACTOR = 4
"""A mutant that simulates this many times as long as the clean unit hangs."""
SLACK_NS = 2_000
ENDED, STOPPED = "simulation ended prematurely", "simulation stopped by --stop-time"
"""What cocotb and GHDL say where the simulator ends by itself."""
SIMULATED = "sim_time_duration"
"""Property of a test in cocotb's results, in nanoseconds."""
WALL_SECONDS = 900
"""Ends a simulation whose time stands still."""
POLL_SECONDS = 0.1


@dataclass(frozen=True)
class Ran:
    """
    What a simulation said.

    Attributes
    ----------
    verdict : str
      ``passed``; ``failed``; ``hung``; ``crashed``: the simulator ended by itself, by a bound check for
      example; ``stillborn``: it ended before a test began.
    detail : str
      The first failing test and its message.
    ns : float
      Simulated time of the tests that ended.
    seconds : float
      Processor time.
    """

    verdict: str
    detail: str
    ns: float
    seconds: float


class Stillborn(Exception):
    """The mutated text does not analyse or elaborate."""


@cache
def _environment() -> dict[str, str]:
    """What cocotb's own runner sets, and the options with which a simulation stops at its first fault."""
    entry = cocotb_tools.config.pygpi_entry_point()
    return {
        **os.environ,
        "PYTHONPATH": os.pathsep.join([str(ROOT / "model"), str(ROOT)]),
        "PYGPI_PYTHON_BIN": sys.executable,
        "GPI_USERS": f"{find_libpython.find_libpython()};{entry}",
        "COCOTB_MAX_FAILURES": "1",
        "COCOTB_REWRITE_ASSERTION_FILES": "",
        "COCOTB_RANDOM_SEED": os.environ.get("QUADSHADE_SEED") or "1",
        "QUADSHADE_FAIL_FAST": "1",
        "QUADSHADE_NETLIST": "",
        "OPENBLAS_NUM_THREADS": "1",
    }


def _variables(case: Case, language: str) -> dict[str, str]:
    return _environment() | {
        "COCOTB_TOPLEVEL": case.unit,
        "COCOTB_TEST_MODULES": case.module,
        "TOPLEVEL_LANG": language,
        # As in cocotb's runner: with it, Icarus would apply writes amid the clock's edge.
        "COCOTB_TRUST_INERTIAL_WRITES": str(int(language == "vhdl")),
        "QUADSHADE_CONFIG": case.config,
        "QUADSHADE_UNIT": case.unit,
    }


def _read(results: Path, log: Path, seconds: float, hung: bool = False) -> Ran:
    """What cocotb's results and the log of a simulation say."""
    text = log.read_text(errors="replace") if log.is_file() else ""
    if hung or STOPPED in text:
        return Ran("hung", f"more than {FACTOR} times the clean run", 0, seconds)
    if results.is_file():
        root = ElementTree.parse(results)
        times = [found.get("value", 0) for found in root.iter("property") if found.get("name") == SIMULATED]
        ns = sum(map(float, times))
        faults = failures(results)
        if faults and ENDED in faults[0]:
            return Ran("crashed", f"{faults[0].partition(':')[0]}: {_last_error(text)}", ns, seconds)
        return Ran("failed" if faults else "passed", faults[0][:300] if faults else "", ns, seconds)
    return Ran("crashed" if "(1/" in text else "stillborn", text.strip()[-200:], 0, seconds)


def _last_error(text: str) -> str:
    """GHDL's own words in a log: of a bound check, for example."""
    errors = [line for line in text.splitlines() if ":error: " in line and "simulation failed" not in line]
    return errors[-1].rpartition(":error: ")[2][:200] if errors else "the simulator ended"


class VhdlBuild:
    """
    A copy of the RTL in a folder of its own, analysed once; then file by file as mutants change it.

    Parameters
    ----------
    folder : Path
      Made anew.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(ROOT / "rtl", folder / "rtl")
        files = [str(path.relative_to(ROOT)) for path in rtl_files(ROOT)]
        run_tool([*tool_command("GHDL"), "-i", "--std=08", *files], folder)
        self.mutated: Path | None = None

    def make(self, unit: str) -> None:
        """Analyse what is not up to date, and link a unit; raises :class:`Stillborn`."""
        command = [*tool_command("GHDL"), "-m", "--std=08", unit]
        done = subprocess.run(command, cwd=self.folder, capture_output=True, text=True, check=False)
        if done.returncode:
            raise Stillborn((done.stdout + done.stderr).strip()[-200:])

    def synthesises(self, case: Case) -> bool:
        """Whether a case's hardware can be made: no two vectors of different lengths meet, for example."""
        command = [*tool_command("GHDL"), "--synth", "--std=08", "--out=none"]
        command += [*(f"-g{name}={value}" for name, value in case.generics), case.unit]
        done = subprocess.run(command, cwd=self.folder, capture_output=True, text=True, check=False)
        return done.returncode == 0

    def mutate(self, file: str, text: str | None) -> None:
        """Give a file another text, or its own again."""
        (self.folder / file).write_text((ROOT / file).read_text() if text is None else text)

    def run(self, case: Case, most_ns: float | None = None) -> Ran:
        """A case on the linked unit; ``most_ns`` is how long the clean one takes."""
        command = [f"./{case.unit}", "--vpi=" + cocotb_tools.config.lib_entry("vpi", "ghdl")]
        command += ["--ieee-asserts=disable", *(f"-g{name}={value}" for name, value in case.generics)]
        if most_ns is not None:
            command += [f"--stop-time={round(most_ns * FACTOR + SLACK_NS)}ns"]
        results, log = self.folder / "results.xml", self.folder / "simulation.log"
        results.unlink(missing_ok=True)
        variables = _variables(case, "vhdl") | {"COCOTB_RESULTS_FILE": str(results)}
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        hung = False
        with (
            log.open("w") as out,
            subprocess.Popen(command, cwd=self.folder, env=variables, stdout=out, stderr=out) as process,
        ):
            try:
                process.wait(WALL_SECONDS)
            except subprocess.TimeoutExpired:
                process.kill()
                hung = True
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        return _read(results, log, seconds, hung)


def run_verilog(netlist: Path, case: Case, mutants: int, most_ns: float | None = None) -> Iterator[Ran]:
    """
    A case on a netlist that holds its mutants, in its folder: see :mod:`scripts.mutation.rtl.forks`.

    Parameters
    ----------
    netlist : Path
    case : Case
    mutants : int
      How many, with mutant 0, the netlist as it is.
    most_ns : float, optional
      How long the clean one takes. Icarus has no option for this: a module beside the unit ends it.

    Yields
    ------
    Ran
      By mutant, as they end; of no use are their seconds, which are 0.

    Raises
    ------
    QuadshadeError
      Icarus does not take the netlist.
    """
    folder = netlist.parent
    (folder / "commands.f").write_text("+timescale+1ns/1ps\n")
    sources, tops = [netlist.name], ["-s", case.unit]
    if most_ns is not None:
        limit = round(most_ns * FACTOR + SLACK_NS)
        text = f'module time_limit; initial #{limit} begin $display("{STOPPED}"); $finish; end endmodule\n'
        (folder / "time_limit.v").write_text(text)
        sources.append("time_limit.v")
        tops += ["-s", "time_limit"]
    run_tool(["iverilog", "-o", "sim.vvp", *tops, "-g2012", "-f", "commands.f", *sources], folder)
    files = [(folder / RESULTS.format(number), folder / LOG.format(number)) for number in range(mutants)]
    for results, log in files:
        results.unlink(missing_ok=True)
        log.unlink(missing_ok=True)
    variables = _variables(case, "verilog")
    variables |= {"COCOTB_TEST_MODULES": f"{case.module},scripts.mutation.rtl.forks", FORKS: str(mutants)}
    command = ["vvp", "-m", cocotb_tools.config.lib_entry("vpi", "icarus"), "sim.vvp", "-none"]
    with (
        (folder / "simulation.log").open("w") as out,
        subprocess.Popen(command, cwd=folder, env=variables, stdout=out, stderr=out) as process,
    ):
        for number, (results, log) in enumerate(files):
            # One after the other: where the next one has begun, this one is done.
            while process.poll() is None and not (number + 1 < mutants and files[number + 1][1].is_file()):
                time.sleep(POLL_SECONDS)
            yield _read(results, log, 0.0)
