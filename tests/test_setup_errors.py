# SPDX-License-Identifier: Apache-2.0
"""Degenerate and bad triangles: what is drawn, what is refused, and with which words."""

from __future__ import annotations

import numpy as np
import pytest

from quadshade.contract.formats import Formats
from quadshade.contract.triangles import ScreenTriangles
from quadshade.errors import QuadshadeError
from quadshade.setup.edges import cut_triangles
from quadshade.setup.triangle_setup import _check_words, _first_misfit, setup_triangles
from tests.support.setup_reference import screen_triangles, walk

FORMATS = Formats(coord_bits=6)
BIG = [[0, 0], [40 * 256, 0], [0, 40 * 256]]


def triangles(*corners: list[list[int]], order: int = 2) -> ScreenTriangles:
    return screen_triangles(np.array(corners, dtype=np.int64), FORMATS, 64, 64, order=order)


@pytest.mark.parametrize(
    "corners",
    (
        [[100, 100], [100, 100], [100, 100]],
        [[0, 0], [2560, 2560], [5120, 5120]],
        [[0, 300], [5000, 300], [2000, 300]],
        [[130, 130], [200, 130], [130, 200]],
        [[-4000, -4000], [-100, -4000], [-4000, -100]],
        [[64 * 256 + 200, 0], [100 * 256, 0], [100 * 256, 9000]],
    ),
    ids=("point", "line", "horizontal_line", "between_centres", "off_left", "off_right"),
)
def test_nothing_drawn(corners: list[list[int]]) -> None:
    assert len(setup_triangles(triangles(corners), FORMATS)) == 0


def test_one_pixel() -> None:
    primitives = setup_triangles(triangles([[120, 120], [140, 120], [120, 140]]), FORMATS)
    pixels = walk(primitives, FORMATS)
    assert (pixels["x"].tolist(), pixels["y"].tolist()) == ([0], [0])
    assert (primitives.words[0, :, 1:] == 0).all(), "a word that no pixel uses"


def test_whole_screen_is_one_packet() -> None:
    """The border has nothing to walk: step 0, and an error that never carries."""
    primitives = setup_triangles(triangles([[-9000, -9000], [32767, -9000], [-9000, 32767]]), FORMATS)
    assert len(walk(primitives, FORMATS)["x"]) < 64 * 64
    major = {part: int(values[0]) for part, values in primitives.edges["major"].items()}
    assert major == {"column": 0, "error": -1, "step": 0, "increment": 0, "decrement": -1}


def test_orders_send_only_their_differences(rng: np.random.Generator) -> None:
    for order, differences in enumerate((1, 3, 6)):
        given = triangles(BIG, order=order)
        given.samples = rng.uniform(0, 255, given.samples.shape)
        # What an order does not use is not looked at.
        given.samples[..., differences:] = np.nan
        primitives = setup_triangles(given, FORMATS)
        assert (primitives.words[:, :3, differences:] == 0).all()
        assert (primitives.words[:, :3, :differences] != 0).all()


def test_depth_is_linear() -> None:
    given = triangles(BIG)
    given.depth = np.array([[0.0, 65535.0, 30000.0]])
    primitives = setup_triangles(given, FORMATS)
    assert primitives.orders[0].tolist() == [2, 2, 2, 1]
    slope = 65535 / 40 * 2.0**FORMATS.depth_frac_bits
    assert abs(int(primitives.words[0, 3, 2]) - slope) < 1


def broken(**changes) -> ScreenTriangles:
    given = triangles(BIG, BIG, BIG)
    for field, value in changes.items():
        setattr(given, field, value)
    return given


def with_sample(value: float, channel: int = 1) -> np.ndarray:
    samples = np.full((3, 3, 6), 100.0)
    samples[2, channel, 4] = value
    return samples


def with_vertex(value: int) -> np.ndarray:
    vertices = np.array([BIG, BIG, BIG])
    vertices[1, 2, 0] = value
    return vertices


