# SPDX-License-Identifier: Apache-2.0
"""Pictures that are larger than a board's screen: drawn in tiles, they are the model's byte for byte."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

import quadshade
from quadshade.board import Board, BoardSettings
from quadshade.board.fallbacks import host_formats, sent_triangles
from quadshade.board.pool import BoardPool, wait_until_free
from quadshade.board.readback import BoardReader
from quadshade.board.tile_plan import PACKET_BYTES, TILE_BYTES, plan_tiles
from quadshade.board.tile_store import TileStore
from quadshade.board.tiled_picture import Planes, TiledPicture, paste
from quadshade.board.tiled_screen import TiledScreen
from quadshade.board.worker_boards import EngineScreen
from quadshade.cli.main import main
from quadshade.contract.formats import Formats
from quadshade.engine import draw
from quadshade.errors import QuadshadeError
from quadshade.image import read_picture, resolve
from quadshade.rendering import Reports
from quadshade.scene import fit_camera, load_scene, project
from quadshade.setup.refit import picture_formats
from quadshade.setup.tile import Rectangle
from quadshade.shading.sample import sample
from tests.support.golden_stimuli import triangles_of
from tests.test_board_api import run
from tests.test_setup_tile import ICEBREAKER
from tests.test_words import EXAMPLE

SIZE = (61, 47)
SMALL = {"size": SIZE, "camera": "from=1,2,3"}
LOOKS: dict[str, dict[str, object]] = {
    "colours": {},
    "background": {"background": (0.1, 0.5, 0.9), "shading": "gouraud"},
    "fractional": {"stepping": "fractional"},
    "cartoon": {"style": "cartoon"},
    "hatch": {"style": "hatch"},
    "edges": {"edges": "profile,inner"},
    "eight": {"edges": "profile,inner", "edge_variant": "eight", "style": "gooch"},
    "mean": {"supersample": 2},
    "adaptive": {"max_error": 3, "shading": "quadratic"},
}


def small_board(width: int = 24, height: int = 20, **generics: int) -> Board:
    """A board of the golden model with few pixels."""
    settings = BoardSettings(screen_width=width, screen_height=height).with_generics(generics)
    return Board("sim", settings=settings, engine="model")


def quiet(**more: object) -> Reports:
    return Reports(notice=lambda _: None, **more)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def board() -> Iterator[Board]:
    with small_board(with_edge_map=1) as opened:
        yield opened


@pytest.fixture(scope="module")
def shaded() -> Iterator[Board]:
    with small_board(with_shade=1, num_channels=2, num_specular=2) as opened:
        yield opened


@pytest.mark.parametrize("look", LOOKS)
def test_tiles_are_the_models_picture(look: str, board: Board, shaded: Board) -> None:
    arguments = SMALL | LOOKS[look]
    drawn = quadshade.render("torus:288", port=shaded if look == "cartoon" else board, **arguments)
    model = quadshade.render("torus:288", engine="model", **arguments)
    assert np.array_equal(drawn.array, model.array)
    assert len(np.unique(model.array)) > 3
    assert " tiles, as the golden model predicts" in drawn.summary


@pytest.mark.parametrize("name", ("ulx3s", "icebreaker"))
def test_a_monitors_picture_on_a_boards_screen(name: str) -> None:
    """1920 x 1080 on 160 x 120 and on one channel in painter's order: every tile is drawn, none is sent."""
    size = (1920, 1080)
    formats = {"ulx3s": Formats(), "icebreaker": ICEBREAKER}[name]
    screen = EngineScreen(BoardSettings(formats, 160, 120), "model")
    picture = TiledPicture(picture_formats([formats], *size), *size)
    mesh, shading = load_scene("sphere:168"), host_formats(picture.formats)
    triangles = sample(project(mesh, fit_camera(mesh), *size, shading), "quadratic", formats=shading)
    picture.clear((0, 40, 0))
    picture.draw(triangles, 0.0)
    planes = picture.ground(("colour",))
    for cost in picture.plan((160, 120), ("colour",)):
        paste(planes, cost.tile, picture.draw_tile(screen, cost.tile, ("colour",), True))
    drawn = draw(sent_triangles(triangles, picture.formats), picture.formats)
    expected = resolve(drawn.pixels, *size, (0, 40, 0) if name == "ulx3s" else (29,) * 3)
    assert np.array_equal(BoardReader.as_rgb(planes["colour"]), expected)
    assert drawn.stats["pixels"] > 500_000


