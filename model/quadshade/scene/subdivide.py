# SPDX-License-Identifier: Apache-2.0
"""
Division of triangles on the screen without cracks.

Whether an edge is split, and where, is a property of the edge, not of a triangle: both triangles that share
it get the same new vertex, rounded once to the sub-pixel grid. A triangle with one, two or three split edges
becomes two, three or four, so there is never a vertex in the middle of a neighbour's edge.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from quadshade.scene import subdivide_loops
from quadshade.scene.project import Projected

CORNERS = np.array([[0, 1], [1, 2], [2, 0]])
"""Corners that edge 0, 1 and 2 of a triangle lead from and to."""

Pattern: TypeAlias = tuple[tuple[int, ...], ...]
"""The parts of a triangle, three points each."""

# Points of a triangle: corners 0, 1, 2, then the new vertices on edges 0, 1, 2.
_ONE: Pattern = ((3, 1, 2), (0, 3, 2))
_TWO: tuple[Pattern, Pattern] = (((3, 1, 4), (0, 3, 4), (0, 4, 2)), ((3, 1, 4), (0, 3, 2), (3, 4, 2)))
_RED: Pattern = ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5))


def _turned(children: Pattern, by: int) -> Pattern:
    """A pattern for the triangle whose corner ``by`` is called corner 0."""
    place = [(index + by) % 3 + 3 * (index >= 3) for index in range(6)]
    return tuple(tuple(place[index] for index in child) for child in children)


# Children by split edges (bit e: edge e), once for each diagonal of the quadrilateral that two splits leave.
PATTERNS: dict[int, tuple[Pattern, Pattern]] = {0: (((0, 1, 2),),) * 2, 7: (_RED,) * 2}
for _by in range(3):
    PATTERNS[1 << _by] = (_turned(_ONE, _by),) * 2
    PATTERNS[1 << _by | 1 << (_by + 1) % 3] = _turned(_TWO[0], _by), _turned(_TWO[1], _by)


CHILDREN, COUNTS = np.zeros((8, 2, 4, 3), dtype=np.int64), np.zeros((8, 2), dtype=np.int64)
"""The patterns as arrays: corners of the parts, and how many there are."""
for _code, _both in PATTERNS.items():
    for _which, _parts in enumerate(_both):
        CHILDREN[_code, _which, : len(_parts)], COUNTS[_code, _which] = _parts, len(_parts)


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

    def splits(self, marks: np.ndarray) -> np.ndarray:
        """(n,) int64 which edges of each triangle (edges,) marks split, bit e: edge e."""
        return marks[self.index] @ (1 << np.arange(3))


def point_indices(vertices: np.ndarray) -> np.ndarray:
    """(n, 3) int64: a number for each place on the screen that (n, 3, 2) sub-pixel vertices take."""
    return subdivide_loops.place_numbers(np.asarray(vertices, dtype=np.int64))[0]


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
    return Edges(
        *subdivide_loops.edge_numbers(*subdivide_loops.place_numbers(np.asarray(vertices, dtype=np.int64)))
    )


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
    kinds = [projected.position, projected.normal]
    if projected.colour is not None:
        kinds.append(projected.colour)
    weight, depth, carried = subdivide_loops.interpolated(
        parent, corners, projected.weight, projected.depth, np.stack(kinds).astype(np.float64, copy=False)
    )
    return replace(
        projected,
        vertices=vertices,
        depth=depth,
        position=carried[0],
        normal=carried[1],
        colour=None if projected.colour is None else carried[2],
        weight=weight,
        source=projected.source[parent],
    )


def _sound(
    projected: Projected, edges: Edges, marks: np.ndarray, share: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(edges,) bool: those of the marked edges that can be split, and (edges, 2) where."""
    marks = marks.copy()
    middle = subdivide_loops.new_vertices(edges.ends, share, marks)
    vertices = np.asarray(projected.vertices, dtype=np.int64)
    subdivide_loops.sound_marks(vertices, edges.index, marks, middle, CHILDREN, COUNTS)
    return marks, middle


def possible_splits(projected: Projected, edges: Edges, marks: np.ndarray) -> np.ndarray:
    """(edges,) bool: those of the marked edges that :func:`split_edges` splits in the middle."""
    return _sound(projected, edges, marks, np.empty(0))[0]


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
    share = np.empty(0) if share is None else share
    marks, middle = _sound(projected, edges, marks, share)
    vertices = np.asarray(projected.vertices, dtype=np.int64)
    parent, barycentric, vertices = subdivide_loops.parts(
        vertices, edges.index, edges.reversed, marks, middle, share, CHILDREN, COUNTS
    )
    return divided(projected, parent, barycentric, vertices), parent


def children(parent: np.ndarray) -> np.ndarray:
    """(m,) int64 which part of its triangle each is, from 0, by the sorted (m,) triangles."""
    return np.arange(len(parent)) - np.searchsorted(parent, parent)


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
    wanted = np.broadcast_to(wanted[:, None] if wanted.ndim == 1 else wanted, (len(projected), 3))
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
    vertices = np.asarray(projected.vertices, dtype=np.int64)
    points = screen_points(vertices[triangle], barycentric)
    chosen = np.full(len(vertices), -1)
    chosen[triangle] = np.arange(len(triangle))
    parent, corners, vertices = subdivide_loops.parts_around(vertices, chosen, barycentric, points)
    return divided(projected, parent, corners, vertices), parent


def screen_points(vertices: np.ndarray, barycentric: np.ndarray) -> np.ndarray:
    """(k, 2) int64 sub-pixels nearest to (k, 3) barycentric coordinates in (k, 3, 2) triangles."""
    return np.rint((barycentric[:, :, None] * vertices).sum(axis=1)).astype(np.int64)
