# SPDX-License-Identifier: Apache-2.0
"""
Edges in the fewest bits: the DDA of the smallest height with the same column in every scanline drawn.

A column k scanlines down is ``floor((r + k a) / h)`` past its whole steps. A segment of n scanlines has the
same columns for every slope of an open interval round a / h, and then for some remainder; the simplest
fraction in it mostly has a denominator below n, where the sub-pixel heights take ten bits and more.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from quadshade.contract.arrays import Ints
from quadshade.setup.packet import Primitives

MOST_TRIES = 256
"""Denominators tried; only a segment of more scanlines may need more, and those are few."""


@njit(cache=True)
def _remainders(columns: Ints, rows: int, slope: int, height: int) -> tuple[int, int]:
    """Least and greatest remainder with these columns, or an empty range."""
    least, most = 0, height - 1
    for k in range(1, rows):
        ahead = columns[k] * height - k * slope
        least, most = max(least, ahead), min(most, ahead + height - 1)
        if least > most:
            break
    return least, most


@njit(cache=True)
def _shorten(rows: Ints, remainder: Ints, increment: Ints, height: Ints, columns: Ints, tries: int) -> None:
    """Write the shortest (remainder, increment, height) of every edge over itself."""
    for p in range(len(rows)):
        count, r, a, h = rows[p], remainder[p], increment[p], height[p]
        if h <= 1 or count <= 0:
            continue
        value, column = r, 0
        for k in range(count):
            columns[k] = column
            value += a
            if value >= h:
                value -= h
                column += 1
        # Both neighbours of a / h for each denominator: if any other is in the interval, so is one of them.
        for choice in range(2, 2 * min(h, tries)):
            tried = choice // 2
            slope = a * tried // h + choice % 2
            least, most = _remainders(columns, count, slope, tried)
            if slope < tried and least <= most:
                # Nearest to an error of zero, which takes the fewest bits.
                remainder[p] = min(max(tried - slope, least), most)
                increment[p], height[p] = slope, tried
                break


def short_edges(primitives: Primitives, tries: int = MOST_TRIES) -> dict[str, dict[str, np.ndarray]]:
    """
    The edges of primitives in as few bits as their columns allow.

    Parameters
    ----------
    primitives : Primitives
    tries : int
      Denominators from 1 to below this are tried; as many as a segment has scanlines are enough.

    Returns
    -------
    dict of dict of (n,) int64
      As ``primitives.edges``: other errors, increments and decrements, the same columns in every scanline
      that is drawn, and the same carries between them.
    """
    first, second = primitives.header["rows_first"], primitives.header["rows_second"]
    rows = {"major": first + second, "minor": first, "second": second}
    longest = int(rows["major"].max(initial=1))
    columns = np.zeros(longest, np.int64)
    out = {}
    for name, edge in primitives.edges.items():
        height = edge["increment"] - edge["decrement"]
        remainder, increment = edge["error"] - edge["decrement"], edge["increment"].copy()
        _shorten(rows[name], remainder, increment, height, columns, tries)
        decrement = increment - height
        out[name] = edge | {
            "error": remainder + decrement, "increment": increment, "decrement": decrement,
        }  # fmt: skip
    return out
