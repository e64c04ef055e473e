# SPDX-License-Identifier: Apache-2.0
"""Clock crossings: those of the boards are all known, and what is no synchroniser is not taken for one."""

from __future__ import annotations

from pathlib import Path

import pytest

from quadshade.errors import QuadshadeError
from quadshade.synthesis.bitstream import read_board
from quadshade.synthesis.crossings import Crossing, compare
from scripts.clocks import crossings_of, crossings_of_board, page, read_table

ROOT = Path(__file__).resolve().parents[1]

PAIRS = """
module top (input a, input b, input pin, input choose, output reg [15:0] seen, output reg out,
            output reg other_edge_1);
  reg source = 0, own = 0;
  always @(posedge a) source <= !source ^ pin_now;
  reg [1:0] pin_taken = 0;
  wire pin_now = pin_taken[1];
  always @(posedge a) pin_taken <= {pin_taken[0], pin};

  reg good_0, good_1, single, shared_0, shared_1, logic_0, logic_1, enabled_0, enabled_1, mixed_0, mixed_1;
  reg held, held_by_other, masked, other_edge_0;
  reg [7:0] words [0:63];
  reg [7:0] word;
  always @(posedge a) words[{6{own_a}}] <= {8{own_a}};
  reg own_a = 0;
  always @(posedge a) own_a <= !own_a;
  always @(posedge b) begin
    own <= !own;
    good_0 <= source;
    good_1 <= good_0;
    single <= source;
    shared_0 <= source;
    shared_1 <= shared_0;
    logic_0 <= source;
    logic_1 <= !logic_0;
    if (own) enabled_0 <= source;
    enabled_1 <= enabled_0;
    mixed_0 <= source ^ own;
    mixed_1 <= mixed_0;
    if (own) held <= source;
    held_by_other <= source ? own : held_by_other;
    masked <= own & source;
    other_edge_0 <= source;
    out <= own ? (choose_now ? source : held) : out;
    word <= words[{6{own}}];
    seen <= {word[0], good_1, single & own, shared_0, shared_1, logic_1, enabled_1, mixed_1, held,
             held_by_other, masked};
  end
  reg [1:0] choose_taken = 0;
  wire choose_now = choose_taken[1];
  always @(posedge b) choose_taken <= {choose_taken[0], choose};
  always @(posedge a) other_edge_1 <= other_edge_0;
endmodule
"""

KINDS = {
    "good_0": "synchroniser",
    "single": "",
    "shared_0": "",
    "logic_0": "",
    "enabled_0": "held",
    "mixed_0": "",
    "held": "held",
    "held_by_other": "",
    "masked": "",
    "other_edge_0": "",
    "out": "held",
    "pin_taken": "synchroniser",
    "choose_taken": "synchroniser",
    "other_edge_1": "",
    "word": "",
}


def found_in(verilog: str, folder: Path) -> list[Crossing]:
    (folder / "top.v").write_text(verilog)
    return crossings_of([folder / "top.v"], "ecp5")


@pytest.mark.parametrize("name", ["icebreaker", "ulx3s-12f-sdram"])
def test_crossings_of_a_board_are_those_of_the_table(name: str) -> None:
    table = read_table(ROOT)
    found = crossings_of_board(read_board(name, ROOT), ROOT)
    faults, used = compare(found, table)
    assert not faults
    # The larger one has every row of the table but that of Tang Nano 20K's SDRAM; the report shows them all.
    rows = {at for at, row in enumerate(table) if row["source"] != "IO_sdram_dq"}
    assert used == (rows if name == "ulx3s-12f-sdram" else {0, 1})
    assert all(f"`{crossing.sink}`" in page({name: found}, table) for crossing in found)


def test_what_is_no_synchroniser_is_not_taken_for_one(tmp_path: Path) -> None:
    found = found_in(PAIRS, tmp_path)
    assert {crossing.sink: crossing.kind for crossing in found} == KINDS
    assert {(crossing.source, crossing.source_clock) for crossing in found if crossing.sink == "single"} == {
        ("source", "a")
    }
    assert [crossing.source for crossing in found if crossing.sink == "pin_taken"] == ["pin"]


def test_table_that_does_not_fit() -> None:
    crossing = Crossing("source", "a", "sink_0", "b", "held")
    row = {"source": "source", "sink": "sink_[01]", "kind": "held", "why": "it stands still"}
    assert compare([crossing], [row]) == ([], {0})
    assert compare([], [row]) == ([], set())
    (fault,), used = compare([crossing], [row | {"sink": "sink"}])
    assert fault == "source (a) to sink_0 (b) is in no row of the table" and not used
    (fault,), _ = compare([crossing], [row | {"kind": "synchroniser"}])
    assert fault == "source (a) to sink_0 (b) is held, and the table says synchroniser"
    (fault,), _ = compare([Crossing("pin", "", "sink_0", "b", "")], [row | {"source": "pin"}])
    assert fault == "pin (no clock) to sink_0 (b) is unprotected, and the table says held"


@pytest.mark.parametrize(
    ("body", "said"),
    [
        (
            "reg [7:0] words [0:63]; always @(posedge b) out <= words[other];"
            + "always @(posedge a) words[address] <= data; always @(posedge b) words[other] <= data;",
            "has two clocks",
        ),
        ("always @* if (a) out <= data;", "whose clock is not known"),
        ("DCCA gate (.CLKI(a), .CE(b), .CLKO(out[0]));", "DCCA, whose clock is not known"),
    ],
)
def test_what_is_not_understood_is_refused(body: str, said: str, tmp_path: Path) -> None:
    ports = "input a, input b, input [5:0] address, input [5:0] other, input [7:0] data, output reg [7:0] out"
    if "DCCA" in body:
        ports = ports.replace("output reg", "output")
    with pytest.raises(QuadshadeError, match=said):
        found_in(f"module top ({ports}); {body} endmodule", tmp_path)
