# SPDX-License-Identifier: Apache-2.0
"""
The program of ``vertex_unpacker``: packets that carry vertices, to the set-up words of a triangle.

The one source: ``scripts/generate_vhdl`` writes ``rtl/generated/vertex_pkg.vhd`` from it, and the golden
model runs it. The unit is an accumulator, a second operand, a shift register, a memory of ``MEMORY_WORDS``
words and a row of instructions; ``docs/reference/vertices.md`` explains both.

A line is ``label:`` or ``operation operand, count``. An operand is a name (a word of the memory), ``p+1`` (a
word behind the pointer, the index added) or ``#`` and a number, an expression over the names of
:class:`Formats` that means the same in Python and in VHDL.
"""

from __future__ import annotations

import re
from functools import lru_cache
from typing import NamedTuple

from quadshade.contract.formats import Formats
from quadshade.contract.vertex_text import program_text
from quadshade.contract.width_expressions import evaluate
from quadshade.errors import QuadshadeError

REVISION = 1
"""
Of what a packet with vertices means: its bits, and the set-up words that come of them. Another order of the
same sums is the same revision.
"""

WIDTH = 50
"""Bits of a word of the memory, two's complement; sums and differences are cut to it."""

RATIO_FRAC = 32
"""Fraction bits of what a vertex' colour is multiplied by."""

SAMPLE_FRAC = 4
"""Least fraction bits of a vertex' colour; ``shift_colour`` says how many more there are."""

MEMORY_WORDS = 1024
VERTICES, VERTEX_WORDS = 64, 8
MIDDLES, MIDDLE_WORDS = 64, 4
MIDDLES_AT = VERTICES * VERTEX_WORDS
SCRATCH_AT = MIDDLES_AT + MIDDLES * MIDDLE_WORDS

LONGEST_PREFIX, LONG_BITS = 15, 24
"""A residual with so many ones before it is sent whole, in so many bits."""

RUN_BITS = 24
"""Of the number of packed words that pass as they are."""

LARGEST_RUN = (1 << RUN_BITS) - 1

PREFIXES = ("k_place", "k_colour", "k_depth", "k_middle")
PARAMETERS = (*PREFIXES, "shift_colour", "shift_depth")
PARAMETER_BITS = 5
LARGEST_TRIM = LONGEST_PREFIX
LARGEST_SPAN = 16
"""Bits of a difference of two coordinates of a triangle, in sub-pixels."""

LIMITS = (
    ("stream_width", 32, 32),
    ("with_shade", 0, 0),
    ("num_channels", 1, MIDDLE_WORDS),
    ("max_order", 1, 2),
    ("subpixel_bits", 5, 12),
    ("coord_bits + subpixel_bits", 8, 20),
    ("word_width", 12, 32),
    ("word_width - frac_bits", 4, WIDTH - RATIO_FRAC - SAMPLE_FRAC),
    ("depth_bits * with_depth", 0, 16),
)
"""What a board with this unit is: expression, lowest and highest value."""

OPERATIONS = (
    *("ld", "add", "sub", "ldq", "ldr", "muli", "mulf", "div", "st", "stq", "ldp", "ldx", "loop"),
    *("fold", "shl", "shr", "put", "get", "take", "ones", "start", "raw", "word", "align"),
    *("jmp", "jz", "jnz", "jn", "jnn", "call", "ret"),
)
"""
``ld add sub``  the accumulator is, or adds, or subtracts, the operand
``ldq``         the shift register is the operand
``ldr``         the accumulator is the shift register
``muli``        add operand x the lowest ``count`` bits of the shift register, signed, two a clock until the
                others are all the same
``mulf``        the same, of all bits, and then shift right by ``count``: towards minus infinity
``div``         ``count`` steps of the non-restoring division of accumulator and shift register by the operand
``st stq``      the memory gets the accumulator, or the shift register
``ldp ldx``     the pointer, or the index, is the operand; of the index a number of the program
``loop``        add one to the index, and jump as long as it is below ``count``
``shl shr``     shift the accumulator by the operand, arithmetically, four bits a clock
``get``         shift so many bits of the line in
``take``        the same, into an accumulator of 0
``ones``        the accumulator is the number of ones before the next zero, ``LONGEST_PREFIX`` at most
``fold``        0, 1, 2, 3, 4 become 0, -1, 1, -2, 2
``start``       skip zeros and a one
``raw``         pass as many words as the accumulator says, from the next whole one on, then finish the packet
``put word``    so many bits of the accumulator go out, two a clock, while the program goes on; a whole set-up
                word of a difference does
``align``       zeros up to the end of the set-up word
``jmp jz jnz jn jnn call ret``  jumps: always, if the accumulator's lowest bits are zero, are not, if it is
                negative, is not
"""

ZERO_BITS = 16
"""Of them ``jz`` and ``jnz`` look at: numbers of a few bits, differences of coordinates."""

JUMPS = ("jmp", "jz", "jnz", "jn", "jnn", "call", "loop")
QUICK = ("ld", "add", "sub", "ldq", "ldr", "st", "stq", "ldp", "ldx", "ret", *JUMPS)
"""
Operations that take the clock of their operand alone, in whose end the next instruction's is read. What
``ld``, ``ldq``, ``add`` and ``sub`` make of it is there a clock later.
"""

NEEDS_ACC = ("st", "jz", "jnz", "jn", "jnn", "raw")
"""Operations that read the accumulator in the clock of their operand; ``st`` behind ``ld`` writes that."""

SPENT_BITS = 22
"""``muli`` is over when so many lowest bits of the shift register, but the last, are the same."""

