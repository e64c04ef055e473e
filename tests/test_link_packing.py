# SPDX-License-Identifier: Apache-2.0
"""Packed packets: what is unpacked, what shorter words cost, and how many bytes are left."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from quadshade.choices import PACK_ERROR
from quadshade.contract.formats import Formats
from quadshade.contract.packed_format import packed_fields
from quadshade.contract.shade_state import ShadeState, channel_gains
from quadshade.contract.triangles import ScreenTriangles
from quadshade.errors import QuadshadeError
from quadshade.golden.compiled import draw_fast
from quadshade.golden.link.word_unpacker import WordUnpacker
from quadshade.packing.pack import pack_primitives, unpack
from quadshade.packing.widths import Needs, hold
from quadshade.scene import load_scene, parse_camera, project
from quadshade.setup.packet import Primitives, pack
from quadshade.setup.short_edges import short_edges
from quadshade.setup.triangle_setup import setup_triangles
from quadshade.shading import sample
from quadshade.shading.specular import sample_specular, specular_formats
from tests.support.setup_reference import screen_triangles

FORMATS = [
    Formats(),
    Formats(num_channels=2, with_shade=1),
    Formats(num_channels=1, max_order=0, with_depth=0, word_width=20, frac_bits=10, subpixel_bits=0),
    Formats(num_channels=8, word_width=40, frac_bits=28, with_shade=1, num_specular=3, coord_bits=13),
    Formats(num_channels=2, max_order=1, word_width=24, frac_bits=14, subpixel_bits=4, coord_bits=9),
]


def random_triangles(formats: Formats, count: int, seed: int) -> ScreenTriangles:
    """Triangles of three sizes, any orders, some beyond the screen."""
    rng = np.random.default_rng(seed)
    size, pixel = 1 << min(formats.coord_bits, 9), 1 << formats.subpixel_bits
    spread = rng.choice([2.0, 12.0, size / 2], (count, 1, 1))
    vertices = (rng.uniform(0, size, (count, 1, 2)) + rng.uniform(-1, 1, (count, 3, 2)) * spread) * pixel
    shape, top = (count, formats.num_channels), 2.0**formats.value_bits - 1
    samples = rng.uniform(0, top, (*shape, 1)) + rng.uniform(-1, 1, (*shape, 6)) * top / 8
    return ScreenTriangles(
        size,
        size,
        np.rint(vertices).astype(np.int64),
        np.clip(samples, 0, top),
        rng.integers(0, formats.max_order + 1, shape),
        rng.uniform(0, 2.0**formats.depth_bits - 1, (count, 3)) if formats.with_depth else None,
        tuple(f"c{index}" for index in range(formats.num_channels)),
    )


def scene(
    name: str, camera: str, shading: str, width: int = 320, height: int = 240
) -> tuple[Primitives, Formats, ShadeState | None]:
    """A scene's primitives, their formats and shading state."""
    formats = Formats()
    mesh = load_scene(name)
    projected = project(mesh, parse_camera(camera, mesh), width, height, formats)
    if shading.endswith("specular"):
        formats = specular_formats({}, projected)
        triangles = sample_specular(projected, shading, formats=formats)
    else:
        triangles = sample(projected, shading, formats=formats)
    return setup_triangles(triangles, formats, limit=0.5), formats, triangles.shade


@pytest.mark.parametrize("formats", FORMATS, ids=range(len(FORMATS)))
def test_what_is_unpacked_is_the_packets(formats: Formats, seed: int) -> None:
    primitives = setup_triangles(random_triangles(formats, 200, seed), formats)
    exact, short = pack_primitives(primitives, formats, 0.0), pack_primitives(primitives, formats)
    setup_words = pack(primitives, formats)
    assert np.array_equal(unpack(exact.words, formats), setup_words)
    assert exact.added == 0.0
    expected = pack(short.primitives, formats)
    assert np.array_equal(unpack(short.words, formats), expected)
    assert len(short.words) < len(exact.words) < len(setup_words)
    # Batches follow each other, cut anywhere.
    unpacker = WordUnpacker(formats)
    both = np.concatenate([short.words, exact.words])
    cuts = np.sort(np.random.default_rng(seed).integers(0, len(both), 50))
    parts = [unpacker.feed(part) for part in np.split(both, cuts)]
    assert np.array_equal(np.concatenate(parts), np.concatenate([expected, setup_words]))
    assert not unpacker.within


