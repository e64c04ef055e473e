# SPDX-License-Identifier: Apache-2.0
"""
Cool-to-warm tones.

Gooch et al., "A Non-Photorealistic Lighting Model for Automatic Technical Illustration".
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from quadshade.errors import QuadshadeError
from quadshade.shading.lights import AmbientLight, Light
from quadshade.shading.material import Material, dot

COOL, WARM = (0.0, 0.0, 0.55), (0.3, 0.3, 0.0)
ALPHA, BETA = 0.25, 0.5
"""How much of the surface's own colour is in the cool and in the warm tone."""


def gooch_material(material: Material, lights: Sequence[Light]) -> tuple[Material, tuple[Light, ...]]:
    """
    A material whose colour turns from cool to warm with the cosine between normal and light.

    The tone is linear in N.L and changes over the whole surface, shadow side included, so the quadratic
    interpolator carries it as a colour: I = (1 + N.L)/2 warm + (1 - N.L)/2 cool, then the highlight.

    Parameters
    ----------
    material : Material
      Its colour tints both tones; its exponent and specular colour give the highlight.
    lights : sequence of lights
      The first one that is not ambient sets the tones; it counts as white and without fall.

    Returns
    -------
    Material, tuple of lights
      What to shade with.

    Raises
    ------
    QuadshadeError
      No such light, or a material with a reflectance of its own.
    """
    keys = [light for light in lights if not isinstance(light, AmbientLight)]
    if not keys:
        raise QuadshadeError("Gooch's tones need a light that is not ambient", "give --light dir=x,y,z")
    if material.reflectance is not None:
        raise QuadshadeError("--style gooch and --reflectance exclude each other", "give one of them")
    colour = np.asarray(material.colour, dtype=np.float64)
    cool, warm = np.asarray(COOL) + ALPHA * colour, np.asarray(WARM) + BETA * colour

    def tones(
        point: np.ndarray, normal: np.ndarray, to_light: np.ndarray, to_viewer: np.ndarray
    ) -> np.ndarray:
        facing = dot(normal, to_light)[:, None]
        tone = (1 + facing) / 2 * warm + (1 - facing) / 2 * cool
        cosine = material.specular_cosine(facing[:, 0], dot(normal, to_viewer), dot(to_light, to_viewer))
        highlight = np.where(facing[:, 0] > 0, np.clip(cosine, 0, 1) ** material.exponent, 0)
        return tone + highlight[:, None] * np.asarray(material.specular)

    key = replace(keys[0], colour=(1.0, 1.0, 1.0))
    return replace(material, reflectance=tones), (key,)
