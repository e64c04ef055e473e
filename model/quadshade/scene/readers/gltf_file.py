# SPDX-License-Identifier: Apache-2.0
"""The container of glTF 2.0: GLB's chunks, JSON with checked access, buffers and files beside it."""

from __future__ import annotations

import base64
import binascii
import json
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any
from urllib.parse import unquote

import numpy as np

from quadshade.errors import QuadshadeError

SINGULAR = {"meshes": "mesh"}
MAGIC, JSON_CHUNK, BINARY_CHUNK = b"glTF", b"JSON", b"BIN\0"

DRAWN_EXTENSIONS = frozenset(
    {
        "KHR_mesh_quantization", "KHR_texture_transform", "EXT_texture_webp", "KHR_node_visibility",
        "KHR_lights_punctual", "KHR_animation_pointer", "KHR_xmp_json_ld",
        "KHR_materials_anisotropy", "KHR_materials_clearcoat", "KHR_materials_dispersion",
        "KHR_materials_emissive_strength", "KHR_materials_ior", "KHR_materials_iridescence",
        "KHR_materials_pbrSpecularGlossiness", "KHR_materials_sheen", "KHR_materials_specular",
        "KHR_materials_unlit", "KHR_materials_variants",
    }
)  # fmt: skip
"""Extensions that a file may require: read here, or without effect on shape and base colour."""


class Item:
    """
    A JSON object whose members are asked for by kind.

    Parameters
    ----------
    content : object
      What should be a JSON object.
    name : str
      For messages, e.g. ``accessor 3``.
    """

    def __init__(self, content: object, name: str) -> None:
        if not isinstance(content, dict):
            raise QuadshadeError(f"its {name} is no object", "repair the mesh")
        self._content: dict[str, Any] = content
        self.name = name

    def __contains__(self, key: str) -> bool:
        return key in self._content

    def _wrong(self, key: str, wanted: str) -> QuadshadeError:
        got = repr(self._content.get(key))[:40]
        return QuadshadeError(f"its {self.name} has {key} {got}, not {wanted}", "repair the mesh")

    def whole(self, key: str, default: int | None = None) -> int:
        """A whole number from 0 on."""
        value = self._content.get(key, default)
        if (
            isinstance(value, bool)
            or not isinstance(value, (int, float))
            or not 0 <= value < 2**53
            or value % 1
        ):
            raise self._wrong(key, "a whole number")
        return int(value)

    def number(self, key: str, default: float) -> float:
        """A finite number."""
        return self.numbers(key, (default,), single=True)[0]

    def numbers(self, key: str, default: tuple[float, ...], single: bool = False) -> tuple[float, ...]:
        """As many finite numbers as the default has."""
        given = self._content.get(key, default[0] if single else default)
        values = [given] if single else given
        if not isinstance(values, (list, tuple)) or len(values) != len(default):
            raise self._wrong(key, f"{len(default)} numbers")
        for value in values:
            if isinstance(value, bool) or not isinstance(value, (int, float)) or not abs(value) <= 1e100:
                raise self._wrong(key, f"{len(default)} finite numbers")
        return tuple(float(value) for value in values)

    def list_of_numbers(self, key: str) -> list[float]:
        """Any number of finite numbers."""
        given = self._content.get(key, [])
        if not isinstance(given, list):
            raise self._wrong(key, "a list")
        return list(self.numbers(key, (0.0,) * len(given))) if given else []

    def text(self, key: str, default: str) -> str:
        """A string."""
        value = self._content.get(key, default)
        if not isinstance(value, str):
            raise self._wrong(key, "a text")
        return value

    def texts(self, key: str) -> list[str]:
        """A list of strings."""
        value = self._content.get(key, [])
        if not isinstance(value, list) or not all(isinstance(part, str) for part in value):
            raise self._wrong(key, "a list of texts")
        return value

    def flag(self, key: str, default: bool = False) -> bool:
        """True or false."""
        value = self._content.get(key, default)
        if not isinstance(value, bool):
            raise self._wrong(key, "true or false")
        return value

    def item(self, key: str) -> Item:
        """An object; an empty one where there is none."""
        return Item(self._content.get(key, {}), f"{self.name}'s {key}")

    def items(self, key: str) -> list[Item]:
        """A list of objects."""
        value = self._content.get(key, [])
        if not isinstance(value, list):
            raise self._wrong(key, "a list")
        return [
            Item(part, f"{self.name}'s {SINGULAR.get(key, key.removesuffix('s'))} {index}")
            for index, part in enumerate(value)
        ]

    def wholes(self, key: str) -> list[int]:
        """A list of whole numbers from 0 on."""
        numbers = self.list_of_numbers(key)
        if not all(number >= 0 and math.floor(number) == number for number in numbers):
            raise self._wrong(key, "a list of whole numbers")
        return [int(number) for number in numbers]

    def keys(self) -> list[str]:
        """Names of the members."""
        return list(self._content)

    def extension(self, name: str) -> Item | None:
        """An extension's object, if the object has it."""
        extensions = self.item("extensions")
        return extensions.item(name) if name in extensions else None


