# SPDX-License-Identifier: Apache-2.0
"""The report of coverage."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from math import prod

from quadshade.files.markdown import markdown_table
from scripts.coverage.functional import Cross
from scripts.coverage.rtl_coverage import KINDS, FileCoverage

HEAD = """\
<!-- SPDX-License-Identifier: Apache-2.0 -->
# Coverage of the RTL

Written by `make coverage`, which runs every cocotb bench with counters in the compiled VHDL, and fails
where a line or a way of a decision was not run and has no reason below, or where a reason has no such
line any more. [What is counted](../explanation/coverage.md).

"""


def share(done: int, total: int) -> str:
    """A share in percent, rounded down, so that only all is 100."""
    return f"{1000 * done // total / 10:.1f} %" if total else ""


def page(
    found: Mapping[str, FileCoverage],
    exceptions: Sequence[Mapping[str, str]],
    excused: Counter[tuple[str, str]],
    crosses: Sequence[Cross],
    made: str,
) -> str:
    """
    The report.

    Parameters
    ----------
    found : mapping of str to FileCoverage
    exceptions : sequence of mappings
      See :func:`scripts.coverage.rtl_coverage.check`.
    excused : Counter
      By file and kind.
    crosses : sequence of Cross
    made : str
      Versions of what ran it.

    Returns
    -------
    str
    """
    header = ("file", "statements", "run", "with a reason", "ways of decisions", "gone", "with a reason ")
    rows = []
    for name, file in sorted(found.items()):
        cells: list[object] = [f"`{name}`"]
        for kind in KINDS:
            total, without = file.total(kind), excused[name, kind]
            cells += [total, total - without, without or ""]
        rows.append(cells)
    sums: list[object] = ["all"]
    for kind in KINDS:
        total, without = (
            sum(file.total(kind) for file in found.values()),
            sum(count for (_, other), count in excused.items() if other == kind),
        )
        sums += [total, f"{total - without} ({share(total - without, total)})", without or ""]
    table = markdown_table(header, [*rows, sums], right=set(header[1:]))
    reasons = markdown_table(
        ("file", "line", "what was not run", "why"),
        [
            (
                f"`{row['file']}`",
                f"`{row['line']}`",
                row["kind"] if row["kind"] == "statement" else f"{row['ways']} of its ways",
                row["why"],
            )
            for row in exceptions
        ],
    )
    parts = [f"{HEAD}{table}", f"## Lines with a reason\n\n{reasons}", *map(_cross_section, crosses)]
    return "\n\n".join([*parts, f"Made with {made}.\n"])


def _cross_section(cross: Cross) -> str:
    """What a cross is made of, how much of it was driven, and why the rest cannot be."""
    values = markdown_table(
        ("what varies", "values"), [(name, ", ".join(some)) for name, some in cross.bins.items()]
    )
    possible = cross.possible
    driven = [one for one in possible if cross.hits[one]]
    total = prod(map(len, cross.bins.values()))
    text = (
        f"{len(driven)} of {len(possible)} possible combinations were driven "
        f"({share(len(driven), len(possible))}), {total - len(possible)} of {total} cannot be"
    )
    parts = [f"## Stimuli: {cross.name}", values, text + (":" if cross.impossible else ".")]
    if cross.impossible:
        rows = [
            (why, "; ".join(f"{name}: {', '.join(some)}" for name, some in where.items()))
            for why, where in cross.impossible
        ]
        parts.append(markdown_table(("why it cannot be", "what"), rows))
    return "\n\n".join(parts)
