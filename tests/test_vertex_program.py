# SPDX-License-Identifier: Apache-2.0
"""The program that decodes packets with vertices: formats that it takes, its clocks, that it ends."""

from __future__ import annotations

import zlib

import numpy as np
import pytest

from quadshade.contract.formats import Formats
from quadshade.contract.vertex_program import (
    DIRECT,
    IMMEDIATE,
    INDEXED,
    JUMPS,
    MEMORY_WORDS,
    OPERATIONS,
    REVISION,
    SCRATCH_AT,
    Instruction,
    _waits,
    check_formats,
    instruction_clocks,
    program,
    takes_formats,
)
from quadshade.errors import QuadshadeError
from quadshade.golden.link.vertex_unpacker import VertexUnpacker


@pytest.mark.parametrize(
    ("fits", "beyond", "said"),
    [
        ({}, {"stream_width": 64}, "stream_width is 64"),
        ({}, {"num_channels": 2, "with_shade": 1}, "with_shade is 1"),
        ({"num_channels": 4}, {"num_channels": 5}, "num_channels is 5"),
        ({"max_order": 1}, {"max_order": 0}, "max_order is 0"),
        ({"subpixel_bits": 5}, {"subpixel_bits": 4}, "subpixel_bits is 4"),
        ({"coord_bits": 8, "subpixel_bits": 12}, {"coord_bits": 9, "subpixel_bits": 12}, "is 21"),
        ({"word_width": 32}, {"word_width": 33, "frac_bits": 23}, "word_width is 33"),
        ({"word_width": 32, "frac_bits": 18}, {"word_width": 32, "frac_bits": 17}, "frac_bits is 15"),
        ({"depth_bits": 16}, {"depth_bits": 17}, "depth_bits * with_depth is 17"),
        ({"depth_bits": 17, "with_depth": 0}, {"depth_bits": 17}, "depth_bits * with_depth is 17"),
    ],
)
def test_formats_of_a_board_that_takes_vertices(fits: dict, beyond: dict, said: str) -> None:
    """Each limit from both sides."""
    check_formats(Formats(**fits))
    assert takes_formats(Formats(**fits)) and not takes_formats(Formats(**beyond))
    with pytest.raises(QuadshadeError) as error:
        check_formats(Formats(**beyond))
    assert said in str(error.value)


def test_the_program_ends_each_packet() -> None:
    """But for counted loops no instruction comes twice in a packet, and every call finds its way back."""
    code = program().instructions
    counted = {pc for pc, row in enumerate(code) if row.operation == "loop"}
    start = next(pc for pc, row in enumerate(code) if row.operation == "start")

    def follows(pc: int) -> list[int]:
        row = code[pc]
        if row.operation == "ret":
            return []
        target = [int(row.operand)] if row.operation in JUMPS and pc not in counted else []
        # The next packet begins anew.
        return [at for at in target + [pc + 1] * (row.operation != "jmp") if at != start]

    cleared = [
        (pc, int(row.operand))
        for pc, row in enumerate(code)
        if row.operation in ("jz", "jnz", "jn", "jnn") and start < int(row.operand) <= pc
    ]
    # Tables are emptied eight words a time, up to their end: the only jump back that is not counted.
    ((back, begin),) = cleared
    rises = [row[:3] for row in code[begin:back]]
    assert ("add", IMMEDIATE, "8") in rises and ("add", IMMEDIATE, f"0 - {SCRATCH_AT}") in rises
    depths: dict[int, int] = {}
    open_: set[int] = set()

    def depth(pc: int) -> int:
        """Calls that an instruction and those behind it make, one within another."""
        assert pc not in open_, f"instruction {pc} comes again"
        if pc not in depths:
            open_.add(pc)
            calls = code[pc].operation == "call"
            ways = [at for at in follows(pc) if (pc, at) != (back, begin)]
            depths[pc] = max((depth(at) + (calls and at != pc + 1) for at in ways), default=0)
            open_.discard(pc)
        return depths[pc]

    # From the end on, so that no way is deep; what comes again is met before that.
    for pc in reversed(range(len(code))):
        depth(pc)
    assert 1 <= depth(start) <= 3
    assert all(0 <= int(row.operand) < len(code) for row in code if row.operation in JUMPS)
    assert len(code) <= 1024 and max(program().places.values()) < MEMORY_WORDS


@pytest.mark.parametrize(
    ("row", "behind", "waits"),
    [
        # What is read must have been written, and an indexed word may be any.
        ("st", ("ld", DIRECT, "9"), 1),
        ("st", ("ld", DIRECT, "8"), 0),
        ("st", ("ld", INDEXED, "9"), 1),
        ("st", ("ld", IMMEDIATE, "9"), 0),
        ("st", ("st", DIRECT, "9"), 0),
        ("stq", ("stq", INDEXED, "9"), 0),
        ("stq", ("muli", DIRECT, "9"), 1),
        ("ldp", ("ld", INDEXED, "0"), 1),
        ("ldx", ("st", INDEXED, "0"), 1),
        ("loop", ("ld", INDEXED, "0"), 1),
        ("ldp", ("ld", DIRECT, "0"), 0),
        ("add", ("jz", IMMEDIATE, "3"), 1),
        ("sub", ("st", DIRECT, "9"), 1),
        ("sub", ("ldq", DIRECT, "9"), 0),
        ("ld", ("jn", IMMEDIATE, "3"), 1),
        ("ld", ("st", DIRECT, "8"), 0),
        ("ld", ("add", DIRECT, "8"), 0),
        ("ldq", ("stq", DIRECT, "8"), 1),
        ("ldq", ("ldr", IMMEDIATE, "0"), 1),
        ("ldq", ("muli", DIRECT, "8"), 0),
        ("fold", ("jz", IMMEDIATE, "3"), 0),
    ],
)
def test_what_waits_for_the_instruction_before(row: str, behind: tuple[str, int, str], waits: int) -> None:
    assert _waits(Instruction(row, DIRECT, "9", "0", 0), Instruction(*behind, "0", 0)) == waits


def test_clocks_of_an_instruction() -> None:
    """That of its operand, and a step each: two bits of a factor, one of a quotient."""
    clocks = {"mulf": 19, "div": 37, "fold": 2, "put": 2, "align": 2}
    for operation in OPERATIONS:
        for waits in (0, 1):
            wanted = waits + clocks.get(operation, 2 if operation in ("raw", "word") else 1)
            assert instruction_clocks(operation, 36, waits) == wanted, operation


def test_a_revision_means_the_same_words() -> None:
    """What comes of any words for a board's whole life: with another answer REVISION has to rise."""
    words = np.random.default_rng(20).integers(0, 1 << 32, 600, dtype=np.uint64).astype(np.uint32)
    head = np.array([0x00A28CB3], np.uint32)
    given = VertexUnpacker(Formats()).feed(np.concatenate([head, words | 1]))
    assert (REVISION, len(given), zlib.crc32(given.astype("<u4").tobytes())) == (1, 1568, 1071336866)
