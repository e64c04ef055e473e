# SPDX-License-Identifier: Apache-2.0
"""Clipping of triangles against planes (Sutherland and Hodgman, "Reentrant Polygon Clipping"), vectorised."""

from __future__ import annotations

import numpy as np

MISSED = 1e-9
"""Relative error of a cut's coordinate from which it is put on the plane."""


def clip_triangles(corners: np.ndarray, planes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """
    What of triangles lies on the inner side of every plane, as triangles.

    A cut edge is cut at the same point, to the last bit, for both triangles that share it: the point is
    computed from the edge's inner end, whichever way round it is traversed.

    Parameters
    ----------
    corners : (n, 3, attributes) float
      Everything that is linear along the triangle, first the k coordinates that the planes cut.
    planes : (p, k + 1) float
      Inside is where planes[:, :k] @ coordinates + planes[:, k] >= 0.

    Returns
    -------
    corners : (m, 3, attributes) float64
      Same orientation; triangles that lie inside are returned unchanged.
    source : (m,) int64
      Index of the triangle that each was cut from, ascending.
    """
    distance = np.stack([plane_distance(corners, plane) for plane in planes], axis=-1)
    inside = (distance >= 0).all(axis=(1, 2))
    beyond_one = np.any(np.all(distance < 0, axis=1), axis=1)
    crossing = np.flatnonzero(~inside & ~beyond_one)
    whole = np.flatnonzero(inside)
    if len(crossing) == 0:
        return corners[whole].astype(np.float64), whole
    polygons, counts = _cut_all(corners[crossing].astype(np.float64), planes)
    fans, owner = _triangulate(polygons, counts)
    source = np.concatenate([whole, crossing[owner]])
    order = np.argsort(source, kind="stable")
    return np.concatenate([corners[whole], fans])[order], source[order]


def plane_distance(corners: np.ndarray, plane: np.ndarray) -> np.ndarray:
    """
    How far inside a plane corners are, added up in one order always (a matrix product's rounding may vary).

    Parameters
    ----------
    corners : (..., attributes) float
    plane : (k + 1,) float

    Returns
    -------
    (...) float64
    """
    total = np.full(corners.shape[:-1], plane[-1])
    for coordinate, factor in enumerate(plane[:-1]):
        total += corners[..., coordinate] * factor
    return total


def _cut_all(polygons: np.ndarray, planes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(n, most corners, attributes) polygons cut by every plane in turn; their (n,) corner counts."""
    counts = np.full(len(polygons), 3)
    for plane in planes:
        polygons, counts = _cut(polygons, counts, plane)
    return polygons, counts


def _cut(polygons: np.ndarray, counts: np.ndarray, plane: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Polygons cut by one plane."""
    rows, most = np.arange(len(polygons))[:, None], polygons.shape[1]
    index = np.arange(most)[None, :]
    used = index < counts[:, None]
    following = polygons[rows, np.where(index + 1 < counts[:, None], index + 1, 0)]
    here, there = plane_distance(polygons, plane), plane_distance(following, plane)
    keep = used & (here >= 0)
    cross = used & ((here >= 0) != (there >= 0))
    leaving = (here >= 0)[..., None]
    inner, outer = np.where(leaving, polygons, following), np.where(leaving, following, polygons)
    span = np.where(cross, np.abs(here) + np.abs(there), 1)
    share = np.where(cross, np.where(here >= 0, here, there), 0) / span
    cuts = _on_plane(inner + (outer - inner) * share[..., None], plane)
    # Each corner gives up to two: itself where it is inside, then the point where its edge crosses.
    emitted = np.stack([polygons, cuts], axis=2).reshape(len(polygons), 2 * most, -1)
    wanted = np.stack([keep, cross], axis=2).reshape(len(polygons), 2 * most)
    counts = wanted.sum(axis=1)
    order = np.argsort(~wanted, axis=1, kind="stable")[:, : max(int(counts.max(initial=0)), 1)]
    return emitted[rows, order], counts


def _on_plane(points: np.ndarray, plane: np.ndarray) -> np.ndarray:
    """Points that lie in a plane up to rounding, put there where the rounding of far-off numbers is large."""
    axis = int(np.flatnonzero(plane[:-1])[0])
    rest = plane.copy()
    rest[axis] = 0
    wanted = -plane_distance(points, rest) / plane[axis]
    given = points[..., axis]
    missed = np.abs(given - wanted) > MISSED * (np.abs(given) + np.abs(wanted))
    points[..., axis] = np.where(missed, wanted, given)
    return points


def _triangulate(polygons: np.ndarray, counts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Fans of triangles, and the polygon that each is from."""
    fan = np.arange(1, polygons.shape[1] - 1)
    owner, second = np.nonzero(fan[None, :] + 1 < counts[:, None])
    second = second + 1
    return np.stack([polygons[owner, 0], polygons[owner, second], polygons[owner, second + 1]], axis=1), owner
