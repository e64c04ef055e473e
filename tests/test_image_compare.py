# SPDX-License-Identifier: Apache-2.0
"""Measures of two pictures against values worked out by hand, and the heat map by its colours."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib import colormaps

from quadshade.errors import QuadshadeError
from quadshade.image import compare, read_picture, write_heatmap


def test_one_wrong_channel_of_one_pixel():
    one = np.full((10, 20, 3), 100, dtype=np.uint8)
    other = one.copy()
    other[3, 7, 1] = 130
    result = compare(one, other)
    assert result.psnr == pytest.approx(10 * np.log10(255**2 / (900 / 600)))
    assert (result.largest_error, result.largest_at) == (30, (7, 3))
    assert (result.differing, result.pixels) == (1, 200)
    assert 0 < result.ssim < 1
    assert compare(other, one) == result


def test_black_against_white_and_identical_pictures():
    black, white = np.zeros((8, 8, 3), dtype=np.uint8), np.full((8, 8, 3), 255, dtype=np.uint8)
    opposite, same = compare(black, white), compare(white, white)
    assert opposite.psnr == 0 and opposite.largest_error == 255 and opposite.ssim < 0.001
    assert same.psnr == float("inf") and same.largest_error == 0 and same.ssim == pytest.approx(1)


def test_a_picture_under_the_window_has_no_similarity():
    small = np.zeros((6, 60, 3), dtype=np.uint8)
    assert compare(small, small).ssim is None


def test_pictures_of_two_sizes_are_refused():
    with pytest.raises(QuadshadeError, match="4x3 and 3x4"):
        compare(np.zeros((3, 4, 3), dtype=np.uint8), np.zeros((4, 3, 3), dtype=np.uint8))


def test_the_heat_map_shows_the_error_and_a_legend(tmp_path):
    one = np.zeros((40, 40, 3), dtype=np.uint8)
    other = one.copy()
    other[:20, :, 2] = 80
    write_heatmap(tmp_path / "heat.png", one, other)
    picture = read_picture(tmp_path / "heat.png").reshape(-1, 3).astype(int)
    for value in (0.0, 1.0):
        colour = np.round(np.array(colormaps["inferno"](value)[:3]) * 255)
        assert (np.abs(picture - colour).max(axis=1) <= 1).mean() > 0.2
    assert len(np.unique(picture, axis=0)) > 200
