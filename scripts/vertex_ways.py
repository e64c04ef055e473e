# SPDX-License-Identifier: Apache-2.0
"""
Every way through ``vertex_unpacker``'s program, and the clocks that it takes at most.

The program is run on what is known of its numbers: the index, constants, one word of the memory. A jump that
depends on others goes both ways, and a subroutine returns behind each of its calls, whichever it was.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import lru_cache
from graphlib import CycleError, TopologicalSorter
from typing import NamedTuple

from quadshade.contract.formats import SETUP_WORD_BITS, Formats
from quadshade.contract.vertex_program import (
    DIRECT,
    IMMEDIATE,
    JUMPS,
    MEMORY_WORDS,
    QUICK,
    Instruction,
    program,
    value_of,
)
from quadshade.errors import QuadshadeError
from quadshade.golden.link.vertex_machine import JUMP_CLOCKS
from scripts.generate_vhdl.vertices import encoded, steps

INDEX_VALUES = 8


class Code(NamedTuple):
    """An instruction with the formats' numbers, and its bits."""

    row: Instruction
    operand: int
    count: int
    bits: int


class State(NamedTuple):
    """
    At an instruction: numbers that are known, None of others; whether bits may still go out, or zeros up to
    the end of a word.
    """

    at: int
    index: int | None
    acc: int | None
    pointer: int | None
    cell: int | None
    leaves: bool
    pads: bool


START = State(0, None, None, None, None, False, False)


def writes(line: Code, place: int) -> bool:
    """Whether an instruction writes a named word of the memory."""
    return line.row.operation in ("st", "stq") and line.row.mode == DIRECT and line.operand == place


@lru_cache
def codes(formats: Formats) -> tuple[Code, ...]:
    """The program."""
    rows = []
    for row in program().instructions:
        operand, count = value_of(row.operand, formats), value_of(steps(row), formats)
        rows.append(Code(row, operand, count, encoded(row, operand, count)))
    return tuple(rows)


class Subroutines(NamedTuple):
    """Per address: number of the subroutine that it belongs to, and how deep; and behind whose call it is."""

    owner: dict[int, int]
    depth: dict[int, int]
    returns: dict[int, list[int]]


@lru_cache
def subroutines(formats: Formats) -> Subroutines:
    """Which addresses are whose; entries that share one are the same subroutine, the main program is 0."""
    code = codes(formats)
    bodies: list[tuple[set[int], set[int]]] = []
    for entry in sorted({0, *(line.operand for line in code if line.row.operation == "call")}):
        body, waiting, entries = set(), [entry], {entry}
        while waiting:
            at = waiting.pop()
            if at in body:
                continue
            body.add(at)
            name = code[at].row.operation
            if name in JUMPS and name != "call":
                waiting.append(code[at].operand)
            if name not in ("jmp", "ret"):
                waiting.append(at + 1)
        for other in [other for other in bodies if other[0] & body]:
            bodies.remove(other)
            body, entries = body | other[0], entries | other[1]
        bodies.append((body, entries))
    bodies.sort(key=lambda pair: min(pair[1]))
    owner = {at: number for number, (body, _) in enumerate(bodies) for at in body}
    calls = [at for at in owner if code[at].row.operation == "call"]
    returns = {number: [] for number in range(len(bodies))}
    for at in sorted(calls):
        returns[owner[code[at].operand]].append(at + 1)
    depths = {0: 0}
    for _ in bodies:
        for number, places in returns.items():
            for at in places:
                if owner[at] in depths:
                    depth = depths[owner[at]] + 1
                    if depths.setdefault(number, depth) != depth:
                        raise QuadshadeError("vertex_unpacker: a subroutine is called at two depths")
    return Subroutines(owner, {at: depths[number] for at, number in owner.items()}, returns)


