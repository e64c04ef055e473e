# SPDX-License-Identifier: Apache-2.0
"""Colour words against exact rationals: the bound holds at every pixel, and is small."""

from __future__ import annotations

import itertools
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from quadshade.contract.formats import Formats
from quadshade.contract.triangles import ScreenTriangles
from quadshade.setup import triangle_setup
from quadshade.setup.colour_words import Colours, colour_exactly
from quadshade.setup.edges import cut_triangles
from quadshade.setup.packet import Primitives
from quadshade.setup.quantise import FIT, SAMPLE_POINTS, carried_error, fit_linear, region, round_words
from quadshade.setup.triangle_setup import setup_triangles
from tests.support.setup_reference import exact_quadratic, screen_triangles, stepped_values, walk

FORMATS = (
    Formats(num_channels=1),
    Formats(num_channels=1, word_width=20, frac_bits=10, depth_bits=12),
    Formats(num_channels=1, word_width=60, frac_bits=44, value_bits=12, depth_bits=24),
    Formats(num_channels=1, subpixel_bits=12, coord_bits=13),
    Formats(num_channels=1, subpixel_bits=0, coord_bits=8),
)


def name(formats: Formats) -> str:
    return f"w{formats.word_width}_frac{formats.frac_bits}_subpixel{formats.subpixel_bits}"


def any_triangles(rng: np.random.Generator, count: int, formats: Formats, side: int) -> ScreenTriangles:
    """Every shape and size, needles and triangles across the border among them, at all orders."""
    pixel = 1 << formats.subpixel_bits
    reach = np.exp(rng.uniform(0, np.log(side * pixel), (count, 3, 1))).astype(np.int64) + 1
    vertices = rng.integers(0, side * pixel, (count, 1, 2)) + rng.integers(-reach, reach + 1, (count, 3, 2))
    thin = slice(None, None, 4)
    vertices[thin, 2] = (vertices[thin, 0] + vertices[thin, 1]) // 2 + rng.integers(
        -2, 3, (len(vertices[thin]), 2)
    )
    top = (1 << formats.value_bits) - 1
    samples = rng.uniform(0, top, (count, formats.num_channels, 6))
    samples[::7] = rng.integers(0, 2, samples[::7].shape) * top
    triangles = screen_triangles(vertices, formats, side, side, samples)
    triangles.orders = rng.choice([0, 1, 2, 2, 2], triangles.orders.shape)
    triangles.depth = rng.uniform(0, (1 << formats.depth_bits) - 1, (count, 3))
    return triangles


def position(
    triangles: ScreenTriangles,
    primitives: Primitives,
    primitive: int,
    pixel: dict[str, int],
    formats: Formats,
) -> tuple[Fraction, Fraction]:
    """Where colour is sampled for a pixel, in sub-pixels: its centre, or along the fractional major edge."""
    scale = 1 << formats.subpixel_bits
    y = Fraction(scale * (2 * pixel["y"] + 1), 2)
    if not primitives.header["fractional"][primitive]:
        return Fraction(scale * (2 * pixel["x"] + 1), 2), y
    corners = triangles.vertices[primitives.triangle[primitive]].tolist()
    crossings = []
    for (xa, ya), (xb, yb) in zip(corners, corners[1:] + corners[:1], strict=True):
        if min(ya, yb) <= y <= max(ya, yb) and ya != yb:
            crossings.append(xa + (y - ya) * Fraction(xb - xa, yb - ya))
    if primitives.header["mirror"][primitive]:
        return max(crossings) - scale * pixel["n"], y
    return min(crossings) + scale * pixel["n"], y


def errors_at(
    triangles: ScreenTriangles, primitives: Primitives, formats: Formats, chosen: np.ndarray, pixels: dict
) -> np.ndarray:
    """(k, channels) Fraction |value - exact quadratic| at chosen pixels of the walk, in output units."""
    words = stepped_values(primitives, pixels, formats)
    found = np.empty((len(chosen), formats.carried_channels), dtype=object)
    for place, index in enumerate(chosen):
        primitive = int(pixels["primitive"][index])
        triangle = int(primitives.triangle[primitive])
        x, y = position(
            triangles, primitives, primitive, {k: int(v[index]) for k, v in pixels.items()}, formats
        )
        for channel, frac_bits in enumerate(formats.channel_frac_bits):
            if channel < formats.num_channels:
                samples, order = triangles.samples[triangle, channel], triangles.orders[triangle, channel]
            else:
                samples, order = triangles.depth[triangle], 1
            exact = exact_quadratic(triangles.vertices[triangle], samples, order)(x, y)
            value = Fraction(int(words[index, channel]), 1 << frac_bits) - Fraction(1, 2)
            found[place, channel] = abs(value - exact)
    return found


