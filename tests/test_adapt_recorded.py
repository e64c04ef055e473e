# SPDX-License-Identifier: Apache-2.0
"""Adaptive pictures of tiny scenes: parts, orders and errors are those that were recorded."""

from __future__ import annotations

import zlib
from typing import Any

import numpy as np
import pytest

from quadshade.adapt import Adapted, ColourShader, CosineShader, LightShader, adapt, stream_bytes
from quadshade.adapt.centre_test import centre_subdivision
from quadshade.adapt.cho import highlight_subdivision, regular_subdivision
from quadshade.adapt.highlight import highlight_centres
from quadshade.contract.formats import Formats
from quadshade.scene import Projected, load_scene, parse_camera, project
from quadshade.shading import AmbientLight, DirectionalLight, Material, PointLight, specular_formats
from tests.support.recorded import assert_recorded

LIGHTS = [
    AmbientLight(),
    PointLight((3.0, 4.0, 5.0)),
    PointLight((-4.0, 2.0, 1.0), (0.5, 0.4, 0.3), (1.0, 0.1, 0.0)),
    DirectionalLight((1.0, 2.0, 0.5)),
]
CASES: dict[str, dict[str, Any]] = {
    "colours": {"max_error": 6.0, "shading": "quadratic"},
    "colours_rms": {"max_error": 1.5, "measure": "rms", "shading": "quadratic"},
    "cosines": {"max_error": 5.0, "shading": "quadratic-specular"},
    "cosines_rms": {"max_error": 1.0, "measure": "rms", "shading": "quadratic-specular"},
    "lights": {"max_error": 4.0, "shading": "quadratic-lights"},
    "budget": {"budget": 2500, "shading": "auto"},
    "clocks": {"budget": 700, "unit": "clocks", "shading": "quadratic"},
    # A few triangles, so quick that every change of a loop can be tried on them.
    "few_fitted": {"few": 4, "max_error": 6.0, "shading": "quadratic", "fit": "auto"},
    "few_fitted_cosines": {"few": 3, "max_error": 4.0, "shading": "quadratic-specular", "fit": "auto"},
    "few_fitted_budget": {"few": 3, "budget": 1500, "shading": "quadratic-specular", "fit": "minimax"},
    "few_cosines": {"few": 3, "max_error": 1.2, "shading": "quadratic-specular"},
    "few_lights": {"few": 3, "max_error": 1.5, "shading": "quadratic-lights"},
    "few_rms": {"few": 4, "max_error": 2.0, "measure": "rms", "shading": "quadratic"},
    "few_auto": {"few": 3, "max_error": 4.0, "shading": "auto"},
    "few_auto_loose": {"few": 3, "max_error": 9.0, "shading": "auto"},
    "few_auto_budget": {"few": 3, "budget": 1500, "shading": "auto", "unit": "line"},
    "assessed": {},
    "subdivided": {},
    "centres": {},
}


def looked_at(scene: str = "icosphere:1", width: int = 26, height: int = 21) -> Projected:
    mesh = load_scene(scene)
    return project(mesh, parse_camera("from=1,2,3", mesh), width, height)


def sums(adapted: Adapted) -> dict[str, Any]:
    """
    What is drawn, in few numbers.

    Samples are solved for, and processors differ by 1e-10: as whole eighths of a grey level they do not.
    Another 1e-8 of each sample changes none of these.
    """
    triangles = adapted.triangles
    return {
        "parts": len(adapted.root),
        "bytes": stream_bytes(triangles, adapted.formats),
        "shading": adapted.shading,
        "orders": np.bincount(triangles.orders.ravel(), minlength=3).tolist(),
        "root": zlib.crc32(adapted.root.astype("<i8").tobytes()),
        "vertices": zlib.crc32(triangles.vertices.astype("<i8").tobytes()),
        "error": float(adapted.error),
        "eighths": zlib.crc32(np.rint(8 * triangles.samples).astype("<i8").tobytes()),
    }


