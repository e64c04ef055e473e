# SPDX-License-Identifier: Apache-2.0
"""A mesh's surface, asked for its nearest point: what a coarser mesh takes its normals and colours from."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from quadshade.scene.mesh import Mesh, face_normals

NEIGHBOURS = 8
"""Places of the surface whose triangles are candidates for the nearest point."""

MOST_STEPS = 32
"""Rows of places over a triangle, at most."""


class Surface:
    """
    The triangles of a mesh.

    Parameters
    ----------
    mesh : Mesh
    """

    def __init__(self, mesh: Mesh) -> None:
        self.mesh, self.corners = mesh, mesh.corners
        self.flat = face_normals(self.corners)

    @cached_property
    def _places(self) -> tuple[np.ndarray, np.ndarray]:
        """(p, 3) places all over the surface, about as far apart as a typical edge, and (p,) their faces."""
        ends = np.roll(self.corners, -1, axis=1) - self.corners
        longest = np.linalg.norm(ends, axis=2).max(axis=1)
        typical = max(float(np.median(longest)), 1e-12)
        steps = np.clip(np.ceil(longest / typical).astype(np.int64), 1, MOST_STEPS)
        places, faces = [], []
        for count in np.unique(steps):
            rows = np.flatnonzero(steps == count)
            first, second = np.meshgrid(np.arange(count), np.arange(count), indexing="ij")
            inside = first + second < count
            u, v = (first[inside] + 1 / 3) / count, (second[inside] + 1 / 3) / count
            weights = np.stack([1 - u - v, u, v], axis=1)
            places.append(np.einsum("pk,nki->npi", weights, self.corners[rows]).reshape(-1, 3))
            faces.append(np.repeat(rows, len(weights)))
        return np.concatenate(places), np.concatenate(faces)

    def nearest_faces(self, points: np.ndarray, facing: np.ndarray, scale: np.ndarray) -> np.ndarray:
        """
        The triangle that is nearest to each point, of those that face about the same way.

        Parameters
        ----------
        points : (m, 3) float64
        facing : (m, 3) float64
          Unit normals.
        scale : (m,) float64
          Length that turning away by 90 degrees counts as: this much further away is as good.

        Returns
        -------
        (m,) int64
        """
        from scipy.spatial import cKDTree

        places, faces = self._places
        count = min(NEIGHBOURS, len(places))
        _, index = cKDTree(places).query(points, k=count)
        candidates = faces[index.reshape(len(points), count)]
        away = np.linalg.norm(self.nearest_points(np.repeat(points, count, 0), candidates.ravel())[0], axis=1)
        turned = 1 - np.einsum("mki,mi->mk", self.flat[candidates], facing)
        cost = away.reshape(len(points), count) + turned * scale[:, None]
        return candidates[np.arange(len(points)), cost.argmin(axis=1)]

    def nearest_points(self, points: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """
        The nearest point of a given triangle to each point.

        Parameters
        ----------
        points : (m, 3) float64
        faces : (m,) int64

        Returns
        -------
        (m, 3) float64
          Way from it to the point.
        (m, 3) float64
          Its barycentric weights.
        """
        from trimesh.triangles import closest_point

        corners = self.corners[faces]
        nearest = np.asarray(closest_point(corners, points))
        first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        way = nearest - corners[:, 0]
        a, b, c = (
            np.einsum("mi,mi->m", x, y) for x, y in ((first, first), (first, second), (second, second))
        )
        d, e = (np.einsum("mi,mi->m", way, edge) for edge in (first, second))
        area = a * c - b * b
        solid = np.where(area > 0, area, 1)
        u, v = np.where(area > 0, (c * d - b * e) / solid, 0), np.where(area > 0, (a * e - b * d) / solid, 0)
        return points - nearest, np.clip(np.stack([1 - u - v, u, v], axis=1), 0, 1)
