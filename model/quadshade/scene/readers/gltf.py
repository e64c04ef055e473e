# SPDX-License-Identifier: Apache-2.0
"""glTF 2.0 and GLB: nodes, primitives, morph targets and skins, as they stand before any animation."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

import numpy as np

from quadshade.errors import QuadshadeError
from quadshade.scene.readers.gltf_accessor import read_accessor, read_indices
from quadshade.scene.readers.gltf_file import GltfFile, Item, open_gltf
from quadshade.scene.readers.gltf_material import Material, read_material
from quadshade.scene.readers.part import (
    MOST_TRIANGLES,
    MeshFile,
    Part,
    check_colours,
    check_faces,
    check_finite,
    plural,
)
from quadshade.scene.readers.ply import strip_faces

POINTS, TRIANGLES, STRIP, FAN = 0, 4, 5, 6
IDENTITY = tuple(np.eye(4).ravel().tolist())


def read_gltf(data: bytes, fetch: Callable[[str], bytes]) -> MeshFile:
    """
    The meshes of a glTF file's scene.

    Parameters
    ----------
    data : bytes
    fetch : callable
      The content of a file beside this one, by its name.

    Returns
    -------
    MeshFile
      A part for every primitive of every node that has a mesh.

    Raises
    ------
    QuadshadeError
      A malformed file, or one that requires what is not read.
    """
    file, notes = open_gltf(data, fetch)
    return _Scene(file, notes).read()


class _Scene:
    """A glTF file while its scene is read."""

    def __init__(self, file: GltfFile, notes: list[str]) -> None:
        self.file, self.notes = file, notes
        self.skipped: Counter[str] = Counter()
        self.materials: dict[int, Material] = {}
        self.matrices: dict[int, np.ndarray] = {}
        self.triangles = 0

    def read(self) -> MeshFile:
        """Everything that the scene shows."""
        parts = []
        for index in self._place_nodes():
            node = self.file.pick("nodes", index)
            if "mesh" not in node:
                continue
            if node.extension("EXT_mesh_gpu_instancing") is not None:
                raise QuadshadeError(
                    "it has EXT_mesh_gpu_instancing, which is not read", "save its instances as nodes"
                )
            mesh = self.file.pick("meshes", node.whole("mesh"))
            weights = node.list_of_numbers("weights") or mesh.list_of_numbers("weights")
            for primitive in mesh.items("primitives"):
                part = self._primitive(primitive, node, self.matrices[index], weights)
                if part is not None:
                    parts.append(part)
        if self.file.root.items("animations"):
            self.notes.append("animations not played: drawn as its nodes stand")
        self.notes += [f"{plural(count, what)} not drawn" for what, count in self.skipped.items()]
        self.notes += [
            f"the material {index} is transparent: drawn opaque"
            for index, material in self.materials.items()
            if material.transparent
        ]
        return MeshFile(parts, self.notes)

    def _place_nodes(self) -> list[int]:
        """The nodes of the scene, parents first; sets their matrices."""
        root = self.file.root
        scenes = root.items("scenes")
        if scenes:
            first = self.file.pick("scenes", root.whole("scene", 0)).wholes("nodes")
        else:
            children = {child for node in root.items("nodes") for child in node.wholes("children")}
            first = [index for index in range(len(root.items("nodes"))) if index not in children]
        order: list[int] = []
        stack = [(index, np.eye(4), True) for index in reversed(first)]
        while stack:
            index, above, shown = stack.pop()
            if index in self.matrices:
                raise QuadshadeError(f"its node {index} has two parents, or is its own", "repair the mesh")
            node = self.file.pick("nodes", index)
            self.matrices[index] = above @ _local_matrix(node)
            visibility = node.extension("KHR_node_visibility")
            shown = shown and (visibility is None or visibility.flag("visible", True))
            if shown:
                order.append(index)
            stack += [(child, self.matrices[index], shown) for child in reversed(node.wholes("children"))]
        return order

    def _primitive(self, item: Item, node: Item, matrix: np.ndarray, weights: list[float]) -> Part | None:
        """A primitive of a node; None for points and lines."""
        mode = item.whole("mode", TRIANGLES)
        if mode not in (TRIANGLES, STRIP, FAN):
            if mode > FAN:
                raise QuadshadeError(f"its {item.name} has the mode {mode}", "repair the mesh")
            self.skipped["primitive of points or lines/primitives of points or lines"] += 1
            return None
        attributes = item.item("attributes")
        if "POSITION" not in attributes:
            self.skipped["primitive without positions/primitives without positions"] += 1
            return None
        _check_draco(self.file, item, attributes)
        vertices = self._morphed(item, attributes, "POSITION", weights)
        faces = self._faces(item, mode, len(vertices))
        self.triangles += len(faces)
        if self.triangles > MOST_TRIANGLES:
            raise QuadshadeError(f"it has more than {MOST_TRIANGLES} triangles", "give a smaller mesh")
        normals = self._morphed(item, attributes, "NORMAL", weights) if "NORMAL" in attributes else None
        for name, array in (("NORMAL", normals),):
            if array is not None and len(array) != len(vertices):
                raise QuadshadeError(
                    f"its {name} has {len(array)} rows for {len(vertices)}", "repair the mesh"
                )
        check_finite(vertices)
        colours, double_sided = self._colours(item, attributes, faces, len(vertices), weights)
        if "skin" in node and "JOINTS_0" in attributes:
            matrices = self._skin_matrices(node.whole("skin"), attributes, len(vertices))
        else:
            matrices = matrix[None]
        return _placed(vertices, faces, normals, colours, matrices, double_sided)

    def _faces(self, item: Item, mode: int, count: int) -> np.ndarray:
        """(n, 3) triangles of a primitive."""
        indices = read_indices(self.file, item.whole("indices")) if "indices" in item else np.arange(count)
        if mode == STRIP:
            faces = strip_faces(indices)
        elif mode == FAN:
            step = np.arange(1, max(len(indices) - 1, 1))
            faces = (
                np.stack([indices[step], indices[step + 1], np.full(len(step), indices[0])], axis=1)
                if len(indices) >= 3
                else np.empty((0, 3), np.int64)
            )
        else:
            if len(indices) % 3:
                raise QuadshadeError(
                    f"its {item.name} has {len(indices)} corners of triangles", "repair the mesh"
                )
            faces = indices.reshape(-1, 3)
        check_faces(faces, count)
        return faces

    def _rows(self, index: int, kinds: tuple[str, ...], count: int) -> np.ndarray:
        """An attribute's numbers, as many as there are vertices."""
        values = read_accessor(self.file, index, kinds)
        if len(values) != count:
            raise QuadshadeError(
                f"its accessor {index} has {len(values)} rows for {count} vertices", "repair the mesh"
            )
        return values

    def _morphed(self, item: Item, attributes: Item, name: str, weights: list[float]) -> np.ndarray:
        """(m, c) numbers of an attribute, moved by the morph targets."""
        kinds = ("VEC3", "VEC4") if name == "COLOR_0" else ("VEC3",)
        values = read_accessor(self.file, attributes.whole(name), kinds)
        for weight, target in zip(weights, item.items("targets"), strict=False):
            if weight and name in target:
                values = values + weight * self._rows(target.whole(name), kinds, len(values))
        return values

    def _colours(
        self, item: Item, attributes: Item, faces: np.ndarray, count: int, weights: list[float]
    ) -> tuple[np.ndarray | None, bool]:
        """(n, 3, 3) colours of corners, if any are given, and whether both sides are seen."""
        own = None
        if "COLOR_0" in attributes:
            own = self._morphed(item, attributes, "COLOR_0", weights)[:, :3]
            if len(own) != count or not np.isfinite(own).all():
                raise QuadshadeError(f"its {item.name} has a vertex without a colour", "repair the mesh")
            check_colours(own, "a vertex has a colour")
        if "material" not in item:
            return None if own is None else own[faces], False
        index = item.whole("material")
        if index not in self.materials:
            self.materials[index] = read_material(self.file, index)
        material = self.materials[index]

        def places(number: int) -> np.ndarray:
            name = f"TEXCOORD_{number}"
            if name not in attributes:
                raise QuadshadeError(f"its {item.name} has a texture and no {name}", "repair the mesh")
            return self._rows(attributes.whole(name), ("VEC2",), count)

        return material.colours(faces, places, own), material.double_sided

    def _skin_matrices(self, index: int, attributes: Item, count: int) -> np.ndarray:
        """(m, 4, 4): where the joints move each vertex."""
        skin = self.file.pick("skins", index)
        joints = skin.wholes("joints")
        lost = [joint for joint in joints if joint not in self.matrices]
        if lost or not joints:
            raise QuadshadeError(f"its {skin.name} has a joint outside the scene", "repair the mesh")
        moved = np.stack([self.matrices[joint] for joint in joints])
        if "inverseBindMatrices" in skin:
            # Columns come first in the file.
            inverse = read_accessor(self.file, skin.whole("inverseBindMatrices"), ("MAT4",))
            if len(inverse) < len(joints):
                raise QuadshadeError(f"its {skin.name} has too few inverse bind matrices", "repair the mesh")
            moved = moved @ inverse[: len(joints)].reshape(-1, 4, 4).transpose(0, 2, 1)
        total = np.zeros((count, 4, 4))
        number = 0
        while f"JOINTS_{number}" in attributes and f"WEIGHTS_{number}" in attributes:
            names = self._rows(attributes.whole(f"JOINTS_{number}"), ("VEC4",), count).astype(np.int64)
            weights = self._rows(attributes.whole(f"WEIGHTS_{number}"), ("VEC4",), count)
            if names.size and (names.min() < 0 or names.max() >= len(joints)):
                raise QuadshadeError(
                    f"a vertex names joint {names.max()} of {len(joints)}", "repair the mesh"
                )
            for column in range(4):
                total += weights[:, column, None, None] * moved[names[:, column]]
            number += 1
        return total


