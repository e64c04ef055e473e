# SPDX-License-Identifier: Apache-2.0
"""Near and far: the distances that depth spans, so that nothing that can be seen is before the near plane."""

from __future__ import annotations

import numpy as np

from quadshade.contract.formats import Formats
from quadshade.scene.clip import clip_triangles

NEAREST = 1e-3
"""A fitted near plane is nearer than this share of the farthest point only for what is seen there."""

EDGE_ON = 1e-15
"""Volume of the unit vectors to a triangle's corners, below which it is edge-on or rounding decides."""

COARSE = 16
"""Steps of depth in the farthest point's distance, fewer than which are worth a notice."""


def fitted_near(
    corners: np.ndarray, culled: np.ndarray, pyramid: np.ndarray, scale: float, far: float
) -> float:
    """
    A near plane for a perspective view of a scene that reaches up to the viewer, or behind.

    Parameters
    ----------
    corners : (n, 3, 4) float64
      Triangles: x w and y w in pixels from the picture's middle, y down, w and the distance to the viewer.
    culled : (n,) bool
      Those that are not drawn where they are seen from behind.
    pyramid : (5, 5) float64
      Planes around what the picture shows: near, then left, right, upper and lower.
    scale : float
      Pixels that one unit shows at the distance 1.
    far : float
      The farthest point's distance.

    Returns
    -------
    float
      The distance of the nearest point in the picture, or ``NEAREST * far``, whichever is less.
    """
    limit = NEAREST * far
    distance = corners[..., 3]
    close = np.flatnonzero((distance.min(axis=1) < limit) & (distance.max(axis=1) > 0))
    places = corners[close]
    points = places[..., :3] / (scale, scale, 1)
    # The determinant's sign tells which side is seen; y is down.
    units = points / np.maximum(np.linalg.norm(points, axis=-1, keepdims=True), 1e-300)
    facing = -np.linalg.det(units)
    seen = (facing > EDGE_ON) | ((facing < -EDGE_ON) & ~culled[close])
    pieces, source = clip_triangles(places[seen], pyramid)
    # A cut may miss by its rounding; no point is nearer than its plane, seen at the picture's corner.
    slope = np.hypot(pyramid[1, 2], pyramid[3, 2]) / scale
    lower = _plane_distance(points[seen]) / np.sqrt(1 + slope**2)
    nearest = np.maximum(pieces[..., 3].min(axis=1), lower[source])
    return max(float(nearest.min(initial=limit)), 1e-30)


def _plane_distance(points: np.ndarray) -> np.ndarray:
    """(n,) distances of the origin from the planes of (n, 3, 3) triangles, from each one's nearest corner."""
    rows = np.arange(len(points))[:, None]
    order = (np.linalg.norm(points, axis=-1).argmin(axis=1)[:, None] + np.arange(3)) % 3
    one, two, three = points[rows, order].transpose(1, 0, 2)
    first, second = _unit(two - one), _unit(three - one)
    return np.abs(np.einsum("ni,ni->n", one, _unit(np.cross(first, second))))


def _unit(vectors: np.ndarray) -> np.ndarray:
    """(n, 3) vectors of length 1; zero stays zero."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(vectors / np.where(length > 0, length, 1))


def depth_notes(near: float, far: float, formats: Formats) -> tuple[str, ...]:
    """What to say of a perspective view whose depth is coarse; empty where it is not."""
    if not formats.with_depth or not far > near > 0:
        return ()
    # Depth is linear in 1 / distance: one step more at the farthest point is this much nearer.
    step = far - 1 / (1 / far + (1 / near - 1 / far) / (2.0**formats.depth_bits - 1))
    if step * COARSE < far:
        return ()
    note = (
        f"near is {near:.3g} and the farthest point at {far:.3g}: {formats.depth_bits} bits of depth resolve"
        f" only {step:.3g} there, so surfaces may show through each other; give the camera a larger near"
        " or raise generic depth_bits"
    )
    return (note,)