@pytest.mark.parametrize("error", [1 / 16, 1 / 2])
@pytest.mark.parametrize("formats", [FORMATS[0], FORMATS[4]], ids=["default", "narrow"])
def test_errors_added_are_bounded(formats: Formats, error: float, seed: int) -> None:
    primitives = setup_triangles(random_triangles(formats, 150, seed), formats)
    batch = pack_primitives(primitives, formats, error)
    # The same words, with more bits of them emitted.
    more = min(18 - formats.value_bits, formats.frac_bits)
    fine = replace(
        formats,
        value_bits=formats.value_bits + more,
        frac_bits=formats.frac_bits - more,
        depth_bits=formats.depth_bits,
    )
    before, after = draw_fast(pack(primitives, fine), fine), draw_fast(pack(batch.primitives, fine), fine)
    assert np.array_equal(before.x, after.x)
    assert np.array_equal(before.y, after.y)
    channels = formats.num_channels
    off = np.abs(before.value[:, :channels] - after.value[:, :channels]).max() / 2.0**more
    assert 0.1 * error < off <= batch.added + 2.0**-more
    assert batch.added <= error
    if formats.with_depth:
        assert np.abs(before.value[:, channels] - after.value[:, channels]).max() <= 1
    assert (batch.primitives.bound >= primitives.bound).all()


def test_short_edges_have_the_same_columns(seed: int) -> None:
    formats = Formats()
    primitives = setup_triangles(random_triangles(formats, 400, seed), formats)
    short = replace(primitives, edges=short_edges(primitives))
    one, other = draw_fast(pack(primitives, formats), formats), draw_fast(pack(short, formats), formats)
    for name in ("x", "y", "packet"):
        assert np.array_equal(getattr(one, name), getattr(other, name))
    # Colour moves with the carries, so every pixel has its value.
    assert np.array_equal(one.value, other.value)
    before, after = (-p.edges["minor"]["decrement"] for p in (primitives, short))
    assert (after <= before).all()
    assert np.median(after) < np.median(before) / 8


@pytest.mark.parametrize("camera", ["", "ortho=1.1"])
@pytest.mark.parametrize(("shading", "most"), [("quadratic", 45), ("quadratic-specular", 45)])
def test_bytes_of_a_triangle(camera: str, shading: str, most: int) -> None:
    primitives, formats, state = scene("sphere:690", camera, shading)
    batch = pack_primitives(primitives, formats, PACK_ERROR, state)
    assert 20 < 4 * len(batch.words) / len(np.unique(primitives.triangle)) < most


@pytest.mark.parametrize("formats", [FORMATS[0], FORMATS[4]], ids=["default", "narrow"])
def test_bits_that_are_zero_in_all_words_are_not_sent(formats: Formats, seed: int) -> None:
    primitives = setup_triangles(random_triangles(formats, 60, seed), formats)
    coarse = replace(primitives, words=primitives.words & -64)
    batches = [pack_primitives(given, formats, 0.0) for given in (primitives, coarse)]
    sent = int(np.array([1, 3, 6])[primitives.orders].sum())
    saved = 32 * (len(batches[0].words) - len(batches[1].words))
    assert 5 * sent < saved
    assert np.array_equal(unpack(batches[1].words, formats), pack(coarse, formats))


def test_no_width_is_beyond_its_field() -> None:
    """Over the border of a screen of the full size too, where a column is one more than its bits can say."""
    formats = Formats(num_channels=1, coord_bits=6)
    corners = np.array([[[3000, 200], [40 * 256, 60 * 256], [80 * 256, 300]]])
    triangles = screen_triangles(corners, formats, 64, 64, order=0)
    primitives = setup_triangles(triangles, formats)
    assert max(edge["column"].max() for edge in primitives.edges.values()) == 64
    unpacker, packets = WordUnpacker(formats), 0
    for _ in unpacker.packets(pack_primitives(primitives, formats, 0.0).words):
        packets += 1
        for name, bits, address, _ in packed_fields(formats):
            assert unpacker.widths[address] < bits, name
    assert packets == len(primitives)


