# SPDX-License-Identifier: Apache-2.0
"""The H1 and H2 test and the highlight's centre, against dense sampling of the triangles."""

from __future__ import annotations

import numpy as np
import pytest

from quadshade.adapt import (
    highlight_centres,
    highlight_possible,
    highlight_subdivision,
    potentially_highlighted,
    regular_subdivision,
    with_neighbours,
)
from quadshade.adapt.highlight import to_light
from quadshade.scene import fit_camera, load_scene, project
from quadshade.scene.project import Projected, doubled_area
from quadshade.scene.subdivide import divided, refine
from quadshade.shading import AmbientLight, DirectionalLight, PointLight

STEPS = 48


def projected_scene(scene: str, ortho: float | None = None) -> Projected:
    mesh = load_scene(scene)
    return project(mesh, fit_camera(mesh, ortho=ortho), 256, 256)


def random_lights(count: int, seed: int) -> list[PointLight]:
    rng = np.random.default_rng(seed)
    return [PointLight(tuple(rng.uniform(-4, 4, 2)) + (float(rng.uniform(2, 5)),)) for _ in range(count)]


def cells() -> np.ndarray:
    """(k, 3, 3) barycentric corners of the small triangles that a triangle is made of."""
    small = []
    for i in range(STEPS):
        for j in range(STEPS - i):
            small.append([(i, j), (i + 1, j), (i, j + 1)])
            if i + j < STEPS - 1:
                small.append([(i + 1, j), (i + 1, j + 1), (i, j + 1)])
    places = np.array(small) / STEPS
    return np.concatenate([1 - places.sum(axis=2, keepdims=True), places], axis=2)


CELLS = cells()


def holds_centre(position: np.ndarray, normal: np.ndarray, light: object, eye: np.ndarray) -> bool:
    """Whether N meets the half vector anywhere on a triangle: both components cross zero in a small cell."""
    places = (CELLS @ position).reshape(-1, 3)
    normals = (CELLS @ normal).reshape(-1, 3)
    light_vector, viewer = to_light(places, light), eye - places
    unit = [v / np.linalg.norm(v, axis=1, keepdims=True) for v in (light_vector, viewer, normals)]
    half = unit[0] + unit[1]
    # N is along H where N x H vanishes: two components across the mean normal say so.
    mean = normal.mean(axis=0) / np.linalg.norm(normal.mean(axis=0))
    along = np.cross(mean, np.eye(3)[np.argmin(abs(mean))])
    frame = np.stack([along, np.cross(mean, along)], axis=1)
    miss = (np.cross(unit[2], half) @ frame).reshape(-1, 3, 2)
    ahead = ((half * unit[2]).sum(axis=1) > 0).reshape(-1, 3).all(axis=1)
    first, second = miss[:, 1] - miss[:, 0], miss[:, 2] - miss[:, 0]
    area = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        u = (-miss[:, 0, 0] * second[:, 1] + miss[:, 0, 1] * second[:, 0]) / area
        v = (-first[:, 0] * miss[:, 0, 1] + first[:, 1] * miss[:, 0, 0]) / area
    return bool((ahead & (u >= 0) & (v >= 0) & (u + v <= 1)).any())


def counts(scene: str, lights: int, seed: int) -> tuple[int, int, int, int]:
    """Triangles tested, with a centre, of them missed, and named without a centre."""
    projected = projected_scene(scene)
    tested = true = missed = spare = 0
    for light in random_lights(lights, seed):
        named = potentially_highlighted(projected, [light])[0]
        held = np.array(
            [
                holds_centre(position, normal, light, projected.eye)
                for position, normal in zip(projected.position, projected.normal, strict=True)
            ]
        )
        tested, true = tested + len(named), true + held.sum()
        missed, spare = missed + (held & ~named).sum(), spare + (named & ~held).sum()
    return tested, int(true), int(missed), int(spare)


@pytest.mark.parametrize(("scene", "lights"), [("sphere:168", 10), ("torus:288", 4)])
def test_no_centre_is_missed_and_few_triangles_are_named(scene: str, lights: int) -> None:
    tested, true, missed, spare = counts(scene, lights, seed=1)
    print(f"{scene}: {tested} tested, {true} with a centre, {missed} missed, {spare} named without one")
    assert true >= lights
    assert missed == 0
    assert true + spare < 0.1 * tested


def test_back_facing_triangles_and_ambient_light_are_left_out() -> None:
    projected = projected_scene("sphere:168")
    behind = PointLight((0.0, 0.0, -10.0))
    assert not potentially_highlighted(projected, [behind, AmbientLight()]).any()
    normal = np.array([[[1.0, 0, 1], [-1, 0.1, 1], [0, -1, 1]]])
    up = np.zeros((1, 3, 3)) + (0.2, 0.1, 1)
    viewer = np.zeros((1, 3, 3)) + (-0.1, 0.2, 1)
    assert highlight_possible(normal, up, viewer).all()
    assert not highlight_possible(-normal, up, viewer).any()


