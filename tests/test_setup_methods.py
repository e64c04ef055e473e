# SPDX-License-Identifier: Apache-2.0
"""The literature's set-up methods against exact rational arithmetic."""

from __future__ import annotations

from fractions import Fraction
from math import isqrt

import numpy as np
import pytest

from quadshade.errors import QuadshadeError
from quadshade.setup.literature.kernels import METHODS, coefficients, edge_factors
from quadshade.setup.literature.methods import FITS, fit

EDGES = ((0, 1), (0, 2), (1, 2))
LIGHT = np.array([0.36, 0.48, 0.80])
TOLERANCE = 1e-9
"""Of the largest coefficient; Abbas et al.'s quotients of sixth powers lose most."""


def solve(rows: list[list[Fraction]], right: list[Fraction]) -> list[Fraction]:
    """A linear system by elimination, exactly."""
    rows = [[*row, value] for row, value in zip(rows, right, strict=True)]
    for column in range(len(rows)):
        pivot = next(index for index in range(column, len(rows)) if rows[index][column])
        rows[column], rows[pivot] = rows[pivot], rows[column]
        rows[column] = [entry / rows[column][column] for entry in rows[column]]
        for index in range(len(rows)):
            if index != column and rows[index][column]:
                factor = rows[index][column]
                rows[index] = [a - factor * b for a, b in zip(rows[index], rows[column], strict=True)]
    return [row[-1] for row in rows]


def quadratic(vertices: np.ndarray, samples: list[Fraction]) -> np.ndarray:
    """T0 to T5 through six samples: Barrera et al., equation 8, solved in rationals."""
    corners = [tuple(Fraction(float(c)) for c in vertex - vertices[0]) for vertex in vertices]
    places = corners + [
        tuple((a + b) / 2 for a, b in zip(corners[i], corners[j], strict=True)) for i, j in EDGES
    ]
    rows = [[Fraction(1), y, x, y * y, x * y, x * x] for x, y in places]
    return np.array([float(term) for term in solve(rows, samples)])


def dot(one: np.ndarray, two: np.ndarray) -> Fraction:
    return sum((Fraction(float(a)) * Fraction(float(b)) for a, b in zip(one, two, strict=True)), Fraction(0))


