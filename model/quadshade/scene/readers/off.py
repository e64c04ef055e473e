# SPDX-License-Identifier: Apache-2.0
"""OFF files as Geomview writes them: OFF, COFF, NOFF, CNOFF, STOFF and so on, with colours of faces."""

from __future__ import annotations

import re

import numpy as np

from quadshade.errors import QuadshadeError
from quadshade.scene.readers.part import OPAQUE, MeshFile, Part, check_colours, check_faces, text_lines
from quadshade.scene.readers.polygons import triangulate

HEADER = re.compile(r"(?P<st>ST)?(?P<colours>C)?(?P<normals>N)?(?P<four>4)?(?P<any>n)?OFF\b")
WHOLE = re.compile(r"[+-]?[0-9]+")


def read_off(text: str) -> MeshFile:
    """
    The mesh of an OFF file.

    Parameters
    ----------
    text : str

    Returns
    -------
    MeshFile

    Raises
    ------
    QuadshadeError
      A file that is cut short or malformed, of four or n dimensions, or binary.
    """
    text = re.sub(r"#.*", "", text).lstrip()
    header = HEADER.match(text)
    if header is None:
        raise QuadshadeError(f"it begins with {text[:12].strip()!r}, not with OFF", "give an OFF file")
    if header["four"] or header["any"]:
        raise QuadshadeError("its vertices have not three coordinates", "save it in three dimensions")
    rest = text[header.end() :]
    if rest.split(maxsplit=1)[:1] == ["BINARY"]:
        raise QuadshadeError("it is a binary OFF, which is not read", "save it as text")
    lines = [line.split() for line in text_lines(rest) if line.strip()]
    counts = _whole(lines[0][:2]) if lines else []
    if len(counts) != 2 or min(counts) < 0:
        raise QuadshadeError("it has no counts of vertices and faces", "repair the mesh")
    num_vertices, num_faces = counts
    lines = lines[1:]
    if len(lines) < num_vertices + num_faces:
        raise QuadshadeError(
            f"it is cut short: vertices and faces are {num_vertices + num_faces} lines, not {len(lines)}",
            "repair the mesh",
        )
    rows = lines[:num_vertices]
    vertices, normals, colours, transparent = _read_vertices(rows, header)
    faces, face_colours, notes = _read_faces(lines[num_vertices : num_vertices + num_faces], vertices)
    if transparent and OPAQUE not in notes:
        notes.append(OPAQUE)
    if len(lines) > num_vertices + num_faces:
        notes.append(f"lines behind the last face: {len(lines) - num_vertices - num_faces}")
    return MeshFile(
        [
            Part(
                vertices,
                faces,
                None if normals is None else normals[faces],
                face_colours if colours is None else colours[faces],
            )
        ],
        notes,
    )


def _read_vertices(
    rows: list[list[str]], header: re.Match[str]
) -> tuple[np.ndarray, np.ndarray | None, np.ndarray | None, bool]:
    """
    (m, 3) positions, normals and colours of vertices, None where the header has none of them, and whether a
    colour is transparent.
    """
    after = 6 if header["normals"] else 3
    trailing = 2 if header["st"] else 0
    allowed = {after + trailing} if not header["colours"] else {after + trailing + 3, after + trailing + 4}
    for index, row in enumerate(rows):
        if len(row) not in allowed:
            wanted = " or ".join(str(size) for size in sorted(allowed))
            raise QuadshadeError(
                f"vertex {index} has {len(row)} numbers, not {wanted} as {header[0]} asks for",
                "repair the mesh",
            )
    vertices = _reals([row[:3] for row in rows], 3)
    normals = _reals([row[3:6] for row in rows], 3) if header["normals"] else None
    if not header["colours"]:
        return vertices, normals, None, False
    return vertices, normals, *_levels([row[after : len(row) - trailing] for row in rows])


def _read_faces(
    rows: list[list[str]], vertices: np.ndarray
) -> tuple[np.ndarray, np.ndarray | None, list[str]]:
    """(n, 3) triangles, their (n, 3, 3) colours, if any face has one, and notes."""
    counts = _whole([row[0] for row in rows])
    for index, (count, row) in enumerate(zip(counts, rows, strict=True)):
        if not 0 <= count < len(row):
            raise QuadshadeError(
                f"face {index} is cut short: {count} corners in {len(row) - 1} numbers", "repair it"
            )
        if len(row) - 1 - count not in (0, 3, 4):
            raise QuadshadeError(
                f"face {index} has {len(row) - 1 - count} numbers for its colour",
                "write red green blue, or nothing: a number alone counts in a map that is not in the file",
            )
    corners = np.array(
        _whole([word for c, row in zip(counts, rows, strict=True) for word in row[1 : c + 1]]), np.int64
    )
    check_faces(corners, len(vertices))
    triangles, owner, notes = triangulate(vertices[corners], np.array(counts, dtype=np.int64))
    given = [row[count + 1 :] for count, row in zip(counts, rows, strict=True)]
    coloured = np.array([bool(words) for words in given], dtype=bool)
    colours = None
    if coloured.any():
        levels = np.full((len(rows), 3), np.nan)
        levels[coloured], transparent = _levels([words for words in given if words])
        notes += [OPAQUE] * transparent
        colours = np.repeat(levels[owner][:, None, :], 3, axis=1)
    return corners[triangles], colours, notes


def _levels(words: list[list[str]]) -> tuple[np.ndarray, bool]:
    """
    (m, 3) colours of rows of red, green, blue and perhaps alpha, and whether one is transparent.

    Whole numbers are levels up to 255; if one has a point or none is above 1, all are shares of 1.
    """
    values = _reals([row[:3] for row in words], 3)
    whole = all(WHOLE.fullmatch(word) for row in words for word in row)
    top = 255.0 if whole and values.max(initial=0) > 1 else 1.0
    check_colours(values / top, "it has a colour")
    alpha = _reals([row[3:] for row in words if len(row) > 3], 1)
    return values / top, bool((alpha < top).any())


def _reals(words: list[list[str]], width: int) -> np.ndarray:
    """(m, width) float64 of words."""
    try:
        return np.array(words, dtype=np.float64).reshape(-1, width)
    except ValueError as error:
        raise QuadshadeError(f"it has no number where one should be: {error}", "repair the mesh") from None


def _whole(words: list[str]) -> list[int]:
    """Whole numbers of words."""
    for word in words:
        if not WHOLE.fullmatch(word) or len(word) > 18:
            raise QuadshadeError(f"it has {word[:20]!r} where a whole number should be", "repair the mesh")
    return [int(word) for word in words]
