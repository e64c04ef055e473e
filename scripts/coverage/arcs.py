# SPDX-License-Identifier: Apache-2.0
"""
What a program compiled with ``-fprofile-arcs -ftest-coverage`` by gcc 12 has run, block by block.

gcov's own output does not say where a branch leads. GHDL guards every index and every range by a branch to a
failure, which no test takes; here such a branch is known by its end, and every other one has to be taken.
The files are those that gcc's ``gcov-io.h`` describes.
"""

from __future__ import annotations

import struct
from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from itertools import permutations
from pathlib import Path

FUNCTION, BLOCKS, ARCS, LINES, COUNTERS = 0x01000000, 0x01410000, 0x01430000, 0x01450000, 0x01A10000
ON_TREE, FAKE = 1, 2
VERSION = b"*22B"
"""Of the files' layout: that of gcc 12."""


@dataclass
class Arc:
    """A way from a block to another."""

    source: int
    target: int
    flags: int
    count: int | None = None


@dataclass
class Function:
    """
    A compiled process or subprogram.

    Attributes
    ----------
    name : str
    checksum : int
      Of its blocks and arcs: two compilations of one source have the same.
    lines : dict of int to list of (str, int)
      File and line of what a block executes, in order.
    """

    name: str
    checksum: int
    blocks: int = 0
    arcs: list[Arc] = field(default_factory=list)
    lines: dict[int, list[tuple[str, int]]] = field(default_factory=lambda: defaultdict(list))

    def counted(self) -> list[Arc]:
        """Those whose count the program writes; of the others it follows."""
        return [arc for arc in self.arcs if not arc.flags & ON_TREE]

    def solve(self, counters: list[int]) -> None:
        """
        Give every arc its count: what goes into a block comes out of it.

        Raises
        ------
        ValueError
          The counters are not this function's.
        """
        for arc in self.arcs:
            arc.count = None
        for arc, count in zip(self.counted(), counters, strict=True):
            arc.count = count
        into, out = self._by_block()
        open_blocks = set(range(2, self.blocks))
        while open_blocks:
            solved = {block for block in open_blocks if self._balance(into[block], out[block])}
            if not solved:
                raise ValueError(f"{self.name}: the counts of its arcs do not follow")
            open_blocks -= solved

    def _by_block(self) -> tuple[dict[int, list[Arc]], dict[int, list[Arc]]]:
        into: dict[int, list[Arc]] = {block: [] for block in range(self.blocks)}
        out: dict[int, list[Arc]] = {block: [] for block in range(self.blocks)}
        for arc in self.arcs:
            into[arc.target].append(arc)
            out[arc.source].append(arc)
        return into, out

    @staticmethod
    def _balance(into: list[Arc], out: list[Arc]) -> bool:
        """Find the one count of a block that is missing; true if none is missing afterwards."""
        unknown = [arc for arc in (*into, *out) if arc.count is None]
        if len(unknown) == 1:
            entered = sum(arc.count or 0 for arc in into)
            left = sum(arc.count or 0 for arc in out)
            unknown[0].count = abs(entered - left)
        return len(unknown) <= 1

    def executed(self) -> dict[tuple[str, int], int]:
        """How often the most executed block of each line was."""
        into, out = self._by_block()
        found: dict[tuple[str, int], int] = {}
        for block, places in self.lines.items():
            count = max(sum(arc.count or 0 for arc in arcs) for arcs in (into[block], out[block]))
            for place in places:
                found[place] = max(found.get(place, 0), count)
        return found

    def failing(self) -> set[int]:
        """Blocks after which the program ends: GHDL's checks, and what only they lead to."""
        _, out = self._by_block()
        found: set[int] = set()
        while True:
            more = {
                block
                for block, arcs in out.items()
                if arcs
                and block not in found
                and all(arc.flags & FAKE or arc.target in found for arc in arcs)
            }
            if not more:
                return found
            found |= more

    def branches(self) -> Iterator[tuple[tuple[str, int], int]]:
        """Place of a decision, and how often one of its ways was gone, for each way."""
        _, out = self._by_block()
        failing = self.failing()
        for block, arcs in out.items():
            ways = [arc for arc in arcs if not arc.flags & FAKE and arc.target not in failing]
            if len(ways) > 1 and block in self.lines and not self._is_of_assignment(block, ways, out):
                for arc in ways:
                    yield self.lines[block][-1], arc.count or 0

    def _is_of_assignment(self, block: int, ways: list[Arc], out: Mapping[int, list[Arc]]) -> bool:
        """
        Whether a branch belongs to GHDL's code of an assignment or a slice, not to a condition.

        That code asks where the driver's value is, or whether a range is empty: two blocks that meet at once.
        It asks whether a value is a new one, or a length a wrong one: only then it calls GHDL's library, and
        goes on as without. A condition's ways hold such code, and never only a block that does nothing of it.
        """

        def after(other: int) -> set[int]:
            return {arc.target for arc in out[other] if not arc.flags & FAKE}

        def calls(other: int) -> bool:
            return any(arc.flags & FAKE for arc in out[other])

        def skips(here: int, there: int, back: int) -> bool:
            return calls(here) and after(here) in ({there}, {back})

        def plain(other: int) -> list[int]:
            """Blocks in a row, without a call or a branch between."""
            row = [other]
            while len(after(row[-1])) == 1 and not calls(row[-1]) and not after(row[-1]) & set(row):
                row += after(row[-1])
            return row

        def checked(other: int) -> list[int]:
            """The same behind a check."""
            for here, there in permutations(after(other), 2):
                if len(after(other)) == 2 and not calls(other) and skips(here, there, other):
                    return plain(there)
            return []

        pair = [arc.target for arc in ways]
        here = set(self.lines[block])
        if len(pair) != 2 or any(not set(self.lines.get(other, ())) <= here for other in pair):
            return False
        one, two = pair
        if skips(one, two, block) or skips(two, one, block):
            return True
        if after(one) == after(two) and len(after(one)) == 1 and not calls(one) and not calls(two):
            return True
        return any(set(plain(here)[1:]) & set(checked(there)) for here, there in permutations(pair))


