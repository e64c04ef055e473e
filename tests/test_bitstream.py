# SPDX-License-Identifier: Apache-2.0
"""Boards' files against their tops and pins, what is done with nextpnr's report, and every refusal."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tomllib
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner

from quadshade.board.settings import board_settings
from quadshade.engine.netlist import write_netlist
from quadshade.errors import QuadshadeError
from quadshade.synthesis.bitstream import (
    ENTITY,
    TOP,
    Built,
    build,
    check_pins,
    clocks_of,
    missing_packages,
    ports_of,
    program,
    read_board,
)
from quadshade.synthesis.cells import with_cells
from quadshade.synthesis.families import Device
from quadshade.synthesis.flow import run_yosys
from quadshade.synthesis.mapping import CHECKED
from scripts import bitstream
from scripts.bitstream import page
from tests.support.own_board import CONSTRAINTS, NO_TOP, OWN, own_board

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / "synth" / "boards"
BOARDS = [path.stem for path in sorted(FOLDER.glob("*.toml")) if "top" in path.read_text()]


def run(*arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "scripts.bitstream", *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def test_wrong_words_are_one_line() -> None:
    for words, said in ((("build", "--seeds", "0"), "'--seeds': 0"), (("nope",), "'nope'")):
        result = run(*words)
        assert result.returncode == 2 and result.stdout == ""
        assert result.stderr.startswith("bitstream: error: ") and said in result.stderr
        assert len(result.stderr.splitlines()) == 1


@pytest.mark.parametrize("name", BOARDS)
def test_every_port_has_a_pin(name: str) -> None:
    board = read_board(name, ROOT)
    check_pins(board)
    # None is lost by a pattern that does not fit: each has its line.
    text = board.pins()
    lines = re.findall(r"^(?:LOCATE|set_io|IO_LOC)", text, re.MULTILINE)
    assert len(board.device.described.pins(text)) == len(ports_of(board.top)) == len(lines) > 3


@pytest.mark.parametrize("name", BOARDS)
def test_board_is_one_that_can_be_built(name: str) -> None:
    board = read_board(name, ROOT)
    assert board.formats.value_bits == 8
    least = board.clocks["clk"]
    assert board.generics["clk_frequency_hz"] == least * 1e6
    # A monitor takes 25 million pixels a second, and 1 % more; ten bits of each, two in a cycle.
    shift = board.clocks.get("clk_shift", 125)
    assert 125 <= shift <= 126.25
    assert least * 5 == shift * board.generics.get("clocks_per_pixel", 4) or "clk_shift" not in board.clocks
    assert ("clk_shift" in board.clocks) == bool(board.generics.get("with_video", 0))
    text = (ROOT / "rtl" / "board.vhd").read_text()
    generics = re.findall(r"^    (\w+) : (?:natural|positive) :=", text[: text.index("port (")], re.MULTILINE)
    assert set(board.generics) <= set(generics)


@pytest.mark.parametrize(
    ("entries", "message"),
    [
        (OWN.replace("ecp5-25k-6", "xc7-35"), "unknown family 'xc7'; the families are ecp5, gowin, ice40"),
        (OWN.replace("ecp5-25k-6", "ecp5-9k"), "unknown device 'ecp5-9k'; the devices are ecp5-25k-6"),
        (OWN.replace("device", "devise"), "names no device"),
        (OWN.replace("clocks", "clock"), "no bitstream is built for own: its file has no clocks"),
        (OWN.replace("own.lpf", "lost.lpf"), "names synth/boards/lost.lpf, which is not there"),
        (OWN + 'parts = ["gpdi.v"]', "names synth/boards/gpdi.v, which is not there"),
        (OWN.replace("}", ""), "own.toml: "),
        (OWN.replace('"own.v"', "3"), "own.toml: top is 3; write the name of a file"),
        (
            OWN.replace("{clk = 100}", '{clk = "fast"}'),
            "clocks is {'clk': 'fast'}; write a table of megahertz",
        ),
        (OWN.replace("{clk = 100}", "{clk_shift = 125}"), "write a table of megahertz, clk among them"),
        (OWN.replace("{clk = 100}", "{clk = 0}"), "write a table of megahertz, clk among them"),
        (OWN.replace("generics = {}", 'generics = {buffers = "2"}'), "write a table of whole numbers"),
        (OWN.replace("[]", '"openFPGALoader"'), "write a list of commands, each a list of words"),
        (OWN.replace("[]", "[[]]"), "write a list of commands, each a list of words"),
        ('parts = "gpdi.v"\n' + OWN, "own.toml: parts is 'gpdi.v'; write a list of names of files"),
        ("part = []\n" + OWN, "own.toml has part, which no board has; there are top, constraints"),
    ],
)
def test_a_boards_file_that_is_wrong(entries: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(QuadshadeError, match=message):
        read_board("own", own_board(tmp_path, entries))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('LOCATE COMP "led[1]" SITE "C2";\n', "", r"own.lpf has no pin for led\[1\]; own.v has that port"),
        ('"C2"', '"B2"', r"own.lpf: led\[1\] has the pin B2 of led\[0\]; give it its own"),
        ('"led[1]"', '"led[2]"', r"own.lpf has no pin for led\[1\]"),
        ("\n", '\nLOCATE COMP "button" SITE "D6";\n', "own.lpf has a pin for button; own.v has no such port"),
    ],
    ids=["none", "twice", "another", "one more"],
)
def test_a_pin_that_is_missing(old: str, new: str, message: str, tmp_path: Path) -> None:
    check_pins(read_board("own", own_board(tmp_path / "right", OWN)))
    root = own_board(tmp_path / "wrong", OWN, CONSTRAINTS.replace(old, new, 1))
    with pytest.raises(QuadshadeError, match=message):
        build(read_board("own", root), root)
    assert not (root / "build").exists()


def test_a_tool_that_is_not_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    board = read_board("own", own_board(tmp_path, OWN))
    assert missing_packages(board) == []
    lost = replace(board.device.described, packages=("yowasp-nextpnr-nowhere",))
    monkeypatch.setattr(Device, "described", lost)
    assert missing_packages(board) == ["yowasp-nextpnr-nowhere"]
    with pytest.raises(QuadshadeError, match="yowasp-nextpnr-nowhere is not installed; run `make bitstream`"):
        build(board, tmp_path)


@pytest.mark.parametrize(
    ("generics", "message"),
    [
        ({"clocks_per_pixel": 0}, "clocks_per_pixel is 0; give 1 to 16"),
        ({"bank_words": 3000}, "bank_words is 3000; give 256 or 512"),
    ],
)
def test_generics_of_devices_and_monitors(generics: dict[str, int], message: str) -> None:
    with pytest.raises(QuadshadeError, match=message):
        board_settings(None, None, generics)


def test_what_is_left_out_of_setup_is_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    """With pip, and what ``pyproject.toml`` pins for it; nothing where nothing is missing."""
    ran: list[list[str]] = []
    monkeypatch.setattr(bitstream, "run_tool", lambda command, folder: ran.append(command))
    monkeypatch.setattr(bitstream, "missing_packages", lambda board: ["apycula"])
    bitstream.install(read_board("ulx3s-25f", ROOT), ROOT)
    assert ran == []
    tang = read_board("tang-nano-20k", ROOT)
    bitstream.install(tang, ROOT)
    assert [command[-1] for command in ran] == [".[gowin]"] and ran[0][1:4] == ["-m", "pip", "install"]
    monkeypatch.setattr(bitstream, "missing_packages", lambda board: [])
    bitstream.install(tang, ROOT)
    assert len(ran) == 1
    pinned = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]["gowin"]
    assert {line.split("==")[0] for line in pinned} >= set(tang.device.described.packages)


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
        (["program", "--board", "nexys"], "unknown board 'nexys'"),
    ],
)
def test_refusals(arguments: list[str], what: str) -> None:
    result = run(*arguments)
    assert result.returncode == 2
    assert result.stdout == ""
    assert re.fullmatch(rf"bitstream: error: {re.escape(what)}.*\n", result.stderr), result.stderr


@pytest.mark.parametrize(
    ("entries", "said"),
    [
        (
            NO_TOP,
            "no bitstream is built for own: its file has no top; write it as synth/boards/ulx3s-85f.toml",
        ),
        (
            OWN.replace("generics = {}", "generics = {moons = 2}"),
            "a board has no generic 'moons'; the gene",
        ),
        (OWN.replace("generics = {}", "generics = {buffers = 3}"), "buffers is 3; give 1 or 2"),
        (
            OWN.replace("generics = {}", "generics = {with_video = 1, screen_width = 170}"),
            "with_video=1 with",
        ),
    ],
    ids=["no top", "unknown generic", "out of range", "no monitor"],
)
def test_boards_of_ones_own_are_refused(
    entries: str, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    root = own_board(tmp_path, entries)
    monkeypatch.setattr(bitstream, "repository_root", lambda: root)
    result = CliRunner().invoke(bitstream.main, ["build", "--board", "own"])
    assert result.exit_code == 2 and result.output.startswith(f"bitstream: error: {said}"), result.output
    assert len(result.output.splitlines()) == 1 and not (root / "build").exists()


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


def test_report_is_that_of_its_numbers() -> None:
    report = ROOT / "docs" / "reports" / "bitstream.md"
    rows = json.loads(report.with_suffix(".json").read_text())
    assert report.read_text() == page(rows)
    # What is on the page was met, and a board of the page is still there.
    assert all(mhz >= least for row in rows.values() for mhz, least in row["clocks"].values())
    assert set(rows) <= set(BOARDS)


def test_top_is_named() -> None:
    assert all(f"module {TOP} (" in read_board(name, ROOT).top.read_text() for name in BOARDS)
