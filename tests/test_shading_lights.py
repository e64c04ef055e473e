# SPDX-License-Identifier: Apache-2.0
"""Lights and materials against values worked out by hand."""

from __future__ import annotations

import numpy as np
import pytest

from quadshade.errors import QuadshadeError
from quadshade.shading import (
    DEFAULT_LIGHTS,
    AmbientLight,
    DirectionalLight,
    Material,
    PointLight,
    load_reflectance,
    parse_light,
    parse_material,
)
from quadshade.shading.material import PICTURE_MATERIAL

ORIGIN, UP, FRONT = (np.array([vector], dtype=float) for vector in ((0, 0, 0), (0, 1, 0), (0, 0, 1)))
PLAIN = Material(
    colour=(0.5, 1.0, 0.0), diffuse=(0.8,) * 3, ambient=(0.1,) * 3, specular=(0.0,) * 3, exponent=2.0
)


def test_ambient_light_is_the_product_of_its_colours():
    light = PLAIN.reflect([AmbientLight((1.0, 0.5, 1.0))], ORIGIN, UP, FRONT[0])
    assert light == pytest.approx(np.array([[0.05, 0.05, 0.0]]))


@pytest.mark.parametrize(("degrees", "cosine"), [(0, 1), (60, 0.5), (90, 0), (120, 0)])
def test_diffuse_light_goes_with_the_cosine_and_stops_at_the_horizon(degrees, cosine):
    angle = np.radians(degrees)
    sun = DirectionalLight((7 * np.sin(angle), 7 * np.cos(angle), 0), (1.0, 0.5, 1.0))
    light = PLAIN.reflect([sun], ORIGIN, UP, FRONT[0])
    assert light == pytest.approx(cosine * np.array([[0.4, 0.4, 0.0]]), abs=1e-12)


@pytest.mark.parametrize(("model", "angle"), [("phong", 40.0), ("blinn", 20.0)])
def test_the_specular_term_goes_with_the_reflection_or_the_half_vector(model, angle):
    """Light 30 degrees to one side, viewer 70 to the other: 40 off the reflection, 20 off the half vector."""
    light, viewer = np.radians(30), np.radians(70)
    surface = Material(colour=(0.0,) * 3, specular=(1.0, 0.5, 0.25), exponent=3.0, model=model)
    sun = DirectionalLight((-np.sin(light), np.cos(light), 0))
    got = surface.reflect([sun], ORIGIN, UP, np.array([np.sin(viewer), np.cos(viewer), 0]))
    assert got == pytest.approx(np.cos(np.radians(angle)) ** 3 * np.array([[1.0, 0.5, 0.25]]))


def test_no_specular_light_from_behind_the_surface():
    sun = DirectionalLight((0, -0.1, 1))
    for model in ("phong", "blinn"):
        surface = parse_material(f"colour=0,specular=1,model={model}", 1.0)
        assert not surface.reflect([sun], ORIGIN, UP, FRONT[0]).any()


def test_a_point_light_fades_with_the_distance_and_looks_the_right_way():
    lamp = PointLight((3.0, 4.0, 0.0), attenuation=(1.0, 0.5, 0.25))
    to_light, intensity = lamp.reach(ORIGIN)
    assert to_light == pytest.approx(np.array([[0.6, 0.8, 0]]))
    assert intensity == pytest.approx(1 / (1 + 2.5 + 6.25))
    light = PLAIN.reflect([lamp], ORIGIN, UP, FRONT[0])
    assert light == pytest.approx(np.array([[0.4, 0.8, 0]]) * 0.8 / 9.75)
    assert np.isfinite(
        PLAIN.reflect([PointLight((0.0, 0.0, 0.0), attenuation=(0, 0, 1))], ORIGIN, UP, FRONT[0])
    ).all()


def test_lights_add_up(rng):
    lights = [
        AmbientLight(),
        DirectionalLight((1, 1, 1)),
        PointLight((0, 3, 1)),
        DirectionalLight((-1, 2, 0)),
    ]
    point, normal = rng.normal(size=(50, 3)), rng.normal(size=(50, 3))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    together = Material().reflect(lights, point, normal, FRONT[0])
    assert together == pytest.approx(
        sum(Material().reflect([light], point, normal, FRONT[0]) for light in lights)
    )


def test_the_defaults_never_overflow(rng):
    normal = rng.normal(size=(20000, 3))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    for exponent in (1.0, 5.0, 50.0):
        light = Material(exponent=exponent).reflect(DEFAULT_LIGHTS, normal, normal, FRONT[0])
        assert 0.0 <= light.min() and light.max() <= 1.0


