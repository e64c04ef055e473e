# SPDX-License-Identifier: Apache-2.0
"""A checkout with one board of its own, for tests of boards' files that are wrong."""

from __future__ import annotations

from pathlib import Path

CONSTRAINTS = (
    'LOCATE COMP "clk" SITE "G2";\nLOCATE COMP "led[0]" SITE "B2";\nLOCATE COMP "led[1]" SITE "C2";\n'
)

OWN = """\
device = "ecp5-25k-6"
top = "own.v"
constraints = "own.lpf"
program = []
clocks = {clk = 100}
generics = {}
"""

NO_TOP = OWN.replace('top = "own.v"\n', "")
"""Its device alone may be measured; no bitstream is built."""


def own_board(folder: Path, entries: str, constraints: str = CONSTRAINTS) -> Path:
    """The root of a checkout with one board, of two lights."""
    boards = folder / "synth" / "boards"
    boards.mkdir(parents=True)
    (boards / "own.v").write_text("module top (input clk, // led [7:0]\n  output [1:0] led);\nendmodule\n")
    (boards / "own.lpf").write_text(constraints)
    (boards / "own.toml").write_text(entries)
    return folder
