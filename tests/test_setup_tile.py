# SPDX-License-Identifier: Apache-2.0
"""Primitives cut to rectangles draw the whole picture's pixels bit for bit, on cores of other formats too."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from quadshade.contract.formats import Formats
from quadshade.contract.triangles import ScreenTriangles
from quadshade.errors import QuadshadeError
from quadshade.golden.compiled import draw_fast
from quadshade.golden.core.raster_core import draw_scalar
from quadshade.golden.screen.screen import Screen
from quadshade.setup.coverage import mesh_rows, pixels_of
from quadshade.setup.edges import cut_triangles
from quadshade.setup.packet import Primitives, pack
from quadshade.setup.refit import picture_formats, refit, why_unfit
from quadshade.setup.short_edges import short_edges
from quadshade.setup.tile import Cuttable, Rectangle
from quadshade.setup.triangle_setup import has_constant_depth, setup_triangles
from tests.support.golden_stimuli import triangles_of

ICEBREAKER = Formats(
    num_channels=1, with_depth=0, depth_bits=1, word_width=19, frac_bits=9, subpixel_bits=4, coord_bits=9
)
FORMATS = {
    "colours": Formats(),
    "icebreaker": ICEBREAKER,
    "linear": Formats(max_order=1, subpixel_bits=0, coord_bits=9),
    "wide": Formats(word_width=60, frac_bits=44, num_channels=1, stream_width=128),
}
SIZE = 150


def pixel_rows(primitives: Primitives, formats: Formats, left: int = 0, top: int = 0) -> np.ndarray:
    """(n, 3 + c) triangle, y, x and values of every pixel, sorted."""
    emitted = draw_fast(pack(primitives, formats), formats)
    place = (primitives.triangle[emitted.packet], emitted.y + top, emitted.x + left)
    return in_order(np.column_stack([*place, emitted.value]).astype(np.int64))


def in_order(rows: np.ndarray) -> np.ndarray:
    """Rows of :func:`pixel_rows`, sorted by triangle, y and x."""
    return rows[np.lexsort((rows[:, 2], rows[:, 1], rows[:, 0]))]


def tiles_of(width: int, height: int, across: int, down: int) -> list[Rectangle]:
    """A picture in tiles of some size, those at its right and bottom smaller."""
    return [
        Rectangle(left, top, min(across, width - left), min(down, height - top))
        for top in range(0, height, down)
        for left in range(0, width, across)
    ]


def whole(formats: Formats, seed: int, fractional: bool = False) -> tuple[ScreenTriangles, Primitives]:
    """Triangles of every awkward kind, some divided, and their primitives."""
    triangles = triangles_of(formats, np.random.default_rng(seed), 84, SIZE)
    return triangles, setup_triangles(triangles, formats, limit=0.5, fractional=fractional)


@pytest.mark.parametrize("fractional", (False, True))
@pytest.mark.parametrize("size", ((67, 53), (11, SIZE), (SIZE, 7)), ids=str)
@pytest.mark.parametrize("name", FORMATS)
def test_tiles_have_the_pixels_of_the_whole(name: str, size: tuple[int, int], fractional: bool) -> None:
    formats = FORMATS[name]
    triangles, primitives = whole(formats, seed=len(name), fractional=fractional)
    cuttable = Cuttable(primitives, formats)
    parts = [np.zeros((0, 3 + formats.carried_channels), np.int64)]
    for tile in tiles_of(triangles.width, triangles.height, *size):
        part = cuttable.to(tile)
        rows = pixel_rows(part, formats, tile.left, tile.top)
        inside = (rows[:, 1] >= tile.top) & (rows[:, 1] < tile.bottom)
        assert (inside & (rows[:, 2] >= tile.left) & (rows[:, 2] < tile.right)).all()
        parts.append(rows)
    assert np.array_equal(in_order(np.concatenate(parts)), pixel_rows(primitives, formats))


@pytest.mark.parametrize("fractional", (False, True))
@pytest.mark.parametrize("name", FORMATS)
def test_cores_that_share_scanlines_have_the_pixels_of_the_whole(name: str, fractional: bool) -> None:
    formats = FORMATS[name]
    triangles, primitives = whole(formats, seed=7, fractional=fractional)
    cuttable, expected = Cuttable(primitives, formats), pixel_rows(primitives, formats)
    for cores in (1, 2, 3, 5):
        parts = []
        for core in range(cores):
            part = cuttable.interleaved(cores, core, triangles.width, triangles.height)
            part = replace(part, edges=short_edges(part, 1 << 12))
            rows = pixel_rows(part, formats)
            rows[:, 1] = cores * rows[:, 1] + core
            parts.append(rows)
        assert np.array_equal(in_order(np.concatenate(parts)), expected), cores


def test_every_seam_of_one_triangle() -> None:
    """Cut between any two columns and any two scanlines, mirrored and not; drawn by the scalar model."""
    formats = Formats(num_channels=1, with_depth=0)
    corners = np.array([[1, 2], [25, 9], [7, 21]]) << 8
    samples = np.array([[[3.0, 250, 90, 140, 30, 200]]])
    for vertices in (corners, [26 << 8, 0] - corners * [1, -1]):
        triangles = ScreenTriangles(
            26, 22, vertices[None].astype(np.int64), samples, np.full((1, 1), 2), None, ("grey",)
        )
        primitives = setup_triangles(triangles, formats)
        cuttable, expected = Cuttable(primitives, formats), pixel_rows(primitives, formats)
        assert len(expected) > 200
        for cut in range(1, 26):
            left, right = Rectangle(0, 0, cut, 22), Rectangle(cut, 0, 26 - cut, 22)
            above, below = Rectangle(0, 0, 26, cut), Rectangle(0, cut, 26, 22 - cut)
            for halves in ((left, right), (above, below))[: 1 if cut >= 22 else 2]:
                rows = [scalar_rows(cuttable.to(half), formats, half) for half in halves]
                assert np.array_equal(in_order(np.concatenate(rows)), expected), (cut, halves)


def scalar_rows(primitives: Primitives, formats: Formats, tile: Rectangle) -> np.ndarray:
    """As :func:`pixel_rows`, by the model that takes a pixel at a time."""
    rows = [
        (primitives.triangle[pixel.packet], pixel.y + tile.top, pixel.x + tile.left, *pixel.value)
        for pixel in draw_scalar(pack(primitives, formats).tolist(), formats)
    ]
    return np.array(rows, np.int64).reshape(-1, 3 + formats.carried_channels)


def test_what_is_whole_keeps_its_words_and_tiny_parts_have_few() -> None:
    formats = FORMATS["colours"]
    _, primitives = whole(formats, 1)
    cuttable = Cuttable(primitives, formats)
    everything = cuttable.to(Rectangle(0, 0, SIZE, SIZE))
    # But for those that no pixel needs.
    same = everything.words == primitives.words
    assert (same | (everything.words == 0)).all() and same.mean() > 0.95
    tiny = cuttable.to(Rectangle(70, 70, 1, 1))
    assert len(tiny) and (tiny.orders == 0).all()


def test_where_pixels_may_be() -> None:
    formats = FORMATS["colours"]
    _, primitives = whole(formats, 2)
    cuttable = Cuttable(primitives, formats)
    rows = pixel_rows(primitives, formats)
    for tile in tiles_of(SIZE, SIZE - 1, 31, 17):
        bounds = cuttable.bounds(tile)
        on = (rows[:, 1] >= tile.top) & (rows[:, 1] < tile.bottom)
        on &= (rows[:, 2] >= tile.left) & (rows[:, 2] < tile.right)
        if on.any():
            assert bounds is not None
            assert bounds.left <= rows[on, 2].min() and bounds.right > rows[on, 2].max()
            assert bounds.top <= rows[on, 1].min() and bounds.bottom > rows[on, 1].max()
            assert bounds.left >= tile.left and bounds.bottom <= tile.bottom
    assert Cuttable(primitives, formats).bounds(Rectangle(SIZE, 0, 10, 10)) is None


def shown(words: np.ndarray, formats: Formats, size: tuple[int, int]) -> np.ndarray:
    """(h, w, c) uint8 picture of set-up words through z-buffer and framebuffer."""
    pixels = draw_fast(words, formats)
    screen = Screen(*size, formats.emitted_channels, formats.depth_bits if formats.with_depth else None)
    depth = pixels.value[:, formats.num_channels] if formats.with_depth else None
    screen.draw(pixels.x, pixels.y, pixels.value[:, : formats.num_channels], depth)
    return screen.colour


@pytest.mark.parametrize(
    "boards",
    (
        (Formats(), Formats(word_width=40, frac_bits=30, coord_bits=6, subpixel_bits=3)),
        (Formats(), ICEBREAKER),
        (ICEBREAKER, Formats(num_channels=4)),
        (Formats(), Formats(num_channels=4, span_depth=5)),
    ),
    ids=("bits", "grey", "four", "channels"),
)
def test_boards_of_other_formats_show_the_same(boards: tuple[Formats, ...]) -> None:
    """Whatever of two boards draws a tile: pixels in their order and their depths decide the same."""
    formats = picture_formats(boards, SIZE, SIZE - 1)
    _, primitives = whole(formats, seed=5)
    cuttable = Cuttable(primitives, formats)
    expected = shown(pack(primitives, formats), formats, (SIZE, SIZE - 1))
    assert len(np.unique(expected)) > 100
    for board in boards:
        assert why_unfit(formats, board) == ""
        for tile in tiles_of(SIZE, SIZE - 1, 60, 50):
            part = refit(cuttable.to(tile), formats, board)
            got = shown(pack(part, board), board, (tile.width, tile.height))
            wanted = expected[tile.top : tile.bottom, tile.left : tile.right]
            assert np.array_equal(got[..., : wanted.shape[2]], wanted)
            if formats.num_channels == 1 and board.num_channels > 1:
                assert (got[..., :3] == wanted).all()


def few(formats: Formats, count: int = 14, size: int = 24) -> Primitives:
    """Some triangles of a small picture."""
    triangles = triangles_of(formats, np.random.default_rng(3), count, size)
    return setup_triangles(triangles, formats, limit=0.5)


@pytest.mark.parametrize(
    "board", (ICEBREAKER, Formats(with_depth=0), Formats(num_channels=4)), ids=("grey", "flat", "four")
)
def test_few_triangles_of_a_grey_picture_on_another_board(board: Formats) -> None:
    picture = picture_formats([ICEBREAKER, board], 24, 24)
    primitives = few(picture)
    part = refit(primitives, picture, board)
    turned = board.with_depth and not picture.with_depth
    rows = pixel_rows(part, board)
    colours = 3 if board.num_channels >= 3 else 1
    assert np.array_equal(rows[:, :4], pixel_rows(primitives, picture)) and len(rows) > 100
    assert (rows[:, 3 : 3 + colours] == rows[:, 3:4]).all() and not rows[:, 3 + colours :].any()
    assert np.array_equal(part.triangle[::-1] if turned else part.triangle, primitives.triangle)


@pytest.mark.parametrize("name", ("colours", "icebreaker"))
def test_scanlines_of_few_triangles_by_two_cores(name: str) -> None:
    primitives = few(FORMATS[name])
    parts = []
    for core in range(2):
        rows = pixel_rows(Cuttable(primitives, FORMATS[name]).interleaved(2, core, 24, 24), FORMATS[name])
        rows[:, 1] = 2 * rows[:, 1] + core
        parts.append(rows)
    assert np.array_equal(in_order(np.concatenate(parts)), pixel_rows(primitives, FORMATS[name]))


def test_pixels_of_triangles_are_those_that_are_drawn() -> None:
    formats = FORMATS["colours"]
    triangles = triangles_of(formats, np.random.default_rng(3), 14, 24)
    cut = cut_triangles(triangles.vertices, triangles.width, triangles.height, formats.subpixel_bits)
    triangle, x, y = pixels_of(mesh_rows(cut, len(triangles)))
    drawn = pixel_rows(setup_triangles(triangles, formats), formats)
    assert np.array_equal(in_order(np.column_stack([triangle, y, x])), drawn[:, :3])


def test_constant_depth_saves_words_where_it_is_alone_in_its_words() -> None:
    depth = np.array([[5.0, 5.0, 5.0], [5.0, 5.0, 6.0]])
    assert has_constant_depth(depth, Formats()).tolist() == [True, False]
    assert has_constant_depth(depth, Formats(stream_width=128)).tolist() == [False, False]


@pytest.mark.parametrize(
    ("board", "reason"),
    (
        (Formats(with_shade=1, num_channels=2), "its with_shade is 1, the picture's 0"),
        (Formats(num_channels=2), "it has 2 channels, the picture 3"),
        (Formats(max_order=1), "its max_order is 1, the picture's 2"),
        (Formats(frac_bits=20), "its words have 32 bits, 20 of them fraction, the picture's 32 and 22"),
        (Formats(word_width=36), "its words have 36 bits, 22 of them fraction, the picture's 32 and 22"),
        (Formats(with_depth=0), "it has no depth, the picture 16 bits"),
        (Formats(depth_bits=12), "it has 12 bits of depth, the picture 16 bits"),
    ),
)
def test_a_board_that_is_not_fit_says_why(board: Formats, reason: str) -> None:
    assert why_unfit(Formats(), board) == reason


def test_sizes_that_no_core_addresses() -> None:
    assert picture_formats([ICEBREAKER], 1920, 1080).coord_bits == 11
    assert picture_formats([Formats(coord_bits=6)], 64, 64).coord_bits == 6
    for size in ((8192, 1), (1, 8192), (1, 1)):
        assert picture_formats([Formats()], *size).coord_bits == max(12, (max(size) - 1).bit_length())
    for size in ((8193, 1), (1, 8193), (0, 5), (5, 0)):
        with pytest.raises(QuadshadeError, match="give 1x1 to 8192x8192"):
            picture_formats([Formats()], *size)


def test_edges_of_a_small_board() -> None:
    """A triangle that is far taller than a small board's coordinates say, in tiles of it."""
    board = Formats(coord_bits=5, subpixel_bits=0, with_depth=0, num_channels=1)
    formats = replace(picture_formats([board], 2048, 2048), subpixel_bits=8)
    vertices = np.array([[[1234, -70000], [524000, 33333], [77777, 523000]]])
    triangles = ScreenTriangles(
        2048, 2048, vertices, np.array([[[1.0, 250, 90, 140, 30, 200]]]), np.full((1, 1), 1), None, ("grey",)
    )
    cuttable = Cuttable(setup_triangles(triangles, formats), formats)
    rows = pixel_rows(cuttable.primitives, formats)
    for left, top in ((0, 0), (992, 128), (1504, 192), (32, 32), (320, 1600)):
        tile = Rectangle(left, top, 32, 32)
        part = refit(cuttable.to(tile), formats, board)
        on = (rows[:, 1] >= top) & (rows[:, 1] < top + 32) & (rows[:, 2] >= left) & (rows[:, 2] < left + 32)
        assert np.array_equal(pixel_rows(part, board, left, top), rows[on])
