# SPDX-License-Identifier: Apache-2.0
"""docs/reports/mutation.md: a section for the RTL and one for Python, each written by its own command."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path
from typing import Any

from quadshade.errors import QuadshadeError
from quadshade.files.atomic import write_text

REPORT = Path(__file__).resolve().parents[2] / "docs" / "reports" / "mutation.md"
Z_95 = 1.959964
"""Standard deviations on both sides of the mean that hold 95 % of a normal distribution."""


def wilson(hits: int, total: int, z: float = Z_95) -> tuple[float, float]:
    """
    Interval of a share that was sampled (E. B. Wilson, 1927).

    Parameters
    ----------
    hits, total : int
      Of the sample; the share is ``hits / total``.
    z : float

    Returns
    -------
    tuple of float
      Lower and upper end, from 0 to 1; all of it if nothing was sampled.
    """
    if total == 0:
        return 0.0, 1.0
    share, square = hits / total, z * z / total
    middle = (share + square / 2) / (1 + square)
    half = z / (1 + square) * math.sqrt(share * (1 - share) / total + square / (4 * total))
    return max(0.0, middle - half), min(1.0, middle + half)


def score(killed: int, alive: int) -> str:
    """Share of the mutants killed, with its interval: ``98.1 % (97.2 to 98.7)``."""
    total = killed + alive
    if total == 0:
        return "-"
    low, high = (100 * end for end in wilson(killed, total))
    return f"{100 * killed / total:.1f} % ({low:.1f} to {high:.1f})"


def with_section(report: str, name: str, text: str) -> str:
    """
    A report with one section's text replaced.

    Parameters
    ----------
    report : str
    name : str
      Of the section, between ``<!-- name begin -->`` and ``<!-- name end -->``.
    text : str
      Markdown.

    Raises
    ------
    QuadshadeError
      The report has no such section.
    """
    begin, end = f"<!-- {name} begin -->", f"<!-- {name} end -->"
    pattern = re.compile(rf"(?<={begin}\n).*?(?={end})", re.DOTALL)
    if not pattern.search(report):
        raise QuadshadeError(f"the report has no section {name}", f"put {begin} and {end} into {REPORT.name}")
    return pattern.sub(lambda _: text.strip() + "\n", report)


def write_section(name: str, text: str, report: Path = REPORT) -> None:
    """Replace one section of docs/reports/mutation.md; raises :class:`QuadshadeError` where it has none."""
    write_text(report, with_section(report.read_text(), name, text))


def write_numbers(path: Path, content: dict[str, Any]) -> None:
    """Write a report's numbers as JSON in which each entry of a list or of a table has a line of its own."""
    parts = []
    for name, value in content.items():
        text = json.dumps(value)
        if isinstance(value, list):
            text = "[\n" + ",\n".join(map(json.dumps, value)) + "\n]"
        elif isinstance(value, dict):
            text = "{\n" + ",\n".join(f"{json.dumps(key)}: {json.dumps(value[key])}" for key in value) + "\n}"
        parts.append(f"{json.dumps(name)}: {text}")
    write_text(path, "{" + ",\n".join(parts) + "}\n")
