# SPDX-License-Identifier: Apache-2.0
"""The model of the whole board, small: packed words to set-up words, and to the pixels of half-planes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from quadshade.contract.formats import Formats
from quadshade.golden.board import DrawnScreen
from quadshade.golden.link.word_unpacker import WordUnpacker
from quadshade.golden.screen.plane_reader import COLOUR, DEPTH
from quadshade.golden.screen.screen import Screen
from quadshade.packing.pack import pack_primitives
from quadshade.setup.packet import pack
from quadshade.setup.triangle_setup import setup_triangles
from tests.support.setup_reference import half_plane_pixels, screen_triangles

FORMATS = Formats(num_channels=3, with_depth=0, coord_bits=4, subpixel_bits=2)
SIZE = (12, 9)


def flat_triangles(rng: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Vertices across the border of the screen, and a colour each."""
    return rng.integers(-20, 60, (count, 3, 2)), rng.integers(1, 256, (count, 3))


def packed(
    vertices: np.ndarray, colours: np.ndarray, formats: Formats = FORMATS
) -> tuple[list[int], np.ndarray]:
    """Packed words of triangles of one colour each, and the set-up words that they stand for."""
    samples = np.repeat(colours[:, :, None], 6, axis=2).astype(float)
    triangles = screen_triangles(vertices, formats, *SIZE, samples, order=0)
    primitives = setup_triangles(triangles, formats)
    return pack_primitives(primitives, formats, 0.0).words.tolist(), pack(primitives, formats)


def painted(vertices: np.ndarray, colours: np.ndarray, background: list[int]) -> np.ndarray:
    """(height, width, 3): each pixel has the colour of the last triangle that covers it."""
    picture = np.full((SIZE[1], SIZE[0], 3), background)
    for triangle, x, y in half_plane_pixels(vertices, *SIZE, FORMATS.subpixel_bits).tolist():
        picture[y, x] = colours[triangle]
    return picture


def test_words_are_unpacked_however_they_are_cut(rng: np.random.Generator) -> None:
    words, setup_words = packed(*flat_triangles(rng, 4))
    for cut in (1, 2, len(words)):
        unpacker, out = WordUnpacker(FORMATS), []
        for at in range(0, len(words), cut):
            out += unpacker.feed(words[at : at + cut]).tolist()
        assert out == setup_words.tolist() and not unpacker.within
    # A packet begun is forgotten, and so are the widths.
    unpacker.feed(words[:1])
    assert unpacker.within and any(unpacker.widths)
    unpacker.reset()
    assert not unpacker.within and not any(unpacker.widths)
    assert unpacker.feed(words).tolist() == setup_words.tolist()


@pytest.mark.parametrize("with_shade", [0, 1])
def test_a_screen_shows_what_was_sent_so_far(with_shade: int, rng: np.random.Generator) -> None:
    """Words come in two parts, cut within a packet; a clear, and a reset between them."""
    formats = replace(FORMATS, with_shade=with_shade)
    vertices, colours = flat_triangles(rng, 3)
    words, _ = packed(vertices, colours, formats)
    screen = DrawnScreen(*SIZE, formats)
    screen.clear(0x030201)
    screen.triangles(words[:2])
    screen.triangles(words[2:])
    expected = painted(vertices, colours, [1, 2, 3])
    assert len(np.unique(expected.reshape(-1, 3), axis=0)) > 2
    for _ in range(2):
        assert np.array_equal(screen.plane(COLOUR), expected)
    row = screen.read(0, 2, SIZE[0], 3 * SIZE[0], COLOUR)
    assert list(row) == expected[2].ravel().tolist()
    # What was sent before a clear is not drawn behind it; what a reset finds begun never.
    screen.triangles(words)
    screen.clear(7)
    assert (screen.plane(COLOUR) == [7, 0, 0]).all()
    screen.triangles(words[:-1])
    screen.reset()
    assert screen.words == [] and (screen.plane(COLOUR) == [7, 0, 0]).all()
    screen.triangles(words)
    assert np.array_equal(screen.plane(COLOUR), painted(vertices, colours, [7, 0, 0]))


@pytest.mark.parametrize("with_shade", [0, 1])
def test_state_is_kept_by_address(with_shade: int) -> None:
    screen = DrawnScreen(*SIZE, Formats(with_shade=with_shade))
    before = dict(screen.registers)
    assert bool(before) == bool(with_shade)
    screen.state(5, 1234)
    screen.state(6, 7)
    screen.state(5, 9)
    assert screen.registers == before | {5: 9, 6: 7}


def test_a_screen_has_sixteen_bits_of_depth_unless_told() -> None:
    assert Screen(2, 1).plane(DEPTH).tolist() == [[[255, 255], [255, 255]]]
    assert [Screen(2, 1, depth_bits=bits).depth_bytes for bits in (None, 8, 9, 16, 17)] == [0, 1, 2, 2, 3]