def test_a_users_reflectance_takes_the_place_of_the_model():
    def cloth(point, normal, to_light, to_viewer):
        assert point.shape == normal.shape == to_light.shape == to_viewer.shape == (2, 3)
        return np.einsum("ij,ij->i", normal, to_light)[:, None] * np.array([[0.5, 0.25, 0.0]])

    surface = Material(ambient=(0.0,) * 3, reflectance=cloth)
    lights = [
        AmbientLight(),
        DirectionalLight((0, 2, 0), (1.0, 1.0, 0.5)),
        PointLight((0, 2, 0), attenuation=(0, 1, 0)),
    ]
    got = surface.reflect(lights, np.zeros((2, 3)), np.tile(UP, (2, 1)), FRONT[0])
    assert got == pytest.approx(np.tile([[0.75, 0.375, 0.0]], (2, 1)))


@pytest.mark.parametrize(
    ("function", "message"),
    [
        (lambda p, n, light, v: n[:, 0], "shape"),
        (lambda p, n, light, v: n * np.nan, "not finite"),
        (lambda p, n, light, v: 1 / 0, "ZeroDivisionError"),
        (lambda p: p, "TypeError"),
    ],
)
def test_a_broken_reflectance_is_one_clear_error(function, message):
    with pytest.raises(QuadshadeError, match=message):
        Material(reflectance=function).reflect([DirectionalLight((0, 1, 0))], ORIGIN, UP, FRONT[0])


def test_a_reflectance_with_other_arguments_is_told_which_there_are():
    with pytest.raises(QuadshadeError) as caught:
        Material(reflectance=lambda point: point).reflect([DirectionalLight((0, 1, 0))], ORIGIN, UP, FRONT[0])
    assert "point, normal, to_light and to_viewer" in caught.value.hint


@pytest.mark.parametrize("colour", [(255, 128, 0), (0.5, 0.5, 1.01), (-0.1, 0, 0), (float("nan"), 0, 0)])
def test_a_materials_colour_is_from_0_to_1(colour):
    with pytest.raises(QuadshadeError, match="the material's colour is"):
        Material(colour=colour)
    with pytest.raises(QuadshadeError):
        parse_material("colour=" + ",".join(map(str, colour)))


def test_a_reflectance_is_loaded_from_a_module_or_a_file(tmp_path):
    (tmp_path / "skin.py").write_text(
        "def white(point, normal, to_light, to_viewer):\n    return 0 * normal + 1\n"
    )
    assert (load_reflectance(f"{tmp_path / 'skin.py'}:white")(UP, UP, UP, UP) == 1).all()
    assert load_reflectance("numpy.linalg:norm") is np.linalg.norm


@pytest.mark.parametrize(
    "text", ["skin", "skin:", ":white", "no_such_module:white", "math:no_such", "math:pi", "no_such.py:white"]
)
def test_a_reflectance_that_is_not_there_is_refused(text):
    with pytest.raises(QuadshadeError):
        load_reflectance(text)


def test_lights_and_materials_are_read():
    assert parse_light("dir=1,2,3,color=1,0.5,0") == DirectionalLight((1, 2, 3), (1, 0.5, 0))
    assert parse_light("point=1,2,3,attenuation=1,0,0.5") == PointLight((1, 2, 3), attenuation=(1, 0, 0.5))
    assert parse_light("ambient=0.1") == AmbientLight((0.1, 0.1, 0.1))
    assert parse_light("ambient=0.5,colour=1,0.5,0") == AmbientLight((0.5, 0.25, 0))
    surface = parse_material("color=1,0,0.5,specular=0.2,model=Phong", 7.0)
    assert (surface.colour, surface.specular, surface.model, surface.exponent) == (
        (1, 0, 0.5),
        (0.2, 0.2, 0.2),
        "phong",
        7.0,
    )
    assert parse_material("exponent=9").exponent == 9
    assert parse_material("") == PICTURE_MATERIAL


@pytest.mark.parametrize(
    "text",
    [
        "",
        "1,1,1",
        "dir=1,1",
        "dir=0,0,0",
        "dir=1,1,x",
        "dir=1,1,inf",
        "spot=1,1,1",
        "dir=1,1,1,point=1,1,1",
        "colour=1,1,1",
        "dir=1,1,1,colour=-1,0,0",
        "dir=1,1,1,dir=1,1,1",
        "ambient=-1",
        "ambient=1,2",
        "dir=1,1,1,attenuation=1,0,0",
        "point=1,1,1,attenuation=0,0,0",
    ],
)
def test_a_bad_light_is_refused(text):
    with pytest.raises(QuadshadeError):
        parse_light(text)


@pytest.mark.parametrize(
    "text",
    ["red", "colour=red", "shine=1", "model=toon", "model=", "exponent=-1", "specular=1,2", "diffuse=nan"],
)
def test_a_bad_material_is_refused(text):
    with pytest.raises(QuadshadeError):
        parse_material(text)


def test_an_exponent_given_twice_is_refused():
    with pytest.raises(QuadshadeError, match="twice"):
        parse_material("exponent=3", 4.0)
