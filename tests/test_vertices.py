# SPDX-License-Identifier: Apache-2.0
"""Packets that carry vertices: what is unpacked, edges bit for bit, what it costs, how few bytes it is."""

from __future__ import annotations

import zlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from quadshade.board.board import Board
from quadshade.board.pool import BoardPool
from quadshade.board.settings import BoardSettings
from quadshade.board.tiled_screen import TiledScreen
from quadshade.choices import PACK_ERROR
from quadshade.cli.main import main
from quadshade.contract.formats import Formats
from quadshade.contract.triangles import ScreenTriangles
from quadshade.errors import QuadshadeError
from quadshade.golden.board import BoardModel
from quadshade.golden.compiled import draw_fast
from quadshade.golden.link.vertex_unpacker import VertexUnpacker
from quadshade.golden.screen.plane_reader import COLOUR
from quadshade.golden.screen.screen import Screen
from quadshade.link.session import Session
from quadshade.link.transport import MemoryTransport
from quadshade.packing.frame_file import (
    decode_frame_file,
    encode_frame_file,
    line_bytes,
    pack_frame,
    read_frame_file,
)
from quadshade.packing.neighbours import ordered_for_vertices
from quadshade.packing.pack import pack_primitives
from quadshade.packing.pack_vertices import as_run, choose_vertices, pack_vertices, unpack_vertices
from quadshade.scene import load_scene, parse_camera, project
from quadshade.setup.packet import Primitives, pack
from quadshade.setup.triangle_setup import setup_triangles
from quadshade.shading import sample

FORMATS = [
    Formats(),
    Formats(num_channels=1, with_depth=0, word_width=24, frac_bits=14, coord_bits=9),
    Formats(num_channels=4, max_order=1, subpixel_bits=5, coord_bits=10, depth_bits=12),
]


def run(*arguments: object) -> tuple[int, str]:
    """Exit code and output of the command."""
    result = CliRunner().invoke(main, [str(argument) for argument in arguments])
    return result.exit_code, result.output


def random_triangles(formats: Formats, count: int, seed: int) -> ScreenTriangles:
    """Triangles of four sizes, of all orders, neighbours now and then; slivers, flat ones, some cut off."""
    rng = np.random.default_rng(seed)
    size, pixel = 200, 1 << formats.subpixel_bits
    middle = rng.uniform(-10, size + 10, (count, 1, 2))
    vertices = middle + rng.uniform(-1, 1, (count, 3, 2)) * rng.choice([0.7, 3.0, 20.0, 150.0], (count, 1, 1))
    vertices = np.rint(vertices * pixel).astype(np.int64)
    # Slivers; edges along a scanline; the edge of the one before; columns of pixel centres.
    vertices[::7, 2] = (vertices[::7, 0] + vertices[::7, 1]) // 2 + 1
    vertices[1::7, 1, 1] = vertices[1::7, 0, 1]
    vertices[2::7, :2] = vertices[1::7, 1:][: len(vertices[2::7])]
    vertices[3::7] = vertices[3::7] // pixel * pixel + pixel // 2
    shape, top = (count, formats.num_channels), 2.0**formats.value_bits - 1
    samples = rng.uniform(0, top, (*shape, 1)) + rng.uniform(-1, 1, (*shape, 6)) * top / 8
    samples[2::7, :, :2] = samples[1::7, :, 1:3][: len(samples[2::7])]
    depth = rng.uniform(0, 2.0**formats.depth_bits - 1, (count, 3))
    depth[2::7, :2] = depth[1::7, 1:][: len(depth[2::7])]
    return ScreenTriangles(
        size,
        size,
        vertices,
        np.clip(samples, 0, top),
        rng.integers(0, formats.max_order + 1, shape),
        depth if formats.with_depth else None,
        tuple(f"c{index}" for index in range(formats.num_channels)),
    )


