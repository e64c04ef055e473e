# SPDX-License-Identifier: Apache-2.0
"""Wavefront OBJ files."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np

from quadshade.errors import QuadshadeError
from quadshade.scene.readers.mtl import Material, read_mtl
from quadshade.scene.readers.part import MeshFile, Part, check_colours, plural, text_lines
from quadshade.scene.readers.polygons import triangulate

NAMES = ("usemtl", "mtllib", "g", "o")
"""Statements whose names may hold a ``#``."""

INDEXED = ("vertex", "texture coordinate", "normal")
LARGEST_INDEX = 1 << 40
NO_INDEX = -1
NO_EFFECT = frozenset(
    {
        "g", "o", "mg", "vp", "lod", "shadow_obj", "trace_obj", "bevel", "c_interp", "d_interp",
        "usemap", "maplib", "ctech", "stech", "deg", "bmat", "step", "cstype", "parm", "trim", "hole",
        "scrv", "sp", "end", "con",
    }
)  # fmt: skip
"""Statements that change nothing of the triangles' shape and colour."""

NOT_SHOWN = {"p": "point element", "l": "line element", "curv": "curve", "curv2": "curve"}
REFUSED = {"surf": "a free-form surface", "call": "a call of another file", "csh": "a shell command"}


@dataclass
class Statements:
    """An OBJ's data as it stands; indices count from 0, ``NO_INDEX`` for none. ``known``: corners by word."""

    positions: list[list[float]] = field(default_factory=list)
    colours: list[list[float] | None] = field(default_factory=list)
    places: list[list[float]] = field(default_factory=list)
    normals: list[list[float]] = field(default_factory=list)
    corners: list[tuple[int, int, int]] = field(default_factory=list)
    known: dict[str, tuple[int, int, int]] = field(default_factory=dict)
    counts: list[int] = field(default_factory=list)
    materials: list[str | None] = field(default_factory=list)
    libraries: list[str] = field(default_factory=list)
    smoothing: bool = False
    skipped: Counter[str] = field(default_factory=Counter)


def read_obj(text: str, fetch: Callable[[str], bytes]) -> MeshFile:
    """
    The mesh of an OBJ file, with the diffuse colours and textures of its materials.

    Parameters
    ----------
    text : str
    fetch : callable
      The content of a file beside this one, by its name.

    Returns
    -------
    MeshFile

    Raises
    ------
    QuadshadeError
      A statement that is malformed or cannot be drawn, or a material that is nowhere defined.
    """
    found = _read_statements(text)
    notes = [f"{plural(count, what)} not drawn" for what, count in found.skipped.items()]
    positions = np.array(found.positions, dtype=np.float64).reshape(-1, 3)
    corners = np.array(found.corners, dtype=np.int64).reshape(-1, 3)
    _check_range(corners[:, 0], len(positions), "vertex")
    _check_range(corners[:, 2], len(found.normals), "normal")
    points = positions[corners[:, 0]]
    index, owner, more = triangulate(points, np.array(found.counts, dtype=np.int64))
    faces = corners[index]
    colours = _face_colours(found, faces, owner, fetch, more)
    normals = None
    if (faces[..., 2] != NO_INDEX).any():
        listed = np.array([*found.normals, [np.nan] * 3], dtype=np.float64)
        normals = listed[faces[..., 2]]
    elif found.smoothing:
        more.append("smoothing groups not used: its normals follow from the crease angle")
    return MeshFile([Part(positions, faces[..., 0], normals, colours)], notes + more)


def _lines(text: str) -> Iterator[tuple[int, str]]:
    """Statements with the numbers of their first lines: a backslash joins a line and the next."""
    started, number = "", 0
    for index, line in enumerate(text_lines(text), 1):
        number = number if started else index
        if line.endswith("\\"):
            started += line[:-1] + " "
            continue
        yield number, started + line
        started = ""
    if started:
        yield number, started


def _read_statements(text: str) -> Statements:
    """All statements of a file."""
    found = Statements()
    material: str | None = None
    for number, line in _lines(text):
        words = line.split("#", 1)[0].split() if "#" in line else line.split()
        if not words:
            continue
        key, values = words[0], words[1:]
        try:
            if key == "f":
                _read_face(found, values)
                found.materials.append(material)
            elif key == "v":
                _read_vertex(found, values)
            elif key == "vn":
                found.normals.append(_reals(values, 3, 3))
            elif key == "vt":
                found.places.append([*_reals(values, 1, 3), 0.0][:2])
            elif key in NAMES:
                name = re.split(r"\s#", line, maxsplit=1)[0].strip()[len(key) :].strip()
                if key == "usemtl":
                    material = " ".join(name.split()) or None
                elif key == "mtllib":
                    found.libraries.append(name)
            elif key == "s":
                found.smoothing = True
            elif key in REFUSED:
                raise QuadshadeError(f"{REFUSED[key]}, which is not read", "save the mesh as polygons")
            elif key in NOT_SHOWN:
                found.skipped[NOT_SHOWN[key]] += 1
            elif key not in NO_EFFECT:
                found.skipped[
                    f"statement {key[:20]!r} that no OBJ has/statements {key[:20]!r} that no OBJ has"
                ] += 1
        except QuadshadeError as error:
            raise QuadshadeError(f"line {number} {_verb(error.message)}", error.hint) from None
    return found


def _verb(message: str) -> str:
    """A message as the rest of a sentence about a line."""
    return message if message.startswith(("names", "has")) else f"has {message}"