@dataclass
class GltfFile:
    """
    A glTF file.

    Attributes
    ----------
    root : Item
    binary : bytes or None
      GLB's binary chunk.
    fetch : callable
      The content of a file beside this one, by its name.
    """

    root: Item
    binary: bytes | None
    fetch: Callable[[str], bytes]

    def __post_init__(self) -> None:
        self._lists: dict[str, list[Item]] = {}
        self._buffers: dict[int, bytes] = {}

    def pick(self, kind: str, index: int) -> Item:
        """Item number ``index`` of a list at the top."""
        if kind not in self._lists:
            self._lists[kind] = self.root.items(kind)
        items = self._lists[kind]
        if index >= len(items):
            raise QuadshadeError(f"it names number {index} of {len(items)} {kind}", "repair the mesh")
        items[index].name = f"{SINGULAR.get(kind, kind.removesuffix('s'))} {index}"
        return items[index]

    def buffer(self, index: int) -> bytes:
        """The content of a buffer."""
        if index not in self._buffers:
            item = self.pick("buffers", index)
            length = item.whole("byteLength")
            if "uri" in item:
                data = self.content(item.text("uri", ""))
            elif index == 0 and self.binary is not None:
                data = self.binary
            else:
                raise QuadshadeError(f"its {item.name} has no content", "repair the mesh")
            if len(data) < length:
                raise QuadshadeError(
                    f"its {item.name} is cut short: {len(data)} of {length} bytes", "repair the mesh"
                )
            self._buffers[index] = data[:length]
        return self._buffers[index]

    def view(self, index: int) -> tuple[bytes, int]:
        """The bytes of a buffer view, and its stride (0: none given)."""
        item = self.pick("bufferViews", index)
        if item.extension("EXT_meshopt_compression") is not None:
            raise QuadshadeError(
                "it is compressed with EXT_meshopt_compression, which is not read", "decompress it"
            )
        data = self.buffer(item.whole("buffer"))
        start, length = item.whole("byteOffset", 0), item.whole("byteLength")
        if start + length > len(data):
            raise QuadshadeError(
                f"its {item.name} is cut short: bytes {start} to {start + length} of {len(data)}",
                "repair the mesh",
            )
        return data[start : start + length], item.whole("byteStride", 0)

    def content(self, uri: str) -> bytes:
        """What a URI stands for: data in it, or a file beside this one."""
        if uri.startswith("data:"):
            head, _, body = uri.partition(",")
            try:
                return (
                    base64.b64decode(body, validate=True)
                    if head.endswith(";base64")
                    else unquote(body).encode()
                )
            except (binascii.Error, ValueError):
                raise QuadshadeError("it has a data: URI that is no base64", "repair the mesh") from None
        if "://" in uri:
            raise QuadshadeError(f"it needs {uri[:80]}, which is not fetched", "put the file beside it")
        return self.fetch(unquote(uri))


def open_gltf(data: bytes, fetch: Callable[[str], bytes]) -> tuple[GltfFile, list[str]]:
    """
    A glTF file, text or GLB, and notes on what it holds besides.

    Raises
    ------
    QuadshadeError
      A malformed container, another version, or an extension that the file requires and that is not read.
    """
    binary: bytes | None = None
    notes: list[str] = []
    if data[:4] == MAGIC:
        data, binary, notes = _chunks(data)
    try:
        content = json.loads(data.decode("utf-8-sig"), parse_constant=_no_constant)
    except (ValueError, RecursionError):
        raise QuadshadeError("it is no JSON", "give a glTF file") from None
    root = Item(content, "JSON")
    version = root.item("asset").text("version", "")
    if version.split(".")[0] != "2":
        raise QuadshadeError(f"its glTF version is {version or 'missing'}", "save it as glTF 2.0")
    unknown = [name for name in root.texts("extensionsRequired") if name not in DRAWN_EXTENSIONS]
    if unknown:
        raise QuadshadeError(
            f"it requires {', '.join(unknown)}, which is not read"[:300], "save it without, or uncompressed"
        )
    return GltfFile(root, binary, fetch), notes


def _no_constant(name: str) -> float:
    """JSON has no NaN and Infinity, though Python reads them."""
    raise ValueError(name)


def _chunks(data: bytes) -> tuple[bytes, bytes | None, list[str]]:
    """A GLB's JSON, its binary chunk, and notes."""
    if len(data) < 20:
        raise QuadshadeError("it is cut short: its header is not complete", "repair the mesh")
    version, length = (int(number) for number in np.frombuffer(data, "<u4", 2, 4))
    if version != 2:
        raise QuadshadeError(f"it is GLB of version {version}", "save it as glTF 2.0")
    if length > len(data):
        raise QuadshadeError(f"it is cut short: {len(data)} of {length} bytes", "repair the mesh")
    notes = [f"{len(data) - length} bytes behind its end"] if length < len(data) else []
    chunks: dict[bytes, bytes] = {}
    place = 12
    while place + 8 <= length:
        size, kind = int(np.frombuffer(data, "<u4", 1, place)[0]), data[place + 4 : place + 8]
        if place + 8 + size > length:
            raise QuadshadeError(f"it is cut short: a chunk of {size} bytes", "repair the mesh")
        chunks.setdefault(kind, data[place + 8 : place + 8 + size])
        place += 8 + size
    if JSON_CHUNK not in chunks:
        raise QuadshadeError("it has no JSON chunk", "repair the mesh")
    return chunks[JSON_CHUNK], chunks.get(BINARY_CHUNK), notes
