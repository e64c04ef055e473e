# SPDX-License-Identifier: Apache-2.0
"""What a monitor and a reader see, in the model: TMDS words by their rules, a frame's pulses, planes."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from quadshade.contract.protocol import PLANES
from quadshade.errors import QuadshadeError
from quadshade.golden.screen.depth_test import DepthTest
from quadshade.golden.screen.edge_map import DIAGONAL, EIGHT
from quadshade.golden.screen.plane_reader import plane_reader
from quadshade.golden.screen.read_out import Area
from quadshade.golden.screen.scan_out import Timing, frame_words
from quadshade.golden.screen.screen import Screen, edge_plane
from quadshade.golden.screen.tmds_encoder import TmdsEncoder, decode

# Sums with carries where an exclusive or has none.
SMALL = Timing(24, 9, 3, 5, 18, 3, 2, 5)


def test_first_words_are_those_of_the_standards_figure() -> None:
    encoder = TmdsEncoder()
    assert [encoder.encode(value) for value in (0x00, 0x00, 0xFF, 0x10)] == [0x100, 0x3FF, 0x200, 0x1F0]
    assert [encoder.encode(None, control) for control in range(4)] == [0x354, 0x0AB, 0x154, 0x2AB]
    assert encoder.disparity == 0


def test_every_byte_is_decoded_at_every_disparity() -> None:
    """Disparity is ones minus zeros, never much; few changes in every word."""
    encoder, total, seen = TmdsEncoder(), 0, set()
    for value in np.random.default_rng(1).integers(0, 256, 20000).tolist():
        word = encoder.encode(value)
        assert decode(word) == value
        total += 2 * word.bit_count() - 10
        assert encoder.disparity == total and abs(total) <= 10
        seen.add((value, total))
        changes = sum(a != b for a, b in pairwise(f"{word & 0x1FF ^ (0xFF if word >> 9 else 0):09b}"[1:]))
        assert changes <= 4
    assert len({value for value, _ in seen}) == 256 and len(seen) > 1000


def test_a_frame_is_its_picture_and_two_pulses() -> None:
    picture = np.random.default_rng(1).integers(0, 256, (6, 8, 3)).astype(np.uint8)
    words = np.array(list(frame_words(picture, SMALL))).reshape(28, 41, 3)
    controls = [0x354, 0x0AB, 0x154, 0x2AB]
    for line, column in np.ndindex(28, 41):
        blue, green, red = words[line, column].tolist()
        if line < 18 and column < 24:
            assert [decode(red), decode(green), decode(blue)] == picture[line // 3, column // 3].tolist()
        else:
            # Both pulses are low.
            assert blue == controls[2 * (line not in (21, 22)) + (column not in (33, 34, 35))]
            assert green == red == controls[0]
    grey = np.array(list(frame_words(picture[:, :, :1], SMALL))).reshape(28, 41, 3)[:18, :24]
    assert {tuple(map(decode, place)) for place in grey.reshape(-1, 3).tolist()} == {
        (value,) * 3 for value in picture[:, :, 0].ravel().tolist()
    }


def test_the_standard_timing_and_what_does_not_fill_it() -> None:
    assert (Timing().all_columns, Timing().all_lines) == (800, 525)
    for shape in ((480, 641, 3), (481, 640, 1), (240, 640, 3), (239, 320, 3)):
        with pytest.raises(QuadshadeError, match="do not fill 640 x 480 as squares"):
            next(frame_words(np.zeros(shape, np.uint8)))


@pytest.mark.parametrize(
    ("plane", "expected"),
    [("colour", "332211887766"), ("depth", "4433BBAA"), ("edges_diagonal", "0201"), ("edges_eight", "0201")],
)
def test_planes_of_two_pixels(plane: str, expected: str) -> None:
    pixels = [(0x3344_112233, 0x0102), (0xAABB_667788, 0xFFFE)]
    whole = plane_reader(PLANES.index(plane), 100, pixels, 3, 2)
    assert whole == bytes.fromhex(expected + ("FEFF" if plane.startswith("edges") else ""))
    for count in range(len(whole)):
        assert plane_reader(PLANES.index(plane), count, iter(pixels), 3, 2) == whole[:count]


def test_areas_that_fit() -> None:
    assert Area(2, 1, 3, 1).fits(5, 2)
    for area in (Area(3, 1, 3, 1), Area(2, 2, 3, 1), Area(2, 1, 0, 1), Area(2, 1, 3, 0)):
        assert not area.fits(5, 2)


def test_which_screens_have_an_edge_map() -> None:
    Screen(4, 3, 3, 8, with_edge_map=True)
    for settings in ((1, 16), (3, None), (3, 7)):
        Screen(4, 3, *settings)
        with pytest.raises(QuadshadeError, match="an edge map needs three channels and depth of at least 8"):
            Screen(4, 3, *settings, with_edge_map=True)
    assert [Screen(1, 1, 3, bits).depth_bytes for bits in (None, 8, 9, 16, 17, 24)] == [0, 1, 2, 2, 3, 3]


def test_planes_of_a_screen() -> None:
    screen = Screen(4, 3, 3, 20, with_edge_map=True)
    screen.clear(0x030201)
    place = np.array([1, 2, 9]), np.array([1, 2, 0])
    screen.draw(*place, np.full((3, 3), 200), np.array([0x12345, 0x54321, 0]))
    assert screen.plane(0)[0, 0].tolist() == [1, 2, 3] and screen.plane(0)[1, 1].tolist() == [200] * 3
    assert screen.plane(1)[0, 0].tolist() == [0xFF, 0xFF, 0x0F]
    assert screen.plane(1)[1, 1].tolist() == [0x45, 0x23, 0x01]
    depth = np.minimum(screen.depth, 0xFFFFF)
    maps = [edge_plane(screen.colour, depth, 20, variant) for variant in (DIAGONAL, EIGHT)]
    assert (maps[0] != maps[1]).any()
    assert [(screen.plane(plane) == maps[plane - 2]).all() for plane in (2, 3)] == [True, True]
    assert screen.read(1, 1, 2, 7, 0) == bytes([200] * 3 + [1, 2, 3, 1])
    screen.draw(*place, np.full((3, 3), 9), np.array([0, 0, 0]))
    assert screen.plane(0)[1, 1].tolist() == [9] * 3 and (screen.plane(2) != maps[0]).any()
    without = Screen(4, 3, 1, None)
    without.draw(np.array([0, 4, 0]), np.array([0, 0, 3]), np.array([[5], [6], [7]]), None)
    assert without.colour.sum() == without.colour[0, 0] == 5


def test_a_cleared_place_is_one_more_than_the_farthest() -> None:
    assert DepthTest(2, 1, 4).stored == [16, 16]
