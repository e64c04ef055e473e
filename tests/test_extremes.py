# SPDX-License-Identifier: Apache-2.0
"""Numbers at the extremes: drawn by the golden model, exact in coverage and within the bound, or refused."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from click.testing import CliRunner

from quadshade.choices import MAX_ERROR
from quadshade.cli.main import main
from quadshade.contract.formats import Formats
from quadshade.contract.triangles import Pixels, ScreenTriangles
from quadshade.engine import draw
from quadshade.errors import QuadshadeError
from quadshade.files.triangle_file import write_triangles
from quadshade.setup import divide_primitives
from quadshade.setup.triangle_setup import setup_triangles
from quadshade.shading.reference import interpolated
from tests.support.setup_reference import exact_quadratic, half_plane_pixels, screen_triangles

LOW = Formats(num_channels=1, with_depth=0, frac_bits=12)


def keys(triangle: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Sorted numbers, one a pixel of a triangle."""
    return np.sort((np.asarray(triangle, np.int64) << 28) | (np.asarray(y, np.int64) << 14) | x)


def assert_covers(pixels: Pixels, triangles: ScreenTriangles, formats: Formats) -> None:
    """Every triangle covers what half-planes in exact integers do, each pixel once."""
    wanted = half_plane_pixels(triangles.vertices, triangles.width, triangles.height, formats.subpixel_bits)
    assert np.array_equal(keys(pixels.triangle, pixels.x, pixels.y), keys(*wanted.T))


def assert_exact(
    triangles: ScreenTriangles, formats: Formats, most: int = 60, limit: float | None = MAX_ERROR
) -> None:
    """Coverage exact, and some pixels of every triangle within 1/2 + bound of the exact quadratic."""
    drawing = draw(triangles, formats, limit=limit)
    pixels = drawing.pixels
    assert_covers(pixels, triangles, formats)
    bound = Fraction(drawing.stats["bound"])
    assert limit is None or bound <= Fraction(limit) * (1 + Fraction(1, 1 << 19))
    top, scale = Fraction((1 << formats.value_bits) - 1), 1 << formats.subpixel_bits
    for triangle in np.unique(pixels.triangle):
        own = np.flatnonzero(pixels.triangle == triangle)
        for index in np.unique(own[np.linspace(0, len(own) - 1, min(most, len(own))).astype(int)]):
            exact = exact_quadratic(triangles.vertices[triangle], triangles.samples[triangle, 0], 2)
            place = (Fraction(scale * (2 * int(axis[index]) + 1), 2) for axis in (pixels.x, pixels.y))
            want = min(max(exact(*place), Fraction(0)), top)
            off = abs(int(pixels.value[index, 0]) - want)
            assert off <= Fraction(1, 2) + bound, (triangle, index, float(off), float(bound))


def harsh(rng: np.random.Generator, vertices: object, formats: Formats, size: int) -> ScreenTriangles:
    """Triangles whose samples jump between 0 and full scale: the steepest gradients there are."""
    vertices = np.array(vertices, np.int64)
    top = (1 << formats.value_bits) - 1
    samples = rng.integers(0, 2, (len(vertices), formats.num_channels, 6)) * float(top)
    samples[:, :, 0], samples[:, :, 3] = 0.0, top
    return screen_triangles(vertices, formats, size, size, samples)


FORMATS = {
    "default": Formats(num_channels=1, with_depth=0),
    "tiny": Formats(num_channels=1, with_depth=0, coord_bits=3, subpixel_bits=0),
    "fine": Formats(num_channels=1, with_depth=0, coord_bits=9, subpixel_bits=12),
    "short": Formats(num_channels=1, with_depth=0, word_width=16, frac_bits=6),
    "long": Formats(num_channels=1, with_depth=0, word_width=60, frac_bits=44, value_bits=12),
}


