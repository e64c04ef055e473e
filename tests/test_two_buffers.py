# SPDX-License-Identifier: Apache-2.0
"""Boards with two buffers and fewer bits a colour: what is shown is whole, what is read is right."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import quadshade
from cocotb_tests.support.link_stimuli import body_of
from quadshade.board import Board
from quadshade.board.engines import start_engine
from quadshade.board.settings import board_settings
from quadshade.cli.main import main
from quadshade.contract.identity import colour_bits as colour_bits_of
from quadshade.contract.identity import plane_bytes
from quadshade.contract.protocol import LinkError, Opcode
from quadshade.errors import QuadshadeError
from quadshade.golden.board import BoardModel
from quadshade.golden.screen.framebuffer import HALF_STEP, kept_colours, thresholds
from quadshade.image import read_picture
from quadshade.link.frames import enclosed
from quadshade.link.session import Session
from quadshade.link.transport import MemoryTransport
from quadshade.packing.pack import pack_primitives
from quadshade.scene import fit_camera, load_scene, project
from quadshade.setup.triangle_setup import setup_triangles
from quadshade.shading.sample import sample

SIZE = (48, 32)
GENERICS = {"buffers": 2, "colour_bits": 4}
SDRAM = {
    "with_sdram": 1,
    "buffers": 2,
    "colour_bits": 5,
    "depth_bits": 15,
    "screen_width": 640,
    "screen_height": 480,
}


def a_board(engine: str = "model", **generics: int) -> Board:
    """A simulated one."""
    return Board("sim", settings=board_settings(None, SIZE, GENERICS | generics), engine=engine, notice=str)


def kept(picture: np.ndarray, colour_bits: int) -> np.ndarray:
    """(h, w, 3) uint8: a picture as such a board keeps it."""
    y, x = np.indices(picture.shape[:2])
    return kept_colours(picture, thresholds(x, y), colour_bits).astype(np.uint8)


def watched(board: Board) -> list[np.ndarray]:
    """The pictures that a monitor shows from now on; each must stay as it is until the next swap."""
    drawing = board.simulated.engine.board.drawing
    swap, pictures = drawing.swap, [drawing.shown.copy()]

    def look() -> None:
        assert np.array_equal(drawing.shown, pictures[-1])
        swap()
        pictures.append(drawing.shown.copy())

    drawing.swap = look
    return pictures


def test_a_monitor_shows_whole_pictures_only() -> None:
    scenes = ("cube:2", "sphere:168", "torus:288")
    with a_board() as board:
        shown = watched(board)
        read = [quadshade.render(scene, port=board, size=SIZE, pack_error=0).array for scene in scenes]
    wanted = [np.zeros_like(read[0]), *read]
    assert len(shown) == len(wanted)
    assert all(np.array_equal(one, other) for one, other in zip(shown, wanted, strict=True))


def test_edges_are_drawn_unseen() -> None:
    """The G-buffer for the edges is drawn into the buffer that is not shown."""
    with a_board(colour_bits=8, with_edge_map=1) as board:
        shown = watched(board)
        quadshade.render("cube:2", port=board, size=SIZE, pack_error=0, edges="profile")
    plain = quadshade.render("cube:2", size=SIZE, engine="model").array
    covered = (plain != 0).any(axis=2)
    assert len(shown) == 2
    assert np.array_equal(shown[1][covered], plain[covered])


@pytest.mark.parametrize("colour_bits", [8, 5, 4])
def test_what_is_read_is_the_dithered_picture(colour_bits: int) -> None:
    with a_board(colour_bits=colour_bits) as board:
        assert board.colour_bits == colour_bits
        picture = quadshade.render("sphere:168", port=board, size=SIZE, pack_error=0)
    plain = quadshade.render("sphere:168", size=SIZE, engine="model").array
    expected = kept(plain, colour_bits)
    covered = (plain != 0).any(axis=2)
    assert np.array_equal(picture.array[covered], expected[covered])
    assert (f"{colour_bits} bits a colour" in picture.summary) == (colour_bits < 8)


@pytest.mark.parametrize("buffers", [1, 2])
def test_the_simulated_boards_monitor(buffers: int, tmp_path: Path) -> None:
    """The file has what the board shows; with one buffer the part of a picture that has come, too."""
    pictures: list[np.ndarray] = []
    settings = board_settings(None, SIZE, {"buffers": buffers})
    engine = start_engine("model", settings, pictures.append)
    board = engine.board
    session = Session(MemoryTransport(lambda data: engine.feed(data) or engine.take()))
    session.connect()
    session.clear(0xFF)
    session.clear(0xFF00)
    session.flush()
    assert [picture[0, 0].tolist() for picture in pictures] == [[0, 0, 0], [255, 0, 0], [0, 255, 0]][
        : 1 if buffers == 2 else None
    ]
    if buffers == 2:
        session.swap()
        assert len(pictures) == 2
    assert (pictures[-1] == (0, 255, 0)).all()
    assert board.drawing.shown.any() == (buffers == 2)
    with pytest.raises(QuadshadeError, match="the engine ghdl shows no monitor; use --engine model"):
        start_engine("ghdl", settings, pictures.append)
    for name, said in (("none/a.png", "make it first"), ("a.jpg", "ends in .png")):
        result = CliRunner().invoke(main, ["board", "--engine", "model", "--monitor", str(tmp_path / name)])
        assert result.exit_code == 2 and len(result.output.splitlines()) == 1 and said in result.output
    twice = str(tmp_path / "a.png")
    result = CliRunner().invoke(main, ["board", "--engine", "model", "--monitor", twice, "--pty", twice])
    assert result.exit_code == 2 and "--pty and --monitor are both" in result.output
    assert not list(tmp_path.iterdir())


def test_the_command_line_sets_a_simulated_boards_generics(tmp_path: Path) -> None:
    generics = [argument for name, value in GENERICS.items() for argument in ("--generic", f"{name}={value}")]
    scene = ("cube:2", "--size", "48x32", *generics)
    board = ("--port", "sim", "--engine", "model", "--pack-error", "0")
    result = CliRunner().invoke(main, ["render", *scene, *board, "-o", str(tmp_path / "a.png")])
    assert result.exit_code == 0 and "4 bits a colour, dithered" in result.output
    plain = quadshade.render("cube:2", size=SIZE, engine="model").array
    covered = (plain != 0).any(axis=2)
    assert np.array_equal(read_picture(tmp_path / "a.png")[covered], kept(plain, 4)[covered])
    result = CliRunner().invoke(main, ["render", *scene, "-o", str(tmp_path / "b.png")])
    assert result.exit_code == 2 and "the core has no generic 'buffers'" in result.output
    assert not (tmp_path / "b.png").exists()


@pytest.mark.parametrize("engine", ["verilator", "ghdl"])
def test_the_netlist_and_the_vhdl_swap(engine: str) -> None:
    size = (8, 6)
    settings = board_settings(None, size, GENERICS)
    with Board("sim", settings=settings, engine=engine, notice=str) as board:
        for scene in ("sphere:2x3", "cube:1"):
            # Both compare what is read, and its CRC, with the golden model.
            assert quadshade.render(scene, port=board, size=size).array.any()


def test_a_picture_is_read_before_it_is_shown() -> None:
    with a_board() as board:
        board.clear((255, 0, 0))
        board.show()
        # Once is enough.
        board.show()
        for action in (board.read, board.verify, lambda: board.send(np.zeros(1, np.uint32))):
            with pytest.raises(QuadshadeError, match=r"read it before show\(\)"):
                action()
        board.clear((0, 255, 0))
        assert (board.read() == (0, 255, 0)).all()
        assert (board.simulated.engine.board.drawing.shown == (255, 0, 0)).all()


@pytest.mark.parametrize("name", ["ulx3s-12f-double", "icepi-zero-sdram"])
def test_what_is_shown_stays_whole_whatever_the_line_does(name: str, seed: int) -> None:
    """A cable pulled amid a picture, SWAP out of its order and amid a packet, noise: all are refused."""
    settings = board_settings(name, None, {})
    board = BoardModel(
        settings.screen_width,
        settings.screen_height,
        settings.formats,
        buffers=2,
        colour_bits=settings.colour_bits,
    )
    rng = np.random.default_rng(seed)
    mesh, formats = load_scene("cube:2"), settings.formats
    triangles = sample(project(mesh, fit_camera(mesh), *SIZE, formats), "quadratic", formats=formats)
    words = pack_primitives(setup_triangles(triangles, formats), formats).words
    session = Session(MemoryTransport(board.feed))
    session.connect()
    session.clear(0xFF00)
    session.swap()
    session.flush()
    shown = board.drawing.shown.copy()
    assert (shown == (0, 255, 0)).all()
    session.clear(0xFF)
    session.triangles(words[: len(words) // 2])
    session.flush()
    number = board.receiver.expected
    swap = enclosed(body_of(Opcode.SWAP, number + 3, b""))
    rest = enclosed(body_of(Opcode.TRIANGLES, number, words[len(words) // 2 :].astype("<u4").tobytes()[:400]))
    for sent in (rest[: len(rest) // 2], swap, rng.bytes(300), bytes(1), swap):
        board.feed(sent)
        assert np.array_equal(board.drawing.shown, shown)
    # The host is there again, and its picture is the next one that is shown.
    session = Session(MemoryTransport(board.feed))
    session.connect()
    assert np.array_equal(board.drawing.shown, shown)
    session.clear(0xFF0000)
    session.flush()
    assert np.array_equal(board.drawing.shown, shown)
    session.swap()
    assert (board.drawing.shown == (0, 0, 255)).all()


def test_a_board_with_one_buffer_shows_what_it_draws() -> None:
    with a_board(buffers=1) as board:
        board.clear((255, 0, 0))
        board.show()
        assert (board.read() == (255, 0, 0)).all()


def test_a_board_that_was_reset_shows_the_picture_again() -> None:
    """Wherever a board was reset, the picture is drawn anew, and shown."""
    with a_board() as board:
        model = board.simulated.engine.board
        for scene in ("cube:2", "sphere:168"):
            picture = quadshade.render(scene, port=board, size=SIZE, pack_error=0)
            assert np.array_equal(model.drawing.shown, picture.array)
            model._begin()
            model.session = 0
        assert board.statistics["redraws"] > 0


def test_one_buffer_refuses_to_swap() -> None:
    session = Session(MemoryTransport(BoardModel(8, 6).feed))
    session.connect()
    with pytest.raises(LinkError, match="unknown opcode"):
        session.swap()


@pytest.mark.parametrize(
    ("generics", "message"),
    [
        ({"buffers": 3}, "buffers is 3; give 1 or 2"),
        ({"colour_bits": 7}, "colour_bits is 7; give 8 or 6 or 5 or 4"),
        ({"single_port_memory": 1, "with_depth": 0, "buffers": 2}, "give buffers=1"),
        (SDRAM | {"buffers": 1}, "with one buffer"),
        (SDRAM | {"with_edge_map": 1}, "give buffers=2, with_edge_map=0"),
        (SDRAM | {"colour_bits": 6}, "17 bits of colours and 15 of depth"),
        (SDRAM | {"depth_bits": 16}, "16 bits of colours and 16 of depth"),
        (SDRAM | {"with_depth": 0}, "16 bits of colours and 0 of depth"),
        (SDRAM | {"screen_width": 160}, "160 pixels wide; give a multiple of 64, from 128 on"),
        (SDRAM | {"screen_width": 64}, "64 pixels wide"),
        (SDRAM | {"screen_width": 1088, "sdram_row_bits": 11, "sdram_column_bits": 8}, "three planes of"),
        (SDRAM | {"sdram_row_bits": 14}, "sdram_row_bits is 14; give 11 to 13"),
        (SDRAM | {"sdram_refresh_clocks": 99}, "sdram_refresh_clocks is 99; give 100 to 4095"),
    ],
    ids=str,
)
def test_a_picture_memory_that_there_is(generics: dict[str, int], message: str) -> None:
    with pytest.raises(QuadshadeError) as error:
        board_settings(None, None, generics)
    assert message in str(error.value)


def bayer(order: int) -> np.ndarray:
    """Bayer's matrix of 2**order rows, by its recursion."""
    if order == 0:
        return np.zeros((1, 1), int)
    smaller = 4 * bayer(order - 1)
    return np.block([[smaller, smaller + 2], [smaller + 3, smaller + 1]])


