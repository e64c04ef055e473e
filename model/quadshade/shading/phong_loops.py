# SPDX-License-Identifier: Apache-2.0
"""Phong shading of many places in one compiled loop: the same sum as ``Material.reflect``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numba import njit

from quadshade.contract.arrays import Floats, Int, Ints
from quadshade.scene.project import Projected
from quadshade.shading.lights import AmbientLight, DirectionalLight, Light, PointLight
from quadshade.shading.material import Material

TINY = np.finfo(np.float64).tiny


class LitMesh(NamedTuple):
    """
    A mesh with lights and a material, as the loops take them.

    Attributes
    ----------
    vertices : (n, 3, 2) int64
    weight : (n, 3) float64
    position, normal : (n, 3, 3) float64
    base : (n, 3, 3) float64
      The mesh's own colours; none (0 triangles) where the material has the colour.
    viewer : (3,) float64
      Where the eye is, or, if ``parallel``, the direction towards it.
    parallel : bool
    near : bool
      The eye or a light is at a place: positions count.
    lights : (l, 10) float64
      In the order of the scene: what it is (0 ambient, 1 directional, 2 point), direction or position,
      colour, attenuation.
    colour, ambient, diffuse, specular : (3,) float64
    exponent : float
    whole : int
      The exponent where it is an integer, else -1.
    mirror : bool
      Phong's reflection vector, not Blinn's half vector.
    full : float
      Largest value of the output.
    """

    vertices: Ints
    weight: Floats
    position: Floats
    normal: Floats
    base: Floats
    viewer: Floats
    parallel: bool
    near: bool
    lights: Floats
    colour: Floats
    ambient: Floats
    diffuse: Floats
    specular: Floats
    exponent: float
    whole: int
    mirror: bool
    full: float


def lit_mesh(
    projected: Projected, lights: Sequence[Light], material: Material, full: float
) -> LitMesh | None:
    """
    What the loops take, or None where only ``Material.reflect`` can shade: a user's function, W of an angle.

    Parameters
    ----------
    projected : Projected
    lights : sequence of lights
    material : Material
    full : float
      Largest value of the output.

    Returns
    -------
    LitMesh or None
    """
    if material.reflectance is not None or material.incidence is not None:
        return None
    rows = np.zeros((len(lights), 10))
    for row, light in zip(rows, lights, strict=True):
        row[4:7] = light.colour
        if isinstance(light, AmbientLight):
            continue
        if isinstance(light, DirectionalLight):
            row[0], row[1:4] = 1, light.reach(np.zeros((1, 3)))[0]
        elif isinstance(light, PointLight):
            row[0], row[1:4], row[7:] = 2, light.position, light.attenuation
        else:
            return None

    def floats(values: object) -> Floats:
        return np.ascontiguousarray(values, dtype=np.float64)

    base = np.empty((0, 3, 3)) if projected.colour is None else projected.colour
    return LitMesh(
        np.ascontiguousarray(projected.vertices, dtype=np.int64),
        floats(projected.weight),
        floats(projected.position),
        floats(projected.normal),
        floats(base),
        floats(projected.axes[2] if projected.eye is None else projected.eye),
        projected.eye is None,
        projected.eye is not None or bool((rows[:, 0] == 2).any()),
        rows,
        floats(material.colour),
        floats(material.ambient),
        floats(material.diffuse),
        floats(material.specular),
        float(material.exponent),
        int(material.exponent) if material.exponent == int(material.exponent) else -1,
        material.model == "phong",
        float(full),
    )


@njit(cache=True, error_model="numpy", forceinline=True)
def _across(
    corners: Floats, triangle: Int, one: float, two: float, three: float
) -> tuple[float, float, float]:
    """What three corners of a triangle carry, by their shares."""
    return (
        one * corners[triangle, 0, 0] + two * corners[triangle, 1, 0] + three * corners[triangle, 2, 0],
        one * corners[triangle, 0, 1] + two * corners[triangle, 1, 1] + three * corners[triangle, 2, 1],
        one * corners[triangle, 0, 2] + two * corners[triangle, 1, 2] + three * corners[triangle, 2, 2],
    )


@njit(cache=True, error_model="numpy", forceinline=True)
def _unit(x: float, y: float, z: float) -> tuple[float, float, float]:
    """A vector at unit length; zero stays zero."""
    square = x * x + y * y + z * z
    scale = 1 / np.sqrt(square) if square > 0 else 0.0
    return x * scale, y * scale, z * scale


@njit(cache=True, error_model="numpy", forceinline=True)
def power(value: float, exponent: float, whole: int) -> float:
    """A value from 0 to 1 raised to an exponent; ``whole`` is the exponent, or -1 where it is no integer."""
    if whole < 0:
        return value**exponent
    out = 1.0
    while whole:
        if whole & 1:
            out *= value
        value *= value
        whole >>= 1
    return out


@njit(cache=True, error_model="numpy", forceinline=True)
def _light(
    lit: LitMesh, triangle: Int, first: float, second: float, third: float
) -> tuple[float, float, float]:
    """
    Light at a place of a triangle, by barycentric coordinates on the screen, clamped and at full scale.

    Normals and positions are interpolated with perspective.
    """
    weight, lights = lit.weight, lit.lights
    one, two, three = first * weight[triangle, 0], second * weight[triangle, 1], third * weight[triangle, 2]
    total = 1 / (one + two + three)
    one, two, three = one * total, two * total, three * total
    nx, ny, nz = _unit(*_across(lit.normal, triangle, one, two, three))
    vx, vy, vz = lit.viewer[0], lit.viewer[1], lit.viewer[2]
    x, y, z = 0.0, 0.0, 0.0
    if lit.near:
        x, y, z = _across(lit.position, triangle, one, two, three)
    if not lit.parallel:
        vx, vy, vz = _unit(vx - x, vy - y, vz - z)
    toward = nx * vx + ny * vy + nz * vz
    base = lit.colour[0], lit.colour[1], lit.colour[2]
    if len(lit.base):
        base = _across(lit.base, triangle, one, two, three)
    ambient, diffuse, specular = lit.ambient, lit.diffuse, lit.specular
    red, green, blue = 0.0, 0.0, 0.0
    for index in range(len(lights)):
        kind = lights[index, 0]
        r, g, b = lights[index, 4], lights[index, 5], lights[index, 6]
        if kind == 0:
            red += r * ambient[0] * base[0]
            green += g * ambient[1] * base[1]
            blue += b * ambient[2] * base[2]
            continue
        lx, ly, lz, intensity = lights[index, 1], lights[index, 2], lights[index, 3], 1.0
        if kind == 2:
            lx, ly, lz = lx - x, ly - y, lz - z
            distance = np.sqrt(lx * lx + ly * ly + lz * lz)
            fall = lights[index, 7] + (lights[index, 8] + lights[index, 9] * distance) * distance
            intensity = 1 / max(fall, 1e-12)
            distance = max(distance, TINY)
            lx, ly, lz = lx / distance, ly / distance, lz / distance
        facing = nx * lx + ny * ly + nz * lz
        if facing > 0:
            between = lx * vx + ly * vy + lz * vz
            if lit.mirror:
                cosine = 2 * facing * toward - between
            else:
                cosine = (facing + toward) / np.sqrt(max(2 + 2 * between, 1e-30))
            arriving = facing * intensity
            shine = power(min(cosine, 1.0), lit.exponent, lit.whole) * intensity if cosine > 0 else 0.0
            red += arriving * (r * diffuse[0] * base[0]) + shine * (r * specular[0])
            green += arriving * (g * diffuse[1] * base[1]) + shine * (g * specular[1])
            blue += arriving * (b * diffuse[2] * base[2]) + shine * (b * specular[2])
    full = lit.full
    return min(max(red, 0.0), 1.0) * full, min(max(green, 0.0), 1.0) * full, min(max(blue, 0.0), 1.0) * full


@njit(cache=True, error_model="numpy")
def shade_places(lit: LitMesh, triangle: Ints, weights: Floats) -> Floats:
    """(m, k, 3) light at (m, k, 3) or (1, k, 3) barycentric coordinates of (m,) triangles."""
    places = weights.shape[1]
    out = np.empty((len(triangle), places, 3))
    for index in range(len(triangle)):
        row = index if len(weights) > 1 else 0
        for place in range(places):
            out[index, place, 0], out[index, place, 1], out[index, place, 2] = _light(
                lit, triangle[index], weights[row, place, 0], weights[row, place, 1], weights[row, place, 2]
            )
    return out


@njit(cache=True, error_model="numpy", forceinline=True)
def pixel_light(
    lit: LitMesh, triangle: Int, x: Int, y: Int, subpixel_bits: int
) -> tuple[float, float, float]:
    """Light at the centre of a pixel in a triangle, clamped and at full scale."""
    corners = lit.vertices
    x0, y0 = 2 * corners[triangle, 0, 0], 2 * corners[triangle, 0, 1]
    ax, ay = 2 * corners[triangle, 1, 0] - x0, 2 * corners[triangle, 1, 1] - y0
    bx, by = 2 * corners[triangle, 2, 0] - x0, 2 * corners[triangle, 2, 1] - y0
    px, py = ((2 * x + 1) << subpixel_bits) - x0, ((2 * y + 1) << subpixel_bits) - y0
    area = ax * by - bx * ay
    second, third = (px * by - bx * py) / area, (ax * py - px * ay) / area
    return _light(lit, triangle, 1 - second - third, second, third)


@njit(cache=True, error_model="numpy")
def shade_pixels(lit: LitMesh, triangle: Ints, x: Ints, y: Ints, subpixel_bits: int) -> Floats:
    """(m, 3) light at the centres of pixels (m,) in triangles (m,)."""
    out = np.empty((len(triangle), 3))
    for index in range(len(triangle)):
        out[index, 0], out[index, 1], out[index, 2] = pixel_light(
            lit, triangle[index], x[index], y[index], subpixel_bits
        )
    return out
