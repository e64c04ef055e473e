# SPDX-License-Identifier: Apache-2.0
"""Cartoon shading: steps of light exactly, borders where the curves have them, and what it refuses."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from quadshade.cli.main import main
from quadshade.contract.shade_state import table_entries, table_places
from quadshade.engine import draw
from quadshade.errors import QuadshadeError
from quadshade.scene import load_scene, parse_camera, project
from quadshade.shading import (
    DirectionalLight,
    Material,
    UnsuitedError,
    sample_specular,
    specular_formats,
    toon_curves,
)
from quadshade.shading.reference import phong

LIGHTS = (DirectionalLight((0.3, 0.5, 1)),)
MATERIAL = Material(exponent=30, colour=(0.6, 0.6, 0.6), diffuse=1, specular=0, ambient=0)


def sphere(size: int = 128):
    mesh = load_scene("sphere:690")
    return project(mesh, parse_camera("", mesh), size, size)


@pytest.mark.parametrize("steps", [2, 3, 5])
def test_light_comes_in_steps_at_phongs_cosines(steps: int) -> None:
    """Every pixel has the level of its exact cosine, but those within a ramp's length of a border."""
    scene, curves = sphere(), toon_curves(steps, 30)
    formats = specular_formats({}, scene, LIGHTS, MATERIAL, through_tables=True)
    assert formats.num_specular == formats.num_channels == 2
    triangles = sample_specular(scene, "quadratic-specular", LIGHTS, MATERIAL, formats, curves=curves)
    pixels = draw(triangles, formats).pixels
    exact = phong(scene, pixels.triangle, pixels.x, pixels.y, LIGHTS, MATERIAL)[:, 0] / (0.6 * 255)
    from_border = np.abs(exact * steps - np.rint(exact * steps)) / steps
    clear = from_border > 0.03
    assert clear.mean() > 0.5
    levels = np.array([round(0.6 * 255 * step / (steps - 1)) for step in range(steps)])
    wanted = levels[np.minimum((exact * steps).astype(int), steps - 1)]
    got = pixels.value[:, 0]
    assert np.abs(got[clear] - wanted[clear]).max() <= 1
    assert set(np.unique(wanted[clear])) == set(levels)


def test_the_highlight_is_flat_and_ends_at_its_border() -> None:
    formats = specular_formats({}, sphere(), LIGHTS, MATERIAL, through_tables=True)
    places = table_places(formats)
    _, specular = toon_curves(4, 30, border=0.7)
    assert set(np.unique(specular(places))) == {0.0, 1.0}
    assert np.abs(places[np.flatnonzero(np.diff(specular(places)))] ** 30 - 0.7).max() < 0.03
    assert len(places) == table_entries(formats) + 1


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: toon_curves(1, 20), "toon shading with 1 steps; give 2 to 64"),
        (lambda: toon_curves(65, 20), "toon shading with 65 steps"),
        (lambda: toon_curves(3, 20, border=0), "a highlight's border of 0; give a number above 0"),
    ],
)
def test_numbers_out_of_range_are_refused(call, message: str) -> None:
    with pytest.raises(QuadshadeError, match=message):
        call()


def test_a_core_with_too_few_tables_takes_colours() -> None:
    with pytest.raises(UnsuitedError, match="1 lights need 2 channels, all of them with a table"):
        specular_formats({"num_specular": 1}, sphere(16), LIGHTS, MATERIAL, through_tables=True)


def toon(output: Path, *more: str):
    command = ["render", "sphere:168", "--size", "32x32", "-o", str(output), "--toon", "4", *more]
    return CliRunner().invoke(main, command)


def test_render(tmp_path: Path) -> None:
    smooth, steps = tmp_path / "a.png", tmp_path / "b.png"
    assert toon(steps, "--shading", "quadratic-specular").exit_code == 0
    assert toon(smooth, "--shading", "quadratic-specular", "--exponent", "3000").stderr.endswith(
        "drawn as quadratic, without steps: the exponent 3000 is not in 1 .. 1024\n"
    )
    assert steps.read_bytes() != smooth.read_bytes()
    refused = toon(steps, "--shading", "phong")
    assert refused.exit_code == 2
    assert "--toon with the shading phong; give --shading linear-specular or quadratic-spec" in refused.stderr