def _check_draco(file: GltfFile, item: Item, attributes: Item) -> None:
    """Refuse compressed data for which the file has no other."""
    if item.extension("KHR_draco_mesh_compression") is None:
        return
    position = file.pick("accessors", attributes.whole("POSITION"))
    if "bufferView" not in position and "sparse" not in position:
        raise QuadshadeError(
            "it is compressed with KHR_draco_mesh_compression, which is not read", "decompress it"
        )


def _local_matrix(node: Item) -> np.ndarray:
    """(4, 4) of a node: its matrix, columns first, or translation, rotation (a quaternion) and scale."""
    if "matrix" in node:
        return np.array(node.numbers("matrix", IDENTITY)).reshape(4, 4).T
    x, y, z, w = node.numbers("rotation", (0.0, 0.0, 0.0, 1.0))
    length = np.sqrt(x * x + y * y + z * z + w * w)
    if not length > 0:
        raise QuadshadeError(f"its {node.name} has a rotation of zeros", "repair the mesh")
    x, y, z, w = x / length, y / length, z / length, w / length
    matrix = np.eye(4)
    matrix[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    matrix[:3, :3] *= node.numbers("scale", (1.0, 1.0, 1.0))
    matrix[:3, 3] = node.numbers("translation", (0.0, 0.0, 0.0))
    return matrix


def _placed(
    vertices: np.ndarray,
    faces: np.ndarray,
    normals: np.ndarray | None,
    colours: np.ndarray | None,
    matrices: np.ndarray,
    double_sided: bool,
) -> Part:
    """A part moved by (1, 4, 4) or (m, 4, 4) matrices; a mirror turns its faces, to look outward."""
    corner_normals = None if normals is None else normals[faces]
    if not np.array_equal(matrices[0], np.eye(4)) or len(matrices) > 1:
        linear = matrices[:, :3, :3]
        vertices = _times(linear, vertices) + matrices[:, :3, 3]
        if normals is not None:
            corner_normals = _times(np.linalg.pinv(linear).transpose(0, 2, 1), normals)[faces]
        mirrored = np.broadcast_to(np.linalg.det(linear) < 0, len(vertices))[faces[:, 0]]
        turn = np.where(mirrored[:, None], [2, 1, 0], [0, 1, 2])
        rows = np.arange(len(faces))[:, None]
        faces = faces[rows, turn]
        corner_normals = None if corner_normals is None else corner_normals[rows, turn]
        colours = None if colours is None else colours[rows, turn]
    return Part(vertices, faces, corner_normals, colours, double_sided)


def _times(linear: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """(m, 3) vectors by one (1, 3, 3) or their own (m, 3, 3) matrices."""
    if len(linear) == 1:
        return vectors @ linear[0].T
    return np.einsum("nij,nj->ni", linear, vectors)