DIRECT, INDEXED, IMMEDIATE = 0, 1, 2


class Instruction(NamedTuple):
    """
    An operation of :data:`OPERATIONS`, where its operand is, the operand and the count, expressions both, and
    whether the next operand can only be read a clock after it.
    """

    operation: str
    mode: int
    operand: str
    times: str
    waits: int


class Program(NamedTuple):
    """Instructions, and where the named words of the memory are."""

    instructions: tuple[Instruction, ...]
    places: dict[str, int]


# The memory has a prefix' parameter with LONGEST_PREFIX added; behind ``halves``, channel by channel, depth
# last, what rounds a word, and by how much it is shifted then.
RESERVED = (
    *PARAMETERS,
    *("major", "major_step", "minor", "minor_step"),
    *("halves", "half_1", "half_2", "half_3", "half_4"),
    *("shifts", "shift_1", "shift_2", "shift_3", "shift_4"),
)

_CONSTANTS = {
    "RUN_BITS": RUN_BITS,
    "PARAMETER_BITS": PARAMETER_BITS,
    "RATIO_FRAC": RATIO_FRAC,
    "SAMPLE_FRAC": SAMPLE_FRAC,
    "MIDDLES_AT": MIDDLES_AT,
    "SCRATCH_AT": SCRATCH_AT,
    "VERTEX_WORDS": VERTEX_WORDS,
    "MIDDLE_WORDS": MIDDLE_WORDS,
    "LONGEST_PREFIX": LONGEST_PREFIX,
    "LONG_BITS": LONG_BITS,
    "len_prefixes": len(PREFIXES),
}


def _constant(text: str) -> str:
    """An expression with the names of this module as numbers."""
    return re.sub(r"\w+", lambda found: str(_CONSTANTS.get(found[0], found[0])), text)


@lru_cache(maxsize=1)
def program() -> Program:
    """The program, assembled."""
    rows = [row for row in (part.strip() for part in re.split("[;\n]", program_text())) if row]
    labels: dict[str, int] = {}
    code: list[str] = []
    for row in rows:
        if row.endswith(":"):
            labels[row[:-1]] = len(code)
        else:
            code.append(row)
    places = {name: SCRATCH_AT + index for index, name in enumerate(RESERVED)}
    instructions = []

    def place(name: str) -> str:
        places.setdefault(name, SCRATCH_AT + len(set(places.values())))
        return str(places[name])

    for row in code:
        operation, _, rest = row.partition(" ")
        text, _, count = (part.strip() for part in rest.partition(","))
        mode, operand = IMMEDIATE, "0"
        if operation in JUMPS:
            operand = str(labels[text])
        elif text.startswith("#@"):
            operand = place(text[2:])
        elif text.startswith("#"):
            operand = _constant(text[1:])
        elif text.startswith("p+"):
            mode, operand = INDEXED, text[2:]
        elif text:
            mode, operand = DIRECT, place(text)
        instructions.append(Instruction(operation, mode, operand, _constant(count) or "0", 0))
    pairs = zip(instructions, [*instructions[1:], instructions[0]], strict=True)
    return Program(tuple(row._replace(waits=_waits(row, behind)) for row, behind in pairs), places)


def _waits(row: Instruction, behind: Instruction) -> int:
    """1 where the instruction behind reads what this one writes."""
    if row.operation in ("ldp", "ldx", "loop"):
        return int(behind.mode == INDEXED)
    if row.operation in ("add", "sub"):
        return int(behind.operation in NEEDS_ACC)
    if row.operation == "ld":
        return int(behind.operation in NEEDS_ACC and behind.operation != "st")
    if row.operation == "ldq":
        return int(behind.operation in ("stq", "ldr"))
    if row.operation in ("st", "stq"):
        apart = row.mode == behind.mode == DIRECT and row.operand != behind.operand
        return int(behind.mode != IMMEDIATE and behind.operation not in ("st", "stq") and not apart)
    return 0


def instruction_clocks(operation: str, count: int, waits: int) -> int:
    """
    Clocks of an instruction that are always the same.

    Those of operations that take as many as a number says are counted when it is known.
    """
    steps = {"mulf": count // 2, "div": count}.get(operation, 1)
    if operation in (*QUICK, "muli", "shl", "shr", "get", "take", "ones", "start"):
        steps = 0
    return 1 + steps + waits


def check_formats(formats: Formats) -> None:
    """Raise :class:`QuadshadeError` where ``vertex_unpacker`` cannot be built."""
    for expression, low, high in LIMITS:
        value = formats.evaluate(expression)
        if not low <= value <= high:
            raise QuadshadeError(f"{expression} is {value}", f"packets with vertices need {low} to {high}")


def takes_formats(formats: Formats) -> bool:
    """Whether ``vertex_unpacker`` can be built with formats."""
    return all(low <= formats.evaluate(expression) <= high for expression, low, high in LIMITS)


def value_of(expression: str, formats: Formats | None) -> int:
    """Value of an operand or a count; without formats it has no name."""
    return evaluate(expression, formats)


@lru_cache
def evaluated(formats: Formats) -> tuple[tuple[int, int, int, int, int], ...]:
    """Number of the operation, mode, operand, count and clocks of every instruction with formats' numbers."""
    rows = []
    for row in program().instructions:
        count = value_of(row.times, formats)
        clocks = instruction_clocks(row.operation, count, row.waits)
        rows.append(
            (OPERATIONS.index(row.operation), row.mode, value_of(row.operand, formats), count, clocks)
        )
    return tuple(rows)
