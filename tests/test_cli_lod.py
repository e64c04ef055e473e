# SPDX-License-Identifier: Apache-2.0
"""``--lod``: a picture in fewer triangles, compared with Phong shading of all of them."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

import quadshade
from quadshade.cli.main import main
from quadshade.errors import QuadshadeError
from quadshade.packing import read_frame_file

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"


def run(*arguments: object) -> tuple[int, str]:
    """Exit code and everything printed."""
    result = CliRunner().invoke(main, list(map(str, arguments)))
    return result.exit_code, result.output


@pytest.mark.parametrize("scene", ["sphere:690", EXAMPLES / "knot.glb"], ids=["sphere", "knot"])
def test_fewer_triangles_are_further_from_the_fine_mesh(scene: str | Path) -> None:
    """The reference is Phong shading of the mesh with all its triangles, whatever is drawn."""
    errors = []
    for lod in (None, 300, 60):
        picture = quadshade.render(scene, size=(96, 96), engine="model", lod=lod)
        assert picture.stats.faces <= (lod or picture.stats.whole_faces)
        assert ("of the mesh's" in picture.summary) == (lod is not None)
        errors.append(picture.error_to("phong").rms)
    assert errors == sorted(errors) and errors[-1] > 2 * errors[0]


def test_a_decimated_mesh_shades_like_the_fine_one() -> None:
    """Its normals are those of the fine mesh: computed from its own triangles they are much worse."""
    knot = quadshade.render(EXAMPLES / "knot.glb", size=(96, 96), engine="model", lod=500, supersample=2)
    facets = quadshade.render(
        EXAMPLES / "knot.glb", size=(96, 96), engine="model", lod=500, supersample=2, shading="flat"
    )
    assert knot.error_to("phong").rms < 0.8 * facets.error_to("phong").rms


def test_a_budget_below_the_cheapest_picture_takes_fewer_triangles(tmp_path: Path) -> None:
    small = ["render", "sphere:690", "-o", tmp_path / "a.png", "--size", "96x96", "--engine", "model"]
    small += ["--shading", "quadratic", "--error-measure", "rms"]
    code, output = run(*small, "--budget", "2500line")
    assert code == 2 and "the cheapest picture takes" in output
    code, output = run(*small, "--budget", "2500line", "--lod", "auto", "--stats", tmp_path / "a.json")
    assert code == 0, output
    stats = json.loads((tmp_path / "a.json").read_text())
    assert stats["whole_faces"] == 690 and stats["faces"] < 345
    assert 0 < stats["adaptive"]["line_bytes"] <= 2500
    code, output = run(*small, "--budget", "30line", "--lod", "auto")
    assert code == 2 and "the budget is 30 bytes on the line" in output


def test_a_large_budget_keeps_all_triangles() -> None:
    picture = quadshade.render(
        "sphere:168", size=(64, 64), engine="model", budget=40_000, lod="auto", shading="quadratic",
        error_measure="rms",
    )  # fmt: skip
    assert picture.stats.faces == picture.stats.whole_faces == 168


def test_packed_and_on_a_board(tmp_path: Path) -> None:
    code, output = run("pack", "torus:288", "-o", tmp_path / "a.qs", "--size", "64x48", "--lod", 100)
    assert code == 0 and "of the mesh's 288 triangles used" in output
    assert read_frame_file(tmp_path / "a.qs").triangles <= 100
    with quadshade.Board("sim", engine="model") as board:
        picture = quadshade.render(
            "torus:288", size=(64, 48), port=board, budget="1500line", error_measure="rms", lod="auto"
        )
        assert picture.stats.faces < 288 and picture.stats.adaptive["line_bytes"] <= 1500


@pytest.mark.parametrize(
    ("keywords", "said"),
    [
        ({"lod": "auto"}, "--lod auto without a budget"),
        ({"lod": "auto", "max_error": 4.0}, "--lod auto without a budget"),
        ({"lod": "some"}, "give a number of triangles, or auto"),
        ({"lod": -5}, "give a number of triangles, or auto"),
        ({"lod": 2.5}, "give a number of triangles, or auto"),
        ({"lod": 3}, "give at least 4"),
        ({"lod": 169}, "the mesh has 168 triangles"),
    ],
)
def test_refusals(keywords: dict, said: str) -> None:
    with pytest.raises(QuadshadeError) as refused:
        quadshade.render("sphere:168", size=(32, 32), engine="model", **keywords)
    assert said in str(refused.value)
