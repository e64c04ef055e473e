# SPDX-License-Identifier: Apache-2.0
"""A triangle mesh with a normal at every corner of every face."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from quadshade.errors import QuadshadeError

DEFAULT_CREASE = 60.0
"""Degrees between two faces from which their edge is drawn sharp, where a file brings no normals."""


@dataclass(frozen=True)
class Mesh:
    """
    Triangles in the scene's own units, right-handed, counter-clockwise seen from outside.

    Attributes
    ----------
    vertices : (m, 3) float64
    faces : (n, 3) int64
      Indices into ``vertices``.
    normals : (n, 3, 3) float64
      Unit normal at each corner of each face: corners that share a vertex may differ, which makes a crease.
    colours : (n, 3, 3) float64 or None
      Base colour at each corner, 0 .. 1; None: the material's.
    double_sided : (n,) bool or None
      Faces that are drawn from behind too, whatever is culled; None: none of them.
    notes : tuple of str
      What its file holds and a picture does not show, a sentence each.
    """

    vertices: np.ndarray
    faces: np.ndarray
    normals: np.ndarray
    colours: np.ndarray | None = None
    double_sided: np.ndarray | None = None
    notes: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.faces)

    @property
    def corners(self) -> np.ndarray:
        """(n, 3, 3) float64 positions of the faces' corners."""
        return self.vertices[self.faces]

    @property
    def used(self) -> np.ndarray:
        """(m,) bool: the vertices that faces use."""
        used = np.zeros(len(self.vertices), dtype=bool)
        used[self.faces] = True
        return used

    @property
    def bounds(self) -> tuple[np.ndarray, float]:
        """
        A sphere around everything that the faces use.

        Returns
        -------
        centre : (3,) float64
        radius : float
        """
        used = self.vertices[self.used]
        centre = (used.min(axis=0) + used.max(axis=0)) / 2
        return centre, float(np.linalg.norm(used - centre, axis=1).max())


def build_mesh(
    vertices: np.ndarray,
    faces: np.ndarray,
    normals: np.ndarray | None = None,
    crease: float | None = None,
    colours: np.ndarray | None = None,
    double_sided: np.ndarray | None = None,
    notes: tuple[str, ...] = (),
) -> Mesh:
    """
    A checked mesh from arrays.

    Parameters
    ----------
    vertices : (m, 3) float
    faces : (n, 3) int
    normals : (n, 3, 3) float, optional
      Corner normals, of any length; those that are zero or not finite are replaced by computed ones.
    crease : float, optional
      Degrees, 0 .. 180. Given: all normals are computed, with edges sharper than this left sharp. Not given:
      ``normals`` are used, or computed with ``DEFAULT_CREASE``.
    colours : (n, 3, 3) float, optional
      0 .. 1.
    double_sided : (n,) bool, optional
    notes : tuple of str

    Returns
    -------
    Mesh

    Raises
    ------
    QuadshadeError
      Arrays of another shape, no triangles, a vertex that is not finite, a face that names no vertex, a
      colour outside 0 .. 1, or a crease out of range.
    """
    vertices = _rows(vertices, np.float64, "vertices", (None, 3))
    faces = _rows(faces, np.int64, "faces", (None, 3))
    normals = None if normals is None else _rows(normals, np.float64, "normals", (len(faces), 3, 3))
    colours = None if colours is None else _rows(colours, np.float64, "colours", (len(faces), 3, 3))
    if colours is not None and not ((colours >= 0) & (colours <= 1)).all():
        bad = colours[~((colours >= 0) & (colours <= 1))][0]
        raise QuadshadeError(f"a colour of the mesh is {bad:g}", "give 0 to 1")
    if double_sided is not None:
        double_sided = _rows(double_sided, np.bool_, "double_sided", (len(faces),))
    if crease is not None and not 0 <= crease <= 180:
        raise QuadshadeError(
            f"the crease angle is {crease}", "give degrees from 0 (flat faces) to 180 (smooth)"
        )
    if len(faces) == 0:
        raise QuadshadeError("the scene has no triangles", "give a mesh with faces")
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise QuadshadeError("a face names a vertex that does not exist", "repair the mesh")
    bad = np.flatnonzero(~np.isfinite(vertices).all(axis=1))
    if len(bad):
        raise QuadshadeError(f"vertex {bad[0]} is {vertices[bad[0]].tolist()}, not finite", "repair the mesh")
    if np.abs(vertices).max() > 1e100:
        raise QuadshadeError("a vertex is farther than 1e100 from the origin", "scale the mesh down")
    if normals is None or crease is not None:
        computed = corner_normals(vertices, faces, DEFAULT_CREASE if crease is None else crease)
        return Mesh(vertices, faces, computed, colours, double_sided, notes)
    length = np.linalg.norm(normals, axis=-1)
    missing = ~(np.isfinite(length) & (length > 0))
    unit = normals / np.where(missing, 1, length)[..., None]
    if missing.any():
        unit[missing] = corner_normals(vertices, faces, DEFAULT_CREASE)[missing]
    return Mesh(vertices, faces, unit, colours, double_sided, notes)


