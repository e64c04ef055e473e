# SPDX-License-Identifier: Apache-2.0
"""An allowed error and a budget are looked up in one curve: monotonic, never dominated, measured."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from quadshade.adapt import Adapted, ErrorCurve, adapt, error_figures, pixel_errors
from quadshade.adapt.costs import core_clocks, stream_bytes
from quadshade.adapt.curve import error_limits
from quadshade.engine import draw
from quadshade.scene import Projected, fit_camera, load_scene, project
from quadshade.shading import Material

SHINY = Material(exponent=50)
SCENES = ("sphere:168", "sphere:690", "torus:288", "icosphere:2")
ERRORS = {"max": np.geomspace(30, 1.1, 10), "rms": np.geomspace(5, 0.4, 8)}


@cache
def looked_at(scene: str, size: int = 72) -> Projected:
    mesh = load_scene(scene)
    return project(mesh, fit_camera(mesh), size, size)


def drawn_error(adapted: Adapted, whole: Projected, measure: str) -> float:
    """What the golden model's pixels are off by, by the way of those who draw the picture."""
    pixels = draw(adapted.triangles, adapted.formats).pixels
    errors = pixel_errors(pixels, adapted.root, whole, None, SHINY, adapted.formats)
    figures = error_figures(errors)
    return figures.largest if measure == "max" else figures.rms


def size_of(adapted: Adapted, unit: str = "bytes") -> int:
    cost = stream_bytes if unit == "bytes" else core_clocks
    return cost(adapted.triangles, adapted.formats)


def rising(values: list[float]) -> bool:
    return values == sorted(values)


@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("measure", ["max", "rms"])
def test_errors_and_budgets_are_one_monotonic_curve(scene: str, measure: str) -> None:
    whole = looked_at(scene)
    curve = ErrorCurve(whole, None, SHINY, measure=measure, shading="auto")
    errors = ERRORS[measure]
    for_error = [curve.for_error(error) for error in errors]
    for error, adapted in zip(errors, for_error, strict=True):
        assert adapted.error == pytest.approx(drawn_error(adapted, whole, measure), rel=1e-12)
        assert adapted.error <= error
    sizes = [size_of(adapted) for adapted in for_error]
    assert rising(sizes), "a larger allowed error costs more bytes"
    assert sizes[-1] > 1.1 * sizes[0]
    budgets = sorted({*sizes, *np.linspace(sizes[0], sizes[-1], 8).astype(int).tolist()})
    for_budget = [curve.for_budget(budget) for budget in budgets]
    assert all(size_of(one) <= budget for one, budget in zip(for_budget, budgets, strict=True))
    assert rising([-adapted.error for adapted in for_budget]), "more bytes give more error"
    # One is the inverse of the other: no picture of either way is better than one of the other.
    pictures = [(size_of(one), one.error) for one in (*for_error, *for_budget)]
    for error, size in zip(errors, sizes, strict=True):
        assert size == min(bytes_ for bytes_, off in pictures if off <= error)
    for budget, adapted in zip(budgets, for_budget, strict=True):
        assert adapted.error == min(off for bytes_, off in pictures if bytes_ <= budget)


def test_more_clocks_never_give_more_error() -> None:
    whole = looked_at("torus:288")
    curve = ErrorCurve(whole, None, SHINY, shading="auto")
    most, least = (size_of(curve.for_error(error), "clocks") for error in (1.5, 30.0))
    budgets = np.linspace(least, most, 8).astype(int).tolist()
    pictures = [curve.for_budget(budget, "clocks") for budget in budgets]
    assert all(size_of(one, "clocks") <= budget for one, budget in zip(pictures, budgets, strict=True))
    assert rising([-adapted.error for adapted in pictures])
    assert pictures[-1].error < pictures[0].error / 3


def test_a_curve_does_not_depend_on_what_was_asked_before() -> None:
    """What is remembered of one picture changes no other."""
    whole = looked_at("torus:288")
    curve = ErrorCurve(whole, None, SHINY, shading="auto")
    for error in (9.0, 3.0):
        swept = curve.for_error(error)
        alone = adapt(whole, None, SHINY, max_error=error, shading="auto")
        assert (swept.shading, swept.error, swept.rival) == (alone.shading, alone.error, alone.rival)
        for name in ("vertices", "samples", "orders", "depth"):
            assert np.array_equal(getattr(swept.triangles, name), getattr(alone.triangles, name))


def test_a_budget_is_not_dominated_by_an_error() -> None:
    """Estimates had a budget of 24,000 bytes give an error of 3.04, where 16,068 bytes give 1.81."""
    whole = looked_at("torus:288", 512)
    plain = Material()
    # What "auto" takes here; the others need more.
    curve = ErrorCurve(whole, None, plain, shading="quadratic-specular")
    asked, paid = curve.for_error(2.0), curve.for_budget(24_000)
    assert size_of(asked) <= 16_068 and asked.error <= 2
    assert size_of(paid) <= 24_000 and paid.error < 1.3 < asked.error


def test_limits_are_round_numbers_a_few_per_cent_apart() -> None:
    limits = error_limits(255.0)
    assert limits[0] == 255.5 and limits[-1] == 0.525
    assert {0.6, 0.7, 1.0, 1.5, 2.0, 4.0, 12.0, 100.0} <= set(limits.tolist())
    ratio = limits[1:-1] / limits[2:]
    assert 1.019 < ratio.min() and ratio.max() < 1.0511
    assert error_limits(15.0)[0] == 15.5 and error_limits(1023.0)[1] > 990
