# SPDX-License-Identifier: Apache-2.0
"""Phong shading of many places in one compiled loop: the same sum as ``Material.reflect``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numba import njit

from quadshade.contract.arrays import Floats, Int, Ints
from quadshade.scene.project import Projected
from quadshade.setup.coverage import MeshRows
from quadshade.shading.lights import AmbientLight, DirectionalLight, Light, PointLight
from quadshade.shading.material import Material

TINY = np.finfo(np.float64).tiny
BLOCK = 256
"""Places of a triangle that are shaded together: each loop over them is one that a compiler vectorises."""
ROWS = 23
"""Numbers of each place."""


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
def raise_all(values: Floats, count: Int, exponent: float, whole: int, out: Floats) -> None:
    """:func:`power` of the first ``count`` values, from 0 to 1; ``values`` are overwritten."""
    if whole < 0:
        for place in range(count):
            out[place] = values[place] ** exponent
        return
    for place in range(count):
        out[place] = 1.0
    while whole:
        if whole & 1:
            for place in range(count):
                out[place] *= values[place]
        for place in range(count):
            values[place] *= values[place]
        whole >>= 1


@njit(cache=True, error_model="numpy", fastmath={"contract", "nsz"}, forceinline=True)
def _across(room: Floats, count: Int, one: float, two: float, three: float, out: Floats) -> None:
    """What a triangle's corners carry, at places: ``room`` has the corners' shares in its first rows."""
    first, second, third = room[0], room[1], room[2]
    for i in range(count):
        out[i] = first[i] * one + second[i] * two + third[i] * three


@njit(cache=True, error_model="numpy", fastmath={"contract", "nsz"}, forceinline=True)
def surface_at(lit: LitMesh, triangle: Int, count: Int, room: Floats) -> None:
    """
    The surface at places of a triangle: normals and positions are interpolated with perspective.

    ``room`` (``ROWS``, ``BLOCK``) has the places' barycentric coordinates on the screen in its first three
    rows, and gets the corners' shares in the scene there; then position, unit normal, unit vector to the
    viewer, and the cosine between these two.
    """
    one, two, three, x, y, z = room[0], room[1], room[2], room[3], room[4], room[5]
    nx, ny, nz, vx, vy, vz, toward = room[6], room[7], room[8], room[9], room[10], room[11], room[12]
    first, second, third = lit.weight[triangle, 0], lit.weight[triangle, 1], lit.weight[triangle, 2]
    for i in range(count):
        a, b, c = one[i] * first, two[i] * second, three[i] * third
        total = 1 / (a + b + c)
        one[i], two[i], three[i] = a * total, b * total, c * total
    for axis in range(3):
        corners = lit.normal[triangle]
        _across(room, count, corners[0, axis], corners[1, axis], corners[2, axis], room[6 + axis])
        if lit.near:
            corners = lit.position[triangle]
            _across(room, count, corners[0, axis], corners[1, axis], corners[2, axis], room[3 + axis])
    for i in range(count):
        square = nx[i] * nx[i] + ny[i] * ny[i] + nz[i] * nz[i]
        scale = 1 / np.sqrt(square if square > 0 else 1.0)
        nx[i], ny[i], nz[i] = nx[i] * scale, ny[i] * scale, nz[i] * scale
    first, second, third = lit.viewer[0], lit.viewer[1], lit.viewer[2]
    if lit.parallel:
        for i in range(count):
            vx[i], vy[i], vz[i] = first, second, third
    else:
        for i in range(count):
            a, b, c = first - x[i], second - y[i], third - z[i]
            square = a * a + b * b + c * c
            scale = 1 / np.sqrt(square if square > 0 else 1.0)
            vx[i], vy[i], vz[i] = a * scale, b * scale, c * scale
    for i in range(count):
        toward[i] = nx[i] * vx[i] + ny[i] * vy[i] + nz[i] * vz[i]


@njit(cache=True, error_model="numpy", fastmath={"contract", "nsz"}, forceinline=True)
def cosines_to(lit: LitMesh, index: Int, count: Int, room: Floats) -> None:
    """
    How a light, not an ambient one, arrives at the places of :func:`surface_at`.

    Rows 13 to 15 of ``room`` get its cosine with the normal, what is raised to the exponent (N.H or R.V), and
    its intensity.
    """
    x, y, z, nx, ny, nz = room[3], room[4], room[5], room[6], room[7], room[8]
    vx, vy, vz, toward, facing, cosine = room[9], room[10], room[11], room[12], room[13], room[14]
    intensity, light = room[15], lit.lights[index]
    lx, ly, lz = light[1], light[2], light[3]
    constant, linear, square = light[7], light[8], light[9]
    if light[0] == 2:
        for i in range(count):
            a, b, c = lx - x[i], ly - y[i], lz - z[i]
            distance = np.sqrt(a * a + b * b + c * c)
            fall = constant + (linear + square * distance) * distance
            intensity[i] = 1 / (max(1e-12, fall))
            scale = 1 / (max(TINY, distance))
            facing[i] = (nx[i] * a + ny[i] * b + nz[i] * c) * scale
            cosine[i] = (vx[i] * a + vy[i] * b + vz[i] * c) * scale
    else:
        for i in range(count):
            intensity[i] = 1.0
            facing[i] = nx[i] * lx + ny[i] * ly + nz[i] * lz
            cosine[i] = vx[i] * lx + vy[i] * ly + vz[i] * lz
    if lit.mirror:
        for i in range(count):
            cosine[i] = 2 * facing[i] * toward[i] - cosine[i]
    else:
        for i in range(count):
            doubled = 2 + 2 * cosine[i]
            cosine[i] = (facing[i] + toward[i]) / np.sqrt(max(1e-30, doubled))


@njit(cache=True, error_model="numpy", fastmath={"contract", "nsz"}, forceinline=True)
def light_at(lit: LitMesh, triangle: Int, count: Int, room: Floats) -> None:
    """Light at places, clamped and at full scale: from barycentric coordinates to colours, in ``room``."""
    surface_at(lit, triangle, count, room)
    facing, cosine, intensity, shine = room[13], room[14], room[15], room[16]
    for colour in range(3):
        base, out, own, level = room[17 + colour], room[20 + colour], lit.colour[colour], 0.0
        for index in range(len(lit.lights)):
            if lit.lights[index, 0] == 0:
                level += lit.lights[index, 4 + colour] * lit.ambient[colour]
        if len(lit.base):
            corners = lit.base[triangle]
            _across(room, count, corners[0, colour], corners[1, colour], corners[2, colour], base)
            for i in range(count):
                out[i] = level * base[i]
        else:
            for i in range(count):
                base[i], out[i] = own, level * own
    for index in range(len(lit.lights)):
        light = lit.lights[index]
        if light[0] == 0:
            continue
        cosines_to(lit, index, count, room)
        for i in range(count):
            arriving = intensity[i] if facing[i] > 0 else 0.0
            facing[i] *= arriving
            intensity[i] = arriving if cosine[i] > 0 else 0.0
            level = cosine[i] if cosine[i] < 1 else 1.0
            cosine[i] = level if level > 0 else 0.0
        raise_all(cosine, count, lit.exponent, lit.whole, shine)
        for i in range(count):
            shine[i] *= intensity[i]
        for colour in range(3):
            base, out = room[17 + colour], room[20 + colour]
            level, part = light[4 + colour] * lit.diffuse[colour], light[4 + colour] * lit.specular[colour]
            for i in range(count):
                out[i] += facing[i] * (level * base[i]) + shine[i] * part
    full = lit.full
    for colour in range(3):
        out, source = room[colour], room[20 + colour]
        for i in range(count):
            level = source[i] if source[i] > 0 else 0.0
            out[i] = (level if level < 1 else 1.0) * full


@njit(cache=True, error_model="numpy", fastmath={"contract", "nsz"}, forceinline=True)
def _light_pixels(
    lit: LitMesh, triangle: Int, x: Ints, y: Ints, first: Int, bits: int, room: Floats, out: Floats
) -> None:
    """Light at the centres of a triangle's pixels; ``out`` (m, 3) gets it from ``first`` on."""
    count = len(x)
    corners, half = lit.vertices[triangle], 1 << bits
    # Doubles hold these integers exactly; a vector has no products of 64 bits.
    x0, y0 = float(2 * corners[0, 0] - half), float(2 * corners[0, 1] - half)
    ax, ay = 2.0 * (corners[1, 0] - corners[0, 0]), 2.0 * (corners[1, 1] - corners[0, 1])
    bx, by = 2.0 * (corners[2, 0] - corners[0, 0]), 2.0 * (corners[2, 1] - corners[0, 1])
    area, pixel = 1 / (ax * by - bx * ay), 2.0 * half
    one, two, three = room[0], room[1], room[2]
    for i in range(count):
        px, py = x[i] * pixel - x0, y[i] * pixel - y0
        two[i], three[i] = (px * by - bx * py) * area, (ax * py - px * ay) * area
        one[i] = 1 - two[i] - three[i]
    light_at(lit, triangle, count, room)
    for colour in range(3):
        source = room[colour]
        for i in range(count):
            out[first + i, colour] = source[i]