class _Reader:
    """Words and strings of a file."""

    def __init__(self, path: Path, magic: bytes) -> None:
        self.content, self.at = path.read_bytes(), 16
        if self.content[:8] != magic + VERSION:
            raise ValueError(f"{path}: not written by a program of gcc 12")

    def word(self) -> int:
        (value,) = struct.unpack_from("<I", self.content, self.at)
        self.at += 4
        return value

    def text(self) -> str:
        length = self.word()
        value = self.content[self.at : self.at + length].rstrip(b"\0").decode()
        self.at += length
        return value

    def records(self) -> Iterator[tuple[int, int]]:
        """Tag and signed length of every record; what a caller leaves of one is passed over."""
        while self.at + 8 <= len(self.content):
            tag, length = struct.unpack_from("<Ii", self.content, self.at)
            self.at += 8
            end = self.at + max(length, 0)
            yield tag, length
            self.at = end


def read_graph(path: Path) -> dict[int, Function]:
    """The functions of a ``.gcno`` by their number; raises ``ValueError`` for another compiler's."""
    reader = _Reader(path, b"oncg")
    reader.text()
    reader.word()
    functions: dict[int, Function] = {}
    for tag, length in reader.records():
        end = reader.at + length
        if tag == FUNCTION:
            number, _, checksum = reader.word(), reader.word(), reader.word()
            function = functions[number] = Function(reader.text(), checksum)
        elif tag == BLOCKS:
            function.blocks = reader.word()
        elif tag == ARCS:
            source = reader.word()
            while reader.at < end:
                function.arcs.append(Arc(source, reader.word(), reader.word()))
        elif tag == LINES:
            block, file = reader.word(), ""
            while reader.at < end:
                if line := reader.word():
                    function.lines[block].append((file, line))
                else:
                    file = reader.text()
    return functions


def read_counters(path: Path) -> dict[int, tuple[int, list[int]]]:
    """Checksum and counters of the functions of a ``.gcda`` by their number."""
    reader = _Reader(path, b"adcg")
    found: dict[int, tuple[int, list[int]]] = {}
    number = checksum = 0
    for tag, length in reader.records():
        if tag == FUNCTION and length:
            number, _, checksum = reader.word(), reader.word(), reader.word()
        elif tag == COUNTERS:
            # A function that never ran has a negative length, and no counters behind it.
            counters = [0] * (-length // 8)
            if length > 0:
                counters = list(struct.unpack_from(f"<{length // 8}q", reader.content, reader.at))
            found[number] = checksum, counters
    return found