def _reals(words: list[str], least: int, most: int) -> list[float]:
    """So many numbers."""
    if not least <= len(words) <= most:
        wanted = str(least) if least == most else f"{least} to {most}"
        raise QuadshadeError(f"{plural(len(words), 'number')} where {wanted} should be", "repair the mesh")
    try:
        return [float(word) for word in words]
    except ValueError:
        raise QuadshadeError(f"{' '.join(words)[:40]!r}, not numbers", "repair the mesh") from None


def _read_vertex(found: Statements, words: list[str]) -> None:
    """``v x y z``, with a weight, which only curves use, or with red, green and blue."""
    numbers = _reals(words, 3, 7)
    if len(numbers) == 5:
        raise QuadshadeError("5 numbers where 3, 4, 6 or 7 should be", "repair the mesh")
    found.positions.append(numbers[:3])
    found.colours.append(numbers[-3:] if len(numbers) >= 6 else None)


def _read_face(found: Statements, words: list[str]) -> None:
    """``f v v v``, each v, v/vt, v//vn or v/vt/vn; a negative index counts back from here."""
    for word in words:
        corner = found.known.get(word)
        if corner is None:
            corner = _read_corner(word, (len(found.positions), len(found.places), len(found.normals)))
            if "-" not in word:
                found.known[word] = corner
        found.corners.append(corner)
    found.counts.append(len(words))


def _read_corner(word: str, sizes: tuple[int, int, int]) -> tuple[int, int, int]:
    """A corner's three indices, where so many vertices, texture coordinates and normals stand before it."""
    parts = word.split("/")
    corner = [NO_INDEX] * 3
    try:
        indices = [int(part) if part else None for part in parts]
    except ValueError:
        indices = []
    if not 1 <= len(indices) <= 3 or indices[0] is None:
        raise QuadshadeError(f"the corner {word[:40]!r}", "write v, v/vt, v//vn or v/vt/vn")
    for kind, index in enumerate(indices):
        if index is None:
            continue
        what = INDEXED[kind]
        if index == 0:
            raise QuadshadeError(f"names {what} 0", "repair it: an OBJ counts from 1")
        if not -sizes[kind] <= index <= LARGEST_INDEX:
            raise QuadshadeError(f"names {what} {index} where there are {sizes[kind]}", "repair the mesh")
        corner[kind] = index - 1 if index > 0 else sizes[kind] + index
    return corner[0], corner[1], corner[2]


def _check_range(index: np.ndarray, size: int, what: str) -> None:
    """Raise for the first index beyond so many."""
    bad = index[index >= size]
    if len(bad):
        raise QuadshadeError(
            f"a face names a {what} that does not exist: {bad[0] + 1} of {size}", "repair the mesh"
        )


def _face_colours(
    found: Statements,
    faces: np.ndarray,
    owner: np.ndarray,
    fetch: Callable[[str], bytes],
    notes: list[str],
) -> np.ndarray | None:
    """(n, 3, 3) colours of corners: material times texture times vertex; NaN or None without any."""
    names = [found.materials[polygon] for polygon in owner.tolist()]
    library = _read_libraries(found, fetch, notes)
    colours = np.full((len(faces), 3, 3), np.nan)
    order = {name: number for number, name in enumerate(dict.fromkeys(names))}
    number = np.array([order[name] for name in names], dtype=np.int64)
    for name, place in order.items():
        if name is None or not library:
            continue
        if name not in library:
            raise QuadshadeError(
                f"the material {name!r} is not in {', '.join(found.libraries)}",
                "add it there, or remove its usemtl lines",
            )
        chosen = np.flatnonzero(number == place)
        colours[chosen] = _material_colours(found, faces[chosen], library[name])
        if library[name].transparent:
            notes.append(f"the material {name!r} is transparent: drawn opaque")
    own = [[np.nan] * 3 if colour is None else colour for colour in found.colours]
    vertex_colours = np.array(own, dtype=np.float64).reshape(-1, 3)[faces[..., 0]]
    check_colours(vertex_colours, "a vertex has a colour")
    painted = np.isfinite(vertex_colours).all(axis=-1, keepdims=True)
    plain = np.where(np.isfinite(colours), colours, 1.0)
    colours = np.where(painted, plain * vertex_colours, colours)
    return colours if np.isfinite(colours).any() else None


def _material_colours(found: Statements, faces: np.ndarray, material: Material) -> np.ndarray:
    """(n, 3, 3) colours of (n, 3, 3) corners in one material."""
    if material.texture is None:
        colour = np.full(3, np.nan) if material.colour is None else material.colour
        return np.broadcast_to(colour, faces.shape)
    index = faces[..., 1]
    if (index == NO_INDEX).any() or (index >= len(found.places)).any():
        raise QuadshadeError(
            "a face with a textured material has no texture coordinates",
            "add them, or remove the map_Kd line",
        )
    places = np.array(found.places, dtype=np.float64)[index] * material.scale + material.offset
    # The file counts upwards from the picture's lower edge.
    texels = material.texture.at_corners(np.stack([places[..., 0], 1 - places[..., 1]], axis=-1))
    return texels[..., :3] if material.colour is None else texels[..., :3] * material.colour


def _read_libraries(
    found: Statements, fetch: Callable[[str], bytes], notes: list[str]
) -> dict[str, Material]:
    """The materials of all libraries; a name that holds blanks is one file, or else several."""
    library: dict[str, Material] = {}
    if not any(found.materials):
        return library
    if not found.libraries:
        notes.append("its materials are named but nowhere defined (no mtllib): drawn in the given material")
    for names in dict.fromkeys(found.libraries):
        try:
            contents = {names: fetch(names)}
        except QuadshadeError:
            if len(names.split()) < 2:
                raise
            contents = {name: fetch(name) for name in names.split()}
        for name, content in contents.items():
            text = content.decode("utf-8-sig", errors="replace")
            library = read_mtl(text, name, fetch) | library
    return library
