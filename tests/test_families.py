# SPDX-License-Identifier: Apache-2.0
"""Descriptions of families: complete, refused where they are wrong, and what Gowin's makes of a design."""

from __future__ import annotations

import json
import re
from collections import Counter
from pathlib import Path

import pytest

from quadshade.engine.netlist import write_netlist
from quadshade.errors import QuadshadeError
from quadshade.synthesis.devices import find_device
from quadshade.synthesis.families import families, filled, find_family, read_family
from quadshade.synthesis.flow import run_yosys
from quadshade.synthesis.mapping import mapping_commands

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / "synth" / "families"


@pytest.mark.parametrize("name", families())
def test_every_family_is_whole(name: str) -> None:
    family = find_family(name)
    assert family.simulated in family.devices
    assert {re.compile(family.pin).groupindex.keys() >= {"port", "pin"}} == {True}
    # What stands in braces is what is filled in.
    filled(family.passes, run="run", **family.numbers)
    assert "{top}" not in " ".join(filled(family.finish, top="top"))
    assert filled(family.packer, routed="a", packed="b").count("b") == 1
    assert filled(family.constrained, pins="pins", mhz=1).count("pins") + (name == "gowin") == 1
    assert all((ROOT / "synth" / "cells" / f"{entity}.v").is_file() for entity in family.cells)
    assert "block RAM" in family.area and "LUT4" in family.area


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('suffix = ".fs"\n', "", "gowin.toml has no suffix; quadshade.synthesis.families says"),
        ('suffix = ".fs"', 'ending = ".fs"\nsuffix = ".fs"', "gowin.toml has ending, which no family has"),
        ("aim_mhz = 300", "", "gowin.toml has no aim_mhz"),
        ("[devices.gowin-gw2ar18]", "[devices.gw2ar18]", "has the device gw2ar18; call it gowin-"),
        ('suffix = ".fs"', "suffix = .fs", "gowin.toml: "),
    ],
    ids=["missing", "unknown", "a device's", "its name", "no TOML"],
)
def test_a_family_that_is_wrong(old: str, new: str, message: str, tmp_path: Path) -> None:
    text = (FOLDER / "gowin.toml").read_text()
    assert old in text
    (tmp_path / "gowin.toml").write_text(text.replace(old, new))
    with pytest.raises(QuadshadeError, match=message):
        read_family(tmp_path / "gowin.toml")


def test_unknown_family() -> None:
    with pytest.raises(QuadshadeError, match="unknown family 'xc7'; the families are ecp5, gowin, ice40"):
        find_family("xc7")


def mapped(verilog: str, top: str, folder: Path) -> Counter[str]:
    """Cells of a design on Tang Nano 20K's device, pins and constants apart."""
    (folder / "made.v").write_text(verilog)
    commands = mapping_commands(find_device("gowin-gw2ar18"), top)
    run_yosys(["read_verilog made.v", *commands, "write_json made.json"], folder)
    cells = json.loads((folder / "made.json").read_text())["modules"][top]["cells"]
    kinds = Counter(cell["type"] for cell in cells.values())
    return Counter(
        {kind: count for kind, count in kinds.items() if kind not in ("IBUF", "OBUF", "GND", "VCC")}
    )


@pytest.mark.parametrize(
    ("num_words", "data_bits", "blocks"),
    [(19200, 17, {"DPB": 17, "DPX9B": 3}), (2048, 9, {"DPX9B": 1}), (1024, 32, {"DPX9B": 2})],
    ids=["picture of 160 x 120", "one block", "FIFO"],
)
def test_memories_are_gowins_blocks(
    num_words: int, data_bits: int, blocks: dict[str, int], tmp_path: Path
) -> None:
    """As many as their banks have: no memory of flip-flops or LUTs, no block beside a multiplexer."""
    generics = {"num_words": num_words, "data_bits": data_bits, "read_stages": 4}
    kinds = mapped(write_netlist(generics, "block_ram").read_text(), "block_ram", tmp_path)
    assert {kind: count for kind, count in kinds.items() if kind.startswith(("DP", "SDP", "SP"))} == blocks
    assert not [kind for kind in kinds if kind.startswith("RAM16")]


@pytest.mark.parametrize(
    ("body", "kind", "count"),
    [
        ("assign q = a + b;", "ALU", 16),
        ("wire [15:0] p = a[7:0] * b[7:0]; assign q = p;", "MULT9X9", 1),
        ("reg [15:0] r = 0; always @(posedge clk) if (a[0]) r <= b; assign q = r;", "DFFE", 16),
        ("reg [15:0] r = 0; always @(posedge clk) if (a[0]) r <= 0; else r <= b; assign q = r;", "DFFR", 16),
    ],
    ids=["carry", "product", "enable", "reset"],
)
def test_logic_is_gowins_cells(body: str, kind: str, count: int, tmp_path: Path) -> None:
    ports = "input clk, input [15:0] a, input [15:0] b, output [15:0] q"
    assert mapped(f"module made ({ports}); {body} endmodule\n", "made", tmp_path) == {kind: count}
