# SPDX-License-Identifier: Apache-2.0
"""How a design becomes cells of iCE40: what is short or costs nothing is made of LUTs, and means the same."""

from __future__ import annotations

import json
import re
from collections import Counter
from pathlib import Path

import pytest

from quadshade.errors import QuadshadeError
from quadshade.synthesis.devices import find_device
from quadshade.synthesis.families import find_family
from quadshade.synthesis.flow import run_yosys
from quadshade.synthesis.mapped import cell_models
from quadshade.synthesis.mapping import mapping_commands
from tests.support.yosys_proof import prove_equal

NUMBERS = find_family("ice40").numbers
LONGEST_COMPARED, LONGEST_SHORT = NUMBERS["longest_compared"], NUMBERS["longest_short"]
LEAST_SHARED = NUMBERS["least_shared"]

SUM = "assign q = a + b;"
ABOVE = "assign q = a > 37;"
REGISTER = "reg [{top}:0] r = 0; always @(posedge clk) if (enable) r <= a ^ b; assign q = r;"

TAKEN = "reg [{top}:0] r = 0; always @(posedge clk) if (enable) r <= a; assign q = r;"
CLEARED = (
    "reg [{top}:0] r = 0; always @(posedge clk) if (b[0]) r <= 0; else if (enable) r <= a; assign q = r;"
)
BOTH = CLEARED.replace("r <= a", "r <= a ^ b")
MODELS = ("LUT4", "CARRY", "DFF", "DFFE", "DFFSR", "DFFESR")


def design(body: str, width: int) -> str:
    """A module of two numbers."""
    top = width - 1
    ports = f"input clk, input enable, input [{top}:0] a, input [{top}:0] b, output [{top}:0] q"
    return f"module made ({ports});\n{body.replace('{top}', str(top))}\nendmodule\n"


def mapped(body: str, width: int, folder: Path) -> Counter[str]:
    """Cells of a design, by type; their netlist is ``mapped.v``."""
    (folder / "made.v").write_text(design(body, width))
    commands = mapping_commands(find_device("ice40-up5k"), "made")
    run_yosys(
        ["read_verilog made.v", *commands, "write_json mapped.json", "write_verilog -noattr mapped.v"], folder
    )
    cells = json.loads((folder / "mapped.json").read_text())["modules"]["made"]["cells"]
    return Counter(cell["type"] for cell in cells.values())


@pytest.mark.parametrize(
    ("body", "longest", "cell"),
    [(SUM, LONGEST_SHORT, "SB_CARRY"), (ABOVE, LONGEST_COMPARED, "SB_CARRY")],
    ids=["sum", "comparison"],
)
def test_short_numbers_have_no_carry_chain(body: str, longest: int, cell: str, tmp_path: Path) -> None:
    assert mapped(body, longest, tmp_path)[cell] == 0
    assert mapped(body, longest + 1, tmp_path)[cell] > 0


def test_few_flip_flops_have_no_enable_of_their_own(tmp_path: Path) -> None:
    few = mapped(REGISTER, LEAST_SHARED - 1, tmp_path)
    assert few["SB_DFF"] == LEAST_SHARED - 1
    assert few["SB_DFFE"] == 0
    assert mapped(REGISTER, LEAST_SHARED, tmp_path)["SB_DFFE"] == LEAST_SHARED


@pytest.mark.parametrize("body", [TAKEN, CLEARED], ids=["enable", "enable and reset"])
def test_what_takes_another_has_no_enable(body: str, tmp_path: Path) -> None:
    width = 4 * LEAST_SHARED
    assert mapped(body, width, tmp_path) == {"SB_DFF": width, "SB_LUT4": width}


@pytest.mark.parametrize(
    "body",
    [SUM, ABOVE, REGISTER, BOTH, TAKEN, CLEARED],
    ids=["sum", "comparison", "behind logic", "behind logic, cleared", "taken", "cleared"],
)
@pytest.mark.parametrize("width", [LEAST_SHARED, LONGEST_SHORT, LONGEST_COMPARED])
def test_cells_mean_the_same(body: str, width: int, tmp_path: Path) -> None:
    """Proved by Yosys, for all numbers."""
    mapped(body, width, tmp_path)
    pattern = rf"module SB_(?:{'|'.join(MODELS)})\b.*?^endmodule"
    models = re.findall(pattern, cell_models("ice40"), re.DOTALL | re.MULTILINE)
    assert len(models) == len(MODELS)
    text = re.sub(r"`ICE40_DEFAULT_ASSIGNMENT\w*", "", "\n".join(models)).replace(
        "`SB_DFF_INIT", "initial Q = 0;"
    )
    cells = (tmp_path / "mapped.v").read_text()
    prove_equal("made", design(body, width), cells, text + "\n", tmp_path, registers="posedge" in body)


def test_a_wrong_register_is_not_equal(tmp_path: Path) -> None:
    wrong = design(TAKEN.replace("r <= a", "r <= b"), 6)
    with pytest.raises(QuadshadeError, match="proof did fail"):
        prove_equal("made", design(TAKEN, 6), wrong, "", tmp_path, registers=True)
