# SPDX-License-Identifier: Apache-2.0
"""Division opens no cracks: what the undivided mesh covers is drawn exactly as often by its parts."""

from __future__ import annotations

import numpy as np
import pytest

from quadshade.adapt import (
    centre_error,
    centre_subdivision,
    highlight_subdivision,
    refine,
    regular_subdivision,
    shared_edges,
)
from quadshade.contract.formats import Formats
from quadshade.engine import draw
from quadshade.scene import fit_camera, load_scene, project
from quadshade.scene.project import Projected, doubled_area
from quadshade.shading import Material, PointLight, sample
from quadshade.shading.reference import phong

FORMATS = Formats()
LIGHTS = [PointLight((3.0, 3.0, 4.0)), PointLight((-3.0, 1.0, 4.0), (0.5, 0.5, 0.5))]
SHINY = Material(exponent=60)


def projected_scene(scene: str, size: int = 512, **camera: object) -> Projected:
    mesh = load_scene(scene)
    return project(mesh, fit_camera(mesh, **camera), size, size)


def times_drawn(projected: Projected) -> np.ndarray:
    """(height, width) how often the golden model draws each pixel."""
    pixels = draw(sample(projected, "flat"), FORMATS).pixels
    count = np.zeros((projected.height, projected.width), dtype=np.int64)
    np.add.at(count, (pixels.y, pixels.x), 1)
    return count


def check_watertight(whole: Projected, parts: Projected) -> int:
    """Pixels compared; a pixel may differ only at the mesh's border, whose split edges are rounded too."""
    before, after = times_drawn(whole), times_drawn(parts)
    padded = np.pad(before, 1, mode="edge")
    shifts = [(dy, dx) for dy in range(3) for dx in range(3)]
    around = np.stack([padded[dy : dy + whole.height, dx : dx + whole.width] for dy, dx in shifts])
    interior = (around == before).all(axis=0)
    np.testing.assert_array_equal(after[interior], before[interior])
    assert (before != after).sum() <= 20
    return int((interior & (before > 0)).sum())


def test_every_way_of_dividing_is_watertight() -> None:
    pixels = divided = 0
    for scene, camera in (
        ("sphere:168", {}),
        ("sphere:690", {"direction": (1.0, 2.0, 3.0)}),
        ("torus:288", {"direction": (0.3, 1.0, 0.7)}),
        ("icosphere:2", {"ortho": 1.1}),
    ):
        whole = projected_scene(scene, **camera)
        ways = [centre_subdivision(whole, threshold, LIGHTS, SHINY)[0] for threshold in (4.0, 0.5)]
        ways += [regular_subdivision(whole, LIGHTS, area).projected for area in (300.0, 20.0)]
        ways += [highlight_subdivision(whole, LIGHTS, SHINY).projected]
        for parts in ways:
            divided += len(parts) > len(whole)
            pixels += check_watertight(whole, parts)
    assert divided >= 16
    assert pixels > 1_000_000


@pytest.mark.parametrize("seed", [1, 2])
def test_any_edges_may_be_split_again_and_again(seed: int) -> None:
    rng = np.random.default_rng(seed)
    whole = projected_scene("sphere:374")
    parts = whole
    for _ in range(5):
        parts, _ = refine(parts, rng.random((len(parts), 3)) < 0.4)
    assert len(parts) > 20 * len(whole)
    assert check_watertight(whole, parts) > 100_000


def grid(rng: np.random.Generator, columns: int, rows: int, step: int) -> Projected:
    """A sheet of triangles of few sub-pixels, its inner vertices shaken: an open mesh."""
    x, y = np.meshgrid(np.arange(columns + 1), np.arange(rows + 1))
    points = np.stack([x, y], axis=2) * step
    points[1:-1, 1:-1] += rng.integers(-(step // 4), step // 4 + 1, points[1:-1, 1:-1].shape)
    first, right = points[:-1, :-1], points[:-1, 1:]
    below, across = points[1:, :-1], points[1:, 1:]
    vertices = np.concatenate(
        [np.stack(t, axis=2).reshape(-1, 3, 2) for t in ((first, below, right), (right, below, across))]
    )
    count = len(vertices)
    ones = np.ones((count, 3))
    normal = np.zeros((count, 3, 3)) + (0.0, 0, 1)
    return Projected(
        64, 64, vertices, ones, normal, normal, None, ones, np.arange(count), None, np.eye(3)
    )  # fmt: skip


@pytest.mark.parametrize("step", [2, 3, 5, 40, 300])
def test_triangles_of_a_few_sub_pixels(step: int) -> None:
    rng = np.random.default_rng(step)
    whole = grid(rng, 12, 12, step)
    parts = whole
    for _ in range(4):
        parts, _ = refine(parts, rng.random((len(parts), 3)) < 0.6)
        area = doubled_area(parts.vertices)
        assert (area < 0).all()
    assert len(shared_edges(parts.vertices)) > len(shared_edges(whole.vertices)) or step == 2
    inner = times_drawn(parts)[1:-1, 1:-1]
    np.testing.assert_array_equal(inner, times_drawn(whole)[1:-1, 1:-1])
    edges = shared_edges(parts.vertices)
    uses = np.bincount(edges.index.ravel(), minlength=len(edges))
    border = ((edges.ends == 0) | (edges.ends == 12 * step)).all(axis=1).any(axis=1)
    # Inside, every edge has two triangles: no vertex lies in the middle of a neighbour's edge.
    assert (uses[~border] == 2).all()
    assert (uses[border] == 1).all()


def test_parts_are_shaded_as_the_whole() -> None:
    whole = projected_scene("sphere:168")
    parts, parent = refine(whole, np.random.default_rng(7).random((len(whole), 3)) < 0.5)
    parts, more = refine(parts, np.ones(len(parts), dtype=bool))
    root = parent[more]
    pixels = draw(sample(parts, "flat"), FORMATS).pixels
    ours = phong(parts, pixels.triangle, pixels.x, pixels.y, LIGHTS, SHINY)
    theirs = phong(whole, root[pixels.triangle], pixels.x, pixels.y, LIGHTS, SHINY)
    # Vertices are rounded to sub-pixels, which moves colours by a fraction of a grey level.
    assert abs(ours - theirs).max() < 0.35


def test_centres_are_right_after_division() -> None:
    whole = projected_scene("sphere:168")
    before = centre_error(whole, LIGHTS, SHINY)
    parts, root = centre_subdivision(whole, 1.0, LIGHTS, SHINY)
    assert before.max() > 10
    assert centre_error(parts, LIGHTS, SHINY).max() <= 1.0
    untouched = np.bincount(root) == 1
    assert untouched.any() and not untouched.all()
