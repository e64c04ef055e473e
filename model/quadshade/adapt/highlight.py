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

from quadshade.adapt import highlight_loops
from quadshade.scene import subdivide_loops
from quadshade.scene.project import Projected
from quadshade.scene.subdivide import point_indices
from quadshade.shading.lights import AmbientLight, DirectionalLight, Light, PointedLight


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


def viewpoint(projected: Projected) -> tuple[np.ndarray, bool]:
    """The eye and True, or the (3,) float64 direction to an orthographic viewer and False."""
    near = projected.eye is not None
    return np.ascontiguousarray(projected.eye if near else projected.axes[2], dtype=np.float64), near


def light_rows(lights: Sequence[Light]) -> np.ndarray:
    """(lights, 4) float64: 0 ambient, 1 directional or 2 point light, and its direction or place."""
    rows = np.zeros((len(lights), 4))
    for row, light in zip(rows, lights, strict=True):
        if isinstance(light, DirectionalLight):
            row[:] = 1, *light.direction
        elif not isinstance(light, AmbientLight):
            row[:] = 2, *light.position
    return rows


def to_light(position: np.ndarray, light: PointedLight) -> np.ndarray:
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
    return highlight_loops.named(
        projected.position, projected.normal, *viewpoint(projected), light_rows(lights)
    )


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
    return subdivide_loops.with_neighbours(point_indices(vertices), chosen)


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
    return highlight_loops.centres(
        projected.position, projected.normal, triangle, *viewpoint(projected), light_rows([light])[0], repeats
    )
