# SPDX-License-Identifier: Apache-2.0
"""Phong's shading function as he prints it: S = C [cos(i) (1 - d) + d] + W(i) cos(s)^n (equation 3)."""

from __future__ import annotations

from math import acos, cos, degrees, radians, sin, tan
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from quadshade.cli.main import main
from quadshade.errors import QuadshadeError
from quadshade.shading import AmbientLight, DirectionalLight, parse_material
from quadshade.shading.incidence import fresnel_curve, table_curve
from quadshade.shading.material import PICTURE_MATERIAL

NORMAL = np.array([[0.0, 0.0, 1.0]])
INCIDENT = (10.0, 35.0, 60.0, 80.0)


def seen(text: str, incident: float, off: float) -> np.ndarray:
    """S of a point whose light comes ``incident`` degrees from the normal, seen ``off`` degrees from R."""
    material = parse_material(text)
    light = DirectionalLight((-sin(radians(incident)), 0.0, cos(radians(incident))))
    viewer = np.array([sin(radians(incident - off)), 0.0, cos(radians(incident - off))])
    return material.reflect([AmbientLight(), light], np.zeros((1, 3)), NORMAL, viewer)[0]


@pytest.mark.parametrize("incident", INCIDENT)
def test_equation_3(incident: float) -> None:
    text = "model=phong,exponent=7,colour=0.8,0.3,0.1,d=0.15,w=0.4"
    expected = (
        np.array([0.8, 0.3, 0.1]) * (cos(radians(incident)) * 0.85 + 0.15) + 0.4 * cos(radians(20)) ** 7
    )
    assert seen(text, incident, 20) == pytest.approx(expected)


@pytest.mark.parametrize("incident", INCIDENT)
def test_w_over_the_incident_angle(incident: float) -> None:
    table = [0.1, 0.1, 0.5, 0.8]
    expected = np.interp(incident, [0, 30, 60, 90], table) * cos(radians(5)) ** 3
    got = seen("model=phong,exponent=3,colour=0,0,0,w=0.1,0.1,0.5,0.8", incident, 5)
    assert got == pytest.approx(np.full(3, expected))


@pytest.mark.parametrize("incident", INCIDENT)
def test_fresnel_is_snells_law_and_fresnels_equations(incident: float) -> None:
    """The angles' form of both reflectances: sin(i-t)/sin(i+t) and tan(i-t)/tan(i+t)."""
    i = radians(incident)
    t = np.arcsin(sin(i) / 1.5)
    expected = ((sin(i - t) / sin(i + t)) ** 2 + (tan(i - t) / tan(i + t)) ** 2) / 2
    assert fresnel_curve(1.5)(np.array([cos(i)])) == pytest.approx(np.array([expected]))


def test_fresnel_at_the_ends() -> None:
    curve = fresnel_curve(1.5)
    assert curve(np.array([1.0]))[0] == pytest.approx(0.04)
    assert curve(np.array([1e-9]))[0] == pytest.approx(1.0, abs=1e-6)
    assert fresnel_curve(1)(np.array([0.3]))[0] == pytest.approx(0)
    # No light of one polarisation at Brewster's angle.
    brewster = np.arctan(1.5)
    assert curve(np.array([cos(brewster)]))[0] == pytest.approx(((1 - 1.5**2) / (1 + 1.5**2)) ** 2 / 2)
    assert degrees(acos(cos(brewster))) == pytest.approx(56.3, abs=0.01)


def test_table_is_linear_in_the_angle() -> None:
    assert table_curve([0.2, 0.6])(np.cos(np.radians([0, 45, 90]))) == pytest.approx([0.2, 0.4, 0.6])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("d=1.5", "d is 1.5"),
        ("d=0.1,ambient=0.2", "d and a diffuse or ambient"),
        ("w=0.1,specular=0.2", "W twice"),
        ("w=0.1,fresnel=1.5", "W twice"),
        ("w=0.1,1.2", "w is"),
        ("w=-1", "w is"),
        ("fresnel=0.5", "fresnel is 0.5"),
    ],
)
def test_refused(text: str, message: str) -> None:
    with pytest.raises(QuadshadeError, match=message):
        parse_material(text)


def test_pictures_start_from_their_own_material() -> None:
    assert parse_material("") == PICTURE_MATERIAL
    lights = [AmbientLight(), DirectionalLight((0.0, 0.0, 1.0))]
    orange = parse_material("colour=1,0.5,0.1,specular=0")
    # What faces the light has the part's colour; what lies in the dark still stands out from black.
    lit = orange.reflect(lights, np.zeros((1, 3)), NORMAL, np.array([0.0, 0.0, 1.0]))
    assert lit[0] == pytest.approx([1, 0.5, 0.1])
    dark = orange.reflect(lights, np.zeros((1, 3)), -NORMAL, np.array([0.0, 0.0, -1.0]))
    assert dark[0] == pytest.approx([0.3, 0.15, 0.03])


def test_from_the_command_line_and_falls_back_from_the_power_unit(tmp_path: Path) -> None:
    words = ["render", "torus:288", "--size", "48x48", "--material", "fresnel=1.5,d=0.1"]
    plain, power = tmp_path / "plain.png", tmp_path / "power.png"
    result = CliRunner().invoke(main, [*words, "-o", str(plain)])
    assert result.exit_code == 0, result.output
    result = CliRunner().invoke(main, [*words, "-o", str(power), "--shading", "quadratic-specular"])
    assert result.exit_code == 0, result.output
    assert "drawn as quadratic: the material's W varies with the incident angle" in result.output
    assert plain.read_bytes() == power.read_bytes()
