# SPDX-License-Identifier: Apache-2.0
"""Edges over pictures: kinds keep their colours, and the commands that draw them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from quadshade.cli.main import main
from quadshade.image import read_picture
from quadshade.scene import fit_camera, load_scene, project
from quadshade.style import EdgeMaps, draw_edges, draw_gbuffer, find_edges

VIEW = np.array([1.0, 0.8, 1.0])


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
