# SPDX-License-Identifier: Apache-2.0
"""Synthesis: devices, boards, harness, the tools' reports, the resource table; `make synth-check` places."""

from __future__ import annotations

import copy
import json
import re
import subprocess
import sys
from dataclasses import asdict
from pathlib import Path

import pytest

from quadshade.contract.formats import Formats
from quadshade.engine.netlist import TOP, write_netlist
from quadshade.engine.tool_runner import find_tool
from quadshade.errors import QuadshadeError
from quadshade.synthesis import (
    devices,
    find_board,
    find_device,
    find_family,
    flow,
    module_ports,
    table,
    write_harness,
)
from quadshade.synthesis.flow import Implementation, Placed, run_nextpnr, run_yosys
from quadshade.synthesis.mapping import CHECKED
from quadshade.synthesis.tool_reports import (
    Area,
    CriticalPath,
    area_from_stat,
    critical_path,
    fmax_mhz,
    fullest,
    signal_names,
)

ROOT = Path(__file__).resolve().parents[1]
SMALL = {
    "num_channels": 1,
    "max_order": 1,
    "with_depth": 0,
    "word_width": 12,
    "frac_bits": 2,
    "coord_bits": 4,
    "subpixel_bits": 2,
    "span_depth": 1,
}
PORTS = """\
module raster_core
  (input  clk,
   input  [31:0] setup_data,
   output setup_ready,
   output [7:0] pixel_value);
endmodule
"""


def script(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "scripts.synth", *arguments],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.parametrize("arguments", [["--device", "ecp5-25k-7"], ["--board", "nexys"], []])
def test_unknown_device_is_one_line(arguments: list[str]) -> None:
    result = script("run", *arguments)
    assert result.returncode == 2
    assert result.stdout == ""
    assert re.fullmatch(r"synth: error: .+\n", result.stderr)


def test_every_board_names_a_device() -> None:
    boards = sorted((ROOT / "synth" / "boards").glob("*.toml"))
    assert boards
    for board in boards:
        assert find_board(board.stem, ROOT).name in devices()
    assert find_board("ulx3s-25f", ROOT) is find_device("ecp5-25k-6")
    assert find_board("icebreaker", ROOT) is find_device("ice40-up5k")


def test_board_file_without_device(tmp_path: Path) -> None:
    (tmp_path / "synth" / "boards").mkdir(parents=True)
    (tmp_path / "synth" / "boards" / "bare.toml").write_text("# nothing\n")
    with pytest.raises(QuadshadeError, match="names no device"):
        find_board("bare", tmp_path)


def test_module_ports() -> None:
    found = [(port.name, port.direction, port.bits) for port in module_ports(PORTS, TOP)]
    assert found == [
        ("clk", "input", 1),
        ("setup_data", "input", 32),
        ("setup_ready", "output", 1),
        ("pixel_value", "output", 8),
    ]
    with pytest.raises(QuadshadeError, match="no module other"):
        module_ports(PORTS, "other")


def test_harness_connects_every_bit_once() -> None:
    text = write_harness(module_ports(PORTS, TOP), TOP)
    assert "wire [31:0] stimulus" in text and "wire [8:0] response" in text
    assert ".setup_data(stimulus[31:0])" in text
    assert ".setup_ready(response[0:0])" in text and ".pixel_value(response[8:1])" in text


def test_netlist_is_sound(tmp_path: Path) -> None:
    """No string constant, no latch, no loop, nothing undriven, for a core small enough to check quickly."""
    netlist = write_netlist(Formats(**SMALL).core_generics())
    verilog = netlist.read_text()
    assert '"' not in verilog
    (tmp_path / "core.v").write_text(verilog)
    run_yosys(["read_verilog core.v", f"hierarchy -check -top {TOP}", *CHECKED], tmp_path)


@pytest.mark.parametrize(
    "body",
    [
        "always @* if (clk) q = d;",
        "assign q = d; assign q = clk;",
        "wire a = ~b; wire b = a & d; assign q = b;",
    ],
    ids=["latch", "two drivers", "loop"],
)
def test_unsound_netlist_is_refused(tmp_path: Path, body: str) -> None:
    kind = "reg" if "always" in body else "wire"
    (tmp_path / "bad.v").write_text(f"module bad(input clk, input d, output {kind} q); {body} endmodule\n")
    with pytest.raises(QuadshadeError, match="failed"):
        run_yosys(["read_verilog bad.v", "hierarchy -check -top bad", *CHECKED], tmp_path)


def test_missing_tool() -> None:
    with pytest.raises(QuadshadeError, match="is not installed"):
        find_tool("nextpnr-of-nowhere")


