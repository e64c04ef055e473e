# SPDX-License-Identifier: Apache-2.0
"""Tables in Markdown, for the documents that are written from what was measured."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence


def markdown_table(
    header: Sequence[str], rows: Iterable[Sequence[object]], right: Collection[str] = ()
) -> str:
    """
    A table in Markdown.

    Parameters
    ----------
    header : sequence of str
    rows : iterable of sequences
      A cell for each of the header; what is no text is written as ``str`` has it.
    right : collection of str, optional
      Columns of numbers, which stand to the right; all others are aligned as text is.

    Returns
    -------
    str
      Lines without a line break at the end.

    Raises
    ------
    ValueError
      A row has more or fewer cells than the header.
    """
    rules = ["---:" if name in right else "---" for name in header]
    lines = [list(header), rules, *(list(map(str, row)) for row in rows)]
    for line in lines:
        if len(line) != len(header):
            raise ValueError(f"a row of {len(line)} cells in a table of {len(header)} columns: {line}")
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)
