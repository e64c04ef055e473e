# SPDX-License-Identifier: Apache-2.0
"""The one entry point for all scenes: a mesh file or a generated mesh."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from quadshade.errors import QuadshadeError
from quadshade.scene.generate import EXAMPLES, generate
from quadshade.scene.mesh import Mesh, build_mesh, merge_vertices
from quadshade.scene.readers import SUFFIXES, MeshFile, read_mesh_file
from quadshade.scene.readers.part import check_faces, check_finite, plural


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
      Its ``notes`` say what the file holds and a picture does not show.

    Raises
    ------
    QuadshadeError
      No such file, an unknown kind of file, a malformed one, a vertex that is not finite, or no triangles.
    """
    path = Path(scene)
    name = str(scene)
    if is_generated(scene) or (path.suffix.lower() not in SUFFIXES and not path.exists()):
        if ":" not in name:
            raise QuadshadeError(
                f"cannot read {name}: no such file or scene", f"give a mesh file, or one of {EXAMPLES}"
            )
        mesh = generate(name)
        return mesh if crease is None else build_mesh(mesh.vertices, mesh.faces, crease=crease)
    return load_mesh(path, crease)


def is_generated(scene: str | Path) -> bool:
    """Whether a scene is the name of a generated one, and no file."""
    return ":" in str(scene) and Path(scene).suffix.lower() not in SUFFIXES


def load_mesh(path: Path, crease: float | None = None) -> Mesh:
    """
    A mesh from a file; all parts of a file with several are joined, each where the file places it.

    Parameters and errors as for :func:`load_scene`.
    """
    if not path.is_file():
        what = "it is no file" if path.exists() else "No such file or directory"
        what = "it is a folder" if path.is_dir() else what
        raise QuadshadeError(f"cannot read {path}: {what}", "give a mesh file")
    if path.suffix.lower() not in SUFFIXES:
        raise QuadshadeError(f"{path} is no mesh file", f"give one of {', '.join(SUFFIXES)}")
    try:
        return _join(read_mesh_file(path), crease)
    except QuadshadeError as error:
        text = error.message if str(path) in error.message else f"{path}: {error.message}"
        raise QuadshadeError(text, error.hint) from None
    except OSError as error:
        raise QuadshadeError(f"cannot read {path}: {error.strerror or error}", "give a mesh file") from None
    except Exception as error:  # noqa: BLE001 - a malformed file must not end in a traceback
        reason = " ".join(str(error).split())[:200] or type(error).__name__
        raise QuadshadeError(f"cannot read {path}: {reason}", "the file is malformed") from None


def _join(file: MeshFile, crease: float | None) -> Mesh:
    """One mesh of several parts; corners without a normal get a computed one, without a colour are white."""
    parts = [part for part in file.parts if len(part.faces)]
    if not parts:
        raise QuadshadeError("it has no triangles", "give a mesh with faces")
    for part in parts:
        check_finite(part.vertices)
        check_faces(part.faces, len(part.vertices))
    counts = [len(part.faces) for part in parts]
    starts = np.cumsum([0] + [len(part.vertices) for part in parts])
    vertices = np.concatenate([part.vertices for part in parts])
    faces = np.concatenate([part.faces + start for part, start in zip(parts, starts, strict=False)])
    normals = _corners([part.normals for part in parts], counts)
    colours = _corners([part.colours for part in parts], counts)
    notes = list(file.notes)
    if colours is not None:
        bare = ~np.isfinite(colours).all(axis=(1, 2))
        if bare.any():
            notes.append(
                f"{plural(int(bare.sum()), 'triangle')} without a colour beside coloured ones: drawn white"
            )
            colours = np.where(np.isfinite(colours), colours, 1.0)
    double_sided = np.repeat([part.double_sided for part in parts], counts)
    if crease is not None or normals is None or not np.isfinite(normals).all():
        vertices, faces = merge_vertices(vertices, faces)
    return build_mesh(
        vertices,
        faces,
        normals,
        crease,
        colours,
        double_sided if double_sided.any() else None,
        tuple(notes),
    )


def _corners(given: Sequence[np.ndarray | None], counts: list[int]) -> np.ndarray | None:
    """Corner arrays of all parts in one, NaN for parts without; None if no part has any."""
    if all(part is None for part in given):
        return None
    filled = [
        np.full((count, 3, 3), np.nan) if part is None else part
        for part, count in zip(given, counts, strict=True)
    ]
    return np.concatenate(filled)
