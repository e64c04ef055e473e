# SPDX-License-Identifier: Apache-2.0
"""Levels of detail: a generated scene in fewer triangles of the same kind, any other mesh decimated."""

from __future__ import annotations

import math
from pathlib import Path

from quadshade.errors import QuadshadeError
from quadshade.scene.decimate import LEAST, check_count, decimate
from quadshade.scene.files import is_generated, load_scene
from quadshade.scene.generate import grid_of
from quadshade.scene.mesh import Mesh

STEP = 2
"""Triangles of a level, over those of the next."""


def level_of_detail(
    mesh: Mesh, count: int, scene: str | Path | None = None, crease: float | None = None
) -> Mesh:
    """
    A scene in at most so many triangles.

    Parameters
    ----------
    mesh : Mesh
      The scene with all of them.
    count : int
      From 4 to as many as it has.
    scene : str or Path, optional
      Its name: a generated scene (``sphere:690``) has its own tessellation for every count.
    crease : float, optional
      As for :func:`quadshade.scene.load_scene`, of a generated scene.

    Returns
    -------
    Mesh

    Raises
    ------
    QuadshadeError
      A count out of range, or a mesh that cannot be drawn in so few triangles.
    """
    check_count(count, len(mesh))
    if count == len(mesh):
        return mesh
    if scene is not None and is_generated(scene):
        return load_scene(coarser_name(str(scene), count), crease)
    return decimate(mesh, count)


def levels(count: int) -> list[int]:
    """Counts of triangles to try for a mesh, falling, from the one after its own."""
    steps = int(math.log(max(count, LEAST) / LEAST, STEP))
    return [count // STEP**step for step in range(1, steps + 1)]


def coarser_name(scene: str, count: int) -> str:
    """
    The generated scene of the same kind and proportions with the most triangles, at most a count.

    Parameters
    ----------
    scene : str
      ``sphere:690``, say.
    count : int

    Returns
    -------
    str
      ``sphere:13x14``, say.

    Raises
    ------
    QuadshadeError
      There is none.
    """
    kind, _, size = scene.partition(":")
    if kind == "icosphere":
        level = int(size)
        while level >= 0 and 20 * 4**level > count:
            level -= 1
        names = [f"icosphere:{level}"] if level >= 0 else []
    elif kind == "cube":
        divisions = math.isqrt(count // 12)
        names = [f"cube:{divisions}"] if divisions else []
    else:
        names = [f"{kind}:{rows}x{columns}" for rows, columns in _grids(scene, count)]
    if not names:
        least = {"sphere": 6, "torus": 18, "icosphere": 20, "cube": 12}[kind]
        raise QuadshadeError(f"--lod {count}: no {kind} has so few triangles", f"give at least {least}")
    return names[0]


def _grids(scene: str, count: int) -> list[tuple[int, int]]:
    """Stacks and slices, or rings and sides: at most one pair, nearest to the count and the proportions."""
    rows, columns = grid_of(scene)
    least, poles = (2, 1) if scene.startswith("sphere") else (3, 0)
    best: list[tuple[float, int, int]] = []
    for fewer in range(least, rows + 1):
        across = min(count // 2 // (fewer - poles), columns)
        if across >= 3:
            missing = math.log(count / (2 * across * (fewer - poles)))
            shape = abs(math.log((fewer / across) / (rows / columns)))
            best.append((missing + shape, fewer, across))
    return [min(best)[1:]] if best else []
