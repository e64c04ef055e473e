# SPDX-License-Identifier: Apache-2.0
"""The text of ``rtl/generated/axis_pkg.vhd``, and the page's tables, from ``quadshade.contract.axis``."""

from __future__ import annotations

from collections.abc import Callable

from quadshade.contract import axis
from quadshade.contract.formats import Formats
from quadshade.files.markdown import markdown_table

HEADER = """\
-- SPDX-License-Identifier: Apache-2.0
--
-- The AXI ports of quadshade_axis: where a pixel's fields lie in tdata, and the registers' byte offsets.
--
-- Written by scripts/generate_vhdl from model/quadshade/contract/axis.py: change that, then `make rtl`.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

use work.quadshade_pkg.all;
"""


def package(vhdl_expression: Callable[[str], str]) -> str:
    """Text of the VHDL package; ``vhdl_expression`` turns a width into VHDL."""
    lines = [HEADER, "package axis_pkg is", ""]
    lines += [
        f"  constant axi_data_bits : positive := {axis.AXI_DATA_BITS};",
        f"  constant axi_address_bits : positive := {axis.AXI_ADDRESS_BITS};",
        "",
        "  -- Byte offsets from the first register, whose address has the highest bit set.",
        *(
            f"  constant register_{one.name} : natural := {one.offset};"
            for one in axis.REGISTERS
            if one.offset < axis.GENERICS_FIRST
        ),
        f"  constant register_generics : natural := {axis.GENERICS_FIRST};",
        f'  constant identity : u_unsigned(axi_data_bits - 1 downto 0) := x"{axis.IDENTITY:08x}";',
        "",
        "  -- What the registers of the generics hold, a word each, in their order.",
        "  function generic_values(f : formats_t) return natural_vector_t;",
        "",
        "  -- Bytes of a pixel's fields, which tkeep marks, and of tdata: the next power of two.",
        "  function pixel_bytes(f : formats_t) return positive;",
        "  function pixel_data_bytes(f : formats_t) return positive;",
        "",
    ]
    for name, _, why in axis.PIXEL_FIELDS:
        lines += [f"  -- First bit of: {why}.", f"  function {name}_low(f : formats_t) return natural;"]
    lines += ["", "end package axis_pkg;", "", "package body axis_pkg is", ""]
    generics = list(Formats().generics())
    lines += [
        "  function generic_values(f : formats_t) return natural_vector_t is",
        f"    constant values : natural_vector_t(0 to {len(generics) - 1}) := (",
        ",\n".join(f"      f.{name}" for name in generics),
        "    );",
        "  begin",
        "    return values;",
        "  end function generic_values;",
        "",
    ]
    below = "0"
    for name, width, _ in axis.PIXEL_FIELDS:
        lines += _function(f"{name}_low", "natural", [f"    return {below};"])
        below = f"{name}_low(f) + {vhdl_expression(width)}"
    lines += _function("pixel_bytes", "positive", [f"    return ({below}) / 8;"])
    lines += _function(
        "pixel_data_bytes",
        "positive",
        [
            "    while bytes < pixel_bytes(f) loop",
            "      bytes := 2 * bytes;",
            "    end loop;",
            "    return bytes;",
        ],
        ["    variable bytes : positive := 1;"],
    )
    return "\n".join([*lines, "end package body axis_pkg;", ""])


def _function(name: str, result: str, body: list[str], variables: list[str] | None = None) -> list[str]:
    """Lines of a function of the formats."""
    return [
        f"  function {name}(f : formats_t) return {result} is",
        *(variables or []),
        "  begin",
        *body,
        f"  end function {name};",
        "",
    ]


def pixel_table() -> str:
    """The page's table of a pixel's fields, with their places in a core with the default generics."""
    places = axis.pixel_places(Formats())
    rows = [
        (f"`{name}`", f"`{width}`", f"{places[name][0]} to {sum(places[name]) - 1}", why)
        for name, width, why in axis.PIXEL_FIELDS
    ]
    return markdown_table(("field", "bits", "by default", "what"), rows)


def register_table() -> str:
    """The page's table of registers."""
    rows = [
        (f"`0x{axis.REGISTERS_FIRST + one.offset:04x}`", f"`{one.name}`", one.meaning)
        for one in axis.REGISTERS
    ]
    return markdown_table(("byte address", "register", "what"), rows)
