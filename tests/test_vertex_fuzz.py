# SPDX-License-Identifier: Apache-2.0
"""Anything packed as vertices, anything at all unpacked: meshes at the limits, damaged packets."""

from __future__ import annotations

import os
import random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from quadshade.contract.formats import Formats
from quadshade.contract.vertex_program import (
    MIDDLE_WORDS,
    MIDDLES_AT,
    SCRATCH_AT,
    VERTEX_WORDS,
    program,
)
from quadshade.golden.compiled import draw_fast
from quadshade.golden.link.vertex_unpacker import VertexUnpacker
from quadshade.golden.unpacker_clocks import unpacking_clocks, unpacking_of
from quadshade.packing.pack_vertices import choose_vertices, pack_vertices, unpack_vertices
from quadshade.setup.packet import pack
from quadshade.setup.triangle_setup import setup_triangles
from scripts import vertex_ranks
from tests.support.vertex_stimuli import KINDS, Echo, as_bits, as_words, damaged, limit_mesh, most_clocks
from tests.test_vertices import FORMATS

EXAMPLES = int(os.environ.get("QUADSHADE_FUZZ") or 12)
"""Of each test: `make fuzz-vertices` has more."""

CORNERS = ("v0", "v1", "v2", "next_vertex", "slot")
EDGE_MIDDLES = ("m0", "m1", "m2", "next_middle")
SEEDS = st.integers(0, 2**32 - 1)


@pytest.mark.parametrize("formats", FORMATS, ids=range(len(FORMATS)))
@settings(max_examples=EXAMPLES, deadline=None)
@given(seed=SEEDS, points=st.sampled_from([3, 20, 150]), error=st.sampled_from([1 / 32, 1 / 4]))
def test_meshes_at_the_limits(formats: Formats, seed: int, points: int, error: float) -> None:
    """What is unpacked is what the packer says: edges are the host's, colours within the error."""
    triangles = limit_mesh(formats, 100, points, seed)
    primitives = setup_triangles(triangles, formats)
    batch = pack_vertices(primitives, triangles, formats, error)
    words = unpack_vertices(batch.words, formats)
    assert np.array_equal(words, pack(batch.primitives, formats))
    assert 0.0 <= batch.added <= error
    # The same pixels in the same order, packed words' too.
    exact, drawn = draw_fast(pack(primitives, formats), formats), draw_fast(words, formats)
    assert np.array_equal(drawn.x, exact.x) and np.array_equal(drawn.y, exact.y)
    # With nothing to be added every word is the host's.
    whole = unpack_vertices(pack_vertices(primitives, triangles, formats, 0.0).words, formats)
    assert np.array_equal(whole, pack(primitives, formats))


@pytest.mark.parametrize("formats", FORMATS, ids=range(len(FORMATS)))
def test_meshes_at_the_limits_go_as_vertices(formats: Formats, seed: int) -> None:
    """Or the test above says little: a part of them does, from full tables on too."""
    triangles = limit_mesh(formats, 300, 150, seed)
    chosen = choose_vertices(setup_triangles(triangles, formats), triangles, formats, 1 / 4)
    assert chosen is not None and 0.1 < np.count_nonzero(chosen.sent[150:]) / 150 < 0.99


def check_tables(model: VertexUnpacker) -> None:
    """Every pointer of the program is inside its table, whatever was on the line."""
    places = program().places
    for names, low, high, step in (
        (CORNERS, 0, MIDDLES_AT, VERTEX_WORDS),
        (EDGE_MIDDLES, MIDDLES_AT, SCRATCH_AT, MIDDLE_WORDS),
    ):
        for name in names:
            at = int(model.memory[places[name]])
            # Middles that no packet has named are at 0.
            assert at == 0 or (low <= at < high and at % step == 0), (name, at)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("formats", FORMATS, ids=range(len(FORMATS)))
@settings(max_examples=EXAMPLES, deadline=None)
@given(seed=SEEDS)
def test_any_words_are_unpacked(formats: Formats, kind: str, seed: int) -> None:
    """Packets end in a bounded number of clocks, tables stay in their places, words come in any pieces."""
    triangles = limit_mesh(formats, 20, 80, seed)
    packed = pack_vertices(setup_triangles(triangles, formats), triangles, formats, 1 / 4).words
    draw = random.Random(seed)
    words = damaged(draw, kind, packed, 120)
    models = [VertexUnpacker(formats) for _ in range(2)]
    for model in models:
        model.plain = Echo()
    whole = [given.tolist() for _, _, given in models[0].packets(words)]
    check_tables(models[0])
    # A clock for each bit that is skipped, and for each word.
    assert models[0].clocks <= most_clocks(formats) * (len(whole) + 2) + 33 * len(words)
    cut = draw.randrange(len(words) + 1)
    parts = [model_words for part in np.split(words, [cut]) for model_words in models[1].feed(part).tolist()]
    assert parts == [word for given in whole for word in given]
    assert np.array_equal(models[0].memory, models[1].memory)
    assert models[0].begun == models[1].begun and models[0].within == models[1].within
    if kind == "zeros":
        assert not parts and not models[0].within and sum(as_bits(words)) <= 2 + 5 * 6


def test_the_bound_is_not_far_off() -> None:
    """Long residuals everywhere take more than half of what is proved; the rest no packet does at once."""
    formats = FORMATS[0]
    head = [1, 1, 0, *([0, 0, 0, 0, 1] * 6)]
    # Trims, quadratic, three corners and three middles, each new, with numbers of 24 bits.
    corner, middle = [1, 0, *([*[1] * 15, *[0, 1] * 12] * 6)], [1, *([*[1] * 15, *[0, 1] * 12] * 3)]
    body = [1, 0, *([1] * 30), 1, 1, 1, *corner, *corner, *middle, *corner, *middle, *middle]
    words = [np.array(as_words(bits), np.uint32) for bits in (head, [*head, *body])]
    assert len(list(VertexUnpacker(formats).packets(words[1]))) == 1
    before, whole = (unpacking_clocks(unpacking_of(part, formats, True)) for part in words)
    bound = vertex_ranks.table(formats).bound
    assert bound / 2 < whole - before <= bound < most_clocks(formats)
