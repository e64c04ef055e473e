# SPDX-License-Identifier: Apache-2.0
"""Statement, branch and functional coverage of the RTL under the cocotb benches; docs/reports/coverage.md."""

from __future__ import annotations

import os
import platform
import shutil
import subprocess
import sys
from pathlib import Path

import click

from quadshade.engine.sources import repository_root, rtl_files
from quadshade.engine.tool_runner import announce, package_version, run_to_end
from quadshade.files.atomic import write_text
from scripts.coverage.functional import read_crosses
from scripts.coverage.ghdl_gcc import counting_environment
from scripts.coverage.page import page
from scripts.coverage.rtl_coverage import check, coverage_of, read_counts, read_exceptions
from scripts.one_line_errors import Failure, one_line_errors

CROSSES = ("core", "link")
EXCEPTIONS = Path(__file__).with_name("exceptions.toml")


def run_benches(root: Path, environment: dict[str, str], jobs: int, selection: str) -> None:
    """
    Run benches with counters.

    Raises
    ------
    Failure
      A test fails.
    """
    command = [sys.executable, "-m", "pytest", "-q", "-n", str(jobs), "--dist", "worksteal", "cocotb_tests"]
    command += ["-k", selection] if selection else []
    announce("running the benches with counters, which takes minutes")
    if subprocess.run(command, cwd=root, env=environment, check=False).returncode:
        raise Failure("a test fails, so what it reached does not count")


@click.command(help=__doc__)
@click.option("--jobs", default=2, show_default=True, type=click.IntRange(1), help="Benches at a time.")
@click.option(
    "--only", default="", help="Run the benches of this name alone (pytest's -k), beside earlier runs."
)
@click.option("--run/--no-run", default=True, help="Run benches, or read again what earlier runs left.")
@one_line_errors("coverage")
def main(jobs: int, only: str, run: bool) -> None:
    root = repository_root()
    data = root / "build" / "coverage"
    environment = {**counting_environment(root), "QUADSHADE_COVERAGE": str(data)}
    if run and not only:
        shutil.rmtree(data, ignore_errors=True)
    if run:
        run_benches(root, environment, jobs, only)
    sources = rtl_files(root)
    try:
        functions = read_counts(data, root / "build" / "cocotb" / "library", sources)
        crosses = read_crosses(data)
    except ValueError as problem:
        raise Failure(f"{problem}; run `make coverage`") from None
    found = coverage_of(functions, root, sources)
    exceptions = read_exceptions(EXCEPTIONS)
    faults, excused = check(found, exceptions, root)
    faults += [fault for cross in crosses for fault in cross.faults()]
    faults += [f"{name}: no bench drives it" for name in CROSSES if name not in {one.name for one in crosses}]
    if faults:
        raise Failure("\n".join([f"{len(faults)} things were not reached and have no reason:", *faults]))
    ghdl = run_to_end(["ghdl", "--version"], root, environment=environment).stdout.splitlines()[0]
    made = (
        f"{' '.join(ghdl.split()[:2])} with gcc's code generator, {package_version('cocotb')}, "
        f"Python {platform.python_version()}, seed {os.environ.get('QUADSHADE_SEED') or 1}"
    )
    report = root / "docs" / "reports" / "coverage.md"
    write_text(report, page(found, exceptions, excused, crosses, made))
    print(report.relative_to(root))


if __name__ == "__main__":
    main()
