# SPDX-License-Identifier: Apache-2.0
"""Diffuse and specular channels: what is sampled, what it is worth, and when colours take their place."""

from __future__ import annotations

import json

import numpy as np
import pytest
from click.testing import CliRunner

from quadshade.cli.main import main
from quadshade.contract.formats import QUADRATIC
from quadshade.engine import draw
from quadshade.engine.verilator import verilator_available
from quadshade.image import paint, visible
from quadshade.image.compare import psnr
from quadshade.scene import build_mesh, load_scene, parse_camera, project
from quadshade.shading import AmbientLight, DirectionalLight, Material, PointLight
from quadshade.shading.reference import phong
from quadshade.shading.specular import UnsuitedError, sample_specular, specular_formats


def sphere(scene: str = "sphere:168", size: int = 512, camera: str = "from=0,0,1"):
    mesh = load_scene(scene)
    return project(mesh, parse_camera(camera, mesh), size, size)


def pictures(projected, material: Material, lights=None, shading: str = "quadratic-specular"):
    """The engine's picture, and Phong's of the same pixels."""
    formats = specular_formats({}, projected, lights, material)
    pixels = draw(sample_specular(projected, shading, lights, material, formats), formats).pixels
    shown = visible(pixels, projected.width, projected.height)
    exact = phong(projected, pixels.triangle, pixels.x, pixels.y, lights, material)
    return paint(shown, pixels.value, (0, 0, 0)), paint(shown, exact, (0, 0, 0))


def render(*arguments: str):
    return CliRunner().invoke(main, ["render", *(str(argument) for argument in arguments)])


@pytest.mark.parametrize(("scene", "floor"), [("sphere:168", 57.5), ("sphere:690", 67)])
@pytest.mark.parametrize("camera", ["from=0,0,1", "from=0,0,1,ortho=1.05"])
def test_spheres_are_phongs_to_the_floor(scene: str, floor: float, camera: str) -> None:
    assert psnr(*pictures(sphere(scene, camera=camera), Material(exponent=50))) >= floor


@pytest.mark.parametrize(
    ("lights", "material", "floor"),
    [
        ([DirectionalLight((1, 1, 1)), DirectionalLight((-2, 0, 1), (1, 0.3, 0.2))], Material(), 55),
        ([PointLight((1, 2, 2), (1, 1, 1), (0.5, 0, 0.1)), AmbientLight((0.5, 1, 0.5))], Material(), 54),
        ([DirectionalLight((0, 1, 0.2), (2, 2, 2))], Material(exponent=5), 54),
        (None, Material(model="phong", exponent=12), 54),
        ([DirectionalLight((x, 1, 1), (0.4, 0.4, 0.4)) for x in range(4)], Material(exponent=80), 53),
    ],
    ids=["two lights", "attenuation", "from above", "reflected ray", "four lights"],
)
def test_lights_and_models_are_phongs(lights, material: Material, floor: float) -> None:
    assert psnr(*pictures(sphere("sphere:374", 256), material, lights)) >= floor


def test_linear_cosines_are_worse() -> None:
    projected, material = sphere(size=128), Material(exponent=50)
    linear = psnr(*pictures(projected, material, shading="linear-specular"))
    assert 20 < linear < psnr(*pictures(projected, material)) - 15


def test_samples_are_the_cosines() -> None:
    projected = sphere(camera="from=0,0,1,ortho=1.2", size=64)
    lights = [
        AmbientLight((0.5, 0.5, 1)),
        DirectionalLight((0, 2, 0)),
        DirectionalLight((0, 0, 1), (1, 0, 2)),
    ]
    material = Material(colour=(1, 0.5, 0.25), diffuse=(0.8, 0.8, 0.8), specular=(0.5, 0.5, 0.5), exponent=9)
    triangles = sample_specular(projected, lights=lights, material=material)
    normal = projected.normal
    half = np.array([0, 1, 1]) / np.sqrt(2)
    for channel, direction in (("d0", [0, 1, 0]), ("d1", [0, 0, 1]), ("s0", half), ("s1", [0, 0, 1])):
        got = triangles.samples[:, triangles.channels.index(channel), :3]
        assert got == pytest.approx(255 * normal @ direction, abs=1e-9), channel
    assert triangles.samples.min() < -100 and (triangles.orders == QUADRATIC).all()
    colours = triangles.shade.coefficients / 65536
    assert colours[1] == pytest.approx([0.8, 0, 0.4], abs=1e-5)
    assert colours[2:] == pytest.approx(np.array([[0.5, 0.5, 0.5], [0.5, 0, 1]]), abs=1e-5)
    assert triangles.shade.gated == 3


