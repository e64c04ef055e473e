# SPDX-License-Identifier: Apache-2.0
"""Boards from Python and from the command line: simulated ones behind pseudo-terminals and TCP ports."""

from __future__ import annotations

import json
import re
import signal
import subprocess
import sys
import tomllib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import quadshade
from quadshade.board import Board, BoardSettings
from quadshade.board.settings import board_settings
from quadshade.cli.main import main
from quadshade.contract.formats import Formats
from quadshade.contract.protocol import FEATURES
from quadshade.contract.triangles import ScreenTriangles
from quadshade.engine import draw
from quadshade.errors import QuadshadeError
from quadshade.image import read_picture, resolve
from quadshade.scene import fit_camera, load_scene, project
from quadshade.shading.sample import sample

ROOT = Path(__file__).resolve().parents[1]
SMALL = BoardSettings(screen_width=48, screen_height=32)


def seen(scene: str, formats: Formats, size: tuple[int, int] = (48, 32)):
    mesh = load_scene(scene)
    return sample(project(mesh, fit_camera(mesh), *size, formats), "quadratic", formats=formats)


def run(*arguments: str) -> tuple[int, str]:
    result = CliRunner().invoke(main, [str(argument) for argument in arguments])
    return result.exit_code, result.output


@contextmanager
def board_program(*arguments: str, screen: str = "48x32") -> Iterator[tuple[subprocess.Popen, str]]:
    """``quadshade board`` as a process, and the port that it says."""
    command = [sys.executable, "-c", "from quadshade.cli.main import main; main()", "board"]
    process = subprocess.Popen(
        [*command, "--engine", "model", "--screen", screen, *arguments], stdout=subprocess.PIPE, text=True
    )
    try:
        yield process, re.search(r"--port (\S+)", process.stdout.readline())[1]
    finally:
        process.kill()
        process.wait()


@pytest.mark.parametrize("engine", ["model", "verilator", "ghdl"])
def test_what_is_read_is_what_the_model_draws(engine: str) -> None:
    size = (48, 32) if engine != "ghdl" else (8, 6)
    settings = BoardSettings(screen_width=size[0], screen_height=size[1])
    with Board("sim", settings=settings, engine=engine) as board:
        triangles = seen("sphere:168" if engine != "ghdl" else "sphere:2x3", board.host_formats, size)
        board.clear((9, 8, 7))
        board.draw(triangles, pack_error=0)
        image = board.read()
        status = board.status()
    expected = resolve(draw(triangles, Formats()).pixels, *size, (9, 8, 7))
    assert np.array_equal(image, expected)
    assert status["bad_crc"] == status["overruns"] == 0
    # The golden model counts frames, not pixels.
    assert engine == "model" or status["pixels"] > 0


def test_edges_are_read_from_the_netlist(tmp_path: Path) -> None:
    pictures = []
    for where in (("--port", "sim", "--engine", "verilator", "--pack-error", "0"), ("--engine", "model")):
        path = tmp_path / f"{len(pictures)}.png"
        base = ("render", "cube:2", "-o", path, "--size", "160x120", "--camera", "from=1,0.8,1")
        code, output = run(*base, "--edges", "profile,inner", *where)
        assert code == 0, output
        assert "notice" not in output
        pictures.append(read_picture(path))
    assert np.array_equal(*pictures)


def test_an_adaptive_picture_is_drawn_with_cosines_and_said_so(tmp_path: Path) -> None:
    # Seen from the front, in a material of which cosines are the cheaper ones.
    surface = "colour=0.35,0.6,0.95,diffuse=0.6,ambient=0.08,specular=0.35,exponent=60"
    look = ("--camera", "from=0,0,1", "--material", surface)
    base = ("render", "sphere:168", "--size", "48x32", *look, "--max-error", "0.9")
    board, host, stats = tmp_path / "board.png", tmp_path / "host.png", tmp_path / "a.json"
    simulated = ("--port", "sim", "--engine", "model", "--pack-error", "0", "--stats", stats)
    code, output = run(*base, "-o", board, *simulated)
    assert code == 0, output
    mix = json.loads(stats.read_text())["adaptive"]
    # Both kinds go through the shade unit; which takes fewer bytes is close.
    assert {mix["adaptive_shading"], mix["rival"]["shading"]} == {"quadratic-specular", "quadratic-lights"}
    assert mix["rival"]["bytes"] > 0
    assert f"as the golden model predicts\n  channels   {mix['adaptive_shading']}\n" in output
    # The board has a third channel, so that colours are a choice: words, but not pixels.
    code, output = run(*base, "-o", host, "--engine", "model", "--generic", "num_channels=3")
    assert code == 0, output
    assert np.array_equal(read_picture(board), read_picture(host))
    # Edges come from a G-buffer, which takes a board without the shade unit.
    code, output = run(*base, "-o", board, *simulated, "--edges", "profile,inner")
    assert code == 0, output
    assert "channels   quadratic\n" in output and "drawn as quadratic: generic with_shade is 0" in output
    assert "edges drawn by the host" not in output


