# SPDX-License-Identifier: Apache-2.0
"""Light at a point in compiled loops, in float: the same sum as ``Material.reflect``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numba import njit

from quadshade.contract.arrays import Floats
from quadshade.errors import QuadshadeError
from quadshade.scene.project import Projected
from quadshade.shading.lights import AmbientLight, Light, PointLight
from quadshade.shading.material import Material

COLOURS = 3


def compiled_surface(
    projected: Projected, lights: Sequence[Light], material: Material, full: float
) -> tuple[Any, ...]:
    """
    What :func:`light_point` needs: eye, ambient, a row of nine numbers a light, material, largest value.

    Raises
    ------
    QuadshadeError
      A light, a material or a view of another kind.
    """
    points = [light for light in lights if isinstance(light, PointLight)]
    ambient = [light.colour for light in lights if isinstance(light, AmbientLight)]
    if len(points) + len(ambient) < len(lights) or projected.eye is None:
        raise QuadshadeError(
            "the software renderer got a directional light or an orthographic view",
            "give point lights and a view in perspective",
        )
    if material.incidence is not None:
        raise QuadshadeError("the software renderer got a W that varies", "give the material's specular")
    if material.reflectance is not None or projected.colour is not None:
        raise QuadshadeError(
            "the software renderer got a user's reflectance or a coloured mesh", "give the material's colour"
        )
    base = np.asarray(material.colour)
    rows = [(*light.position, *light.colour, *light.attenuation) for light in points]
    return (
        projected.eye,
        np.sum(np.array(ambient).reshape(-1, COLOURS), axis=0) * np.asarray(material.ambient) * base,
        np.array(rows, dtype=np.float64).reshape(-1, 9),
        np.asarray(material.diffuse) * base,
        np.asarray(material.specular, dtype=np.float64),
        material.exponent,
        material.model == "phong",
        full,
    )


@njit(cache=True, error_model="numpy")
def light_point(normal: Floats, point: Floats, surface: tuple[Any, ...], out: Floats) -> None:
    """
    The light that a point reflects to the eye, as ``Material.reflect``, clamped and at full scale.

    ``normal`` and ``point`` are a point's (3,) vectors, the normal of any length.
    """
    eye, ambient, lights, diffuse, specular, exponent, mirror, full = surface
    nx, ny, nz = normal[0], normal[1], normal[2]
    scale = 1 / np.sqrt(nx * nx + ny * ny + nz * nz)
    nx, ny, nz = nx * scale, ny * scale, nz * scale
    vx, vy, vz = eye[0] - point[0], eye[1] - point[1], eye[2] - point[2]
    scale = 1 / np.sqrt(vx * vx + vy * vy + vz * vz)
    vx, vy, vz = vx * scale, vy * scale, vz * scale
    toward = nx * vx + ny * vy + nz * vz
    red, green, blue = ambient[0], ambient[1], ambient[2]
    for index in range(len(lights)):
        light = lights[index]
        lx, ly, lz = light[0] - point[0], light[1] - point[1], light[2] - point[2]
        distance = np.sqrt(lx * lx + ly * ly + lz * lz)
        lx, ly, lz = lx / distance, ly / distance, lz / distance
        facing = nx * lx + ny * ly + nz * lz
        if facing > 0:
            intensity = 1 / (light[6] + (light[7] + light[8] * distance) * distance)
            between = lx * vx + ly * vy + lz * vz
            if mirror:
                cosine = 2 * facing * toward - between
            else:
                cosine = (facing + toward) / np.sqrt(max(2 + 2 * between, 1e-30))
            shine = min(cosine, 1.0) ** exponent if cosine > 0 else 0.0
            red += intensity * light[3] * (facing * diffuse[0] + shine * specular[0])
            green += intensity * light[4] * (facing * diffuse[1] + shine * specular[1])
            blue += intensity * light[5] * (facing * diffuse[2] + shine * specular[2])
    out[0], out[1], out[2] = min(red, 1.0) * full, min(green, 1.0) * full, min(blue, 1.0) * full
