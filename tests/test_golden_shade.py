# SPDX-License-Identifier: Apache-2.0
"""The shade unit's model against rationals and powers in float, and its fast twin against it."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest

from quadshade.contract.formats import Formats
from quadshade.contract.shade_state import (
    ShadeState,
    channel_gains,
    colour_state,
    curve_table,
    power_curve,
    shade_state,
    table_entries,
    table_places,
)
from quadshade.engine import draw
from quadshade.errors import QuadshadeError
from quadshade.golden.compiled import draw_fast
from quadshade.golden.shade import power_table, render_core
from quadshade.golden.shade.shade import factors, shade
from tests.support.golden_stimuli import triangle_words, triangles_of
from tests.support.shade_stimuli import random_state, random_values

TINY = Formats(with_shade=1, num_channels=2, value_bits=4, shade_guard_bits=4, word_width=20, frac_bits=8)
FORMATS = {
    "default": Formats(with_shade=1, num_channels=2),
    "four lights": Formats(with_shade=1, num_channels=8, num_specular=4),
    "all specular": Formats(with_shade=1, num_channels=3, num_specular=3, with_depth=0, shade_guard_bits=8),
    "more bits": Formats(with_shade=1, num_channels=5, num_specular=2, value_bits=12, shade_guard_bits=6,
                         word_width=40, frac_bits=24),
    "tiny": TINY,
}  # fmt: skip


@pytest.mark.parametrize("formats", FORMATS.values(), ids=FORMATS)
def test_fast_is_scalar(formats: Formats, rng: np.random.Generator) -> None:
    for _ in range(4):
        state, values = random_state(formats, rng), random_values(formats, rng, 150)
        expected = [shade(value, state, formats) for value in values.tolist()]
        assert render_core.shade_fast(values.astype(np.int32), state, formats).tolist() == [
            list(colour) for colour in expected
        ]
    words = triangle_words(formats, rng, 12)
    scalar = render_core.draw_scalar(words.tolist(), formats, state)
    assert [tuple(value) for value in render_core.draw(words, formats, state).value.tolist()] == [
        pixel.value for pixel in scalar
    ]


@pytest.mark.parametrize("formats", FORMATS.values(), ids=FORMATS)
def test_every_distance_is_in_its_interval(formats: Formats) -> None:
    """Index and fraction give the distance back: the interval's begin and so much of its length."""
    bits = formats.lane_value_bits
    full = (1 << bits) - 1
    begins = np.rint((1 - table_places(formats)) * full).astype(int)
    entries = table_entries(formats)
    for value in range(0, 1 << bits, 1 if bits < 12 else 257):
        far = power_table.distance(value, formats)
        assert far == full - value
        index, fraction = power_table.normalise(far, power_table.exponent(far), formats)
        assert index < entries
        length = 1 << max(index // 32 - 1, 0)
        assert far == begins[index] + Fraction(length * fraction, 1 << (bits - 6))


def test_interpolation_is_the_nearest_integer_exhaustively() -> None:
    """Every fraction of the tiny format, every pair of a few values: half up of the exact rational."""
    steps = 1 << (TINY.lane_value_bits - 6)
    for here in (0, 1, 2, 77, 65279, 65280, 65535):
        for there in (0, 1, 3, 76, 65280, 65534):
            for fraction in range(steps):
                exact = here + Fraction((there - here) * fraction, steps)
                got = power_table.interpolate(here | there << 16, fraction, TINY)
                assert got == (exact + Fraction(1, 2)).__floor__()


def bound(exponent: float) -> float:
    """
    Grey levels that a power may be off.

    On an interval of length h that begins at t the chord is off by h^2/8 f''(t) at most, f'' falling with t.
    h <= t/32 and h <= 1/64: the product is largest at t = 2/n, or where the last octave begins. Two roundings
    to 16 bits follow, of table and result.
    """
    n = exponent
    at = min(2 / n, 0.5)
    curvature = at**2 * n * (n - 1) * (1 - at) ** (n - 2)
    # The last interval ends one place after a cosine of 0.
    return 255 * curvature / (8 * 32**2) + 1 / 256 + 1 / 1024


@pytest.mark.parametrize("exponent", [1, 2, 3, 5, 20, 50.5, 200, 1024])
def test_power_is_within_its_bound(exponent: float) -> None:
    formats = FORMATS["default"]
    table = curve_table(power_curve(exponent), formats).astype(np.int64)
    full = (1 << 18) - 1
    values = np.arange(0, full + 1, 3)
    got = np.array([render_core._power(value, table, 18) for value in values]) / 256
    error = np.abs(got - 255 * (values / full) ** exponent)
    assert error.max() <= bound(exponent)
    assert bound(exponent) < 0.03


def test_steps_of_a_toon_curve() -> None:
    """A jump is a ramp over one interval: outside of it the steps are flat to the last bit."""
    formats = FORMATS["default"]
    table = curve_table(lambda x: np.floor(x * 4).clip(0, 3) / 3, formats)
    places = table_places(formats)
    crossed = [(a > s) != (b > s) for a, b in pairwise(places) for s in (0.25, 0.5)]
    assert sum(crossed) == 2
    for value, step in ((0.2, 0), (0.3, 1), (0.48, 1), (0.52, 2), (0.7, 2), (0.8, 3), (1.0, 3)):
        got = power_table.power_table(round(value * ((1 << 18) - 1)), table.tolist(), formats)
        assert got == step * 85 * 256


@pytest.mark.parametrize("formats", FORMATS.values(), ids=FORMATS)
def test_colour_is_the_rational_one_rounded_once(formats: Formats, rng: np.random.Generator) -> None:
    """Dropping bits below 2^-16 of a unit in each product is all that happens before the last floor."""
    state, top = random_state(formats, rng), (1 << formats.value_bits) - 1
    checked = 0
    for value in random_values(formats, rng, 300).tolist():
        used = [Fraction(factor, 1 << (18 - formats.value_bits)) for factor in factors(value, state, formats)]
        for colour, got in enumerate(shade(value, state, formats)):
            parts = [f * int(c) for f, c in zip(used, state.coefficients[:, colour], strict=True)]
            exact = (int(state.ambient[colour]) + sum(parts)) / 65536
            lowest = exact - Fraction(formats.num_channels, 65536)
            assert min(max(lowest.__floor__(), 0), top) <= got <= min(exact.__floor__(), top)
            checked += 0 < got < top
    assert checked > 20


def test_exhaustively_on_a_tiny_format() -> None:
    """Every pair of values of the tiny format against powers in float: off by the bounds, never more."""
    state = shade_state(TINY, [0.1, 0.2, 0], [[0.5, 0.3, 1], [0.4, 0, 0.7]], [power_curve(3)], gated=1)
    grid = np.stack(np.meshgrid(*[np.arange(256)] * 2, indexing="ij"), axis=-1).reshape(-1, 2)
    got = render_core.shade_fast(grid.astype(np.int32), state, TINY)
    diffuse, specular = (grid / [240, 255]).T
    power = np.where(diffuse > 0, specular**3, 0)
    weights = np.array([[0.5, 0.3, 1], [0.4, 0, 0.7]])
    exact = np.array([0.1, 0.2, 0]) + diffuse[:, None] * weights[0] + power[:, None] * weights[1]
    exact = np.clip(15 * exact, 0, 15)
    assert np.abs(got - exact).max() <= 0.5 + bound(3) * 15 / 255 + 1e-3


@pytest.mark.parametrize(
    "formats",
    [
        Formats(),
        Formats(num_channels=4, value_bits=6, frac_bits=20, with_depth=0),
        Formats(num_channels=3, value_bits=12, word_width=40, frac_bits=26),
    ],
    ids=["default", "narrow", "wide"],
)
def test_colour_mode_is_the_core_without_shade(formats: Formats, rng: np.random.Generator) -> None:
    shaded = formats.with_generics({"with_shade": 1, "num_specular": 2, "shade_guard_bits": 6})
    triangles = triangles_of(formats, rng, 28)
    plain, passed = draw(triangles, formats), draw(triangles, shaded)
    assert (plain.pixels.value[:, :3] == passed.pixels.value).all() and len(plain.pixels) > 500
    for name in ("triangle", "x", "y", "depth"):
        assert np.array_equal(getattr(plain.pixels, name), getattr(passed.pixels, name))
    assert passed.stats["clocks"] == plain.stats["clocks"] + shaded.shade_stages + 1


def test_without_shade_nothing_changes(rng: np.random.Generator) -> None:
    formats = Formats()
    assert formats.core == formats
    words = triangle_words(formats, rng, 10)
    plain, rendered = draw_fast(words, formats), render_core.draw(words, formats)
    assert rendered.clocks == plain.clocks and (rendered.value == plain.value).all()


def test_state_is_written_once_to_each_address() -> None:
    formats = FORMATS["four lights"]
    state = shade_state(formats, [1, 0, 0.5], np.eye(8)[:, :3] * 3, [power_curve(7)] * 4, gated=5)
    writes = {address: data for address, data in state.writes().tolist()}
    assert len(writes) == len(state.writes()) == 4 * 448 + 8 * 3 + 4
    assert writes[512 * 3] == state.tables[3, 0] and writes[4096 + 4 * 2 + 2] == 3 << 16
    assert writes[4128] == (255 << 16) + (1 << 15) and writes[4131] == 5 << 8
    assert dict(colour_state(formats).writes().tolist())[4131] == 15


def test_a_state_is_read_back_from_its_registers() -> None:
    formats = FORMATS["four lights"]
    state = shade_state(formats, [1, 0, 0.5], np.eye(8)[:, :3] * 3, [power_curve(7)] * 4, gated=5)
    again = ShadeState.from_registers(dict(state.writes().tolist()), formats)
    assert (again.gated, again.linear, again.guard_bits) == (5, 0, 0)
    for name in ("ambient", "coefficients", "tables"):
        assert np.array_equal(getattr(again, name), getattr(state, name)), name
    colour = colour_state(formats)
    assert (colour.gated, colour.linear, colour.guard_bits) == (0, 15, 0)
    again = ShadeState.from_registers(dict(colour.writes().tolist()), formats)
    assert (again.gated, again.linear) == (0, 15) and not again.tables.any()


def test_an_error_in_a_channel_is_multiplied_by_coefficient_and_slope() -> None:
    formats = Formats(with_shade=1, num_channels=3, num_specular=2, with_depth=0)
    curves = [lambda cosine: cosine, lambda cosine: np.where(cosine > 0.5, 2 * cosine - 1, 0.0)]
    state = shade_state(formats, [0, 0, 0], [[0.5, 2, 0], [1, 0, 0], [0, 0, 3]], curves)
    gains = channel_gains(state, formats)
    steepest = []
    for words in state.tables.tolist():
        # An interval of octave n is 2**n parts of the lane's range; the last one is cut at a cosine of 0.
        rises = [abs((word >> 16) - (word & 0xFFFF)) / (255 << 8) for word in words[:-1]]
        parts = [1 << max(index // 32 - 1, 0) for index in range(len(rises))]
        top = (1 << formats.lane_value_bits) - 1
        steepest.append(max(rise * top / part for rise, part in zip(rises, parts, strict=True)))
    assert gains == pytest.approx([2.0, steepest[0], 3 * steepest[1]], rel=1e-9)
    assert steepest[0] >= 1 and steepest[1] >= 2
    linear = replace(state, linear=0b10)
    assert channel_gains(linear, formats).tolist() == [gains[0], gains[1], 3.0]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([0, 0, 0], [[4, 0, 0], [0, 0, 0]], [power_curve(2)]), "not in 0 .. 4"),
        (([0, 0, 0], [[-0.1, 0, 0], [0, 0, 0]], [power_curve(2)]), "not in 0 .. 4"),
        (([0, 0, 0], [[1, 0, 0]], [power_curve(2)]), "colours of 1 channels and 1 curves for 2 channels"),
        (([0, 0, 0], [[1, 0, 0]] * 2, [power_curve(2)] * 2), "2 curves for 2 channels, 1 of them specular"),
        (([0, 0, 0], [[1, 0, 0]] * 2, [lambda x: 2 * x]), "the specular curve leaves 0 .. 1"),
        (([0, 0, 0], [[1, 0, 0]] * 2, [lambda x: x * np.nan]), "the specular curve leaves 0 .. 1"),
    ],
)
def test_what_the_unit_cannot_hold_is_refused(arguments: tuple, message: str) -> None:
    with pytest.raises(QuadshadeError, match=message):
        shade_state(FORMATS["default"], *arguments)


def test_ambient_light_is_clipped_to_what_is_shown() -> None:
    """As much less than none is none, and more than white is white."""
    made = [shade_state(TINY, ambient, [[0.5, 0.3, 1], [0.4, 0, 0.7]], [power_curve(3)]).ambient.tolist()
            for ambient in ([-0.25, 0, 1.5], [0, 0, 1])]  # fmt: skip
    assert made[0] == made[1]


@pytest.mark.parametrize(
    "generics",
    [
        {"num_channels": 2, "num_specular": 3},
        {"num_specular": 0},
        {"shade_guard_bits": 11},
        {"value_bits": 15, "shade_guard_bits": 3, "word_width": 48},
        {"shade_guard_bits": 10, "frac_bits": 9},
    ],
    ids=str,
)
def test_generics_out_of_range_are_refused(generics: dict[str, int]) -> None:
    with pytest.raises(QuadshadeError, match="generic .* is"):
        Formats(with_shade=1).with_generics(generics)
    Formats().with_generics({name: value for name, value in generics.items() if name != "frac_bits"})
