# SPDX-License-Identifier: Apache-2.0
"""The measures of colour across edges: known jumps are found, and the report is of its numbers."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

from quadshade.contract.formats import Formats
from quadshade.engine import draw
from quadshade.shading import sample
from quadshade.shading.reference import barycentric
from scripts.experiments.continuity import mach_bands
from scripts.experiments.continuity import report as continuity


@pytest.fixture(scope="module")
def sphere():
    return mach_bands.view("sphere:168", 128)


def on_screen(projected, function) -> mach_bands.Shade:
    """A shading that is a function of the place on the screen, one for each triangle's index."""

    def shade(owner: np.ndarray, weights: np.ndarray) -> np.ndarray:
        place = np.einsum("mk,mkx->mx", weights, projected.vertices[owner] / 256.0)
        return function(owner, place)

    return shade


def test_a_smooth_function_has_no_jump(sphere):
    found = mach_bands.jumps(
        sphere, on_screen(sphere, lambda owner, at: 0.1 * (at**2).sum(axis=1) - at[:, 0])
    )
    assert found["edges"] > 20
    assert found["largest"] < 1e-6 and found["value_jump"] < 1e-9


def test_a_known_kink_is_measured(sphere):
    """Two triangles and their edge: a shading that rises by 3 grey levels a pixel into one of them only."""
    owner, ends, third = mach_bands.interior_edges(sphere)
    pair = sphere.ordered(owner[0])
    along = ends[0, 1] - ends[0, 0]
    normal = np.array([-along[1], along[0]]) / np.linalg.norm(along)
    normal *= np.sign(normal @ (third[0, 0] - ends[0, 0]))

    def rising(index: np.ndarray, at: np.ndarray) -> np.ndarray:
        return np.where(index == 0, 3.0, 0.0) * ((at - ends[0, 0]) @ normal)

    found = mach_bands.jumps(pair, on_screen(pair, rising))
    assert found["edges"] == 1 and found["value_jump"] < 1e-9
    for name in ("rms", "mean", "p95", "largest"):
        assert found[name] == pytest.approx(3.0, abs=1e-6)


def test_sharp_edges_are_left_out(sphere):
    """Where normals differ across an edge, the jump belongs to the object."""
    flat = np.repeat(sphere.normal.mean(axis=1, keepdims=True), 3, axis=1)
    assert len(mach_bands.interior_edges(replace(sphere, normal=flat))[0]) == 0


@pytest.mark.parametrize("exponent", mach_bands.EXPONENTS)
def test_shadings_are_those_of_the_drawing(sphere, exponent):
    """Float quadratic at pixel centres, against what the golden model draws; the value is continuous."""
    triangles = sample(sphere, "quadratic", None, mach_bands.material_of(exponent))
    pixels = draw(triangles, Formats()).pixels
    weights = barycentric(triangles.vertices, pixels.triangle, pixels.x, pixels.y, 8)
    shades = mach_bands.shades(sphere, exponent)
    assert np.abs(shades["quadratic"](pixels.triangle, weights) - pixels.value[:, 0]).max() < 0.52
    specular, phong = (shades[name](pixels.triangle, weights) for name in ("quadratic-specular", "phong"))
    assert np.sqrt(np.mean((specular - phong) ** 2)) < 0.7
    for shade in shades.values():
        assert mach_bands.jumps(sphere, shade)["value_jump"] < 1e-6


def test_report_is_written_from_the_numbers(tmp_path, monkeypatch):
    monkeypatch.setattr(continuity, "SCENES", ("sphere:168",))
    report = tmp_path / "report.md"
    arguments = ["--size", "96", "--frames", "3", "--frame-size", "64", "--output", str(report)]
    result = CliRunner().invoke(continuity.main, arguments, catch_exceptions=False)
    assert result.exit_code == 0
    numbers = json.loads(report.with_suffix(".json").read_text())
    assert report.read_text() == continuity.report(numbers)
    assert report.with_suffix(".png").stat().st_size > 10_000
    drawn = {row["stepping"]: row for row in numbers["steppings"] if row["exponent"] == 5}
    assert drawn["centre"]["largest_quadratic"] < 0.52
    assert drawn["fractional"]["psnr_quadratic"] < drawn["centre"]["psnr_quadratic"] - 3
    assert drawn["fractional"]["flicker"] > 1.5 * drawn["centre"]["flicker"]
    assert drawn["quadratic in float"]["flicker"] < drawn["phong, rounded"]["flicker"]


def test_published_report_is_that_of_its_numbers():
    numbers = json.loads(continuity.REPORT.with_suffix(".json").read_text())
    assert continuity.REPORT.read_text() == continuity.report(numbers)
