# SPDX-License-Identifier: Apache-2.0
"""
Quadratics with one gradient at a vertex: what values and gradients make of whole and of split triangles.

Around a vertex that has a gradient, all triangles that meet smoothly have that one. An edge with a gradient
at both ends is halved, and both its triangles are split (Powell and Sabin): no derivative jumps across it. An
edge with one stays whole; its middle follows from the gradient, and the jump shrinks to nothing at that
end. Triangles with at most one such corner stay whole, those with two are split into four, those with three
into six.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from quadshade.contract.arrays import Bools, Floats, Ints
from quadshade.fit.elements import ENDS, Elements, Neighbours
from quadshade.fit.split import SIDES, Split

GRADIENTS, MIDDLES, LOCAL = 3, 9, 12
"""Unknowns of a triangle: values at corners, x and y of the gradient at each, values at edges' middles."""
HUB = 6
"""Of a triangle's seven points the inner one."""


@dataclass(frozen=True)
class Parts:
    """
    Triangles and parts of triangles, and what unknowns make of their samples.

    Attributes
    ----------
    parent : (p,) int64
      The triangle that each lies in, in their order.
    corners : (p, 3, 3) float64
      Barycentric coordinates of their corners in it.
    vertices : (p, 3, 2) int64
      Sub-pixels.
    basis : (6 p, u) sparse
      The samples of all parts, one after the other, from unknowns.
    """

    parent: Ints
    corners: Floats
    vertices: Ints
    basis: sparse.csr_array


def smooth_corners(elements: Elements, neighbours: Neighbours, sound: Bools) -> tuple[Ints, Bools]:
    """
    Corners that share a gradient, and those that may have one.

    Parameters
    ----------
    elements : Elements
    neighbours : Neighbours
    sound : (n,) bool
      Triangles that can be split.

    Returns
    -------
    number : (n, 3) int64
      Corners that are joined by smooth edges have the same.
    allowed : (numbers,) bool
      Not where a triangle cannot be split, nor at an edge that is odd.
    """
    count, pairs = len(sound), neighbours.pairs
    rows, columns = [], []
    for end in (0, 1):
        one, two = (3 * pairs[:, side, 0] + corner_at(elements.index, pairs, side, end) for side in (0, 1))
        rows.append(one)
        columns.append(two)
    ones = np.ones(2 * len(pairs))
    shape = (3 * count, 3 * count)
    graph = sparse.coo_array((ones, (np.concatenate(rows), np.concatenate(columns))), shape=shape)
    numbers = connected_components(graph, directed=False)[1].astype(np.int64).reshape(count, 3)
    wrong = np.repeat(~sound[:, None], 3, axis=1)
    for edge, ends in enumerate(ENDS):
        wrong[:, ends] |= neighbours.odd[:, edge, None]
    allowed = np.ones(int(numbers.max(initial=-1)) + 1, dtype=bool)
    allowed[numbers[wrong]] = False
    return numbers, allowed


def corner_at(index: Ints, pairs: Ints, side: int, end: int) -> Ints:
    """(s,) one side's corner at the end of each shared edge whose number is lower (0) or higher (1)."""
    owner, edge = pairs[:, side].T
    first, last = ENDS[edge].T
    forward = index[owner, first] < index[owner, last]
    return np.where(forward == (end == 0), first, last)