def root(value: Fraction) -> Fraction:
    """Square root, rounded down to about 60 digits."""
    return Fraction(isqrt(value.numerator * 10**120 // value.denominator), 10**60)


def exact_samples(normals: np.ndarray, approximate: bool) -> list[Fraction]:
    """Six samples: the middle normals normalised (equations 4-6), or X-shading's (equations 29-31)."""
    corners = [dot(LIGHT, normal) for normal in normals]
    middles = []
    for i, j in EDGES:
        if approximate:
            share = (5 - dot(normals[i], normals[j])) / 8
        else:
            square = (
                dot(normals[i], normals[i]) + 2 * dot(normals[i], normals[j]) + dot(normals[j], normals[j])
            )
            share = 1 / root(square)
        middles.append((corners[i] + corners[j]) * share)
    return corners + middles


def triangles(rng: np.random.Generator, count: int = 40) -> tuple[np.ndarray, np.ndarray]:
    """Vertices of triangles without small angles, corners at distinct heights, and unit normals."""
    found: list[np.ndarray] = []
    while len(found) < count:
        vertices = np.rint(rng.uniform(0, 256, (3, 2)) * 256) / 256
        one, two = vertices[1] - vertices[0], vertices[2] - vertices[0]
        area = one[0] * two[1] - one[1] * two[0]
        if abs(area) > 0.3 * (one @ one + two @ two) and abs(one[1]) > 8:
            found.append(vertices)
    normals = np.array([0.0, 0.0, 1.0]) + rng.normal(scale=0.3, size=(count, 3, 3))
    return np.array(found), normals / np.linalg.norm(normals, axis=-1, keepdims=True)


def assert_close(got: np.ndarray, expected: np.ndarray, vertices: np.ndarray) -> None:
    """Coefficients agree, each weighed by the size of its term on the triangle."""
    for row, want, corners in zip(got, expected, vertices, strict=True):
        size = np.abs(corners - corners[0]).max()
        weight = np.array([1.0, size, size, size**2, size**2, size**2])
        assert np.allclose(row * weight, want * weight, rtol=0, atol=TOLERANCE * np.abs(want * weight).max())


@pytest.mark.parametrize("method", FITS)
def test_fit_goes_through_any_six_samples(method, rng):
    vertices, _ = triangles(rng)
    samples = rng.uniform(0, 255, (len(vertices), 6))
    expected = [quadratic(v, [Fraction(float(i)) for i in s]) for v, s in zip(vertices, samples, strict=True)]
    assert_close(fit(method, vertices, samples), np.array(expected), vertices)


@pytest.mark.parametrize("method", METHODS)
def test_coefficients_are_those_of_the_methods_samples(method, rng):
    vertices, normals = triangles(rng)
    approximate = method not in FITS
    expected = [quadratic(v, exact_samples(n, approximate)) for v, n in zip(vertices, normals, strict=True)]
    assert_close(coefficients(method, vertices, normals, LIGHT), np.array(expected), vertices)


@pytest.mark.parametrize("method", METHODS)
def test_float32_is_float64_up_to_its_rounding(method, rng):
    """More triangles than a block has, so that the last one is not full."""
    vertices, normals = triangles(rng, 150)
    double = coefficients(method, vertices, normals, LIGHT)
    single = coefficients(method, vertices, normals, LIGHT, np.float32)
    assert single.dtype == np.float32 and single.shape == double.shape == (150, 6)
    size = np.abs(vertices - vertices[:, :1]).max(axis=(1, 2))[:, None] ** [0, 1, 1, 2, 2, 2]
    error = np.abs((single - double) * size).max(axis=1)
    assert 0 < np.median(error) < 1e-5 and error.max() < 1e-2


def test_only_abbas_needs_distinct_heights(rng):
    """Y2 = 0 divides by zero in the formula of T3 (Abbas et al., section 3), and nowhere else."""
    vertices, normals = triangles(rng)
    vertices[:, 1, 1] = vertices[:, 0, 1]
    legs = vertices[:, 1:] - vertices[:, :1]
    good = np.abs(legs[:, 0, 0] * legs[:, 1, 1]) > 100
    vertices, normals = vertices[good], normals[good]
    assert len(vertices) > 10
    assert not np.isfinite(coefficients("abbas", vertices, normals, LIGHT)[:, 3]).any()
    for method in set(METHODS) - {"abbas"}:
        expected = [
            quadratic(v, exact_samples(n, method not in FITS)) for v, n in zip(vertices, normals, strict=True)
        ]
        assert_close(coefficients(method, vertices, normals, LIGHT), np.array(expected), vertices)


@pytest.mark.parametrize("degrees", [10, 45, 80])
def test_x_shadings_middle_normal_has_the_length_of_equation_27(degrees):
    turn = np.radians(degrees)
    normals = np.array([[[0.0, 0.0, 1.0], [np.sin(turn), 0.0, np.cos(turn)], [0.0, 0.0, 1.0]]])
    vertices = np.array([[[0.0, 0.0], [8.0, 2.0], [1.0, 7.0]]])

    def middle(method: str) -> float:
        t = coefficients(method, vertices, normals, LIGHT)[0]
        return t @ [1, 1, 4, 1, 4, 16]

    assert middle("x_shading") / middle("unit_triangle") == pytest.approx(
        2 * np.cos(turn / 2) * (5 - np.cos(turn)) / 8, rel=1e-9
    )


def test_edge_factors_outlive_a_turn(rng):
    _, normals = triangles(rng)
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    assert np.allclose(edge_factors(normals @ turn.T), edge_factors(normals), atol=1e-14)
    assert (edge_factors(normals) <= 0).all()


def test_unknown_methods_are_refused(rng):
    vertices, normals = triangles(rng, 1)
    with pytest.raises(QuadshadeError, match="seiler"):
        coefficients("seiler", vertices, normals, LIGHT)
    with pytest.raises(QuadshadeError, match="x_shading"):
        fit("x_shading", vertices, np.zeros((1, 6)))
