# SPDX-License-Identifier: Apache-2.0
"""What every reader of mesh files returns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from quadshade.errors import QuadshadeError

MOST_TRIANGLES = 20_000_000
"""More are refused: a small file that names one part often could fill the memory."""


@dataclass(frozen=True)
class Part:
    """
    A part of a mesh file, placed where the file places it.

    Attributes
    ----------
    vertices : (m, 3) float64
    faces : (n, 3) int64
      Indices into ``vertices``, counter-clockwise seen from outside.
    normals : (n, 3, 3) float64, optional
      At each corner of each face, of any length; not finite where the file gives none.
    colours : (n, 3, 3) float64, optional
      At each corner of each face, 0 .. 1; not finite where the file gives none.
    double_sided : bool
      The file says that the part is seen from both sides.
    """

    vertices: np.ndarray
    faces: np.ndarray
    normals: np.ndarray | None = None
    colours: np.ndarray | None = None
    double_sided: bool = False


@dataclass(frozen=True)
class MeshFile:
    """
    Everything that a mesh file shows.

    Attributes
    ----------
    parts : sequence of Part
    notes : sequence of str
      What the file holds and a picture does not show, a sentence each.
    """

    parts: Sequence[Part]
    notes: Sequence[str] = ()


OPAQUE = "its colours are transparent: drawn opaque"
"""The note on colours with an alpha below 1."""


def plural(count: int, noun: str) -> str:
    """``1 face``, ``2 faces``; of nouns that end otherwise, give both forms: ``vertex/vertices``."""
    one, _, more = noun.partition("/")
    return f"{count} {one if count == 1 else more or one + 's'}"


def text_lines(text: str) -> list[str]:
    """Lines of a text from any system; nothing but a line's end ends one, as it would for ``splitlines``."""
    return text.replace("\r\n", "\n").replace("\r", "\n").split("\n")


def check_finite(points: np.ndarray) -> None:
    """Raise :class:`QuadshadeError` for the first of (m, 3) points that is not finite or far out of reach."""
    bad = points[~np.isfinite(points).all(axis=1)]
    if len(bad):
        raise QuadshadeError(f"a vertex is {bad[0].tolist()}, not finite", "repair the mesh")
    if points.size and np.abs(points).max() > 1e100:
        raise QuadshadeError("a vertex is farther than 1e100 from the origin", "scale the mesh down")


def check_faces(faces: np.ndarray, vertices: int) -> None:
    """Raise :class:`QuadshadeError` for a face that names none of so many vertices."""
    if faces.size and (faces.min() < 0 or faces.max() >= vertices):
        index = int(faces[(faces < 0) | (faces >= vertices)].flat[0])
        raise QuadshadeError(
            f"a face names a vertex that does not exist: {index} of {vertices}, counted from 0",
            "repair the mesh",
        )


def check_colours(colours: np.ndarray, what: str) -> None:
    """Raise :class:`QuadshadeError` for a colour outside 0 .. 1; NaN means that there is none."""
    bad = colours[(colours < 0) | (colours > 1)]
    if bad.size:
        raise QuadshadeError(f"{what} of {bad.flat[0]:g}, outside 0 .. 1", "scale the colours to 0 .. 1")
