# SPDX-License-Identifier: Apache-2.0
"""The text of ``rtl/generated/packed_pkg.vhd`` from ``quadshade.contract.packed_format``."""

from __future__ import annotations

from collections.abc import Callable

from quadshade.contract import packed_format

HEADER = """\
-- SPDX-License-Identifier: Apache-2.0
--
-- The packed stream: kinds of fields and of channels, and where their widths are.
--
-- Written by scripts/generate_vhdl from model/quadshade/contract/packed_format.py: change it, `make rtl`.

use work.quadshade_pkg.all;
"""


def package(vhdl_expression: Callable[[str], str]) -> str:
    """
    Text of the VHDL package.

    Parameters
    ----------
    vhdl_expression : callable
      An expression of the formats' tables in VHDL.
    """
    kinds = packed_format.FIELD_KINDS
    fills = ", ".join(str(packed_format.FILLS.index(fill)) for _, fill in kinds)
    bits = packed_format.field_bits()
    lines = [
        HEADER,
        "package packed_pkg is",
        "",
        "  -- Fields of one bit at a packet's start.",
        f"  constant num_raw_fields : positive := {len(packed_format.RAW_FIELDS)};",
        "",
        "  -- What stands above the bits of a field that are sent: 0, 1, or the highest of them.",
        *(f"  constant fill_{name} : natural := {i};" for i, name in enumerate(packed_format.FILLS)),
        "",
        "  -- Kinds of fields, in order, and their fills.",
        f"  constant num_packed_kinds : positive := {len(kinds)};",
        *(f"  constant packed_{name} : natural := {i};" for i, (name, _) in enumerate(kinds)),
        f"  constant packed_fills : natural_vector_t(0 to {len(kinds) - 1}) := ({fills});",
        "  -- Bits of a field of each kind.",
        "  function packed_kind_bits(f : formats_t) return natural_vector_t;",
        "",
        "  -- Kinds of channels; addresses of widths for each, and of the first kind of fields' width.",
        *(f"  constant kind_{name} : natural := {i};" for i, name in enumerate(packed_format.CHANNEL_KINDS)),
        f"  constant kind_widths : positive := {packed_format.KIND_WIDTHS};",
        f"  constant field_widths : positive := {packed_format.FIELD_WIDTHS};",
        "",
    ]
    for name, _, why in packed_format.SIZES:
        lines += [f"  -- {why}", f"  function {name}(f : formats_t) return positive;"]
    lines += [
        "",
        "end package packed_pkg;",
        "",
        "package body packed_pkg is",
        "",
        "  function packed_kind_bits(f : formats_t) return natural_vector_t is",
        f"    variable bits : natural_vector_t(0 to {len(kinds) - 1});",
        "  begin",
        *(f"    bits(packed_{name}) := {vhdl_expression(bits[name])};" for name, _ in kinds),
        "    return bits;",
        "  end function packed_kind_bits;",
        "",
    ]
    for name, expression, _ in packed_format.SIZES:
        lines += [
            f"  function {name}(f : formats_t) return positive is",
            "  begin",
            f"    return {vhdl_expression(expression)};",
            f"  end function {name};",
            "",
        ]
    return "\n".join([*lines, "end package body packed_pkg;", ""])
