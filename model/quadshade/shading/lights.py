# SPDX-License-Identifier: Apache-2.0
"""
Ambient, directional and point lights.

``--light`` takes ``dir=x,y,z`` (towards the light), ``point=x,y,z`` or ``ambient=intensity`` (one number or
three), with ``colour=r,g,b`` and, for points, ``attenuation=a,b,c`` for 1 / (a + b d + c d**2).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from quadshade.errors import QuadshadeError
from quadshade.scene.key_values import numbers_of, parse_settings

WHITE = (1.0, 1.0, 1.0)
LIGHT_KEYS = {"dir": (3,), "point": (3,), "ambient": (1, 3), "colour": (1, 3), "attenuation": (3,)}


@dataclass(frozen=True)
class AmbientLight:
    """Light from everywhere, reflected by the material's ambient term."""

    colour: tuple[float, float, float] = WHITE


@dataclass(frozen=True)
class DirectionalLight:
    """A light infinitely far away; ``direction`` points towards it and need not be unit length."""

    direction: tuple[float, float, float]
    colour: tuple[float, float, float] = WHITE

    def __post_init__(self) -> None:
        if not np.linalg.norm(self.direction) > 0:
            raise QuadshadeError("the light's direction is 0,0,0", "give the direction towards the light")

    def reach(self, point: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """
        How the light arrives.

        Parameters
        ----------
        point : (m, 3) float

        Returns
        -------
        to_light : (3,) or (m, 3) float64
          Unit vectors.
        intensity : () or (m,) float64
        """
        direction = np.asarray(self.direction, dtype=np.float64)
        return direction / np.linalg.norm(direction), np.ones(())


@dataclass(frozen=True)
class PointLight:
    """A light at a place, 1 / (a + b d + c d**2) as strong at distance d."""

    position: tuple[float, float, float]
    colour: tuple[float, float, float] = WHITE
    attenuation: tuple[float, float, float] = (1.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        if min(self.attenuation) < 0 or not sum(self.attenuation) > 0:
            raise QuadshadeError(
                f"the light's attenuation is {self.attenuation}", "give three numbers from 0, not all 0"
            )

    def reach(self, point: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """How the light arrives, as for :meth:`DirectionalLight.reach`."""
        vector = np.asarray(self.position, dtype=np.float64) - point
        distance = np.sqrt(np.einsum("mi,mi->m", vector, vector))
        constant, linear, square = self.attenuation
        fall = constant + (linear + square * distance) * distance
        # A light in the surface itself has no direction and, without a constant term, no bound.
        tiny = np.finfo(np.float64).tiny
        return vector / np.maximum(distance, tiny)[:, None], 1 / np.maximum(fall, 1e-12)


PointedLight: TypeAlias = DirectionalLight | PointLight
"""A light that comes from somewhere."""
Light: TypeAlias = AmbientLight | PointedLight

DEFAULT_DIRECTION = (-0.5, 1.0, 1.0)
"""The default light comes from above, in front and a little from the left, as the viewer sees it."""


def default_lights(axes: np.ndarray) -> tuple[Light, ...]:
    """
    White light that goes with the viewer: ambient, and directional along ``DEFAULT_DIRECTION``.

    Parameters
    ----------
    axes : (3, 3) float
      The viewer's right, up and backward.

    Returns
    -------
    tuple of lights
    """
    direction = np.asarray(DEFAULT_DIRECTION) @ axes
    x, y, z = (float(part) for part in direction)
    return AmbientLight(), DirectionalLight((x, y, z))


DEFAULT_LIGHTS = default_lights(np.eye(3))
"""The default lights of a viewer who looks from +z, y up."""


def three(numbers: Sequence[float]) -> tuple[float, float, float]:
    """Three numbers, or one that stands for all three."""
    first, second, third = numbers if len(numbers) > 1 else (*numbers, *numbers, *numbers)
    return first, second, third


def triple(numbers: tuple[float, ...], where: str) -> tuple[float, float, float]:
    """A colour of one (grey) or three numbers; raises :class:`QuadshadeError` for negative ones."""
    if min(numbers) < 0:
        raise QuadshadeError(f"the {where} is {','.join(f'{n:g}' for n in numbers)}", "give numbers from 0")
    return three(numbers)


def parse_light(text: str) -> Light:
    """
    The light that one ``--light`` describes.

    Parameters
    ----------
    text : str
      For example ``dir=1,1,1,colour=1,1,1``, ``point=0,2,2,attenuation=1,0,0.1`` or ``ambient=0.1``.

    Returns
    -------
    AmbientLight, DirectionalLight or PointLight

    Raises
    ------
    QuadshadeError
      A malformed description.
    """
    settings = numbers_of(parse_settings(text, "light", LIGHT_KEYS))
    kinds = [kind for kind in ("dir", "point", "ambient") if kind in settings]
    if len(kinds) != 1:
        raise QuadshadeError(
            f"light {text!r} is of {' and '.join(kinds) or 'no kind'}",
            "give one of dir=, point= and ambient=",
        )
    kind = kinds[0]
    if kind != "point" and "attenuation" in settings:
        raise QuadshadeError(f"light {text!r} has an attenuation", "only a point light has one")
    colour = triple(settings.get("colour", WHITE), "light's colour")
    if kind == "ambient":
        intensity = triple(settings["ambient"], "light's ambient")
        return AmbientLight(three([float(a * b) for a, b in zip(intensity, colour, strict=True)]))
    if kind == "dir":
        return DirectionalLight(three(settings["dir"]), colour)
    attenuation = three(settings.get("attenuation", (1.0, 0.0, 0.0)))
    return PointLight(three(settings["point"]), colour, attenuation)