def test_a_core_with_more_channels_draws_the_same() -> None:
    projected = sphere(size=64)
    formats = specular_formats({"num_channels": 5, "num_specular": 2}, projected)
    wide = draw(sample_specular(projected, formats=formats), formats).pixels
    fitted = specular_formats({}, projected)
    assert (wide.value == draw(sample_specular(projected), fitted).pixels.value).all()
    assert (fitted.num_channels, fitted.num_specular) == (2, 1)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"material": Material(exponent=0.5)}, "the exponent 0.5 is not in 1 .. 1024"),
        ({"material": Material(exponent=2000)}, "the exponent 2000"),
        ({"material": Material(reflectance=lambda *_: 0)}, "the reflectance is the user's own"),
        ({"lights": [AmbientLight()]}, "all light is ambient"),
        ({"lights": [DirectionalLight((1, 1, 1))] * 5}, "5 lights need 10 channels of 8"),
        ({"lights": [DirectionalLight((1, 1, 1), (9, 9, 9))]}, "a light reflects 3.15|a light reflects 5.13"),
    ],
    ids=["small", "large", "function", "ambient", "five", "bright"],
)
def test_what_takes_colours_says_why(changes: dict, message: str) -> None:
    changes = {"material": Material(colour=(0.95, 0.95, 0.95))} | changes
    with pytest.raises(UnsuitedError, match=message):
        sample_specular(sphere(size=32), **changes)


def test_a_mesh_with_colours_takes_colours() -> None:
    corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    mesh = build_mesh(corners, [[0, 1, 2]], colours=np.eye(3)[None])
    with pytest.raises(UnsuitedError, match="colours of its own"):
        sample_specular(project(mesh, parse_camera("", mesh), 32, 32))


def test_render_draws_it_and_says_what_the_core_was(tmp_path) -> None:
    stats = tmp_path / "stats.json"
    lights = ("--light", "dir=1,1,1", "--light", "point=0,3,3")
    scene = ("torus:288", "--size", "80x64", "--shading", "quadratic-specular", *lights)
    result = render(*scene, "-o", tmp_path / "a.png", "--stats", stats)
    assert result.exit_code == 0 and result.stderr == "", result.output
    numbers = json.loads(stats.read_text())
    assert numbers["shading"] == "quadratic-specular"
    generics = numbers["generics"]
    assert (generics["with_shade"], generics["num_channels"], generics["num_specular"]) == (1, 4, 2)


def test_render_says_when_it_interpolates_colours(tmp_path) -> None:
    scene = ("sphere:168", "--size", "48x48", "--exponent", "4000")
    result = render(*scene, "-o", tmp_path / "a.png", "--shading", "quadratic-specular")
    assert result.exit_code == 0
    assert result.stderr == "quadshade: notice: drawn as quadratic: the exponent 4000 is not in 1 .. 1024\n"
    render(*scene, "-o", tmp_path / "b.png", "--shading", "quadratic")
    # The core that has a shade unit passes colours through.
    generics = ("--generic", "with_shade=1", "--generic", "num_channels=4")
    result = render(*scene, *generics, "-o", tmp_path / "c.png", "--shading", "quadratic-specular")
    assert result.exit_code == 0 and result.stderr.startswith("quadshade: notice: drawn as quadratic: ")
    picture = (tmp_path / "a.png").read_bytes()
    assert picture == (tmp_path / "b.png").read_bytes() == (tmp_path / "c.png").read_bytes()
    few = render(*scene, "--generic", "num_channels=2", "--generic", "with_shade=1", "-o", tmp_path / "d.png",
                 "--shading", "linear-specular")  # fmt: skip
    assert few.exit_code == 2 and "generic num_channels is 2; a picture needs 3" in few.stderr


@pytest.mark.skipif(
    not verilator_available(), reason="needs GHDL, Verilator and a compiler: run `make setup`"
)
def test_every_engine_draws_it_and_verilator_is_the_default(tmp_path, monkeypatch) -> None:
    monkeypatch.delenv("QUADSHADE_ENGINE")
    scene = ("sphere:168", "--size", "32x32", "--shading", "quadratic-specular", "--exponent", "50")
    drawn = {}
    for engine in ("model", "ghdl", "verilator", ""):
        picture, stats = tmp_path / f"by_{engine}.png", tmp_path / f"by_{engine}.json"
        choice = ("--engine", engine) if engine else ()
        result = render(*scene, "-o", picture, "--stats", stats, *choice)
        assert result.exit_code == 0, result.output
        drawn[engine] = picture.read_bytes(), json.loads(stats.read_text())
    assert drawn[""] == drawn["verilator"]
    assert len({picture for picture, _ in drawn.values()}) == 1
    assert {stats.pop("engine") for _, stats in drawn.values() if "engine" in stats} == set(drawn) - {""}
    assert all(stats == drawn["model"][1] for _, stats in drawn.values())
