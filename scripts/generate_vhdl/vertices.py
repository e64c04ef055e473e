# SPDX-License-Identifier: Apache-2.0
"""The text of ``rtl/generated/vertex_pkg.vhd`` from ``quadshade.contract.vertex_program``."""

from __future__ import annotations

import re
from collections.abc import Callable

from quadshade.contract import vertex_program as source

HEADER = """\
-- SPDX-License-Identifier: Apache-2.0
--
-- The program of vertex_unpacker: its operations, and its instructions with the formats' numbers.
--
-- Written by scripts/generate_vhdl from model/quadshade/contract/vertex_program.py: change it, `make rtl`.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

use work.quadshade_pkg.all;
"""

OPERAND_BITS, COUNT_BITS, MODE_BITS = 16, 6, 2
PER_LINE = 8


def encoded(row: source.Instruction, operand: int, count: int) -> int:
    """
    An instruction: count lowest, then operand (two's complement), mode, operation, whether the next one
    waits, and whether it is one of ``QUICK``.
    """
    flags = row.waits | (row.operation in source.QUICK) << 1
    operation = source.OPERATIONS.index(row.operation) | flags << len(source.OPERATIONS).bit_length()
    bits = (operation << MODE_BITS | row.mode) << OPERAND_BITS
    return (bits | operand % (1 << OPERAND_BITS)) << COUNT_BITS | count


def steps(row: source.Instruction) -> str:
    """The count as the unit has it: steps of an operation whose operand does not say them; a loop's end."""
    if row.operation in ("muli", "mulf"):
        return f"({row.times}) / 2"
    if row.operation in ("shl", "shr", "get", "take") and row.mode == source.IMMEDIATE:
        return row.operand
    return {"ones": str(source.LONGEST_PREFIX), "raw": "1"}.get(row.operation, row.times)


def package(vhdl_expression: Callable[[str], str]) -> str:
    """
    The package.

    Parameters
    ----------
    vhdl_expression : callable
      Turns a width expression into VHDL.
    """
    instructions = source.program().instructions
    fixed, open_ = [], []
    for place, row in enumerate(instructions):
        texts = (row.operand, steps(row))
        named = any(re.search(r"[a-z]", text) for text in texts)
        numbers = (0, 0) if named else tuple(source.value_of(text, None) for text in texts)
        fixed.append(str(encoded(row, *numbers)))
        if named:
            operand, count = (vhdl_expression(text) for text in texts)
            open_.append(
                f"    code({place}) := code({place})"
                f" + ({operand}) mod 2 ** {OPERAND_BITS} * 2 ** {COUNT_BITS}"
                f"{'' if count == '0' else chr(10) + f'      + {count}'};"
            )
    rows = [", ".join(fixed[at : at + PER_LINE]) for at in range(0, len(fixed), PER_LINE)]
    lines = [
        HEADER,
        "package vertex_pkg is",
        "",
        "  -- Bits of the memory's words, fraction bits of colours' factors, least ones of them.",
        f"  constant vertex_width : positive := {source.WIDTH};",
        f"  constant ratio_frac : positive := {source.RATIO_FRAC};",
        f"  constant sample_frac : positive := {source.SAMPLE_FRAC};",
        f"  constant memory_words : positive := {source.MEMORY_WORDS};",
        f"  constant run_bits : positive := {source.RUN_BITS};",
        f"  constant spent_bits : positive := {source.SPENT_BITS};",
        f"  constant zero_bits : positive := {source.ZERO_BITS};",
        "",
        "  -- An instruction, lowest first: count, operand, mode, operation, whether the next one waits, and",
        "  -- whether it takes the clock of its operand alone.",
        f"  constant count_bits : positive := {COUNT_BITS};",
        f"  constant operand_bits : positive := {OPERAND_BITS};",
        f"  constant mode_bits : positive := {MODE_BITS};",
        f"  constant operation_bits : positive := {len(source.OPERATIONS).bit_length()};",
        "  constant mode_low : positive := count_bits + operand_bits;",
        "  constant operation_low : positive := mode_low + mode_bits;",
        "  constant waits_at : positive := operation_low + operation_bits;",
        "  constant quick_at : positive := waits_at + 1;",
        "  subtype vertex_code_t is std_ulogic_vector(quick_at downto 0);",
        "  constant program_bits : positive := 10;",
        "  type vertex_program_t is array (0 to 2 ** program_bits - 1) of vertex_code_t;",
        f"  constant indexed_at : positive := mode_low + {source.INDEXED.bit_length() - 1};",
        f"  constant immediate_at : positive := mode_low + {source.IMMEDIATE.bit_length() - 1};",
        *(f"  constant do_{name} : natural := {i};" for i, name in enumerate(source.OPERATIONS)),
        "",
        f"  constant num_instructions : positive := {len(instructions)};",
        "  function vertex_program(f : formats_t) return vertex_program_t;",
        "",
        "end package vertex_pkg;",
        "",
        "package body vertex_pkg is",
        "",
        "  function vertex_program(f : formats_t) return vertex_program_t is",
        f"    variable code : natural_vector_t(0 to {len(instructions) - 1}) := (",
        *(f"      {row}," for row in rows[:-1]),
        f"      {rows[-1]}",
        "    );",
        "    variable result : vertex_program_t := (others => (others => '0'));",
        "  begin",
        *open_,
        "    for index in code'range loop",
        "      result(index) := std_ulogic_vector(to_unsigned(code(index), vertex_code_t'length));",
        "    end loop;",
        "    return result;",
        "  end function vertex_program;",
        "",
    ]
    return "\n".join([*lines, "end package body vertex_pkg;", ""])