def parts_of(
    elements: Elements, vertices: Ints, split: Split, smooth: Ints, chosen: Bools, scale: float
) -> Parts:
    """
    Cut triangles where gradients are, and express all samples by values and gradients.

    Parameters
    ----------
    elements : Elements
    vertices : (n, 3, 2) int64
    split : Split
    smooth : (n, 3) int64
      From :func:`smooth_corners`.
    chosen : (numbers,) bool
      The corners that have a gradient.
    scale : float
      Sub-pixels of a pixel.

    Returns
    -------
    Parts
      Unknowns: values at corners and at the middles of edges without a gradient, then x and y of gradients,
      times the length of a usual edge so that all are of one size.
    """
    place, has = vertices / scale, chosen[smooth]
    length = float(np.median(np.linalg.norm(place[:, ENDS[:, 0]] - place[:, ENDS[:, 1]], axis=2))) or 1.0
    column, unknowns = _columns(elements.index, smooth, chosen)
    # Most triangles of a fine mesh have no gradient: their samples are unknowns themselves.
    plain, bent = (np.flatnonzero(which) for which in (~has.any(axis=1), has.any(axis=1)))
    own = Split(split.centre[bent], split.point[bent], split.share[bent], split.sound[bent])
    parent, corners, where, samples = _bent_parts(vertices[bent], own, has[bent], length, scale)
    parent = np.concatenate([plain, bent[parent]])
    order = np.argsort(parent, kind="stable")
    row = np.empty((len(order), 6), dtype=np.int64)
    row[order] = np.arange(6 * len(order)).reshape(-1, 6)
    columns = np.repeat(column[parent[len(plain) :]], 6, axis=0)
    rows, used = np.broadcast_to(row[len(plain) :].reshape(-1, 1), columns.shape), samples != 0
    entries = np.concatenate([np.ones(6 * len(plain)), samples[used]])
    places = (
        np.concatenate([row[: len(plain)].reshape(-1), rows[used]]),
        np.concatenate([elements.index[plain].reshape(-1), columns[used]]),
    )
    return Parts(
        parent[order],
        np.concatenate([np.broadcast_to(np.eye(3), (len(plain), 3, 3)), corners])[order],
        np.concatenate([vertices[plain], where])[order],
        sparse.csr_array((entries, places), shape=(6 * len(order), unknowns)),
    )


def _bent_parts(
    vertices: Ints, split: Split, has: Bools, length: float, scale: float
) -> tuple[Ints, Floats, Ints, Floats]:
    """
    Parts of triangles that have a gradient at some corner.

    Returns
    -------
    parent, corners, vertices
      As in :class:`Parts`, in no order.
    samples : (6 p, 12) float64
      Of all parts, one after the other, from their triangle's unknowns.
    """
    place = vertices / scale
    ordinates = _ordinates(place, split, has, length, scale)
    barycentric = np.zeros((len(place), 7, 3))
    barycentric[:, :3] = np.eye(3)
    barycentric[:, HUB] = weights_at(place, split.centre / scale)
    for edge, (one, two) in enumerate(ENDS):
        barycentric[:, 3 + edge, one], barycentric[:, 3 + edge, two] = (
            1 - split.share[:, edge],
            split.share[:, edge],
        )
    points = np.concatenate([vertices, split.point, split.centre[:, None]], axis=1)

    cut = has.sum(axis=1) >= 2
    pieces = [((0, 1, 2), ~cut)]
    for one, two, edge in SIDES:
        halved = cut & has[:, one] & has[:, two]
        pieces += [
            ((one, 3 + edge, HUB), halved),
            ((3 + edge, two, HUB), halved),
            ((one, two, HUB), cut & ~halved),
        ]
    samples, corners, where = (
        np.concatenate([of(piece)[mask] for piece, mask in pieces])
        for of in (
            lambda piece: ordinates.samples(*piece),
            lambda piece: barycentric[:, piece],
            lambda piece: points[:, piece],
        )
    )
    parent = np.concatenate([np.flatnonzero(mask) for _, mask in pieces])
    return parent, corners, where, samples.reshape(-1, LOCAL)


def _columns(index: Ints, smooth: Ints, chosen: Bools) -> tuple[Ints, int]:
    """(n, 12) the unknown that each of a triangle's is, and how many there are; some are of no use."""
    has = chosen[smooth]
    values = int(index.max(initial=-1)) + 1
    gradients = values + 2 * (np.cumsum(chosen) - 1)
    column = np.zeros((len(index), LOCAL), dtype=np.int64)
    column[:, :3], column[:, MIDDLES:] = index[:, :3], index[:, 3:]
    for axis in (0, 1):
        column[:, GRADIENTS + axis : MIDDLES : 2] = np.where(has, gradients[smooth] + axis, 0)
    return column, values + 2 * int(chosen.sum())