@pytest.mark.parametrize("fractional", (False, True), ids=("centre", "fractional"))
@pytest.mark.parametrize("formats", FORMATS, ids=name)
@pytest.mark.parametrize("rounding", ("joint", "independent"))
def test_bound_holds(formats: Formats, fractional: bool, rounding: str, rng: np.random.Generator) -> None:
    """Three pixels of every primitive (first, last, any), 600 triangles a parameter, 12,000 in all."""
    triangles = any_triangles(rng, 600, formats, 200)
    if fractional:
        # On the border of the screen colour starts at the pixel's centre: only triangles inside are checked.
        limit = 200 << formats.subpixel_bits
        inside = ((triangles.vertices >= 0) & (triangles.vertices <= limit)).all(axis=(1, 2))
        triangles.vertices[~inside] = 0
    primitives = setup_triangles(triangles, formats, fractional, rounding)
    pixels = walk(primitives, formats)
    first = np.flatnonzero(np.diff(pixels["primitive"], prepend=-1))
    last = np.append(first[1:], len(pixels["x"])) - 1
    chosen = np.unique(np.concatenate([first, last, rng.integers(first, last + 1)]))
    errors = errors_at(triangles, primitives, formats, chosen, pixels)
    bounds = primitives.bound[pixels["primitive"][chosen]]
    for place, index in enumerate(chosen):
        for channel in range(formats.carried_channels):
            assert errors[place, channel] <= Fraction(bounds[place, channel]), (
                f"pixel {index} of primitive {pixels['primitive'][index]}, channel {channel}"
            )
    assert len(chosen) > 150


def test_bound_holds_at_every_pixel_and_is_met(rng: np.random.Generator) -> None:
    """All pixels of a few triangles; somewhere each bound is nearly reached, so it is not slack."""
    formats = Formats(num_channels=1, with_depth=0)
    vertices = rng.integers(0, 40 * 256, (25, 3, 2))
    triangles = screen_triangles(vertices, formats, 40, 40, rng.uniform(0, 255, (25, 1, 6)))
    primitives = setup_triangles(triangles, formats)
    pixels = walk(primitives, formats)
    errors = errors_at(triangles, primitives, formats, np.arange(len(pixels["x"])), pixels)[:, 0]
    ratios = []
    for primitive, bound in enumerate(primitives.bound[:, 0]):
        most = max(errors[pixels["primitive"] == primitive])
        assert most <= Fraction(bound)
        ratios.append(float(most) / bound)
    assert np.median(ratios) > 0.7


def test_carried_error_is_the_worst_of_all_pixels(rng: np.random.Generator) -> None:
    """Words that are off, each by its error and to one side: the value at every place, in exact numbers."""
    errors = rng.integers(1, 64, 6) / 16
    value, d_row, d_col, dd_row, dd_mixed, dd_col = errors.tolist()
    for m, n in itertools.product(range(7), range(-1, 7)):
        worst = max(
            value
            + row * d_row
            + row * (row - 1) / 2 * dd_row
            + column * (d_col + row * dd_mixed)
            + column * (column + 1) / 2 * dd_col
            for row, column in itertools.product(range(m + 1), range(max(n, 0) + 1))
        )
        assert carried_error(float(m), float(n), errors) == worst


