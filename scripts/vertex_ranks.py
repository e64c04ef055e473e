# SPDX-License-Identifier: Apache-2.0
"""
What formal/link/vertex_unpacker.sv asserts at each address of ``vertex_unpacker``'s program, as a table.

Nothing in it is trusted: the proof shows over the netlist that every entry holds, and that the clocks to go
become fewer.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache
from typing import NamedTuple

from quadshade.contract.formats import Formats
from quadshade.contract.vertex_program import MIDDLES_AT, SCRATCH_AT, program
from quadshade.errors import QuadshadeError
from scripts.vertex_ways import (
    START,
    State,
    clocks_to_go,
    codes,
    own_by_address,
    reached,
    subroutines,
    writes,
)

ADDRESSES = 1 << 10
CELLS = ("t", "next_vertex", "next_middle")
"""Words of the memory that addresses come from: what is emptied, and where the tables go on."""
UNKNOWN, CONSTANT = 0, 1
"""How accumulator, or pointer, is known; of a cell and a constant: 2 and the cell's place in CELLS."""


class Row(NamedTuple):
    """
    What is asserted at an address; :data:`BITS` says in how many bits.

    ``rank``, less ``slope`` for each of the index, or of 8 of ``t`` where ``by_t``: the clocks to the end of
    the subroutine. ``own`` of them are the instruction's. ``site``: of the subroutine behind whose call it
    is. ``acc`` and ``pointer``: how known, the least constant, and how much greater it may be. Of the cells
    the least and the greatest value; of the last two only once parameters were begun.
    """

    code: int
    reached: int = 0
    owner: int = 0
    site: int = 0
    depth: int = 0
    rank: int = 0
    slope: int = 0
    by_t: int = 0
    own: int = 0
    index_low: int = 0
    index_high: int = 0
    acc: int = UNKNOWN
    acc_least: int = 0
    acc_more: int = 0
    pointer: int = UNKNOWN
    pointer_least: int = 0
    pointer_more: int = 0
    t_low: int = 0
    t_high: int = 0
    vertex_low: int = 0
    vertex_high: int = 0
    middle_low: int = 0
    middle_high: int = 0
    leaves: int = 0
    pads: int = 0


BITS = Row(31, 1, 3, 3, 2, 14, 12, 1, 7, 3, 3, 3, 18, 10, 3, 11, 10, 11, 11, 11, 11, 11, 11, 1, 1)
ANY = (0, (1 << 11) - 1)
"""Least and greatest value of a cell of which nothing is known."""


class Table(NamedTuple):
    """Rows by address; most clocks of a packet from its first bit on; where parameters begin the tables."""

    rows: tuple[Row, ...]
    bound: int
    told_at: int


