# SPDX-License-Identifier: Apache-2.0
"""What the packer says a board makes of vertices, against the program that the board runs: every bit."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from quadshade.contract.formats import Formats
from quadshade.golden.link.vertex_unpacker import VertexUnpacker
from quadshade.packing.pack_vertices import covers_of, pack_vertices, unpack_vertices
from quadshade.packing.read_primitives import read_primitives
from quadshade.packing.vertex_code import Tokens, code_parameters, write_tokens
from quadshade.packing.vertex_set_up import COVER_WIDTH, EDGE, board_of, set_up, usual_order
from quadshade.packing.vertices import MOST_TOKENS, Points, tokens_of
from quadshade.setup.packet import pack
from quadshade.setup.triangle_setup import setup_triangles
from tests.test_vertices import FORMATS, random_triangles

SHIFTS = 2, 3
"""Of colours and depth, in place of those that a packer would choose."""


def random_points(formats: Formats, count: int, seed: int) -> Points:
    """Any corners with an area and a row of pixels; on a grid now and then: ties in y, neighbours."""
    rng = np.random.default_rng(seed)
    pixel = 1 << formats.subpixel_bits
    places = rng.integers(0, 200 * pixel, (count, 3, 2))
    places[::2] = places[::2] // (40 * pixel) * 40 * pixel + rng.integers(0, 2, (len(places[::2]), 1, 1))
    places[3::4, :2] = places[2::4, 1:][: len(places[3::4])]
    first = (2 * places[:, :, 1] + pixel - 1) >> (formats.subpixel_bits + 1)
    sides = places[:, 1:] - places[:, :1]
    area = sides[:, 0, 0] * sides[:, 1, 1] - sides[:, 1, 0] * sides[:, 0, 1]
    good = (area != 0) & (first.max(axis=1) > first.min(axis=1))
    places = places[good]
    size, channels, depths = len(places), formats.num_channels, formats.with_depth
    colours = rng.integers(0, 1 << 10, (size, 3, channels))
    depth = rng.integers(0, 1 << formats.depth_bits, (size, 3, depths))
    quadratic = (rng.random(size) < 0.6) & (formats.max_order > 1)
    return Points(
        np.concatenate([places, colours, depth], axis=2),
        rng.integers(0, 1 << 10, (size, 3, channels)),
        quadratic,
        np.zeros((size, 2), np.int64),
        np.ones(size, np.bool_),
    )


@pytest.mark.parametrize("formats", FORMATS, ids=range(len(FORMATS)))
@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_what_the_program_makes_of_any_corners(formats: Formats, seed: int) -> None:
    points = random_points(formats, 24, seed)
    size = len(points.sent)
    room = MOST_TOKENS * size + 1
    tokens = Tokens(np.zeros(room, np.int8), np.zeros(room, np.int64), np.zeros(room, np.int8))
    order, parameters = np.zeros((size, 3), np.int64), np.array([0, 0, 0, 0, *SHIFTS])
    count = tokens_of(points, tokens, order)
    code_parameters(tokens, count, parameters)
    line = np.zeros(2 * count + 8, np.uint32)
    write_tokens(tokens, count, parameters, np.zeros(0, np.uint32), np.zeros(0, np.int64), line)
    drawn = read_primitives(VertexUnpacker(formats).feed(line), formats)
    covers = np.zeros((size, COVER_WIDTH), np.int64)
    words = np.zeros((size, formats.carried_channels, 6), np.int64)
    set_up(points, order, points.sent, board_of(formats, *SHIFTS), covers, words)
    assert np.array_equal(words, drawn.words)
    expected = covers_of(drawn)
    alone = expected[:, 3] == 0
    expected[alone, -len(EDGE) :] = covers[alone, -len(EDGE) :] = 0
    assert np.array_equal(covers, expected)
    # But for corners at the same y the order is the usual one.
    ties = (np.diff(np.sort(points.corners[:, :, 1], axis=1), axis=1) == 0).any(axis=1)
    assert np.array_equal(order[~ties], usual_order(points)[~ties])


@pytest.mark.parametrize("formats", FORMATS, ids=range(len(FORMATS)))
@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), error=st.sampled_from([1 / 32, 1 / 8, 1 / 2, 2.0]))
def test_any_triangles_are_unpacked_as_the_packer_says(formats: Formats, seed: int, error: float) -> None:
    triangles = random_triangles(formats, 24, seed)
    primitives = setup_triangles(triangles, formats)
    before = pack(primitives, formats)
    batch = pack_vertices(primitives, triangles, formats, error)
    assert np.array_equal(unpack_vertices(batch.words, formats), pack(batch.primitives, formats))
    assert np.array_equal(pack(primitives, formats), before), "what was given is as it was"
