# SPDX-License-Identifier: Apache-2.0
"""A mesh from one of trimesh's objects."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from quadshade.errors import QuadshadeError
from quadshade.scene.mesh import Mesh, build_mesh, merge_vertices
from quadshade.scene.readers.texture import Texture

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
    sides = getattr(getattr(given.visual, "material", None), "doubleSided", None)
    double_sided = np.full(len(faces), True) if sides else None
    return build_mesh(vertices, faces, normals, crease, colours, double_sided)


def _corner_colours(given: trimesh.Trimesh, faces: np.ndarray) -> np.ndarray | None:
    """(n, 3, 3) float64 colours of the faces' corners, 0 .. 1, or None where the object has none."""
    # The types of trimesh's two kinds of visuals have nothing in common; `kind` tells them apart.
    visual: Any = given.visual
    if visual is None or not visual.defined:
        return None
    if visual.kind == "face":
        return np.repeat(visual.face_colors[:, None, :3] / 255.0, 3, axis=1)
    if visual.kind == "texture":
        return _material_colours(visual, faces)
    colours = np.asarray(visual.vertex_colors)
    return colours[:, :3][faces] / 255.0 if len(colours) == len(given.vertices) else None


def _material_colours(visual: Any, faces: np.ndarray) -> np.ndarray:
    """(n, 3, 3) colours of corners: the material's factor, texture and the vertices' own, multiplied."""
    material = visual.material
    factor, image = (
        _first(material, "baseColorFactor", "diffuse"),
        _first(material, "baseColorTexture", "image"),
    )
    levels = np.ones(3) if factor is None else np.asarray(factor, dtype=np.float64)[:3]
    if factor is not None and np.asarray(factor).dtype.kind == "u":
        levels = levels / 255.0
    colours = np.broadcast_to(levels, (*faces.shape, 3))
    if image is not None:
        if visual.uv is None:
            raise QuadshadeError("a textured mesh has no texture coordinates", "give its visual a uv")
        places = np.asarray(visual.uv, dtype=np.float64)[faces]
        texels = np.asarray(image.convert("RGBA"), dtype=np.float64) / 255.0
        # Texture coordinates count upwards from the picture's lower edge.
        down = np.stack([places[..., 0], 1 - places[..., 1]], axis=-1)
        colours = colours * Texture(texels).at_corners(down)[..., :3]
    own = getattr(visual, "vertex_attributes", {}).get("color")
    if own is not None:
        own = np.asarray(own)
        colours = colours * own[:, :3][faces] / (255.0 if own.dtype.kind == "u" else 1.0)
    return colours


def _first(material: object, *names: str) -> Any:
    """The first attribute of these that is there and not None."""
    return next((value for name in names if (value := getattr(material, name, None)) is not None), None)
