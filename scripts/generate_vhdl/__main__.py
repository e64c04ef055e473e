# SPDX-License-Identifier: Apache-2.0
"""
Write the packages of ``rtl/generated/`` from their one source each in ``quadshade.contract``.

``quadshade_pkg.vhd`` comes from ``formats``, ``link_pkg.vhd`` from ``protocol``, ``packed_pkg.vhd`` from
``packed_format``, ``vertex_pkg.vhd`` from ``vertex_program``, ``axis_pkg.vhd`` from ``axis``.

``--check`` writes nothing and exits with code 1 if a file in the tree is not what would be written.
"""

from __future__ import annotations

import argparse
import re
import sys
from dataclasses import fields
from pathlib import Path

from quadshade.contract import formats
from quadshade.files.atomic import write_text
from scripts.generate_vhdl import axis as generate_axis
from scripts.generate_vhdl import link as generate_link
from scripts.generate_vhdl import packed as generate_packed
from scripts.generate_vhdl import vertices as generate_vertices

RTL = Path(__file__).resolve().parents[2] / "rtl" / "generated"

GENERICS = tuple(f.name for f in fields(formats.Formats))
DERIVED = tuple(name for name, _, _ in formats.DERIVED)
SHADE_CONSTANTS = (
    "factor_bits",
    "coefficient_frac_bits",
    "power_bits",
    "power_mantissa_bits",
    "power_stages",
    "table_words",
    "state_registers",
    "ambient_row",
    "shaded_colours",
)

HEADER = """\
-- SPDX-License-Identifier: Apache-2.0
--
-- Number formats and the layout of the set-up packet, as functions of the core's generics.
--
-- Written by scripts/generate_vhdl from model/quadshade/contract/formats.py: change them, then `make rtl`.
-- A section's layout function gives the lowest and the highest bit of every field, its bits and its beats.
"""


def vhdl_expression(expression: str) -> str:
    """
    A width expression of ``formats`` in VHDL.

    Parameters
    ----------
    expression : str
      Integers, ``+ - * / **`` and names of generics or derived widths.

    Returns
    -------
    str
      The same expression over ``f : formats_t``.

    Raises
    ------
    KeyError
      A name that is neither a generic nor a derived width.
    """
    calls = {name: f"f.{name}" for name in GENERICS} | {name: f"{name}(f)" for name in DERIVED}
    return re.sub(r"[a-z_][a-z_0-9]*", lambda match: calls[match[0]], expression)


def record(name: str, elements: list[str]) -> list[str]:
    """Lines of a record type of naturals."""
    return [
        f"  type {name} is record",
        *(f"    {e} : natural;" for e in elements),
        f"  end record {name};",
        "",
    ]


def layout_elements(section: str) -> list[str]:
    """Names of a section's layout record."""
    names = [f"{field}_{end}" for field, _, _ in dict(formats.SECTIONS)[section] for end in ("low", "high")]
    return [*names, "bits", "beats"]


def layout_body(section: str) -> list[str]:
    """Lines of the body of a section's layout function."""
    lines = [
        f"  function {section}_layout(f : formats_t) return {section}_layout_t is",
        f"    variable layout : {section}_layout_t;",
        "  begin",
    ]
    below = "0"
    for field, width, why in dict(formats.SECTIONS)[section]:
        lines += [
            f"    -- {why}",
            f"    layout.{field}_low := {below};",
            f"    layout.{field}_high := layout.{field}_low + {vhdl_expression(width)} - 1;",
        ]
        below = f"layout.{field}_high + 1"
    return [
        *lines,
        f"    layout.bits := {below};",
        "    layout.beats := (layout.bits + f.stream_width - 1) / f.stream_width;",
        "    return layout;",
        f"  end function {section}_layout;",
        "",
    ]


def assertion(name: str, condition: str, wanted: str) -> list[str]:
    """Lines of one elaboration-time check of a generic."""
    return [
        f"    assert {condition}",
        f'      report "generic {name} is " & integer\'image(f.{name})',
        f'        & "; give {wanted}"',
        "      severity failure;",
    ]


