# SPDX-License-Identifier: Apache-2.0
"""
How many mutants of the host library its tests notice: ``python -m scripts.mutation.python``.

Each package is a session of pytest of its own. What is known of a mutant is kept in
``build/mutation/python.jsonl``, and with the report in ``docs/reports/mutation_python.json``, so a run that
was ended goes on, also on another machine; a result is used again while the function, and for a survivor
the tests, are the same.
"""

from __future__ import annotations

import json
import multiprocessing
import os
import sys
from collections.abc import Callable
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path

import click

from scripts.mutation.python.kept import PACKAGE, run_kept
from scripts.mutation.python.mutants import Mutant, changed_lines, digest, mutants_of, mutated, sample
from scripts.mutation.python.report import NUMBERS, PLACE, ROOT, argued, write

BUILD = ROOT / "build" / "mutation"
KNOWN = BUILD / "python.jsonl"


@dataclass(frozen=True)
class Group:
    """
    A package that is mutated, and what it is tested by.

    Attributes
    ----------
    tests : tuple of str
      Files below ``tests``, without ``test_`` and ending; behind ``::`` one test of a file.
    more : tuple of str
      Files of other packages that belong to it.
    slow : float
      Seconds of processor time without a change; what takes longer is left out.
    """

    tests: tuple[str, ...]
    more: tuple[str, ...] = ()
    slow: float = 1.5

    @property
    def selected(self) -> list[str]:
        """What pytest collects."""
        names = [name.split("::") for name in self.tests]
        return ["::".join([f"tests/test_{name}.py", *tests]) for name, *tests in names]

    @property
    def digest(self) -> str:
        """Of all files of tests, and of which tests are run."""
        contents = [(ROOT / name.split("::")[0]).read_bytes() for name in self.selected]
        return digest(*contents, str(self.slow).encode())


CHOICE = ("mix_counts_what_is_sent", "fits_reproduce_what_their_order_can", "fits_are_no_worse_than_sampling")
CHOICE += ("bend_bounds_quadratic_against_plane", "refusals")
COSINES = ("scenes_without_cosines", "small_triangles_are_known_by_their_pixels")
COSINES += ("fits_reproduce_what_their_order_can", "equal_extremes_are_less_than_the_mean_squares")
COSINES += ("nothing_seen_is_drawn_with_nothing", "triangles_without_a_pixel_cost_and_err_nothing")
"""Quick tests of adapt."""

GROUPS = {
    "packing": Group(
        (
            "frame_file",
            "link_packing",
            "setup_recorded",
            "setup_packet",
            "vertices",
            "line_budget::test_a_frame_is_never_longer_than_counted",
            "line_budget::test_words_fill_frames_before_another_begins",
        ),
    ),
    "contract": Group(
        (
            "setup_packet",
            "generate_vhdl",
            "width_expressions",
            "link_frames",
            "shade_file",
            "golden_shade",
            "link_packing",
            "vertices",
            "vertex_program",
            "lint::test_generated_package_is_current",
            "habits::test_version_is_a_release_with_its_definition",
        ),
    ),
    "golden": Group(
        (
            "golden_units",
            "golden_core",
            "golden_board",
            "golden_screen",
            "golden_edge_map",
            "golden_shade",
            "golden_clocks::test_clocks_are_those_recorded",
            "golden_clocks::test_nothing_drawn_takes_no_clock",
            "golden_line_clocks",
            "golden_axis",
            "golden_link",
            "golden_sdram",
            "golden_video",
            "packed_pixels",
            "two_buffers::test_thresholds_are_bayers",
            "two_buffers::test_dithering_keeps_the_mean_and_flat_colours",
            "link_golden",
            "link_limits",
            "link_packing::test_what_is_unpacked_is_the_packets",
            "link_packing::test_nothing_and_nonsense",
            "frame_file::test_a_board_draws_what_the_file_says",
        )
    ),
    "setup": Group(
        (
            "setup_recorded",
            "setup_errors",
            "setup_packet",
            "setup_triangle_file",
            "setup_choice",
            "setup_methods",
            "setup_words",
            "setup_edges",
            "setup_lattice",
            "setup_tile",
        ),
        slow=0.7,
    ),
    "link": Group(("link_transport", "link_frames", "link_session", "board_ports", "packed_pixels")),
    "adapt": Group(
        (
            "adapt_recorded",
            "adapt_highlight",
            "adapt_steps",
            "adapt_rules",
            # The other tests of these files take more, each, than a mutant is given.
            "adapt_curve::test_limits_are_round_numbers_a_few_per_cent_apart",
            *(f"adapt_choice::test_{name}" for name in CHOICE),
            *(f"adapt_cosines::test_{name}" for name in COSINES),
        ),
        more=("scene/subdivide.py", "scene/subdivide_loops.py"),
    ),
}


@dataclass(frozen=True)
class Result:
    """What is known of a mutant: where it is, by which tests, its lines, and how its tests ended."""

    name: str
    path: str
    operator: str
    group: str
    where: str
    tests: str
    old: str
    new: str
    state: str
    test: str