@pytest.mark.parametrize(
    "given, message",
    (
        (broken(vertices=with_vertex(2 * 64 * 256)), "triangle out of range: triangle 1"),
        (broken(vertices=with_vertex(-64 * 256 - 1)), "triangle out of range: triangle 1"),
        (broken(samples=with_sample(np.nan)), "triangle 2: channel g has a sample outside 0 .. 255"),
        (broken(samples=with_sample(np.inf)), "triangle 2: channel g has a sample outside"),
        (broken(samples=with_sample(-0.5, 2)), "triangle 2: channel b has a sample outside"),
        (broken(samples=with_sample(255.01)), "triangle 2: channel g has a sample outside"),
        (broken(depth=np.array([[0, 0, 0], [0, 65536.0, 0], [0, 0, 0]])), "triangle 1: channel depth"),
        (broken(orders=np.full((3, 3), 3)), "triangle 0: channel r has order 3"),
        (broken(samples=np.zeros((3, 2, 6)), orders=np.zeros((3, 2))), "generic num_channels is 3"),
        (broken(width=65), "screen of 65 x 64"),
        (broken(height=0), "screen of 64 x 0"),
    ),
    ids=lambda v: v.replace(" ", "_") if isinstance(v, str) else "",
)
def test_refused(given: ScreenTriangles, message: str) -> None:
    with pytest.raises(QuadshadeError, match=message) as caught:
        setup_triangles(given, FORMATS)
    assert "\n" not in str(caught.value)
    assert caught.value.hint


@pytest.mark.parametrize(
    ("given", "said", "hint"),
    [
        (
            broken(vertices=with_vertex(2 * 64 * 256 + 64)),
            "triangle out of range: triangle 1 has its vertices at [[0.0, 0.0], [40.0, 0.0], [128.25, 40.0]]",
            "clip to -64 .. 128 pixels (generic coord_bits)",
        ),
        (broken(width=65), "screen of 65 x 64 pixels", "give 1 to 64 (generic coord_bits)"),
        (
            broken(vertices=np.zeros((3, 3, 2))),
            "the triangles' vertices are float64",
            "give whole sub-pixels",
        ),
        (
            broken(vertices=np.zeros((3, 2), np.int64)),
            "the triangles' vertices has shape (3, 2)",
            "give (3, 3, 2)",
        ),
        (broken(depth=np.zeros((3, 2))), "the triangles' depth has shape (3, 2)", "give (3, 3)"),
    ],
)
def test_where_it_is_and_what_to_do(given: ScreenTriangles, said: str, hint: str) -> None:
    with pytest.raises(QuadshadeError) as caught:
        setup_triangles(given, FORMATS)
    assert str(caught.value).startswith(said) and caught.value.hint == hint


def test_guard_band_is_allowed() -> None:
    """Up to its ends, all of the triangle's pixels are drawn; one sub-pixel further it is refused."""
    low, high = FORMATS.guard_band
    corners = np.array([[low, low], [high, low], [low, high]])
    pixels = walk(setup_triangles(triangles(corners.tolist()), FORMATS), FORMATS)
    y, x = np.mgrid[:64, :64]
    # The slanted edge is none of the triangle's: it is neither its top nor a left one.
    inside = ((x + y + 1) << FORMATS.subpixel_bits) < low + high
    drawn = np.zeros((64, 64), np.int64)
    np.add.at(drawn, (pixels["y"], pixels["x"]), 1)
    assert (drawn == inside).all() and 0 < inside.sum() < inside.size
    for vertex, axis, beyond in ((0, 0, low - 1), (0, 1, low - 1), (1, 0, high + 1), (2, 1, high + 1)):
        further = corners.copy()
        further[vertex, axis] = beyond
        with pytest.raises(QuadshadeError, match="triangle out of range: triangle 0"):
            setup_triangles(triangles(further.tolist()), FORMATS)


