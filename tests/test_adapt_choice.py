# SPDX-License-Identifier: Apache-2.0
"""Adaptive pictures: errors asked for are kept, budgets too, and no fixed choice is better."""

from __future__ import annotations

import numpy as np
import pytest

from quadshade.adapt import adapt, error_figures, pixel_errors, refine
from quadshade.adapt.costs import core_clocks, stream_bytes
from quadshade.adapt.polynomial_fit import POINTS, bend, fit, shape_functions, split_errors
from quadshade.contract.formats import CONSTANT, LINEAR, QUADRATIC, Formats
from quadshade.engine import draw
from quadshade.errors import QuadshadeError
from quadshade.scene import Projected, fit_camera, load_scene, project
from quadshade.shading import Material, PointLight, sample

FORMATS = Formats()
SHINY = Material(exponent=50)


def projected_scene(scene: str, size: int = 256) -> Projected:
    mesh = load_scene(scene)
    return project(mesh, fit_camera(mesh), size, size)


def measured(
    triangles, root: np.ndarray, whole: Projected, allowed: float = np.inf, formats: Formats = FORMATS
):
    """Figures of the golden model's pixels against Phong shading of the undivided mesh."""
    pixels = draw(triangles, formats).pixels
    return error_figures(pixel_errors(pixels, root, whole, None, SHINY, formats), allowed)


@pytest.mark.parametrize("scene", ["sphere:168", "sphere:690", "torus:288"])
@pytest.mark.parametrize("allowed", [12.0, 3.0, 1.2])
def test_no_pixel_is_off_by_more_than_allowed(scene: str, allowed: float) -> None:
    whole = projected_scene(scene)
    estimated = adapt(whole, None, SHINY, max_error=allowed, verify=False)
    figures = measured(estimated.triangles, estimated.root, whole, allowed)
    # The estimate alone is wrong for a few pixels in ten thousand, and then by little.
    assert figures.exceeding < 5e-4
    assert figures.largest < 1.35 * allowed + 0.5
    assert not estimated.verified and estimated.error < 1.2 * allowed
    verified = adapt(whole, None, SHINY, max_error=allowed)
    drawn = measured(verified.triangles, verified.root, whole, allowed)
    assert drawn.exceeding == 0
    assert verified.verified and verified.error == drawn.largest
    # Repairs are few.
    assert len(verified.root) < 1.2 * len(estimated.root) + 10


@pytest.mark.parametrize("allowed", [3.0, 0.6, 0.35])
def test_root_mean_square_is_near_what_was_asked_for(allowed: float) -> None:
    whole = projected_scene("sphere:374")
    adapted = adapt(whole, None, SHINY, max_error=allowed, measure="rms")
    drawn = measured(adapted.triangles, adapted.root, whole).rms
    assert adapted.error == pytest.approx(drawn, rel=1e-12)
    assert 0.9 * allowed < drawn <= allowed


@pytest.mark.parametrize("measure", ["max", "rms"])
def test_more_bytes_buy_less_error(measure: str) -> None:
    whole = projected_scene("torus:288")
    budgets = [12_000, 20_000, 40_000]
    errors = []
    for budget in budgets:
        adapted = adapt(whole, None, SHINY, budget=budget, measure=measure)
        spent = stream_bytes(adapted.triangles, FORMATS)
        assert 0.9 * budget < spent <= budget
        assert 4 * draw(adapted.triangles, FORMATS).stats["words"] == spent
        figures = measured(adapted.triangles, adapted.root, whole)
        errors.append(figures.largest if measure == "max" else figures.rms)
    assert errors == sorted(errors, reverse=True)
    assert errors[0] > 3 * errors[-1]


def test_a_budget_of_clocks_is_kept() -> None:
    whole = projected_scene("torus:288", 128)
    least = core_clocks(adapt(whole, None, SHINY, max_error=200.0).triangles, FORMATS)
    spent = []
    for budget in (least + 100, least + 2000):
        adapted = adapt(whole, None, SHINY, budget=budget, unit="clocks", measure="rms")
        spent.append(core_clocks(adapted.triangles, FORMATS))
        assert spent[-1] <= budget
    assert spent[0] < spent[1]


@pytest.mark.parametrize("scene", ["sphere:168", "torus:288"])
@pytest.mark.parametrize("shading", ["flat", "gouraud", "quadratic"])
@pytest.mark.parametrize("levels", [0, 1])
def test_dominates_fixed_choices(scene: str, shading: str, levels: int) -> None:
    whole = parts = projected_scene(scene, 192)
    root = np.arange(len(whole))
    for _ in range(levels):
        parts, parent = refine(parts, np.ones(len(parts), dtype=bool))
        root = root[parent]
    fixed = sample(parts, shading, None, SHINY)
    size = stream_bytes(fixed, FORMATS)
    theirs = measured(fixed, root, whole)
    equal_error = adapt(whole, None, SHINY, max_error=theirs.largest)
    assert measured(equal_error.triangles, equal_error.root, whole).largest <= theirs.largest
    if shading == "flat" and not levels:
        # No packet is smaller than a constant one: as many bytes, and less error.
        assert stream_bytes(equal_error.triangles, FORMATS) == size
    else:
        assert stream_bytes(equal_error.triangles, FORMATS) < size
    for measure in ("max", "rms"):
        ours = adapt(whole, None, SHINY, budget=size, measure=measure)
        assert stream_bytes(ours.triangles, FORMATS) <= size
        figures = measured(ours.triangles, ours.root, whole)
        if measure == "max":
            assert figures.largest < theirs.largest
        else:
            assert figures.rms < theirs.rms


