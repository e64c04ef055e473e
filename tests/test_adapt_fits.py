# SPDX-License-Identifier: Apache-2.0
"""Adaptive pictures whose parts are fitted anew: never more bytes, the limit kept at every pixel."""

from __future__ import annotations

import warnings
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import quadshade
from quadshade.adapt import Adapted, ErrorCurve, adapt, error_figures, pixel_errors
from quadshade.adapt.costs import stream_bytes
from quadshade.adapt.plan import Plan
from quadshade.adapt.refit import Refit
from quadshade.choices import ADAPTIVE_FITS
from quadshade.engine import draw
from quadshade.errors import QuadshadeError
from quadshade.scene import Projected, fit_camera, load_scene, project
from quadshade.shading import Material

SHINY = Material(exponent=50)
HARD = """
v 0 0 0
v 4 0 0
v 0 4 0
v 4 4 1
v 2 2 3
v 1 1 0.5
v 1.001 1 0.5
v 1 1.001 0.5
v 40 -20 -9
v -40 -20 -9
v 0 40 -9
f 1 2 3
f 2 4 3
f 2 3 5
f 3 2 1
f 1 1 2
f 6 7 8
f 10 9 11
f 3 4 5
"""
"""Three triangles and more on an edge, one turned over, one without area, one of no pixel, one behind all."""


@cache
def looked_at(scene: str, size: int = 72) -> Projected:
    mesh = load_scene(scene)
    return project(mesh, fit_camera(mesh), size, size)


def drawn_error(adapted: Adapted, whole: Projected) -> float:
    """Of the golden model's pixels, by the way of those who draw the picture."""
    pixels = draw(adapted.triangles, adapted.formats).pixels
    return error_figures(pixel_errors(pixels, adapted.root, whole, None, SHINY, adapted.formats)).largest


def size_of(adapted: Adapted) -> int:
    return stream_bytes(adapted.triangles, adapted.formats)


@pytest.mark.parametrize(
    ("scene", "shading"),
    [("sphere:168", "auto"), ("torus:288", "quadratic")],
)
def test_fits_take_no_more_bytes_and_keep_the_error(scene: str, shading: str) -> None:
    whole = looked_at(scene)
    sizes = {}
    for fit in ADAPTIVE_FITS:
        curve = ErrorCurve(whole, None, SHINY, shading=shading, fit=fit)
        for error in (12.0, 4.0, 1.3):
            adapted = curve.for_error(error)
            assert adapted.error == pytest.approx(drawn_error(adapted, whole), rel=1e-12)
            assert adapted.error <= error
            sizes[fit, error] = size_of(adapted)
    for error in (12.0, 4.0, 1.3):
        assert sizes["minimax", error] <= sizes["auto", error] <= sizes["six-point", error]
    assert sum(sizes["minimax", error] < sizes["six-point", error] for error in (12.0, 4.0, 1.3)) >= 2


def test_a_divided_picture_needs_fewer_parts() -> None:
    """Channels fitted together save what no order of channels fitted apart does."""
    whole = looked_at("torus:288", 192)
    plain = adapt(whole, None, SHINY, max_error=0.8, shading="quadratic-specular")
    fitted = adapt(whole, None, SHINY, max_error=0.8, shading="quadratic-specular", fit="minimax")
    assert fitted.fit == "minimax" and plain.fit == "six-point"
    assert drawn_error(fitted, whole) <= 0.8
    assert size_of(fitted) < 0.95 * size_of(plain)
    assert len(fitted.root) < len(plain.root)
    # Divided or not, every pixel within the outline is drawn.
    drawn = [draw(one.triangles, one.formats).pixels for one in (plain, fitted)]
    covered = [np.bincount(pixels.y * whole.width + pixels.x, minlength=whole.width**2) for pixels in drawn]
    assert ((covered[0] > 0) != (covered[1] > 0)).mean() < 0.002


def test_errors_and_budgets_are_monotonic() -> None:
    whole = looked_at("torus:288")
    curve = ErrorCurve(whole, None, SHINY, shading="quadratic-specular", fit="minimax")
    plain = ErrorCurve(whole, None, SHINY, shading="quadratic-specular")
    for_error = [curve.for_error(error) for error in (20.0, 6.0, 2.0)]
    sizes = [size_of(one) for one in for_error]
    assert sizes == sorted(sizes)
    for_budget = []
    for budget in (sizes[0], (sizes[0] + sizes[1]) // 2, sizes[2]):
        adapted = curve.for_budget(budget)
        assert size_of(adapted) <= budget
        assert adapted.error == pytest.approx(drawn_error(adapted, whole), rel=1e-12)
        assert adapted.error <= plain.for_budget(budget).error
        for_budget.append(adapted.error)
    assert for_budget == sorted(for_budget, reverse=True)


def test_auto_fits_only_what_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """For an error one picture is fitted, where minimax fits four; for a budget until one is too dear."""
    whole, asked = looked_at("torus:288"), []
    cheapest = Refit.cheapest

    def counted(refit: Refit, plan: Plan) -> Plan:
        asked.append(refit.max_error)
        return cheapest(refit, plan)

    monkeypatch.setattr(Refit, "cheapest", counted)
    numbers = {}
    for fit in ("auto", "minimax"):
        curve = ErrorCurve(whole, None, SHINY, shading="quadratic-specular", fit=fit)
        asked.clear()
        assert curve.for_error(6.0).error <= 6
        numbers[fit] = len(asked)
    assert numbers == {"auto": 1, "minimax": 4}
    plain = ErrorCurve(whole, None, SHINY, shading="quadratic-specular").for_budget(12_000)
    fitted = adapt(whole, None, SHINY, budget=12_000, shading="quadratic-specular", fit="auto")
    assert size_of(fitted) <= 12_000 and fitted.error <= plain.error


@pytest.mark.parametrize("limit", [{"max_error": 2.0}, {"budget": 2600}])
def test_a_bad_mesh_is_drawn_without_a_hole(tmp_path: Path, limit: dict) -> None:
    path = tmp_path / "hard.obj"
    path.write_text(HARD)
    pictures = []
    for fit in ("six-point", "minimax"):
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            picture = quadshade.render(
                path, size=(128, 128), engine="model", fit=fit, background="0,1,0",
                camera="from=0.3,0.4,1", **limit,
            )  # fmt: skip
        assert sum("fit" in str(one.message) for one in said) <= 1
        pictures.append(picture)
    ground = [(picture.array == (0, 255, 0)).all(axis=2) for picture in pictures]
    assert (ground[0] == ground[1]).all() and not ground[1].all()
    if "max_error" in limit:
        assert all(picture.stats.adaptive["measured_max"] <= 2.0 for picture in pictures)


@pytest.mark.parametrize(
    ("keywords", "said"),
    [
        ({"fit": "smooth", "max_error": 2.0}, "--fit smooth with --max-error"),
        ({"fit": "least-squares", "budget": 9000}, "give --fit six-point or minimax"),
        ({"fit": "minimax", "max_error": 2.0, "error_measure": "rms"}, "--error-measure rms"),
        ({"fit": "minimax", "max_error": 2.0, "verify": False}, "--no-verify"),
    ],
)
def test_what_is_not_fitted_is_refused(keywords: dict, said: str) -> None:
    with pytest.raises(QuadshadeError, match=said):
        quadshade.render("sphere:168", size=(64, 64), engine="model", **keywords)
