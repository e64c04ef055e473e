# SPDX-License-Identifier: Apache-2.0
"""Every step that makes adaptive pictures cheaper is felt where it is left out, and every sign in a bound."""

from __future__ import annotations

import numpy as np
import pytest

from quadshade.adapt import ColourShader, CosineShader, choose, cosine_shader, polynomial_fit
from quadshade.adapt.choose import Goal, choose_orders, settle
from quadshade.adapt.cosine_loops import fit_cosines
from quadshade.adapt.part_memory import WHOLE, Assessed, PartMemory
from quadshade.adapt.polynomial_fit import POINTS, fit, fit_at
from quadshade.contract.formats import CONSTANT, LINEAR, QUADRATIC, Formats
from quadshade.scene import Projected, fit_camera, load_scene, project
from quadshade.setup.triangle_setup import setup_triangles
from quadshade.shading import Material, specular_formats
from quadshade.shading.point_sets import shared_points

SHINY = Material(exponent=50)


def looked_at(scene: str, size: int = 96) -> Projected:
    mesh = load_scene(scene)
    return project(mesh, fit_camera(mesh), size, size)


def bumps(count: int = 60) -> np.ndarray:
    """(count, 3, 28) values with curvature beyond a quadratic."""
    rng = np.random.default_rng(4)
    slope = POINTS @ rng.normal(size=(count, 3, 3))[..., None]
    return np.clip(120 + 40 * np.sin(2 * slope[..., 0]) + 15 * slope[..., 0], 0, 255)