@njit(cache=True, error_model="numpy")
def shade_places(lit: LitMesh, triangle: Ints, weights: Floats) -> Floats:
    """(m, 3) light at barycentric coordinates (m, 3) of triangles (m,): best triangle by triangle."""
    out, room = np.empty((len(triangle), 3)), np.empty((ROWS, BLOCK))
    first = 0
    while first < len(triangle):
        count = 0
        while count < BLOCK and first + count < len(triangle) and triangle[first + count] == triangle[first]:
            for corner in range(3):
                room[corner, count] = weights[first + count, corner]
            count += 1
        light_at(lit, triangle[first], count, room)
        for i in range(count):
            for colour in range(3):
                out[first + i, colour] = room[colour, i]
        first += count
    return out


@njit(cache=True, error_model="numpy")
def shade_pixels(lit: LitMesh, triangle: Ints, x: Ints, y: Ints, subpixel_bits: int) -> Floats:
    """(m, 3) light at the centres of pixels (m,) in triangles (m,): best triangle by triangle."""
    out, room = np.empty((len(triangle), 3)), np.empty((ROWS, BLOCK))
    first = 0
    while first < len(triangle):
        count = 1
        while count < BLOCK and first + count < len(triangle) and triangle[first + count] == triangle[first]:
            count += 1
        last = first + count
        _light_pixels(lit, triangle[first], x[first:last], y[first:last], first, subpixel_bits, room, out)
        first = last
    return out


@njit(cache=True, error_model="numpy")
def shade_rows(lit: LitMesh, rows: MeshRows, subpixel_bits: int, light: Floats) -> None:
    """Write the light (3, m) at all pixels of a mesh."""
    room, x, y = np.empty((ROWS, BLOCK)), np.empty(BLOCK, np.int64), np.empty(BLOCK, np.int64)
    for triangle in range(len(rows.top)):
        row, last = rows.rows[triangle], rows.rows[triangle + 1]
        place, end = rows.places[row], rows.places[last]
        while place < end:
            first, count = place, min(BLOCK, end - place)
            while place < first + count:
                stop = min(rows.places[row + 1], first + count)
                column, scanline = (
                    rows.left[row] - rows.places[row],
                    rows.top[triangle] + row - rows.rows[triangle],
                )
                for i in range(place, stop):
                    x[i - first], y[i - first] = column + i, scanline
                place = stop
                row += place == rows.places[row + 1]
            _light_pixels(lit, triangle, x[:count], y[:count], first, subpixel_bits, room, light.T)
