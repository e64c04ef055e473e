# SPDX-License-Identifier: Apache-2.0
"""Loops over vertices and faces, compiled: coordinates, sides of planes, rounding, culling."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt
from numba import njit

from quadshade.contract.arrays import Bools, Floats, Ints

Flags: TypeAlias = npt.NDArray[np.uint16]

# A vertex's coordinates before the viewport: x w, y w, w (1 in an orthographic view), distance to the viewer.
ACROSS, DOWN, DIVISOR, DISTANCE, COORDINATES = range(5)
CUT = 1 << 15
"""A vertex's flag: beyond the near plane or the guard band. Bit p: beyond plane p of the screen."""


class ViewDepth(NamedTuple):
    """Depth is linear on the screen: 0 at distance ``near``, ``full`` at ``far``."""

    near: float
    far: float
    perspective: bool
    full: float


class Corners(NamedTuple):
    """Arrays of :class:`Projected`."""

    vertices: Ints
    depth: Floats
    position: Floats
    normal: Floats
    weight: Floats


@njit(cache=True)
def place_vertices(points: Floats, eye: Floats, rows: Floats, perspective: bool) -> Floats:
    """(m, 4) float64 coordinates of (m, 3) points, to the last bit the same for the same point."""
    out = np.empty((len(points), COORDINATES))
    for vertex in range(len(points)):
        x, y, z = points[vertex, 0] - eye[0], points[vertex, 1] - eye[1], points[vertex, 2] - eye[2]
        for index in range(COORDINATES):
            out[vertex, index] = x * rows[index, 0] + y * rows[index, 1] + z * rows[index, 2]
        out[vertex, DIVISOR] = out[vertex, DISTANCE] if perspective else 1.0
    return out


@njit(cache=True)
def beyond(coordinates: Floats, plane: Floats) -> bool:
    """Whether a vertex is on the outer side of a plane; added up as in :func:`clip.plane_distance`."""
    total = plane[COORDINATES]
    for index in range(COORDINATES):
        total += coordinates[index] * plane[index]
    return total < 0


@njit(cache=True)
def vertex_sides(coordinates: Floats, borders: Floats, cutters: Floats) -> Flags:
    """(m,) uint16 flags: bit p beyond border p; ``CUT`` beyond any cutter."""
    out = np.zeros(len(coordinates), np.uint16)
    for vertex in range(len(coordinates)):
        for index in range(len(borders)):
            if beyond(coordinates[vertex], borders[index]):
                out[vertex] |= 1 << index
        for index in range(len(cutters)):
            if beyond(coordinates[vertex], cutters[index]):
                out[vertex] |= CUT
    return out


@njit(cache=True, error_model="numpy")
def rounded_vertices(
    coordinates: Floats, sides: Flags, middle: Floats, scale: float, low: int, high: int
) -> Ints:
    """(m, 2) int64 sub-pixels low .. high, y down, ties to even; zero for vertices beyond a cutter."""
    out = np.zeros((len(coordinates), 2), np.int64)
    for vertex in range(len(coordinates)):
        if not sides[vertex] & CUT:
            for axis in range(2):
                place = middle[axis] + coordinates[vertex, axis] / coordinates[vertex, DIVISOR]
                # A cut from very far away may miss the guard band by its rounding.
                out[vertex, axis] = np.int64(min(max(np.rint(place * scale), low), high))
    return out


@njit(cache=True)
def face_sense(face: Ints, vertices: Ints) -> int:
    """Positive for a triangle that turns counter-clockwise on the screen, 0 without area (an integer)."""
    x, y = vertices[face[0], 0], vertices[face[0], 1]
    x2, y2 = vertices[face[1], 0] - x, vertices[face[1], 1] - y
    x3, y3 = vertices[face[2], 0] - x, vertices[face[2], 1] - y
    return x3 * y2 - x2 * y3


@njit(cache=True)
def seen_faces(faces: Ints, sides: Flags, vertices: Ints, culled: Bools) -> tuple[Ints, Ints]:
    """Faces to draw that no cutter touches, and those that one crosses: two (k,) int64, ascending."""
    whole, crossing = np.empty(len(faces), np.int64), np.empty(len(faces), np.int64)
    wholes = crossings = 0
    for index in range(len(faces)):
        face = faces[index]
        one, two, three = sides[face[0]], sides[face[1]], sides[face[2]]
        if one & two & three & (CUT - 1):
            continue
        if (one | two | three) & CUT:
            crossing[crossings] = index
            crossings += 1
        else:
            facing = face_sense(face, vertices)
            if facing > 0 or (facing < 0 and not culled[index]):
                whole[wholes] = index
                wholes += 1
    return whole[:wholes].copy(), crossing[:crossings].copy()


@njit(cache=True, error_model="numpy")
def fill_corners(
    chosen: Ints,
    faces: Ints,
    vertices: Ints,
    coordinates: Floats,
    view_depth: ViewDepth,
    position: Floats,
    normal: Floats,
    out: Corners,
) -> None:
    """The arrays of :func:`_gather`."""
    near, far, perspective, full = view_depth
    for row in range(len(chosen)):
        face = faces[chosen[row]]
        back = face_sense(face, vertices) < 0
        for corner in range(3):
            vertex = face[corner]
            distance = coordinates[vertex, DISTANCE]
            if not far > near:
                share = 0.0
            elif perspective:
                share = (1 / near - 1 / distance) / (1 / near - 1 / far)
            else:
                share = (distance - near) / (far - near)
            out.depth[row, corner] = min(max(share, 0.0), 1.0) * full
            out.weight[row, corner] = 1 / coordinates[vertex, DIVISOR]
            out.vertices[row, corner, 0] = vertices[vertex, 0]
            out.vertices[row, corner, 1] = vertices[vertex, 1]
            for axis in range(3):
                part = normal[chosen[row], corner, axis]
                out.position[row, corner, axis] = position[vertex, axis]
                out.normal[row, corner, axis] = -part if back else part