def test_area_counts_carry_cells_twice_on_ecp5() -> None:
    def area(family: str, cells: dict[str, int]) -> Area:
        return area_from_stat({"design": {"num_cells_by_type": cells}}, find_family(family).counted)

    cells = {"CCU2C": 5, "LUT4": 7, "TRELLIS_FF": 3, "DP16KD": 2, "MULT18X18D": 1, "PFUMX": 4}
    assert area("ecp5", cells) == Area(17, 5, 10, 3, 2, 1)
    cells = {"SB_CARRY": 5, "SB_LUT4": 7, "SB_DFFESR": 3, "SB_DFF": 1, "SB_RAM40_4K": 2, "SB_MAC16": 1}
    assert area("ice40", cells) == Area(7, 5, 0, 4, 2, 1)
    cells = {"ALU": 5, "LUT2": 3, "LUT4": 4, "DFFRE": 3, "DFF": 1, "DPX9B": 1, "DPB": 1, "MULT9X9": 1}
    assert area("gowin", cells) == Area(12, 5, 5, 4, 2, 1)
    with pytest.raises(QuadshadeError, match="no cells"):
        area("ecp5", {})


CELLS = {
    "cells": {
        "dut.n1_q_FF": {"type": "TRELLIS_FF", "connections": {"Q": [4], "D": [9]}},
        "dut.sum_LUT": {"type": "SB_LUT4", "connections": {"O": [7]}},
        "dut.sum_SB_DFF": {"type": "SB_DFF", "connections": {"D": [7], "Q": [8]}},
    },
    "netnames": {
        "dut.n1_q": {"bits": [4]},
        "dut.walker_inst.rows": {"bits": [3, 4]},
        "dut.n2_q": {"bits": [8]},
        "dut.span_inst.count": {"bits": [8]},
    },
}


def step(kind: str, delay: float, cell: str) -> dict:
    return {"type": kind, "delay": delay, "from": {"cell": cell}, "to": {"cell": cell}}


REPORT = {
    "fmax": {"clk": {"achieved": 198.7, "constraint": 250}},
    "critical_paths": [
        {"from": "<async>", "to": "posedge clk", "path": [step("routing", 99.0, "pad")]},
        {
            "from": "posedge clk",
            "to": "posedge clk",
            "path": [
                step("clk-to-q", 0.5, "dut.n1_q_FF"),
                step("routing", 1.25, "dut.n1_q_FF"),
                step("logic", 0.25, "dut.sum_LUT"),
                step("routing", 0.0, "dut.sum_LUT"),
                step("logic", 0.25, "dut.sum_LUT"),
                step("routing", 0.75, "dut.sum_LUT_LC"),
                step("setup", 0.0, "dut.sum_LUT_LC"),
            ],
        },
    ],
}


def test_critical_path_in_names_of_the_vhdl() -> None:
    assert signal_names(CELLS)[4] == "dut.walker_inst.rows[1]"
    assert critical_path(REPORT, CELLS) == CriticalPath("walker_inst.rows[1]", "span_inst.count", 1.0, 2.0, 1)
    with pytest.raises(QuadshadeError, match="no path"):
        critical_path({"critical_paths": REPORT["critical_paths"][:1]}, CELLS)


LOG = """\
Info: Device utilisation:
Info: \t         ICESTORM_LC:    5288/   5280   100%
Info: \t               SB_GB:       8/      8   100%
Info: \t       ICESTORM_PLL:       0/      0     0%
"""


def test_what_fills_the_device() -> None:
    kinds = tuple(find_family("ice40").area.values())
    assert fullest(LOG, kinds) == ("ICESTORM_LC", 5288, 5280)
    assert fullest("ERROR: no such file", kinds) is None


def test_too_large_for_the_device(tmp_path: Path) -> None:
    device = find_device("ice40-up5k")
    made = "reg [5299:0] r = 0; always @(posedge clk) r <= {r[5298:0], a}; assign q = r[5299];"
    (tmp_path / "made.v").write_text(f"module made (input clk, input a, output q);\n{made}\nendmodule\n")
    run_yosys(["read_verilog made.v", f"{device.yosys} -top made", "write_json made.json"], tmp_path)
    with pytest.raises(
        QuadshadeError, match=r"no place .* on ice40-up5k: 53\d\d of 5280 ICESTORM_LC"
    ) as raised:
        run_nextpnr([*device.place, *device.described.unconstrained, "--json", "made.json"], tmp_path, device)
    assert "fewer channels" in str(raised.value)
    with pytest.raises(QuadshadeError, match=r"nextpnr-ice40 failed: .*none\.json"):
        run_nextpnr([*device.place, *device.described.unconstrained, "--json", "none.json"], tmp_path, device)


