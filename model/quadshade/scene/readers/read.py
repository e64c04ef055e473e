# SPDX-License-Identifier: Apache-2.0
"""The reader for a file's kind."""

from __future__ import annotations

from pathlib import Path

from quadshade.errors import QuadshadeError
from quadshade.scene.readers.gltf import read_gltf
from quadshade.scene.readers.obj import read_obj
from quadshade.scene.readers.off import read_off
from quadshade.scene.readers.part import MeshFile
from quadshade.scene.readers.ply import read_ply
from quadshade.scene.readers.stl import read_stl

SUFFIXES = (".obj", ".ply", ".stl", ".glb", ".gltf", ".off")


def read_mesh_file(path: Path) -> MeshFile:
    """
    Everything that a mesh file shows.

    Parameters
    ----------
    path : Path
      Its suffix tells its kind.

    Returns
    -------
    MeshFile

    Raises
    ------
    QuadshadeError
      A malformed file, one that is cut short, or one that needs what is not read or not there.
    OSError
      The file cannot be read.
    """
    data = path.read_bytes()

    def fetch(name: str) -> bytes:
        """The content of a file beside the mesh; names from Windows have backslashes."""
        for text in (name, name.replace("\\", "/")):
            try:
                return (path.parent / text).read_bytes()
            except (OSError, ValueError):
                continue
        raise QuadshadeError(f"there is no {name[:80]} beside it", "put it there, or remove what names it")

    match path.suffix.lower():
        case ".obj":
            return read_obj(_text(data), fetch)
        case ".off":
            return read_off(_text(data))
        case ".ply":
            return read_ply(data, fetch)
        case ".stl":
            return read_stl(data)
        case ".glb" | ".gltf":
            return read_gltf(data, fetch)
        case _:
            raise QuadshadeError(f"{path} is no mesh file", f"give one of {', '.join(SUFFIXES)}")


def _text(data: bytes) -> str:
    """Text with or without a byte order mark, in UTF-16 with one; names and remarks in any encoding."""
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return data.decode("utf-16", errors="replace")
    return data.decode("utf-8-sig", errors="replace")
