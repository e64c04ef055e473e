# SPDX-License-Identifier: Apache-2.0
"""
Edges of a mesh by their kind, and where they are seen: the ground truth of an image-space edge map.

Nienhaus and Döllner, *Edge-Enhancement*, 2: silhouette edges join a face that looks at the viewer to one that
does not, border edges have one face, crease edges a dihedral angle beyond a threshold.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from quadshade.scene.camera import Camera
from quadshade.scene.mesh import Mesh, face_normals, merge_vertices
from quadshade.scene.project import Projected
from quadshade.style.gbuffer import GBuffer

SILHOUETTE, BORDER, CREASE = "silhouette", "border", "crease"
KINDS = (SILHOUETTE, BORDER, CREASE)

CREASE_DEGREES = 30.0
"""A dihedral angle from which an edge is a crease."""

STEP = 0.5
"""Pixels between the points at which an edge is looked at."""


@dataclass(frozen=True)
class MeshEdges:
    """
    Classified edges of a mesh.

    Attributes
    ----------
    vertices : (m, 3) float64
      Of which no two are at one place.
    ends : (k, 2) int64
      Indices into them.
    faces : (k, 2) int64
      The faces on both sides; -1 on the second of a border.
    kind : dict of (k,) bool
      By the names of ``KINDS``; an edge may be a silhouette and a crease.
    """

    vertices: np.ndarray
    ends: np.ndarray
    faces: np.ndarray
    kind: dict[str, np.ndarray]


def mesh_edges(mesh: Mesh) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """
    Edges of a mesh with the faces on both sides; faces without area have none.

    Returns
    -------
    vertices : (m, 3) float64
    ends : (k, 2) int64
      Lower index first.
    faces : (k, 2) int64
      -1 where there is no second face. An edge of more than two faces stands once for each pair in a row.
    """
    vertices, faces = merge_vertices(mesh.vertices, mesh.faces)
    whole = np.flatnonzero((face_normals(vertices[faces]) != 0).any(axis=1))
    sides = np.sort(faces[whole][:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    owner = np.repeat(whole, 3)
    order = np.lexsort((owner, sides[:, 1], sides[:, 0]))
    sides, owner = sides[order], owner[order]
    same = (sides[1:] == sides[:-1]).all(axis=1)
    paired = np.append(same, False)
    follows = np.insert(same, 0, False)
    alone = ~paired & ~follows
    rows = np.flatnonzero(paired | alone)
    second = np.where(paired[rows], owner[np.minimum(rows + 1, len(owner) - 1)], -1)
    return vertices, sides[rows], np.stack([owner[rows], second], axis=1)


def classify_edges(mesh: Mesh, camera: Camera, crease: float = CREASE_DEGREES) -> MeshEdges:
    """
    Silhouette, border and crease edges as a camera sees them.

    Parameters
    ----------
    mesh : Mesh
    camera : Camera
    crease : float
      Degrees between the faces' normals from which an edge is a crease.

    Returns
    -------
    MeshEdges
    """
    vertices, ends, faces = mesh_edges(mesh)
    corners = mesh.corners
    normal = face_normals(corners)
    towards = camera.axes[2] if camera.fov is None else camera.eye - corners[:, 0]
    front = np.einsum("ni,ni->n", normal, np.broadcast_to(towards, normal.shape)) > 0
    border = faces[:, 1] < 0
    one, other = faces[:, 0], np.where(border, faces[:, 0], faces[:, 1])
    bend = np.einsum("ni,ni->n", normal[one], normal[other])
    kind = {
        SILHOUETTE: ~border & (front[one] != front[other]),
        BORDER: border,
        CREASE: ~border & (bend < np.cos(np.radians(crease)) - 1e-12),
    }
    return MeshEdges(vertices, ends, faces, kind)


def edge_points(
    edges: MeshEdges, chosen: np.ndarray, camera: Camera, width: int, height: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """
    Points along edges, about ``STEP`` pixels apart, on the screen.

    Parameters
    ----------
    edges : MeshEdges
    chosen : (k,) bool
    camera : Camera
    width, height : int

    Returns
    -------
    place : (p, 2) float64
      Pixels, y down.
    distance : (p,) float64
      Along the view.
    edge : (p,) int64
    """
    screen, distance = project_points(edges.vertices, camera, width, height)
    rows = np.flatnonzero(chosen & (distance[edges.ends] > 0).all(axis=1))
    ends = edges.ends[rows]
    length = np.linalg.norm(screen[ends[:, 1]] - screen[ends[:, 0]], axis=1)
    count = np.minimum(np.ceil(length / STEP).astype(np.int64), 4 * (width + height)) + 1
    edge = np.repeat(np.arange(len(rows)), count)
    first = np.cumsum(count) - count
    along = (np.arange(len(edge)) - first[edge]) / np.maximum(count[edge] - 1, 1)
    start, end = ends[edge, 0], ends[edge, 1]
    place = screen[start] + along[:, None] * (screen[end] - screen[start])
    # The screen's parameter is linear in one over the distance.
    if camera.fov is None:
        far = distance[start] + along * (distance[end] - distance[start])
    else:
        far = 1 / (1 / distance[start] + along * (1 / distance[end] - 1 / distance[start]))
    return place, far, rows[edge]


def project_points(
    points: np.ndarray, camera: Camera, width: int, height: int
) -> tuple[np.ndarray, np.ndarray]:
    """(m, 2) float64 places on the screen in pixels, y down, and (m,) distances along the view."""
    view = (points - camera.eye) @ camera.axes.T
    distance = -view[:, 2]
    half = min(width, height) / 2
    if camera.fov is None:
        scale = np.full(len(points), half / camera.ortho)
    else:
        with np.errstate(divide="ignore", invalid="ignore"):
            scale = half / np.tan(np.radians(camera.fov / 2)) / distance
    middle = np.array([width, height]) / 2
    return middle + view[:, :2] * np.stack([scale, -scale], axis=1), distance


def visible_edges(
    edges: MeshEdges, chosen: np.ndarray, camera: Camera, gbuffer: GBuffer, projected: Projected
) -> np.ndarray:
    """
    The pixels where edges are seen.

    A point of an edge is seen where one of the nine pixels around it shows a face of the edge or, as the
    faces of a silhouette or border may be thinner than a pixel, shows something farther away than such an
    edge's point.

    Parameters
    ----------
    edges : MeshEdges
    chosen : (k,) bool
      Which edges.
    camera : Camera
    gbuffer : GBuffer
      Of the same view.
    projected : Projected
      What the G-buffer was drawn from.

    Returns
    -------
    (h, w) bool
    """
    height, width = gbuffer.depth.shape
    place, distance, edge = edge_points(edges, chosen, camera, width, height)
    inside = ((place >= 0) & (place < [width, height])).all(axis=1)
    place, distance, edge = place[inside], distance[inside], edge[inside]
    # Index -1, where nothing was drawn, reads the entry behind the last triangle.
    shown = np.pad(np.append(projected.source, -2)[gbuffer.triangle], 1, constant_values=-3)
    behind = np.pad(gbuffer.distance, 1, constant_values=-np.inf)
    outline = (edges.kind[SILHOUETTE] | edges.kind[BORDER])[edge]
    column, row = np.floor(place).astype(np.int64).T
    seen = np.zeros(len(edge), dtype=bool)
    for across in range(3):
        for down in range(3):
            at = row + down, column + across
            seen |= (shown[at][:, None] == edges.faces[edge]).any(axis=1)
            seen |= outline & (behind[at] > distance)
    out = np.zeros((height, width), dtype=bool)
    out[row[seen], column[seen]] = True
    return out
