# SPDX-License-Identifier: Apache-2.0
"""PLY files: polygons and triangle strips with normals, colours of vertices or faces, and a texture."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from quadshade.errors import QuadshadeError
from quadshade.scene.readers.part import OPAQUE, MeshFile, Part, check_colours, check_faces, plural
from quadshade.scene.readers.ply_data import Element, PlyFile, read_ply_data
from quadshade.scene.readers.polygons import triangulate
from quadshade.scene.readers.texture import Texture, read_texels

ALPHA_NAMES = ("alpha", "a", "diffuse_alpha")
COLOUR_NAMES = (("red", "green", "blue"), ("r", "g", "b"), ("diffuse_red", "diffuse_green", "diffuse_blue"))
PLACE_NAMES = (("u", "v"), ("s", "t"), ("texture_u", "texture_v"))
POLYGONS = ("vertex_indices", "vertex_index")
DRAWN = frozenset({"vertex", "face", "tristrips"})


def read_ply(data: bytes, fetch: Callable[[str], bytes]) -> MeshFile:
    """
    The mesh of a PLY file.

    Parameters
    ----------
    data : bytes
    fetch : callable
      The content of a file beside this one, by its name.

    Returns
    -------
    MeshFile

    Raises
    ------
    QuadshadeError
      A file that is cut short or malformed, or a texture that is missing.
    """
    ply = read_ply_data(data)
    notes = ply.notes + [
        f"{plural(element.count, 'row')} of the element {name!r} not drawn"
        for name, element in ply.elements.items()
        if name not in DRAWN and element.count
    ]
    if any(_is_transparent(ply.elements[name]) for name in DRAWN & set(ply.elements)):
        notes.append(OPAQUE)
    vertex = ply.elements.get("vertex")
    if vertex is None:
        raise QuadshadeError("it has no vertices", "repair the mesh")
    positions = _columns(vertex, ("x", "y", "z"))
    if positions is None:
        lacking = next(name for name in ("x", "y", "z") if name not in vertex.numbers)
        raise QuadshadeError(f"its vertices have no {lacking!r}", "repair the mesh")
    positions = positions.astype(np.float64)
    normals = _columns(vertex, ("nx", "ny", "nz"))
    colours = _colours(vertex)
    texture = _texture(ply, fetch)
    places = next((found for names in PLACE_NAMES if (found := _columns(vertex, names)) is not None), None)
    parts = []
    for faces, own_colours, own_places in (_polygons(ply, positions, notes), _strips(ply, positions)):
        if not len(faces):
            continue
        if own_places is None and places is not None:
            own_places = places.astype(np.float64)[faces]
        painted = own_colours if colours is None else colours[faces]
        if texture is not None and own_places is not None:
            down = 1 - own_places[..., 1]
            texels = texture.at_corners(np.stack([own_places[..., 0], down], axis=-1))[..., :3]
            painted = texels if painted is None else texels * painted
        elif texture is not None:
            raise QuadshadeError(
                "it has a texture and no texture coordinates", "remove its comment TextureFile"
            )
        own_normals = None if normals is None else normals.astype(np.float64)[faces]
        parts.append(Part(positions, faces, own_normals, painted))
    return MeshFile(parts, notes)


def _columns(element: Element, names: Sequence[str]) -> np.ndarray | None:
    """(count, columns) of an element's properties; None where it lacks one."""
    if not all(name in element.numbers for name in names):
        return None
    return np.stack([element.numbers[name] for name in names], axis=1)


def _colours(element: Element) -> np.ndarray | None:
    """(count, 3) float64 colours of an element's rows, 0 .. 1, or None."""
    for names in COLOUR_NAMES:
        if not all(name in element.numbers for name in names):
            continue
        channels = []
        for name in names:
            channel = element.numbers[name]
            # Unsigned numbers share out their whole range, signed ones hold eight bits.
            top = 1.0 if channel.dtype.kind == "f" else 255.0
            if channel.dtype.kind == "u":
                top = float(np.iinfo(channel.dtype).max)
            channels.append(channel / np.float64(top))
        colours = np.stack(channels, axis=1)
        if not np.isfinite(colours).all():
            raise QuadshadeError(f"a {element.name} has a colour that is not finite", "repair the mesh")
        check_colours(colours, f"a {element.name} has a colour")
        return colours
    return None


