# SPDX-License-Identifier: Apache-2.0
"""What a board shows, fetched or proved by its CRC, and boards that show something else."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import quadshade
from quadshade.board import Board, BoardSettings
from quadshade.board.engines import ModelEngine
from quadshade.choices import parse_verify
from quadshade.cli.main import main
from quadshade.errors import QuadshadeError
from quadshade.golden.board import DrawnScreen
from quadshade.image import read_picture
from quadshade.scene import fit_camera, load_scene, project
from quadshade.shading.sample import sample
from quadshade.view.board import ViewedBoard
from quadshade.view.shown import Viewed
from quadshade.view.state import ViewState
from scripts.experiments import read_back

ROOT = Path(__file__).parents[1]
REPORT = (ROOT / "docs" / "reports" / "readback.md").read_text()

SIZE = (48, 32)
SMALL = BoardSettings(screen_width=SIZE[0], screen_height=SIZE[1])
LIE = "the board's colour is not what the golden model predicts: "


def draw_something(board: Board) -> None:
    mesh = load_scene("torus:72")
    seen = project(mesh, fit_camera(mesh), *SIZE, board.host_formats)
    board.draw(sample(seen, "quadratic", formats=board.host_formats))


@pytest.fixture
def board() -> Iterator[Board]:
    with Board("sim", settings=SMALL, engine="model") as opened:
        draw_something(opened)
        yield opened


def received(board: Board, action: Callable[[], object]) -> int:
    before = board.statistics["bytes_received"]
    action()
    return int(board.statistics["bytes_received"] - before)


def screen_of(board: Board) -> DrawnScreen:
    """The simulated board's own screen, not the one that predicts."""
    screen = board.simulated.engine.board.drawing
    assert screen is not board._expected
    return screen


def change_pixels(screen: DrawnScreen, *places: tuple[int, int]) -> None:
    """Let a screen show other pixels than were drawn, whenever it is looked at."""
    plane_of = screen.plane

    def plane(number: int) -> np.ndarray:
        shown = plane_of(number).copy()
        for x, y in places:
            shown[y, x, 0] ^= 1
        return shown

    screen.plane = plane


def test_crc_gives_the_models_picture_for_a_few_bytes(board: Board) -> None:
    pictures = []
    fetched = received(board, lambda: pictures.append(board.read()))
    proved = received(board, lambda: pictures.append(board.read(verify="crc")))
    assert np.array_equal(*pictures) and pictures[0].any()
    # STATUS, which says that the board was not reset, an acknowledgement and the CRC.
    assert proved < 128 and fetched > 1000
    part = board.read(20, 30, verify="crc")
    assert np.array_equal(part, pictures[0][:30, :20])
    assert np.array_equal(board.read_depth(verify="crc"), board.read_depth())
    # The caller may write on it.
    part[:] = 0
    assert np.array_equal(board.read(verify="crc"), pictures[0])


@pytest.mark.parametrize("verify", ("crc", "picture", True))
def test_a_board_that_shows_another_picture(board: Board, verify: str | bool) -> None:
    right = board.read()
    change_pixels(screen_of(board), (40, 3), (5, 20))
    red, green, blue = right[3, 40].tolist()
    first = f"{red ^ 1} {green} {blue}, not {red} {green} {blue};"
    message = f"{LIE}2 of 1536 pixels differ, the first at 40,3: {first}"
    with pytest.raises(QuadshadeError) as error:
        board.read(verify=verify)
    assert str(error.value).startswith(message)
    # Believed, it is what the board shows.
    assert np.count_nonzero(board.read(verify="none") != right) == 2


def test_a_board_whose_crc_alone_is_wrong(board: Board) -> None:
    screen_of(board).frame_crc = lambda _: 1
    with pytest.raises(
        QuadshadeError, match=f"{LIE}its CRC is another, every pixel that was read is the same"
    ):
        board.read(verify="crc")


def test_a_board_that_reads_other_pixels_than_it_sums(board: Board) -> None:
    """A part of the picture has no CRC of its own."""
    screen = screen_of(board)
    summed = screen.frame_crc(0)
    screen.frame_crc = lambda _: summed
    change_pixels(screen, (7, 9))
    with pytest.raises(QuadshadeError, match=f"{LIE}1 of 200 pixels differ, the first at 7,9: "):
        board.read(20, 10)


def test_what_verify_takes() -> None:
    assert [parse_verify(value) for value in (True, False, "crc")] == ["picture", "none", "crc"]
    with pytest.raises(QuadshadeError, match="the verification is 'crcs'; give one of picture, crc, none"):
        quadshade.render("sphere:24", size=SIZE, port="sim", verify="crcs")
    with pytest.raises(QuadshadeError, match="verify is 3, of type int; give True, False, or one of picture"):
        quadshade.render("sphere:24", size=SIZE, port="sim", verify=3)
    with pytest.raises(QuadshadeError, match="--verify crc is for a board; give --port as well"):
        quadshade.render("sphere:24", size=SIZE, engine="model", verify="crc")