def successors(
    state: State, code: tuple[Code, ...], subs: Subroutines, place: int
) -> Iterator[tuple[State, int]]:
    """
    What may come behind a state, and the clocks of a jump or of waiting.

    ``place`` is where the cell is. Behind a call comes what is called, behind a return every call of it.
    """
    line = code[state.at]
    name, operand = line.row.operation, line.operand
    value: int | None = None
    if line.row.mode == IMMEDIATE:
        value = operand
    elif line.row.mode == DIRECT and operand == place:
        value = state.cell
    behind = state._replace(at=state.at + 1)
    acc = state.acc
    if name == "ld":
        behind = behind._replace(acc=value)
    elif name in ("add", "sub"):
        known = acc is not None and value is not None
        behind = behind._replace(acc=(acc + value if name == "add" else acc - value) if known else None)
    elif name in ("st", "stq"):
        if writes(line, place):
            behind = behind._replace(cell=acc if name == "st" else None)
    elif name == "ldp":
        behind = behind._replace(pointer=None if value is None else value % MEMORY_WORDS)
    elif name == "ldx":
        behind = behind._replace(index=operand)
    elif name == "put":
        behind = behind._replace(leaves=True, pads=False)
    elif name == "word":
        behind = behind._replace(leaves=False, pads=False)
    elif name == "align":
        behind = behind._replace(pads=True)
    elif name == "raw" and (state.leaves or state.pads):
        raise QuadshadeError("vertex_unpacker: bits may go out amid packed words")
    elif name == "ldr":
        behind = behind._replace(acc=None)
    if name not in QUICK:
        behind = behind._replace(acc=None)
    taken = behind._replace(at=operand)
    jumps = {"jmp": True, "call": True}.get(name) if name in JUMPS else name == "ret"
    if name == "loop":
        if state.index is None:
            raise QuadshadeError("vertex_unpacker: a loop begins with any index")
        index = (state.index + 1) % INDEX_VALUES
        jumps, taken, behind = index < line.count, taken._replace(index=index), behind._replace(index=index)
    elif name in ("jz", "jnz", "jn", "jnn") and acc is not None:
        jumps = ((acc == 0) if "z" in name else (acc < 0)) != (name in ("jnz", "jnn"))
    if name == "ret":
        for at in subs.returns[subs.owner[state.at]]:
            yield behind._replace(at=at), JUMP_CLOCKS
        return
    if jumps is not False:
        yield taken, JUMP_CLOCKS
    if not jumps:
        yield behind, line.row.waits


def reached(first: State, formats: Formats, cell: str) -> dict[State, list[tuple[State, int]]]:
    """Every state that comes of one, and what comes behind each."""
    code, subs, place = codes(formats), subroutines(formats), program().places[cell]
    edges: dict[State, list[tuple[State, int]]] = {}
    waiting = [first]
    while waiting:
        state = waiting.pop()
        if state not in edges:
            edges[state] = list(successors(state, code, subs, place))
            waiting += [behind for behind, _ in edges[state]]
    return edges


def own_clocks(line: Code, leaves: bool, pads: bool) -> int:
    """
    Clocks of an instruction by itself, at most, where line and core do not make it wait.

    One of its operand, and if it is not over then: of a count of the memory another one, its steps, the words
    that are fetched, what has to go out before.
    """
    name, count = line.row.operation, line.count
    if name in QUICK or name == "start":
        return 1
    late = int(name in ("shl", "shr", "get", "take") and line.row.mode != IMMEDIATE)
    counts = range(64) if late else (count,)
    if name in ("shl", "shr"):
        return 1 + late + max(max(1, by // 4 + by % 4) for by in counts)
    if name in ("get", "take", "ones"):
        return 1 + late + max(max(1, by + 1 + (by > SETUP_WORD_BITS)) for by in counts)
    if name in ("put", "word"):
        return 2 + (SETUP_WORD_BITS + 2 if leaves else 1) + pads * (SETUP_WORD_BITS + 1)
    # Of a run: its first step, what is left of the word, a set-up word that waits.
    return 1 + max(1, count) + 3 * (name == "raw")


Key = tuple[int, int | None, int | None]
"""Address, index and ``t``, None where it is not known: what the clocks to go depend on."""


def clocks_to_go(formats: Formats, edges: dict[State, list[tuple[State, int]]]) -> dict[Key, int]:
    """
    Most clocks to the end of the subroutine, of the main program to the next packet.

    Raises
    ------
    QuadshadeError
      There is no such number: something jumps back without being counted.
    """
    code = codes(formats)
    ways: dict[Key, set[tuple[Key, int]]] = {}
    by_address: dict[int, set[Key]] = {}
    for state, after in edges.items():
        key = (state.at, state.index, state.cell)
        by_address.setdefault(state.at, set()).add(key)
        ends = state.at == 0 or code[state.at].row.operation == "ret"
        ways.setdefault(key, set()).update(
            () if ends else ((behind[:2] + (behind.cell,), clocks) for behind, clocks in after)
        )
    own = own_by_address(formats, edges)

    def returns(key: Key) -> set[Key]:
        """Where a call goes on, whatever is known then."""
        return by_address[key[0] + 1] if code[key[0]].row.operation == "call" else set()

    graph = {key: {way for way, _ in after} | returns(key) for key, after in ways.items()}
    known: dict[Key, int] = {}
    try:
        for key in TopologicalSorter(graph).static_order():
            name = code[key[0]].row.operation
            longest = max(
                (known[way] + clocks for way, clocks in ways[key]), default=JUMP_CLOCKS * (name == "ret")
            )
            known[key] = own[key[0]] + longest + max((known[way] for way in returns(key)), default=0)
    except CycleError as error:
        raise QuadshadeError(
            f"vertex_unpacker: from address {error.args[1][0][0]} of its program on a packet may never end"
        ) from error
    return known


def own_by_address(formats: Formats, edges: Iterable[State]) -> dict[int, int]:
    """Most clocks of the instruction at each address by itself."""
    code = codes(formats)
    own: dict[int, int] = {}
    for state in edges:
        own[state.at] = max(own.get(state.at, 0), own_clocks(code[state.at], state.leaves, state.pads))
    return own
