# SPDX-License-Identifier: Apache-2.0
"""``--port sim`` and ``--port sim:BOARD``: what the simulated board is, whatever is drawn on it."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest

import quadshade
from quadshade.board import Board, BoardSettings
from quadshade.board.engines import GhdlEngine
from quadshade.board.settings import board_settings
from quadshade.choices import parse_ports, simulated_board
from quadshade.errors import QuadshadeError
from quadshade.image import read_picture
from quadshade.rendering import PortChoice, RenderSettings, Reports, SceneChoice, StyleChoice
from quadshade.rendering.simulated import worker_place
from tests.support.own_board import NO_TOP, own_board
from tests.test_board_api import run
from tests.test_words import EXAMPLE

BOARDS = Path(__file__).resolve().parents[1] / "synth" / "boards"
MODEL = ("--engine", "model")


def settings_for(
    size: str | None, edges: str | None = None, port: str = "sim", **generics: int
) -> BoardSettings:
    """Generics of the board that would be simulated for a picture."""
    scene = SceneChoice("cube:1", size=size, generics=generics)
    return worker_place(RenderSettings(scene, style=StyleChoice(edges=edges), port=PortChoice(port))).settings


def test_one_board_is_built_for_pictures_of_any_size() -> None:
    real = tomllib.loads((BOARDS / "ulx3s-25f.toml").read_text())["generics"]
    usual = settings_for(None)
    assert (usual.screen_width, usual.screen_height) == (real["screen_width"], real["screen_height"])
    assert {settings_for(size) for size in ("1x1", "48x32", "160x120", "161x9", "4096x4096")} == {usual}
    # An edge map is built where the picture ends with the screen, or goes on.
    edged = {
        size: settings_for(size, "profile").with_edge_map for size in (None, "159x120", "160x120", "170x130")
    }
    assert edged == {None: 1, "159x120": 0, "160x120": 1, "170x130": 1}
    # As far as coordinates reach, or as is asked for.
    assert settings_for("20x20", coord_bits=5).screen_height == 32
    assert settings_for("20x20", screen_width=24, screen_height=22).screen_width == 24


def test_a_port_may_name_a_board() -> None:
    assert [simulated_board(port) for port in ("sim", "sim:icebreaker", "simple", None, 3)] == [
        "",
        "icebreaker",
        None,
        None,
        None,
    ]
    twice = ("sim:icebreaker", "sim:icebreaker", "sim")
    assert parse_ports(["sim:icebreaker", "sim:icebreaker", "sim:1"]) == twice
    expected = board_settings("icebreaker", None, {})
    assert settings_for("48x32", port="sim:icebreaker") == expected
    with Board("sim:icebreaker", engine="model") as board:
        assert board.formats == expected.formats and (board.width, board.height) == (320, 240)
    for port, keywords, said in (
        ("sim:icebreaker", {"settings": BoardSettings()}, "has its own"),
        ("sim:4", {}, "is 4 boards"),
        ("sim:moon", {}, "unknown board 'moon'; the boards are colorlight-i5, icebreaker"),
        ("sim:", {}, "sim:1 to sim:64"),
    ):
        with pytest.raises(QuadshadeError, match=said):
            Board(port, engine="model", **keywords)


def test_every_command_draws_on_a_board_that_is_named(tmp_path: Path) -> None:
    named = ("--port", "sim:icebreaker", *MODEL)
    frame, packed, drawn = tmp_path / "a.qs", tmp_path / "packed.png", tmp_path / "drawn.png"
    sphere = ("sphere:24", "--size", "40x30")
    commands = (
        ("render", *sphere, "-o", drawn, *named),
        ("turn", *sphere, "--frames", 2, "-o", tmp_path / "t.gif", "--no-errors", *named),
        ("raster", EXAMPLE, "-o", tmp_path / "r.png", *named),
    )
    said = {}
    for words in commands:
        code, said[words[0]] = run(*words)
        assert code == 0, said[words[0]]
    assert "drawn in grey: the board has one channel" in said["render"]
    assert "drawn in painter's order" in said["raster"]
    picture = read_picture(drawn)
    assert picture.any() and (picture == picture[..., :1]).all()
    assert run("pack", *sphere, "-o", frame)[0] == 0
    code, output = run("replay", frame, "-o", packed, *named)
    assert code == 2 and "no board draws the picture: it has 1 channel" in output, output
    whole = ("--port", "sim:ulx3s-25f", *MODEL)
    for words in (("replay", frame, "-o", packed, *whole), ("render", *sphere, "-o", drawn, *whole)):
        code, output = run(*words)
        assert code == 0, output
    assert np.array_equal(read_picture(packed), read_picture(drawn))


def test_boards_of_several_kinds_share_a_picture() -> None:
    told: list[str] = []
    arguments = {"size": (330, 9), "engine": "model", "reports": Reports(notice=told.append)}
    mixed = quadshade.render("icosphere:1", port=["sim", "sim:icebreaker"], **arguments)
    assert "drawn in grey: the board has one channel" in told
    alone = quadshade.render(
        "icosphere:1", port="sim", generics={"num_channels": 1, "with_depth": 0}, **arguments
    )
    assert mixed.array.any() and np.array_equal(mixed.array, alone.array)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--port", "sim:moon"), "unknown board 'moon'; the boards are colorlight-i5, icebreaker"),
        (("--port", "sim", "--port", "sim:moon"), "unknown board 'moon'"),
        (("--port", "sim:icebreaker", "--generic", "num_channels=3"), "the board's generics are its own"),
        (("--port", "sim:icebreaker", "--port", "sim:65"), "sim:1 to sim:64"),
    ],
)
def test_wrong_boards_are_one_line(tmp_path: Path, words: tuple[str, ...], said: str) -> None:
    code, output = run("render", "cube:1", "-o", tmp_path / "a.png", *MODEL, *words)
    assert code == 2 and said in output, output
    assert len(output.strip().splitlines()) == 1 and not list(tmp_path.iterdir())


def test_a_board_without_a_top_is_not_simulated(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    root = own_board(tmp_path, NO_TOP)
    monkeypatch.setattr("quadshade.board.settings.repository_root", lambda: root)
    for arguments in (("board", "--board", "own"), ("render", "cube:1", "-o", "a.png", "--port", "sim:own")):
        code, output = run(*arguments)
        assert code == 2 and "no bitstream is built for own: its file has no top" in output, output
        assert len(output.strip().splitlines()) == 1


def test_what_a_simulator_says_instead_of_bytes_ends_it() -> None:
    engine = GhdlEngine(["echo", "board_tb:error: cannot find generic 'new'"])
    try:
        with pytest.raises(QuadshadeError, match="the simulation says: board_tb:error: cannot find"):
            engine.take()
    finally:
        engine.close()