def line_through(points: set[tuple[int | None, int]], unit: int) -> tuple[int, int]:
    """Rank at 0 and slope a unit of pairs of a number and a rank; of unknown numbers there is one rank."""
    numbers = sorted((number, rank) for number, rank in points if number is not None)
    slope = 0
    if len({rank for _, rank in points}) > 1:
        (low, most), (high, least) = numbers[0], numbers[-1]
        slope = (most - least) * unit // (high - low)
    (rank,) = {rank + slope * (number or 0) // unit for number, rank in points}
    return rank, slope


def kind_of(values: list[int | None], cells: list[int | None], cell: str) -> tuple[int, int, int]:
    """How numbers of an address' states are known, their least, and how much greater they may be."""
    known = [value for value in values if value is not None]
    if len(known) < len(values):
        return UNKNOWN, 0, 0
    if None not in cells:
        beyond = {value - (base or 0) for value, base in zip(known, cells, strict=True)}
        if len(beyond) == 1 and len(set(known)) > (cell == CELLS[0]):
            return 2 + CELLS.index(cell), beyond.pop(), 0
    # Before parameters are begun it may be another one, where it is not the constant of all ways.
    return (CONSTANT, min(known), max(known) - min(known)) if cell == CELLS[0] else (UNKNOWN, 0, 0)


def by_address(states: Iterable[State]) -> dict[int, list[State]]:
    """States of each address."""
    groups: dict[int, list[State]] = {}
    for state in states:
        groups.setdefault(state.at, []).append(state)
    return groups


def extremes(values: set[int | None]) -> tuple[int, int]:
    """The least and the greatest, or ANY where one is not known."""
    known = [value for value in values if value is not None]
    return (min(known), max(known)) if len(known) == len(values) > 0 else ANY


@lru_cache
def table(formats: Formats) -> Table:
    """
    The table.

    Raises
    ------
    QuadshadeError
      A packet may never end.
    """
    code, subs = codes(formats), subroutines(formats)
    edges = reached(START, formats, CELLS[0])
    own, to_go = own_by_address(formats, edges), clocks_to_go(formats, edges)
    # More is known of the tables' next entries from the write on that parameters begin with.
    place = program().places[CELLS[1]]
    begins = {state for state in edges if state.acc == 0 and writes(code[state.at], place)}
    (told_at,) = {state.at for state in begins}
    begun = begins.pop()._replace(at=told_at + 1, cell=None)
    analyses = [by_address(edges)]
    for first, cell in ((begun._replace(cell=0), CELLS[1]), (begun, CELLS[2])):
        analyses.append(by_address(reached(first, formats, cell)))
    sites = {at: number for number, places in subs.returns.items() for at in places}
    rows = []
    for at in range(ADDRESSES):
        bits = code[at].bits if at < len(code) else 0
        if at not in analyses[0]:
            rows.append(Row(code=bits))
            continue
        states = analyses[0][at]
        keys = {key for key in to_go if key[0] == at}
        by_t = len({key[1] for key in keys}) == 1 and len({to_go[key] for key in keys}) > 1
        points = {(key[1 + by_t], to_go[key]) for key in keys}
        low, high = extremes({state.index for state in states})
        groups = [(group.get(at, []), cell) for group, cell in zip(analyses, CELLS, strict=True)]
        known = []
        for name in ("acc", "pointer"):
            ways = [
                kind_of([getattr(state, name) for state in some], [state.cell for state in some], cell)
                for some, cell in groups
                if some
            ]
            known.append(max(ways, key=lambda way: way[0] != UNKNOWN))
        ranges = [extremes({state.cell for state in group.get(at, ())}) for group in analyses]
        ends = (at, subs.owner[at], sites.get(at, 0), subs.depth[at])
        rows.append(
            Row(
                *(bits, 1, *ends[1:], *line_through(points, 8 if by_t else 1), by_t, own[at]),
                *(low, min(high, 7), *known[0], *known[1], *(end for pair in ranges for end in pair)),
                any(state.leaves for state in states),
                any(state.pads for state in states),
            )
        )
    return Table(tuple(rows), rows[1].rank + 1, told_at)


def packed_rows(rows: tuple[Row, ...]) -> str:
    """Rows in hexadecimal, a line each, the first field highest: what $readmemh reads."""
    lines = []
    for row in rows:
        bits = 0
        for value, size in zip(row, BITS, strict=True):
            if not -(1 << size) < value < 1 << size:
                raise QuadshadeError(f"vertex_unpacker: {value} does not fit in {size} bits of the table")
            bits = bits << size | value % (1 << size)
        lines.append(f"{bits:0{(sum(BITS) + 3) // 4}x}\n")
    return "".join(lines)


def files(generics: dict[str, int]) -> dict[str, str]:
    """What the wrapper reads, by the files' names."""
    made = table(Formats(**generics))
    places = program().places
    numbers = {
        "ROW_BITS": sum(BITS),
        "BOUND": made.bound,
        "ROUND": max(row.slope * row.by_t for row in made.rows),
        "TOLD_AT": made.told_at,
        "PLACE_T": places["t"],
        "PLACE_VERTEX": places["next_vertex"],
        "PLACE_MIDDLE": places["next_middle"],
        "MIDDLES": MIDDLES_AT,
        "SCRATCH": SCRATCH_AT,
    }
    return {
        "vertex_unpacker_table.svh": "".join(f"`define {name} {value}\n" for name, value in numbers.items()),
        "vertex_unpacker_table.hex": packed_rows(made.rows),
    }
