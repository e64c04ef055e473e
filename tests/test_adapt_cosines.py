# SPDX-License-Identifier: Apache-2.0
"""Adaptive pictures of cosines: the power at the pixel among the choices; small triangles at their pixels."""

from __future__ import annotations

import numpy as np
import pytest

from quadshade.adapt import CosineShader, adapt, error_figures, pixel_errors, refine, stream_bytes
from quadshade.adapt.colour_shader import ColourShader
from quadshade.adapt.costs import state_bytes
from quadshade.adapt.polynomial_fit import POINTS, fit_at, shape_functions
from quadshade.adapt.small_triangles import FEW, pixel_centres
from quadshade.contract.formats import CONSTANT, LINEAR, QUADRATIC, Formats
from quadshade.engine import draw
from quadshade.errors import QuadshadeError
from quadshade.scene import Projected, fit_camera, load_scene, parse_camera, project
from quadshade.scene.mesh import Mesh
from quadshade.shading import (
    AmbientLight,
    DirectionalLight,
    Material,
    PointLight,
    sample,
    sample_specular,
    specular_formats,
)
from quadshade.shading.specular import UnsuitedError
from scripts.experiments.cho.teapot import teapot

SHINY = Material(exponent=50)
SPECULAR = "quadratic-specular"
KINDS = ("quadratic", SPECULAR, "quadratic-lights")


def looked_at(mesh: Mesh, size: int = 128) -> Projected:
    return project(mesh, fit_camera(mesh), size, size)


def figures_of(adapted, whole: Projected, lights=None, material: Material = SHINY, allowed: float = np.inf):
    """The golden model's pixels against Phong shading of the undivided mesh."""
    pixels = draw(adapted.triangles, adapted.formats).pixels
    return error_figures(
        pixel_errors(pixels, adapted.root, whole, lights, material, adapted.formats), allowed
    )


@pytest.mark.parametrize("scene", ["sphere:168", "torus:288", "teapot"])
@pytest.mark.parametrize("allowed", [8.0, 2.0, 0.8])
def test_the_cheaper_channels_are_taken_and_the_error_kept(scene: str, allowed: float) -> None:
    whole = looked_at(teapot() if scene == "teapot" else load_scene(scene))
    both = {}
    for shading in KINDS:
        both[shading] = adapt(whole, None, SHINY, max_error=allowed, shading=shading)
        assert figures_of(both[shading], whole, allowed=allowed).exceeding == 0
    auto = adapt(whole, None, SHINY, max_error=allowed, shading="auto")
    sizes = {name: stream_bytes(one.triangles, one.formats) for name, one in both.items()}
    assert auto.shading == min(sizes, key=sizes.get)
    assert stream_bytes(auto.triangles, auto.formats) == min(sizes.values())
    # What is dearer by far is not searched to the end.
    assert auto.rival.shading != auto.shading
    if auto.rival.error is None:
        assert min(sizes.values()) < auto.rival.bytes < 1.35 * sizes[auto.rival.shading]
    else:
        assert sizes[auto.rival.shading] <= auto.rival.bytes < 1.35 * sorted(sizes.values())[1]
    assert auto.mix()["rival"]["bytes"] == auto.rival.bytes
    if allowed < 1:
        assert sizes[SPECULAR] < 0.7 * sizes["quadratic"]


def test_bytes_are_those_that_are_sent() -> None:
    whole = looked_at(load_scene("torus:288"))
    adapted = adapt(whole, None, SHINY, max_error=2.0, shading=SPECULAR)
    words = draw(adapted.triangles, adapted.formats).stats["words"]
    state = state_bytes(adapted.triangles, adapted.formats)
    # All of the colours' registers, and of 448 entries those that are read.
    assert 4 * 100 < state < 0.5 * 4 * len(adapted.triangles.shade.writes())
    assert stream_bytes(adapted.triangles, adapted.formats) == 4 * words + state
    mix = adapted.mix()
    assert mix["state_bytes"] == state
    assert sum(mix["specular_by_order"].values()) == mix["triangles"]
    # Most triangles are away from the highlight.
    assert mix["specular_by_order"]["constant"] > mix["specular_by_order"]["quadratic"] > 0


