# SPDX-License-Identifier: Apache-2.0
"""The text of ``rtl/generated/link_pkg.vhd`` from ``quadshade.contract.protocol``."""

from __future__ import annotations

from quadshade.contract import protocol
from quadshade.contract.protocol import OPTIONAL, PAYLOADS, WORD_BYTES, Opcode, Reason

HEADER = """\
-- SPDX-License-Identifier: Apache-2.0
--
-- The link protocol: opcodes, lengths, reasons, counters, and what HELLO says of a board.
--
-- Written by scripts/generate_vhdl from model/quadshade/contract/protocol.py: change that, then `make rtl`.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

use work.quadshade_pkg.all;
"""

BYTE = "std_ulogic_vector(7 downto 0)"
WORD = "std_ulogic_vector(31 downto 0)"
CONSTANTS = (
    *("header_bytes", "crc_bytes", "max_body", "phase_bits", "break_bits", "max_read", "edge_bytes"),
    *("packed", "escape_ones"),
)


def requests() -> list[Opcode]:
    """What the board takes."""
    return [opcode for opcode in PAYLOADS if not opcode.is_answer]


def choices(result: str, values: dict[Opcode, str]) -> list[str]:
    """
    Lines that give a variable the value of its opcode, or leave it.

    Not a case statement: GHDL 2.0 forgets its ``when others`` in the netlist, if it stands in a function.
    """
    lines = []
    for opcode, value in values.items():
        lines += [
            f"    if opcode = opcode_{opcode.name.lower()} then",
            f"      {result} := {value};",
            "    end if;",
        ]
    return lines


