# SPDX-License-Identifier: Apache-2.0
"""
Fewer triangles for a mesh: positions by quadric error, normals and colours from the mesh as it was.

The triangles are those of fast-simplification (Garland and Heckbert, "Surface Simplification Using Quadric
Error Metrics"). It knows positions alone. Open borders and seams between colours keep their vertices, as the
mesh is cut along seams; every corner of a new triangle asks the old surface for its normal and colour, on its
own side of a crease or seam.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from quadshade.errors import QuadshadeError
from quadshade.scene.mesh import Mesh, corner_pairs, face_normals, merge_vertices
from quadshade.scene.surface import Surface

LEAST = 4
"""Triangles of the simplest solid."""
AGGRESSIVENESS = (5.0, 7.0, 9.0)
"""How fast the decimator's threshold grows; the first that reaches the count."""
PULL = 0.03
"""Of the way from a corner to its triangle's middle: where its side of a seam is looked for."""
TURN = 0.1
"""Of a triangle's longest edge: what a surface that faces another way counts as being further away."""
SMOOTH_COSINE = float(np.cos(np.radians(25.0)))
"""Between the normals of two triangles' corners at a vertex, below which their edge is a crease."""
SMOOTH_COLOUR = 0.08
"""Between their colours, from which it is a seam."""


def check_count(count: int, triangles: int) -> None:
    """
    Refuse a number of triangles that a mesh cannot be decimated to.

    Raises
    ------
    QuadshadeError
      Fewer than 4, or more than it has.
    """
    if count < LEAST:
        raise QuadshadeError(f"--lod {count}", f"give at least {LEAST} triangles")
    if count > triangles:
        raise QuadshadeError(
            f"--lod {count}: the mesh has {triangles} triangles", "give fewer, or leave --lod out"
        )


def decimate(mesh: Mesh, count: int) -> Mesh:
    """
    The same surface in at most so many triangles.

    Parameters
    ----------
    mesh : Mesh
    count : int
      From 4 to as many as it has.

    Returns
    -------
    Mesh
      With normals and colours of the given one; where no more of its edges collapse it has more triangles,
      and a note says so.

    Raises
    ------
    QuadshadeError
      A count out of range, a mesh of which no edge collapses, or fast-simplification is not installed.
    """
    check_count(count, len(mesh))
    if count == len(mesh):
        return mesh
    vertices, faces = _simplified(mesh, count)
    corners = vertices[faces]
    surface = Surface(mesh)
    flat = face_normals(corners)
    middle = corners.mean(axis=1)
    size = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2).max(axis=1)
    pulled = corners + PULL * (middle[:, None] - corners)
    found = surface.nearest_faces(
        pulled.reshape(-1, 3), np.repeat(flat, 3, axis=0), np.repeat(TURN * size, 3)
    )
    _, weights = surface.nearest_points(corners.reshape(-1, 3), found)
    normals = _unit(np.einsum("mk,mki->mi", weights, mesh.normals[found]), flat)
    normals = _unit(_joined(faces, normals, -2.0 if _is_smooth(mesh) else SMOOTH_COSINE), flat)
    colours = None
    if mesh.colours is not None:
        colours = np.einsum("mk,mki->mi", weights, mesh.colours[found])
        colours = np.clip(_joined(faces, colours, None), 0, 1).reshape(-1, 3, 3)
    double_sided = None
    if mesh.double_sided is not None:
        double_sided = mesh.double_sided[surface.nearest_faces(middle, flat, TURN * size)]
    notes = mesh.notes
    if len(faces) > count:
        notes += (f"{len(faces)} triangles instead of {count}: no more edges collapse",)
    return Mesh(vertices, faces, normals.reshape(-1, 3, 3), colours, double_sided, notes)