@pytest.mark.parametrize(
    ("scene", "levels"), [("sphere:168", 0), ("sphere:168", 1), ("torus:288", 0), ("teapot", 1)]
)
@pytest.mark.parametrize("shading", ["flat", "linear-specular", SPECULAR])
def test_dominates_fixed_choices(scene: str, shading: str, levels: int) -> None:
    whole = parts = looked_at(teapot() if scene == "teapot" else load_scene(scene))
    root = np.arange(len(whole))
    for _ in range(levels):
        parts, parent = refine(parts, np.ones(len(parts), dtype=bool))
        root = root[parent]
    core = Formats() if shading == "flat" else specular_formats({}, whole, None, SHINY)
    fixed = (sample if shading == "flat" else sample_specular)(parts, shading, None, SHINY, core)
    size = stream_bytes(fixed, core)
    theirs = error_figures(pixel_errors(draw(fixed, core).pixels, root, whole, None, SHINY, core))
    ours = adapt(whole, None, SHINY, max_error=theirs.largest, shading="auto")
    assert figures_of(ours, whole).largest <= theirs.largest
    assert stream_bytes(ours.triangles, ours.formats) < size
    for measure, name in (("max", "largest"), ("rms", "rms")):
        ours = adapt(whole, None, SHINY, budget=size, measure=measure, shading="auto")
        assert stream_bytes(ours.triangles, ours.formats) <= size
        assert getattr(figures_of(ours, whole), name) < getattr(theirs, name)


SUNS = [DirectionalLight((x, 1, 1), (0.3, 0.25, 0.2)) for x in (-1, 0.3, 2)]


@pytest.mark.parametrize(
    "lights",
    [
        [PointLight((3.0, 3.0, 4.0), (0.6, 0.6, 0.6)), PointLight((-3.0, 1.0, 4.0), (0.4, 0.2, 0.1))],
        [PointLight((1.2, 1.6, 1.6), (1, 1, 1), (0.5, 0, 0.1)), AmbientLight((0.5, 1, 0.5))],
        SUNS,
    ],
    ids=["two lights", "falls off", "three lights"],
)
def test_several_lights_and_lights_that_fall_off(lights) -> None:
    whole = looked_at(load_scene("sphere:374"))
    adapted = adapt(whole, lights, SHINY, max_error=1.5, shading=SPECULAR)
    assert figures_of(adapted, whole, lights, allowed=1.5).exceeding == 0
    assert len(np.unique(adapted.triangles.orders)) == 3
    # Parts of triangles are lit by the same state as wholes.
    shader = CosineShader(lights, SHINY, adapted.formats, whole)
    states, table = [], shader.table()
    while table is not None:
        states.append(table.state.writes().tolist())
        table = shader.coarser(table)
    assert adapted.triangles.shade.writes().tolist() in states


def test_many_lights_are_treated_alike_and_few_combined() -> None:
    whole = looked_at(load_scene("sphere:168"), 96)
    for lights, options in ((SUNS[:1], 9), (SUNS[:2], 81), (SUNS, 11)):
        core = specular_formats({}, whole, lights, SHINY)
        shader = CosineShader(lights, SHINY, core, whole)
        assessed = shader.surface(whole).assessed
        assert assessed.options.shape == (len(whole), options, 2 * len(lights))
        assert (assessed.errors[:, -1] <= assessed.errors[:, 0] + 1e-9).all()


def test_unused_channels_and_wide_streams() -> None:
    whole = looked_at(load_scene("sphere:168"), 128)
    for generics in ({"num_channels": 3}, {"stream_width": 128}, {"max_order": LINEAR}):
        core = specular_formats(generics, whole, None, SHINY)
        adapted = adapt(whole, None, SHINY, max_error=5.0, shading=SPECULAR, specular=core)
        assert figures_of(adapted, whole, allowed=5.0).exceeding == 0
        assert adapted.triangles.orders.shape[1] == core.num_channels
        assert adapted.triangles.orders.max() <= core.max_order
    # On a core with three channels colours are a choice too; the state then lets them pass.
    core = specular_formats({"num_channels": 3}, whole, None, SHINY)
    adapted = adapt(whole, None, SHINY, core, max_error=5.0)
    assert adapted.triangles.shade is None
    assert figures_of(adapted, whole, allowed=5.0).exceeding == 0