def _is_transparent(element: Element) -> bool:
    """Whether an element's rows have colours of which one is not opaque."""
    if _colours(element) is None:
        return False
    for name in ALPHA_NAMES:
        alpha = element.numbers.get(name)
        if alpha is not None and alpha.size:
            top = 1.0 if alpha.dtype.kind == "f" else 255.0
            top = float(np.iinfo(alpha.dtype).max) if alpha.dtype.kind == "u" else top
            return bool(alpha.min() < top)
    return False


def _texture(ply: PlyFile, fetch: Callable[[str], bytes]) -> Texture | None:
    """The texture that a comment names, as MeshLab writes it."""
    names = [text.split(maxsplit=1)[1] for text in ply.comments if text.startswith("TextureFile ")]
    if not names:
        return None
    if len(names) > 1:
        raise QuadshadeError(f"it has {len(names)} textures; one is read", "join them")
    return Texture(read_texels(fetch(names[0]), names[0]))


def _polygons(
    ply: PlyFile, positions: np.ndarray, notes: list[str]
) -> tuple[np.ndarray, np.ndarray | None, np.ndarray | None]:
    """(n, 3) triangles of the faces, with their (n, 3, 3) colours and (n, 3, 2) texture coordinates."""
    face = ply.elements.get("face")
    empty = np.empty((0, 3), np.int64)
    if face is None or not face.count:
        return empty, None, None
    name = next((name for name in POLYGONS if name in face.lists), None)
    if name is None:
        raise QuadshadeError("its faces have no list vertex_indices", "repair the mesh")
    counts, listed = face.lists[name]
    if listed.dtype.kind == "f":
        raise QuadshadeError(f"its {name} are {listed.dtype}, not whole numbers", "repair the mesh")
    corners = listed.astype(np.int64)
    check_faces(corners, len(positions))
    index, owner, more = triangulate(positions[corners], counts)
    notes += more
    colours = _colours(face)
    if colours is not None:
        colours = np.repeat(colours[owner][:, None, :], 3, axis=1)
    places = None
    if "texcoord" in face.lists:
        lengths, values = face.lists["texcoord"]
        if not np.array_equal(lengths, 2 * counts):
            raise QuadshadeError("a face has not two texcoord numbers a corner", "repair the mesh")
        places = values.astype(np.float64).reshape(-1, 2)[index]
    return corners[index], colours, places


def _strips(ply: PlyFile, positions: np.ndarray) -> tuple[np.ndarray, None, None]:
    """(n, 3) triangles of the element ``tristrips``; -1 begins another strip, every other one is turned."""
    element = ply.elements.get("tristrips")
    if element is None or not element.count:
        return np.empty((0, 3), np.int64), None, None
    name = next((name for name in POLYGONS if name in element.lists), None)
    if name is None:
        raise QuadshadeError("its tristrips have no list vertex_indices", "repair the mesh")
    counts, listed = element.lists[name]
    strips = np.split(listed.astype(np.int64), np.cumsum(counts)[:-1])
    pieces = [piece for strip in strips for piece in np.split(strip, np.flatnonzero(strip == -1))]
    triangles = [strip_faces(piece[piece != -1]) for piece in pieces]
    faces = np.concatenate(triangles)
    check_faces(faces, len(positions))
    return faces, None, None


def strip_faces(corners: np.ndarray) -> np.ndarray:
    """(n, 3) triangles of a strip of (n + 2,) corners (glTF 2.0, 3.7.2.1), without those of no area."""
    step = np.arange(max(len(corners) - 2, 0))
    odd = step % 2
    faces = np.stack([corners[step], corners[step + 1 + odd], corners[step + 2 - odd]], axis=1)
    alike = (faces[:, 0] == faces[:, 1]) | (faces[:, 1] == faces[:, 2]) | (faces[:, 2] == faces[:, 0])
    return faces[~alike]
