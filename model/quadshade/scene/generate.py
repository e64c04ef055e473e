# SPDX-License-Identifier: Apache-2.0
"""
Generated scenes: ``sphere:168``, ``sphere:12x17``, ``torus:288``, ``torus:16x9``, ``icosphere:3``,
``cube:2``.

The latitude-longitude spheres of 7 x 14, 12 x 17 and 16 x 23 stacks and slices have the 168, 374 and 690
triangles of Abbas et al., section 6.
"""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Callable

import numpy as np

from quadshade.errors import QuadshadeError
from quadshade.scene.mesh import Mesh, merge_vertices

MAX_TRIANGLES = 5_000_000
EXAMPLES = "sphere:168, sphere:12x17, torus:288, torus:16x9, icosphere:3, cube:2"
TORUS_RADIUS, TUBE_RADIUS = 1.0, 0.4


WORST_ASPECT = 4.0
"""A count that divides only into triangles longer than this, against the best shape, is refused."""


def generate(scene: str) -> Mesh:
    """
    The mesh that a scene's name asks for.

    Parameters
    ----------
    scene : str
      ``kind:count`` or ``kind:AxB``.

    Returns
    -------
    Mesh
      Of radius 1 around the origin (the torus: of the circle inside its tube), with its exact normals.

    Raises
    ------
    QuadshadeError
      An unknown kind, or a count that no such mesh has; the message names the nearest that are possible.
    """
    kind, _, size = scene.partition(":")
    if kind not in ("sphere", "torus", "icosphere", "cube") or not re.fullmatch(
        r"[0-9]{1,9}(x[0-9]{1,9})?", size
    ):
        raise QuadshadeError(f"{scene!r} is not a scene that can be generated", f"examples: {EXAMPLES}")
    numbers = tuple(int(number) for number in size.split("x"))
    if kind == "icosphere":
        if len(numbers) != 1 or numbers[0] > 8:
            raise QuadshadeError(
                f"{scene!r} is not an icosphere", "give 0 to 8 subdivisions, e.g. icosphere:3"
            )
        return icosphere(numbers[0])
    if kind == "cube":
        if len(numbers) != 1 or numbers[0] < 1:
            raise QuadshadeError(f"{scene!r} is not a cube", "give the divisions of an edge, e.g. cube:2")
        return cube(numbers[0])
    return (sphere if kind == "sphere" else torus)(*grid_of(scene))


def grid_of(scene: str) -> tuple[int, int]:
    """
    Stacks and slices of a sphere, rings and sides of a torus.

    Parameters
    ----------
    scene : str
      ``sphere:690`` or ``torus:16x9``, say.

    Raises
    ------
    QuadshadeError
      As for :func:`generate`.
    """
    kind, _, size = scene.partition(":")
    numbers = [int(number) for number in size.split("x")]
    if len(numbers) == 2:
        return numbers[0], numbers[1]
    return _divide(scene, numbers[0], _sphere_divisions if kind == "sphere" else _torus_divisions)