def test_a_board_without_edge_map_leaves_them_to_the_host() -> None:
    told: list[str] = []
    from quadshade.rendering import PortChoice, RenderSettings, Reports, SceneChoice, StyleChoice
    from quadshade.rendering.board import style_on_board
    from quadshade.rendering.shade import ShownScene
    from quadshade.style import draw_edges, draw_gbuffer, find_edges

    mesh = load_scene("cube:2")
    settings = RenderSettings(
        SceneChoice(mesh), style=StyleChoice(edges="profile,inner"), port=PortChoice("sim", pack_error=0.0)
    )
    white = np.full((32, 48, 3), 255, np.uint8)
    with Board("sim", settings=SMALL, engine="model", notice=told.append) as board:
        camera = fit_camera(mesh, direction=np.array([1, 0.8, 1]))
        projected = project(mesh, camera, 48, 32, board.formats)
        scene = ShownScene(projected, None, None, (255, 255, 255), len(mesh), mesh, camera)
        picture = style_on_board(settings, white, scene, board, Reports(told.append))
    gbuffer, _ = draw_gbuffer(projected)
    assert np.array_equal(picture, draw_edges(white, find_edges(gbuffer)))
    assert len(told) == 1 and "no edge map" in told[0]


def test_grey_and_without_depth_say_so() -> None:
    told: list[str] = []
    formats = Formats(num_channels=1, with_depth=0)
    settings = BoardSettings(formats, screen_width=48, screen_height=32)
    with Board("sim", settings=settings, engine="model", notice=told.append) as board:
        board.draw(seen("torus:72", board.host_formats))
        image = board.read()
    assert (image == image[..., :1]).all() and image.any()
    assert any("painter's order" in text and "pixels differ" in text for text in told)
    assert any("grey" in text for text in told)


@pytest.mark.parametrize(("rate", "size"), [(1e-3, (48, 32)), (1e-2, (16, 12))])
def test_a_damaged_line_costs_time_only(rate: float, size: tuple[int, int]) -> None:
    settings = BoardSettings(Formats(), *size)
    with Board("sim", settings=settings, engine="model", faults=(rate, 3), answer_seconds=0.05) as board:
        board.draw(seen("sphere:168", board.host_formats, size))
        board.read()
        assert board.statistics["resent"] > 0


def test_too_large_for_the_screen() -> None:
    triangles = seen("sphere:168", Formats(), (64, 32))
    message = "64x32 pixels, the board's screen 48x32"
    with (
        Board("sim", settings=SMALL, engine="model") as board,
        pytest.raises(QuadshadeError, match=message),
    ):
        board.draw(triangles)


@pytest.mark.parametrize(
    "misuse",
    (
        lambda board, _: board.clear((300, 0, 0)),
        lambda board, _: board.clear((0, 0, 0.5)),
        lambda board, _: board.clear((1, 2)),
        lambda board, _: board.clear(5),
        lambda board, _: board.draw("sphere:168"),
        lambda board, triangles: board.draw(triangles, limit=float("nan")),
        lambda board, _: board.send([1, 2]),
        lambda board, _: board.send(np.full(3, np.nan)),
        lambda board, _: board.read(0, 5),
        lambda board, _: board.read(-1),
        lambda board, _: board.read(1.5),
    ),
)
def test_misuse_is_said_and_does_no_harm(misuse: Callable[[Board, ScreenTriangles], object]) -> None:
    triangles = seen("sphere:24", Formats(), (48, 32))
    with Board("sim", settings=SMALL, engine="model") as board:
        board.clear(np.array((1, 2, 3)))
        with pytest.raises(QuadshadeError):
            misuse(board, triangles)
        assert (board.read() == (1, 2, 3)).all()
    with pytest.raises(QuadshadeError, match="the board is closed; open another"):
        board.read()
    assert board.simulated is None


@pytest.mark.parametrize(
    ("port", "keywords"),
    (
        (1, {}),
        (b"sim", {}),
        ("sim", {"baud": 0}),
        ("sim", {"answer_seconds": -1}),
        ("sim", {"answer_seconds": 0}),
    ),
)
def test_a_board_takes_what_it_says_it_takes(port: object, keywords: dict) -> None:
    with pytest.raises(QuadshadeError, match="give"):
        Board(port, settings=SMALL, engine="model", **keywords)