@pytest.mark.parametrize("name", FORMATS)
def test_huge_triangles_to_the_guard_bands_corners(name, rng):
    """Three screens wide and high, vertices at the formats' limits, gradients over all of it."""
    formats = FORMATS[name]
    low, high = formats.guard_band
    middle = (low + high) // 2
    corners = [
        [(low, low), (high, low), (low, high)],
        [(high, high), (low, high), (high, low)],
        [(low, middle), (high, low), (high, high)],
        [(middle, high), (low, low), (high, low + 1)],
    ]
    assert_exact(harsh(rng, corners, formats, min(1 << formats.coord_bits, 100)), formats, 30)


@pytest.mark.parametrize("name", FORMATS)
def test_needles_across_everything(name, rng):
    """Slivers of a sub-pixel's width from one end of the guard band to the other, at every slope."""
    formats = FORMATS[name]
    low, high = formats.guard_band
    size = min(1 << formats.coord_bits, 300)
    ends = rng.integers(low, high + 1, (12, 2, 2))
    ends[::3] = rng.integers(0, size << formats.subpixel_bits, (4, 2, 2))
    ends[1, :, 1], ends[2, :, 0] = (1 << formats.subpixel_bits) // 2, size << formats.subpixel_bits >> 1
    thin = ends[:, 1:] + rng.choice([-1, 1], (12, 1, 2))
    vertices = np.clip(np.concatenate([ends, thin], axis=1), low, high)
    assert_exact(harsh(rng, vertices, formats, size), formats)


