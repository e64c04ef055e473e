# SPDX-License-Identifier: Apache-2.0
"""From a state to what a viewer sees: the picture or a map of it, and its figures."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

import quadshade
from quadshade.choices import PACK_ERROR
from quadshade.contract.arrays import Bytes
from quadshade.contract.formats import Formats
from quadshade.image import largest_and_rms
from quadshade.image.compare import error_map
from quadshade.packing.line import picture_line_bytes
from quadshade.rendering.picture import Picture
from quadshade.rendering.settings import Reports
from quadshade.scene import Mesh
from quadshade.scene.turned import Detail, Turn
from quadshade.view.state import BITS_A_BYTE, ViewState

ERROR_FULL = 16
"""Grey levels that the error map shows brightest."""

ORDER_NAMES = ("constant", "linear", "quadratic")
ORDER_COLOURS = np.array([(70, 110, 190), (90, 170, 90), (220, 140, 50), (200, 60, 120)])
"""Of the orders, and of a triangle with a power at every pixel."""

LINE_COLOUR = (255, 255, 255)


@dataclass(frozen=True, eq=False)
class Shown:
    """
    What a viewer sees of a state.

    Attributes
    ----------
    image : (height, width, 3) uint8
    figures : dict
      Bytes, clocks, triangles and errors, for JSON.
    """

    image: Bytes
    figures: dict[str, Any]


@dataclass
class Viewed:
    """
    A scene that is being looked at.

    Attributes
    ----------
    name : str
    mesh : Mesh
    keywords : dict
      Of :func:`quadshade.render`, which no state sets.
    words : tuple of str
      The same on the command line.
    crease : float, optional
      What the mesh was read with.
    """

    name: str
    mesh: Mesh
    keywords: Mapping[str, Any] = field(default_factory=dict)
    words: tuple[str, ...] = ()
    crease: float | None = None
    _last: tuple[dict[str, Any], Picture] | None = None

    def __post_init__(self) -> None:
        # It does not turn, but its levels of detail are kept.
        self._stands = Turn(np.eye(3), np.zeros(3), Detail(self.mesh, self.name, self.crease))

    def picture(self, state: ViewState, **more: Any) -> Picture:
        """The picture of a state, as :func:`quadshade.render` draws it."""
        given = {"engine": "model", **self.keywords, **state.keywords(self.mesh), **more}
        if given.get("port") is not None:
            given |= {"baud": None, "clock": None}
        return quadshade.render(self._stands, **given, reports=Reports(notice=lambda _: None))

    def _drawn(self, state: ViewState) -> Picture:
        """The picture of a state; of two states in a row that differ in their map only, it is drawn once."""
        keywords = state.keywords(self.mesh)
        if self._last is None or self._last[0] != keywords:
            self._last = keywords, self.picture(state)
        return self._last[1]

    def show(self, state: ViewState, measure: bool) -> Shown:
        """
        Draw a state.

        Parameters
        ----------
        state : ViewState
        measure : bool
          Whether to compare with Phong shading; the error map always does.

        Returns
        -------
        Shown

        Raises
        ------
        QuadshadeError
          A state that cannot be drawn.
        """
        picture = self._drawn(state)
        measure = measure or state.map == "error"
        reference = None
        if measure:
            reference = picture.array if state.is_reference else picture.phong_array()
        figures = cost(picture, state) | errors(picture, reference)
        figures["levers"] = levers(picture)
        figures |= {"notes": list(picture.notes), "command": state.command(self.name, self.mesh, self.words)}
        return Shown(drawn_map(picture, reference, state.map), figures)


def levers(picture: Picture) -> str | None:
    """What gave a picture its frame time; None where there is none."""
    timing = picture.stats.timing
    if timing is None:
        return None
    faces = f"{picture.stats.faces} of {picture.stats.whole_faces} triangles"
    return f"{faces}, {timing['shading']}, words to {timing['pack_error']:g} grey levels"


def drawn_map(picture: Picture, reference: np.ndarray | None, kind: str) -> Bytes:
    """(height, width, 3) uint8 of one of ``MAPS``."""
    if kind == "error" and reference is not None:
        return heat(error_map(picture.array, reference))
    triangle = picture.triangle
    if kind in ("orders", "wireframe") and triangle is not None:
        image = order_map(picture) if kind == "orders" else picture.array.copy()
        across = triangle[:, 1:] != triangle[:, :-1]
        down = triangle[1:] != triangle[:-1]
        if kind == "wireframe":
            image[:, 1:][across] = LINE_COLOUR
            image[1:][down] = LINE_COLOUR
        return image
    return picture.array


def heat(errors_of: np.ndarray) -> Bytes:
    """(height, width, 3) uint8 colours of errors in grey levels, brightest from ``ERROR_FULL`` on."""
    from matplotlib import colormaps

    table = (colormaps["inferno"](np.linspace(0, 1, ERROR_FULL + 1))[:, :3] * 255).round().astype(np.uint8)
    image: Bytes = table[np.minimum(errors_of, ERROR_FULL)]
    return image


def kinds(picture: Picture) -> np.ndarray:
    """(n,) int order of each triangle's highest channel; 3 where it takes a power at every pixel."""
    triangles = picture.triangles
    highest = triangles.orders.max(axis=1, initial=0)
    specular = [name.startswith("s") for name in triangles.channels]
    powers = (triangles.orders[:, specular] > 0).any(axis=1)
    return np.where(powers, len(ORDER_NAMES), highest)


def order_map(picture: Picture) -> Bytes:
    """(height, width, 3) uint8: a colour for every order, lit as the picture is."""
    assert picture.triangle is not None
    colours = ORDER_COLOURS[kinds(picture)]
    image = np.zeros_like(picture.array)
    covered = picture.triangle >= 0
    light = 0.4 + 0.6 * picture.array.max(axis=2, keepdims=True) / 255
    image[covered] = (colours[picture.triangle[covered]] * light[covered]).astype(np.uint8)
    return image


def cost(picture: Picture, state: ViewState) -> dict[str, Any]:
    """Bytes, clocks and triangles by order, and frames a second by line and by core."""
    stats = picture.stats
    if state.is_reference:
        unknown = dict.fromkeys(("bytes", "line_bytes", "clocks", "line_fps", "core_fps"))
        return {"triangles": len(picture.triangles), "orders": {}, **unknown}
    # The line's packets come from the narrow stream, whatever the core of the engine has.
    formats = replace(Formats(**stats.generics), stream_width=32)
    error = PACK_ERROR if stats.timing is None else stats.timing["pack_error"]
    on_line = picture_line_bytes(picture.triangles, formats, error)
    counts = np.bincount(kinds(picture), minlength=len(ORDER_NAMES) + 1)
    names = (*ORDER_NAMES, "power at the pixel")
    return {
        "triangles": len(picture.triangles),
        "orders": {name: int(count) for name, count in zip(names, counts, strict=True) if count},
        "bytes": None if stats.words is None else 4 * stats.words,
        "line_bytes": on_line,
        "clocks": stats.clocks,
        "line_fps": state.baud / BITS_A_BYTE / on_line,
        "core_fps": state.clock_mhz * 1e6 / stats.clocks if stats.clocks else None,
    }


def errors(picture: Picture, reference: np.ndarray | None) -> dict[str, Any]:
    """Largest and root mean square error in grey levels; None where it was not measured."""
    if reference is None:
        return {"largest_error": None, "rms_error": None}
    largest, rms = largest_and_rms(picture.array, reference)
    return {"largest_error": largest, "rms_error": rms}
