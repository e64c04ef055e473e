# SPDX-License-Identifier: Apache-2.0
"""The score of the host library's tests: from what is known of the mutants to numbers and a table."""

from __future__ import annotations

import json
import tomllib
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from textwrap import fill
from typing import Any

from quadshade.files.markdown import markdown_table
from scripts.mutation.report import score, write_numbers, write_section

ROOT = Path(__file__).resolve().parents[3]
EQUIVALENT = Path(__file__).with_name("equivalent.toml")
NUMBERS = ROOT / "docs" / "reports" / "mutation_python.json"
PLACE = ("path", "where", "old", "new")


def argued() -> list[dict[str, str]]:
    """Survivors that a reader found equivalent, each with a reason."""
    entries: list[dict[str, str]] = tomllib.loads(EQUIVALENT.read_text()).get("mutant", [])
    return entries


def _counts(rows: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Of some mutants: how many were killed, are equivalent, and survived."""
    states = Counter(row["state"] for row in rows)
    killed = states["killed"] + states["timeout"]
    return {
        "sampled": len(rows),
        "killed": killed,
        "timeouts": states["timeout"],
        "equivalent": states["equivalent"],
        "survived": states["survived"],
    }


def numbers(
    rows: Sequence[dict[str, Any]],
    reviewed: Sequence[dict[str, str]],
    count: int,
    seeds: Mapping[int, Collection[str]],
) -> dict[str, Any]:
    """
    All numbers of the report.

    Parameters
    ----------
    rows : sequence of dict
      A mutant each, as the runner's ``Result`` names what is known of it.
    reviewed : sequence of dict
      Those that a reader found equivalent, with a reason.
    count : int
      Of each seed's sample.
    seeds : mapping
      Names of the mutants that each seed draws, run or not.

    Returns
    -------
    dict
      What JSON can hold.
    """
    reasons = {tuple(entry[name] for name in PLACE): entry["reason"] for entry in reviewed}
    mutants = []
    for row in rows:
        mutant = dict(row)
        reason = reasons.get(tuple(mutant[name] for name in PLACE))
        if reason and mutant["state"] == "survived":
            mutant["state"] = "equivalent"
        mutants.append(mutant)
    packages = sorted({mutant["group"] for mutant in mutants})
    return {
        "conditions": {
            "count": count,
            "asked": len(set().union(*seeds.values())),
            "seeds": {
                str(seed): _counts([mutant for mutant in mutants if mutant["name"] in names])
                for seed, names in seeds.items()
            },
            "tool": f"Cosmic Ray {version('cosmic-ray')}",
            "run": len(mutants),
        },
        "overall": _counts(mutants),
        "packages": {
            name: _counts([mutant for mutant in mutants if mutant["group"] == name]) for name in packages
        },
        "mutants": sorted(mutants, key=lambda mutant: tuple(mutant[name] for name in (*PLACE, "operator"))),
    }


def section(content: dict[str, Any] | None = None) -> str:
    """
    The report's part about the host library, as Markdown without a title.

    Parameters
    ----------
    content : dict, optional
      What :func:`numbers` gives; else what lies in ``docs/reports``.

    Returns
    -------
    str
    """
    content = json.loads(NUMBERS.read_text()) if content is None else content
    conditions, overall = content["conditions"], content["overall"]
    header = ("package", "sampled", "killed", "equivalent", "survived", "score (95 %)")

    def row(name: str, counts: dict[str, Any]) -> list[str]:
        shown = [str(counts[column]) for column in header[1:5]]
        return [name, *shown, score(counts["killed"], counts["survived"])]

    rows = [row(f"`{name}`", counts) for name, counts in content["packages"].items()]
    survivors = [mutant for mutant in content["mutants"] if mutant["state"] == "survived"]
    run, asked = conditions["run"], conditions["asked"]
    rest = (
        ""
        if run == asked
        else f"The sample is not complete: of {asked} mutants {asked - run} were not run yet. "
    )
    seeds = conditions["seeds"]
    if len(seeds) > 1:
        each = [
            f"of seed {seed} {counts['sampled']}, {score(counts['killed'], counts['survived'])}"
            for seed, counts in seeds.items()
        ]
        rest += f"Drawn and run are {'; '.join(each)}. "
    text = [
        fill(
            f'Written by `make mutation-python COUNT={conditions["count"]} SEED="{" ".join(seeds)}"`. '
            f"{rest}Mutants are made by "
            f"{conditions['tool']}, but for dropped statements; each file has its share of all places that "
            "can be changed. A mutant is run on quick tests of its package, without numba's compiler for its "
            "package's loops. "
            f"{overall['timeouts']} of those killed did not end.",
            130,
        ),
        "",
        markdown_table(header, [*rows, row("all", overall)], right=header[1:]),
    ]
    if survivors:
        text += ["", "Survivors:", ""]
        lines = [
            [
                f"`{mutant['path']}`",
                f"`{mutant['where'] or 'module'}`",
                *(f"`{mutant[name]}`" for name in ("old", "new")),
            ]
            for mutant in survivors
        ]
        text += [
            markdown_table(
                ("file", "function", "line", "mutant"),
                [[cell.replace("|", "\\|") for cell in line] for line in lines],
            )
        ]
    return "\n".join(text)


def write(
    rows: Sequence[dict[str, Any]],
    reviewed: Sequence[dict[str, str]],
    count: int,
    seeds: Mapping[int, Collection[str]],
    report: bool,
) -> int:
    """Say the score, write numbers and report if asked; how many mutants survive without a reason."""
    content = numbers(rows, reviewed, count, seeds)
    if report:
        write_numbers(NUMBERS, content)
        write_section("python", section(content))
    for name, counts in {**content["packages"], "all": content["overall"]}.items():
        print(f"{name}: " + ", ".join(f"{key} {value}" for key, value in counts.items()))
    return int(content["overall"]["survived"])