@pytest.mark.parametrize("name", FORMATS)
def test_registers_wrap_and_pixels_do_not_notice(name, rng):
    """Triangles of a few sub-pixels round a pixel's centre: steps far beyond the word, values within it."""
    formats = FORMATS[name]
    pixel = 1 << formats.subpixel_bits
    centre = rng.integers(0, 8, (100, 1, 2)) * pixel + pixel // 2
    reach = max(pixel // 64, 1)
    vertices = centre + rng.integers(-reach, reach + 1, (100, 3, 2))
    triangles = harsh(rng, vertices, formats, 8)
    assert_exact(triangles, formats)
    if pixel > 64:
        assert len(setup_triangles(triangles, formats)) > 2
        per_pixel = (2.0**formats.value_bits - 1) * pixel / reach * 2.0**formats.frac_bits
        assert per_pixel > 2.0 ** (formats.word_width - 1)


def test_the_last_pixel_of_the_largest_screen(rng):
    formats = Formats(num_channels=1, with_depth=0, coord_bits=13)
    far = (1 << 13) * 256
    vertices = [
        [(far - 700, far - 900), (far, far - 512), (far - 256, far + 700)],
        [(far - 512, 0), (far, 0), (far, 700)],
        [(2 * far - 1, far - 300), (far - 900, far - 256), (2 * far - 1, far + 300)],
    ]
    triangles = harsh(rng, vertices, formats, 1 << 13)
    drawing = draw(triangles, formats)
    assert drawing.pixels.x.max() == drawing.pixels.y.max() == (1 << 13) - 1
    reference = interpolated(triangles, drawing.pixels.triangle, drawing.pixels.x, drawing.pixels.y, formats)
    assert np.abs(drawing.pixels.value - reference).max() <= 0.5 + drawing.stats["bound"] + 1e-6


def test_what_cannot_be_drawn_is_refused(rng):
    formats = FORMATS["default"]
    low, high = formats.guard_band
    for beyond in (low - 1, high + 1, 2**40, -(2**62)):
        triangles = harsh(rng, [[(0, 0), (beyond, 0), (0, 2560)]], formats, 100)
        with pytest.raises(QuadshadeError, match="triangle out of range"):
            draw(triangles, formats)
    inside = np.array([[(0, 0), (2560, 0), (0, 2560)]])
    for size in (0, (1 << formats.coord_bits) + 1):
        triangles = screen_triangles(inside, formats, 100, 100)
        triangles.width = size
        with pytest.raises(QuadshadeError, match="screen of"):
            draw(triangles, formats)
    for wrong in (np.nan, np.inf, -0.001, 255.001):
        triangles = screen_triangles(inside, formats, 100, 100, np.full((1, 1, 6), wrong))
        with pytest.raises(QuadshadeError, match="sample outside"):
            draw(triangles, formats)


def grid(rng: np.random.Generator, cells: int, size: int) -> np.ndarray:
    """(n, 3, 2) a mesh of shaken squares, two triangles each, in sub-pixels."""
    line = np.linspace(0, size * 256, cells + 1).astype(np.int64)
    points = np.stack(np.meshgrid(line, line), axis=-1)
    points[1:-1, 1:-1] += rng.integers(-size * 20 // cells, size * 20 // cells, (cells - 1, cells - 1, 2))
    a, b, c, d = points[:-1, :-1], points[:-1, 1:], points[1:, :-1], points[1:, 1:]
    both = np.stack([np.stack([a, b, c], axis=2), np.stack([b, d, c], axis=2)], axis=2)
    return both.reshape(-1, 3, 2)


@pytest.mark.parametrize("rounding", ["joint", "independent"])
@pytest.mark.parametrize("bits", [6, 11])
def test_division_is_watertight_and_keeps_the_polynomial(bits, rounding, rng):
    """Every pixel of a mesh once, by its own triangle, within 1/2 + 1/2 of the undivided float quadratic."""
    formats = Formats(num_channels=1, with_depth=1, frac_bits=bits)
    vertices = grid(rng, 2, 500)
    triangles = screen_triangles(vertices, formats, 500, 500, rng.uniform(0, 255, (len(vertices), 1, 6)))
    triangles.depth = rng.uniform(0, 65535, (len(vertices), 3))
    whole = draw(triangles, formats, rounding=rounding, limit=None)
    parts = draw(triangles, formats, rounding=rounding)
    assert whole.stats["bound"] > MAX_ERROR >= parts.stats["bound"] * 0.999
    assert parts.stats["packets"] > whole.stats["packets"]
    pixels = parts.pixels
    assert_covers(pixels, triangles, formats)
    assert np.array_equal(np.sort(pixels.y * 500 + pixels.x), np.arange(500 * 500))
    reference = interpolated(triangles, pixels.triangle, pixels.x, pixels.y, formats)
    assert np.abs(pixels.value - reference).max() <= 0.5 + parts.stats["bound"] + 1e-6
    assert np.abs(whole.pixels.value - interpolated(
        triangles, whole.pixels.triangle, whole.pixels.x, whole.pixels.y, formats
    )).max() > 1  # fmt: skip
    order, other = (np.lexsort((p.x, p.y)) for p in (pixels, whole.pixels))
    assert np.abs(pixels.depth[order] - whole.pixels.depth[other]).max() <= 1


def test_only_what_exceeds_the_limit_is_divided(rng):
    vertices = np.array([[[0, 0], [900, 100], [200, 950]], [[10, 10], [40, 12], [20, 44]]]) * 256
    triangles = screen_triangles(vertices, LOW, 1000, 1000, rng.uniform(0, 255, (2, 1, 6)))
    whole = setup_triangles(triangles, LOW)
    parts = setup_triangles(triangles, LOW, limit=MAX_ERROR)
    assert (parts.triangle == 0).sum() > 1 == (parts.triangle == 1).sum()
    assert np.array_equal(parts.words[parts.triangle == 1], whole.words[whole.triangle == 1])
    assert (np.diff(parts.triangle) >= 0).all()
    fine = Formats(num_channels=1, with_depth=0)
    for name in ("words", "bound", "triangle"):
        pair = (getattr(setup_triangles(triangles, fine, limit=level), name) for level in (None, MAX_ERROR))
        assert np.array_equal(*pair)


def test_strict_refuses_and_names_the_bound(rng, tmp_path):
    vertices = np.array([[[0, 0], [900, 100], [200, 950]]]) * 256
    triangles = screen_triangles(vertices, LOW, 1000, 1000, rng.uniform(0, 255, (1, 1, 6)))
    bound = setup_triangles(triangles, LOW).bound[0, 0]
    with pytest.raises(QuadshadeError, match=f"may be {bound:.3g} grey levels off, more than 0.5"):
        draw(triangles, LOW, strict=True)
    assert draw(triangles, LOW, strict=True, limit=bound * 1.01).stats["packets"] == 1

    path = tmp_path / "a.json"
    write_triangles(path, triangles, LOW)
    arguments = ["raster", str(path), "-o", str(tmp_path / "a.npz"), "--generic", "frac_bits=12"]
    refused = CliRunner().invoke(main, [*arguments, "--strict"])
    assert refused.exit_code == 2 and "grey levels off" in refused.output
    assert CliRunner().invoke(main, [*arguments, f"--strict={bound * 1.01}"]).exit_code == 0
    assert CliRunner().invoke(main, arguments).exit_code == 0


def test_a_limit_below_the_words_last_place_is_refused(rng):
    """No part is small enough where the fraction itself is coarser than the limit."""
    triangles = screen_triangles(
        np.array([[[0, 0], [9, 1], [2, 9]]]) * 256, LOW, 10, 10, rng.uniform(0, 255, (1, 1, 6))
    )
    with pytest.raises(QuadshadeError, match="no part of it is within 1e-05 grey levels of exact"):
        draw(triangles, LOW, limit=1e-5)
    whole = Formats(num_channels=1, with_depth=0, frac_bits=0)
    with pytest.raises(QuadshadeError, match="within 0.5 grey levels of exact with 0 fraction bits"):
        draw(triangles, whole)
    triangles.orders[:] = 0
    assert draw(triangles, whole).stats["bound"] <= 0.5 * (1 + 2**-20)


def test_division_in_chunks_is_division_at_once(rng, monkeypatch):
    vertices = np.array([[[0, 0], [400, 100], [200, 450]], [[10, 300], [440, 12], [420, 444]]]) * 256
    coarse = Formats(num_channels=1, with_depth=0, frac_bits=5)
    triangles = screen_triangles(vertices, coarse, 450, 450, rng.uniform(0, 255, (2, 1, 6)))
    once = setup_triangles(triangles, coarse, limit=MAX_ERROR)
    monkeypatch.setattr(divide_primitives, "CHUNK", 3)
    parts = setup_triangles(triangles, coarse, limit=MAX_ERROR)
    assert len(parts) == len(once) > 100
    for primitives in (once, parts):
        assert (np.diff(primitives.triangle) >= 0).all()
        assert (np.diff(primitives.header["y"])[np.diff(primitives.triangle) == 0] >= 0).all()
    rows = [np.unique(one.words[:, 0], axis=0) for one in (once, parts)]
    assert np.array_equal(*rows)


def test_fractional_stepping_is_not_divided(rng):
    vertices = np.array([[[0, 0], [900, 100], [200, 950]]]) * 256
    triangles = screen_triangles(vertices, LOW, 1000, 1000, rng.uniform(0, 255, (1, 1, 6)))
    assert draw(triangles, LOW, fractional=True).stats["packets"] == 1
    with pytest.raises(QuadshadeError, match="grey levels off"):
        draw(triangles, LOW, fractional=True, strict=True)


@pytest.mark.parametrize("name", ["short", "default", "fine"])
def test_the_vhdl_draws_the_extremes_alike(name, rng):
    """Divided, huge, thin and wrapping triangles in one drawing, every pixel and clock in GHDL."""
    formats = FORMATS[name]
    low, high = formats.guard_band
    pixel, size = 1 << formats.subpixel_bits, 48
    vertices = [
        [(low, low), (high, low), (low, high)],
        [(0, 0), (size * pixel, pixel), (3 * pixel, size * pixel)],
        [(low, low + 1), (high, high), (high - 1, high)],
        [(pixel // 2 - 2, pixel // 2 - 2), (pixel // 2 + 3, pixel // 2), (pixel // 2, pixel // 2 + 3)],
    ]
    triangles = harsh(rng, vertices, formats, size)
    model, vhdl = draw(triangles, formats), draw(triangles, formats, "ghdl")
    for part in ("triangle", "x", "y", "value"):
        assert np.array_equal(getattr(model.pixels, part), getattr(vhdl.pixels, part)), part
    assert model.stats["clocks"] == vhdl.stats["clocks"]
    assert (model.stats["packets"] > 4) == (name == "short")