def test_the_report_and_the_guide_say_what_is_measured() -> None:
    row = read_back.measure("sphere:690")[0]
    line = next(line for line in REPORT.splitlines() if "sphere:690 | colour" in line)
    cells = [cell.strip() for cell in line.split("|")]
    assert cells[3:7] == [str(row[name]) for name in ("bytes", *read_back.WAYS)]
    guide = " ".join((ROOT / "docs" / "guide" / "board_api.md").read_text().split())
    assert f"four bytes, {row['crc']} with all frames" in guide
    assert f"`picture` takes {row['packed']} bytes" in guide and f"{row['whole']} from a board" in guide
    assert row["whole"] > 4 * row["packed"]
    page = " ".join((ROOT / "docs" / "reference" / "readback.md").read_text().split())
    assert f"{row['whole'] / row['packed']:.1f} times fewer on the line" in page


# The commands.


def run(*arguments: object) -> tuple[int, str]:
    result = CliRunner().invoke(main, [str(argument) for argument in arguments])
    return result.exit_code, result.output


BOARD = ("--port", "sim", "--engine", "model")


@pytest.fixture
def commands(tmp_path: Path) -> dict[str, tuple[object, ...]]:
    """Commands that draw on a board; the output comes behind them."""
    frame, triangles = tmp_path / "frame.qs", ROOT / "examples" / "triangles.json"
    code, output = run("pack", "torus:72", "--size", "48x32", "-o", frame)
    assert code == 0, output
    return {
        "render": ("render", "torus:72", "--size", "48x32"),
        "turn": ("turn", "torus:72", "--frames", "2", "--size", "48x32", "--no-errors"),
        "raster": ("raster", triangles),
        "replay": ("replay", frame),
    }


@pytest.mark.parametrize("name", ("render", "turn", "raster", "replay"))
def test_commands_take_crc(
    name: str, commands: dict, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pictures = []
    for verify in ("picture", "crc"):
        path = tmp_path / f"{verify}.png"
        code, output = run(*commands[name], "-o", path, *BOARD, "--verify", verify)
        assert code == 0, output
        pictures.append(path.read_bytes())
    assert pictures[0] == pictures[1]
    begin = ModelEngine.__init__

    def lie(engine: ModelEngine, *arguments: object) -> None:
        begin(engine, *arguments)
        change_pixels(engine.board.drawing, (1, 2))

    monkeypatch.setattr(ModelEngine, "__init__", lie)
    path = tmp_path / "lie.png"
    code, output = run(*commands[name], "-o", path, *BOARD, "--verify", "crc")
    said = [line for line in output.splitlines() if "golden model" in line]
    assert code == 2 and len(said) == 1 and "the first at 1,2" in said[0]
    assert "Traceback" not in output and not list(tmp_path.glob("*lie*"))


def test_no_verify_is_a_word_too(commands: dict, tmp_path: Path) -> None:
    paths = [tmp_path / "a.png", tmp_path / "b.png"]
    for path, words in zip(paths, (("--no-verify",), ("--verify", "none")), strict=True):
        code, output = run(*commands["render"], "-o", path, *BOARD, *words)
        assert code == 0 and "golden model" not in output, output
    assert np.array_equal(*map(read_picture, paths))
    code, output = run(*commands["render"], "-o", paths[0], "--engine", "model", "--verify", "crc")
    assert code == 2 and "--verify crc is for a board; give --port as well" in output
    code, output = run(*commands["render"], "-o", paths[0], *BOARD, "--verify", "all")
    assert code == 2 and "'all' is not one of 'picture', 'crc', 'none'" in output
    for words in (("--verify", "crc"), ("--no-verify",)):
        code, output = run("view", "sphere:24", "--no-open", *words)
        assert code == 2 and "--verify is for a board; give --port as well" in output
    for words in (("--verify", "crc", "--no-verify"), ("--no-verify", "--verify", "picture")):
        code, output = run(*commands["render"], "-o", paths[0], *BOARD, *words)
        assert code == 2 and "and --no-verify are given; give one of them" in output


def test_the_viewer_asks_for_the_crc_alone(board: Board) -> None:
    state = ViewState.read({"width": 40, "height": 30})
    viewed = Viewed("torus:72", load_scene("torus:72"))
    bytes_of = {}
    for verify, text in (
        ("crc", "CRC equal"),
        ("picture", "picture and CRC equal"),
        ("none", "not compared"),
    ):
        shown = ViewedBoard(board, viewed, verify)
        bytes_of[verify] = received(board, lambda shown=shown, text=text: said(shown.draw(state), text))
    assert bytes_of["crc"] + 1000 < bytes_of["none"] < bytes_of["picture"]
    change_pixels(screen_of(board), (1, 2))
    assert "stopped: " + LIE in ViewedBoard(board, viewed).draw(state)["text"]


def said(answer: dict, text: str) -> None:
    assert answer["goes_on"] and answer["text"].endswith(f"{text}, 40x30")
