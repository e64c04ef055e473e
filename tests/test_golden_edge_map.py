# SPDX-License-Identifier: Apache-2.0
"""The edge map's integers against exact fractions and the float formulas, whole formats if small."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from quadshade.errors import QuadshadeError
from quadshade.golden.screen.edge_map import (
    DIAGONAL,
    EIGHT,
    diagonal_intensity,
    edge_map,
    edge_map_scalar,
    eight_intensity,
    normal_intensity,
)
from tests.support.edge_map_reference import EDGE_ERROR, edge_intensity


def random_g_buffer(
    rng: np.random.Generator, height: int, width: int, bits: int
) -> tuple[np.ndarray, np.ndarray]:
    """Encoded normals and depth; a third of the pixels at the ends of their range."""
    normal = rng.integers(0, 256, (height, width, 3))
    depth = rng.integers(0, 1 << bits, (height, width))
    ends = rng.random((height, width)) < 0.3
    normal[ends] = 255 * rng.integers(0, 2, (ends.sum(), 3))
    depth[ends] = ((1 << bits) - 1) * rng.integers(0, 2, ends.sum())
    return normal.astype(np.uint8), depth


@pytest.mark.parametrize("variant", [DIAGONAL, EIGHT])
@pytest.mark.parametrize("bits", [8, 11, 15, 16])
def test_numpy_is_the_scalar_one(rng: np.random.Generator, bits: int, variant: int) -> None:
    for height, width in ((1, 3), (2, 5), (7, 9), (40, 41)):
        normal, depth = random_g_buffer(rng, height, width, bits)
        pixels = np.dstack([normal.astype(int), depth]).reshape(-1, 4).tolist()
        expected = edge_map_scalar(pixels, width, height, bits, variant)
        got = np.dstack(edge_map(normal, depth, bits, variant)).reshape(-1, 2)
        assert [tuple(pixel) for pixel in got.tolist()] == expected


@pytest.mark.parametrize("variant", [DIAGONAL, EIGHT])
@pytest.mark.parametrize("bits", [8, 9, 13, 16])
def test_error_of_the_float_formulas_is_bounded(rng: np.random.Generator, bits: int, variant: int) -> None:
    normal, depth = random_g_buffer(rng, 90, 110, bits)
    exact = edge_intensity(normal / 255, depth / ((1 << bits) - 1), variant)
    for got, wanted in zip(edge_map(normal, depth, bits, variant), exact, strict=True):
        assert np.abs(got - 255 * wanted).max() <= EDGE_ERROR


def test_normal_intensity_of_every_sum() -> None:
    for dots in (*range(-400_000, 400_000, 7), -1, 0, 1, 254, 255, 256, 130_049, 130_050, 390_150):
        exact = min(max(Fraction(dots, 510), 0), 255)
        assert abs(normal_intensity(dots) - exact) <= Fraction(EDGE_ERROR)


def test_diagonal_intensity_of_every_pair_of_differences() -> None:
    for fall in range(256):
        for rise in range(0, 256, 3):
            exact = 255 * (1 - Fraction(fall, 510)) ** 2 * (1 - Fraction(rise, 510)) ** 2
            assert abs(diagonal_intensity(fall, rise, 8) - exact) <= Fraction(EDGE_ERROR)


@pytest.mark.parametrize("bits", [8, 12, 16])
def test_eight_intensity_of_every_sum(bits: int) -> None:
    full = (1 << bits) - 1
    for total in range(0, 12 * full + 1, max(full // 900, 1)):
        exact = min(Fraction(255 * total, 8 * full), 255)
        assert abs(eight_intensity(total, bits) - exact) <= Fraction(EDGE_ERROR)


def test_flat_has_no_edge_and_a_step_has() -> None:
    normal = np.full((5, 8, 3), (128, 128, 255), dtype=np.uint8)
    depth = np.where(np.arange(8) < 4, 10, 200) * np.ones((5, 1), dtype=int)
    diagonal, eight = edge_map(normal, depth)[1], edge_map(normal, depth, variant=EIGHT)[1]
    edge = np.isin(np.arange(8), (3, 4))
    assert (diagonal[:, ~edge] == 255).all() and (diagonal[:, edge] < 100).all()
    assert (eight[:, ~edge] == 0).all() and (eight[:, edge] > 80).all()
    assert (edge_map(normal, depth)[0] == 255).all()


def test_bad_input_is_refused() -> None:
    normal, depth = np.zeros((4, 4, 3), np.uint8), np.zeros((4, 4), int)
    with pytest.raises(QuadshadeError, match="no G-buffer"):
        edge_map(normal[:, :2], depth[:, :2])
    with pytest.raises(QuadshadeError, match="no G-buffer"):
        edge_map(normal[:3], depth)
    with pytest.raises(QuadshadeError, match="depth_bits 7"):
        edge_map(normal, depth, 7)
    with pytest.raises(QuadshadeError, match="does not fit in 8 bits"):
        edge_map(normal, depth + 256)