def test_thresholds_are_bayers() -> None:
    y, x = np.indices((8, 8))
    assert np.array_equal(thresholds(x, y), np.tile(bayer(2), (2, 2)))


@pytest.mark.parametrize("colour_bits", [6, 5, 4])
def test_dithering_keeps_the_mean_and_flat_colours(colour_bits: int) -> None:
    y, x = np.indices((4, 4))
    values = np.broadcast_to(np.arange(256)[:, None, None, None], (256, 4, 4, 3))
    there = kept_colours(values, thresholds(x, y), colour_bits)
    for channel, bits in enumerate((colour_bits, {6: 5, 5: 6, 4: 4}[colour_bits], colour_bits)):
        # What n bits can show: they themselves, and again below, to eight.
        levels = np.array([int((3 * f"{level:0{bits}b}")[:8], 2) for level in range(1 << bits)])
        assert set(np.unique(there[..., channel])) == set(levels)
        assert (there[levels, :, :, channel] == levels[:, None, None]).all()
        assert abs(there[..., channel].mean(axis=(1, 2)) - np.arange(256)).max() <= 1
        assert (np.diff(there[..., channel], axis=0) >= 0).all()
        one = kept_colours(values[:, 0, 0], HALF_STEP, colour_bits)[:, channel]
        assert set(np.unique(one)) == set(levels)


def test_a_board_with_sdram_is_one_of_640_by_480() -> None:
    settings = board_settings("ulx3s-85f-sdram", None, {})
    assert SDRAM.items() <= settings.generics().items() and settings.with_video == 1
    board = BoardModel(640, 480, settings.formats, buffers=2, colour_bits=5)
    assert (colour_bits_of(board.identity), plane_bytes(board.identity)) == (5, (3, 2, 0, 0))