def test_output_is_within_half_and_the_bound(rng: np.random.Generator) -> None:
    """Dropping the fraction rounds: |output - clamp(exact)| <= 1/2 + bound, with words of few bits too."""
    formats = Formats(num_channels=1, with_depth=0, word_width=16, frac_bits=6)
    triangles = screen_triangles(
        rng.integers(0, 12 * 256, (60, 3, 2)), formats, 12, 12, rng.uniform(0, 255, (60, 1, 6))
    )
    primitives = setup_triangles(triangles, formats)
    pixels = walk(primitives, formats)
    words = stepped_values(primitives, pixels, formats)[:, 0]
    for index, word in enumerate(words.tolist()):
        primitive = int(pixels["primitive"][index])
        triangle = int(primitives.triangle[primitive])
        x, y = (Fraction(256 * (2 * int(pixels[axis][index]) + 1), 2) for axis in "xy")
        exact = exact_quadratic(triangles.vertices[triangle], triangles.samples[triangle, 0], 2)(x, y)
        got, want = min(max(word >> 6, 0), 255), min(max(exact, 0), 255)
        assert abs(got - want) <= Fraction(1, 2) + Fraction(primitives.bound[primitive, 0])


@given(
    st.lists(st.integers(-(2**31), 2**31 - 1), min_size=6, max_size=6),
    st.integers(0, 40),
    st.integers(0, 40),
    st.integers(0, 40),
)
def test_steps_are_the_polynomial(words: list[int], m: int, carries: int, n: int) -> None:
    """The hardware's additions give the polynomial of which the words are the forward differences."""
    formats = Formats(num_channels=1, with_depth=0)
    carries = min(carries, m)
    primitives = Primitives(
        np.zeros(1), {"fractional": np.zeros(1, np.int64)}, {}, np.full((1, 1), 2), np.array([[words]])
    )
    pixels = {"primitive": [0], "x": [0], "m": [m], "n": [n], "n_lattice": [carries + n]}
    pixels = {key: np.array(value) for key, value in pixels.items()}
    value, d_row, d_col, dd_row, dd_mixed, dd_col = words
    column = carries + n
    want = value + m * d_row + m * (m - 1) // 2 * dd_row + column * d_col
    want += m * column * dd_mixed + column * (column + 1) // 2 * dd_col
    got = int(stepped_values(primitives, pixels, formats)[0, 0])
    assert (got - want) % (1 << 32) == 0


LARGE = {
    "right": [(0, 0), (0, 1024), (1024, 1024)],
    "left_leaning": [(1, 0), (0, 1024), (1024, 1023)],
    "right_leaning": [(1023, 0), (1024, 1024), (0, 1023)],
    "diagonal": [(0, 0), (1024, 1024), (1024, 1023)],
    "flat_top": [(0, 0), (1024, 0), (511, 1024)],
    "flat_bottom": [(1, 1024), (1024, 1024), (0, 0)],
    "shallow": [(0, 0), (1024, 30), (500, 1024)],
    "steep": [(1024, 0), (900, 1024), (0, 512)],
}


@pytest.mark.parametrize("shape", LARGE)
def test_bound_of_large_triangles(shape: str, rng: np.random.Generator) -> None:
    """Under 0.1 grey level at the default formats, whatever the words' fractions are, worst ones included."""
    cut = cut_triangles(np.array([LARGE[shape]]) * 256, 1024, 1024, 8)
    corners, fit, off = np.zeros((8, 2)), np.zeros(1, FIT)[0], np.zeros(6)
    count = region(cut.heads[0], cut.edges[0], False, corners)
    fit_linear(corners, count, np.zeros((SAMPLE_POINTS, 5)), fit)
    fractions = rng.uniform(0, 1, (4000, 6))
    fractions[:64, 3:] = np.stack(np.meshgrid(*3 * [[0.49, 0.5, 0.51, 0.25]]), axis=-1).reshape(-1, 3)
    worst = max(round_words(f, 2, corners, count, fit, True, off) for f in fractions)
    assert worst * 2.0**-22 < 0.1


@pytest.mark.parametrize("along", [0, 1], ids=["one_column", "one_row"])
def test_what_no_pixel_uses_is_rounded_to_nearest(along: int, rng: np.random.Generator) -> None:
    """Of one row or one column: the second differences of the other direction, and the mixed one."""
    corners, fit, off = np.zeros((8, 2)), np.zeros(1, FIT)[0], np.zeros(6)
    corners[2 - along : 4 - along, along] = 9.0
    fit_linear(corners, 4, np.zeros((SAMPLE_POINTS, 5)), fit)
    unused = [3, 4] if along else [4, 5]
    for fraction in rng.uniform(0, 1, (200, 6)):
        bound = round_words(fraction, 2, corners, 4, fit, True, off)
        nearest = np.floor(fraction + 0.5) - fraction
        assert np.array_equal(off[unused], nearest[unused])
        # The bound is that of the ten places, which the corners hold.
        places = np.arange(10.0)
        m, n = (0.0, places) if along else (places, 0.0)
        errors = off[0] + m * off[1] + m * (m - 1) / 2 * off[3] + n * off[2] + n * (n + 1) / 2 * off[5]
        assert np.abs(errors).max() <= bound


