# SPDX-License-Identifier: Apache-2.0
"""Levels of detail: fewer triangles, with the normals, colours, seams and creases of all of them."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from quadshade.errors import QuadshadeError
from quadshade.scene import Mesh, build_mesh, level_of_detail, load_scene
from quadshade.scene.decimate import decimate
from quadshade.scene.detail import coarser_name, levels
from quadshade.scene.mesh import face_normals

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"


@pytest.fixture(scope="module")
def knot() -> Mesh:
    return load_scene(EXAMPLES / "knot.glb")


@pytest.fixture(scope="module")
def pawn() -> Mesh:
    return load_scene(EXAMPLES / "pawn.obj")


def open_edges(mesh: Mesh) -> set[tuple[tuple[float, ...], ...]]:
    """Ends of the edges that only one face has, as places."""
    ends = np.stack([mesh.corners, np.roll(mesh.corners, -1, axis=1)], axis=2).reshape(-1, 2, 3)
    keys = [tuple(sorted(map(tuple, np.round(edge, 9).tolist()))) for edge in ends]
    once: set[tuple[tuple[float, ...], ...]] = set()
    for key in keys:
        once ^= {key}
    return once


@pytest.mark.parametrize("count", [1000, 300, 60])
def test_a_closed_smooth_mesh_stays_so(knot: Mesh, count: int) -> None:
    coarse = decimate(knot, count)
    assert 0.9 * count <= len(coarse) <= count
    assert not open_edges(knot) and not open_edges(coarse)
    # One normal a vertex, and it is that of the fine surface there.
    for vertex in np.unique(coarse.faces):
        normals = coarse.normals[coarse.faces == vertex]
        assert np.ptp(normals, axis=0).max() < 1e-12
    places, normals = knot.corners.reshape(-1, 3), knot.normals.reshape(-1, 3)
    nearest = np.linalg.norm(coarse.corners.reshape(-1, 1, 3)[::3] - places[None], axis=2).argmin(axis=1)
    agree = np.einsum("ni,ni->n", coarse.normals.reshape(-1, 3)[::3], normals[nearest])
    assert np.median(agree) > 0.97 and agree.min() > 0.5
    assert np.allclose(np.linalg.norm(coarse.normals, axis=2), 1)
    assert coarse.colours.min() >= 0 and coarse.colours.max() <= 1 and np.ptp(coarse.colours) > 0.5


def test_seams_and_borders_stay(pawn: Mesh) -> None:
    coarse = decimate(pawn, 300)
    assert 250 <= len(coarse) <= 300
    # Four squares and a pawn: flat colours, none of them mixed.
    fine = np.unique(np.round(pawn.colours.reshape(-1, 3), 6), axis=0)
    assert len(fine) == 3
    assert np.array_equal(np.unique(np.round(coarse.colours.reshape(-1, 3), 6), axis=0), fine)
    assert np.ptp(coarse.colours, axis=1).max() < 1e-9
    assert open_edges(coarse) == open_edges(pawn)


def test_creases_stay() -> None:
    cube = load_scene("cube:8")
    coarse = decimate(cube, 24)
    assert 12 <= len(coarse) <= 24
    assert np.allclose(coarse.normals, face_normals(coarse.corners)[:, None])
    assert np.allclose(np.abs(coarse.corners).max(axis=(0, 1)), 1) and not open_edges(coarse)


def test_double_sided_faces_stay_so() -> None:
    sheet = load_scene("cube:8")
    upper = sheet.corners[..., 1].min(axis=1) > 0.99
    given = build_mesh(sheet.vertices, sheet.faces, sheet.normals, double_sided=upper)
    coarse = decimate(given, 40)
    assert np.array_equal(coarse.double_sided, coarse.corners[..., 1].min(axis=1) > 0.99)
    assert 0 < coarse.double_sided.sum() < len(coarse)


def test_faces_without_area_are_left_out_first() -> None:
    cube = load_scene("cube:2")
    flat = np.repeat(cube.faces[:, :1], 3, axis=1)[:10]
    mesh = build_mesh(cube.vertices, np.concatenate([cube.faces, flat]))
    coarse = decimate(mesh, len(cube))
    assert len(coarse) == len(cube)


@pytest.mark.parametrize("scale", [1e-12, 1e12])
def test_size_and_place_do_not_matter(knot: Mesh, scale: float) -> None:
    moved = build_mesh(knot.vertices * scale + 3 * scale, knot.faces, knot.normals)
    assert len(decimate(moved, 500)) == len(
        decimate(build_mesh(knot.vertices, knot.faces, knot.normals), 500)
    )


@pytest.mark.parametrize(
    ("scene", "count", "name"),
    [
        ("sphere:690", 374, "sphere:12x17"),
        ("sphere:690", 6, "sphere:2x3"),
        ("torus:288", 72, "torus:8x4"),
        ("icosphere:4", 1279, "icosphere:2"),
        ("icosphere:4", 1280, "icosphere:3"),
        ("cube:8", 50, "cube:2"),
    ],
)
def test_generated_scenes_have_their_own(scene: str, count: int, name: str) -> None:
    assert coarser_name(scene, count) == name
    whole = load_scene(scene)
    coarse = level_of_detail(whole, count, scene)
    assert count * 0.2 <= len(coarse) <= count
    assert len(coarse) == len(load_scene(name))


@pytest.mark.parametrize("kind", ["sphere:690", "sphere:40x3", "torus:288", "torus:40x3"])
def test_every_count_has_a_grid_that_uses_it(kind: str) -> None:
    whole = load_scene(kind)
    for count in range(20, len(whole) + 1, 7):
        size = len(load_scene(coarser_name(kind, count)))
        assert 0.6 * count <= size <= count


def test_levels_fall_to_the_least() -> None:
    assert levels(100) == [50, 25, 12, 6]
    assert levels(4) == levels(1) == []


@pytest.mark.parametrize(
    ("scene", "count", "said"),
    [
        ("sphere:168", 3, "--lod 3; give at least 4"),
        ("sphere:168", 169, "the mesh has 168 triangles; give fewer"),
        ("sphere:168", 5, "no sphere has so few triangles; give at least 6"),
        ("torus:288", 17, "no torus has so few triangles; give at least 18"),
        ("icosphere:2", 19, "no icosphere has so few triangles; give at least 20"),
        ("cube:2", 11, "no cube has so few triangles; give at least 12"),
    ],
)
def test_refusals(scene: str, count: int, said: str) -> None:
    with pytest.raises(QuadshadeError) as refused:
        level_of_detail(load_scene(scene), count, scene)
    assert said in str(refused.value)


def test_what_cannot_be_decimated_is_refused() -> None:
    """Triangles that share nothing: every edge is a border."""
    rng = np.random.default_rng(1)
    soup = build_mesh(rng.normal(size=(60, 3)), np.arange(60).reshape(-1, 3))
    with pytest.raises(QuadshadeError, match="none of the mesh's 20 triangles can be left out"):
        decimate(soup, 10)


def test_what_stops_early_says_so(pawn: Mesh) -> None:
    coarse = decimate(pawn, 20)
    assert len(coarse) > 20 and "instead of 20: no more edges collapse" in coarse.notes[-1]


def test_a_missing_decimator_is_one_line(knot: Mesh, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "fast_simplification", None)
    with pytest.raises(QuadshadeError, match=r"fast-simplification is not installed.*quadshade\[lod\]"):
        decimate(knot, 100)
    assert len(level_of_detail(load_scene("sphere:690"), 100, "sphere:690")) <= 100
