# SPDX-License-Identifier: Apache-2.0
"""The framebuffer against a loop over the pixels, one at a time."""

from __future__ import annotations

import numpy as np
import pytest

from quadshade.contract.triangles import Pixels
from quadshade.errors import QuadshadeError
from quadshade.image import paint, read_picture, resolve, visible, write_png


def random_pixels(rng, depth: bool, count: int = 600, channels: int = 3) -> Pixels:
    x, y = rng.integers(0, 7, count), rng.integers(0, 5, count)
    return Pixels(
        np.arange(count, dtype=np.int32),
        x.astype(np.int32),
        y.astype(np.int32),
        rng.integers(0, 256, (count, channels)).astype(np.int32),
        rng.integers(0, 9, count).astype(np.int32) if depth else None,
    )


@pytest.mark.parametrize("depth", [True, False])
def test_the_nearest_pixel_wins_then_the_first_or_the_last_without_depth(rng, depth):
    pixels = random_pixels(rng, depth)
    expected = np.full((6, 8), -1)
    for index, (x, y) in enumerate(zip(pixels.x, pixels.y, strict=True)):
        if not depth or expected[y, x] < 0 or pixels.depth[index] < pixels.depth[expected[y, x]]:
            expected[y, x] = index
    assert np.array_equal(visible(pixels, 8, 6), expected)
    picture = resolve(pixels, 8, 6, (9, 8, 7))
    assert (picture[expected < 0] == (9, 8, 7)).all()
    assert np.array_equal(picture[expected >= 0], pixels.value[expected[expected >= 0]])


def test_nothing_drawn_is_all_background(rng):
    assert (resolve(random_pixels(rng, True, 0), 3, 2, (1, 2, 3)) == (1, 2, 3)).all()


def test_a_pixel_outside_is_refused(rng):
    with pytest.raises(QuadshadeError, match="outside"):
        visible(random_pixels(rng, True), 6, 5)


def test_values_are_scaled_to_eight_bits():
    shown = np.arange(3).reshape(1, 3)
    assert paint(shown, np.array([[0, 15, 7]] * 3), (0, 0, 0), 15)[0, 0].tolist() == [0, 255, 119]
    assert paint(shown, np.array([[0.4, 0.6, 300.0]] * 3), (0, 0, 0))[0, 0].tolist() == [0, 1, 255]
    assert paint(shown, np.array([[5], [6], [7]]), (0, 0, 0))[0].tolist() == [[5] * 3, [6] * 3, [7] * 3]


def test_a_picture_survives_its_file(tmp_path, rng):
    picture = rng.integers(0, 256, (5, 9, 3)).astype(np.uint8)
    write_png(tmp_path / "a.png", picture)
    assert np.array_equal(read_picture(tmp_path / "a.png"), picture)
