# SPDX-License-Identifier: Apache-2.0
"""A cartoon's tones: smooth borders, no specks, and an outline that stays."""

from __future__ import annotations

import numpy as np

from quadshade.style import smooth_tones


def two_tones() -> tuple[np.ndarray, np.ndarray]:
    """A disc of two tones on white, and where it is."""
    y, x = np.mgrid[:40, :40]
    covered = (x - 20) ** 2 + (y - 20) ** 2 < 17**2
    picture = np.full((40, 40, 3), 255, np.uint8)
    picture[covered] = (40, 60, 100)
    picture[covered & (x + 2 * y > 60)] = (80, 120, 200)
    return picture, covered


def test_borders_between_tones_become_ramps_and_the_outline_stays() -> None:
    picture, covered = two_tones()
    smooth = smooth_tones(picture, covered)
    assert (smooth[~covered] == 255).all()
    between = covered & (smooth[..., 2] > 100) & (smooth[..., 2] < 200)
    assert between.sum() > 30
    # Nothing of the background's white gets into the disc.
    assert smooth[covered].max() == 200 and smooth[covered].min() == 40
    # Far from the border both tones are as they were.
    assert smooth[8, 20].tolist() == [40, 60, 100] and smooth[32, 22].tolist() == [80, 120, 200]


def test_specks_vanish() -> None:
    picture, covered = two_tones()
    speckled = picture.copy()
    speckled[12:14, 18:21] = (80, 120, 200)
    assert (smooth_tones(speckled, covered) == smooth_tones(picture, covered)).all()


def test_a_thin_shape_keeps_its_tone_and_nothing_stays_nothing() -> None:
    picture = np.full((9, 9, 3), 255, np.uint8)
    covered = np.zeros((9, 9), bool)
    assert (smooth_tones(picture, covered) == 255).all()
    covered[4] = True
    picture[4] = (10, 20, 30)
    assert (smooth_tones(picture, covered) == picture).all()
