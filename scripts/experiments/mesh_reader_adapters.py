# SPDX-License-Identifier: Apache-2.0
"""Other readers of mesh files behind one function each: a file's path in, a mesh out."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from quadshade.scene import Mesh, build_mesh, load_scene
from quadshade.scene.readers.polygons import triangulate
from quadshade.scene.readers.texture import Texture, read_texels

OTHERS = {
    "assimp": ["assimp-py==1.1.0"],
    "tinyobjloader": ["tinyobjloader==2.0.0rc13"],
    "meshio": ["meshio==5.3.5"],
}
"""What pip is asked for, without dependencies: NumPy and rich are there."""


def _joined(parts: list[tuple[np.ndarray, np.ndarray | None]]) -> Mesh:
    """A mesh of parts' (n, 3, 3) corners and colours; white where only some have colours."""
    corners = np.concatenate([corner for corner, _ in parts]).astype(np.float64)
    colours = None
    if any(colour is not None for _, colour in parts):
        colours = np.concatenate([np.ones_like(c) if k is None else k for c, k in parts]).astype(np.float64)
    faces = np.arange(3 * len(corners)).reshape(-1, 3)
    return build_mesh(corners.reshape(-1, 3), faces, colours=colours)


def _textured(path: Path, name: str, places: np.ndarray) -> np.ndarray:
    """(n, 3, 3) colours of a picture beside the file, at places that count upwards."""
    texels = read_texels((path.parent / name).read_bytes(), name)
    return Texture(texels).at_corners(np.stack([places[..., 0], 1 - places[..., 1]], axis=-1))[..., :3]


def read_trimesh(path: Path) -> Mesh:
    """trimesh, as its own conversion to colours shows it."""
    import trimesh

    scene = trimesh.load_scene(path, process=False)
    parts: list[tuple[np.ndarray, np.ndarray | None]] = []
    for node in scene.graph.nodes_geometry:
        matrix, name = scene.graph[node]
        part = scene.geometry[name]
        if not isinstance(part, trimesh.Trimesh):
            continue
        faces = np.asarray(part.faces)
        if np.linalg.det(matrix[:3, :3]) < 0:
            faces = faces[:, ::-1]
        vertices = np.asarray(part.vertices) @ matrix[:3, :3].T + matrix[:3, 3]
        colours = None
        if part.visual.defined and part.visual.kind == "face":
            colours = np.repeat(part.visual.face_colors[:, None, :3] / 255.0, 3, axis=1)
        elif part.visual.defined:
            visual: Any = part.visual
            listed = visual.to_color().vertex_colors if visual.kind == "texture" else visual.vertex_colors
            colours = np.asarray(listed)[:, :3][faces] / 255.0
        parts.append((vertices[faces], colours))
    return _joined(parts)


def read_assimp(path: Path) -> Mesh:
    """Assimp through assimp-py: vertex colours times the diffuse colour, and textures that are files."""
    import assimp_py

    steps = assimp_py.Process_Triangulate | assimp_py.Process_PreTransformVertices
    scene = assimp_py.import_file(str(path), steps)
    parts: list[tuple[np.ndarray, np.ndarray | None]] = []
    for mesh in scene.meshes:
        if not mesh.num_faces or mesh.num_indices != 3 * mesh.num_faces:
            continue
        faces = np.asarray(mesh.indices).reshape(-1, 3)
        vertices = np.asarray(mesh.vertices).reshape(-1, 3)
        material = scene.materials[mesh.material_index]
        colours = None
        if material.get("NAME") not in (None, "", "DefaultMaterial") or path.suffix in (".glb", ".gltf"):
            colours = np.broadcast_to(np.array(material["COLOR_DIFFUSE"])[:3], (*faces.shape, 3))
        if mesh.colors:
            own = np.asarray(mesh.colors[0]).reshape(len(vertices), -1)[:, :3][faces]
            colours = own if colours is None else own * colours
        files = [names[0] for kind, names in material["TEXTURES"].items() if kind == 1]
        if files and mesh.texcoords:
            places = np.asarray(mesh.texcoords[0]).reshape(len(vertices), -1)[:, :2][faces]
            texels = _textured(path, files[0], places)
            colours = texels if colours is None else texels * colours
        parts.append((vertices[faces], colours))
    return _joined(parts)


def read_tinyobjloader(path: Path) -> Mesh:
    """tinyobjloader, which triangulates too."""
    import tinyobjloader

    config = tinyobjloader.ObjReaderConfig()
    config.triangulate = True
    reader = tinyobjloader.ObjReader()
    if not reader.ParseFromFile(str(path), config):
        raise ValueError(reader.Error())
    listed, materials = reader.GetAttrib(), reader.GetMaterials()
    vertices = np.array(listed.vertices).reshape(-1, 3)
    own = np.array(listed.colors).reshape(-1, 3)
    places = np.array(listed.texcoords).reshape(-1, 2)
    parts: list[tuple[np.ndarray, np.ndarray | None]] = []
    for shape in reader.GetShapes():
        index = shape.mesh.indices
        if not len(index):
            continue
        faces = np.array([corner.vertex_index for corner in index]).reshape(-1, 3)
        uv = np.array([corner.texcoord_index for corner in index]).reshape(-1, 3)
        # It gives white to vertices without a colour, so that white is none.
        colours = None if (own == 1).all() else own[faces]
        for number in sorted(set(shape.mesh.material_ids)):
            chosen = np.array(shape.mesh.material_ids) == number
            painted = None if colours is None else colours[chosen]
            if number >= 0:
                material = materials[number]
                painted = np.ones((*faces[chosen].shape, 3)) if painted is None else painted
                if material.diffuse_texname:
                    painted = painted * _textured(path, material.diffuse_texname, places[uv[chosen]])
                else:
                    painted = painted * np.array(material.diffuse)
            parts.append((vertices[faces[chosen]], painted))
    return _joined(parts)


def read_meshio(path: Path) -> Mesh:
    """meshio, its polygons through Quadshade's ear clipper."""
    import meshio

    mesh = meshio.read(path)
    points = np.asarray(mesh.points, dtype=np.float64)
    data = mesh.point_data
    colours = None
    if {"red", "green", "blue"} <= set(data):
        channels = np.stack([data["red"], data["green"], data["blue"]], axis=1)
        colours = channels / (255.0 if channels.dtype.kind == "u" else 1.0)
    parts: list[tuple[np.ndarray, np.ndarray | None]] = []
    for block in mesh.cells:
        if block.type not in ("triangle", "quad") and not block.type.startswith("polygon"):
            continue
        corners = np.concatenate([np.asarray(cell, dtype=np.int64) for cell in block.data])
        counts = np.array([len(cell) for cell in block.data], dtype=np.int64)
        index, _, _ = triangulate(points[corners], counts)
        faces = corners[index]
        parts.append((points[faces], None if colours is None else colours[faces]))
    return _joined(parts)


ADAPTERS: dict[str, tuple[tuple[str, ...], Callable[[Path], Mesh]]] = {
    "quadshade": (("obj", "ply", "off", "stl", "glb", "gltf"), load_scene),
    "trimesh": (("obj", "ply", "off", "stl", "glb", "gltf"), read_trimesh),
    "assimp": (("obj", "ply", "off", "stl", "glb", "gltf"), read_assimp),
    "tinyobjloader": (("obj",), read_tinyobjloader),
    "meshio": (("obj", "ply", "off", "stl"), read_meshio),
}
"""The formats of each reader, and its function."""
