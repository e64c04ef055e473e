# SPDX-License-Identifier: Apache-2.0
"""
Division of triangles on the screen without cracks.

Whether an edge is split, and where, is a property of the edge, not of a triangle: both triangles that share
it get the same new vertex, rounded once to the sub-pixel grid. A triangle with one, two or three split edges
becomes two, three or four, so there is never a vertex in the middle of a neighbour's edge.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from quadshade.scene.project import Projected, doubled_area

CORNERS = np.array([[0, 1], [1, 2], [2, 0]])
"""Corners that edge 0, 1 and 2 of a triangle lead from and to."""

# Points of a triangle: corners 0, 1, 2, then the new vertices on edges 0, 1, 2.
_ONE = ((3, 1, 2), (0, 3, 2))
_TWO = (((3, 1, 4), (0, 3, 4), (0, 4, 2)), ((3, 1, 4), (0, 3, 2), (3, 4, 2)))
_RED = ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5))


def _turned(children: tuple, by: int) -> tuple:
    """A pattern for the triangle whose corner ``by`` is called corner 0."""
    place = [(index + by) % 3 + 3 * (index >= 3) for index in range(6)]
    return tuple(tuple(place[index] for index in child) for child in children)


# Children by split edges (bit e: edge e), once for each diagonal of the quadrilateral that two splits leave.
PATTERNS: dict[int, tuple[tuple, tuple]] = {0: (((0, 1, 2),),) * 2, 7: (_RED,) * 2}
for _by in range(3):
    PATTERNS[1 << _by] = (_turned(_ONE, _by),) * 2
    PATTERNS[1 << _by | 1 << (_by + 1) % 3] = tuple(_turned(children, _by) for children in _TWO)


@dataclass(frozen=True)
class Edges:
    """
    The edges of triangles on the screen; two edges between the same two points are one.

    Attributes
    ----------
    index : (n, 3) int64
      The edge that each triangle has between corners 0-1, 1-2 and 2-0.
    reversed : (n, 3) bool
      Where the triangle runs from the edge's second end to its first.
    ends : (edges, 2, 2) int64
      Sub-pixels.
    """

    index: np.ndarray
    reversed: np.ndarray
    ends: np.ndarray

    def __len__(self) -> int:
        return len(self.ends)

    def marked(self, wanted: np.ndarray) -> np.ndarray:
        """(edges,) bool: edges that any triangle wants, from (n, 3) bool."""
        marks = np.zeros(len(self), dtype=bool)
        marks[self.index[wanted]] = True
        return marks


def point_indices(vertices: np.ndarray) -> np.ndarray:
    """(n, 3) int64: a number for each place on the screen that (n, 3, 2) sub-pixel vertices take."""
    keys = (vertices[..., 0].astype(np.int64) << 32) + vertices[..., 1]
    return np.unique(keys, return_inverse=True)[1].reshape(len(vertices), 3)


def shared_edges(vertices: np.ndarray) -> Edges:
    """
    Find the edges of triangles.

    Parameters
    ----------
    vertices : (n, 3, 2) int64
      Sub-pixels.

    Returns
    -------
    Edges
    """
    pairs = point_indices(vertices)[:, CORNERS].reshape(-1, 2)
    first, second = pairs.min(axis=1), pairs.max(axis=1)
    count = int(pairs.max(initial=-1)) + 1
    _, where, index = np.unique(first * count + second, return_index=True, return_inverse=True)
    turned = pairs[:, 0] != first
    ends = vertices[:, CORNERS].reshape(-1, 2, 2)
    ends = np.where(turned[:, None, None], ends[:, ::-1], ends)[where]
    return Edges(index.reshape(-1, 3), turned.reshape(-1, 3), ends)


def divided(projected: Projected, parent: np.ndarray, corners: np.ndarray, vertices: np.ndarray) -> Projected:
    """
    Parts of triangles, with what is interpolated at their corners.

    Positions and normals are interpolated with perspective and normals are not normalised, so Phong shading
    of a part is Phong shading of the triangle.

    Parameters
    ----------
    projected : Projected
    parent : (m,) int
      The triangle that each part lies in.
    corners : (m, 3, 3) float
      Barycentric coordinates of the parts' corners in it, on the screen.
    vertices : (m, 3, 2) int64
      Where the corners are, in sub-pixels.

    Returns
    -------
    Projected
    """
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
    """
    Split marked edges, and with them every triangle that has one.

    Parameters
    ----------
    projected : Projected
    edges : Edges
      Of its triangles, from :func:`shared_edges`.
    marks : (edges,) bool
      Edges to split. One stays whole where its new vertex would be one of its ends, or where a triangle
      would get a part without area or turned over: there are such triangles of a few sub-pixels.
    share : (edges,) float, optional
      Where an edge is split, 0 at its first end, 1 at its second; by default in the middle.

    Returns
    -------
    projected : Projected
      The parts, in the order of their triangles.
    parent : (m,) int64
      The triangle that each part is of.
    """
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


def refine(projected: Projected, wanted: np.ndarray) -> tuple[Projected, np.ndarray]:
    """
    Split edges in the middle.

    Parameters
    ----------
    projected : Projected
    wanted : (n,) or (n, 3) bool
      Triangles to divide into four, or edges 0-1, 1-2, 2-0 of each to split. Neighbours follow with two,
      three or four parts.

    Returns
    -------
    projected : Projected
    parent : (m,) int64
      As for :func:`split_edges`.
    """
    edges = shared_edges(projected.vertices)
    wanted = np.broadcast_to(wanted.reshape(len(projected), -1), (len(projected), 3))
    return split_edges(projected, edges, edges.marked(wanted))


def insert_vertices(
    projected: Projected, triangle: np.ndarray, barycentric: np.ndarray
) -> tuple[Projected, np.ndarray]:
    """
    Divide triangles into three at a point inside (Cho et al., section 3.1.2).

    Parameters
    ----------
    projected : Projected
    triangle : (k,) int
      Each at most once.
    barycentric : (k, 3) float
      The point, on the screen. Where it is so near the border that a part has no area, nothing is done.

    Returns
    -------
    projected : Projected
    parent : (m,) int64
    """
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
