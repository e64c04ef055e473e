# SPDX-License-Identifier: Apache-2.0
"""The renderer of Cho's tables against the references, and the tables: counts, errors, the report's text."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

from quadshade.adapt import potentially_highlighted, regular_subdivision, with_neighbours
from quadshade.contract.formats import Formats
from quadshade.engine import draw
from quadshade.errors import QuadshadeError
from quadshade.scene import fit_camera, load_scene, project
from quadshade.scene.project import doubled_area
from quadshade.shading import DEFAULT_LIGHTS, sample
from quadshade.shading.material import Material
from quadshade.shading.reference import interpolated, phong
from scripts.experiments.cho import tables as cho
from scripts.experiments.cho.renderer import Picture, draw_software
from scripts.experiments.cho.teapot import teapot

MATERIAL = Material(exponent=50.0)


@pytest.fixture(scope="module")
def data(tmp_path_factory) -> dict:
    """The report of two small views."""
    output = tmp_path_factory.mktemp("cho") / "cho.md"
    arguments = ["--size", "64", "--size", "256", "--views", "2", "--repeats", "1", "--output", str(output)]
    done = CliRunner().invoke(cho.main, arguments, catch_exceptions=False)
    assert done.exit_code == 0
    return {"text": output.read_text(), **json.loads(output.with_suffix(".json").read_text())}


@pytest.mark.parametrize("model", ["blinn", "phong"])
@pytest.mark.parametrize("scene", ["torus:288", "sphere:168"])
def test_both_rules_are_those_of_the_references(scene, model):
    mesh, material = load_scene(scene), replace(MATERIAL, model=model)
    lights = cho.four_lights(mesh)
    projected = project(mesh, fit_camera(mesh, direction=np.array([0.4, 0.5, 1.0])), 96, 80)
    per_pixel = np.arange(len(projected)) % 2 == 0
    picture = draw_software(projected, lights, material, per_pixel)
    y, x = np.nonzero(picture.triangle >= 0)
    triangle = picture.triangle[y, x]
    linear = interpolated(sample(projected, "gouraud", lights, material), triangle, x, y)
    exact = phong(projected, triangle, x, y, lights, material)
    expected = np.where(per_pixel[triangle][:, None], exact, linear)
    assert abs(picture.value[y, x] - expected).max() < 1e-9


def test_coverage_is_the_cores():
    """Of a convex mesh no pixel has two triangles, so the core's list of pixels is the map."""
    mesh = load_scene("sphere:168")
    projected = project(mesh, fit_camera(mesh, direction=np.array([0.4, 0.5, 1.0])), 96, 80)
    drawn = draw(sample(projected, "flat"), Formats(with_depth=False)).pixels
    expected = np.full((80, 96), -1)
    expected[drawn.y, drawn.x] = drawn.triangle
    assert (draw_software(projected, cho.four_lights(mesh)).triangle == expected).all()


def test_a_picture_is_cleared_before_it_is_drawn_over():
    mesh = load_scene("torus:288")
    lights, picture = cho.four_lights(mesh), Picture.empty(64, 64)
    for direction in np.eye(3):
        projected = project(mesh, fit_camera(mesh, direction=direction), 64, 64)
        again = draw_software(projected, lights, MATERIAL, over=picture)
        new = draw_software(projected, lights, MATERIAL)
        assert again is picture
        for name in ("value", "triangle", "depth"):
            assert (getattr(again, name) == getattr(new, name)).all()


def test_what_the_renderer_cannot_light_is_refused():
    mesh = load_scene("sphere:168")
    projected = project(mesh, fit_camera(mesh), 32, 32)
    with pytest.raises(QuadshadeError, match="directional"):
        draw_software(projected, DEFAULT_LIGHTS)
    with pytest.raises(QuadshadeError, match="reflectance"):
        draw_software(projected, (), replace(MATERIAL, reflectance=lambda *vectors: vectors[0]))


def test_the_teapot_is_that_of_the_paper():
    mesh = teapot()
    assert len(mesh) == 896
    corners = mesh.vertices[mesh.faces]
    flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    empty = np.linalg.norm(flat, axis=1) < 1e-9
    assert empty.sum() == 16
    # Wound as its normals say.
    assert (np.einsum("nx,nx->n", flat, mesh.normals.sum(axis=1))[~empty] > 0).all()


