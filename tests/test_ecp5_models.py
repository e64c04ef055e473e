# SPDX-License-Identifier: Apache-2.0
"""The models of ECP5's block RAM and multiplier are the memory and the product that Yosys made them of."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from quadshade.synthesis.devices import find_device
from quadshade.synthesis.mapped import write_simulated
from quadshade.synthesis.mapping import mapping_commands

ROOT = Path(__file__).resolve().parents[1]
CLOCKS = 1500
PORTS = """\
module {name} (input clk, input enable, input write, input [{a}:0] at, input [{a}:0] to, input [{d}:0] d,
               output reg [{d}:0] q = 0);
"""
MEMORY = """\
  (* ram_style = "block", no_rw_check *) reg [{d}:0] words [0:{last}];
  integer index;
  initial for (index = 0; index <= {first}; index = index + 1)
    words[index] = index < 512 ? index * 40503 >> 3 : 0;
"""
MADE = """\
  reg [{d}:0] fetched = 0;
  always @(posedge clk) begin
    if (write) words[to] <= d;
    if (enable) fetched <= words[at];
    {behind}
  end
endmodule
"""
# The same, but that a word which is just being written is unknown.
EXPECTED = MADE.replace("words[at];", "write && to == at ? 'bx : words[at];")
BENCH = """\
module bench;
  reg clk = 0, enable = 0, write = 0;
  reg [{a}:0] at = 0, to = 0;
  reg [{d}:0] d = 0;
  wire [{d}:0] q, expected;
  integer index, wrong = 0, known = 0;
  made made_inst (clk, enable, write, at, to, d, q);
  expected expected_inst (clk, enable, write, at, to, d, expected);
  initial begin
    for (index = 0; index < {clocks}; index = index + 1) begin
      {{enable, write}} = $random;
      // Near each other now and then.
      at = $random; to = index % 3 ? $random : at + index[3:0] % 2; d = {{$random, $random}};
      #1 clk = 1;
      #1 clk = 0;
      if (q !== expected) wrong = wrong + 1;
      if (^q !== 1'bx) known = known + 1;
    end
    $display("%0d wrong, %0d known", wrong, known);
  end
endmodule
"""
needs_icarus = pytest.mark.skipif(not shutil.which("iverilog"), reason="needs Icarus: run `make setup`")


def run_bench(verilog: str, files: list[Path], folder: Path) -> str:
    """What a bench prints."""
    (folder / "bench.v").write_text(verilog)
    build = ["iverilog", "-g2012", "-s", "bench", "-o", "bench.vvp", "bench.v", *files]
    subprocess.run(build, cwd=folder, check=True, capture_output=True)
    run = subprocess.run(["vvp", "-n", "bench.vvp"], cwd=folder, check=True, capture_output=True, text=True)
    return run.stdout.strip()


def simulated(
    data_bits: int, num_words: int, behind: str, spoil: tuple[str, str], folder: Path
) -> tuple[str, str]:
    """What the bench prints, and the mapped netlist."""
    fields = {
        "d": data_bits - 1,
        "a": (num_words - 1).bit_length() - 1,
        "last": num_words - 1,
        "behind": behind,
        "clocks": CLOCKS,
    }
    device = find_device("ecp5-25k-6")
    # Yosys takes long over a loop; what it leaves out is zero in a block.
    (folder / "made.v").write_text((PORTS + MEMORY + MADE).format(name="made", first=511, **fields))
    commands = ["read_verilog made.v", *mapping_commands(device, "made")]
    files = write_simulated(commands, folder, "made", device, ROOT)
    netlist = files[0].read_text()
    files[0].write_text(netlist.replace(*spoil))
    expected = (PORTS + MEMORY + EXPECTED).format(name="expected", first=num_words - 1, **fields)
    return run_bench(expected + BENCH.format(**fields), files, folder), netlist


@needs_icarus
@pytest.mark.parametrize(
    ("data_bits", "num_words", "register"),
    [
        (1, 16384, True),
        (2, 8192, False),
        (4, 4096, True),
        (9, 2048, True),
        (18, 1024, True),
        (36, 512, False),
    ],
)
def test_model_is_the_memory(data_bits: int, num_words: int, register: bool, tmp_path: Path) -> None:
    behind = "if (enable) q <= fetched;" if register else "q <= fetched;"
    printed, netlist = simulated(data_bits, num_words, behind, ("", ""), tmp_path)
    wrong, known = map(int, re.findall(r"\d+", printed))
    assert wrong == 0
    assert CLOCKS / 2 < known < CLOCKS
    widths = re.findall(r"DATA_WIDTH_[AB]\(32'd(\d+)\)", netlist)
    assert widths == [str(data_bits)] * 2
    assert ('"OUTREG"' in netlist) == register


@needs_icarus
@pytest.mark.parametrize(
    "spoil", [('"OUTREG"', '"NOREG"'), (".OCEB(enable)", ".OCEB(1'b1)")], ids=["late", "enable"]
)
def test_a_wrong_block_is_found(spoil: tuple[str, str], tmp_path: Path) -> None:
    printed, netlist = simulated(9, 2048, "if (enable) q <= fetched;", spoil, tmp_path)
    assert spoil[0] in netlist
    assert not printed.startswith("0 wrong")


PRODUCT = "module made (input {sign} [17:0] a, input {sign} [17:0] b, output {sign} [35:0] q);"
PRODUCTS = """\
module bench;
  reg {sign} [17:0] a, b;
  wire {sign} [35:0] q;
  integer index, wrong = 0;
  made made_inst (a, b, q);
  initial begin
    for (index = 0; index < {clocks}; index = index + 1) begin
      // Near zero and near the ends now and then.
      a = index % 3 ? $random : index % 16 - 8; b = index % 5 ? $random : index % 16 - 8;
      #1 if (q !== {expected}) wrong = wrong + 1;
    end
    $display("%0d wrong", wrong);
  end
endmodule
"""


@needs_icarus
@pytest.mark.parametrize("sign", ["signed", ""], ids=["signed", "unsigned"])
def test_model_is_the_product(sign: str, tmp_path: Path) -> None:
    device = find_device("ecp5-25k-6")
    (tmp_path / "made.v").write_text(PRODUCT.format(sign=sign) + " assign q = a * b; endmodule\n")
    commands = ["read_verilog made.v", *mapping_commands(device, "made")]
    files = write_simulated(commands, tmp_path, "made", device, ROOT)
    assert re.findall(r"^  (MULT\w+)", files[0].read_text(), re.MULTILINE) == ["MULT18X18D"]
    right, wrong = (
        run_bench(PRODUCTS.format(sign=sign, clocks=CLOCKS, expected=expected), files, tmp_path)
        for expected in ("a * b", "a * b + (a == b)")
    )
    assert right == "0 wrong"
    assert wrong != "0 wrong"
