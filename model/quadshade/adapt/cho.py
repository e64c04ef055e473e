# SPDX-License-Identifier: Apache-2.0
"""Adaptive shading after Cho, Neumann and Woo: highlighted triangles and their neighbours are divided."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from quadshade.adapt.highlight import highlight_centres, potentially_highlighted, with_neighbours
from quadshade.adapt.subdivide import insert_vertices, refine, shared_edges, split_edges
from quadshade.formats import Formats
from quadshade.scene.project import Projected, doubled_area
from quadshade.shading.lights import Light
from quadshade.shading.material import Material
from quadshade.shading.sample import reflected

MAX_DEPTH = 6
"""Passes of highlight subdivision."""


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
    highlighted = potentially_highlighted(projected, lights).any(axis=0)
    limit = 2 * threshold * 4.0**formats.subpixel_bits
    # The area is computed once; every division quarters it.
    area = abs(doubled_area(projected.vertices)).astype(np.float64)
    area[~with_neighbours(projected.vertices, highlighted)] = 0
    root = np.arange(len(projected))
    while (area >= limit).any():
        projected, parent = refine(projected, area >= limit)
        root, area = root[parent], area[parent] / 4
    return _subdivided(projected, root, highlighted)


def _insert_centre(
    projected: Projected, triangle: np.ndarray, light: Light
) -> tuple[Projected, np.ndarray, np.ndarray]:
    """A vertex at or near each highlight's centre: the parts, their parents and the new places (k, 2)."""
    scene, inside = highlight_centres(projected, triangle, light)
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
    corners = projected.vertices[triangle[used]].astype(np.float64)
    place = np.rint(np.einsum("kj,kjx->kx", screen[used], corners)).astype(np.int64)
    return parts, parent[more], place


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
    near = with_neighbours(projected.vertices, found.any(axis=0))
    root = np.arange(len(projected))
    places = [np.zeros((0, 2), np.int64)]
    for light, highlighted in zip(lights, found, strict=True):
        # What an earlier light has divided is left to the test of the edges.
        whole = np.bincount(root, minlength=len(highlighted)) == 1
        triangle = np.flatnonzero((highlighted & whole)[root])
        if len(triangle):
            projected, parent, place = _insert_centre(projected, triangle, light)
            root = root[parent]
            places.append(place)
    centres = np.concatenate(places)
    for step in range(MAX_DEPTH):
        at_centre = (projected.vertices[:, :, None, :] == centres[None, None]).all(axis=3).any(axis=2)
        # Triangles with a vertex on a centre; in the first pass the highlight's neighbours too.
        rows = np.flatnonzero(at_centre.any(axis=1) | (near[root] & (step == 0)))
        wanted = np.zeros((len(projected), 3), dtype=bool)
        wanted[rows] = _edge_differences(projected, rows, lights, material) > threshold
        if not wanted.any():
            break
        projected, parent = refine(projected, wanted)
        root = root[parent]
    return _subdivided(projected, root, found.any(axis=0))


def _edge_differences(
    projected: Projected, rows: np.ndarray, lights: Sequence[Light], material: Material
) -> np.ndarray:
    """(k, 3) largest difference over the channels at edges' middles, relative to the true intensity."""
    places = np.concatenate([np.eye(3), (np.eye(3) + np.eye(3)[[1, 2, 0]]) / 2])
    light = np.clip(reflected(projected, rows, places, lights, material), 0, 1)
    linear = (light[:, :3] + light[:, [1, 2, 0]]) / 2
    return (abs(light[:, 3:] - linear) / np.maximum(light[:, 3:], 1 / 255)).max(axis=2)