def _rows(given: np.ndarray, kind: type, what: str, shape: tuple[int | None, ...]) -> np.ndarray:
    """An array of a kind and a shape, of any length where that is None."""
    array: np.ndarray = np.asarray(given, dtype=kind)
    if array.size == 0 and shape[0] is None:
        return array.reshape(0, *shape[1:])
    if array.ndim != len(shape) or any(s not in (None, n) for s, n in zip(shape, array.shape, strict=True)):
        wanted = ", ".join("n" if size is None else str(size) for size in shape)
        raise QuadshadeError(f"the mesh's {what} have the shape {array.shape}", f"give ({wanted})")
    return array


def merge_vertices(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """
    The same faces over vertices of which no two are at the same place.

    Parameters
    ----------
    vertices : (m, 3) float
    faces : (n, 3) int

    Returns
    -------
    vertices : (k, 3) float64
    faces : (n, 3) int64
    """
    vertices = vertices + 0.0  # makes -0.0 and 0.0 one
    order = np.lexsort(vertices.T)
    first = np.ones(len(order), dtype=bool)
    first[1:] = (vertices[order[1:]] != vertices[order[:-1]]).any(axis=1)
    index = np.empty(len(order), dtype=np.int64)
    index[order] = np.cumsum(first) - 1
    return vertices[order[first]], index[faces]


def face_normals(corners: np.ndarray) -> np.ndarray:
    """
    Unit normals of triangles, counter-clockwise seen from the side they point to.

    Parameters
    ----------
    corners : (n, 3, 3) float

    Returns
    -------
    (n, 3) float64
      Zero for a triangle without area.
    """
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    scale = np.maximum(np.abs(first), np.abs(second)).max(axis=1, keepdims=True)
    scale[scale == 0] = 1
    normal = np.cross(first / scale, second / scale)
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    return normal / np.where(length > 0, length, 1)


def corner_normals(vertices: np.ndarray, faces: np.ndarray, crease: float) -> np.ndarray:
    """
    Normals that are smooth across edges up to the crease angle and sharp across the others.

    The faces around a vertex that are joined by smooth edges share the mean of their normals, each weighted
    by its angle at the vertex (Thuermer and Wuethrich, "Computing Vertex Normals from Polygonal Facets").

    Parameters
    ----------
    vertices : (m, 3) float
    faces : (n, 3) int
    crease : float
      Degrees; 0 gives flat faces, 180 is smooth everywhere.

    Returns
    -------
    (n, 3, 3) float64
      Unit length; (0, 0, 1) where nothing with an area touches.
    """
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    corners = vertices[faces]
    flat = face_normals(corners)
    count = faces.size
    one, other = corner_pairs(faces)
    bend = np.einsum("ni,ni->n", flat[one // 3], flat[other // 3])
    # Faces in one plane are smooth at any crease, in spite of the rounding of their normals.
    smooth = bend >= np.cos(np.radians(crease)) - 1e-12
    one, other = one[smooth], other[smooth]
    links = coo_matrix((np.ones(len(one), dtype=bool), (one, other)), shape=(count, count))
    groups, label = connected_components(links, directed=False)
    weighted = (flat[:, None, :] * _corner_angles(corners)[..., None]).reshape(count, 3)
    total = np.stack([np.bincount(label, weighted[:, axis], groups) for axis in range(3)], axis=1)
    length = np.linalg.norm(total, axis=1)
    normals = (total / np.where(length > 1e-12, length, 1)[:, None])[label].reshape(-1, 3, 3)
    cancelled = (length <= 1e-12)[label].reshape(-1, 3)
    normals[cancelled] = np.broadcast_to(flat[:, None, :], normals.shape)[cancelled]
    normals[(normals == 0).all(axis=-1)] = (0.0, 0.0, 1.0)
    return normals


def _corner_angles(corners: np.ndarray) -> np.ndarray:
    """(n, 3) angles of triangles at their corners, in radians."""
    to_next = np.roll(corners, -1, axis=1) - corners
    to_previous = np.roll(corners, 1, axis=1) - corners
    lengths = np.linalg.norm(to_next, axis=-1) * np.linalg.norm(to_previous, axis=-1)
    cosine = np.einsum("nki,nki->nk", to_next, to_previous) / np.where(lengths > 0, lengths, 1)
    return np.where(lengths > 0, np.arccos(np.clip(cosine, -1, 1)), 0)


def corner_pairs(faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of corners (3 * face + corner) of two faces that meet at a vertex of an edge of both."""
    start = np.arange(faces.size)
    end = start - start % 3 + (start + 1) % 3
    ends = np.stack([faces.ravel()[start], faces.ravel()[end]], axis=1)
    low, high = ends.min(axis=1), ends.max(axis=1)
    order = np.lexsort((high, low))
    here, there = order[:-1], order[1:]
    meet = (low[here] == low[there]) & (high[here] == high[there])
    here, there = here[meet], there[meet]
    same_way = ends[here, 0] == ends[there, 0]
    return (
        np.concatenate([start[here], end[here]]),
        np.concatenate(
            [np.where(same_way, start[there], end[there]), np.where(same_way, end[there], start[there])]
        ),
    )
