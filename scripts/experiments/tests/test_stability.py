# SPDX-License-Identifier: Apache-2.0
"""The stability report: its triangles are what they say, its errors are exact, its text is of its numbers."""

from __future__ import annotations

import json
from fractions import Fraction
from math import gcd

import numpy as np
import pytest
from click.testing import CliRunner

from quadshade.setup.literature.general_solution import general_in
from quadshade.setup.literature.methods import fit, terms_in
from scripts.experiments import setup_stability as stability
from tests.support.setup_reference import exact_quadratic


@pytest.mark.parametrize("aspect", [1.0, 100.0, 1e6])
def test_a_needle_is_as_thin_as_it_says(aspect, rng):
    x2, y2, x3, y3 = stability.needle(rng, 256, aspect)
    length = (x2 * x2 + y2 * y2) ** 0.5
    assert length == pytest.approx(256 * 256, rel=1e-4) and gcd(x2, y2) == 1
    assert 0.85 < length * length / (x2 * y3 - y2 * x3) / aspect < 1.15
    assert 0.25 < (x2 * x3 + y2 * y3) / length**2 < 0.75


@pytest.mark.parametrize("name", stability.SPECIAL)
def test_a_special_case_is_what_it_says(name, rng):
    x2, y2, x3, y3 = (Fraction(leg, 256) for leg in stability.special(name, rng))
    if name == "one sub-pixel squared":
        assert abs(x2 * y3 - y2 * x3) * 65536 <= 50
        return
    left, _, right = name.partition(" = ")
    known = {"X2": x2, "Y2": y2, "X3": x3, "Y3": y3, "X2 Y3": x2 * y3, "Y2 X3": y2 * x3}
    assert known[left] == (known[right] if right in known else Fraction(right))


def test_terms_in_fractions_are_the_polynomial(rng):
    """The reference of all errors, against Lagrange's form."""
    legs = tuple(Fraction(int(leg), 256) for leg in stability.stout(rng, 50))
    samples = rng.uniform(0, 255, 6)
    six = tuple(Fraction(float(sample)) for sample in samples)
    vertices = np.array(
        [[0, 0], [int(256 * legs[0]), int(256 * legs[1])], [int(256 * legs[2]), int(256 * legs[3])]]
    )
    exact = exact_quadratic(vertices, samples, 2)
    for method in ("abbas", "unit_triangle"):
        t0, t1, t2, t3, t4, t5 = terms_in(method, legs, six)
        for x, y in rng.integers(-99, 99, (5, 2)).tolist():
            here = t0 + t1 * y + t2 * x + t3 * y * y + t4 * x * y + t5 * x * x
            assert here == exact(Fraction(256 * x), Fraction(256 * y))


def test_arithmetic_is_of_the_type_it_says(rng):
    """float64 equals what the host computes; float32 is rounded after every step."""
    legs = np.array([stability.stout(rng, 90) for _ in range(20)]) / 256
    samples = stability.samples_of("abbas", rng, 20)
    vertices = np.concatenate([np.zeros((20, 2)), legs], axis=1).reshape(-1, 3, 2)
    for method in ("abbas", "general", "unit_triangle"):
        double = stability.computed(method, np.float64, legs, samples)
        single = stability.computed(method, np.float32, legs, samples)
        assert (double.dtype, single.dtype) == (np.float64, np.float32)
        assert np.array_equal(double, fit(method, vertices, samples))
        off = np.abs(single - double) / np.abs(double).max(axis=1, keepdims=True)
        assert 1e-9 < off.max() < 1e-2
    assert general_in(np.float32, legs.astype(np.float32), samples).dtype == np.float32


def test_errors_are_those_of_the_coefficients(rng):
    """A coefficient off by a known amount is off by that much at the corner where its term is largest."""
    legs = np.array([8.0, 0.5, 0.25, 4.0])
    samples = stability.samples_of("unit_triangle", rng, 1)[0]
    exact = terms_in(
        "unit_triangle", tuple(Fraction(x) for x in legs), tuple(Fraction(float(s)) for s in samples)
    )
    terms = np.array([float(term) for term in exact])
    for difference, most in ((0, 1), (1, 4), (2, 8), (3, 16), (5, 64)):
        wrong = terms.copy()
        wrong[difference] += 0.25
        grey, relative = stability.errors("unit_triangle", legs, samples, {"float64": wrong})["float64"]
        assert grey == pytest.approx(most / 4, rel=1e-9) and relative > 0
    assert stability.errors("abbas", legs, samples, {"float64": terms * np.nan})["float64"] is None


def test_report_is_written_from_the_numbers(tmp_path):
    report = tmp_path / "report.md"
    result = CliRunner().invoke(
        stability.main, ["--triangles", "1", "--output", str(report)], catch_exceptions=False
    )
    assert result.exit_code == 0
    numbers = json.loads(report.with_suffix(".json").read_text())
    assert report.read_text() == stability.report(numbers)
    assert report.with_suffix(".png").stat().st_size > 10_000
    rows = numbers["rows"]
    assert len(rows) == (len(stability.ASPECTS) + len(stability.SIZES) + len(stability.SPECIAL)) * 9
    undefined = {row["value"] for row in rows if row["method"] == "abbas" and row["undefined"] == 1}
    assert {"Y2 = 0", "X2 Y3 = Y2 X3"} <= undefined


def test_published_report_is_that_of_its_numbers():
    numbers = json.loads(stability.REPORT.with_suffix(".json").read_text())
    assert stability.REPORT.read_text() == stability.report(numbers)
