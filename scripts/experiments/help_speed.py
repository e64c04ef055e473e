#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""
Processor time of help and shell completion, beside that of an earlier commit, in one run.

The commit is exported into a temporary folder; both trees run with the same interpreter and the same
installed packages, and take turns. Writes docs/reports/helpspeed.md; exit code 1 if a ratio is too high.
"""

from __future__ import annotations

import os
import platform
import subprocess
import sys
import sysconfig
import tempfile
from collections.abc import Mapping
from pathlib import Path
from statistics import median

import click

from quadshade.errors import QuadshadeError
from quadshade.files.markdown import markdown_table
from scripts.experiments.report_writer import (
    REPORTS,
    ROOT,
    command_line,
    output_option,
    paragraph,
    write_report,
)
from scripts.one_line_errors import Failure, one_line_errors

REPORT = REPORTS / "helpspeed.md"
COMMIT = "21b62a9"
"""The last commit before help and completion came without numba, scipy and the engines."""
MOST = 0.35
"""Processor time, in that of the earlier commit."""
CALLS: dict[str, tuple[list[str], dict[str, str]]] = {
    "help of the program": (["--help"], {}),
    "help of `render`": (["render", "--help"], {}),
    "completion of a command": (
        [],
        {"_QUADSHADE_COMPLETE": "bash_complete", "COMP_WORDS": "quadshade re", "COMP_CWORD": "1"},
    ),
    "completion of an option of `render`": (
        [],
        {"_QUADSHADE_COMPLETE": "bash_complete", "COMP_WORDS": "quadshade render --sh", "COMP_CWORD": "2"},
    ),
}
"""Arguments and environment of each call."""
MAIN = "from quadshade.cli.main import main; main(prog_name='quadshade')"
WHERE = "import quadshade.cli.main; print(quadshade.cli.main.__file__)"


def export(commit: str, folder: Path) -> None:
    """
    Write the package as it was in a commit into a folder.

    Raises
    ------
    QuadshadeError
      This is no clone that holds the commit.
    """
    command = ["git", "-C", str(ROOT), "archive", "--format=tar", commit, "model"]
    packed = subprocess.run(command, capture_output=True, check=False)
    if packed.returncode:
        raise QuadshadeError(
            f"git cannot export commit {commit}", "run this in a clone with its whole history"
        )
    subprocess.run(["tar", "-x", "-C", str(folder)], input=packed.stdout, check=True)


def run(tree: Path, program: str, arguments: list[str], variables: Mapping[str, str]) -> tuple[str, float]:
    """
    Run a Python program with the package of a tree.

    Returns
    -------
    str, float
      What it printed, and its processor seconds.

    Raises
    ------
    QuadshadeError
      It ended with an error, or printed nothing.
    """
    # Without the module site (-S) an editable install of the package is not in the path.
    path = os.pathsep.join([str(tree / "model"), sysconfig.get_path("purelib")])
    environment = os.environ | {"PYTHONPATH": path} | variables
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    with tempfile.TemporaryFile() as printed:
        process = subprocess.Popen(
            [sys.executable, "-S", "-c", program, *arguments], stdout=printed, env=environment
        )
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        printed.seek(0)
        text = printed.read().decode()
    if process.returncode or not text.strip():
        raise QuadshadeError(
            f"{tree}: {' '.join(arguments) or 'completion'} ends with code {process.returncode}, "
            f"after {len(text)} characters",
            "run it by hand",
        )
    return text, used.ru_utime + used.ru_stime


def measure(trees: Mapping[str, Path], runs: int) -> dict[str, dict[str, float]]:
    """
    Median processor seconds of every call in every tree.

    Parameters
    ----------
    trees : mapping of str to Path
      Checkouts, by a name; they take turns. A run that is not counted compiles their modules first.
    runs : int

    Returns
    -------
    dict
      By call, then by the tree's name.

    Raises
    ------
    QuadshadeError
      A call fails, or the package is imported from elsewhere.
    """
    for tree in trees.values():
        where = run(tree, WHERE, [], {})[0].strip()
        if not Path(where).resolve().is_relative_to(tree.resolve()):
            raise QuadshadeError(f"{where} is imported instead of {tree}", "use an editable install")
    medians = {}
    for call, (arguments, variables) in CALLS.items():
        seconds: dict[str, list[float]] = {name: [] for name in trees}
        for _ in range(runs + 1):
            for name, tree in trees.items():
                seconds[name].append(run(tree, MAIN, arguments, variables)[1])
        medians[call] = {name: median(values[1:]) for name, values in seconds.items()}
    return medians


def ratios(medians: Mapping[str, Mapping[str, float]]) -> dict[str, float]:
    """Processor time now in that of the earlier commit, by call."""
    return {call: times["now"] / times["before"] for call, times in medians.items()}


def report(command: str, commit: str, runs: int, medians: Mapping[str, Mapping[str, float]]) -> str:
    """The report's text."""
    rows = [
        (
            call,
            f"{medians[call]['before']:.3f}",
            f"{medians[call]['now']:.3f}",
            f"{ratio:.3f} {'met' if ratio <= MOST else 'MISSED'}",
        )
        for call, ratio in ratios(medians).items()
    ]
    header = ("call", f"seconds, {commit}", "seconds, now", f"ratio, target ≤ {MOST}")
    text = f"""
        Written by `{command}` (`make helpspeed`): processor seconds, median of {runs} runs in which both
        trees take turns, with the same interpreter (Python {platform.python_version()}) and the same
        packages. Commit {commit} is exported from the history. Seconds depend on the machine, ratios hardly.
        """
    return f"# Help and completion\n\n{paragraph(text)}\n\n{markdown_table(header, rows)}\n"


@click.command(help=__doc__)
@click.option("--commit", default=COMMIT, show_default=True, help="The earlier commit.")
@click.option("--runs", type=click.IntRange(1), default=15, show_default=True, help="Runs of each call.")
@output_option(REPORT)
@one_line_errors(REPORT.stem)
def main(commit: str, runs: int, output: Path) -> None:
    with tempfile.TemporaryDirectory() as folder:
        export(commit, Path(folder))
        medians = measure({"before": Path(folder), "now": ROOT}, runs)
    text = report(command_line("help_speed", commit=commit, runs=runs), commit, runs, medians)
    write_report(output, text)
    click.echo(text, nl=False)
    if max(ratios(medians).values()) > MOST:
        raise Failure(f"a ratio is above {MOST}")


if __name__ == "__main__":
    main()
