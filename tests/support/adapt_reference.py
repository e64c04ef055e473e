# SPDX-License-Identifier: Apache-2.0
"""
What the compiled loops of ``quadshade.adapt`` have to give, in array expressions: edges, parts, highlights.

Written before the loops, from the papers' text and the definition of an edge; slower, and independent.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from quadshade.adapt.highlight import highlight_possible, to_light
from quadshade.scene.project import Projected, doubled_area
from quadshade.scene.subdivide import CORNERS, PATTERNS, Edges
from quadshade.shading.lights import AmbientLight, Light


def point_indices(vertices: np.ndarray) -> np.ndarray:
    """(n, 3) int64: a number for each place on the screen that (n, 3, 2) sub-pixel vertices take."""
    keys = (vertices[..., 0].astype(np.int64) << 32) + vertices[..., 1]
    return np.unique(keys, return_inverse=True)[1].reshape(len(vertices), 3)


def shared_edges(vertices: np.ndarray) -> Edges:
    """Find the edges of triangles."""
    pairs = point_indices(vertices)[:, CORNERS].reshape(-1, 2)
    first, second = pairs.min(axis=1), pairs.max(axis=1)
    count = int(pairs.max(initial=-1)) + 1
    _, where, index = np.unique(first * count + second, return_index=True, return_inverse=True)
    turned = pairs[:, 0] != first
    ends = vertices[:, CORNERS].reshape(-1, 2, 2)
    ends = np.where(turned[:, None, None], ends[:, ::-1], ends)[where]
    return Edges(index.reshape(-1, 3), turned.reshape(-1, 3), ends)


def divided(projected: Projected, parent: np.ndarray, corners: np.ndarray, vertices: np.ndarray) -> Projected:
    """Parts of triangles, with what is interpolated at their corners."""
    share = corners * projected.weight[parent][:, None, :]
    weight = share.sum(axis=-1)
    share /= weight[..., None]

    def inside(values: np.ndarray) -> np.ndarray:
        return np.einsum("mij,mjk->mik", share, values[parent])

    depth = np.einsum("mij,mj->mi", corners, projected.depth[parent])
    low, high = (getattr(projected.depth[parent], name)(axis=1, keepdims=True) for name in ("min", "max"))
    return replace(
        projected,
        vertices=vertices,
        depth=np.clip(depth, low, high),
        position=inside(projected.position),
        normal=inside(projected.normal),
        colour=None if projected.colour is None else inside(projected.colour),
        weight=weight,
        source=projected.source[parent],
    )


def _new_vertices(edges: Edges, share: np.ndarray | None) -> np.ndarray:
    """(edges, 2) int64 new vertices, from the edges' ends alone: whoever shares an edge gets the same."""
    one, other = edges.ends[:, 0], edges.ends[:, 1]
    if share is None:
        return (one + other) >> 1
    return one + np.rint(share[:, None] * (other - one)).astype(np.int64)


