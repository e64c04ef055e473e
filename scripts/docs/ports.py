# SPDX-License-Identifier: Apache-2.0
"""
Write ``docs/reference/ports.md``, generics and ports for designs of one's own. ``--check`` only compares.

``make docs`` makes a page for every unit; this one can be read without it.
"""

from __future__ import annotations

import sys

from quadshade.files.atomic import write_text
from scripts.docs.entity import ROOT, units
from scripts.docs.unit_page import generics_table, ports_table

PAGE = ROOT / "docs" / "reference" / "ports.md"

TAKEN = (
    ("raster_core", "render_core", "quadshade_axis"),
    ("shade", "depth_test", "framebuffer", "scan_out", "screen"),
    ("uart_rx", "uart_tx", "command_decoder", "board"),
)
"""Units that a design of one's own builds on: cores, what follows them, the link and all together."""

HEAD = """\
<!-- SPDX-License-Identifier: Apache-2.0 -->
# Ports and generics

Written by `make rtl` from the VHDL: what a [design of your own](../guide/own_design.md) builds on. Every
stream moves in the clocks in which its valid and ready are both high; `reset` is synchronous and active high.
[`make docs`](units/README.md) makes a page of every unit, with timing diagrams.

"""


def text() -> str:
    """The page."""
    known = units()
    sections = []
    for group in TAKEN:
        for name in group:
            unit = known[name]
            source = unit.path.relative_to(ROOT)
            sections += [f"## {name}", f"{unit.first_sentence} Source: [`{source}`](../../{source})."]
            sections += [generics_table(unit.generics), ports_table(unit.ports)]
    return HEAD + "\n\n".join(sections) + "\n"


def main() -> int:
    """Write the page, or check it; the exit code."""
    if "--check" in sys.argv[1:]:
        if PAGE.exists() and PAGE.read_text() == text():
            return 0
        print("docs/reference/ports.md is not what the VHDL says: run `make rtl`", file=sys.stderr)
        return 1
    write_text(PAGE, text())
    return 0


if __name__ == "__main__":
    sys.exit(main())
