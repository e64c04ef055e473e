# SPDX-License-Identifier: Apache-2.0
"""Power-up with unknown registers: what is taken from a netlist, and units that reset alone defines."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from quadshade.engine.netlist import write_netlist
from quadshade.engine.unknown_registers import DECIDED, PROMISED, without_initial_values
from quadshade.errors import QuadshadeError

ROOT = Path(__file__).resolve().parents[1]

NETLIST = """\
module {name}
  (input  clk,
   output [1:0] pixel_clocks);
  reg [1:0] pixel_clocks;
  reg [1:0] n1_q;
  reg step;
  reg n2_q;
  reg [7:0] words[1:0] ; // memory
  initial begin
    words[1] = 8'b00000001;
    words[0] = 8'b00000010;
    end
  always @*
    pixel_clocks = n1_q; // (isignal)
  initial
    pixel_clocks <= 2'b10;
  always @*
    step = n2_q; // (isignal)
  initial
    step <= 1'b1;
  always @(posedge clk)
    n1_q <= pixel_clocks;
  initial
    n1_q <= 2'b10;
  always @(posedge clk)
    n2_q <= step;
  initial
    n2_q <= 1'b1;
endmodule
"""


def test_registers_lose_their_values_and_tables_keep_theirs() -> None:
    stripped = without_initial_values(NETLIST.format(name="other_0a1b"))
    assert re.findall(r"initial\b.*", stripped) == ["initial begin"]
    assert "assign step = n2_q;" in stripped and "wire step;" in stripped
    assert "n1_q <= pixel_clocks;" in stripped and "words[1] = 8'b00000001;" in stripped


@pytest.mark.parametrize("name", ["scan_out", "scan_out_640_480", "scan_out_" + "5e" * 20])
def test_promised_registers_keep_their_values(name: str) -> None:
    stripped = without_initial_values(NETLIST.format(name=name))
    assert re.findall(r"initial\n    (.*)", stripped) == ["n1_q <= 2'b10;"]


def test_other_initial_statements_are_refused() -> None:
    text = NETLIST.format(name="other") + "initial\n  $readmemh(words);\n"
    with pytest.raises(QuadshadeError, match=r"unknown kind: initial \$readmemh\(words\);"):
        without_initial_values(text)


@pytest.mark.parametrize("entity", PROMISED)
def test_every_promise_is_one_of_a_register(entity: str) -> None:
    """A name that the VHDL has no more would be a promise of nothing."""
    verilog = write_netlist({}, entity, root=ROOT).read_text()
    for name in PROMISED[entity]:
        assert re.search(rf"^    (?:\w+_)?{name} = \w+; // \(isignal\)$", verilog, re.MULTILINE), name
    kept = len(re.findall(r"^  initial\n", without_initial_values(verilog), re.MULTILINE))
    assert kept >= len(PROMISED[entity])


COMPARISON = """\
module depth_test_2_1
  (input  [1:0] depth_7,
   input  [2:0] n9_o,
   output n3_o);
  wire [2:0] n2_o;
  wire [2:0] stored;
  assign stored = n9_o; // (signal)
  assign n2_o = {1'b0, depth_7};
  assign n3_o = $unsigned(n2_o) < $unsigned(stored);
endmodule
"""

ALL_WORDS = """\
module all_words;
  reg [1:0] depth;
  reg [2:0] word;
  wire less;
  integer i;
  depth_test_2_1 unit (.depth_7(depth), .n9_o(word), .n3_o(less));
  initial begin
    for (i = 0; i < 32; i = i + 1) begin
      {depth, word} = i;
      #1 $display("%0d %0d %b", depth, word, less);
    end
    {depth, word} = 5'b011xx;
    #1 $display("cleared %b", less);
    {depth, word} = 5'b010x0;
    #1 $display("drawn %b", less);
    {depth, word} = 5'b01x00;
    #1 $display("neither %b", less);
  end
endmodule
"""


def test_comparison_is_the_same_for_known_words(tmp_path: Path) -> None:
    """And unknown only where the top bit does not decide."""
    (tmp_path / "all.v").write_text(without_initial_values(COMPARISON) + ALL_WORDS)
    subprocess.run(["iverilog", "-g2012", "-o", "all", "all.v"], cwd=tmp_path, check=True)
    said = subprocess.run(["vvp", "-n", "all"], cwd=tmp_path, capture_output=True, text=True, check=True)
    known = [f"{depth} {word} {int(depth < word)}" for depth in range(4) for word in range(8)]
    assert said.stdout.splitlines() == [*known, "cleared 1", "drawn x", "neither x"]


@pytest.mark.parametrize("change", [("1'b0, depth_7", "1'b1, depth_7"), ("stored", "kept")])
def test_comparison_that_the_netlist_does_not_have_is_refused(change: tuple[str, str]) -> None:
    with pytest.raises(QuadshadeError, match="compares nothing with stored as DECIDED says"):
        without_initial_values(COMPARISON.replace(*change))


@pytest.mark.parametrize("entity", DECIDED)
def test_every_decided_word_is_compared(entity: str) -> None:
    stripped = without_initial_values(write_netlist({}, entity, root=ROOT).read_text())
    assert [word for word in DECIDED[entity] if f"= {word}[" not in stripped] == []


def simulated(*units: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """Benches on netlists whose registers begin unknown."""
    paths = [str(path) for unit in units for path in (ROOT / "cocotb_tests").rglob(f"test_{unit}.py")]
    assert len(paths) == len(units)
    command = [sys.executable, "-m", "pytest", "-q", *paths, "-k", "default", "-p", "no:cacheprovider"]
    settings = {**os.environ, "QUADSHADE_SIM": "icarus", "QUADSHADE_NETLIST": "unknown", **environment}
    return subprocess.run(command, cwd=ROOT, env=settings, capture_output=True, text=True, check=False)


def test_reset_alone_defines_units() -> None:
    """Cheap ones; `make test-netlist` has every unit."""
    done = simulated("skid_buffer", "memory_clear", "lane_handshake")
    assert done.returncode == 0 and "3 passed" in done.stdout, done.stdout


def test_reset_alone_defines_a_board() -> None:
    """Pictures through its two pins, the first of pixels that meet a z-buffer cleared at power-up."""
    done = simulated("board", COCOTB_TEST_FILTER="scenes")
    assert done.returncode == 0 and "1 passed" in done.stdout, done.stdout


def test_register_that_no_reset_sets_is_found(tmp_path: Path) -> None:
    """The same bench, on the same unit without the reset of one register."""
    shutil.copytree(ROOT / "rtl", tmp_path / "rtl")
    path = tmp_path / "rtl" / "link" / "uart_tx.vhd"
    text = path.read_text()
    reset = "      if reset = '1' then\n        active <= '0';\n"
    assert text.count(reset) == 1
    path.write_text(text.replace(reset, "      if reset = '1' then\n"))
    done = simulated("uart_tx", QUADSHADE_ROOT=str(tmp_path))
    assert done.returncode == 1
    assert "Cannot convert Logic('X')" in done.stdout