def test_cores_with_fewer_orders_and_wider_streams() -> None:
    whole = projected_scene("sphere:168", 128)
    for formats in (Formats(max_order=LINEAR), Formats(max_order=CONSTANT), Formats(stream_width=128)):
        adapted = adapt(whole, None, SHINY, formats, max_error=6.0)
        assert adapted.triangles.orders.max() <= formats.max_order
        assert (
            measured(adapted.triangles, adapted.root, whole, 6.0, formats).exceeding
            < (0.06, 1e-3, 0)[formats.max_order] + 1e-9
        )
    # Four channels share a beat, depth is linear: a constant channel would save nothing.
    assert adapted.triangles.orders.min() >= LINEAR


def test_several_lights_and_a_narrow_highlight() -> None:
    whole = projected_scene("sphere:374")
    lights = [PointLight((3.0, 3.0, 4.0), (0.6, 0.6, 0.6)), PointLight((-3.0, 1.0, 4.0), (0.4, 0.2, 0.1))]
    sharp = Material(exponent=300)
    adapted = adapt(whole, lights, sharp, max_error=4.0)
    pixels = draw(adapted.triangles, FORMATS).pixels
    errors = pixel_errors(pixels, adapted.root, whole, lights, sharp)
    assert error_figures(errors, 4.0).exceeding == 0
    assert 0 < (np.bincount(adapted.root) > 1).sum() < len(whole) / 4


def test_mix_counts_what_is_sent() -> None:
    adapted = adapt(projected_scene("sphere:168"), None, SHINY, max_error=3.0)
    mix = adapted.mix()
    assert mix["triangles"] == len(adapted.triangles) == sum(mix["triangles_by_order"].values())
    assert 3 * mix["triangles"] == sum(mix["channels_by_order"].values())
    assert all(mix["channels_by_order"].values())
    assert 0 < mix["divided"] < mix["triangles_of_mesh"] < mix["triangles"]


@pytest.mark.parametrize("order", [CONSTANT, LINEAR, QUADRATIC])
def test_fits_reproduce_what_their_order_can(order: int) -> None:
    rng = np.random.default_rng(order)
    samples = rng.uniform(60, 200, (7, 3, (1, 3, 6)[order]))
    values = samples @ shape_functions(POINTS, order).T
    for measure in ("max", "rms"):
        found = fit(values, order, 255.0, measure)
        np.testing.assert_allclose(found.samples[..., : samples.shape[2]], samples, atol=1e-9)
        assert found.largest.max() < 1e-9
    assert max(split_errors(values, order, measure).max() for measure in ("max", "rms")) < 1e-9


def test_fits_are_no_worse_than_sampling() -> None:
    rng = np.random.default_rng(5)
    values = np.clip(rng.uniform(0, 255, (50, 3, 1)) + 90 * (POINTS @ rng.normal(size=3)) ** 3, 0, 255)
    for order in (CONSTANT, LINEAR, QUADRATIC):
        nearest, moved = (fit(values, order, 255.0, measure) for measure in ("rms", "max"))
        assert (moved.largest <= nearest.largest + 1e-12).all()
        assert (nearest.square <= moved.square + 1e-12).all()
        assert (moved.samples >= 0).all() and (moved.samples <= 255).all()


def test_bend_bounds_quadratic_against_plane() -> None:
    rng = np.random.default_rng(6)
    samples = rng.uniform(0, 255, (500, 6))
    samples[0] = (10, 10, 10, 40, 40, 40)
    off = abs(samples @ shape_functions(POINTS, QUADRATIC).T - samples[:, :3] @ POINTS.T).max(axis=1)
    assert (off <= bend(samples) + 1e-9).all()
    assert off[0] == pytest.approx(bend(samples)[0])


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({}, "needs a limit"),
        ({"max_error": 3.0, "budget": 100}, "needs a limit"),
        ({"max_error": 0.5}, "rounding the output costs 0.5 alone"),
        ({"max_error": 0.28, "measure": "rms"}, "rounding the output costs 0.289 alone"),
        ({"budget": 100}, "the budget is 100 bytes"),
        ({"budget": 100, "unit": "clocks"}, "the budget is 100 clocks"),
        ({"budget": 100, "unit": "words"}, "unit is 'words'; give one of bytes, clocks, line"),
        ({"max_error": 3.0, "measure": "mean"}, "measure is 'mean'"),
    ],
)
def test_refusals(settings: dict, message: str) -> None:
    with pytest.raises(QuadshadeError, match=message):
        adapt(projected_scene("sphere:168", 64), **settings)
