# SPDX-License-Identifier: Apache-2.0
"""STL files, binary and text, with the colours that VisCAM and Magics keep in a facet's attribute."""

from __future__ import annotations

import numpy as np

from quadshade.errors import QuadshadeError
from quadshade.scene.readers.part import MeshFile, Part, plural, text_lines
from quadshade.scene.readers.polygons import triangulate

HEADER = 84
FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def read_stl(data: bytes) -> MeshFile:
    """
    The mesh of an STL file; facets' normals follow from the order of their corners.

    Parameters
    ----------
    data : bytes

    Returns
    -------
    MeshFile

    Raises
    ------
    QuadshadeError
      A file that is cut short or malformed.
    """
    count = int.from_bytes(data[80:HEADER], "little") if len(data) >= HEADER else -1
    wanted = HEADER + FACET.itemsize * count
    is_text = data.lstrip()[:5].lower() == b"solid"
    # Binary files may begin with "solid" too: the size decides; no text has one that fits by chance.
    if count >= 0 and (len(data) == wanted or not is_text or b"\0" in data[:HEADER]):
        if len(data) < wanted:
            raise QuadshadeError(f"it is cut short: {plural(count, 'facet')} are {wanted} bytes", "repair it")
        notes = [f"{len(data) - wanted} bytes behind the last facet"] if len(data) > wanted else []
        facets = np.frombuffer(data, FACET, count, HEADER)
        return MeshFile(
            [_part(facets["corners"].reshape(-1, 3), _colours(data[:80], facets["attribute"]))], notes
        )
    if not is_text:
        raise QuadshadeError(
            "it is cut short, or no STL: neither binary nor text as it should be", "repair it"
        )
    return _read_text(data.decode("utf-8", errors="replace"))


def _part(corners: np.ndarray, colours: np.ndarray | None = None) -> Part:
    """Triangles of which every three (3 n, 3) corners are one."""
    count = len(corners) // 3
    faces = np.arange(3 * count, dtype=np.int64).reshape(-1, 3)
    return Part(corners.astype(np.float64), faces, None, colours)


def _colours(header: bytes, attribute: np.ndarray) -> np.ndarray | None:
    """(n, 3, 3) colours of facets: five bits a channel, the 16th tells whether they hold."""
    levels = np.stack([attribute >> shift & 31 for shift in (0, 5, 10)], axis=1) / 31.0
    flag = (attribute >> 15).astype(bool)
    place = header.find(b"COLOR=")
    if place >= 0 and len(header) >= place + 10:
        # Magics: red is lowest, a set flag means the colour of the whole, and the header has that.
        whole = np.frombuffer(header, np.uint8, 3, place + 6) / 255.0
        colours = np.where(flag[:, None], whole, levels)
    elif flag.any():
        # VisCAM and SolidView: blue is lowest, the flag means that there is a colour.
        colours = np.where(flag[:, None], levels[:, ::-1], np.nan)
    else:
        return None
    return np.repeat(colours[:, None, :], 3, axis=1)


def _read_text(text: str) -> MeshFile:
    """The mesh of a text file; several solids are joined."""
    corners: list[list[float]] = []
    counts: list[int] = []
    inside = loop = False
    open_solid = False
    for number, line in enumerate(text_lines(text), 1):
        words = line.lower().split()
        if not words:
            continue
        match words[0]:
            case "solid":
                open_solid = True
                expected = not inside
            case "facet":
                expected, inside = not inside, True
                counts.append(0)
            case "outer":
                expected, loop = inside and not loop, True
            case "vertex":
                expected = loop and len(words) == 4
                if expected:
                    corners.append(_numbers(words[1:], number))
                    counts[-1] += 1
            case "endloop":
                expected, loop = loop and counts[-1] >= 3, False
            case "endfacet":
                expected, inside = inside and not loop and counts[-1] >= 3, False
            case "endsolid" | "end":
                expected, open_solid = not inside, False
            case _:
                expected = False
        if not expected:
            raise QuadshadeError(
                f"line {number} is {line.strip()[:40]!r}, out of its place", "repair the mesh"
            )
    if inside:
        raise QuadshadeError(f"it is cut short: facet {len(counts)} is not complete", "repair the mesh")
    points = np.array(corners, dtype=np.float64).reshape(-1, 3)
    index, _, notes = triangulate(points, np.array(counts, dtype=np.int64))
    if open_solid:
        notes.append("its last solid has no endsolid: it may be cut short")
    return MeshFile([_part(points[index].reshape(-1, 3))], notes)


def _numbers(words: list[str], number: int) -> list[float]:
    """Numbers of a line."""
    try:
        return [float(word) for word in words]
    except ValueError:
        raise QuadshadeError(
            f"line {number} has {' '.join(words)[:40]!r}, not numbers", "repair it"
        ) from None
