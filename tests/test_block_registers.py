# SPDX-License-Identifier: Apache-2.0
"""Registers behind block RAM go into the blocks of ECP5, and only those that do the same there."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from quadshade.engine.netlist import write_netlist
from quadshade.synthesis.block_registers import absorb_registers
from quadshade.synthesis.devices import find_device
from quadshade.synthesis.flow import run_yosys
from quadshade.synthesis.mapping import mapping_commands

MEMORY = """
module memory (input clk, input enable, input other, input write, input [10:0] at, input [10:0] to,
               input [7:0] d, output reg [7:0] q);
  (* ram_style = "block", no_rw_check *) reg [7:0] words [0:2047];
  reg [7:0] fetched;
  always @(posedge clk) begin
    if (write) words[to] <= d;
    if (enable) fetched <= words[at];
    BODY
  end
endmodule
"""
BEHIND = "if (enable) q <= fetched;"


def mapped(verilog: str, top: str, folder: Path) -> dict:
    """A design in cells of ECP5, as Yosys writes it."""
    (folder / "made.v").write_text(verilog)
    commands = mapping_commands(find_device("ecp5-25k-6"), top)
    run_yosys(["read_verilog made.v", *commands, "write_json mapped.json"], folder)
    return json.loads((folder / "mapped.json").read_text())


def cells_of(design: dict, top: str, kind: str) -> list[dict]:
    return [cell for cell in design["modules"][top]["cells"].values() if cell["type"] == kind]


@pytest.mark.parametrize(("num_words", "data_bits", "banks"), [(19200, 17, 3), (76800, 24, 7), (2048, 9, 1)])
def test_memories_of_the_screen(num_words: int, data_bits: int, banks: int, tmp_path: Path) -> None:
    """Every bank's register, whatever its blocks are: no multiplexer stands between."""
    generics = {"num_words": num_words, "data_bits": data_bits, "read_stages": 3}
    design = mapped(write_netlist(generics, "block_ram").read_text(), "block_ram", tmp_path)
    flip_flops = len(cells_of(design, "block_ram", "TRELLIS_FF"))
    assert absorb_registers(design, "block_ram") == banks * data_bits
    assert len(cells_of(design, "block_ram", "TRELLIS_FF")) == flip_flops - banks * data_bits
    for block in cells_of(design, "block_ram", "DP16KD"):
        nets, side = block["connections"], "AB"[block["parameters"]["REGMODE_B"] == "OUTREG"]
        assert block["parameters"][f"REGMODE_{side}"] == "OUTREG"
        assert nets[f"OCE{side}"] == nets[f"CE{side}"]
    assert absorb_registers(design, "block_ram") == 0


@pytest.mark.parametrize(
    ("behind", "moved"),
    [
        (BEHIND, 8),
        ("if (other) q <= fetched;", 0),
        ("q <= fetched;", 0),
        ("if (enable) q <= other ? 8'b0 : fetched;", 0),
        ("if (enable) q <= ~fetched;", 0),
    ],
    ids=["same enable", "another enable", "no enable", "reset", "logic between"],
)
def test_only_what_does_the_same(behind: str, moved: int, tmp_path: Path) -> None:
    design = mapped(MEMORY.replace("BODY", behind), "memory", tmp_path)
    assert len(cells_of(design, "memory", "DP16KD")) == 1
    assert absorb_registers(design, "memory") == moved


def test_a_word_that_goes_elsewhere_too_stays(tmp_path: Path) -> None:
    verilog = MEMORY.replace("output reg [7:0] q", "output reg [7:0] q, output [7:0] early")
    verilog = verilog.replace("BODY", BEHIND).replace("endmodule", "  assign early = fetched;\nendmodule")
    assert absorb_registers(mapped(verilog, "memory", tmp_path), "memory") == 0