def _simplified(mesh: Mesh, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and faces of the decimated mesh."""
    try:
        from fast_simplification import simplify
    except ImportError:
        raise QuadshadeError(
            "fast-simplification is not installed, which --lod needs for this mesh",
            "pip install quadshade[lod], or --lod with a generated scene",
        ) from None
    vertices, faces = merge_vertices(mesh.vertices, mesh.faces)
    solid = _is_triangle(vertices, faces)
    faces = faces[solid]
    if len(faces) <= count:
        # What is no triangle is not seen.
        return vertices, faces
    if mesh.colours is not None:
        vertices, faces = _cut(vertices, faces, mesh.colours[solid])
    # The decimator's thresholds are absolute.
    centre, radius = replace(mesh, vertices=vertices, faces=faces).bounds
    scaled = np.ascontiguousarray((vertices - centre) / radius)
    best = None
    for aggressiveness in AGGRESSIVENESS:
        points, kept = simplify(
            scaled, faces.astype(np.int32), target_count=count, agg=aggressiveness, preserve_border=True
        )
        kept = kept.astype(np.int64)
        kept = kept[_is_triangle(points, kept)]
        if len(kept) and (best is None or len(kept) < len(best[1])):
            best = points * radius + centre, kept
        if best is not None and len(best[1]) <= count:
            break
    if best is None or len(best[1]) >= len(faces):
        raise QuadshadeError(
            f"--lod {count}: none of the mesh's {len(mesh)} triangles can be left out", "leave --lod out"
        )
    # Both sides of a seam have its vertices.
    return merge_vertices(*best)


def _cut(vertices: np.ndarray, faces: np.ndarray, colours: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The same faces, with vertices of their own on either side of a seam between colours."""
    one, other = corner_pairs(faces)
    place = faces.ravel()
    same = np.abs(colours.reshape(-1, 3)[one] - colours.reshape(-1, 3)[other]).max(axis=1) <= SMOOTH_COLOUR
    label = _groups(one[same], other[same], faces.size)
    made = np.empty((label.max() + 1, 3))
    made[label] = vertices[place]
    return made, label.reshape(-1, 3)


def _unit(normals: np.ndarray, flat: np.ndarray) -> np.ndarray:
    """(3n, 3) unit normals of corners; where they cancel each other those of the (n, 3) triangles."""
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.where(length > 1e-9, normals / np.maximum(length, 1e-9), np.repeat(flat, 3, axis=0))


def _is_smooth(mesh: Mesh) -> bool:
    """Whether a mesh has no crease."""
    one, other = corner_pairs(merge_vertices(mesh.vertices, mesh.faces)[1])
    normals = mesh.normals.reshape(-1, 3)
    return bool((np.einsum("pi,pi->p", normals[one], normals[other]) >= SMOOTH_COSINE).all())


def _is_triangle(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """(n,) bool: faces with three corners and an area."""
    return (face_normals(vertices[faces]) != 0).any(axis=1)


def _joined(faces: np.ndarray, values: np.ndarray, least_cosine: float | None) -> np.ndarray:
    """
    (3n, 3) the mean over the corners of neighbouring triangles at a vertex, where they are about the same.

    ``least_cosine`` between unit vectors; None: colours.
    """
    one, other = corner_pairs(faces)
    if least_cosine is None:
        same = np.abs(values[one] - values[other]).max(axis=1) <= SMOOTH_COLOUR
    else:
        same = np.einsum("pi,pi->p", values[one], values[other]) >= least_cosine
    label = _groups(one[same], other[same], faces.size)
    total = np.stack([np.bincount(label, values[:, axis]) for axis in range(3)], axis=1)
    return (total / np.bincount(label)[:, None])[label]


def _groups(one: np.ndarray, other: np.ndarray, count: int) -> np.ndarray:
    """(count,) int: the group of each corner, of those that pairs join."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    links = coo_matrix((np.ones(len(one), dtype=bool), (one, other)), shape=(count, count))
    return np.asarray(connected_components(links, directed=False)[1])
