# SPDX-License-Identifier: Apache-2.0
"""What planning ends with: triangles to be drawn, and what they are made of."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from quadshade.adapt.costs import state_bytes
from quadshade.contract.formats import ORDER_NAMES, Formats
from quadshade.contract.triangles import ScreenTriangles
from quadshade.scene.project import Projected


class Rival(NamedTuple):
    """
    What is known of the next best kind of channels.

    Attributes
    ----------
    shading : str
    bytes : int or None
      Of its picture; where none was drawn because it could not win, what it would take at least, about.
    error : float or None
      As of :class:`Adapted`, where it was drawn.
    reason : str
      Why there is no picture of that kind; empty where there is one.
    """

    shading: str
    bytes: int | None = None
    error: float | None = None
    reason: str = ""


@dataclass(frozen=True)
class Adapted:
    """
    What is to be drawn, and what it is made of.

    Attributes
    ----------
    triangles : ScreenTriangles
    projected : Projected
      The same triangles in the scene.
    root : (n,) int64
      Triangle of the undivided mesh that each is a part of.
    roots : int
    measure : str
      ``max`` or ``rms``.
    error : float
      In output units against Phong shading, by that measure, the output's rounding included.
    verified : bool
      The error is that of every pixel that the golden model draws. Else it is an estimate from samples, and
      no bound.
    shading : str
      ``quadratic`` (red, green, blue), ``quadratic-specular`` (diffuse and specular cosines) or
      ``quadratic-lights`` (diffuse and specular parts).
    formats : Formats
      Of the core that draws it.
    rival : Rival or None
      Where other kinds of channels were tried, what is known of the next best.
    line_bytes : int or None
      The most that it takes on the serial line, where the budget was one of these.
    fit : str
      ``minimax`` where parts are fitted anew, which took less; else ``six-point``.
    """

    triangles: ScreenTriangles
    projected: Projected
    root: np.ndarray
    roots: int
    measure: str
    error: float
    verified: bool
    shading: str
    formats: Formats
    rival: Rival | None = None
    line_bytes: int | None = None
    fit: str = "six-point"

    def mix(self) -> dict[str, Any]:
        """Counts for reports: shading, triangles sent, divided ones, and triangles and channels by order."""
        orders, names = self.triangles.orders, self.triangles.channels
        highest = np.bincount(orders.max(axis=1, initial=0), minlength=len(ORDER_NAMES))
        channels = np.bincount(orders.ravel(), minlength=len(ORDER_NAMES))
        specular = orders[:, [name.startswith("s") for name in names]]
        powers = np.bincount(specular.ravel(), minlength=len(ORDER_NAMES))
        return {
            "adaptive_shading": self.shading,
            "fit": self.fit,
            "rival": None if self.rival is None else self.rival._asdict(),
            "state_bytes": state_bytes(self.triangles, self.formats),
            "line_bytes": self.line_bytes,
            "specular_by_order": dict(zip(ORDER_NAMES, map(int, powers), strict=True)),
            "triangles_of_mesh": self.roots,
            "divided": int((np.bincount(self.root, minlength=self.roots) > 1).sum()),
            "triangles": len(self.root),
            "triangles_by_order": dict(zip(ORDER_NAMES, map(int, highest), strict=True)),
            "channels_by_order": dict(zip(ORDER_NAMES, map(int, channels), strict=True)),
            "error_measure": self.measure,
            "error": self.error,
            "error_verified": self.verified,
        }