@pytest.mark.parametrize(
    ("generics", "message"),
    (
        ({"value_bits": 6}, "value_bits is 6, and every board has 8"),
        ({"stream_width": 128}, "stream_width is 128, and every board has 32"),
        ({"num_channels": 5}, "at most 4"),
        ({"with_edge_map": 1, "with_depth": 0}, "give three channels"),
        ({"with_edge_map": 1, "num_channels": 4}, "give three channels"),
        ({"single_port_memory": 1}, "give with_depth=0"),
        ({"fifo_words": 64}, "give a power of two from 256"),
        ({"clk_frequency_hz": 1 << 30}, "below 2"),
    ),
    ids=str,
)
def test_a_board_is_one_that_the_vhdl_builds(generics: dict[str, int], message: str) -> None:
    """``board.vhd`` and ``screen.vhd`` assert the same."""
    with pytest.raises(QuadshadeError, match=message):
        board_settings(None, None, generics)


@pytest.mark.parametrize("toon", (None, 3))
@pytest.mark.parametrize(
    ("scene", "keywords"),
    (
        ("torus:16x9", {}),
        ("torus:16x9", {"material": "fresnel=1.5"}),
        ("torus:16x9", {"lights": ["dir=1,1,1", "dir=-1,0,1"]}),
        ("torus:16x9", {"lights": [f"dir={x},0,1" for x in range(5)]}),
        ("examples/pawn.obj", {"edges": "inner"}),
    ),
    ids=str,
)
@pytest.mark.filterwarnings("ignore")
def test_a_simulated_board_has_the_channels_of_the_scene(
    scene: str, keywords: dict, toon: int | None
) -> None:
    """Cosines where the scene has them, for each light; else colours, as the model draws."""
    arguments = {
        "shading": "quadratic-specular",
        "toon": toon,
        "size": (40, 30),
        "engine": "model",
    } | keywords
    path = scene if ":" in scene else Path(__file__).resolve().parents[1] / scene
    drawn = quadshade.render(path, port="sim", pack_error=0, **arguments)
    assert np.array_equal(drawn.array, quadshade.render(path, **arguments).array)


def test_a_killed_host_leaves_the_board_to_the_next(tmp_path: Path) -> None:
    link = tmp_path / "board"
    with board_program("--pty", str(link)) as (process, port):
        assert port == str(link)
        half = "import os, sys; from quadshade.board import Board; b = Board(sys.argv[1]); "
        half += (
            "b.session.triangles([0x12345678] * 90); b.session.transport.write(b'\\x00\\x05ab'); os._exit(9)"
        )
        assert subprocess.run([sys.executable, "-c", half, port], check=False).returncode == 9
        code, output = run("render", "sphere:168", "-o", tmp_path / "a.png", "--port", port)
        assert code == 0, output
        assert "as the golden model predicts" in output
        process.send_signal(signal.SIGINT)
        assert process.wait(20) == 0
        assert "the board has stopped" in process.stdout.read()
    assert not link.exists()


def test_a_killed_board_is_drawn_anew(tmp_path: Path) -> None:
    link = tmp_path / "board"
    with board_program("--pty", str(link)) as (first, port):
        board = Board(port, answer_seconds=0.5, reconnect_seconds=30)
        try:
            board.draw(seen("torus:72", board.host_formats))
            first.kill()
            first.wait()
            with board_program("--pty", str(link)):
                board.draw(seen("sphere:168", board.host_formats))
                board.read()  # verified: both drawings are there
                assert board.statistics["redraws"] >= 1
        finally:
            board.close()


def test_tcp(tmp_path: Path) -> None:
    with board_program("--tcp", "0") as (_, port):
        assert port.startswith("socket://")
        code, output = run("info", "--port", port)
        assert code == 0, output
        assert "screen_width" in output and "depth_test" in output
        code, output = run(
            "raster", ROOT / "tests" / "missing.json", "-o", tmp_path / "a.png", "--port", port
        )
        assert code == 2


BOARD_FILES = {
    path.stem: tomllib.loads(path.read_text()) for path in (ROOT / "synth" / "boards").glob("*.toml")
}
REAL_BOARDS = sorted(name for name, file in BOARD_FILES.items() if "top" in file)


