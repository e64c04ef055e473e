# SPDX-License-Identifier: Apache-2.0
"""Light and cosines at points of triangles, as many as each has, in compiled loops."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from quadshade.contract.arrays import Bools, Floats, Int, Ints
from quadshade.shading.phong_loops import BLOCK, ROWS, LitMesh, cosines_to, light_at, surface_at


class PointSets(NamedTuple):
    """
    Points of triangles, as many as each has.

    Attributes
    ----------
    points : (m, 3) float64
      Barycentric coordinates.
    begin, number : (n,) int64
      Where a triangle's points begin, and how many it has; triangles may share them.
    at : (n,) int64
      Where its values begin, in arrays that hold one for each of its points.
    """

    points: Floats
    begin: Ints
    number: Ints
    at: Ints


def shared_points(points: Floats, rows: Ints) -> PointSets:
    """The same (k, 3) points in all triangles; those of (n,) ``rows``, of arrays with values for all."""
    same = np.full(len(rows), len(points))
    return PointSets(points, np.zeros(len(rows), np.int64), same, len(points) * np.asarray(rows))


def own_points(points: Floats, count: Ints) -> PointSets:
    """(m, 3) points of triangles that have (n,) ``count`` of them, one triangle after the other."""
    begin = np.cumsum(count) - count
    return PointSets(points, begin, count, begin)


def used_points(points: Floats, used: Bools) -> PointSets:
    """Those of (1 or n, p, 3) points that (n, p) ``used`` says, at least one of each triangle."""
    everywhere = np.broadcast_to(points, (len(used), *points.shape[1:]))
    return own_points(everywhere[used], used.sum(axis=1))


@njit(cache=True, error_model="numpy", forceinline=True)
def _put_points(sets: PointSets, index: Int, first: Int, number: Int, room: Floats) -> None:
    """Some points of a triangle, to the first rows of the room of :mod:`quadshade.shading.phong_loops`."""
    begin = sets.begin[index] + first
    for i in range(number):
        for corner in range(3):
            room[corner, i] = sets.points[begin + i, corner]


@njit(cache=True, error_model="numpy")
def shade_sets(lit: LitMesh, triangle: Ints, sets: PointSets) -> Floats:
    """(3, m) light, clamped and at full scale, at points of (n,) triangles of a mesh."""
    out, room = np.empty((3, sets.number.sum())), np.empty((ROWS, BLOCK))
    for index in range(len(triangle)):
        for first in range(0, sets.number[index], BLOCK):
            number, at = min(sets.number[index] - first, BLOCK), sets.at[index] + first
            _put_points(sets, index, first, number, room)
            light_at(lit, triangle[index], number, room)
            for colour in range(3):
                out[colour, at : at + number] = room[colour, :number]
    return out


@njit(cache=True, error_model="numpy")
def cosine_sets(lit: LitMesh, triangle: Ints, sets: PointSets, strength: Floats) -> tuple[Floats, Floats]:
    """
    Diffuse and specular cosines of all lights that come from somewhere, as :func:`.specular.cosines`.

    Parameters
    ----------
    lit : LitMesh
    triangle : (n,) int64
    sets : PointSets
      Of these triangles, their values one after the other.
    strength : (lights,) float64
      Largest intensity of each light.

    Returns
    -------
    diffuse, specular : (lights, m) float64
    """
    total, room = sets.number.sum(), np.empty((ROWS, BLOCK))
    diffuse, specular = np.empty((len(strength), total)), np.empty((len(strength), total))
    for index in range(len(triangle)):
        for first in range(0, sets.number[index], BLOCK):
            number, at, light = min(sets.number[index] - first, BLOCK), sets.at[index] + first, 0
            _put_points(sets, index, first, number, room)
            surface_at(lit, triangle[index], number, room)
            for source in range(len(lit.lights)):
                if lit.lights[source, 0] == 0:
                    continue
                cosines_to(lit, source, number, room)
                point = lit.lights[source, 0] == 2
                for i in range(number):
                    facing, cosine = min(max(room[13, i], -1.0), 1.0), min(max(room[14, i], -1.0), 1.0)
                    if point:
                        share = min(room[15, i] / strength[light], 1.0)
                        facing *= share
                        cosine *= share ** (1 / lit.exponent)
                    diffuse[light, at + i], specular[light, at + i] = facing, cosine
                light += 1
    return diffuse, specular