@pytest.mark.parametrize("order", [CONSTANT, LINEAR, QUADRATIC])
def test_each_candidate_polynomial_wins_somewhere(order: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Through the samples, nearest, moved: without any of them some triangle is worse."""
    values = bumps()
    best = fit(values, order, 255.0, "max").largest
    whole = polynomial_fit._evaluated
    tried = []

    def watched(samples: np.ndarray, *others: object) -> polynomial_fit.Fit:
        tried.append(whole(samples, *others))
        return tried[-1]

    monkeypatch.setattr(polynomial_fit, "_evaluated", watched)
    fit(values, order, 255.0, "max")
    assert len(tried) == 3
    errors = np.stack([one.largest for one in tried])
    np.testing.assert_array_equal(best, errors.min(axis=0))
    # Nearest and moved by half the range's centre: equal extremes, so never worse than nearest alone.
    assert (errors[2] <= errors[1] + 1e-9).all() and (errors[2] < errors[1] - 1e-6).any()


def test_equalising_steps_are_worth_their_time(monkeypatch: pytest.MonkeyPatch) -> None:
    values, used = bumps(), np.ones((60, len(POINTS)), dtype=bool)
    points = np.broadcast_to(POINTS, (60, *POINTS.shape))
    errors = []
    for steps in (0, 1, polynomial_fit.EQUALISING):
        monkeypatch.setattr(polynomial_fit, "EQUALISING", steps)
        errors.append(fit_at(points, used, values, QUADRATIC, 255.0, "max").largest)
    assert (errors[0] >= errors[1]).all() and (errors[1] >= errors[2]).all()
    assert errors[2].mean() < 0.97 * errors[1].mean() < 0.97 * errors[0].mean()


def test_secants_fit_the_power_and_not_the_cosine(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = looked_at("sphere:168")
    errors = []
    for secants in (cosine_shader.SECANTS, 0):
        monkeypatch.setattr(cosine_shader, "SECANTS", secants)
        shader = CosineShader(None, SHINY, specular_formats({}, whole, None, SHINY), whole, "rms")
        cosines = shader._cosines(whole, np.arange(len(whole)), shared_points(POINTS, np.arange(len(whole))))
        samples, own = np.zeros((len(whole), 2, 3, 6)), np.zeros((len(whole), 2, 3))
        sets, nodes = shared_points(POINTS, np.arange(len(whole))), np.empty((0, 6), np.int64)
        fit_cosines(shader.kind, sets, *cosines, nodes, np.arange(len(whole)), samples, own)
        errors.append(own[:, 1, LINEAR])
    better, worse = errors
    assert (better <= worse).all() and better.mean() < 0.999 * worse.mean()


def test_the_bound_of_an_estimate_is_that_of_the_set_up() -> None:
    """``bound`` is what the set-up publishes for the highest order, never less, and errors add to it."""
    whole = looked_at("torus:288", 256)
    formats = Formats(word_width=20, frac_bits=9)
    shader = ColourShader(None, SHINY, formats, whole)
    surface = shader.surface(whole)
    orders = np.full((len(whole), 3), QUADRATIC)
    triangles = shader.screen_triangles(whole, surface.assessed.samples[:, :, -1], orders)
    primitives = setup_triangles(triangles, formats)
    published = np.zeros(len(whole))
    np.maximum.at(published, primitives.triangle, primitives.bound[:, :3].max(axis=1))
    seen = surface.assessed.pixels > 0
    np.testing.assert_allclose(surface.assessed.bound[seen], published[seen])
    assert published.max() > 0.05
    decision = choose_orders(surface, shader, Goal(np.full(len(whole), 3.0)))
    chosen = np.take_along_axis(surface.assessed.errors, decision.orders[..., None], axis=2)[..., 0]
    np.testing.assert_allclose(decision.largest, chosen.max(axis=1) + surface.assessed.bound)
    # What rounding takes is not left for the polynomials.
    stricter = choose_orders(surface, shader, Goal(3.0 - surface.assessed.bound))
    assert (stricter.orders >= decision.orders).all() and (stricter.orders > decision.orders).any()


def parts_for(allowed: float) -> int:
    whole = looked_at("torus:288")
    shader = ColourShader(None, SHINY, None, whole)
    return len(settle(shader.surface(whole), shader, Goal(np.full(len(whole), allowed)))[0].root)


def test_the_edge_that_saves_most_is_split(monkeypatch: pytest.MonkeyPatch) -> None:
    usual = parts_for(1.0)
    gain = choose._gain_max
    monkeypatch.setattr(choose, "_gain_max", lambda *arguments: -gain(*arguments))
    assert parts_for(1.0) > 1.1 * usual, "the edge that saves least is as good"


def test_parts_are_assessed_once_and_forgotten_when_they_are_many() -> None:
    whole = looked_at("sphere:168")
    asked = []

    def assess(projected: Projected, root: np.ndarray) -> Assessed:
        asked.append(len(root))
        values = projected.vertices.sum(axis=(1, 2)).astype(float)
        none = np.zeros((len(root), 0, 3), dtype=np.int64)
        return Assessed(values, values, none[:, :, 0], values[:, None], values, none, none[:, :, 0])

    memory, root = PartMemory(assess, most=len(whole) + 5), np.arange(len(whole))
    undivided = np.full(len(whole), WHOLE)
    first, part = memory.assessed(whole, root, undivided, root)
    assert (first.pixels == whole.vertices.sum(axis=(1, 2))).all()
    assert len(np.unique(part)) == len(whole) == asked[0]
    some = np.array([5, 1, 1])
    again, numbers = memory.assessed(whole.ordered(some), root[some], undivided[some], root[some])
    assert (again.pixels == first.pixels[some]).all() and (numbers == part[some]).all()
    assert asked == [len(whole)]
    # A part of a part is another part, though it may be at the same place; room for it is made.
    other, fresh = memory.assessed(whole.ordered(some[:1]), root[some[:1]], part[some[:1]], root[:1])
    assert asked == [len(whole), 1] and fresh[0] not in part and other.pixels[0] == first.pixels[5]
    _, renewed = memory.assessed(whole, root, undivided, root)
    assert asked[-1] == len(whole) and not set(renewed.tolist()) & {*part.tolist(), *fresh.tolist()}
