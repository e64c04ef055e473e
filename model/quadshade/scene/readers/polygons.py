# SPDX-License-Identifier: Apache-2.0
"""Polygons of any number of corners, concave and not quite flat ones too, as triangles."""

from __future__ import annotations

import numpy as np

from quadshade.scene.readers.part import check_finite, plural


def triangulate(points: np.ndarray, counts: np.ndarray) -> tuple[np.ndarray, np.ndarray, list[str]]:
    """
    Triangles that cover polygons.

    A polygon is looked at along the axis that its normal is nearest to (Newell's normal: Sutherland, Sproull
    and Schumacker, "A Characterization of Ten Hidden-Surface Algorithms"). What is convex there becomes a
    fan, all else goes through the ear clipper of mapbox_earcut.

    Parameters
    ----------
    points : (k, 3) float64
      The corners of all polygons, one polygon after the other.
    counts : (p,) int64
      Corners of each; those of fewer than three give no triangle.

    Returns
    -------
    corners : (n, 3) int64
      Indices into ``points``, in the order of the polygons and turning as they do.
    owner : (n,) int64
      The polygon of each triangle.
    notes : list of str
      Says what cannot be drawn as it stands.

    Raises
    ------
    QuadshadeError
      A corner that is not finite.
    """
    check_finite(points)
    starts = np.cumsum(counts) - counts
    corners, owners, crossed = [np.empty((0, 3), np.int64)], [np.empty(0, np.int64)], 0
    for count in np.unique(counts[counts >= 3]).tolist():
        chosen = np.flatnonzero(counts == count)
        index = starts[chosen][:, None] + np.arange(count)
        if count == 3:
            corners.append(index)
            owners.append(chosen)
            continue
        flat, area = _flattened(points[index])
        fan = _fan(count)
        convex = _is_convex(flat, fan)
        corners.append(index[convex][:, fan].reshape(-1, 3))
        owners.append(np.repeat(chosen[convex], len(fan)))
        for polygon in np.flatnonzero(~convex).tolist():
            ears, whole = _clip_ears(flat[polygon], float(area[polygon]))
            crossed += not whole
            corners.append(index[polygon][ears])
            owners.append(np.full(len(ears), chosen[polygon]))
    owner = np.concatenate(owners).astype(np.int64)
    order = np.argsort(owner, kind="stable")
    notes = []
    few = int(np.count_nonzero(counts < 3))
    if few:
        notes.append(f"{plural(few, 'face')} of fewer than three corners: nothing to draw")
    if crossed:
        notes.append(f"{plural(crossed, 'polygon')} with sides that cross: what they cover is not defined")
    return np.concatenate(corners)[order], owner[order], notes


def _fan(count: int) -> np.ndarray:
    """(count - 2, 3) corners of a fan around corner 0."""
    if count == 4:
        return np.array([[0, 1, 2], [2, 3, 0]])
    second = np.arange(1, count - 1)
    return np.stack([np.zeros_like(second), second, second + 1], axis=1)


def _flattened(polygons: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """
    (p, c, 3) polygons as (p, c, 2), without the axis nearest to the normal, and their (p,) doubled areas.

    Scaled to a size of 1, moved to the origin and counter-clockwise as long as they have an area.
    """
    flat = polygons - polygons[:, :1]
    scale = np.abs(flat).max(axis=(1, 2))
    flat = flat / np.where(scale > 0, scale, 1)[:, None, None]
    normal = np.cross(flat, np.roll(flat, -1, axis=1)).sum(axis=1)
    # Two loops that turn against each other have no normal: then the axis along which they are thin.
    thin = 1e-12 * (1 - np.ptp(flat, axis=1))
    axis = (np.abs(normal) + thin).argmax(axis=1)
    rows = np.arange(len(flat))
    positive = normal[rows, axis] >= 0
    first = np.where(positive, (axis + 1) % 3, (axis + 2) % 3)
    second = np.where(positive, (axis + 2) % 3, (axis + 1) % 3)
    columns = np.stack([first, second], axis=1)[:, None, :]
    return np.take_along_axis(flat, columns, axis=2), np.abs(normal[rows, axis])


def _cross(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Cross products of (..., 2) vectors."""
    return first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0]


def _areas(flat: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Doubled areas of triangles of (..., c, 2) corners, positive counter-clockwise."""
    one, two, three = (flat[..., triangles[:, corner], :] for corner in range(3))
    return _cross(two - one, three - one)


def _is_convex(flat: np.ndarray, fan: np.ndarray) -> np.ndarray:
    """(p,) bool: no corner turns the other way, and the corners go round once."""
    sides = np.roll(flat, -1, axis=1) - flat
    turns = _cross(sides, np.roll(sides, -1, axis=1))
    return np.asarray((turns >= 0).all(axis=1) & (_areas(flat, fan) >= 0).all(axis=1))


def _clip_ears(flat: np.ndarray, area: float) -> tuple[np.ndarray, bool]:
    """(t, 3) corners of triangles that cover one polygon, and whether they cover it exactly."""
    from mapbox_earcut import triangulate_float64

    ends = np.array([len(flat)], np.uint32)
    triangles = triangulate_float64(np.ascontiguousarray(flat), ends).astype(np.int64).reshape(-1, 3)
    signed = _areas(flat, triangles)
    triangles = np.where((signed < 0)[:, None], triangles[:, ::-1], triangles)
    triangles = _with_straight_corners(triangles, len(flat))
    return triangles, bool(abs(np.abs(signed).sum() - area) <= 1e-9)


def _with_straight_corners(triangles: np.ndarray, count: int) -> np.ndarray:
    """The same cover with the corners on straight sides, which ear clipping leaves out."""
    rows = [tuple(triangle) for triangle in triangles.tolist()]
    used = {corner for row in rows for corner in row}
    for corner in sorted(set(range(count)) - used):
        before, after = (corner - 1) % count, (corner + 1) % count
        while before not in used and before != corner:
            before = (before - 1) % count
        while after not in used and after != corner:
            after = (after + 1) % count
        for index, row in enumerate(rows):
            for shift in range(3):
                if (row[shift], row[(shift + 1) % 3]) == (before, after):
                    tip = row[(shift + 2) % 3]
                    rows[index] = (before, corner, tip)
                    rows.append((corner, after, tip))
                    used.add(corner)
                    break
            if corner in used:
                break
    return np.array(rows, dtype=np.int64).reshape(-1, 3)