def test_a_budget_takes_what_errs_less() -> None:
    whole = looked_at(load_scene("torus:288"))
    for measure, name in (("max", "largest"), ("rms", "rms")):
        errors = {}
        for shading in (*KINDS, "auto"):
            one = adapt(whole, None, SHINY, budget=14_500, measure=measure, shading=shading)
            errors[shading] = getattr(figures_of(one, whole), name)
        assert errors["auto"] == min(errors.values())
        assert errors[SPECULAR] < 0.3 * errors["quadratic"]
    # Two constant words a light are the least that there is: where only they are paid for, they are left.
    cheapest = adapt(whole, None, SHINY, max_error=250.0, shading="quadratic-lights")
    least = stream_bytes(cheapest.triangles, cheapest.formats)
    one = adapt(whole, None, SHINY, budget=least, shading="auto")
    assert one.shading == "quadratic-lights"
    assert "the budget is" in one.rival.reason
    assert least < stream_bytes(sample(whole, "flat"), Formats())


@pytest.mark.parametrize("lights", [None, SUNS[:2]], ids=["one light", "two lights"])
def test_lights_without_the_power_need_no_table(lights) -> None:
    whole = looked_at(load_scene("sphere:374"))
    adapted = adapt(whole, lights, SHINY, max_error=4.0, shading="quadratic-lights")
    assert figures_of(adapted, whole, lights, allowed=4.0).exceeding == 0
    state = adapted.triangles.shade
    assert state.tables.size == 0 and state_bytes(adapted.triangles, adapted.formats) < 100
    assert state.linear == (1 << adapted.formats.num_specular) - 1
    # What a specular channel carries is the light itself: 1 is as much as a table's 1.
    powered = adapt(whole, lights, SHINY, max_error=4.0, shading=SPECULAR).triangles.shade
    top = (1 << adapted.formats.lane_value_bits) - 1
    full = 255 << adapted.formats.shade_guard_bits
    ratio = state.coefficients[-1] * (top / full) / powered.coefficients[-1]
    np.testing.assert_allclose(ratio, 1, atol=1e-4)


def test_scenes_without_cosines() -> None:
    whole = looked_at(load_scene("sphere:168"), 64)
    dull = Material(reflectance=lambda point, normal, to_light, to_viewer: 0 * normal + 0.5)
    with pytest.raises(UnsuitedError, match="reflectance"):
        adapt(whole, None, dull, max_error=4.0, shading=SPECULAR)
    one = adapt(whole, None, dull, max_error=4.0, shading="auto")
    assert one.shading == "quadratic" and "reflectance" in one.rival.reason
    with pytest.raises(QuadshadeError, match="shading is 'flat'"):
        adapt(whole, None, dull, max_error=4.0, shading="flat")


def test_small_triangles_are_known_by_their_pixels() -> None:
    whole = looked_at(load_scene("sphere:690"), 96)
    formats = Formats()
    places = pixel_centres(whole, formats.subpixel_bits, whole, np.arange(len(whole)))
    pixels = draw(sample(whole, "flat"), formats).pixels
    have = np.bincount(pixels.triangle, minlength=len(whole))
    assert (places.pixels == have).mean() > 0.9
    assert (places.rows == np.flatnonzero((have > 0) & (have <= FEW))).all()
    assert (places.have == have[places.rows]).all()
    assert places.points.min() >= 0
    assert (places.whole == places.points).all()
    parts, root = refine(whole, np.ones(len(whole), dtype=bool))
    few = pixel_centres(parts, formats.subpixel_bits, whole, root)
    at = [
        np.einsum("pj,pjx->px", points, np.repeat(corners, few.have, axis=0).astype(float))
        for points, corners in (
            (few.points, parts.vertices[few.rows]),
            (few.whole, whole.vertices[root[few.rows]]),
        )
    ]
    # The same pixels' centres, in 1/256 pixel.
    np.testing.assert_allclose(at[0], at[1], atol=1e-6)
    assert (np.rint(at[0]) % 256 == 128).all()
    drawn = draw(sample(parts, "flat"), formats).pixels
    order = np.lexsort((drawn.x, drawn.y, drawn.triangle))
    order = order[np.isin(drawn.triangle[order], few.rows)]
    assert (np.floor(at[0] / 256) == np.stack([drawn.x, drawn.y], axis=1)[order]).all()
    # What an order's words can meet exactly, they do: a pixel is one place, three are a plane's.
    shader = ColourShader(None, SHINY, formats, whole)
    errors = np.full(len(whole), np.nan)
    errors[places.rows] = shader.surface(whole).assessed.errors[places.rows][:, :, CONSTANT].max(axis=1)
    assert errors[have == 1].max() < 1e-6
    # On a finer mesh many triangles have no pixel at all; what is asked for is kept all the same.
    tiny = looked_at(load_scene("sphere:690"), 24)
    for shading in ("quadratic", SPECULAR):
        adapted = adapt(tiny, None, SHINY, max_error=0.6, shading=shading)
        assert figures_of(adapted, tiny, allowed=0.6).exceeding == 0
        assert adapted.error <= 0.6