def test_powers_at_the_pixel_go_through_a_shade_unit() -> None:
    arguments = SMALL | {"shading": "quadratic-specular", "exponent": 50}
    with small_board(with_shade=1, num_channels=2) as opened:
        drawn = quadshade.render("torus:288", port=opened, **arguments)
    assert np.array_equal(drawn.array, quadshade.render("torus:288", engine="model", **arguments).array)


def test_edges_come_from_the_boards_own_edge_map(board: Board) -> None:
    """With a margin round each tile; without the unit the host takes them from normals and depth."""
    told: list[str] = []
    arguments = SMALL | {"edges": "profile,inner", "reports": Reports(notice=told.append)}
    own = quadshade.render("cube:2", port=board, **arguments)
    assert told == []
    with small_board() as other:
        host = quadshade.render("cube:2", port=other, **arguments)
    assert "edges found by the host in the board's G-buffer" in told[0]
    assert np.array_equal(own.array, host.array)


@pytest.mark.parametrize("pack_error", (0.0, 1 / 16))
@pytest.mark.parametrize("name", ("icebreaker", "colours"))
def test_tiles_are_the_picture_of_a_screen_that_were_large_enough(name: str, pack_error: float) -> None:
    """Painter's order and one channel included; shorter words too are those of the whole picture."""
    formats = {"icebreaker": ICEBREAKER, "colours": Formats(coord_bits=6)}[name]
    pictures = []
    for size in ((32, 20), SIZE):
        settings = BoardSettings(formats, *size, single_port_memory=int(not formats.with_depth))
        with Board("sim", settings=settings, engine="model") as opened:
            drawn = quadshade.render(
                "sphere:168", port=opened, pack_error=pack_error, reports=quiet(), **SMALL
            )
            pictures.append(drawn.array)
    assert np.array_equal(*pictures)
    assert len(np.unique(pictures[0])) > 50