def test_lengths_do_not_matter() -> None:
    rng = np.random.default_rng(3)
    normal, light, viewer = rng.normal(size=(3, 2000, 3, 3))
    light[..., 2], viewer[..., 2], normal[..., 2] = 2, 2, 2
    named = highlight_possible(normal, light, viewer)
    scales = rng.uniform(0.1, 10, (3, 2000, 3, 1))
    assert 0 < named.sum() < len(named)
    np.testing.assert_array_equal(
        highlight_possible(normal * scales[0], light * scales[1], viewer * scales[2]), named
    )


@pytest.mark.parametrize(
    ("light", "ortho"),
    [(PointLight((2.0, 3.0, 4.0)), None), (DirectionalLight((0.3, 0.4, 1.0)), None),
     (DirectionalLight((0.3, 0.4, 1.0)), 1.2)],
    ids=["point", "directional", "orthographic"],
)  # fmt: skip
def test_centre_lies_halfway_between_light_and_viewer(light: object, ortho: float | None) -> None:
    projected = projected_scene("sphere:690", ortho)
    named = np.flatnonzero(potentially_highlighted(projected, [light])[0])
    angles = []
    for repeats in (0, 3):
        centre, inside = highlight_centres(projected, named, light, repeats)
        assert inside.any()
        place, normal = (
            np.einsum("kj,kjx->kx", centre[inside], corners[named[inside]])
            for corners in (projected.position, projected.normal)
        )
        to_eye = projected.axes[2][None] if projected.eye is None else projected.eye - place
        half = sum(v / np.linalg.norm(v, axis=1, keepdims=True) for v in (to_light(place, light), to_eye))
        off = np.linalg.norm(np.cross(normal, half), axis=1)
        angles.append((off / np.linalg.norm(normal, axis=1) / np.linalg.norm(half, axis=1)).max())
    # The direct solution is within a few thousandths of a right angle; refinement squares that.
    assert angles[0] < 5e-3
    assert angles[1] < 1e-6


def test_neighbours_share_a_vertex() -> None:
    projected = projected_scene("sphere:168")
    chosen = np.zeros(len(projected), dtype=bool)
    chosen[20] = True
    corners = {tuple(v) for v in projected.vertices[20].tolist()}
    expected = [any(tuple(v) in corners for v in t) for t in projected.vertices.tolist()]
    np.testing.assert_array_equal(with_neighbours(projected.vertices, chosen), expected)
    assert 8 < sum(expected) < 30


@pytest.mark.parametrize("threshold", [32.0, 100.0])
def test_regular_subdivision_stops_at_the_threshold(threshold: float) -> None:
    projected = projected_scene("sphere:374")
    adapted = regular_subdivision(projected, random_lights(2, 4), threshold)
    near = with_neighbours(projected.vertices, adapted.highlighted)
    area = abs(doubled_area(adapted.projected.vertices)) / 2 / 65536
    # Rounding to sub-pixels moves an area a little from a quarter of its parent's.
    assert area[near[adapted.root]].max() < 1.1 * threshold
    large = abs(doubled_area(projected.vertices)) / 2 / 65536 >= threshold
    assert (adapted.subdivided[near] == large[near]).mean() > 0.9
    assert len(adapted.projected) > len(projected)


def test_highlight_subdivision_follows_its_threshold() -> None:
    projected, lights = projected_scene("sphere:374"), random_lights(3, 5)
    sizes = [len(highlight_subdivision(projected, lights, threshold=t).projected) for t in (0.3, 0.05)]
    assert len(projected) < sizes[0] < sizes[1]


def test_where_nothing_is_highlighted_nothing_is_divided() -> None:
    """A light behind the scene; none of the triangles is a candidate, of none is the light computed."""
    projected = projected_scene("cube:1")
    adapted = highlight_subdivision(projected, [DirectionalLight((-0.7, -0.65, -1.0))], threshold=0.05)
    assert not adapted.highlighted.any() and not adapted.subdivided.any()
    np.testing.assert_array_equal(adapted.projected.vertices, projected.vertices)


@pytest.mark.parametrize("shape", ((0,), (0, 3)))
def test_no_triangles_are_refined_to_none(shape: tuple[int, ...]) -> None:
    projected = projected_scene("cube:1")
    none = divided(projected, np.zeros(0, np.int64), np.zeros((0, 3, 3)), np.zeros((0, 3, 2), np.int64))
    refined, parent = refine(none, np.zeros(shape, bool))
    assert len(refined) == len(parent) == 0
