# SPDX-License-Identifier: Apache-2.0
"""What a viewer has set: one state is a link, keywords of ``quadshade.render``, and a command line."""

from __future__ import annotations

import math
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from quadshade.choices import DEFAULT_SHADING, FITS, PHONG, SHADINGS
from quadshade.contract.arrays import Floats
from quadshade.errors import QuadshadeError
from quadshade.scene.camera import DEFAULT_FOV, DEFAULT_FROM, FIT_MARGIN
from quadshade.scene.decimate import LEAST
from quadshade.scene.mesh import Mesh

MAPS = ("picture", "error", "orders", "wireframe")
"""What is shown of a picture: itself, its error against Phong shading, orders, or triangles."""

BITS_A_BYTE = 10
"""On a serial line: start, eight, stop."""

STEEPEST = 89.0
"""Degrees; straight from above there is no up."""

RANGES = {
    "yaw": (-1e6, 1e6),
    "pitch": (-STEEPEST, STEEPEST),
    "zoom": (0.05, 50.0),
    "across": (-10.0, 10.0),
    "along": (-10.0, 10.0),
    "light_x": (-1.0, 1.0),
    "light_y": (-1.0, 1.0),
    "exponent": (1.0, 200.0),
    "lod": (0, 1 << 31),
    "max_error": (0.0, 64.0),
    "frame_ms": (0.0, 10_000.0),
    "width": (16, 1024),
    "height": (16, 1024),
    "baud": (9600, 12_000_000),
    "clock_mhz": (1.0, 500.0),
}
"""Least and most of every number; a page cannot ask for more."""

WORDS = {"shading": SHADINGS, "fit": FITS, "map": MAPS}