@pytest.mark.parametrize("order", [CONSTANT, LINEAR, QUADRATIC])
def test_fits_reproduce_what_their_order_can(order: int) -> None:
    rng = np.random.default_rng(order)
    places = np.broadcast_to(POINTS, (7, *POINTS.shape))
    samples = rng.uniform(60, 200, (7, 3, (1, 3, 6)[order]))
    values = samples @ np.swapaxes(shape_functions(places, order), 1, 2)
    used = np.ones(places.shape[:2], dtype=bool)
    for measure in ("max", "rms"):
        found = fit_at(places, used, values, order, 255.0, measure)
        assert found.largest.max() < 1e-5
        np.testing.assert_allclose(found.samples[..., : samples.shape[2]], samples, atol=1e-4)


def test_equal_extremes_are_less_than_the_mean_squares() -> None:
    rng = np.random.default_rng(3)
    values = np.clip(rng.uniform(0, 255, (40, 3, 1)) + 90 * (POINTS @ rng.normal(size=3)) ** 3, 0, 255)
    places, used = np.broadcast_to(POINTS, (40, *POINTS.shape)), np.ones((40, len(POINTS)), dtype=bool)
    for order in (LINEAR, QUADRATIC):
        nearest, equal = (fit_at(places, used, values, order, 255.0, measure) for measure in ("rms", "max"))
        assert (equal.largest <= nearest.largest + 1e-9).all()
        assert equal.largest.mean() < 0.95 * nearest.largest.mean()


def test_nothing_seen_is_drawn_with_nothing() -> None:
    mesh = load_scene("sphere:168")
    nothing = project(mesh, parse_camera("eye=9,0,0,target=20,0,0", mesh), 64, 48)
    assert len(nothing) == 0
    for choice in ({"max_error": 2.0}, {"budget": 2000}, {"budget": 2000, "measure": "rms"}):
        for shading in (*KINDS, "auto"):
            adapted = adapt(nothing, None, SHINY, **choice, shading=shading)
            assert len(adapted.triangles) == 0
            assert stream_bytes(adapted.triangles, adapted.formats) == state_bytes(
                adapted.triangles, adapted.formats
            )


def test_triangles_without_a_pixel_cost_and_err_nothing() -> None:
    whole = looked_at(load_scene("sphere:690"), 24)
    core = specular_formats({}, whole, None, SHINY)
    for shader in (ColourShader(None, SHINY, None, whole), CosineShader(None, SHINY, core, whole)):
        assessed = shader.surface(whole).assessed
        unseen = assessed.pixels == 0
        assert 0.1 < unseen.mean() < 0.9
        assert assessed.errors[unseen].max() == assessed.bound[unseen].max() == 0
        assert assessed.errors[~unseen].max() > 1


def test_light_too_strong_for_the_shade_unit_is_drawn_by_colours() -> None:
    whole = looked_at(load_scene("sphere:168"))
    strong = [DirectionalLight((0, 0, 1), (10, 10, 10))]
    adapted = adapt(whole, strong, SHINY, max_error=8, shading="auto")
    assert adapted.shading == "quadratic"
    assert adapted.rival is not None and "a light reflects" in adapted.rival.reason
    assert figures_of(adapted, whole, strong).largest == pytest.approx(adapted.error)
    with pytest.raises(UnsuitedError, match="a light reflects"):
        adapt(whole, strong, SHINY, max_error=8, shading=SPECULAR)