def test_order_above_the_core() -> None:
    with pytest.raises(QuadshadeError, match="max_order"):
        setup_triangles(triangles(BIG), Formats(coord_bits=6, max_order=1))


def test_rounding_has_two_names() -> None:
    with pytest.raises(QuadshadeError, match="'banker'"):
        setup_triangles(triangles(BIG), FORMATS, rounding="banker")


@pytest.mark.parametrize(("word_width", "frac_bits", "coord_bits"), [(12, 2, 8), (20, 10, 12)])
def test_word_too_narrow(word_width: int, frac_bits: int, coord_bits: int) -> None:
    """Few fraction bits lose a second difference: hundreds of grey levels, and the bound sees it."""
    formats = Formats(
        num_channels=1, with_depth=0, word_width=word_width, frac_bits=frac_bits, coord_bits=coord_bits
    )
    side = 128 << coord_bits
    corners = np.array([[[0, 0], [side, 0], [0, side]]])
    samples = np.array([[[0, 0, 0, 255, 0, 0.0]]])
    wide = screen_triangles(corners, formats, samples=samples)
    with pytest.raises(QuadshadeError, match=f"triangle 0: channel 0 may not fit its word of {word_width} b"):
        setup_triangles(wide, formats, rounding="independent")


@pytest.mark.parametrize(("order", "stray"), [(0, 0.0), (1, 120.0), (2, 200.0)])
def test_how_far_a_value_may_stray(order: int, stray: float) -> None:
    """Half the range of the samples that are used, 5/3 of it for a quadratic, the bound, and half a level."""
    cut = cut_triangles(np.array([BIG]), 64, 64, 8)
    samples = np.array([[[10.0, 250.0, 130.0, 100.0, 10.0, 20.0]]])
    middle = 10.0 if order == 0 else 130.0
    for sign in (1, -1):
        reach = middle + 0.5 * sign + stray + 3.0
        for limit in (reach - 0.1, reach + 0.1):
            given = (cut.heads, sign * samples, np.array([[order]]), np.array([[3.0]]), np.array([limit]))
            assert _first_misfit(*given) == ((0, 0) if limit < reach else (-1, -1))


@pytest.mark.parametrize(
    "generics", ({"word_width": 20, "frac_bits": 10}, {"word_width": 36, "frac_bits": 26})
)
def test_words_of_every_width_have_their_limit(generics: dict[str, int]) -> None:
    """Nine bits before the point, with the sign: a value of 511 fits, half a level more does not."""
    formats = Formats(num_channels=1, with_depth=0, **generics)
    cut = cut_triangles(np.array([BIG]), 64, 64, 8)
    for value in (511.0, 512.0):
        given = (cut, np.full((1, 1, 6), value), np.zeros((1, 1), np.int64), np.zeros((1, 1)), formats)
        if value < 511.5:
            _check_words(*given)
        else:
            with pytest.raises(QuadshadeError, match=f"its word of {generics['word_width']} bits"):
                _check_words(*given)


@pytest.mark.parametrize(
    ("field", "value", "message"),
    (
        ("vertices", np.zeros((1, 3, 3), np.int64), r"vertices has shape \(1, 3, 3\)"),
        ("vertices", np.zeros((1, 3, 2)), "vertices are float64"),
        ("depth", np.zeros((2, 3)), r"depth has shape \(2, 3\)"),
    ),
)
def test_arrays_of_another_shape_are_refused(field: str, value: np.ndarray, message: str) -> None:
    given = triangles(BIG)
    setattr(given, field, value)
    with pytest.raises(QuadshadeError, match=message):
        setup_triangles(given, FORMATS)


@pytest.mark.parametrize("value", (2.5, "8", None))
def test_generics_are_whole_numbers(value: object) -> None:
    with pytest.raises(QuadshadeError, match="generic num_channels is .*whole number"):
        Formats(num_channels=value)
