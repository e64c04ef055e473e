# SPDX-License-Identifier: Apache-2.0
"""What takes long says what it does, without a terminal too; sizes that no board has are said at once."""

from __future__ import annotations

import time
from pathlib import Path

import pytest
from click.testing import CliRunner

from quadshade.board.large_screen import large_screen_notice, largest_screen
from quadshade.board.settings import BoardSettings
from quadshade.cli import terminal
from quadshade.cli.main import main
from quadshade.cli.terminal import reporting
from quadshade.engine.ghdl import analyse
from quadshade.engine.sources import repository_root
from quadshade.trade import progress
from quadshade.trade.progress import progress_bars


def test_a_long_step_is_said_without_a_terminal(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(terminal, "QUIET_SECONDS", 0.05)
    with reporting() as reports:
        reports.step("a short step")
        reports.step("shading 7 triangles")
        time.sleep(0.5)
        assert reports.progress is not None
        for done in range(5):
            reports.progress("reading", done, 5, 0)
        time.sleep(0.5)
    assert capsys.readouterr().err.splitlines() == [
        "quadshade: shading 7 triangles ...",
        "quadshade: reading on the board ...",
    ]


def test_a_short_step_is_not(capsys: pytest.CaptureFixture[str]) -> None:
    with reporting() as reports:
        reports.step("a short step")
    assert capsys.readouterr().err == ""


def test_a_sweep_says_how_far_it_is_without_a_terminal(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with progress_bars() as tell:
        tell("points", 0, 6)
    assert capsys.readouterr().err == ""
    monkeypatch.setattr(progress, "FIRST_SECONDS", 0.05)
    monkeypatch.setattr(progress, "LINE_SECONDS", 0.05)
    with progress_bars() as tell:
        for done in (0, 4, 6):
            tell("points", done, 6)
            time.sleep(0.5)
    assert capsys.readouterr().err.splitlines() == [
        f"quadshade: {done} of 6 points measured ..." for done in (0, 4)
    ]


def test_an_analysis_is_said_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("rtl", "sim"):
        (tmp_path / name).symlink_to(repository_root() / name)
    for _ in range(2):
        analyse(tmp_path)
    assert capsys.readouterr().err.count("quadshade: analysing the VHDL for GHDL") == 1


def test_the_largest_screen_is_a_boards() -> None:
    _, width, height = largest_screen()
    assert (width, height) == (640, 480)
    assert large_screen_notice(BoardSettings(screen_width=width, screen_height=height), "model") == ""


def test_a_board_says_so_before_it_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("quadshade.board.large_screen.largest_screen", lambda: ("small", 8, 6))
    monkeypatch.setattr("quadshade.board.simulated.SimulatedBoard.run", lambda _: None)
    monkeypatch.setattr("quadshade.cli.board.signal.signal", lambda *_: None)
    result = CliRunner().invoke(main, ["board", "--tcp", "0", "--engine", "model", "--screen", "16x12"])
    assert result.exit_code == 0, result.output
    assert result.output.startswith("quadshade: notice: no board has 16x12 pixels, the largest screen is 8x6")


def test_a_simulated_screen_is_one_that_a_board_has(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("quadshade.rendering.simulated.REAL_SCREEN", (8, 6))
    command = ["render", "sphere:2x3", "-o", str(tmp_path / "a.png"), "--port", "sim", "--engine", "model"]
    result = CliRunner().invoke(main, [*command, "--size", "16x12"])
    assert result.exit_code == 0, result.output
    assert "no board has" not in result.output and " tiles, as the golden" in result.output


@pytest.mark.parametrize(
    ("engine", "estimate"),
    [
        ("verilator", ", and about 5 minutes of simulation"),
        ("ghdl", ", and about 259 minutes of simulation"),
        ("model", ""),
    ],
)
def test_a_size_that_no_board_has_is_estimated(engine: str, estimate: str) -> None:
    settings = BoardSettings(screen_width=1920, screen_height=1080)
    assert large_screen_notice(settings, engine) == (
        "no board has 1920x1080 pixels, the largest screen is 640x480 (icepi-zero-sdram); reading the picture"
        f" takes 62 s of a line at 1000000 baud{estimate}; give --screen 640x480: larger pictures are drawn"
        " on it in tiles"
    )
