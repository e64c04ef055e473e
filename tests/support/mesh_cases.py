# SPDX-License-Identifier: Apache-2.0
"""
Small mesh files with what is right to draw of them, for the tests and for the report on readers.

All are looked at along -z at 16 pixels a unit, in ambient light alone: a unit square has 256 pixels, a right
triangle of that size 136 (or 120, the other half).
"""

from __future__ import annotations

import io
import json
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from PIL import Image

DATA = Path(__file__).resolve().parents[1] / "data" / "meshes"
CAMERA = "from=0,0,1,target=1,1,0,ortho=2"
WHITE, RED, GREEN, BLUE = (255, 255, 255), (255, 0, 0), (0, 255, 0), (0, 0, 255)
GIVEN = (51, 102, 153)
"""The colour of the given material, where a case is to show it."""

Colour = tuple[int, int, int]


@dataclass(frozen=True)
class Case:
    """
    A mesh file and what is right.

    Attributes
    ----------
    name : str
      The file's; its suffix tells the format.
    lit : dict or None
      Pixels by colour, all that are not black; None: it is refused.
    content : bytes or None
      None: the file of this name in ``tests/data/meshes``.
    beside : mapping
      Files that stand beside it.
    refused : str
      A part of the error's text.
    note : str
      A part of a note that it must give; without one there must be none.
    """

    name: str
    lit: Mapping[Colour, int] | None
    content: bytes | None = None
    beside: Mapping[str, bytes] = field(default_factory=dict)
    refused: str = ""
    note: str = ""
    camera: str = CAMERA
    given: Colour = WHITE

    def write(self, folder: Path) -> Path:
        """Write the file and those beside it into a folder."""
        for name, content in self.beside.items():
            (folder / name).parent.mkdir(exist_ok=True)
            (folder / name).write_bytes(content)
        path = folder / self.name
        if self.content is None:
            for other in DATA.glob("*"):
                (folder / other.name).write_bytes(other.read_bytes())
        else:
            path.write_bytes(self.content)
        return path


def png(*colours: Colour, rows: int = 1) -> bytes:
    """A picture of columns in these colours."""
    out = io.BytesIO()
    Image.fromarray(np.array([colours] * rows, dtype=np.uint8)).save(out, "PNG")
    return out.getvalue()


class Gltf:
    """
    Builds a glTF file piece by piece.

    Attributes
    ----------
    root : dict
      The JSON, with the keys that its caller adds.
    """

    def __init__(self) -> None:
        self.binary = b""
        self.root: dict = {"asset": {"version": "2.0"}, "bufferViews": [], "accessors": [], "scene": 0}
        self.root |= {"nodes": [{"mesh": 0}], "scenes": [{"nodes": [0]}], "meshes": [{"primitives": []}]}

    def view(self, data: bytes, **more: object) -> int:
        """A buffer view of bytes; its number."""
        self.binary += bytes(-len(self.binary) % 4)
        view = {"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(data)} | more
        self.binary += data
        self.root["bufferViews"].append(view)
        return len(self.root["bufferViews"]) - 1

    def accessor(self, array: Sequence | np.ndarray, dtype: str = "f4", **more: object) -> int:
        """An accessor of an array; its number."""
        table = np.array(array, dtype=dtype)
        codes = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}
        kind = "SCALAR" if table.ndim == 1 else {2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}[table.shape[1]]
        view = self.view(table.astype("<" + dtype).tobytes())
        self.root["accessors"].append(
            {"bufferView": view, "componentType": codes[dtype], "count": len(table), "type": kind} | more
        )
        return len(self.root["accessors"]) - 1

    def primitive(self, positions: Sequence = ((0, 0, 0), (1, 0, 0), (1, 1, 0)), **more: object) -> dict:
        """A primitive of the mesh, with POSITION; returned, to be added to."""
        attributes = {"POSITION": self.accessor(positions)}
        self.root["meshes"][0]["primitives"].append({"attributes": attributes} | more)
        return self.root["meshes"][0]["primitives"][-1]

    def texture(self, content: bytes, sampler: dict | None = None) -> int:
        """A texture in the file; its number."""
        image = {"bufferView": self.view(content), "mimeType": "image/png"}
        self.root.setdefault("images", []).append(image)
        texture = {"source": len(self.root["images"]) - 1}
        if sampler is not None:
            self.root.setdefault("samplers", []).append(sampler)
            texture["sampler"] = len(self.root["samplers"]) - 1
        self.root.setdefault("textures", []).append(texture)
        return len(self.root["textures"]) - 1

    def material(self, texture: dict | None = None, **more: object) -> int:
        """A material, its factor given as ``factor``; its number."""
        surface: dict = {} if texture is None else {"baseColorTexture": texture}
        if "factor" in more:
            surface["baseColorFactor"] = more.pop("factor")
        self.root.setdefault("materials", []).append({"pbrMetallicRoughness": surface} | more)
        return len(self.root["materials"]) - 1

    def glb(self) -> bytes:
        """The file as GLB."""
        root = self.root | {"buffers": [{"byteLength": len(self.binary)}]}
        text = json.dumps(root).encode()
        text += b" " * (-len(text) % 4)
        binary = self.binary + bytes(-len(self.binary) % 4)
        chunks = struct.pack("<I4s", len(text), b"JSON") + text
        chunks += struct.pack("<I4s", len(binary), b"BIN\0") + binary
        return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks

    def gltf(self, uri: str) -> bytes:
        """The file as text, its buffer at a URI."""
        return json.dumps(self.root | {"buffers": [{"byteLength": len(self.binary), "uri": uri}]}).encode()
