# SPDX-License-Identifier: Apache-2.0
"""
No Mach bands: quadratics whose derivative does not jump where a jump could be seen.

It begins with whole triangles. Where the derivative jumps by more than is allowed, both ends of the edge get
a gradient, so that the triangles beside it are split (``powell_sabin``); what then jumps too far follows.
The least squared error against Phong shading is asked for all along.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import sparse

from quadshade.contract.arrays import Bools, Floats, Ints
from quadshade.contract.formats import Formats
from quadshade.contract.triangles import ScreenTriangles
from quadshade.fit.elements import ENDS, Elements, neighbours_of, shared_elements
from quadshade.fit.jumps import jumps_of
from quadshade.fit.places import Places
from quadshade.fit.powell_sabin import Parts, parts_of, smooth_corners
from quadshade.fit.solve import HOLD, normal_equations, solved_directly
from quadshade.fit.split import split_of
from quadshade.scene.project import Projected, doubled_area
from quadshade.scene.subdivide import divided

SEEN = 4.0
"""Pixels that one of the triangles at an edge has at least, for a jump across it to be seen."""
ROUNDS = 6
"""Of splitting what jumps; after four of them it is a few edges in ten thousand."""


@dataclass(frozen=True)
class Target:
    """
    What is to be drawn.

    Attributes
    ----------
    sampled : callable
      Projected triangles at six points.
    places : callable
      Projected triangles' places, and (p, c) their colours.
    """

    sampled: Callable[[Projected], ScreenTriangles]
    places: Callable[[Projected], tuple[Places, Floats]]


@dataclass(frozen=True)
class SmoothParts:
    """
    Triangles and parts of triangles.

    Attributes
    ----------
    triangles : ScreenTriangles
    projected : Projected
    parent : (p,) int64
      The triangle that each lies in.
    unsplit : int
      Triangles that could not be split, at a jump or at an edge that is odd.
    ended : bool
      Whether the solver came to its end.
    """

    triangles: ScreenTriangles
    projected: Projected
    parent: Ints
    unsplit: int
    ended: bool


def _seen(projected: Projected, jump: float, formats: Formats) -> Bools:
    """(n,) triangles at which a jump is seen; without an allowed jump every one."""
    area = np.abs(doubled_area(np.asarray(projected.vertices, dtype=np.int64)))
    return area / 2 / 4.0**formats.subpixel_bits >= (SEEN if jump else 0)


def anything_seen(projected: Projected, jump: float, formats: Formats) -> bool:
    """Whether anything can be split; else what is drawn is least squares, and takes less time that way."""
    return bool(_seen(projected, jump, formats).any())


def fit_c1(
    projected: Projected,
    elements: Elements,
    target: Target,
    jump: float,
    largest: float,
    formats: Formats,
    moves: Sequence[tuple[int, int]] = ((0, 0),),
) -> SmoothParts:
    """
    Split triangles where the derivative would jump, and fit.

    Parameters
    ----------
    projected : Projected
    elements : Elements
      Of its triangles at six points.
    target : Target
    jump : float
      Root mean square along an edge that is allowed, in output units per pixel; what is too small to be seen
      (``SEEN``) may jump by more, unless it is 0.
    largest : float
      Of the output.
    formats : Formats
    moves
      As for :func:`quadshade.fit.fit_scene`.

    Returns
    -------
    SmoothParts
    """
    vertices = np.asarray(projected.vertices, dtype=np.int64)
    neighbours = neighbours_of(elements, vertices)
    split = split_of(elements, neighbours, vertices, formats.subpixel_bits, np.array(moves, dtype=np.int64))
    smooth, allowed = smooth_corners(elements, neighbours, split.sound)
    chosen = np.zeros(len(allowed), dtype=bool)
    scale = 2.0**formats.subpixel_bits
    seen = _seen(projected, jump, formats)
    for number in range(ROUNDS):
        parts = parts_of(elements, vertices, split, smooth, chosen, scale)
        drawn, triangles, ended = _solved(projected, parts, target, elements.start, largest)
        own = shared_elements(triangles)
        jumps = jumps_of(own, parts.vertices, formats, _whole_edges(parts))
        values = np.empty_like(own.start)
        values[own.index.reshape(-1)] = _flat(triangles)
        large = seen[parts.parent[jumps.triangle]].any(axis=1)
        wrong = large & (jumps.of_edges(values) > jump)
        wanted = np.zeros(len(chosen), dtype=bool)
        wanted[smooth[_ends(parts, jumps.triangle[wrong, 0], jumps.side[wrong, 0])]] = True
        more = wanted & allowed & ~chosen
        if not more.any() or number == ROUNDS - 1:
            break
        chosen |= more
    refused = (wanted & ~allowed)[smooth].any(axis=1) | neighbours.odd.any(axis=1)
    return SmoothParts(triangles, drawn, parts.parent, int(refused.sum()), ended)


def _solved(
    projected: Projected, parts: Parts, target: Target, start: Floats, largest: float
) -> tuple[Projected, ScreenTriangles, bool]:
    """The parts with the colours of least squared error."""
    drawn = divided(projected, parts.parent, parts.corners, parts.vertices)
    sampled = target.sampled(drawn)
    places, colour = target.places(drawn)
    apart = Elements(np.arange(6 * len(drawn)).reshape(-1, 6), _flat(sampled))
    held = np.full(len(drawn), HOLD)
    normal = normal_equations(apart, held, places, colour, places.area)
    right = parts.basis.T @ normal.right.reshape(-1, colour.shape[1])
    count = len(drawn)
    diagonal = normal.block, np.arange(count), np.arange(count + 1)
    blocks = sparse.bsr_array(diagonal, shape=(6 * count, 6 * count))
    matrix = sparse.csr_array(parts.basis.T @ (blocks @ parts.basis))
    begin = np.zeros((matrix.shape[0], start.shape[1]))
    begin[: len(start)] = start
    solution = solved_directly(matrix, right, begin)
    samples = np.clip((parts.basis @ solution.values).reshape(count, 6, -1).transpose(0, 2, 1), 0, largest)
    return (
        drawn,
        replace(sampled, samples=np.where(np.isfinite(samples), samples, sampled.samples)),
        solution.ended,
    )


def _flat(triangles: ScreenTriangles) -> Floats:
    """(6 n, c) the samples of all triangles, one after the other."""
    return triangles.samples.transpose(0, 2, 1).reshape(-1, triangles.samples.shape[1])


def _whole_edges(parts: Parts) -> Bools:
    """(p, 3) edges of parts that are whole edges of triangles."""
    whole = parts.corners.max(axis=2) == 1
    return whole[:, ENDS].all(axis=2)


def _ends(parts: Parts, part: Ints, edge: Ints) -> tuple[Ints, Ints]:
    """(e, 2) triangles, and corners of them, at the ends of whole edges of parts."""
    corner = parts.corners[part[:, None], ENDS[edge]].argmax(axis=2)
    return np.broadcast_to(parts.parent[part][:, None], corner.shape), corner
