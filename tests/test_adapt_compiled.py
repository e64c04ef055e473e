# SPDX-License-Identifier: Apache-2.0
"""Compiled loops over edges, parts and highlights against array expressions of the same."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from quadshade.adapt import cho as adapt_cho
from quadshade.adapt import highlight
from quadshade.scene import Projected, fit_camera, load_scene, parse_camera, project, subdivide_loops
from quadshade.scene import subdivide as divided
from quadshade.shading import AmbientLight, DirectionalLight, Material, PointLight
from scripts.experiments.cho.teapot import teapot
from tests.support import adapt_reference as reference

LIGHTS = (
    AmbientLight(),
    PointLight((3.0, 4.0, 5.0)),
    PointLight((-4.0, 2.0, 1.0), (0.5, 0.4, 0.3), (1.0, 0.1, 0.0)),
    DirectionalLight((1.0, 2.0, 0.5)),
)
SHINY = Material(exponent=50)


def scenes() -> list[Projected]:
    """Closed, open and creased meshes, in perspective and parallel, some larger than the screen."""
    made = []
    for mesh in (teapot(), load_scene("torus:288"), load_scene("cube:3")):
        for direction in ([0.4, 0.5, 1.0], [-1.0, 0.2, 0.3]):
            made.append(project(mesh, fit_camera(mesh, direction=np.array(direction)), 200, 160))
        made.append(project(mesh, parse_camera("ortho=0.6", mesh), 120, 120))
    return made


SCENES = scenes()


def same(got: Projected, expected: Projected) -> None:
    """The same triangles: vertices exactly, what is interpolated up to rounding."""
    assert (got.vertices == expected.vertices).all()
    assert (got.source == expected.source).all()
    for name in ("position", "normal", "weight", "depth"):
        np.testing.assert_allclose(getattr(got, name), getattr(expected, name), rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("projected", SCENES)
def test_edges_are_those_of_sorted_pairs(projected: Projected) -> None:
    got, expected = divided.shared_edges(projected.vertices), reference.shared_edges(projected.vertices)
    assert len(got) == len(expected)
    assert (got.reversed == expected.reversed).all()
    # Numbered otherwise: by first appearance, not by place.
    assert (got.ends[got.index] == expected.ends[expected.index]).all()
    assert len(np.unique(np.stack([got.index.ravel(), expected.index.ravel()]), axis=1).T) == len(got)


@pytest.mark.parametrize("projected", SCENES)
@pytest.mark.parametrize("share", [False, True])
def test_parts_are_those_of_the_patterns(projected: Projected, share: bool) -> None:
    rng = np.random.default_rng(len(projected))
    ours, theirs = (module.shared_edges(projected.vertices) for module in (divided, reference))
    number = np.zeros(len(theirs), dtype=np.int64)
    number[theirs.index] = ours.index
    for part in (0.1, 0.5, 1.0):
        marks = rng.random(len(ours)) < part
        places = rng.random(len(ours)) if share else None
        got, parent = divided.split_edges(projected, ours, marks, places)
        expected, parents = reference.split_edges(
            projected, theirs, marks[number], None if places is None else places[number]
        )
        assert (parent == parents).all()
        assert len(parent) > len(projected)
        same(got, expected)


def test_parts_of_a_few_sub_pixels_stay_sound() -> None:
    rng = np.random.default_rng(8)
    whole = SCENES[0]
    for size in (2, 3, 6, 20):
        small = replace(whole, vertices=rng.integers(0, size, whole.vertices.shape))
        wanted = rng.random((len(small), 3)) < 0.6
        got, parent = divided.refine(small, wanted)
        edges = reference.shared_edges(small.vertices)
        expected, parents = reference.split_edges(small, edges, edges.marked(wanted))
        assert (parent == parents).all()
        same(got, expected)


def test_colours_of_a_mesh_are_carried() -> None:
    rng = np.random.default_rng(2)
    whole = replace(SCENES[0], colour=rng.random((len(SCENES[0]), 3, 3)))
    wanted = rng.random((len(whole), 3)) < 0.3
    got, _ = divided.refine(whole, wanted)
    edges = reference.shared_edges(whole.vertices)
    expected, _ = reference.split_edges(whole, edges, edges.marked(wanted))
    np.testing.assert_allclose(got.colour, expected.colour, rtol=1e-12)


@pytest.mark.parametrize("projected", SCENES)
def test_inserted_vertices(projected: Projected) -> None:
    rng = np.random.default_rng(4)
    triangle = np.flatnonzero(rng.random(len(projected)) < 0.4)
    barycentric = rng.dirichlet((0.3, 0.3, 0.3), len(triangle))
    got, parent = divided.insert_vertices(projected, triangle, barycentric)
    expected, parents = reference.insert_vertices(projected, triangle, barycentric)
    assert (parent == parents).all()
    assert len(projected) < len(parent) < len(projected) + 2 * len(triangle) + 1
    same(got, expected)


@pytest.mark.parametrize("projected", SCENES)
def test_highlights_are_named_and_found_alike(projected: Projected) -> None:
    named = reference.potentially_highlighted(projected, LIGHTS)
    assert (highlight.potentially_highlighted(projected, LIGHTS) == named).all()
    assert not named[0].any()
    for light, found in zip(LIGHTS[1:], named[1:], strict=True):
        near = reference.with_neighbours(projected.vertices, found)
        assert (highlight.with_neighbours(projected.vertices, found) == near).all()
        for repeats in (0, 1, 3):
            # Every triangle, so that what is not a highlight is tried too.
            triangle = np.arange(len(projected))
            got = highlight.highlight_centres(projected, triangle, light, repeats)
            expected = reference.highlight_centres(projected, triangle, light, repeats)
            assert (got[1] == expected[1])[found].all()
            np.testing.assert_allclose(got[0][found], expected[0][found], atol=1e-8)
            assert (got[1] == expected[1]).mean() > 0.99


@pytest.mark.parametrize("projected", SCENES)
def test_corners_at_places(projected: Projected) -> None:
    rng = np.random.default_rng(6)
    places = projected.vertices.reshape(-1, 2)[rng.integers(0, 3 * len(projected), 17)]
    places = np.concatenate([places, rng.integers(0, 200, (5, 2))])
    expected = (projected.vertices[:, :, None] == places).all(axis=3).any(axis=(1, 2))
    assert (subdivide_loops.touching(projected.vertices, places) == expected).all()
    assert not subdivide_loops.touching(projected.vertices, np.zeros((0, 2), dtype=np.int64)).any()


CREASED = replace(SCENES[0], normal=np.random.default_rng(3).normal(size=SCENES[0].normal.shape))
"""No two triangles have the same normal at a vertex that they share."""


@pytest.mark.parametrize("projected", [SCENES[0], SCENES[3], CREASED], ids=["teapot", "torus", "creased"])
@pytest.mark.parametrize("threshold", [0.01, 0.1, 0.3])
def test_edges_are_judged_alike_by_loops_and_by_arrays(
    projected: Projected, threshold: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Point lights in perspective are the loop's; arrays judge what only they can light."""
    ids, places = subdivide_loops.place_numbers(projected.vertices)
    edges = divided.Edges(*subdivide_loops.edge_numbers(ids, places))
    candidates = np.random.default_rng(9).random(len(projected)) < 0.7
    arguments = (projected, candidates, ids, edges, LIGHTS[:3], SHINY, threshold)
    got = adapt_cho._large_differences(*arguments)

    def refuse(*_):
        raise adapt_cho.QuadshadeError("no loop")

    monkeypatch.setattr(adapt_cho, "compiled_surface", refuse)
    expected = adapt_cho._large_differences(*arguments)
    assert (got == expected).all()
    assert 0 < got.sum() < len(edges)


def test_directional_lights_are_subdivided_for_too() -> None:
    for projected in (SCENES[0], SCENES[2]):
        made = adapt_cho.highlight_subdivision(projected, LIGHTS, SHINY, 0.1)
        assert len(made.projected) > len(projected)
        assert made.subdivided.sum() > 0
