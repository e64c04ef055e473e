# SPDX-License-Identifier: Apache-2.0
"""The demonstration: its pictures reach what float theory allows, and it fails where the VHDL differs."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from PIL import Image

from quadshade.engine import draw
from quadshade.errors import QuadshadeError
from scripts import demo

QUADRATIC_AT_LEAST = {(168, 5): 48, (168, 50): 34, (690, 50): 50}
"""dB against Phong shading, whole picture of 512 x 512."""

ADVANTAGE = 8
"""dB over Gouraud, everywhere."""


@pytest.mark.parametrize("triangles", demo.SPHERES)
@pytest.mark.parametrize("exponent", demo.EXPONENTS)
def test_quality(triangles: int, exponent: int) -> None:
    result = demo.shade(triangles, exponent, 512, engine="model")
    assert result.triangles == triangles
    gouraud, six_points, least_squares = result.quality
    assert six_points >= QUADRATIC_AT_LEAST.get((triangles, exponent), 0)
    assert six_points >= gouraud + ADVANTAGE
    assert least_squares > six_points
    # The fit costs nothing in the core.
    assert len(set(result.clocks)) == 1


def test_draws_through_the_vhdl(tmp_path: Path) -> None:
    run = CliRunner().invoke(demo.main, ["--size", "32", "--jobs", "1", "--output", str(tmp_path)])
    assert run.exit_code == 0, run.output
    assert run.output.count("yes") == len(demo.SPHERES) * len(demo.EXPONENTS)
    names = {f"sphere_{triangles}_n{exponent}" for triangles in demo.SPHERES for exponent in demo.EXPONENTS}
    assert {path.name for path in tmp_path.iterdir()} == {f"{name}.png" for name in names | {"overview"}}
    with Image.open(tmp_path / "sphere_168_n5.png") as picture:
        assert picture.size == (128, 32 + demo.CAPTION_HEIGHT)


def change_value(drawing):
    value = drawing.pixels.value.copy()
    value[7, 1] ^= 1
    return replace(drawing, pixels=replace(drawing.pixels, value=value))


def change_clocks(drawing):
    return replace(drawing, stats=drawing.stats | {"clocks": drawing.stats["clocks"] + 1})


@pytest.mark.parametrize(
    ("change", "said"),
    [(change_value, "1 pixels: first value of pixel 7"), (change_clocks, "clocks: got")],
    ids=["value", "clocks"],
)
def test_a_difference_fails(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, change, said: str) -> None:
    def draw_wrong(triangles, formats, engine):
        drawing = draw(triangles, formats, "model")
        return change(drawing) if engine == "ghdl" else drawing

    monkeypatch.setattr(demo, "draw", draw_wrong)
    run = CliRunner().invoke(demo.main, ["--size", "32", "--jobs", "1", "--output", str(tmp_path)])
    assert run.exit_code == 1
    assert said in run.output


def test_a_missing_simulator_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def no_simulator(*_):
        raise QuadshadeError("ghdl is not installed", "run `make setup`")

    monkeypatch.setattr(demo, "draw", no_simulator)
    run = CliRunner().invoke(demo.main, ["--size", "32", "--jobs", "1", "--output", str(tmp_path)])
    assert run.exit_code == 2
    assert "demo: error: ghdl is not installed; run `make setup`\n" in run.output


def test_differences_of_equal_drawings_are_none() -> None:
    drawing = demo.shade(168, 5, 32, engine="model")
    assert drawing.difference == ""
    assert np.isfinite(drawing.quality).all()