def test_lower_orders_absorb_what_higher_ones_lost(rng: np.random.Generator) -> None:
    """
    By least squares over a primitive's corners and edge middles: of the eight ways to round three second
    differences the one that leaves least to a linear function, then d_row that takes most of it away, then
    d_col that takes most of the rest.
    """
    corners, fit, off = np.zeros((8, 2)), np.zeros(1, FIT)[0], np.zeros(6)
    points, checked = np.zeros((SAMPLE_POINTS, 5)), 0
    for size in np.repeat([0.5, 1.0, 3.0, 30.0], 30):
        # Of one trapezoid, all round: the first row's low and high end, the last row's high and low one.
        corners[:4, 0] = 0.0, 0.0, *2 * [np.ceil(3 * size)]
        corners[:4, 1] = np.sort(rng.uniform(-size, size, (2, 2)), axis=1).ravel()[[0, 1, 3, 2]]
        fit_linear(corners, 4, points, fit)
        m, n = (points[:, :2] - points[:, :2].mean(axis=0)).T
        if (m @ m) * (n @ n) - (m @ n) ** 2 < 1e-2 * (m @ m) * (n @ n):
            continue
        row, column = points[:, 0], points[:, 1]
        bent = np.stack([row * (row - 1) / 2, row * column, column * (column + 1) / 2])
        bent -= bent.mean(axis=1, keepdims=True)
        linear = np.stack([m, n], axis=1)
        for fraction in rng.uniform(0, 1, (3, 6)):
            round_words(fraction, 2, corners, 4, fit, True, off)
            ways = np.array(list(itertools.product((0, 1), repeat=3))) - fraction[3:]
            left = [np.linalg.lstsq(linear, way @ bent, rcond=None)[1].sum() for way in (*ways, off[3:])]
            assert left[-1] <= min(left) + 1e-6 * (1 + min(left))
            want_row = np.linalg.lstsq(linear, -(off[3:] @ bent), rcond=None)[0][0]
            assert abs(off[1] - want_row) <= 0.5 + 1e-5
            want_column = -(off[3:] @ bent + off[1] * m) @ n / (n @ n)
            assert abs(off[2] - want_column) <= 0.5 + 1e-5
            checked += 1
    assert checked > 300


def test_bound_of_random_large_triangles(rng: np.random.Generator) -> None:
    formats = Formats()
    vertices = rng.integers(0, 1024 * 256 + 1, (3000, 3, 2))
    samples = rng.uniform(0, 255, (3000, 3, 6))
    triangles = screen_triangles(vertices, formats, 1024, 1024, samples)
    joint = setup_triangles(triangles, formats).bound[:, :3]
    independent = setup_triangles(triangles, formats, rounding="independent").bound[:, :3]
    assert joint.max() < 0.1
    # What the joint rounding is for: between one and three bits.
    assert np.median(independent / joint) > 4


def test_paths_agree(rng: np.random.Generator) -> None:
    """Floating point and integers give the same words, up to a unit where a rounding is close."""
    formats = Formats(num_channels=1)
    triangles = any_triangles(rng, 400, formats, 100)
    fast = setup_triangles(triangles, formats, rounding="independent")
    samples, orders = triangle_setup._checked_channels(triangles, formats)
    cut = cut_triangles(triangles.vertices, 100, 100, 8)
    words, bounds = np.zeros_like(fast.words), np.zeros_like(fast.bound)
    again = np.ones(bounds.shape, dtype=bool)
    colours = Colours(triangles.vertices, samples, orders, formats, False, False)
    colour_exactly(cut, colours, words, bounds, again)
    off = (words - fast.words + (1 << 31)) % (1 << 32) - (1 << 31)
    assert (np.abs(off) <= 1).all()
    assert (off != 0).mean() < 1e-3
    assert (bounds <= fast.bound + 1e-12).all()