@pytest.mark.parametrize("seed", range(4))
def test_random_scenes_and_every_seam(seed: int) -> None:
    """Triangles of every awkward kind, on screens of a few pixels; colour and depth."""
    formats = Formats()
    triangles = triangles_of(formats, np.random.default_rng(seed), 42, 40)
    expected = []
    with Board("sim", settings=BoardSettings(formats, 40, 39), engine="model") as large:
        large.clear((9, 8, 7))
        large.draw(triangles, 0.0)
        expected = [large.read(), large.read_depth()]
    width, height = 5 + 3 * seed, 13 - 2 * seed
    with small_board(width, height) as opened:
        screen = TiledScreen(BoardPool([opened], print), 40, 39, print)
        screen.clear((9, 8, 7))
        screen.draw(triangles)
        planes = screen.read_planes(("colour", "depth"))
        tiles = screen.tiles
        assert np.array_equal(screen.read(), expected[0])
        assert np.array_equal(screen.read_depth(), expected[1])
        assert screen.as_rgb(planes["colour"]) is not None
        # What was read together was drawn once.
        assert screen.tiles == tiles >= -(-40 // width) * -(-39 // height)


def test_plans_have_every_pixel_once_and_no_empty_tile() -> None:
    rng = np.random.default_rng(3)
    for _ in range(30):
        size = tuple(rng.integers(20, 400, 2).tolist())
        most = tuple(rng.integers(7, 90, 2).tolist())
        corner = rng.integers(-20, 400, (60, 2))
        extents = np.concatenate([corner, corner + rng.integers(1, 30, (60, 2))], axis=1)
        count = np.zeros(size[::-1], int)
        for cost in plan_tiles(extents, size, most, 3, int(rng.integers(1, 5))):
            tile = cost.tile
            assert 0 < tile.width <= most[0] and 0 < tile.height <= most[1]
            count[tile.top : tile.bottom, tile.left : tile.right] += 1
        assert count.max(initial=0) <= 1
        for left, top, right, bottom in np.maximum(extents, 0).tolist():
            assert (count[top:bottom, left:right] == 1).all()
    assert plan_tiles(np.zeros((0, 4), int), (9, 9), (3, 3), 3) == []


def test_plans_take_few_bytes() -> None:
    """A disc of small triangles: much fewer pixels are read than of a grid."""
    y, x = np.mgrid[0:480:8, 0:640:8].reshape(2, -1)
    inside = np.hypot(x - 320, y - 240) < 230
    extents = np.stack([x, y, x + 9, y + 9], axis=1)[inside]
    plan = plan_tiles(extents, (640, 480), (160, 120), 3)
    area = sum(cost.tile.width * cost.tile.height for cost in plan)
    assert area < 0.7 * 640 * 480
    total = sum(cost.bytes for cost in plan)
    assert total <= 3 * area + 1.4 * PACKET_BYTES * len(extents) + TILE_BYTES * len(plan)
    # Not with the fewest tiles, of which there are 16 here.
    grid = plan_tiles(np.array([[0, 0, 640, 480]]), (640, 480), (160, 120), 3)
    assert len(grid) == 16 < len(plan)
    assert [cost.bytes for cost in plan] == sorted((cost.bytes for cost in plan), reverse=True)


def test_a_picture_that_was_broken_off_goes_on(
    tmp_path: Path, board: Board, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn_tiles: list[Rectangle] = []
    draw_tile = TiledPicture.draw_tile

    def counted(self: TiledPicture, on: Board, tile: Rectangle, *more: Any) -> Planes:
        drawn_tiles.append(tile)
        return draw_tile(self, on, tile, *more)

    monkeypatch.setattr(TiledPicture, "draw_tile", counted)
    folder = tmp_path / "tiles"
    model = quadshade.render("torus:288", engine="model", **SMALL)
    counts: list[float] = []

    def stop(what: str, done: float, total: float, sent: int) -> None:
        assert what == "drawing tiles" and 0 < done <= total and sent > 0
        counts.append(total)
        if len(counts) == 1:
            raise KeyboardInterrupt

    # What is kept of it keeps all that was running, as in a notebook.
    with pytest.raises(KeyboardInterrupt) as kept:
        quadshade.render("torus:288", port=board, resume=folder, reports=quiet(progress=stop), **SMALL)
    assert len(list(folder.glob("*/*.npz"))) == 1
    wait_until_free(board)
    assert kept.value and 1 <= len(drawn_tiles) <= 2 < counts[0]
    told: list[str] = []
    before = board.statistics["triangles"]
    drawn = quadshade.render(
        "torus:288", port=board, resume=folder, reports=Reports(notice=told.append), **SMALL
    )
    assert told == [f"1 of {counts[0]} tiles were drawn before"]
    assert re.search(rf"in {counts[0] - 1} tiles?\b", drawn.summary)
    assert board.statistics["triangles"] > before
    assert np.array_equal(drawn.array, model.array)
    assert not folder.exists()


def test_tiles_of_another_picture_are_not_taken(tmp_path: Path) -> None:
    store = TileStore(tmp_path / "tiles")
    store.begin([b"one"], ("colour",))
    store.add(Rectangle(0, 0, 2, 1), {"colour": np.ones((1, 2, 3), np.uint8)})
    again = TileStore(tmp_path / "tiles")
    again.begin([b"other"], ("colour",))
    assert again.tiles() == []
    again.begin([b"one"], ("colour",))
    [(tile, planes)] = again.tiles()
    assert tile == (0, 0, 2, 1) and planes["colour"].tolist() == [[[1, 1, 1], [1, 1, 1]]]
    kept = next(tmp_path.glob("tiles/*/*.npz"))
    whole = kept.read_bytes()
    for broken in (b"cut short", b"", whole[: len(whole) // 2], whole.replace(b"\1" * 6, b"\2" * 6)):
        assert broken != whole
        kept.write_bytes(broken)
        assert again.tiles() == []
    kept.write_bytes(whole)
    new = TileStore(tmp_path / "tiles", is_new=True)
    # Only what begins removes what was there.
    assert kept.is_file()
    new.begin([b"one"], ("colour",))
    assert new.tiles() == [] and not kept.exists()
    new.add(tile, planes)
    new.begin([b"one"], ("depth",))
    assert kept.is_file()
    (tmp_path / "mine").mkdir()
    with pytest.raises(QuadshadeError, match="holds no tiles"):
        TileStore(tmp_path / "mine")


def test_a_wrong_option_removes_no_tiles(tmp_path: Path) -> None:
    store = TileStore(tmp_path / ".p.png.tiles")
    store.begin([b"one"], ("colour",))
    store.add(Rectangle(0, 0, 1, 1), {"colour": np.ones((1, 1, 3), np.uint8)})
    sim = ("--port", "sim", "--engine", "model", "--size", "170x122")
    code, _ = run("render", "icosphere:0", "-o", tmp_path / "p.png", *sim, "--shading", "phong")
    assert code == 2 and len(list(store.folder.glob("*/*.npz"))) == 1


def test_an_empty_picture_is_drawn_in_no_tiles(tmp_path: Path) -> None:
    sim = ("--port", "sim:2", "--engine", "model", "--size", "32x24")
    away = ("--camera", "eye=0,0,9,target=0,0,20")
    code, output = run("render", "icosphere:0", "-o", tmp_path / "p.png", *sim, *away)
    assert code == 0 and "0 triangles, drawn by the board at sim:2, as" in output


def test_commands_draw_in_tiles(tmp_path: Path) -> None:
    """Larger than a real board's screen: render, raster, replay and turn, with --port sim."""
    sim = ("--port", "sim", "--engine", "model")
    scene = ("icosphere:0", "--size", "170x122")
    paths = {name: tmp_path / f"{name}.png" for name in ("model", "board", "raster", "replay")}
    for words in (
        ("render", *scene, "-o", paths["model"], "--engine", "model"),
        ("render", *scene, "-o", paths["board"], *sim, "--stats", tmp_path / "stats.json"),
        ("pack", *scene, "-o", tmp_path / "frame.qs", "--pack-error", "0"),
        ("replay", tmp_path / "frame.qs", "-o", paths["replay"], *sim),
    ):
        code, output = run(*words)
        assert code == 0, output
    assert np.array_equal(read_picture(paths["model"]), read_picture(paths["board"]))
    assert np.array_equal(read_picture(paths["model"]), read_picture(paths["replay"]))
    assert not list(tmp_path.glob(".*"))


def test_no_board_is_too_small_and_no_picture_too_large() -> None:
    with small_board(1, 1) as opened:
        drawn = quadshade.render("icosphere:0", port=opened, size=(4, 3))
        assert np.array_equal(drawn.array, quadshade.render("icosphere:0", engine="model", size=(4, 3)).array)
        with pytest.raises(QuadshadeError, match="give 1x1 to 8192x8192"):
            quadshade.render("icosphere:0", port=opened, size=(9000, 3))


@pytest.mark.parametrize(
    ("size", "board", "least", "ortho"),
    [((40, 30), (3, 2), 60, 1.0), ((4096, 1024), (24, 20), 4, 15)],
    ids=["many", "far"],
)
def test_tiles_of_a_tiny_screen(
    size: tuple[int, int], board: tuple[int, int], least: int, ortho: float
) -> None:
    """Tiles of six pixels; and a small thing amid a picture of four million."""
    asked = {"size": size, "camera": f"from=1,2,3,ortho={ortho}"}
    model = quadshade.render("icosphere:0", engine="model", **asked).array
    with small_board(*board) as opened:
        drawn = quadshade.render("icosphere:0", port=opened, verify="crc", **asked)
    assert np.array_equal(drawn.array, model) and model.any()
    assert int(re.search(r"in (\d+) tile", drawn.summary)[1]) >= least


def test_a_picture_that_no_memory_holds_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise MemoryError

    monkeypatch.setattr("quadshade.board.tiled_picture.np.tile", full)
    with (
        small_board() as opened,
        pytest.raises(QuadshadeError, match="61x47 pixels does not fit in this mach"),
    ):
        quadshade.render("icosphere:0", port=opened, **SMALL)


def test_a_picture_that_no_board_draws_is_refused() -> None:
    told: list[str] = []
    with (
        small_board() as opened,
        pytest.raises(QuadshadeError, match="no board draws .*: its words have 32 bits, 22 of them fraction"),
    ):
        TiledScreen(BoardPool([opened], told.append), 40, 30, told.append, formats=Formats(frac_bits=20))
    assert told == [], "the error says it of the only board"


@pytest.mark.parametrize("command", [("render", "cube:2"), ("raster", str(EXAMPLE))])
def test_only_what_is_kept_is_resumed(tmp_path: Path, command: tuple[str, ...]) -> None:
    result = CliRunner().invoke(main, [*command, "--resume", "--engine", "model", "-o", f"{tmp_path}/a.png"])
    assert result.exit_code == 2 and "--resume is for a board; give --port as well" in result.output
    assert not list(tmp_path.iterdir())