FULL = """\
Info: \t              DP16KD:      60/     56   107%
Info: \t        TRELLIS_COMB:    9000/  24288    37%
"""


@pytest.mark.parametrize(
    ("log", "said"),
    [
        (FULL, r"60 of 56 DP16KD; give a smaller screen, colour_bits=6 or 4"),
        (FULL.replace("9000", "24999"), r"60 of 56 DP16KD; give a smaller screen"),
        (FULL.replace("60/", "10/"), r"9000 of 24288 TRELLIS_COMB; give fewer channels"),
        ("", "no BELs remaining"),
    ],
    ids=["memory", "memory first", "logic", "no log"],
)
def test_what_to_leave_out(log: str, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(*arguments: object) -> str:
        (tmp_path / "nextpnr.log").write_text(log)
        raise QuadshadeError("nextpnr failed: ERROR: no BELs remaining to implement a cell")

    monkeypatch.setattr(flow, "run_tool", fails)
    with pytest.raises(QuadshadeError, match=said):
        run_nextpnr(["nextpnr"], tmp_path, find_device("ecp5-25k-6"))


def test_fmax() -> None:
    assert fmax_mhz(REPORT) == 198.7
    with pytest.raises(QuadshadeError, match="2 clocks"):
        fmax_mhz({"fmax": REPORT["fmax"] | {"other": {}}})


def implementation(*clocks: float) -> Implementation:
    path = CriticalPath("a", "b", 1.0, 2.0, 3)
    runs = tuple(Placed(seed, clock, path) for seed, clock in enumerate(clocks, start=1))
    return Implementation("ecp5-25k-6", Area(10, 2, 4, 5, 0, 0), runs)


def test_median_of_seeds() -> None:
    result = implementation(3.0, 1.0, 2.0, 9.0)
    assert result.fmax_mhz == 2.5
    assert result.typical.seed == 3


def row(floor: float) -> dict:
    given = {"name": "core", "device": "ecp5-25k-6", "generics": {"stream_width": 128}, "floor_mhz": floor}
    return given | table.measured(implementation(180.0, 190.0, 200.0), implementation(200.0))


def test_table_row_and_its_failures() -> None:
    good = row(185.0)
    assert good["fmax_mhz"] == 190.0 and good["ratio"] == 0.95
    assert table.timing_failures(good) == [] and table.differences(good, good) == []
    assert len(table.timing_failures(row(191.0))) == 1
    grown = copy.deepcopy(good)
    grown["area"]["lut4"] += 1
    assert table.differences(good, grown) == ["core on ecp5-25k-6: lut4 is 11, the table says 10"]


def test_find_row_knows_defaults() -> None:
    rows = {"rows": [row(1.0)]}
    assert table.find_row(rows, "ecp5-25k-6", {"stream_width": 128, "num_channels": 3}) is rows["rows"][0]
    assert table.find_row(rows, "ecp5-25k-6", {"stream_width": 64}) is None
    assert table.find_row(rows, "ecp5-25k-8", {"stream_width": 128}) is None


def test_table_file_round_trip() -> None:
    whole = {"seeds": 5, "tools": ["pyosys 0"], "rows": [row(1.0), row(2.0)]}
    assert json.loads(table.dumps(whole)) == whole


def test_cells_name_the_width_of_the_stream() -> None:
    header, (cells,) = table.cells({"rows": [row(1.0)]})
    shown = dict(zip(header, cells, strict=True))
    assert shown["set-up stream"] == "128 bits" and shown["configuration"] == "core"
    assert [shown[name] for name in ("LUT4", "flip-flops", "block RAM", "multipliers")] == [
        "10",
        "5",
        "0",
        "0",
    ]
    assert (shown["MHz"], shown["lone accumulator"], shown["ratio"]) == ("190", "200", "0.95")


def test_table_in_the_repository() -> None:
    """Every row is complete, names a device, and stands above its floor."""
    whole = table.read_table(ROOT)
    assert whole["rows"]
    for entry in whole["rows"]:
        find_device(entry["device"])
        Formats().with_generics(entry["generics"])
        assert set(entry) == set(row(1.0)), entry["name"]
        assert set(entry["area"]) == set(asdict(Area(0, 0, 0, 0, 0, 0)))
        assert len(entry["runs_mhz"]) == len(entry["lone_runs_mhz"]) == whole["seeds"]
        assert entry["floor_mhz"] > 0 and table.timing_failures(entry) == []
