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

use work.quadshade_pkg.all;
"""

OPERAND_BITS, COUNT_BITS, MODE_BITS = 16, 6, 2
PER_LINE = 9


def _number(row: source.Instruction, operand: int, count: int) -> int:
    """An instruction: count lowest, then operand (two's complement), mode, operation, whether it waits."""
    operation = source.OPERATIONS.index(row.operation) | row.waits << len(source.OPERATIONS).bit_length()
    bits = (operation << MODE_BITS | row.mode) << OPERAND_BITS
    return (bits | operand % (1 << OPERAND_BITS)) << COUNT_BITS | count


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
        texts = (row.operand, row.times)
        named = any(re.search(r"[a-z]", text) for text in texts)
        numbers = (0, 0) if named else tuple(source.value_of(text, None) for text in texts)
        fixed.append(str(_number(row, *numbers)))
        if named:
            operand, count = (vhdl_expression(text) for text in texts)
            open_.append(
                f"    code({place}) := code({place})"
                f" + ({operand}) mod 2 ** {OPERAND_BITS} * 2 ** {COUNT_BITS}"
                f"{'' if count == '0' else f' + {count}'};"
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
        f"  constant longest_prefix : positive := {source.LONGEST_PREFIX};",
        f"  constant run_bits : positive := {source.RUN_BITS};",
        f"  constant spent_bits : positive := {source.SPENT_BITS};",
        "",
        "  -- An instruction, lowest first: count, operand, mode, operation, whether the next one waits.",
        f"  constant count_bits : positive := {COUNT_BITS};",
        f"  constant operand_bits : positive := {OPERAND_BITS};",
        f"  constant mode_bits : positive := {MODE_BITS};",
        f"  constant operation_bits : positive := {len(source.OPERATIONS).bit_length()};",
        f"  constant mode_indexed : natural := {source.INDEXED};",
        f"  constant mode_immediate : natural := {source.IMMEDIATE};",
        *(f"  constant do_{name} : natural := {i};" for i, name in enumerate(source.OPERATIONS)),
        "",
        f"  constant num_instructions : positive := {len(instructions)};",
        "  function vertex_code(f : formats_t) return natural_vector_t;",
        "",
        "end package vertex_pkg;",
        "",
        "package body vertex_pkg is",
        "",
        "  function vertex_code(f : formats_t) return natural_vector_t is",
        f"    variable code : natural_vector_t(0 to {len(instructions) - 1}) := (",
        *(f"      {row}," for row in rows[:-1]),
        f"      {rows[-1]}",
        "    );",
        "  begin",
        *open_,
        "    return code;",
        "  end function vertex_code;",
        "",
    ]
    return "\n".join([*lines, "end package body vertex_pkg;", ""])
