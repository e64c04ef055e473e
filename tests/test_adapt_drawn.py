# SPDX-License-Identifier: Apache-2.0
"""Planning measures a drawing's errors in loops of its own: they are those of the drawing, pixel by pixel."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from quadshade.adapt import CosineShader, LightShader, adapt, choose, phong_pixels, pixel_errors, refine
from quadshade.adapt.colour_shader import ColourShader
from quadshade.adapt.costs import stream_bytes
from quadshade.adapt.pair_numbers import PairNumbers
from quadshade.adapt.phong_pixels import PhongPixels
from quadshade.adapt.plan import Planner
from quadshade.adapt.shader import Shader
from quadshade.contract.formats import Formats
from quadshade.contract.triangles import ScreenTriangles
from quadshade.engine import draw
from quadshade.scene import Projected, fit_camera, load_scene, parse_camera, project
from quadshade.scene.subdivide import Edges, split_edges
from quadshade.shading import Material, specular_formats
from quadshade.shading.lights import AmbientLight, DirectionalLight, Light, PointLight
from quadshade.shading.phong_loops import lit_mesh, shade_pixels
from quadshade.shading.reference import barycentric, phong, phong_at

SHINY = Material(exponent=50)
LIGHTS: tuple[Light, ...] = (
    AmbientLight((0.5, 0.6, 0.7)),
    DirectionalLight((0.3, 1.0, 0.8), (0.9, 0.8, 0.7)),
    PointLight((2.0, 1.0, 3.0), (0.4, 0.9, 0.5), (0.5, 0.1, 0.05)),
)


def looked_at(scene: str, size: int = 96) -> Projected:
    mesh = load_scene(scene)
    return project(mesh, fit_camera(mesh), size, size)


@pytest.mark.parametrize("exponent", [20.0, 7.5])
@pytest.mark.parametrize("model", ["phong", "blinn"])
@pytest.mark.parametrize("camera", ["from=1,1,2", "from=1,1,2,ortho=1.2"])
def test_compiled_phong_shading_is_phong_shading(exponent: float, model: str, camera: str) -> None:
    mesh = load_scene("torus:288")
    whole = project(mesh, parse_camera(camera, mesh), 96, 96)
    material = Material(exponent=exponent, model=model)
    pixels = draw(ColourShader(LIGHTS, material, None, whole).screen_triangles(
        whole, np.zeros((len(whole), 3, 6)), np.zeros((len(whole), 3), int)
    ), Formats()).pixels  # fmt: skip
    owner, x, y = (values.astype(np.int64) for values in (pixels.triangle, pixels.x, pixels.y))
    lit = lit_mesh(whole, LIGHTS, material, 255.0)
    assert lit is not None and len(x) > 1000
    weights = barycentric(whole.vertices, owner, x, y, 8)
    true = phong_at(whole, owner, weights, LIGHTS, material, Formats())
    assert (phong(whole, owner, x, y, LIGHTS, material) == shade_pixels(lit, owner, x, y, 8)).all()
    assert true.std() > 10
    np.testing.assert_allclose(shade_pixels(lit, owner, x, y, 8), true, rtol=0, atol=1e-9)


@pytest.mark.parametrize("kind", [ColourShader, CosineShader, LightShader])
def test_errors_of_parts_are_those_of_what_is_drawn(kind: type[Shader]) -> None:
    whole = looked_at("torus:288")
    formats = Formats() if kind is ColourShader else specular_formats({}, whole, None, SHINY)
    planner = Planner(whole, kind(None, SHINY, formats, whole))
    plan = planner.for_limit(2.0)
    assert len(plan.surface.root) > len(whole) or kind is CosineShader
    assert plan.bytes == planner.bytes_of(plan.surface, plan.decision.orders, plan.table, plan.first)
    assert plan.bytes == stream_bytes(plan.triangles, formats)
    errors = plan.drawn
    pixels = draw(plan.triangles, formats).pixels
    off = pixel_errors(pixels, plan.surface.root, whole, planner.shader.lights, SHINY, formats)
    largest = np.zeros(len(plan.surface.root))
    np.maximum.at(largest, pixels.triangle, off.max(axis=1))
    np.testing.assert_allclose(errors.largest, largest, rtol=0, atol=1e-9)
    square = np.bincount(pixels.triangle, (off**2).sum(axis=1), len(largest))
    np.testing.assert_allclose(errors.square, square, rtol=1e-9)
    assert (errors.pixels == np.bincount(pixels.triangle, minlength=len(largest))).all()


def test_a_part_may_have_pixels_that_its_triangle_has_not() -> None:
    """Corners are rounded; with pixels of 4 sub-pixels that is seen. A user's reflectance is no loop."""
    mesh, formats = load_scene("torus:288"), Formats(subpixel_bits=2)
    whole = project(mesh, fit_camera(mesh), 96, 96, formats)
    parts, root = refine(whole, np.ones(len(whole), dtype=bool))
    parts, parent = refine(parts, np.ones(len(parts), dtype=bool))
    root = root[parent]
    lambert = Material(reflectance=lambda point, normal, light, viewer: np.maximum(
        np.einsum("mi,mi->m", normal, light), 0
    )[:, None] * np.array([0.9, 0.5, 0.2]))  # fmt: skip
    for material in (SHINY, lambert):
        shader = ColourShader(None, material, formats, whole)
        triangles = shader.screen_triangles(
            parts, np.full((len(parts), 3, 6), 80.0), np.zeros((len(parts), 3), int)
        )
        reference = PhongPixels(whole, shader.lights, material, formats)
        errors = reference.errors(triangles, root, formats)
        pixels = draw(triangles, formats).pixels
        mine = set(zip(*(v.tolist() for v in (root[pixels.triangle], pixels.x, pixels.y)), strict=True))
        flat = shader.screen_triangles(whole, np.zeros((len(whole), 3, 6)), np.zeros((len(whole), 3), int))
        own = draw(flat, formats).pixels
        assert len(mine - set(zip(*(v.tolist() for v in (own.triangle, own.x, own.y)), strict=True))) > 10
        off = pixel_errors(pixels, root, whole, shader.lights, material, formats)
        largest = np.zeros(len(root))
        np.maximum.at(largest, pixels.triangle, off.max(axis=1))
        np.testing.assert_allclose(errors[:, 0], largest, rtol=0, atol=1e-9)
        assert errors[:, 1].sum() == pytest.approx((off**2).sum(), rel=1e-9)


