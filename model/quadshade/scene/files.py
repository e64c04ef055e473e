# SPDX-License-Identifier: Apache-2.0
"""Mesh files (OBJ, PLY, STL, GLB) through trimesh, and the one entry point for all scenes."""

from __future__ import annotations

import re
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from quadshade.errors import QuadshadeError
from quadshade.scene.generate import EXAMPLES, generate
from quadshade.scene.mesh import Mesh, build_mesh, merge_vertices

if TYPE_CHECKING:
    import trimesh

TEXT_SUFFIXES = (".obj", ".off")
SUFFIXES = (".obj", ".ply", ".stl", ".glb", ".gltf", ".off")
VERTEX_0 = re.compile(r"^[ \t]*+f(?:[ \t]++[^0\s]\S*+)*+[ \t]++0++(?=[/\s]|$)", re.MULTILINE)
"""A face of an OBJ with a 0 where a vertex is named; linear in the text."""

OFF_WORDS = re.compile(r"\bC?OFF\b|#.*")
"""What stands in an OFF besides numbers."""


def load_scene(scene: str | Path, crease: float | None = None) -> Mesh:
    """
    A mesh from a file or from a generator.

    Parameters
    ----------
    scene : str or Path
      A mesh file, or a name such as ``sphere:168`` (see ``quadshade.scene.generate``).
    crease : float, optional
      Degrees. Given: vertex normals are computed and edges sharper than this stay sharp. Not given: the
      normals of the file or the generator are used; a file without normals gets a crease of 60 degrees.

    Returns
    -------
    Mesh

    Raises
    ------
    QuadshadeError
      No such file, an unknown kind of file, a malformed one, a vertex that is not finite, or no triangles.
    """
    path = Path(scene)
    name = str(scene)
    if path.suffix.lower() not in SUFFIXES and (":" in name or not path.exists()):
        if ":" not in name:
            raise QuadshadeError(f"no such file or scene: {name}", f"give a mesh file, or one of {EXAMPLES}")
        mesh = generate(name)
        return mesh if crease is None else build_mesh(mesh.vertices, mesh.faces, crease=crease)
    return load_mesh(path, crease)


def load_mesh(path: Path, crease: float | None = None) -> Mesh:
    """
    A mesh from a file; all parts of a file with several are joined, each where the file places it.

    Parameters and errors as for :func:`load_scene`.
    """
    import trimesh

    if not path.is_file():
        what = "is no file" if path.exists() else "does not exist"
        what = "is a folder, not a file" if path.is_dir() else what
        raise QuadshadeError(f"{path} {what}", "give a mesh file")
    if path.suffix.lower() not in SUFFIXES:
        raise QuadshadeError(f"{path} is no mesh file", f"give one of {', '.join(SUFFIXES)}")
    try:
        loaded = _load(path)
        placed = [(loaded.geometry[name], matrix) for matrix, name in _placements(loaded)]
        parts = [_part(part, matrix) for part, matrix in placed if isinstance(part, trimesh.Trimesh)]
    except QuadshadeError as error:
        text = error.message if str(path) in error.message else f"{path}: {error.message}"
        raise QuadshadeError(text, error.hint) from None
    except OSError as error:
        if error.strerror is None:
            raise QuadshadeError(f"cannot read {path}: {_reason(error)}", "the file is malformed") from None
        raise QuadshadeError(f"cannot read {path}: {error.strerror}", "give a mesh file") from None
    except Exception as error:  # noqa: BLE001 - trimesh raises whatever its parsing stumbles over
        raise QuadshadeError(f"cannot read {path}: {_reason(error)}", "the file is malformed") from None
    parts = [part for part in parts if len(part[1])]
    if not parts:
        raise QuadshadeError(f"{path} has no triangles", "give a mesh with faces")
    return _join(parts, crease)


def _reason(error: Exception) -> str:
    """What trimesh stumbled over, in words of at most 200 characters."""
    text = " ".join(str(error).split())
    if isinstance(error, ImportError):
        # It asks an optional package for the encoding of what ought to be text and is not.
        text = "neither binary nor text as it should be"
    elif isinstance(error, FileNotFoundError):
        # What is no JSON it takes for an archive of this.
        text = "it is no JSON" if text == "model.gltf" else f"there is no {text} beside it"
    elif isinstance(error, KeyError):
        text = f"it has no {text}"
    elif isinstance(error, UnicodeEncodeError):
        text = "its name is not UTF-8"
    return text[:200] or type(error).__name__