@dataclass(frozen=True)
class ViewState:
    """
    What is shown, and how.

    Attributes
    ----------
    yaw, pitch : float
      Degrees of the camera about the scene, from +z towards +x, and upwards.
    zoom : float
      1: the scene fits.
    across, along : float
      By how many of its radii the scene is moved to the right and up.
    light_x, light_y : float
      Where the light stands on the half of a ball in front of the scene; both 0.0 and default lights are
      told apart by ``light``.
    light : bool
      Whether the light was moved; else the default lights.
    shading, fit, map : str
    exponent : float
    lod : int
      Triangles of the level of detail, at most; 0: all.
    max_error : float
      Grey levels of an adaptive picture; 0: not adaptive.
    frame_ms : float
      Milliseconds in which a board must have the picture, which is then adaptive too; 0: no matter.
    width, height : int
    baud : int
      Of the line whose frames a second are told.
    clock_mhz : float
      Of the core, too.
    """

    yaw: float = math.degrees(math.atan2(DEFAULT_FROM[0], DEFAULT_FROM[2]))
    pitch: float = math.degrees(math.atan2(DEFAULT_FROM[1], math.hypot(DEFAULT_FROM[0], DEFAULT_FROM[2])))
    zoom: float = 1.0
    across: float = 0.0
    along: float = 0.0
    light: bool = False
    light_x: float = 0.0
    light_y: float = 0.0
    shading: str = DEFAULT_SHADING
    fit: str = FITS[0]
    exponent: float = 20.0
    lod: int = 0
    max_error: float = 0.0
    frame_ms: float = 0.0
    map: str = MAPS[0]
    width: int = 512
    height: int = 512
    baud: int = 1_000_000
    clock_mhz: float = 100.0

    @classmethod
    def read(cls, given: Mapping[str, Any]) -> ViewState:
        """
        A state from a page's message or a link's words.

        Parameters
        ----------
        given : mapping
          Numbers, words, or their texts; what is missing has its default.

        Raises
        ------
        QuadshadeError
          No mapping, an unknown name, or a value out of its range.
        """
        if not isinstance(given, Mapping):
            raise QuadshadeError("a state is no object", "give names and values")
        kinds = {one.name: type(one.default) for one in fields(cls)}
        values: dict[str, Any] = {}
        for name, value in given.items():
            if name not in kinds:
                raise QuadshadeError(
                    f"there is no setting {str(name)[:40]!r}", f"there are {', '.join(kinds)}"
                )
            values[name] = _value(name, value, kinds[name])
        return cls(**values)

    def content(self) -> dict[str, Any]:
        """All settings, for JSON."""
        return {one.name: getattr(self, one.name) for one in fields(self)}

    @property
    def is_adaptive(self) -> bool:
        """Whether orders are chosen, for an error or for the line; nothing else is then left to choose."""
        wanted = self.max_error > 0 or self.frame_ms > 0
        return wanted and self.shading == DEFAULT_SHADING and self.fit == FITS[0]

    def axes(self) -> Floats:
        """(3, 3) float64: right, up and backward of the viewer, in the scene."""
        yaw, pitch = math.radians(self.yaw), math.radians(self.pitch)
        back = np.array([math.sin(yaw) * math.cos(pitch), math.sin(pitch), math.cos(yaw) * math.cos(pitch)])
        right = np.array([math.cos(yaw), 0.0, -math.sin(yaw)])
        return np.stack([right, np.cross(back, right), back])

    def camera(self, mesh: Mesh) -> str:
        """``--camera`` of the state; a scene that stands in the middle at zoom 1 fits."""
        centre, radius = mesh.bounds
        radius = (radius or 1.0) * FIT_MARGIN
        right, up, back = self.axes()
        target = centre - radius * (self.across * right + self.along * up)
        eye = target + back * (radius / math.sin(math.radians(DEFAULT_FOV / 2)) / self.zoom)
        place = {"eye": eye, "target": target, "up": up}
        return ",".join(
            f"{name}={','.join(repr(float(n)) for n in vector)}" for name, vector in place.items()
        )

    def lights(self) -> list[str]:
        """``--light`` of the state, none for the default ones."""
        if not self.light:
            return []
        towards = np.array([self.light_x, self.light_y, 0.0])
        length = float(np.linalg.norm(towards))
        towards /= max(length, 1.0)
        towards[2] = math.sqrt(max(0.0, 1 - min(length, 1.0) ** 2))
        direction = towards @ self.axes()
        return ["ambient=1", f"dir={','.join(repr(float(number)) for number in direction)}"]

    def keywords(self, mesh: Mesh) -> dict[str, Any]:
        """Keywords of :func:`quadshade.render` for the state."""
        given: dict[str, Any] = {
            "size": (self.width, self.height),
            "camera": self.camera(mesh),
            "exponent": self.exponent,
            "lights": self.lights(),
        }
        if 0 < self.lod < len(mesh):
            given["lod"] = max(self.lod, LEAST)
        if self.is_adaptive and self.frame_ms > 0:
            return given | {"frame_time": self.frame_ms, "baud": self.baud, "clock": self.clock_mhz}
        if self.is_adaptive:
            return given | {"max_error": self.max_error}
        fit = self.fit if self.shading == DEFAULT_SHADING else FITS[0]
        return given | {"shading": self.shading, "fit": fit}

    def command(self, scene: str, mesh: Mesh, more: Sequence[str] = ()) -> str:
        """The command line that draws the same picture; ``more`` are options that the state does not set."""
        given = self.keywords(mesh)
        words = [
            "quadshade",
            "render",
            scene,
            "-o",
            "picture.png",
            "--size",
            f"{self.width}x{self.height}",
            *more,
        ]
        words += [f"--camera={given['camera']}", "--exponent", f"{self.exponent:.12g}"]
        words += [word for light in given["lights"] for word in ("--light", light)]
        for name in ("shading", "fit", "lod", "max_error", "frame_time", "baud", "clock"):
            if name in given and given[name] not in (DEFAULT_SHADING, FITS[0]):
                words += [f"--{name.replace('_', '-')}", str(given[name])]
        return shlex.join(words)

    @property
    def is_reference(self) -> bool:
        """Whether the picture is the reference itself."""
        return self.shading == PHONG


def _value(name: str, given: Any, kind: type) -> Any:
    """A setting's value, of its kind and in its range."""
    if name in WORDS:
        if given not in WORDS[name]:
            raise QuadshadeError(f"the {name} is {str(given)[:40]!r}", f"give {', '.join(WORDS[name])}")
        return given
    if kind is bool:
        if given not in (True, False, "true", "false"):
            raise QuadshadeError(f"{name} is {str(given)[:40]!r}", "give true or false")
        return given in (True, "true")
    least, most = RANGES[name]
    try:
        number = float(given)
    except (TypeError, ValueError, OverflowError):
        number = math.nan
    if not least <= number <= most or (kind is int and number != int(number)):
        raise QuadshadeError(f"{name} is {str(given)[:40]!r}", f"give a number from {least:g} to {most:g}")
    return kind(number)
