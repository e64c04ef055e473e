# SPDX-License-Identifier: Apache-2.0
"""
Change the RTL in small ways, see which benches notice, and write docs/reports/mutation.md.

What was done stays in build/mutation, and with the report in docs/reports/mutation_rtl.json: a run that was
stopped goes on, also on another machine. After a change of a bench its survivors are run again; what it
killed as it was before stands beside the digest of that bench, and is run again with --all.
"""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor

import click

from quadshade.errors import QuadshadeError
from scripts.mutation.rtl import report
from scripts.mutation.rtl import results as store
from scripts.mutation.rtl.benches import rtl_paths
from scripts.mutation.rtl.results import Result
from scripts.mutation.rtl.run_text import sampled
from scripts.mutation.rtl.settle import STEPS, Settling, counts
from scripts.one_line_errors import one_line_errors

DEFAULT_COUNT = 1700


def show(result: Result) -> None:
    """A line for each mutant, while it runs."""
    place = f"{result.unit}:{result.line}" if result.line else f"{result.unit} {result.kind}"
    click.echo(f"{place} {result.what[:70]}: {result.verdict} {result.by} {result.detail[:60]}")


def settle(unit: str, numbers: tuple[int, int], seed: int, steps: tuple[str, ...], again: bool) -> None:
    """One unit, in whatever process."""
    Settling(unit, numbers, seed, steps, again, show).run()


@click.command(help=__doc__.strip().splitlines()[0])
@click.option("--unit", "units", multiple=True, help="Only these; all of rtl/ if not given.")
@click.option("--seed", default=1, show_default=True, help="Which mutants are drawn.")
@click.option(
    "--count", default=DEFAULT_COUNT, show_default=True, help="Mutants of all units together, about."
)
@click.option("--jobs", default=1, show_default=True, help="Units at a time.")
@click.option("--step", "steps", multiple=True, type=click.Choice(STEPS), help="Only these steps.")
@click.option("--all", "again", is_flag=True, help="Kills of benches that have changed since are run again.")
@click.option("--report-only", is_flag=True, help="Run nothing; write the report anew.")
@one_line_errors("mutation")
def main(
    units: tuple[str, ...],
    seed: int,
    count: int,
    jobs: int,
    steps: tuple[str, ...],
    again: bool,
    report_only: bool,
) -> None:
    for unit in units:
        if unit not in rtl_paths():
            raise QuadshadeError(
                f"there is no unit {unit!r}", f"the units are {', '.join(sorted(rtl_paths()))}"
            )
    if count < 1 or jobs < 1:
        raise QuadshadeError("count and jobs are at least 1", "leave them out for the usual ones")
    numbers = counts(count, seed)
    problems = []
    if not report_only:
        with ProcessPoolExecutor(jobs) as pool:
            waiting = [
                pool.submit(settle, unit, numbers[unit], seed, steps or STEPS, again)
                for unit in units or rtl_paths()
            ]
            # One unit whose bench fails on the clean RTL keeps no other from being run.
            problems = [problem for work in waiting if (problem := work.exception())]
    there = {mutant.name for unit in rtl_paths() for mutant in sampled(unit, seed)}
    found = [
        result
        for result in store.known().values()
        if result.seed == seed
        and (result.name in there or result.source == "netlist")
        and result.verdict != store.OUTDATED
    ]
    report.write(found, seed, sum(len(sampled(unit, seed)) for unit in rtl_paths()), numbers)
    if problems:
        raise problems[0]


if __name__ == "__main__":
    main()