def _sphere_divisions(count: int) -> list[tuple[float, int, int]]:
    """All (distance from the best shape, stacks, slices) with 2 * slices * (stacks - 1) == count."""
    pairs = [(rows + 1, count // 2 // rows) for rows in _divisors(count)]
    return [(abs(math.log(slices / stacks / 2)), stacks, slices) for stacks, slices in pairs if slices >= 3]


def _torus_divisions(count: int) -> list[tuple[float, int, int]]:
    """All (distance from the best shape, rings, sides) with 2 * rings * sides == count."""
    pairs = [(rings, count // 2 // rings) for rings in _divisors(count)]
    return [
        (abs(math.log(rings / sides / 1.6)), rings, sides) for rings, sides in pairs if min(rings, sides) >= 3
    ]


def _divisors(count: int) -> list[int]:
    """Divisors of half the count; none of an odd one."""
    if count % 2 or count < 2:
        return []
    half = count // 2
    small = [number for number in range(1, math.isqrt(half) + 1) if half % number == 0]
    return sorted({*small, *(half // number for number in small)})


def _divide(
    scene: str, count: int, divisions: Callable[[int], list[tuple[float, int, int]]]
) -> tuple[int, int]:
    """The best two numbers that make exactly ``count`` triangles."""
    _check_count(scene, count)

    def possible(number: int) -> list[tuple[float, int, int]]:
        return [division for division in divisions(number) if division[0] <= math.log(WORST_ASPECT)]

    found = possible(count)
    if not found:
        below = next((number for number in range(count - 1, 0, -1) if possible(number)), None)
        above = next(number for number in itertools.count(count + 1) if possible(number))
        nearest = f"nearest counts are {below} and {above}" if below else f"least count is {above}"
        raise QuadshadeError(f"{scene}: no such mesh has {count} triangles", f"the {nearest}")
    return min(found)[1:]


def _check_count(scene: str, count: int) -> None:
    """Refuse what would not fit the memory."""
    if count > MAX_TRIANGLES:
        raise QuadshadeError(f"{scene} has {count} triangles", f"give at most {MAX_TRIANGLES}")


def sphere(stacks: int, slices: int) -> Mesh:
    """
    A latitude-longitude sphere of radius 1, poles on the y axis.

    Parameters
    ----------
    stacks, slices : int
      At least 2 and 3; 2 * slices * (stacks - 1) triangles.

    Returns
    -------
    Mesh
    """
    if stacks < 2 or slices < 3:
        raise QuadshadeError(f"a sphere of {stacks}x{slices}", "give at least 2 stacks and 3 slices")
    _check_count(f"sphere:{stacks}x{slices}", 2 * slices * (stacks - 1))
    polar = np.pi * np.arange(1, stacks) / stacks
    around = 2 * np.pi * np.arange(slices) / slices
    rings = np.stack(
        [
            np.outer(np.sin(polar), np.sin(around)),
            np.outer(np.cos(polar), np.ones(slices)),
            np.outer(np.sin(polar), np.cos(around)),
        ],
        axis=-1,
    )
    vertices = np.concatenate([rings.reshape(-1, 3), [[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]]])
    top, bottom = len(vertices) - 2, len(vertices) - 1
    here = np.arange(slices)
    beside = (here + 1) % slices
    last = (stacks - 2) * slices
    faces = np.concatenate(
        [
            np.stack([np.full(slices, top), here, beside], axis=1),
            _quads(np.arange(stacks - 2)[:, None], here[None, :], slices, (stacks - 1)),
            np.stack([np.full(slices, bottom), last + beside, last + here], axis=1),
        ]
    )
    return Mesh(vertices, faces, vertices[faces])


def torus(rings: int, sides: int) -> Mesh:
    """
    A torus around the z axis: a tube of radius 0.4 around a circle of radius 1.

    Parameters
    ----------
    rings, sides : int
      Divisions along the circle and around the tube, each at least 3; 2 * rings * sides triangles.

    Returns
    -------
    Mesh
    """
    if rings < 3 or sides < 3:
        raise QuadshadeError(f"a torus of {rings}x{sides}", "give at least 3 rings and 3 sides")
    _check_count(f"torus:{rings}x{sides}", 2 * rings * sides)
    along = (2 * np.pi * np.arange(rings) / rings)[:, None]
    around = (2 * np.pi * np.arange(sides) / sides)[None, :]
    outward = np.stack(
        [np.cos(along) * np.cos(around), np.sin(along) * np.cos(around), np.sin(around) + 0 * along], axis=-1
    )
    centre = np.stack([np.cos(along), np.sin(along), 0 * along], axis=-1)
    vertices = (TORUS_RADIUS * centre + TUBE_RADIUS * outward).reshape(-1, 3)
    faces = _quads(np.arange(rings)[:, None], np.arange(sides)[None, :], sides, rings)
    return Mesh(vertices, faces, outward.reshape(-1, 3)[faces])


def icosphere(subdivisions: int) -> Mesh:
    """
    A sphere of radius 1 from a subdivided icosahedron.

    Parameters
    ----------
    subdivisions : int
      0 to 8; 20 * 4**subdivisions triangles.

    Returns
    -------
    Mesh
    """
    from trimesh.creation import icosphere as subdivided

    made = subdivided(subdivisions=subdivisions)
    vertices = np.array(made.vertices) / np.linalg.norm(made.vertices, axis=1, keepdims=True)
    faces = np.array(made.faces, dtype=np.int64)
    return Mesh(vertices, faces, vertices[faces])


def cube(divisions: int) -> Mesh:
    """
    A cube from -1 to 1 with sharp edges.

    Parameters
    ----------
    divisions : int
      Of an edge, at least 1; 12 * divisions**2 triangles.

    Returns
    -------
    Mesh
    """
    _check_count(f"cube:{divisions}", 12 * divisions**2)
    # Symmetric to the last bit, so that sides meet in the same vertices.
    step = (2 * np.arange(divisions + 1) - divisions) / divisions
    down, across = (grid.ravel() for grid in np.meshgrid(step, step, indexing="ij"))
    row, column = np.divmod(np.arange(divisions**2), divisions)
    corner = row * (divisions + 1) + column
    below = corner + divisions + 1
    first, second = (corner, below, corner + 1), (below, below + 1, corner + 1)
    side = np.stack([np.stack(first, axis=-1), np.stack(second, axis=-1)], axis=1).reshape(-1, 3)
    vertices: list[np.ndarray] = []
    faces: list[np.ndarray] = []
    normals: list[np.ndarray] = []
    for axis in range(3):
        for sign in (1, -1):
            plane = np.empty((len(down), 3))
            plane[:, axis], plane[:, axis - 2], plane[:, axis - 1] = sign, down, sign * across
            faces.append(side + len(down) * len(vertices))
            vertices.append(plane)
            normals.append(np.broadcast_to(sign * np.eye(3)[axis], (len(side), 3, 3)))
    joined = merge_vertices(np.concatenate(vertices), np.concatenate(faces))
    return Mesh(*joined, np.concatenate(normals))


def _quads(row: np.ndarray, column: np.ndarray, columns: int, rows: int) -> np.ndarray:
    """(2 * quads, 3) faces of a grid of vertices that closes in both directions, two to a quad."""
    beside = (column + 1) % columns
    below = (row + 1) % rows
    upper_left, upper_right = row * columns + column, row * columns + beside
    lower_left, lower_right = below * columns + column, below * columns + beside
    first = np.stack([upper_left, lower_left, upper_right], axis=-1)
    second = np.stack([upper_right, lower_left, lower_right], axis=-1)
    return np.stack([first, second], axis=-2).reshape(-1, 3)