def test_counts_are_consistent(data):
    for part in data["measured"]:
        rows = {row["scheme"]: row for row in part["schemes"]}
        front = rows["Gouraud"]["front"]
        assert 0 < front < data["faces"] == 896
        for row in rows.values():
            assert row["front"] == front
            assert row["final"] == front - row["subdivided"] + row["parts"]
            assert row["final_with_culled"] == pytest.approx(896 - front + row["final"])
        for name in ("Highlight subdivision", "Regular subdivision", "Gouraud + Phong"):
            row = rows[name]
            assert row["tested"] == front > row["near"] > row["highlighted"] > 0
            assert row["highlighted"] == rows["Gouraud + Phong"]["highlighted"]
        assert rows["Gouraud + Phong"]["per_pixel"] == rows["Gouraud + Phong"]["near"]
        assert rows["Phong"]["per_pixel"] == front
        assert rows["Highlight subdivision"]["parts"] > rows["Highlight subdivision"]["subdivided"] > 0


def test_regular_subdivision_reaches_its_threshold():
    mesh = teapot()
    lights = cho.four_lights(mesh)
    projected = project(mesh, fit_camera(mesh, direction=cho.directions(2)[1]), 256, 256)
    near = with_neighbours(projected.vertices, potentially_highlighted(projected, lights).any(axis=0))
    made = regular_subdivision(projected, lights, cho.AREA)
    area = abs(doubled_area(made.projected.vertices)) / 2 / 4**8
    # The area is that of the whole triangle over fours; new vertices are rounded.
    assert area[near[made.root]].max() < 1.01 * cho.AREA


def test_errors_are_ordered(data):
    for part in data["measured"]:
        rms = {row["scheme"]: row["rms"] for row in part["schemes"]}
        assert rms["Phong"] == 0 < rms["Gouraud + Phong"] < rms["Gouraud"]
        assert rms["Highlight subdivision"] < rms["Gouraud"]
        assert rms["Regular subdivision"] <= rms["Gouraud"]


def test_pixels_of_another_triangle_are_kept_apart(data):
    for part in data["measured"]:
        rows = {row["scheme"]: row for row in part["schemes"]}
        for name in ("Gouraud", "Gouraud + Phong", "Phong"):
            assert rows[name]["others"] == rows[name]["largest_other"] == 0
        for name in ("Highlight subdivision", "Regular subdivision"):
            assert rows[name]["others"] < 1e-3 * part["pixels"]
            assert 0 < rows[name]["largest"] <= 1.05 * rows["Gouraud"]["largest"]


def test_squares_are_of_the_same_and_of_another_triangle():
    one, other = (Picture.empty(4, 1) for _ in range(2))
    one.triangle[0], other.triangle[0] = (0, 1, 2, -1), (0, 1, 3, 3)
    one.value[0, :, 0] = 10, 20, 30, 40
    same, elsewhere = cho.squares(one, other)
    assert same[:, 0].tolist() == [100, 400] and elsewhere[:, 0].tolist() == [900]


def test_shares_depend_on_width_and_material(data):
    widths, materials = data["shares"]["widths"], data["shares"]["materials"]
    for size in (256, 512):
        finals = [row[f"final_{size}"] for row in widths]
        assert finals == sorted(finals, reverse=True) and finals[0] > 1
    for exponent in (20, 50, 100):
        finals = [row["final"] for row in materials if row["exponent"] == exponent]
        assert finals == sorted(finals) and 1 < finals[0] < finals[-1]


def test_times_are_ratios(data):
    for part in data["measured"]:
        rows = {row["scheme"]: row for row in part["schemes"]}
        for what in ("time", "draw"):
            assert rows["Gouraud"][f"{what}_over_gouraud"] == rows["Phong"][f"{what}_over_phong"] == 1
            for row in rows.values():
                share = row[f"{what}_over_gouraud"] / rows["Phong"][f"{what}_over_gouraud"]
                assert row[f"{what}_over_phong"] == pytest.approx(share)


def test_the_papers_numbers_stand_beside_ours(data):
    rows = {(row["size"], row["scheme"]): row for row in data["paper"]}
    assert {size for size, _ in rows} == {256}
    regular = rows[256, "Regular subdivision"]
    assert regular["paper_final"] == 1075.5 / 896 and regular["paper_over_gouraud"] == 664 / 480
    ours = {row["scheme"]: row for row in data["measured"][1]["schemes"]}["Regular subdivision"]
    assert regular["our_final"] == ours["final_with_culled"] / 896
    assert rows[256, "Phong"]["our_draw_over_gouraud"] > 0


def test_the_report_is_of_its_numbers(data):
    assert data["text"] == cho.text(data)
    changed = json.loads(json.dumps({key: value for key, value in data.items() if key != "text"}))
    changed["measured"][0]["schemes"][1]["final"] = 12345.6
    assert "12345.6" in cho.text(changed) and "12345.6" not in data["text"]


def test_the_committed_report_is_of_the_committed_numbers():
    stored = json.loads(cho.REPORT.with_suffix(".json").read_text())
    assert cho.REPORT.read_text() == cho.text(stored)
    assert stored["views"] == 60 and [part["size"] for part in stored["measured"]] == [256, 512]
