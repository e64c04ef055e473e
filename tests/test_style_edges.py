# SPDX-License-Identifier: Apache-2.0
"""Edges over pictures, the mesh's own edges, and how well the first find the second."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from quadshade.cli.main import main
from quadshade.image import read_picture
from quadshade.scene import fit_camera, load_scene, project
from quadshade.scene.mesh import build_mesh
from quadshade.style import EdgeMaps, draw_edges, draw_gbuffer, find_edges
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
    import json

    data = json.loads(report.REPORT.with_suffix(".json").read_text())
    written = report.REPORT.read_text()
    assert report.table(data["scenes"]) in written
    assert report.claim(data["scenes"]) in written


def test_kinds_keep_their_colours() -> None:
    depth = np.full((3, 3), 255, np.uint8)
    normal = depth.copy()
    depth[0, 0], normal[2, 2] = 0, 0
    maps = EdgeMaps(normal, depth, "diagonal")
    white = np.full((3, 3, 3), 255, np.uint8)
    inks = {"profile": (1, 0, 0), "inner": (0, 0, 1)}
    both = draw_edges(white, maps, colours=inks)
    assert both[0, 0].tolist() == [255, 0, 0] and both[2, 2].tolist() == [0, 0, 255]
    assert (both[1] == 255).all()
    assert (draw_edges(white, maps, ("profile",), inks)[2] == 255).all()


def render(tmp_path: Path, *arguments: str) -> tuple[int, str, np.ndarray | None]:
    picture = tmp_path / "a.png"
    base = ["render", "cube:2", "-o", str(picture), "--size", "64x64", "--engine", "model"]
    result = CliRunner().invoke(main, [*base, *arguments])
    return result.exit_code, result.output, read_picture(picture) if result.exit_code == 0 else None


def test_render_draws_edges_on_paper(tmp_path: Path) -> None:
    _, _, plain = render(tmp_path, "--camera", "from=1,0.8,1", "--background", "1")
    code, output, edged = render(tmp_path, "--camera", "from=1,0.8,1", "--edges", "profile,inner")
    assert code == 0, output
    mesh = load_scene("cube:2")
    gbuffer, _ = draw_gbuffer(project(mesh, fit_camera(mesh, direction=VIEW), 64, 64))
    assert np.array_equal(edged, draw_edges(plain, find_edges(gbuffer)))
    assert (edged != plain).any()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--edges", "outer"), "give profile, inner"),
        (("--edge-color", "inner=1,0,0"), "give --edges inner"),
        (("--edges", "inner", "--edge-color", "inner=2,0,0"), "numbers from 0 to 1"),
        (("--gbuffer", "a.txt"), "ends in .npz"),
        (("--style", "cartoon", "--shading", "phong"), "exclude each other"),
        (("--style", "cartoon", "--max-error", "3"), "exclude each other"),
        (("--style", "gooch", "--shading", "quadratic-specular"), "exclude each other"),
        (("--style", "gooch", "--light", "ambient=1"), "not ambient"),
        (("--style", "gooch", "--reflectance", "a:b"), "exclude each other"),
        (("--edges", "inner", "--generic", "with_depth=0"), "needs depth"),
    ],
)
def test_wrong_choices(tmp_path: Path, arguments: tuple[str, ...], message: str) -> None:
    code, output, _ = render(tmp_path, *arguments)
    assert code == 2 and message in output, output
