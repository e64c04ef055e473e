# SPDX-License-Identifier: Apache-2.0
"""Accessors of glTF 2.0: numbers in buffers, normalised, strided and sparse ones too."""

from __future__ import annotations

import numpy as np

from quadshade.errors import QuadshadeError
from quadshade.scene.readers.gltf_file import GltfFile, Item

COMPONENT_TYPES = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
COMPONENTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
MOST_ZEROS = 10_000_000
"""Rows of an accessor without data, which the file's size does not bound."""


def read_accessor(file: GltfFile, index: int, kinds: tuple[str, ...]) -> np.ndarray:
    """
    The numbers of an accessor.

    Parameters
    ----------
    file : GltfFile
    index : int
    kinds : tuple of str
      What it may be: ``SCALAR``, ``VEC3`` and so on.

    Returns
    -------
    (count, components) float64
      Normalised ones within -1 .. 1.

    Raises
    ------
    QuadshadeError
      An accessor of another kind, malformed or cut short.
    """
    item = file.pick("accessors", index)
    kind = item.text("type", "")
    if kind not in kinds:
        raise QuadshadeError(
            f"its {item.name} is {kind or 'of no type'}, not {' or '.join(kinds)}", "repair the mesh"
        )
    dtype = _component_type(item)
    count, columns = item.whole("count"), COMPONENTS[kind]
    if "bufferView" in item:
        raw = _rows(
            file, item.whole("bufferView"), item.whole("byteOffset", 0), count, columns, dtype, item.name
        )
    else:
        if count > MOST_ZEROS:
            raise QuadshadeError(f"its {item.name} has {count} rows and no data", "repair the mesh")
        raw = np.zeros((count, columns), dtype)
    if "sparse" in item:
        raw = _with_sparse(file, item, raw)
    values = raw.astype(np.float64)
    if item.flag("normalized"):
        if dtype.kind == "f":
            raise QuadshadeError(f"its {item.name} is of normalised floats", "repair the mesh")
        values = np.maximum(values / float(np.iinfo(dtype).max), -1.0)
    return values


def read_indices(file: GltfFile, index: int) -> np.ndarray:
    """(count,) int64 of an accessor of unsigned numbers."""
    kind = _component_type(file.pick("accessors", index)).kind
    if kind != "u":
        raise QuadshadeError(
            f"its accessor {index} for indices is not of unsigned numbers", "repair the mesh"
        )
    return read_accessor(file, index, ("SCALAR",))[:, 0].astype(np.int64)


def _component_type(item: Item) -> np.dtype:
    """The type of an accessor's numbers."""
    code = item.whole("componentType")
    if code not in COMPONENT_TYPES:
        raise QuadshadeError(f"its {item.name} has the componentType {code}", "repair the mesh")
    return np.dtype(COMPONENT_TYPES[code])


def _rows(
    file: GltfFile, view: int, offset: int, count: int, columns: int, dtype: np.dtype, name: str
) -> np.ndarray:
    """(count, columns) numbers from a buffer view."""
    data, stride = file.view(view)
    size = columns * dtype.itemsize
    stride = stride or size
    if stride < size:
        raise QuadshadeError(f"its {name} has a stride of {stride} bytes for {size}", "repair the mesh")
    if count and offset + (count - 1) * stride + size > len(data):
        raise QuadshadeError(
            f"its {name} is cut short: {count} rows of {stride} bytes from {offset} on, in {len(data)}",
            "repair the mesh",
        )
    if not count:
        return np.zeros((0, columns), dtype)
    return np.ndarray((count, columns), dtype, data, offset, (stride, dtype.itemsize))


def _with_sparse(file: GltfFile, item: Item, raw: np.ndarray) -> np.ndarray:
    """The numbers with those of the accessor's ``sparse`` in their places."""
    sparse = item.item("sparse")
    count = sparse.whole("count")
    indices, values = sparse.item("indices"), sparse.item("values")
    kind = _component_type(indices)
    if kind.kind != "u":
        raise QuadshadeError(f"its {indices.name} are not of unsigned numbers", "repair the mesh")
    at = (indices.whole("bufferView"), indices.whole("byteOffset", 0))
    rows = _rows(file, *at, count, 1, kind, indices.name)[:, 0].astype(np.int64)
    if rows.size and rows.max() >= len(raw):
        raise QuadshadeError(f"its {indices.name} name row {rows.max()} of {len(raw)}", "repair the mesh")
    at = (values.whole("bufferView"), values.whole("byteOffset", 0))
    out = raw.copy()
    out[rows] = _rows(file, *at, count, raw.shape[1], raw.dtype, values.name)
    return out
