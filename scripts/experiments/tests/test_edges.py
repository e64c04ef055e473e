# SPDX-License-Identifier: Apache-2.0
"""The mesh's own edges, how well edge maps find them, and the report on that."""

from __future__ import annotations

import json

import numpy as np
import pytest

from quadshade.scene import fit_camera, load_scene, project
from quadshade.scene.mesh import build_mesh
from quadshade.style import draw_gbuffer
from scripts.experiments.edges import report
from scripts.experiments.edges.classify import (
    BORDER,
    CREASE,
    KINDS,
    SILHOUETTE,
    classify_edges,
    visible_edges,
)

VIEW = np.array([1.0, 0.8, 1.0])


def test_edges_of_a_cube_are_known() -> None:
    mesh = load_scene("cube:1")
    edges = classify_edges(mesh, fit_camera(mesh, direction=VIEW))
    # 12 edges and 6 diagonals; three faces are seen, around which six edges run.
    assert len(edges.ends) == 18
    assert [int(edges.kind[kind].sum()) for kind in KINDS] == [6, 0, 12]


def test_an_open_mesh_has_a_border() -> None:
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
    mesh = build_mesh(square, np.array([[0, 1, 2], [0, 2, 3]]))
    edges = classify_edges(mesh, fit_camera(mesh))
    assert [int(edges.kind[kind].sum()) for kind in KINDS] == [0, 4, 0]


def test_a_crease_needs_its_angle() -> None:
    roof = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0.0], [1, 1, 0], [0, -1, -1], [1, -1, -1]], float)
    mesh = build_mesh(roof, np.array([[0, 1, 3], [0, 3, 2], [4, 5, 1], [4, 1, 0]]))
    camera = fit_camera(mesh)
    assert classify_edges(mesh, camera, 44).kind[CREASE].sum() == 1
    assert classify_edges(mesh, camera, 46).kind[CREASE].sum() == 0


def test_only_seen_edges_count() -> None:
    mesh = load_scene("cube:1")
    camera = fit_camera(mesh, direction=VIEW)
    projected = project(mesh, camera, 100, 100)
    gbuffer, _ = draw_gbuffer(projected)
    edges = classify_edges(mesh, camera)
    creases = visible_edges(edges, edges.kind[CREASE] & ~edges.kind[SILHOUETTE], camera, gbuffer, projected)
    # Three of the inner creases meet in front; the three behind meet at the same place, and are hidden.
    middle = np.zeros((100, 100), bool)
    middle[30:70, 30:70] = True
    assert 60 < creases.sum() < 200
    assert not visible_edges(edges, edges.kind[BORDER], camera, gbuffer, projected).any()
    below = np.argwhere(creases & middle)
    assert len(below) < 100


@pytest.mark.parametrize("variant", ["diagonal", "eight"])
@pytest.mark.parametrize("scene", ["cube:2", "torus:1152"])
def test_map_finds_the_mesh_edges(scene: str, variant: str) -> None:
    rows, picture = report.measure(load_scene(scene), 160)
    row = next(row for row in rows if row["variant"] == variant)
    assert picture.shape == (160, 480, 3)
    assert row["precision"] > 0.97 and row["recall"] > 0.95
    assert row["profile_recall"] > 0.9 and row["inner_recall_of_creases"] == 1


def test_the_committed_report_is_its_data() -> None:
    data = json.loads(report.REPORT.with_suffix(".json").read_text())
    written = report.REPORT.read_text()
    assert report.table(data["scenes"]) in written
    assert report.claim(data["scenes"]) in written
