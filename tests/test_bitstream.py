# SPDX-License-Identifier: Apache-2.0
"""Boards' files against their tops and pins, what is done with nextpnr's report, and every refusal."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from quadshade.engine.netlist import write_netlist
from quadshade.errors import QuadshadeError
from quadshade.synthesis.bitstream import (
    ENTITY,
    TOP,
    Built,
    clocks_of,
    program,
    read_board,
)
from quadshade.synthesis.cells import with_cells
from quadshade.synthesis.flow import run_yosys
from quadshade.synthesis.mapping import CHECKED

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / "synth" / "boards"
BOARDS = [path.stem for path in sorted(FOLDER.glob("*.toml")) if "top" in path.read_text()]


def run(*arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "scripts.bitstream", *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def ports(top: Path) -> set[str]:
    """Every bit of a top's ports, as pins are named."""
    text = re.sub(r"//.*", "", top.read_text())
    header = re.search(r"module top \((.*?)\);", text, re.DOTALL)[1]
    found = set()
    for high, name in re.findall(r"(?:input|output)\s+(?:\[(\d+):0\]\s+)?(\w+)", header):
        found |= {f"{name}[{index}]" for index in range(int(high) + 1)} if high else {name}
    return found


@pytest.mark.parametrize("name", BOARDS)
def test_every_port_has_a_pin(name: str) -> None:
    board = read_board(name, ROOT)
    pins = dict(
        re.findall(r'(?:LOCATE COMP|set_io) "?([\w\[\]]+)"? (?:SITE )?"?(\w+)', board.constraints.read_text())
    )
    assert set(pins) == ports(board.top)
    assert len(set(pins.values())) == len(pins)


@pytest.mark.parametrize("name", BOARDS)
def test_board_is_one_that_can_be_built(name: str) -> None:
    board = read_board(name, ROOT)
    assert board.formats.value_bits == 8
    least = board.clocks["clk"]
    assert board.generics["clk_frequency_hz"] == least * 1e6
    # Ten bits of a pixel, two in a cycle, in four of the system's.
    assert board.clocks.get("clk_shift", 1.25 * least) == 1.25 * least
    assert ("clk_shift" in board.clocks) == bool(board.generics.get("with_video", 0))
    text = (ROOT / "rtl" / "board.vhd").read_text()
    generics = re.findall(r"^    (\w+) : (?:natural|positive) :=", text[: text.index("port (")], re.MULTILINE)
    assert set(board.generics) <= set(generics)


def test_small_board_has_no_latch(tmp_path: Path) -> None:
    board = read_board("icebreaker", ROOT)
    verilog = write_netlist(board.generics, ENTITY).read_text()
    (tmp_path / "board.v").write_text(verilog)
    run_yosys(["read_verilog board.v", f"hierarchy -check -top {ENTITY}", *CHECKED], tmp_path)
    # Its memory becomes that of the device, under the name that GHDL gave.
    (name,) = re.findall(r"^module (single_port_ram_\w+)", verilog, re.MULTILINE)
    cells = with_cells(verilog, "ice40", ROOT)
    assert len(re.findall(rf"^module {name}\b", cells, re.MULTILINE)) == 1
    assert "SB_SPRAM256KA" in cells and "num_words = 76800" in cells
    assert with_cells("module other;\nendmodule\n", "ice40", ROOT) == "module other;\nendmodule\n"


def test_clocks() -> None:
    report = {"fmax": {"$glbnet$inst.clk": {"achieved": 61.5}, "$glbnet$clk_pixel": {"achieved": 20.0}}}
    assert clocks_of(report, {"clk": 50, "clk_pixel": 25}) == {"clk": (61.5, 50), "clk_pixel": (20.0, 25)}
    with pytest.raises(QuadshadeError, match="no limit"):
        clocks_of(report, {"pixel": 25})
    with pytest.raises(QuadshadeError, match="no clock shift"):
        clocks_of(report, {"clk": 50, "clk_pixel": 25, "shift": 125})
    built = Built(Path("x"), 1, clocks_of(report, {"clk": 50, "clk_pixel": 25}), {})
    assert built.too_slow == {"clk_pixel": (20.0, 25)}


@pytest.mark.parametrize(
    ("arguments", "what"),
    [
        (["build"], "no board is given"),
        (["build", "--board", "nexys"], "unknown board 'nexys'"),
        (["build", "--board", "ulx3s-45f"], "no bitstream is built for ulx3s-45f"),
        (["program", "--board", "nexys"], "unknown board 'nexys'"),
    ],
)
def test_refusals(arguments: list[str], what: str) -> None:
    result = run(*arguments)
    assert result.returncode == 2
    assert result.stdout == ""
    assert re.fullmatch(rf"bitstream: error: {re.escape(what)}.*\n", result.stderr), result.stderr


def test_program(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture) -> None:
    board = read_board("icebreaker", ROOT)
    with pytest.raises(QuadshadeError, match="there is no build/bitstream/icebreaker.bin"):
        program(board, tmp_path)
    path = board.bitstream(tmp_path)
    path.parent.mkdir(parents=True)
    path.write_bytes(b"bits")
    tools = tmp_path / "bin"
    tools.mkdir()
    monkeypatch.setenv("PATH", str(tools))
    with pytest.raises(QuadshadeError, match="iceprog or openFPGALoader is not installed"):
        program(board, tmp_path)
    loader = tools / "openFPGALoader"
    loader.write_text('#!/bin/sh\necho "loaded $*"\n')
    loader.chmod(0o755)
    assert program(board, tmp_path) == ["openFPGALoader", "-b", "ice40_generic", str(path)]
    assert capfd.readouterr().out == f"loaded -b ice40_generic {path}\n"
    loader.write_text("#!/bin/sh\nexit 3\n")
    with pytest.raises(QuadshadeError, match="exit code 3"):
        program(board, tmp_path)


def test_top_is_named() -> None:
    assert all(f"module {TOP} (" in read_board(name, ROOT).top.read_text() for name in BOARDS)