def _children(points: np.ndarray, split: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Parent (m,) and corners (m, 3), as indices into (n, 6, 2) points, of the parts of all triangles."""
    code = split @ (1 << np.arange(3))
    # The quadrilateral that two splits leave is cut along its shorter diagonal.
    diagonal = np.zeros(len(points), dtype=np.int64)
    for by in range(3):
        rows = np.flatnonzero(code == (1 << by | 1 << (by + 1) % 3))
        one = points[rows, by] - points[rows, 3 + (by + 1) % 3]
        other = points[rows, 3 + by] - points[rows, (by + 2) % 3]
        diagonal[rows] = (other**2).sum(axis=1) < (one**2).sum(axis=1)
    parents, corners = [], []
    for number, patterns in PATTERNS.items():
        for which, children in enumerate(patterns):
            rows = np.flatnonzero((code == number) & (diagonal == which))
            parents.append(np.repeat(rows, len(children)))
            corners.append(np.tile(np.array(children), (len(rows), 1)))
    parent = np.concatenate(parents)
    order = np.argsort(parent, kind="stable")
    return parent[order], np.concatenate(corners)[order]


def split_edges(
    projected: Projected, edges: Edges, marks: np.ndarray, share: np.ndarray | None = None
) -> tuple[Projected, np.ndarray]:
    """Split marked edges, and with them every triangle that has one."""
    middle = _new_vertices(edges, share)
    marks = marks & (middle[:, None] != edges.ends).any(axis=2).all(axis=1)
    points = np.concatenate([projected.vertices, middle[edges.index]], axis=1)
    turn = np.sign(doubled_area(projected.vertices))
    while True:
        parent, corners = _children(points, marks[edges.index])
        vertices = np.take_along_axis(points[parent], corners[..., None], axis=1)
        wrong = np.sign(doubled_area(vertices)) != turn[parent]
        if not wrong.any():
            break
        marks[edges.index[parent[wrong]]] = False
    along = np.full(edges.index.shape, 0.5) if share is None else share[edges.index]
    along = np.where(edges.reversed, 1 - along, along)
    places = np.zeros((len(points), 6, 3))
    places[:, range(3), range(3)] = 1
    for edge, (start, end) in enumerate(CORNERS):
        places[:, 3 + edge, start], places[:, 3 + edge, end] = 1 - along[:, edge], along[:, edge]
    barycentric = np.take_along_axis(places[parent], corners[..., None], axis=1)
    return divided(projected, parent, barycentric, vertices), parent


def insert_vertices(
    projected: Projected, triangle: np.ndarray, barycentric: np.ndarray
) -> tuple[Projected, np.ndarray]:
    """Divide triangles into three at a point inside (Cho et al., section 3.1.2)."""
    corners = projected.vertices[triangle]
    point = np.rint(np.einsum("kj,kjx->kx", barycentric, corners.astype(np.float64))).astype(np.int64)
    parts = np.repeat(corners[:, None], 3, axis=1)
    parts[:, range(3), range(3)] = point[:, None]
    turn = np.sign(doubled_area(corners))
    good = np.ones(len(triangle), dtype=bool)
    for part in range(3):
        good &= np.sign(doubled_area(parts[:, part])) == turn
    triangle = triangle[good]
    whole = np.setdiff1d(np.arange(len(projected)), triangle)
    places = np.repeat(np.eye(3)[None, None], len(triangle), axis=0).repeat(3, axis=1)
    places[:, range(3), range(3)] = barycentric[good][:, None]
    parent = np.concatenate([whole, np.repeat(triangle, 3)])
    order = np.argsort(parent, kind="stable")
    unit = np.broadcast_to(np.eye(3), (len(whole), 3, 3))
    barycentric = np.concatenate([unit, places.reshape(-1, 3, 3)])[order]
    vertices = np.concatenate([projected.vertices[whole], parts[good].reshape(-1, 3, 2)])[order]
    return divided(projected, parent[order], barycentric, vertices), parent[order]


def _dot(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    return np.einsum("...i,...i->...", first, second)


def potentially_highlighted(projected: Projected, lights: tuple[Light, ...]) -> np.ndarray:
    """(lights, n) bool: the test of H1 and H2, light by light."""
    if projected.eye is None:
        viewer = np.broadcast_to(projected.axes[2], projected.position.shape)
    else:
        viewer = projected.eye - projected.position
    out = np.zeros((len(lights), len(projected)), dtype=bool)
    for row, light in zip(out, lights, strict=True):
        if not isinstance(light, AmbientLight):
            row[:] = highlight_possible(projected.normal, to_light(projected.position, light), viewer)
    return out


def with_neighbours(vertices: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    """Chosen triangles and those that share a vertex with one (section 3)."""
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
    """Where condition H1 holds between two points of each triangle: the appendix's quadratic."""
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
    """Approximate centres of highlights, by three one-dimensional problems."""
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
