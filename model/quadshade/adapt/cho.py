# SPDX-License-Identifier: Apache-2.0
"""Adaptive shading after Cho, Neumann and Woo: highlighted triangles and their neighbours are divided."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit

from quadshade.adapt.highlight import highlight_centres, potentially_highlighted, with_neighbours
from quadshade.contract.arrays import Bools, Floats, Ints
from quadshade.contract.formats import Formats
from quadshade.errors import QuadshadeError
from quadshade.scene import subdivide_loops
from quadshade.scene.project import Projected, doubled_area
from quadshade.scene.subdivide import (
    Edges,
    insert_vertices,
    refine,
    screen_points,
    shared_edges,
    split_edges,
)
from quadshade.shading.light_loops import compiled_surface, light_point
from quadshade.shading.lights import Light
from quadshade.shading.material import Material
from quadshade.shading.sample import reflected

MAX_DEPTH = 6
"""Passes of highlight subdivision."""
FAINTEST = 1 / 255
"""Of the largest intensity; differences are relative to no less."""
EDGE_POINTS = np.concatenate([np.eye(3), (np.eye(3) + np.eye(3)[[1, 2, 0]]) / 2])


@dataclass(frozen=True)
class Subdivided:
    """
    A mesh after Cho's subdivision, to be drawn with Gouraud shading.

    Attributes
    ----------
    projected : Projected
    root : (m,) int64
      The triangle of the original mesh that each is a part of.
    highlighted : (n,) bool
      Original triangles that the H1 and H2 test names.
    subdivided : (n,) bool
      Original triangles of more than one part.
    """

    projected: Projected
    root: np.ndarray
    highlighted: np.ndarray
    subdivided: np.ndarray


def _subdivided(projected: Projected, root: np.ndarray, highlighted: np.ndarray) -> Subdivided:
    return Subdivided(projected, root, highlighted, np.bincount(root, minlength=len(highlighted)) > 1)


def regular_subdivision(
    projected: Projected, lights: Sequence[Light], threshold: float = 32.0, formats: Formats | None = None
) -> Subdivided:
    """
    Divide potentially highlighted triangles and their neighbours into fours (section 3.2).

    Parameters
    ----------
    projected : Projected
    lights : sequence of lights
    threshold : float
      Pixels; triangles are divided until their area is less.
    formats : Formats, optional
      Gives the sub-pixel bits.

    Returns
    -------
    Subdivided
    """
    formats = Formats() if formats is None else formats
    highlighted = np.any(potentially_highlighted(projected, lights), axis=0)
    limit = 2 * threshold * 4.0**formats.subpixel_bits
    # The area is computed once; every division quarters it.
    area = abs(doubled_area(projected.vertices)).astype(np.float64)
    area[~with_neighbours(projected.vertices, highlighted)] = 0
    root = np.arange(len(projected))
    while (area >= limit).any():
        projected, parent = refine(projected, area >= limit)
        root, area = root[parent], area[parent] / 4
    return _subdivided(projected, root, highlighted)


def _insert_centres(
    projected: Projected, found: np.ndarray, lights: Sequence[Light]
) -> tuple[Projected, np.ndarray, np.ndarray]:
    """
    A vertex at or near the centre of each highlight that (lights, n) ``found`` names.

    A triangle gets one, of its first light; others are left to the test of the edges.

    Returns
    -------
    projected : Projected
    parent : (m,) int64
    places : (k, 2) int64
      Of the new vertices.
    """
    triangle = np.flatnonzero(np.any(found, axis=0))
    first = found[:, triangle].argmax(axis=0)
    scene, inside = np.empty((len(triangle), 3)), np.empty(len(triangle), dtype=bool)
    for index, light in enumerate(lights):
        mine = np.flatnonzero(first == index)
        if len(mine):
            scene[mine], inside[mine] = highlight_centres(projected, triangle[mine], light)
    screen = scene / projected.weight[triangle]
    screen /= screen.sum(axis=1, keepdims=True)
    # Outside: the point on the edge that is nearer to the centre becomes a vertex for both neighbours.
    edges = shared_edges(projected.vertices)
    marks, share = np.zeros(len(edges), dtype=bool), np.full(len(edges), 0.5)
    outside = ~inside & np.isfinite(screen).all(axis=1)
    rows, points = triangle[outside], screen[outside]
    edge = (points.argmin(axis=1) + 1) % 3
    index = edges.index[rows, edge]
    along = points[np.arange(len(rows)), (edge + 1) % 3]
    marks[index], share[index] = True, np.where(edges.reversed[rows, edge], 1 - along, along)
    parts, parent = split_edges(projected, edges, marks, share)
    # A triangle that a neighbour has divided is left to the test of the edges.
    whole = (np.bincount(parent, minlength=len(projected)) == 1)[triangle] & inside
    parts, more = insert_vertices(parts, np.searchsorted(parent, triangle[whole]), screen[whole])
    used = whole | outside
    return parts, parent[more], screen_points(projected.vertices[triangle[used]], screen[used])


def highlight_subdivision(
    projected: Projected,
    lights: Sequence[Light],
    material: Material | None = None,
    threshold: float = 0.3,
) -> Subdivided:
    """
    Put vertices at the highlights' centres and limit them by further ones (section 3.1).

    A potentially highlighted triangle gets a vertex at the centre of its highlight, or on the edge that is
    nearest to it. Then edges that meet at a centre are split in the middle where the true intensity differs
    from the interpolated one by more than the threshold, again and again.

    Parameters
    ----------
    projected : Projected
    lights : sequence of lights
    material : Material, optional
    threshold : float
      Allowed difference at an edge's middle, relative to the true intensity there.

    Returns
    -------
    Subdivided
    """
    material = Material() if material is None else material
    found = potentially_highlighted(projected, lights)
    near = with_neighbours(projected.vertices, np.any(found, axis=0))
    projected, root, centres = _insert_centres(projected, found, lights)
    fresh = np.ones(len(root), dtype=bool)
    for step in range(MAX_DEPTH):
        # Triangles with a vertex on a centre; in the first pass the highlight's neighbours too.
        candidates = subdivide_loops.touching(projected.vertices, centres)
        # Later on, edges of what was not divided just now have been tested.
        candidates = candidates & fresh if step else candidates | near[root]
        ids, places = subdivide_loops.place_numbers(projected.vertices)
        edges = Edges(*subdivide_loops.edge_numbers(ids, places))
        marks = _large_differences(projected, candidates, ids, edges, lights, material, threshold)
        if not marks.any():
            break
        projected, parent = split_edges(projected, edges, marks)
        root, fresh = root[parent], (np.bincount(parent) > 1)[parent]
    return _subdivided(projected, root, np.any(found, axis=0))


def _large_differences(
    projected: Projected,
    candidates: np.ndarray,
    ids: np.ndarray,
    edges: Edges,
    lights: Sequence[Light],
    material: Material,
    threshold: float,
) -> np.ndarray:
    """(edges,) where a candidate's interpolated colour at an edge's middle is off by more, relatively."""
    try:
        surface = compiled_surface(projected, lights, material, 1.0)
    except QuadshadeError:
        # Directional lights, parallel views, a user's reflectance, coloured meshes.
        rows = np.flatnonzero(candidates)
        light = np.clip(reflected(projected, rows, EDGE_POINTS, lights, material), 0, 1)
        linear = (light[:, :3] + light[:, [1, 2, 0]]) / 2
        off = (abs(light[:, 3:] - linear) / np.maximum(light[:, 3:], FAINTEST)).max(axis=2)
        marks = np.zeros(len(edges), dtype=bool)
        marks[edges.index[rows][off > threshold]] = True
        return marks
    return _edge_loop(
        projected.position, projected.normal, projected.weight, candidates, ids, edges.index, len(edges),
        surface, threshold,
    )  # fmt: skip


@njit(cache=True)
def _alike(position: Floats, normal: Floats, one: int, other: int) -> bool:
    """Whether the corners (triangle, corner) are the same point of the same surface."""
    for axis in range(3):
        if position[one // 3, one % 3, axis] != position[other // 3, other % 3, axis]:
            return False
        if normal[one // 3, one % 3, axis] != normal[other // 3, other % 3, axis]:
            return False
    return True


@njit(cache=True, error_model="numpy")
def _edge_loop(
    position: Floats,
    normal: Floats,
    weight: Floats,
    candidates: Bools,
    ids: Ints,
    index: Ints,
    count: int,
    surface: tuple[Any, ...],
    threshold: float,
) -> Bools:
    """As :func:`_large_differences`, for what the compiled light can do; what triangles share is lit once."""
    marks, seen = np.zeros(count, np.bool_), np.full(count, -1)
    keeper, kept = np.full(ids.size, -1), np.empty((ids.size, 3))
    ends, true, point, turn = np.empty((3, 3)), np.empty(3), np.empty(3), np.empty(3)
    for row in range(len(ids)):
        if not candidates[row]:
            continue
        for corner in range(3):
            place, here = ids[row, corner], 3 * row + corner
            if keeper[place] < 0 or not _alike(position, normal, keeper[place], here):
                light_point(normal[row, corner], position[row, corner], surface, kept[place])
                keeper[place] = here
            ends[corner] = kept[place]
        for corner in range(3):
            other, edge = (corner + 1) % 3, index[row, corner]
            if marks[edge]:
                continue
            if seen[edge] >= 0:
                # The other side of the edge, run through the other way.
                there = seen[edge]
                back = there + 1 if there % 3 < 2 else there - 2
                if _alike(position, normal, 3 * row + corner, back) and _alike(
                    position, normal, 3 * row + other, there
                ):
                    continue
            seen[edge] = 3 * row + corner
            # Half-way on the screen; lengths of normals do not matter to the light, places are divided.
            one, two = weight[row, corner], weight[row, other]
            for axis in range(3):
                at = one * position[row, corner, axis] + two * position[row, other, axis]
                point[axis] = at / (one + two)
                turn[axis] = one * normal[row, corner, axis] + two * normal[row, other, axis]
            light_point(turn, point, surface, true)
            for colour in range(3):
                linear = (ends[corner, colour] + ends[other, colour]) / 2
                marks[edge] |= abs(true[colour] - linear) / max(true[colour], FAINTEST) > threshold
    return marks