def length_function(name: str, which: int, why: str) -> list[str]:
    """Lines of a function from a request's opcode to its shortest or longest payload in words."""
    lengths = {opcode: PAYLOADS[opcode].lengths[which] // WORD_BYTES for opcode in requests()}
    return [
        f"  -- {why}",
        f"  function {name}(opcode : {BYTE}) return u_unsigned is",
        "    variable words : u_unsigned(7 downto 0) := (others => '0');",
        "  begin",
        *choices(
            "words", {opcode: f"to_unsigned({length}, 8)" for opcode, length in lengths.items() if length}
        ),
        "    return words;",
        f"  end function {name};",
        "",
    ]


def identity_source(name: str) -> str:
    """The VHDL expression of a field of HELLO's identity, but for magic and definition."""
    if name in [field for field, _, _ in protocol.BOARD_FIELDS]:
        return f"board.{name}"
    if name in [field for field, _, _ in protocol.GENERIC_FIELDS]:
        return f"f.{name}"
    return {"version": "protocol_version", "num_counters": "num_counters", "padding": "0"}[name]


def identity_words() -> list[list[str]]:
    """For every word of the identity its parts, the lowest byte first, as VHDL expressions."""
    words: list[list[str]] = []
    room = 0
    for name, size, _ in (*protocol.IDENTITY, protocol.PADDING):
        if size == 0:
            continue
        if room == 0:
            words.append([])
            room = WORD_BYTES
        constants = {"magic": protocol.MAGIC, "definition": protocol.definition_hash()}
        if name in constants:
            words[-1].append(f'std_ulogic_vector\'(x"{constants[name]:08x}")')
        else:
            words[-1].append(f"std_ulogic_vector(to_unsigned({identity_source(name)}, {8 * size}))")
        # No field may straddle two words.
        room -= size
        assert room >= 0, f"{name} does not fit its word"
    return words


def identity_function() -> list[str]:
    """Lines of the function that gives HELLO's words."""
    words = identity_words()
    lines = [
        "  -- What HELLO's answer says after link state and session, word by word.",
        "  function identity_of(f : formats_t; board : board_t) return identity_t is",
        "    variable words : identity_t;",
        "  begin",
    ]
    for index, parts in enumerate(words):
        joined = "\n        & ".join(reversed(parts))
        lines.append(f"    words({index}) := {joined};")
    return [*lines, "    return words;", "  end function identity_of;", ""]


def known_function() -> list[str]:
    """Lines of the function that tells what a board takes."""
    lines = [
        f"  function is_request({known_parameters()}) return std_ulogic is",
        "    variable known : std_ulogic := '0';",
        "  begin",
    ]
    for opcode in requests():
        known_here = f"with_{opcode.name.lower()} = 1 and " if opcode in OPTIONAL else ""
        lines += [
            f"    if {known_here}opcode = opcode_{opcode.name.lower()} then",
            "      known := '1';",
            "    end if;",
        ]
    return [*lines, "    return known;", "  end function is_request;", ""]


def known_parameters() -> str:
    """Of that function: the opcode, and 1 or 0 for each request that not every board knows."""
    return "; ".join([f"opcode : {BYTE}", *(f"with_{opcode.name.lower()} : natural" for opcode in OPTIONAL)])


def constant_lines() -> list[str]:
    """Lines of the package's constants."""
    lines = [f"  constant {name} : positive := {getattr(protocol, name.upper())};" for name in CONSTANTS]
    lines += [
        f"  constant protocol_version : positive := {protocol.VERSION};",
        "",
        "  -- Opcodes; bit 7 is set in answers, bit 4 in requests that are executed once and in order.",
    ]
    lines += [f'  constant opcode_{op.name.lower()} : {BYTE} := x"{op:02x}";' for op in Opcode]
    lines += ["", "  -- Why a frame was refused."]
    lines += [f'  constant reason_{reason.name.lower()} : {BYTE} := x"{reason:02x}";' for reason in Reason]
    lines += ["", "  -- Counters of STATUS, in their order, and their bits."]
    lines += [f"  constant num_counters : positive := {len(protocol.COUNTERS)};"]
    lines += [f"  constant counter_{row[0]} : natural := {i};" for i, row in enumerate(protocol.COUNTERS)]
    bits = ", ".join(str(bits) for _, bits, _ in protocol.COUNTERS)
    lines += [
        "  constant counter_bits : natural_vector_t(0 to num_counters - 1) := (",
        f"    {bits}",
        "  );",
        "",
        "  -- Bits of the identity's features.",
    ]
    lines += [f"  constant feature_{name} : natural := {1 << i};" for i, name in enumerate(protocol.FEATURES)]
    return [*lines, ""]


PHASE_STEP = """\
  -- 2**phase_bits * baud / frequency to nearest, bit by bit: the product has more than 32 bits.
  function phase_step_of(baud : positive; frequency : positive) return natural is
    variable rest : natural := baud;
    variable quotient : natural := 0;
  begin
    for index in 0 to phase_bits loop
      rest := 2 * rest;
      quotient := 2 * quotient;
      if rest >= frequency then
        rest := rest - frequency;
        quotient := quotient + 1;
      end if;
    end loop;
    return (quotient + 1) / 2;
  end function phase_step_of;
"""


def package() -> str:
    """Text of the VHDL package."""
    count = len(identity_words())
    lines = [HEADER, "package link_pkg is", "", *constant_lines()]
    lines += ["  -- What a board says of itself:"]
    lines += [f"  --   {name}: {text}" for name, _, text in protocol.BOARD_FIELDS]
    lines += ["  type board_t is record"]
    lines += [f"    {name} : natural;" for name, _, _ in protocol.BOARD_FIELDS]
    lines += [
        "  end record board_t;",
        "",
        f"  constant identity_length : positive := {count};",
        f"  type identity_t is array (0 to identity_length - 1) of {WORD};",
        "  function identity_of(f : formats_t; board : board_t) return identity_t;",
        "",
        f"  function least_words(opcode : {BYTE}) return u_unsigned;",
        f"  function most_words(opcode : {BYTE}) return u_unsigned;",
        f"  function is_request({known_parameters()}) return std_ulogic;",
        "  function phase_step_of(baud : positive; frequency : positive) return natural;",
        "",
        "end package link_pkg;",
        "",
        "package body link_pkg is",
        "",
        *identity_function(),
        *length_function("least_words", 0, "Words of a request's shortest payload."),
        *length_function("most_words", 1, "Words of a request's longest payload."),
        *known_function(),
        PHASE_STEP,
        "end package body link_pkg;",
        "",
    ]
    return "\n".join(lines)