CHANGE = 11
"""Bits of a change of a width at the default formats: one, an address of five, a value of five."""


def cheapest(need: list[int], count: list[int], below: list[int] | None) -> tuple[float, list[list[int]]]:
    """
    Fewest bits for one width over some packets, and every list of values that takes no more, by trying all.

    With ``below`` it is a top: at least what a packet needs, a value's bits are those from ``below`` to it.
    Without, it is the bits that are not sent: at most what a packet needs.
    """
    sending = [packet for packet, times in enumerate(count) if times]
    found: dict[float, list[list[int]]] = {}
    for values in product(range(max(need) + 1), repeat=len(sending)):
        bits = sum(CHANGE for a, b in zip((None, *values), values, strict=False) if a != b)
        for packet, value in zip(sending, values, strict=True):
            if value < need[packet] if below else value > need[packet]:
                break
            bits += count[packet] * (len(range(below[packet], value + 1)) if below else -value)
        else:
            found.setdefault(bits, []).append(list(values))
    return min(found), found[min(found)]


PACKETS = st.lists(
    st.tuples(st.integers(0, 4), st.sampled_from([0, 1, 3, 12]), st.integers(0, 6)), min_size=1, max_size=4
).filter(lambda packets: any(count for _, count, _ in packets))


@given(PACKETS)
def test_widths_take_the_fewest_bits(packets: list[tuple[int, int, int]]) -> None:
    """Of a difference's two widths, each against every choice that there is."""
    need, count, below = (np.array(column)[:, None] for column in zip(*packets, strict=True))
    sends = count[:, 0] > 0
    held = hold(need, count, None, Formats())[:, 0]
    assert held[sends].tolist() in cheapest(need[:, 0].tolist(), count[:, 0].tolist(), None)[1]
    needs = Needs(len(packets), Formats())
    # Twelve channels that share a width.
    shared, one_each = np.full(12, 4), np.ones((12, 1), np.int64)
    sent = count[:, 0] > np.arange(12)[:, None]
    needs.differences(shared, one_each * below[:, 0], one_each * need[:, 0], sent)
    widths = needs.widths(Formats())
    assert np.array_equal(widths[:, 4], below[:, 0])
    needed = np.where(sends, need[:, 0], 0)
    best = cheapest(needed.tolist(), count[:, 0].tolist(), below[:, 0].tolist())[1]
    assert widths[sends, 5].tolist() in best
    # Nothing else was asked for.
    assert not np.delete(widths, [4, 5], axis=1).any()


def test_gains_are_those_of_the_power() -> None:
    _, formats, state = scene("sphere:168", "", "quadratic-specular")
    diffuse, specular = channel_gains(state, formats)
    assert diffuse == pytest.approx(state.coefficients[0].max() / 2**16)
    # The slope of x**20 at 1, but for the table's intervals.
    assert specular == pytest.approx(20 * state.coefficients[1].max() / 2**16, rel=0.05)


def test_nothing_and_nonsense() -> None:
    formats = Formats()
    nothing = setup_triangles(random_triangles(formats, 0, 1), formats)
    empty = pack_primitives(nothing, formats)
    assert len(empty.words) == 0 and empty.added == 0.0
    assert len(unpack(np.zeros(5, np.uint32), formats)) == 0
    with pytest.raises(QuadshadeError, match="error of packing"):
        pack_primitives(nothing, formats, float("nan"))
    with pytest.raises(QuadshadeError, match="stream_width"):
        pack_primitives(nothing, Formats(stream_width=64))
    some = pack_primitives(setup_triangles(random_triangles(formats, 3, 1), formats), formats)
    with pytest.raises(QuadshadeError, match="end within a packet"):
        unpack(some.words[:-1], formats)