@dataclass(frozen=True)
class _Ordinates:
    """
    A triangle's seven points (corners, points on the edges 12, 13, 23, inner point) and its Bezier ordinates.

    Attributes
    ----------
    at : (n, 7, 12) float64
      The value at each point, from the triangle's unknowns.
    between : dict
      (n, 12) the ordinate between two points, the lower one first.
    """

    at: Floats
    between: dict[tuple[int, int], Floats]

    def samples(self, one: int, two: int, three: int) -> Floats:
        """(n, 6, 12) the six samples of the part between three points."""
        corners = [self.at[:, point] for point in (one, two, three)]
        middles = []
        for first, last in ((0, 1), (0, 2), (1, 2)):
            pair = (one, two, three)[first], (one, two, three)[last]
            between = self.between[min(pair), max(pair)]
            middles.append((corners[first] + 2 * between + corners[last]) / 4)
        return np.stack(corners + middles, axis=1)


def _ordinates(place: Floats, split: Split, has: Bools, length: float, scale: float) -> _Ordinates:
    """All that the parts of triangles may need; what a triangle has not is meaningless."""
    count = len(place)
    value, middle = np.zeros((count, 3, LOCAL)), np.zeros((count, 3, LOCAL))
    gradient = np.zeros((count, 3, 2, LOCAL))
    for corner in range(3):
        value[:, corner, corner] = middle[:, corner, MIDDLES + corner] = 1
        for axis in (0, 1):
            gradient[:, corner, axis, GRADIENTS + 2 * corner + axis] = 1 / length

    def toward(corner: int, target: Floats) -> Floats:
        step = target - place[:, corner]
        return value[:, corner] + 0.5 * np.einsum("na,nak->nk", step, gradient[:, corner])

    between: dict[tuple[int, int], Floats] = {}
    for edge, (one, two) in enumerate(ENDS):
        free = 2 * middle[:, edge] - 0.5 * (value[:, one] + value[:, two])
        with_two = np.where(has[:, two, None], toward(two, place[:, one]), free)
        between[one, two] = np.where(has[:, one, None], toward(one, place[:, two]), with_two)
    # A corner without a gradient of its own, in a triangle that is cut: its edges' ordinates say it.
    slopes = _weight_slopes(place)
    for corner in range(3):
        own = np.zeros((count, 2, LOCAL))
        for other in range(3):
            if other != corner:
                rise = 2 * (between[min(corner, other), max(corner, other)] - value[:, corner])
                own += rise[:, None, :] * slopes[:, other, :, None]
        gradient[:, corner] = np.where(has[:, corner, None, None], gradient[:, corner], own)

    inner = split.centre / scale
    at = np.zeros((count, 7, LOCAL))
    at[:, :3] = value
    weights = weights_at(place, inner)
    for corner in range(3):
        between[corner, HUB] = toward(corner, inner)
        at[:, HUB] += weights[:, corner, None] * between[corner, HUB]
    for edge, (one, two) in enumerate(ENDS):
        point, there = 3 + edge, split.share[:, edge, None]
        for corner in (one, two):
            between[corner, point] = toward(corner, split.point[:, edge] / scale)
        at[:, point] = (1 - there) * between[one, point] + there * between[two, point]
        between[point, HUB] = (1 - there) * between[one, HUB] + there * between[two, HUB]
    return _Ordinates(at, between)


def weights_at(corners: Floats, points: Floats) -> Floats:
    """(n, 3) barycentric coordinates of (n, 2) points in (n, 3, 2) triangles; 1, 0, 0 without area."""
    off = np.einsum("nca,na->nc", _weight_slopes(corners)[:, 1:], points - corners[:, 0])
    return np.concatenate([1 - off.sum(axis=1, keepdims=True), off], axis=1)


def _weight_slopes(corners: Floats) -> Floats:
    """(n, 3, 2) gradients of the barycentric coordinates of (n, 3, 2) triangles; 0 where there is no area."""
    legs = corners[:, 1:] - corners[:, :1]
    area = legs[:, 0, 0] * legs[:, 1, 1] - legs[:, 0, 1] * legs[:, 1, 0]
    area = np.where(area == 0, np.inf, area)[:, None]
    second = np.stack([legs[:, 1, 1], -legs[:, 1, 0]], axis=1) / area
    third = np.stack([-legs[:, 0, 1], legs[:, 0, 0]], axis=1) / area
    return np.stack([-second - third, second, third], axis=1)
