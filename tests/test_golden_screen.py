# SPDX-License-Identifier: Apache-2.0
"""The models behind the pixel stream against something else: the host's own resolving, zlib, loops."""

from __future__ import annotations

import zlib

import numpy as np
import pytest

from quadshade.contract.triangles import Pixels
from quadshade.errors import QuadshadeError
from quadshade.golden.screen.depth_test import DepthTest, empty_depths, kept_pixels
from quadshade.golden.screen.framebuffer import Framebuffer, draw_pixels
from quadshade.golden.screen.read_out import Area, read_area, read_out
from quadshade.image.visible import resolve, visible

WIDTH, HEIGHT, DEPTH_BITS = 9, 5, 4


def random_stream(rng: np.random.Generator, count: int, beyond: int = 0) -> tuple[np.ndarray, ...]:
    """x, y and depth of pixels, some of them outside the screen."""
    x, y = rng.integers(0, WIDTH + beyond, count), rng.integers(0, HEIGHT + beyond, count)
    return x, y, rng.integers(0, 1 << DEPTH_BITS, count)


def test_last_kept_pixel_of_a_place_is_what_the_host_shows(rng: np.random.Generator) -> None:
    for count in (0, 1, 30, 2000):
        x, y, depth = random_stream(rng, count)
        kept = np.flatnonzero(kept_pixels(x, y, depth, empty_depths(WIDTH, HEIGHT, DEPTH_BITS)))
        shown = np.full((HEIGHT, WIDTH), -1)
        for index in kept:
            shown[y[index], x[index]] = index
        value = np.zeros((count, 1), dtype=np.int32)
        pixels = Pixels(np.zeros(count, np.int32), x, y, value, depth)
        assert np.array_equal(shown, visible(pixels, WIDTH, HEIGHT))


def test_compiled_z_buffer_is_the_scalar_one(rng: np.random.Generator) -> None:
    model, stored = DepthTest(WIDTH, HEIGHT, DEPTH_BITS), empty_depths(WIDTH, HEIGHT, DEPTH_BITS)
    for _ in range(3):
        x, y, depth = random_stream(rng, 300, beyond=2)
        expected = [model.test(*pixel) for pixel in zip(x.tolist(), y.tolist(), depth.tolist(), strict=True)]
        assert kept_pixels(x, y, depth, stored).tolist() == expected
        assert stored.ravel().tolist() == model.stored


def test_farthest_depth_is_drawn_where_nothing_was() -> None:
    model = DepthTest(1, 1, 2)
    assert [model.test(0, 0, depth) for depth in (3, 3, 2, 2)] == [True, False, True, False]
    model.clear()
    assert model.test(0, 0, 3)


def test_negative_coordinates_are_refused() -> None:
    with pytest.raises(QuadshadeError, match="negative coordinate"):
        kept_pixels(np.array([-1]), np.array([0]), np.array([0]), empty_depths(2, 2, 4))


@pytest.mark.parametrize("with_depth", [True, False])
def test_framebuffer_holds_the_hosts_picture(rng: np.random.Generator, with_depth: bool) -> None:
    background = (10, 20, 30)
    x, y, depth = random_stream(rng, 500)
    value = rng.integers(0, 256, (500, 3)).astype(np.int32)
    pixels = Pixels(np.zeros(500, np.int32), x, y, value, depth if with_depth else None)
    picture = draw_pixels(x, y, value, pixels.depth, WIDTH, HEIGHT, DEPTH_BITS, background)
    assert np.array_equal(picture, resolve(pixels, WIDTH, HEIGHT, background))


@pytest.mark.parametrize("with_depth", [True, False])
def test_compiled_framebuffer_is_the_scalar_one(rng: np.random.Generator, with_depth: bool) -> None:
    x, y, depth = random_stream(rng, 400, beyond=3)
    value = rng.integers(0, 256, (400, 1))
    test, model = DepthTest(WIDTH, HEIGHT, DEPTH_BITS), Framebuffer(WIDTH, HEIGHT, clear_value=7)
    for pixel in zip(x.tolist(), y.tolist(), depth.tolist(), value[:, 0].tolist(), strict=True):
        if not with_depth or test.test(*pixel[:3]):
            model.write(*pixel[:2], pixel[3])
    picture = draw_pixels(x, y, value, depth if with_depth else None, WIDTH, HEIGHT, DEPTH_BITS, (7,))
    assert picture.ravel().tolist() == model.words


@pytest.mark.parametrize("channels", [1, 3])
def test_areas_bytes_and_crc(rng: np.random.Generator, channels: int) -> None:
    picture = rng.integers(0, 256, (HEIGHT, WIDTH, channels)).astype(np.uint8)
    flat = picture.reshape(-1, channels).tolist()
    words = [int.from_bytes(bytes(pixel), "little") for pixel in flat]
    whole = Area(0, 0, WIDTH, WIDTH * HEIGHT)
    assert read_area(picture, whole) == (picture.tobytes(), zlib.crc32(picture.tobytes()))
    areas = [whole, Area(0, 0, 0, 1), Area(1, 0, WIDTH, 1), Area(0, HEIGHT, 1, 1), Area(0, HEIGHT - 1, 3, 90)]
    for _ in range(60):
        x, y, width = (int(rng.integers(limit)) for limit in (WIDTH, HEIGHT, WIDTH + 1))
        areas.append(Area(x, y, width, int(rng.integers(WIDTH * HEIGHT))))
    for area in areas:
        values, crc = read_out(words, WIDTH, HEIGHT, area, channels)
        data = b"".join(value.to_bytes(channels, "little") for value in values)
        assert read_area(picture, area) == (data, crc)
