# SPDX-License-Identifier: Apache-2.0
"""Readers of mesh files: bytes in, parts with normals and colours out, or one error that says why not."""

from quadshade.scene.readers.part import MeshFile, Part
from quadshade.scene.readers.read import SUFFIXES, read_mesh_file

__all__ = ["SUFFIXES", "MeshFile", "Part", "read_mesh_file"]