def _load(path: Path) -> trimesh.Scene:
    """The file's scene; text may have a byte order mark, and names and remarks in any encoding."""
    import trimesh

    # process=False: trimesh would otherwise drop what is not finite, where the user should hear of it.
    if path.suffix.lower() not in TEXT_SUFFIXES:
        return trimesh.load_scene(path, process=False)
    text = path.read_bytes().decode("utf-8-sig", errors="replace")
    _check_text(path, text)
    return trimesh.load_scene(
        BytesIO(text.encode()),
        file_type=path.suffix.lower().lstrip("."),
        resolver=trimesh.resolvers.FilePathResolver(path),
        process=False,
    )


def _check_text(path: Path, text: str) -> None:
    """Refuse what trimesh would read as something else: an OBJ's vertex 0 as the last one, half an OFF."""
    if path.suffix.lower() == ".obj":
        if zero := VERTEX_0.search(text):
            line = text.count("\n", 0, zero.end()) + 1
            raise QuadshadeError(f"{path}: line {line} names vertex 0", "repair it: an OBJ counts from 1")
        return
    counts, *lines = [line for line in OFF_WORDS.sub("", text).splitlines() if line.strip()] or [""]
    wanted = sum(int(count) for count in counts.split()[:2])
    last = lines[wanted - 1].split() if 0 < wanted <= len(lines) else []
    if wanted > len(lines) or (last and last[0].isdecimal() and len(last) <= int(last[0])):
        raise QuadshadeError(f"{path} is cut short: vertices and faces are {wanted} lines", "repair the mesh")


def _placements(loaded: trimesh.Scene) -> list[tuple[np.ndarray, str]]:
    """Transform and name of every geometry in the scene graph, instances included."""
    return [loaded.graph[node] for node in loaded.graph.nodes_geometry]


def _part(
    part: trimesh.Trimesh, matrix: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray | None, np.ndarray]:
    """Vertices, faces, corner normals (None: the file has none) and corner colours of one placed geometry."""
    vertices = np.array(part.vertices, dtype=np.float64)
    faces = np.array(part.faces, dtype=np.int64)
    if faces.size and (faces.min() < 0 or faces.max() >= len(vertices)):
        raise QuadshadeError("a face names a vertex that does not exist", "repair the mesh")
    bad = vertices[~np.isfinite(vertices).all(axis=1)]
    if len(faces) and len(bad):
        # Which one of the file it is gets lost in trimesh.
        raise QuadshadeError(f"a vertex is {bad[0].tolist()}, not finite", "repair the mesh")
    normals = None
    # trimesh computes the normals of a mesh that has none; only its cache tells which they are.
    if "vertex_normals" in part._cache.cache:
        normals = np.array(part.vertex_normals, dtype=np.float64)[faces]
    linear = matrix[:3, :3]
    if not np.array_equal(matrix, np.eye(4)):
        vertices = vertices @ linear.T + matrix[:3, 3]
        if normals is not None:
            normals = normals @ np.linalg.pinv(linear)
        if np.linalg.det(linear) < 0:
            faces = faces[:, ::-1]
            normals = None if normals is None else normals[:, ::-1]
    return vertices, faces, normals, _colours(part, faces)


def _colours(part: trimesh.Trimesh, faces: np.ndarray) -> np.ndarray | None:
    """(n, 3, 3) corner colours, 0 .. 1, or None where the file gives none."""
    visual = part.visual
    if not visual.defined:
        return None
    if visual.kind == "face":
        return np.repeat(visual.face_colors[:, None, :3] / 255.0, 3, axis=1)
    colours = visual.to_color().vertex_colors if visual.kind == "texture" else visual.vertex_colors
    return np.asarray(colours)[:, :3][faces] / 255.0 if len(colours) == len(part.vertices) else None


def _join(parts: list[tuple], crease: float | None) -> Mesh:
    """One mesh of several parts; a part without normals gets computed ones, one without colours is white."""
    starts = np.cumsum([0] + [len(part[0]) for part in parts])
    vertices = np.concatenate([part[0] for part in parts])
    faces = np.concatenate([part[1] + start for part, start in zip(parts, starts, strict=False)])
    normals = _corners([part[2] for part in parts], [len(part[1]) for part in parts], 0.0)
    colours = _corners([part[3] for part in parts], [len(part[1]) for part in parts], 1.0)
    if crease is not None or any(part[2] is None for part in parts):
        vertices, faces = merge_vertices(vertices, faces)
    return build_mesh(vertices, faces, normals, crease, colours)


def _corners(given: list[np.ndarray | None], counts: list[int], default: float) -> np.ndarray | None:
    """Corner arrays of all parts in one, the default for parts without; None if no part has any."""
    if all(part is None for part in given):
        return None
    filled = [
        np.full((count, 3, 3), default) if part is None else part
        for part, count in zip(given, counts, strict=True)
    ]
    return np.concatenate(filled)
