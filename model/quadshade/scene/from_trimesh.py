# SPDX-License-Identifier: Apache-2.0
"""A mesh from one of trimesh's objects."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from quadshade.errors import QuadshadeError
from quadshade.scene.mesh import Mesh, build_mesh, merge_vertices

if TYPE_CHECKING:
    import trimesh


def mesh_from_trimesh(given: trimesh.Trimesh | trimesh.Scene, crease: float | None = None) -> Mesh:
    """
    The mesh that one of trimesh's objects holds.

    Parameters
    ----------
    given : trimesh.Trimesh or trimesh.Scene
      A scene's parts are joined, each where the scene places it.
    crease : float, optional
      As for :func:`quadshade.scene.load_scene`. Not given: the normals that the object holds, which are those
      of the file or those that trimesh has been asked for; an object without any gets a crease of 60 degrees.

    Returns
    -------
    Mesh

    Raises
    ------
    QuadshadeError
      Neither of the two, or a mesh that cannot be drawn.
    """
    import trimesh

    if isinstance(given, trimesh.Scene):
        given = given.to_mesh()
    if not isinstance(given, trimesh.Trimesh):
        kind = type(given).__name__
        raise QuadshadeError(
            f"the scene is of type {kind}", "give a path, a name, a Mesh or a trimesh.Trimesh"
        )
    vertices = np.array(given.vertices, dtype=np.float64)
    faces = np.array(given.faces, dtype=np.int64)
    if faces.size and (faces.min() < 0 or faces.max() >= len(vertices)):
        raise QuadshadeError("a face names a vertex that does not exist", "repair the mesh")
    normals = None
    # trimesh computes the normals of a mesh that has none; only its cache tells which they are.
    if "vertex_normals" in given._cache.cache:
        normals = np.array(given.vertex_normals, dtype=np.float64)[faces]
    colours = _corner_colours(given, faces)
    if crease is not None or normals is None:
        vertices, faces = merge_vertices(vertices, faces)
    return build_mesh(vertices, faces, normals, crease, colours)


def _corner_colours(given: trimesh.Trimesh, faces: np.ndarray) -> np.ndarray | None:
    """(n, 3, 3) float64 colours of the faces' corners, 0 .. 1, or None where the object has none."""
    # The types of trimesh's two kinds of visuals have nothing in common; `kind` tells them apart.
    visual: Any = given.visual
    if visual is None or not visual.defined:
        return None
    if visual.kind == "face":
        return np.repeat(visual.face_colors[:, None, :3] / 255.0, 3, axis=1)
    colours = visual.to_color().vertex_colors if visual.kind == "texture" else visual.vertex_colors
    return np.asarray(colours)[:, :3][faces] / 255.0 if len(colours) == len(given.vertices) else None