def subdivided() -> dict[str, Any]:
    """What the subdivisions of Cho et al. make of a sphere."""
    whole = looked_at(width=60, height=50)
    made = {
        "regular": regular_subdivision(whole, LIGHTS, 8.0),
        "highlight": highlight_subdivision(whole, LIGHTS, threshold=0.05),
    }
    pictures = {name: parts.projected for name, parts in made.items()}
    pictures["centre"] = centre_subdivision(whole, 2.0, LIGHTS, Material(exponent=50))[0]
    found: dict[str, Any] = {}
    for name, projected in pictures.items():
        found[name] = [len(projected), zlib.crc32(projected.vertices.astype("<i8").tobytes())]
        found[name] += np.abs(projected.normal).sum(axis=(0, 1)).tolist()
    return found


def short(values: np.ndarray) -> list[float]:
    """Sums to five digits, and to a millionth: samples are solved for, and bounds are of their last bits."""
    rows = np.asarray(values, dtype=float).reshape(len(values), -1).sum(axis=1)
    return [round(float(f"{value:.5g}"), 6) for value in rows]


def assessed() -> dict[str, Any]:
    """What shaders find out of a few triangles, of coarse words as well, and of their halves."""
    whole, material = looked_at("icosphere:0", 12, 10).ordered(np.arange(4)), Material(exponent=50)
    cosines = specular_formats({}, whole, LIGHTS, material)
    shaders = {
        f"{kind.__name__} {measure} {core and core.frac_bits}": kind(LIGHTS, material, core, whole, measure)
        for measure in ("max", "rms")
        for kind, core in (
            (ColourShader, None),
            (CosineShader, cosines),
            (LightShader, cosines),
            (ColourShader, Formats(frac_bits=1)),
        )
    }
    # An exponent between whole ones.
    shaders["between"] = CosineShader(LIGHTS, Material(exponent=5.5), cosines, whole)
    # Highlights that are nearly nothing, which need no polynomial.
    dull, one_light = Material(specular=(0.001,) * 3, exponent=5), LIGHTS[:2]
    shaders["dull"] = CosineShader(one_light, dull, specular_formats({}, whole, one_light, dull), whole)
    found = {}
    for name, shader in shaders.items():
        surface = shader.surface(whole)
        one = surface.assessed
        found[name] = {
            "pixels": one.pixels.tolist(),
            "bound": short(one.bound),
            "packets": one.packets.tolist(),
            "errors": short(one.errors),
            "options": int(one.options.sum()),
            "words": short(one.words) if one.words.size else [],
            "level": shader.level_highlights(one).tolist(),
            "halves": short(shader.halves(whole, one.options)),
            "table": [shader.table(2.0).number, shader.table(2.0).first, *short(shader.table(2.0).gain)],
        }
    return found


def centres() -> dict[str, Any]:
    """Where the highlights of a sphere are."""
    whole = looked_at(width=60, height=50)
    found: dict[str, Any] = {}
    for number, light in enumerate(LIGHTS[1:]):
        where, what = highlight_centres(whole, np.arange(len(whole)), light)
        found[str(number)] = [where.tolist(), np.asarray(what).ravel().tolist()]
    return found


def computed(name: str) -> dict[str, Any]:
    """The numbers of a case."""
    if name == "subdivided":
        return subdivided()
    if name == "centres":
        return centres()
    if name == "assessed":
        return assessed()
    settings = dict(CASES[name])
    few = settings.pop("few", 0)
    if not few:
        return sums(adapt(looked_at(), LIGHTS, Material(exponent=50), **settings))
    whole = looked_at("icosphere:0", 12, 10).ordered(np.arange(few))
    adapted = adapt(whole, LIGHTS, Material(exponent=50), **settings)
    return sums(adapted) | {"mix": adapted.mix()}


@pytest.mark.parametrize("name", CASES)
def test_numbers_are_those_recorded(name: str) -> None:
    assert_recorded("adapt", name, computed(name))