@pytest.mark.parametrize("name", REAL_BOARDS)
def test_every_real_board_is_simulated(name: str, tmp_path: Path) -> None:
    """``quadshade board --board NAME`` has the generics of the board's file, and draws."""
    generics = BOARD_FILES[name]["generics"]
    link = tmp_path / "board.tty"
    size = f"{generics['screen_width']}x{generics['screen_height']}"
    with (
        board_program("--pty", str(link), "--board", name, screen=size),
        Board(str(link), notice=str) as board,
    ):
        known = {key: value for key, value in generics.items() if key in board.identity}
        known["clk_frequency_hz"] = BoardSettings().clk_frequency_hz
        assert known == {key: board.identity[key] for key in known}
        assert bool(board.identity["features"] >> FEATURES.index("display") & 1) == bool(
            generics.get("with_video")
        )
        board.draw(seen("sphere:2x3", board.host_formats, (board.width, board.height)))
        # read checks the CRC of the golden model's picture.
        assert board.read().any()


@pytest.mark.parametrize(("name", "engine"), [("icebreaker", "verilator"), ("icebreaker", "ghdl")])
def test_a_real_board_is_simulated_from_its_netlist(name: str, engine: str) -> None:
    settings = board_settings(name, (8, 6), {})
    assert settings.generics()["crc_cycles"] == settings.generics()["most_counter_bits"] == 8
    with Board("sim", settings=settings, engine=engine, notice=str) as board:
        board.draw(seen("sphere:2x3", board.host_formats, (8, 6)))
        assert board.read().any()
        assert board.status()["bad_crc"] == board.status()["overruns"] == 0


def test_a_monitor_is_simulated_from_the_netlist() -> None:
    """With ``with_video``, which the ULX3S boards have, beside the smallest core."""
    small = {"num_channels": 1, "with_depth": 0, "coord_bits": 9, "word_width": 20, "frac_bits": 10}
    settings = board_settings(None, (160, 120), small | {"with_video": 1})
    with Board("sim", settings=settings, engine="verilator", notice=str) as board:
        assert board.identity["features"] >> FEATURES.index("display") & 1
        board.draw(seen("sphere:2x3", board.host_formats, (160, 120)))
        assert board.read().any()


def test_counters_of_a_small_board_wrap() -> None:
    settings = board_settings("icebreaker", (8, 6), {"most_counter_bits": 2})
    with Board("sim", settings=settings, engine="model", notice=str) as board:
        before = board.status()["frames"]
        for _ in range(5):
            board.clear()
        assert board.status()["frames"] == (before + 5) % 4


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("render", "sphere:168", "-o", "a.png", "--port", "/dev/ttyUSB99"), "there is no port"),
        (("render", "sphere:168", "-o", "a.png", "--port", "sim", "--waves", "a.ghw"), "no waves"),
        (("render", "sphere:168", "-o", "a.png", "--port", "sim", "--shading", "phong"), "phong"),
        (("render", "cube:1", "-o", "a.png", "--port", "sim", "--gbuffer", "a.npz"), "which triangle"),
        (("board", "--generic", "fifo_words=100"), "power of two"),
        (("board", "--board", "moon"), "unknown board 'moon'; the boards are colorlight-i5"),
        (("board", "--board", "ulx3s-12f", "--screen", "48x32"), "give --generic with_video=0, or 1 or 3"),
        (("board", "--generic", "crc_cycles=3"), "crc_cycles is 3; give 1 or 2 or 4 or 8"),
        (("board", "--generic", "most_counter_bits=0"), "most_counter_bits is 0; give 1 to 32"),
        (("board", "--generic", "moon=1"), "a board has no generic 'moon'"),
        (("board", "--pty", "a", "--tcp", "1"), "give one of them"),
        (("replay", "missing.qs", "--port", "sim"), "missing.qs"),
        (("info", "--port", "sim", "--timeout", "nan"), "not a number of seconds"),
    ],
)
def test_wrong_choices(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: tuple[str, ...], message: str
) -> None:
    monkeypatch.chdir(tmp_path)
    code, output = run(*arguments)
    assert code == 2 and message in output, output
    assert "Traceback" not in output


def test_pack_and_replay(tmp_path: Path) -> None:
    frame, direct, replayed = tmp_path / "a.qs", tmp_path / "a.png", tmp_path / "b.png"
    base = ("sphere:168", "--size", "48x32")
    for arguments in (
        ("pack", *base, "-o", frame),
        ("render", *base, "-o", direct, "--port", "sim"),
        ("replay", frame, "-o", replayed, "--port", "sim"),
    ):
        code, output = run(*arguments)
        assert code == 0, output
    assert np.array_equal(read_picture(direct), read_picture(replayed))