def test_pairs_keep_their_numbers() -> None:
    rng = np.random.default_rng(3)
    table, known = PairNumbers(), {}
    for count in (0, 5, 300, 40, 3000):
        first, second = rng.integers(-1, 40, (2, count))
        numbers = table.numbers(first, second)
        for pair, number in zip(zip(first.tolist(), second.tolist(), strict=True), numbers, strict=True):
            assert known.setdefault(pair, len(known)) == number
        assert len(table) == len(known)


def test_bytes_are_those_of_the_stream_where_the_set_up_divides() -> None:
    formats, whole = Formats(frac_bits=7), looked_at("torus:288", 512)
    planner = Planner(whole, ColourShader(None, SHINY, formats, whole))
    plan = planner.estimated_for_limit(6.0)
    assert planner.bytes_of(plan.surface, plan.decision.orders, plan.table) is None
    assert plan.bytes == stream_bytes(plan.triangles, formats)


@pytest.mark.parametrize(("scene", "planned_twice"), [("sphere:374", True), ("sphere:690", False)])
def test_work_is_done_once_and_only_where_it_can_win(
    scene: str, planned_twice: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Counts, not times: pixels shaded once, one kind of channels drawn, halves of few triangles judged."""
    whole = looked_at(scene, 512)
    shaded: list[int] = []
    drawn: dict[Formats, list[int]] = {}
    halves: list[int] = []
    splits: list[int] = []
    shade_rows, errors = phong_pixels.shade_rows, PhongPixels.errors

    def shading(*given: Any) -> None:
        shaded.append(given[-1].shape[1])
        shade_rows(*given)

    def drawing(
        self: PhongPixels, triangles: ScreenTriangles, root: np.ndarray, formats: Formats
    ) -> np.ndarray:
        drawn.setdefault(formats, []).append(len(triangles))
        return errors(self, triangles, root, formats)

    def judging(self: Shader, projected: Projected, options: np.ndarray) -> np.ndarray:
        halves.append(len(projected))
        return judge[type(self)](self, projected, options)

    def splitting(projected: Projected, edges: Edges, marks: np.ndarray) -> tuple[Projected, np.ndarray]:
        splits.append(len(projected))
        return split_edges(projected, edges, marks)

    monkeypatch.setattr(choose, "split_edges", splitting)
    judge = {kind: kind.halves for kind in (ColourShader, CosineShader, LightShader)}
    for kind in judge:
        monkeypatch.setattr(kind, "halves", judging)
    monkeypatch.setattr(phong_pixels, "shade_rows", shading)
    monkeypatch.setattr(PhongPixels, "errors", drawing)
    adapted = adapt(whole, None, SHINY, max_error=4.0, shading="auto")
    assert adapted.rival is not None
    # Of the smaller sphere two kinds of channels take about as much: both are drawn.
    kinds = 1 + (adapted.rival.error is not None)
    assert kinds == (2 if scene == "sphere:374" else 1)
    assert len(shaded) == 1 and shaded[0] > 1000
    assert list(drawn) == [adapted.formats]
    (counts,) = drawn.values()
    # The whole once, and once more for a coarser table; after that the few parts that other limits change.
    wholes = [count for count in counts if count >= len(whole)]
    assert len(wholes) == kinds + planned_twice
    assert max(set(counts) - set(wholes)) < len(whole) / 5
    assert sum(counts) < 1.3 * sum(wholes)
    assert planned_twice or len(counts) <= 6
    # Of all plans most are divided at the same edges.
    assert planned_twice or len(splits) <= 3
    # Judged for every triangle of all three kinds they would be three times the whole, and more for parts.
    assert 0 < sum(halves) < 0.6 * kinds * len(whole)


FORMER = {
    ("sphere:168", 16.0): 4748, ("sphere:168", 8.0): 5252, ("sphere:168", 4.0): 5428,
    ("sphere:168", 2.0): 5872, ("sphere:168", 1.0): 6784, ("sphere:168", 0.7): 9868,
    ("torus:288", 8.0): 12016, ("torus:288", 4.0): 12740, ("torus:288", 1.0): 24052,
    ("sphere:690", 4.0): 18504,
}  # fmt: skip
"""Bytes at 512 x 512 pixels in docs/reports/adapt_fits.md, without fits."""


@pytest.mark.parametrize(("scene", "error"), FORMER)
def test_no_choice_takes_more_than_the_former_one(scene: str, error: float) -> None:
    adapted = adapt(looked_at(scene, 512), None, SHINY, max_error=error, shading="auto")
    assert adapted.error <= error
    assert stream_bytes(adapted.triangles, adapted.formats) <= FORMER[scene, error]