def known_results(path: Path = KNOWN, numbers: Path = NUMBERS) -> dict[str, Result]:
    """The latest result of each mutant, by its name: what was published, and what was found here since."""
    names = [field.name for field in fields(Result)]
    entries = [
        # That a reader found it equivalent is found out anew.
        entry | {"state": "survived" if entry["state"] == "equivalent" else entry["state"]}
        for entry in json.loads(numbers.read_text())["mutants"]
    ]
    entries += [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []
    return {entry["name"]: Result(**{name: entry[name] for name in names}) for entry in entries}


def drawn(count: int, seed: int) -> list[Mutant]:
    """The sample over all groups."""
    paths = [path for name in GROUPS for path in sorted((PACKAGE / name).rglob("*.py"))]
    paths += [PACKAGE / path for group in GROUPS.values() for path in group.more]
    return sample({str(path): mutants_of(path, PACKAGE) for path in paths}, count, seed)


def group_of(path: str) -> str:
    """The group that a file belongs to."""
    return next((name for name, group in GROUPS.items() if path in group.more), path.split("/")[0])


def run_group(name: str, mutants: list[Mutant], said: Callable[[str], None]) -> str:
    """Run tests on mutants of a package and note each result; why that could not be done."""
    from scripts.mutation.python.runner import Session, run_session

    group = GROUPS[name]
    tests = group.digest

    def work(session: Session) -> None:
        said(f"{name}: {len(session.items)} tests of {session.total:.0f} s, {len(mutants)} mutants")
        for mutant in mutants:
            source = (PACKAGE / mutant.path).read_text()
            old, new = changed_lines(source, mutated(mutant, source))
            outcome = session.run(mutant)
            result = Result(
                mutant.name,
                mutant.path,
                mutant.operator,
                name,
                mutant.where,
                tests,
                old,
                new,
                outcome.state,
                outcome.test,
            )
            with KNOWN.open("a") as file:
                file.write(json.dumps(asdict(result)) + "\n")
            if outcome.state == "survived":
                said(f"{mutant.path}:{mutant.line} survived: {old} -> {new}")

    modules = [path.removesuffix(".py").replace("/", ".") for path in (f"{name}/", *group.more)]
    interpreted = tuple(f"quadshade.{module}" for module in modules)
    return run_session(ROOT, BUILD / "python", interpreted, group.selected, group.slow, work)


def _child(name: str, mutants: list[Mutant], terminal: int) -> None:
    def said(text: str) -> None:
        os.write(terminal, f"mutation: {text}\n".encode())

    problem = run_group(name, mutants, said)
    if problem:
        said(f"error: {name}: {problem}")
        sys.exit(1)


def to_do(mutants: list[Mutant], name: str) -> list[Mutant]:
    """The mutants of a package that nothing valid is known of; those that are argued are run once."""
    known = known_results()
    tests, reasons = GROUPS[name].digest, {tuple(entry[part] for part in PLACE) for entry in argued()}
    left = []
    for mutant in mutants:
        result = known.get(mutant.name)
        is_known = result is not None and (
            result.state != "survived"
            or result.tests == tests
            or (mutant.path, result.where, result.old, result.new) in reasons
        )
        if not is_known:
            left.append(mutant)
    return left


@click.command(help=__doc__)
@click.option("--count", default=600, show_default=True, type=click.IntRange(1), help="Mutants to draw.")
@click.option(
    "--seed",
    "seeds",
    default=(1,),
    type=int,
    multiple=True,
    help="Draws the same mutants again; several draw more.",
)
@click.option("--only", type=click.Choice(tuple(GROUPS)), multiple=True, help="Only these packages.")
@click.option(
    "--check", is_flag=True, help="Write no report; fail where a mutant survives that is not argued."
)
@click.option("--known", is_flag=True, help="Run nothing: write the report of what is known already.")
@click.option(
    "--slow", type=float, help="Leave out tests that take more seconds; survivors are run again without."
)
@click.option("--kept", is_flag=True, help="Only mutants that the report says are killed: they must stay so.")
def main(
    count: int,
    seeds: tuple[int, ...],
    only: tuple[str, ...],
    check: bool,
    known: bool,
    slow: float | None,
    kept: bool,
) -> None:
    # Before anything imports numpy: a process of one thread can be forked.
    for variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "NUMBA_NUM_THREADS"):
        os.environ[variable] = "1"
    if kept:
        run, alive = run_kept(count, seeds[0])
        for mutant in alive:
            print(f"{mutant.path}:{mutant.line} {mutant.operator} is not killed any more")
        print(f"mutation: {run - len(alive)} of {run} are killed again")
        raise SystemExit(bool(alive))
    for name, group in GROUPS.items() if slow else ():
        GROUPS[name] = replace(group, slow=slow)
    BUILD.mkdir(parents=True, exist_ok=True)
    samples = {seed: drawn(count, seed) for seed in seeds}
    names = {seed: {mutant.name for mutant in found} for seed, found in samples.items()}
    mutants = list({mutant.name: mutant for found in samples.values() for mutant in found}.values())
    for name in () if known else only or GROUPS:
        left = to_do([mutant for mutant in mutants if group_of(mutant.path) == name], name)
        if left:
            terminal = os.dup(2)
            process = multiprocessing.get_context("fork").Process(target=_child, args=(name, left, terminal))
            process.start()
            process.join()
            os.close(terminal)
            if process.exitcode:
                raise SystemExit(1)
    found = known_results()
    rows = [asdict(found[mutant.name]) for mutant in mutants if mutant.name in found]
    survivors = write(rows, argued(), count, names, report=not check and not only)
    if check and survivors:
        raise SystemExit(f"mutation: {survivors} survived")


if __name__ == "__main__":
    main()