def scene(name: str, shading: str, size: int = 320) -> tuple[Primitives, ScreenTriangles]:
    """A scene's primitives, and the triangles that they are set up from."""
    mesh = load_scene(name)
    projected = project(mesh, parse_camera("from=0,0,1", mesh), size, size * 3 // 4)
    triangles = sample(projected, shading)
    return setup_triangles(triangles, Formats(), limit=0.5), triangles


@pytest.mark.parametrize("error", [PACK_ERROR, 1 / 4])
@pytest.mark.parametrize("formats", FORMATS, ids=range(len(FORMATS)))
def test_what_is_unpacked_is_what_is_drawn(formats: Formats, error: float, seed: int) -> None:
    triangles = random_triangles(formats, 150, seed)
    primitives = setup_triangles(triangles, formats)
    batch = pack_vertices(primitives, triangles, formats, error)
    expected = pack(batch.primitives, formats)
    assert batch.vertices and np.array_equal(unpack_vertices(batch.words, formats), expected)
    # Words come in any pieces; another batch may follow, and a board that knew others before.
    unpacker = VertexUnpacker(formats)
    unpacker.memory[:] = np.random.default_rng(seed).integers(-(1 << 49), 1 << 49, len(unpacker.memory))
    both = np.concatenate([batch.words, batch.words])
    cuts = np.sort(np.random.default_rng(seed).integers(0, len(both), 40))
    parts = [unpacker.feed(part) for part in np.split(both, cuts)]
    assert np.array_equal(np.concatenate(parts), np.concatenate([expected, expected]))
    assert not unpacker.within


@pytest.mark.parametrize("formats", FORMATS, ids=range(len(FORMATS)))
def test_edges_are_the_hosts_in_every_bit(formats: Formats, seed: int) -> None:
    triangles = random_triangles(formats, 150, seed)
    primitives = setup_triangles(triangles, formats)
    batch = choose_vertices(primitives, triangles, formats, 1 / 4)
    assert batch is not None
    sent = batch.sent
    alone = np.bincount(primitives.triangle, minlength=len(triangles))[primitives.triangle] == 1
    assert 0.5 < np.count_nonzero(sent) / np.count_nonzero(alone) and not sent[~alone].any()
    # Mirrored ones, ones with two edges on a side, ones without.
    for name in ("mirror", "has_second"):
        assert set(primitives.header[name][sent]) == {0, 1}
    words = pack(batch.primitives, formats)
    drawn = draw_fast(words, formats)
    exact = draw_fast(pack(primitives, formats), formats)
    assert np.array_equal(drawn.x, exact.x) and np.array_equal(drawn.y, exact.y)


def test_errors_added_are_bounded(seed: int) -> None:
    formats, error = Formats(), 1 / 8
    triangles = random_triangles(formats, 200, seed)
    primitives = setup_triangles(triangles, formats)
    batch = pack_vertices(primitives, triangles, formats, error)
    fine = replace(formats, value_bits=18, frac_bits=12)
    before, after = draw_fast(pack(primitives, fine), fine), draw_fast(pack(batch.primitives, fine), fine)
    off = np.abs(before.value[:, :3] - after.value[:, :3]).max() / 2.0**10
    assert 0.05 * error < off <= batch.added + 2.0**-10
    assert batch.added <= error
    assert np.abs(before.value[:, 3] - after.value[:, 3]).max() <= 1


@pytest.mark.parametrize(
    "name, shading, most",
    [("sphere:690", "quadratic", 21), ("sphere:690", "gouraud", 12), ("torus:288", "quadratic", 24)],
)
def test_bytes_on_the_line(name: str, shading: str, most: float) -> None:
    primitives, triangles = scene(name, shading)
    words = pack_vertices(primitives, triangles, Formats()).words
    drawn = len(np.unique(primitives.triangle))
    assert line_bytes(words) <= most * drawn
    assert line_bytes(words) < line_bytes(pack_primitives(primitives, Formats()).words) / 3


def test_triangles_are_sent_from_neighbour_to_neighbour(seed: int) -> None:
    """What was shuffled takes little more than the strips that it was; strips, and what is painted, stay."""
    formats = Formats()
    _, strips = scene("torus:288", "gouraud")
    shuffled = strips.ordered(np.random.default_rng(seed).permutation(len(strips)))

    def size(triangles: ScreenTriangles) -> int:
        return line_bytes(pack_vertices(setup_triangles(triangles, formats), triangles, formats).words)

    again = ordered_for_vertices(shuffled, formats)
    assert sorted(map(bytes, again.vertices)) == sorted(map(bytes, strips.vertices))
    assert size(again) < 1.2 * size(strips) < size(shuffled) / 1.5
    painted = replace(shuffled, depth=None)
    for kept in (strips, painted, strips.ordered(np.arange(1)), strips.ordered(np.arange(0))):
        assert np.array_equal(ordered_for_vertices(kept, formats).vertices, kept.vertices)
    # An edge of many triangles, the same one again and again, and single points.
    same = strips.ordered(np.zeros(40, int))
    points = replace(same, vertices=np.zeros_like(same.vertices))
    for many in (same, points):
        assert len(ordered_for_vertices(many, formats)) == 40


@pytest.mark.parametrize(
    ("index", "recorded"), [(0, (796, 589123958)), (1, (368, 2597760338)), (2, (661, 610946253))]
)
def test_words_are_those_recorded(index: int, recorded: tuple[int, int]) -> None:
    """
    Another choice of what is named and what is sent shows here, though the same is drawn of it.

    Beside neighbours there are corners that come again, all of them or their places alone, from nearer and
    farther than a table reaches.
    """
    formats = FORMATS[index]
    triangles = random_triangles(formats, 112, 3)
    for first, again in ((4, 1), (5, 2)):
        triangles.vertices[first::7] = triangles.vertices[again::7]
        if triangles.depth is not None:
            triangles.depth[first::7] = triangles.depth[again::7]
    triangles.samples[5::7] = triangles.samples[2::7]
    triangles.vertices[-14:], triangles.samples[-14:] = triangles.vertices[:14], triangles.samples[:14]
    words = pack_vertices(setup_triangles(triangles, formats), triangles, formats).words
    assert (len(words), zlib.crc32(words.astype("<u4").tobytes())) == recorded


def test_the_order_is_that_recorded() -> None:
    """Of a shuffled sphere, beside which corners lie that are one sub-pixel away."""
    _, strips = scene("sphere:168", "gouraud", 96)
    shuffled = strips.ordered(np.random.default_rng(1).permutation(len(strips)))
    beside = replace(shuffled, vertices=shuffled.vertices + np.array([0, 1]))
    order = ordered_for_vertices(shuffled.followed_by([beside]), Formats()).vertices
    assert zlib.crc32(order.astype("<i8").tobytes()) == 845374981


def test_what_cannot_go_as_vertices_goes_as_packed_words(seed: int) -> None:
    formats = Formats()
    triangles = random_triangles(formats, 40, seed)
    primitives = setup_triangles(triangles, formats)
    exact = pack_vertices(primitives, triangles, formats, 0.0)
    assert np.array_equal(exact.words, as_run(pack_primitives(primitives, formats, 0.0).words))
    nothing = setup_triangles(random_triangles(formats, 0, 1), formats)
    assert len(pack_vertices(nothing, random_triangles(formats, 0, 1), formats).words) == 0
    with pytest.raises(QuadshadeError, match="with_shade is 1"):
        VertexUnpacker(Formats(num_channels=2, with_shade=1))


def test_every_packet_ends_whatever_its_bits(seed: int) -> None:
    formats, rng = Formats(), np.random.default_rng(seed)
    for mask in (0xFFFFFFFF, 0x11111111, 0xF0F0F0F0, 0):
        unpacker = VertexUnpacker(formats)
        words = rng.integers(0, 1 << 32, 300, dtype=np.uint64).astype(np.uint32) & np.uint32(mask)
        given = unpacker.feed(words)
        assert len(given) == 0 if mask == 0 else True
    # A packet that is cut, finished by zeros.
    triangles = random_triangles(formats, 20, seed)
    words = pack_vertices(setup_triangles(triangles, formats), triangles, formats).words
    unpacker = VertexUnpacker(formats)
    unpacker.feed(words[: len(words) // 2])
    unpacker.feed(np.zeros(64, np.uint32))
    assert not unpacker.within


def test_a_file_says_which_words_it_has() -> None:
    _, triangles = scene("sphere:168", "quadratic", 96)
    frame, batch = pack_frame(triangles, Formats(), vertices=True)
    again = decode_frame_file(encode_frame_file(frame))
    assert again.vertices and np.array_equal(again.words, batch.words)
    plain, _ = pack_frame(triangles, Formats())
    assert not plain.vertices and len(plain.words) > 3 * len(frame.words)


@pytest.fixture(scope="module")
def packed_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What ``quadshade pack --vertices`` writes."""
    path = tmp_path_factory.mktemp("vertices") / "x.qs"
    assert run("pack", "sphere:24", "--size", "64x48", "--vertices", "-o", path)[0] == 0
    return path


def test_pack_and_dump_of_vertices(packed_file: Path) -> None:
    frame = read_frame_file(packed_file)
    assert frame.vertices
    code, said = run("dump", packed_file)
    assert code == 0 and said.count("\npacket ") == frame.packets
    # Drawn by the golden model, the picture is the one that the file's CRC is of.
    pixels = draw_fast(frame.set_up_words(), frame.formats)
    screen = Screen(64, 48, 3, frame.formats.depth_bits)
    screen.clear(frame.clear_colour)
    screen.draw(pixels.x, pixels.y, pixels.value[:, :3], pixels.value[:, 3])
    assert screen.frame_crc(COLOUR) == frame.crc


def test_boards_that_take_vertices_replay_them(packed_file: Path) -> None:
    code, said = run("replay", packed_file, "--port", "sim", "--engine", "model")
    assert code == 0, said
    frame = read_frame_file(packed_file)
    plain, _ = pack_frame(scene("sphere:24", "quadratic", 64)[1], Formats())
    for takes in (False, True):
        board = BoardModel(64, 48, frame.formats, with_vertices=takes)
        session = Session(MemoryTransport(board.feed))
        session.connect()
        plain.send(session)
        assert session.frame_crc() == plain.crc
        if takes:
            frame.send(session)
            assert session.frame_crc() == frame.crc
        else:
            with pytest.raises(QuadshadeError, match="does not take"):
                frame.send(session)


def test_tiles_of_vertices_are_packed_anew(packed_file: Path) -> None:
    settings = BoardSettings(screen_width=40, screen_height=30)
    with Board("sim", engine="model", settings=settings) as board:
        screen = TiledScreen(BoardPool([board], print), 64, 48, print)
        screen.replay(read_frame_file(packed_file))


def test_vertices_of_a_shade_unit_are_refused_in_a_line(tmp_path: Path) -> None:
    scene = ("sphere:24", "--size", "64x48", "--shading", "quadratic-specular")
    code, said = run("pack", *scene, "--vertices", "-o", tmp_path / "x.qs")
    assert (code, said.count("\n")) == (2, 1)
    assert "with_shade is 1" in said and not (tmp_path / "x.qs").exists()


def test_a_board_with_vertices_draws_the_same_picture_in_fewer_bytes() -> None:
    _, triangles = scene("sphere:168", "quadratic", 96)
    frame, _ = pack_frame(triangles, Formats(), vertices=True)
    plain, _ = pack_frame(triangles, Formats())
    sent, pictures = [], []
    for with_vertices in (0, 1):
        settings = BoardSettings(screen_width=96, screen_height=72, with_vertices=with_vertices)
        with Board("sim", engine="model", settings=settings) as board:
            board.draw(triangles)
            pictures.append(board.read())
            sent.append(board.statistics["bytes_sent"])
            board.replay(plain)
            if with_vertices:
                board.replay(frame)
            else:
                with pytest.raises(QuadshadeError, match="does not take"):
                    board.replay(frame)
    assert sent[1] < sent[0] / 2
    assert np.abs(pictures[0].astype(int) - pictures[1]).max() <= 1
