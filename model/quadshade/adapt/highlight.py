# SPDX-License-Identifier: Apache-2.0
"""
Which triangles can hold the centre of a specular highlight, and where it is (Cho, Neumann and Woo).

The centre of a highlight is where the normal N lies in the plane of the vectors L to the light and V to the
viewer (condition H1), halfway between the two (H2). Both are signs at the vertices, so no square root is
needed.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from quadshade.adapt.subdivide import CORNERS, point_indices
from quadshade.scene.project import Projected
from quadshade.shading.lights import AmbientLight, DirectionalLight, Light


def _dot(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    return np.einsum("...i,...i->...", first, second)


def conditions(
    normals: np.ndarray, to_light: np.ndarray, to_viewer: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """
    How far, with a sign, points are from the two conditions of a highlight's centre.

    Parameters
    ----------
    normals, to_light, to_viewer : (..., 3) float
      Need not be unit length.

    Returns
    -------
    h1 : (...) float64
      (L x V) . N: the side of the plane of L and V on which N is (section 2.3).
    h2 : (...) float64
      (V . N)^2 |L|^2 - (L . N)^2 |V|^2, each square with the sign of its cosine: positive where N is nearer
      to V.
    """
    light, viewer = _dot(to_light, normals), _dot(to_viewer, normals)
    h1 = _dot(np.cross(to_light, to_viewer), normals)
    h2 = viewer * abs(viewer) * _dot(to_light, to_light) - light * abs(light) * _dot(to_viewer, to_viewer)
    return h1, h2


def highlight_possible(normals: np.ndarray, to_light: np.ndarray, to_viewer: np.ndarray) -> np.ndarray:
    """
    Classify triangles that can hold a specular highlight centre (Cho, Neumann and Woo, tests H1 and H2).

    Parameters
    ----------
    normals, to_light, to_viewer : (n, 3, 3) float
      Per triangle and vertex; need not be unit length.

    Returns
    -------
    (n,) bool
      Potentially highlighted: the signs of both conditions differ between vertices (or one is zero), and
      neither the light nor the viewer is behind all three vertices.
    """
    h1, h2 = conditions(normals, to_light, to_viewer)
    between = [(sign.min(axis=1) <= 0) & (sign.max(axis=1) >= 0) for sign in (h1, h2)]
    lit, seen = ((_dot(vector, normals) > 0).any(axis=1) for vector in (to_light, to_viewer))
    return between[0] & between[1] & lit & seen


def to_viewer(projected: Projected) -> np.ndarray:
    """(n, 3, 3) float64 vectors from the vertices to the viewer, not unit length."""
    if projected.eye is None:
        return np.broadcast_to(projected.axes[2], projected.position.shape)
    return projected.eye - projected.position


def to_light(position: np.ndarray, light: Light) -> np.ndarray:
    """(..., 3) float64 vectors from (..., 3) points to a directional or point light, not unit length."""
    if isinstance(light, DirectionalLight):
        return np.broadcast_to(np.asarray(light.direction, dtype=np.float64), position.shape)
    return np.asarray(light.position) - position


def potentially_highlighted(projected: Projected, lights: Sequence[Light]) -> np.ndarray:
    """
    The H1 and H2 test of every triangle for every light.

    Parameters
    ----------
    projected : Projected
    lights : sequence of lights
      Ambient light has no highlight.

    Returns
    -------
    (lights, n) bool
    """
    viewer = to_viewer(projected)
    out = np.zeros((len(lights), len(projected)), dtype=bool)
    for row, light in zip(out, lights, strict=True):
        if not isinstance(light, AmbientLight):
            row[:] = highlight_possible(projected.normal, to_light(projected.position, light), viewer)
    return out


def with_neighbours(vertices: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    """
    Chosen triangles and those that share a vertex with one (section 3).

    Parameters
    ----------
    vertices : (n, 3, 2) int64
      Sub-pixels; two corners at the same place are one vertex.
    chosen : (n,) bool

    Returns
    -------
    (n,) bool
    """
    points = point_indices(vertices)
    touched = np.zeros(points.max(initial=-1) + 1, dtype=bool)
    touched[points[chosen]] = True
    return touched[points].any(axis=1)


def _mix(corners: np.ndarray, barycentric: np.ndarray) -> np.ndarray:
    """(k, 3) what (k, 3, 3) corners carry at (k, 3) barycentric coordinates."""
    return np.einsum("kj,kjx->kx", barycentric, corners)


def _root(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """A root in 0 .. 1 of a t^2 + b t + c, NaN where there is none; the nearer to the middle of two."""
    with np.errstate(divide="ignore", invalid="ignore"):
        # The form of the solution that does not cancel; the other root is c / (a root).
        q = -0.5 * (b + np.where(b < 0, -1, 1) * np.sqrt(b * b - 4 * a * c))
        roots = np.stack([q / a, c / q])
    roots[~((roots >= 0) & (roots <= 1))] = np.nan
    far = np.where(np.isnan(roots), np.inf, abs(roots - 0.5))
    return np.take_along_axis(roots, far.argmin(axis=0)[None], axis=0)[0]


def h1_on_segment(
    ends: tuple[np.ndarray, np.ndarray],
    position: np.ndarray,
    normal: np.ndarray,
    light: Light,
    eye: np.ndarray | None,
    axis: np.ndarray,
) -> np.ndarray:
    """
    Where condition H1 holds between two points of each triangle: the appendix's quadratic, solved directly.

    Parameters
    ----------
    ends : two (k, 3) float
      Barycentric coordinates in the scene.
    position, normal : (k, 3, 3) float
    light : DirectionalLight or PointLight
    eye : (3,) float or None
    axis : (3,) float
      Towards an orthographic viewer.

    Returns
    -------
    (k,) float64
      0 at the first end, 1 at the second; NaN where H1 does not hold in between.
    """
    start, end = (_mix(position, bary) for bary in ends)
    first, last = (_mix(normal, bary) for bary in ends)
    light_start, light_end = to_light(start, light), to_light(end, light)
    viewer_start, viewer_end = (
        np.broadcast_to(axis, place.shape) if eye is None else eye - place for place in (start, end)
    )
    light_step, viewer_step = light_end - light_start, viewer_end - viewer_start
    # L x V is quadratic in t, but both vectors change by the same step (or not at all): t^2 vanishes.
    cross = np.cross(light_start, viewer_start)
    change = np.cross(light_step, viewer_start) + np.cross(light_start, viewer_step)
    turn = last - first
    return _root(_dot(change, turn), _dot(change, first) + _dot(cross, turn), _dot(cross, first))


class _Search:
    """The appendix's search in triangles whose corners are known."""

    def __init__(self, projected: Projected, triangle: np.ndarray, light: Light) -> None:
        self.position, self.normal = projected.position[triangle], projected.normal[triangle]
        self.light, self.eye, self.axis = light, projected.eye, projected.axes[2]

    def between(self, one: np.ndarray, other: np.ndarray) -> np.ndarray:
        """Where H1 holds between two points; NaN where nowhere."""
        return h1_on_segment((one, other), self.position, self.normal, self.light, self.eye, self.axis)

    def misses(self, barycentric: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Both conditions' signed distances as sines and cosines of unit vectors."""
        place, normal = _mix(self.position, barycentric), _mix(self.normal, barycentric)
        viewer = np.broadcast_to(self.axis, place.shape) if self.eye is None else self.eye - place
        vectors = (normal, to_light(place, self.light), viewer)
        normal, light, viewer = (v / np.linalg.norm(v, axis=-1, keepdims=True) for v in vectors)
        return _dot(np.cross(light, viewer), normal), _dot(viewer, normal) - _dot(light, normal)

    def on_line(self, one: np.ndarray, other: np.ndarray) -> np.ndarray:
        """The place between two points where H2 holds if its cosines vary linearly (end of the appendix)."""
        start, end = self.misses(one)[1], self.misses(other)[1]
        with np.errstate(divide="ignore", invalid="ignore"):
            share = start / (start - end)
        return np.clip(np.where(np.isfinite(share), share, 0.5), 0, 1)


def highlight_centres(
    projected: Projected, triangle: np.ndarray, light: Light, repeats: int = 3
) -> tuple[np.ndarray, np.ndarray]:
    """
    Approximate centres of highlights, by three one-dimensional problems (section 3.1.1 and the appendix).

    Q and R are where H1 holds on two edges, P where H2 holds on the line QR. H1 and H2 are then solved again
    in turns, H1 on the line from the vertex between the two edges through P, H2 between the nearer of Q and
    R and that point.

    Parameters
    ----------
    projected : Projected
    triangle : (k,) int
      Potentially highlighted triangles.
    light : DirectionalLight or PointLight
    repeats : int
      Refinements; 0 is the direct solution.

    Returns
    -------
    centre : (k, 3) float64
      Barycentric coordinates in the scene; NaN where H1 does not hold on two edges.
    inside : (k,) bool
      H2 changes its sign between Q and R. Elsewhere ``centre`` is the one of the two that is nearer to it.
    """
    search = _Search(projected, triangle, light)
    count = len(triangle)
    corner = np.eye(3)
    crossing = np.stack(
        [
            search.between(
                np.broadcast_to(corner[start], (count, 3)), np.broadcast_to(corner[end], (count, 3))
            )
            for start, end in CORNERS
        ],
        axis=1,
    )
    # The edge without a crossing is left out; where all three have one (at a vertex), the last.
    has = ~np.isnan(crossing)
    missing = np.where(has.all(axis=1), 2, has.argmin(axis=1))
    edges = (missing[:, None] + (1, 2)) % 3
    share = np.take_along_axis(crossing, edges, axis=1)[..., None]
    places = corner[CORNERS[edges, 0]] * (1 - share) + corner[CORNERS[edges, 1]] * share
    q, r = places[:, 0], places[:, 1]
    apex = corner[CORNERS[edges[:, 0], 1]]
    along = search.on_line(q, r)[:, None]
    inside = search.misses(q)[1] * search.misses(r)[1] <= 0
    centre = q + along * (r - q)
    for _ in range(repeats):
        # From the vertex through P to the opposite edge, where H1 has to hold again.
        weight = (apex * centre).sum(axis=1, keepdims=True)
        with np.errstate(divide="ignore", invalid="ignore"):
            far = (centre - weight * apex) / (1 - weight)
        share = search.between(apex, far)[:, None]
        better = np.where(np.isnan(share), centre, apex + share * (far - apex))
        same = (search.misses(q)[1] * search.misses(better)[1] > 0)[:, None]
        q, r = np.where(same, better, q), np.where(same, r, better)
        along = search.on_line(q, r)[:, None]
        centre = np.where(inside[:, None], q + along * (r - q), centre)
    return centre, inside & (has.sum(axis=1) >= 2)