def check_body() -> list[str]:
    """Lines of the body of ``check_formats``."""
    lines = ["  function check_formats(f : formats_t) return boolean is", "  begin"]
    for name, values in formats.GENERIC_CHOICES:
        condition = " or ".join(f"f.{name} = {value}" for value in values)
        lines += assertion(name, condition, f"one of {', '.join(map(str, values))}")
    for name, lowest, highest, holds in formats.GENERIC_RANGES:
        low, high = vhdl_expression(lowest), vhdl_expression(highest)
        condition = f"f.{name} >= {low} and f.{name} <= {high}"
        if holds != "1":
            condition = f"{vhdl_expression(holds)} = 0\n      or ({condition})"
        lines += assertion(name, condition, f"a value from {lowest} to {highest}")
    return [*lines, "    return true;", "  end function check_formats;", ""]


def package() -> str:
    """Text of the VHDL package."""
    defaults = formats.Formats().generics()
    sections = [name for name, _ in formats.SECTIONS]
    orders = len(formats.DIFFERENCES_OF_ORDER)
    counts = ", ".join(map(str, formats.DIFFERENCES_OF_ORDER))
    lines = [HEADER, "package quadshade_pkg is", ""]
    lines += [
        "  -- Bits of a set-up word: the set-up stream is a row of them.",
        f"  constant setup_word_bits : positive := {formats.SETUP_WORD_BITS};",
        "",
    ]
    lines += ["  -- Orders of a channel, and how many differences each needs."]
    lines += [f"  constant order_{name} : natural := {i};" for i, name in enumerate(formats.ORDER_NAMES)]
    lines += [
        "  type natural_vector_t is array (natural range <>) of natural;",
        f"  constant differences_of_order : natural_vector_t(0 to {orders - 1}) := ({counts});",
        "",
        "  -- Differences of a channel, in the order in which they are sent; the first is its value.",
        f"  constant num_differences : positive := {len(formats.DIFFERENCES)};",
        *(f"  constant difference_{name} : natural := {i};" for i, name in enumerate(formats.DIFFERENCES)),
        "",
        "  -- The shade unit: operands, fractions, a power table's values and index, stages, addresses.",
        *(f"  constant {name} : positive := {getattr(formats, name.upper())};" for name in SHADE_CONSTANTS),
        "",
        "  -- Generics of the core:",
        *(f"  --   {name}: {text}" for name, text in formats.GENERIC_HELP.items()),
        *record("formats_t", list(GENERICS)),
        "  constant default_formats : formats_t := (",
        ",\n".join(f"    {name} => {value}" for name, value in defaults.items()),
        "  );",
        "",
        "  -- True, or a failure that names the first generic out of range and the value got.",
        "  function check_formats(f : formats_t) return boolean;",
        "",
    ]
    for name, _, why in formats.DERIVED:
        lines += [f"  -- {why}", f"  function {name}(f : formats_t) return integer;"]
    lines += [""]
    for section in sections:
        lines += record(f"{section}_layout_t", layout_elements(section))
        lines += [f"  function {section}_layout(f : formats_t) return {section}_layout_t;", ""]
    lines += ["end package quadshade_pkg;", "", "package body quadshade_pkg is", "", *check_body()]
    for name, expression, _ in formats.DERIVED:
        lines += [
            f"  function {name}(f : formats_t) return integer is",
            "  begin",
            f"    return {vhdl_expression(expression)};",
            f"  end function {name};",
            "",
        ]
    for section in sections:
        lines += layout_body(section)
    return "\n".join([*lines, "end package body quadshade_pkg;", ""])


def main() -> int:
    """Write the packages, or check them; the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.strip().splitlines()[0])
    parser.add_argument("--check", action="store_true", help="write nothing; exit 1 if a file is out of date")
    arguments = parser.parse_args()
    code = 0
    packages = {
        "quadshade_pkg.vhd": package(),
        "link_pkg.vhd": generate_link.package(),
        "packed_pkg.vhd": generate_packed.package(vhdl_expression),
        "vertex_pkg.vhd": generate_vertices.package(vhdl_expression),
        "axis_pkg.vhd": generate_axis.package(vhdl_expression),
    }
    for name, text in packages.items():
        path = RTL / name
        if path.exists() and path.read_text() == text:
            continue
        if arguments.check:
            print(f"{name} is not what its source in Python says: run `make rtl`", file=sys.stderr)
            code = 1
            continue
        write_text(path, text)
    return code


if __name__ == "__main__":
    sys.exit(main())
