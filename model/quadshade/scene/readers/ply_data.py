# SPDX-License-Identifier: Apache-2.0
"""The elements of a PLY file, text or binary, whatever they are."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from quadshade.errors import QuadshadeError
from quadshade.scene.readers.part import plural

TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2", "ushort": "u2",
    "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4", "float": "f4", "float32": "f4",
    "double": "f8", "float64": "f8",
}  # fmt: skip
LONGEST_WORD = 64
ByteOrder = Literal["=", "<", ">"]
TEXT: ByteOrder = "="
BYTE_ORDERS: dict[str, ByteOrder] = {"ascii": TEXT, "binary_little_endian": "<", "binary_big_endian": ">"}


@dataclass(frozen=True)
class Property:
    """A number, or a list of numbers with its length before it."""

    name: str
    dtype: np.dtype
    length: np.dtype | None = None


@dataclass
class Element:
    """
    So many rows of properties.

    Attributes
    ----------
    numbers : dict
      (count,) arrays by property.
    lists : dict
      (count,) lengths and all values, one row after the other, by property.
    """

    name: str
    count: int
    properties: list[Property] = field(default_factory=list)
    numbers: dict[str, np.ndarray] = field(default_factory=dict)
    lists: dict[str, tuple[np.ndarray, np.ndarray]] = field(default_factory=dict)


@dataclass(frozen=True)
class Header:
    """Byte order, elements, comments, lines that mean nothing, and where the data begin."""

    order: ByteOrder
    elements: list[Element]
    comments: list[str]
    strange: list[str]
    start: int


@dataclass(frozen=True)
class PlyFile:
    """Elements by name, the header's comments, and notes on what cannot be drawn of all this."""

    elements: dict[str, Element]
    comments: list[str]
    notes: list[str]


def read_ply_data(data: bytes) -> PlyFile:
    """
    All elements of a PLY file.

    Parameters
    ----------
    data : bytes

    Returns
    -------
    PlyFile

    Raises
    ------
    QuadshadeError
      A header that is malformed, data that are cut short or do not fit the header.
    """
    header = _read_header(data)
    if header.order != TEXT:
        place = header.start
        for element in header.elements:
            place = _read_binary(element, data, place, header.order)
        left = plural(len(data) - place, "byte") if len(data) > place else ""
    else:
        words = _read_text(header.elements, data[header.start :])
        left = plural(words, "word") if words else ""
    notes = header.strange + [f"{left} behind its last element"] * bool(left)
    return PlyFile({element.name: element for element in header.elements}, header.comments, notes)


def _read_header(data: bytes) -> Header:
    """The header, its elements without data."""
    if not data.startswith(b"ply") or data[3:4] not in (b"\n", b"\r"):
        raise QuadshadeError("it does not begin with ply", "give a PLY file")
    place = 0
    order: ByteOrder | None = None
    elements: list[Element] = []
    comments: list[str] = []
    strange: list[str] = []
    while True:
        end = min((at for at in (data.find(b"\n", place), data.find(b"\r", place)) if at >= 0), default=-1)
        if end < 0:
            raise QuadshadeError("it is cut short: its header has no end", "repair the mesh")
        line = data[place:end].decode("utf-8", errors="replace")
        place = end + (2 if data[end : end + 2] == b"\r\n" else 1)
        words = line.split()
        match words:
            case ["end_header"]:
                break
            case ["format", name, _] if name in BYTE_ORDERS:
                order = BYTE_ORDERS[name]
            case ["comment", *_]:
                comments.append(line.strip()[len("comment") :].strip())
            case ["element", name, count] if count.isdecimal() and len(count) < 16:
                elements.append(Element(name, int(count)))
            case ["property", "list", length, kind, name] if elements and length in TYPES and kind in TYPES:
                if TYPES[length].startswith("f"):
                    raise QuadshadeError(f"the length of its list {name!r} is a {length}", "repair the mesh")
                elements[-1].properties.append(Property(name, np.dtype(TYPES[kind]), np.dtype(TYPES[length])))
            case ["property", kind, name] if elements and kind in TYPES:
                elements[-1].properties.append(Property(name, np.dtype(TYPES[kind])))
            case [] | ["ply"] | ["obj_info", *_]:
                pass
            case _ if not elements:
                strange.append(f"a header line that no PLY has: {line[:60]!r}")
            case _:
                raise QuadshadeError(f"its header has the line {line[:60]!r}", "repair the mesh")
    if order is None:
        raise QuadshadeError("its header has no format", "repair the mesh")
    for names in ([e.name for e in elements], *([p.name for p in e.properties] for e in elements)):
        if len(set(names)) < len(names):
            raise QuadshadeError("its header names an element or a property twice", "repair the mesh")
    return Header(order, elements, comments, strange, place)


def _cut_short(element: Element, index: int) -> QuadshadeError:
    """What to raise where the data end too early."""
    return QuadshadeError(
        f"it is cut short: {element.name} {index} of {element.count} is not complete", "repair the mesh"
    )


def _read_binary(element: Element, data: bytes, place: int, order: ByteOrder) -> int:
    """Read an element from a place on; returns the place behind it."""
    if not element.properties or not element.count:
        return place
    lengths = _first_lengths(element, data, place, order)
    row = _row_type(element, lengths, order)
    if not any(prop.length for prop in element.properties) or _all_alike(element, data, place, row, lengths):
        if len(data) < place + element.count * row.itemsize:
            raise _cut_short(element, (len(data) - place) // row.itemsize)
        table = np.frombuffer(data, row, element.count, place)
        for prop in element.properties:
            column = table[prop.name]
            if prop.length is None:
                element.numbers[prop.name] = column.astype(prop.dtype)
            else:
                counts = np.full(element.count, lengths[prop.name], np.int64)
                element.lists[prop.name] = counts, column.astype(prop.dtype).reshape(-1)
        return place + element.count * row.itemsize
    return _read_row_by_row(element, data, place, order)


def _first_lengths(element: Element, data: bytes, place: int, order: ByteOrder) -> dict[str, int]:
    """The lengths of the lists in an element's first row."""
    lengths: dict[str, int] = {}
    for prop in element.properties:
        count = 1
        if prop.length is not None:
            count = _length(element, 0, data, place, prop.length.newbyteorder(order))
            lengths[prop.name] = count
            place += prop.length.itemsize
        place += count * prop.dtype.itemsize
    return lengths


def _length(element: Element, index: int, data: bytes, place: int, kind: np.dtype) -> int:
    """The length of a list that begins at a place."""
    if place + kind.itemsize > len(data):
        raise _cut_short(element, index)
    count = int(np.frombuffer(data, kind, 1, place)[0])
    if count < 0 or place + count > len(data):
        raise QuadshadeError(
            f"{element.name} {index} has a list of {count}: it is cut short", "repair the mesh"
        )
    return count


def _row_type(element: Element, lengths: dict[str, int], order: ByteOrder) -> np.dtype:
    """The type of rows whose lists have these lengths."""
    fields: list[tuple[Any, ...]] = []
    for prop in element.properties:
        kind = prop.dtype.newbyteorder(order)
        if prop.length is None:
            fields.append((prop.name, kind))
        else:
            fields.append((f"length of {prop.name}", prop.length.newbyteorder(order)))
            fields.append((prop.name, kind, (lengths[prop.name],)))
    return np.dtype(fields)


def _all_alike(element: Element, data: bytes, place: int, row: np.dtype, lengths: dict[str, int]) -> bool:
    """Whether every row's lists are as long as the first row's."""
    if len(data) < place + element.count * row.itemsize:
        return False
    table = np.frombuffer(data, row, element.count, place)
    return all((table[f"length of {name}"] == count).all() for name, count in lengths.items())


def _read_row_by_row(element: Element, data: bytes, place: int, order: ByteOrder) -> int:
    """As :func:`_read_binary`, for lists of several lengths."""
    values: dict[str, list[np.ndarray]] = {prop.name: [] for prop in element.properties}
    for index in range(element.count):
        for prop in element.properties:
            count = 1
            if prop.length is not None:
                count = _length(element, index, data, place, prop.length.newbyteorder(order))
                place += prop.length.itemsize
            if place + count * prop.dtype.itemsize > len(data):
                raise _cut_short(element, index)
            values[prop.name].append(np.frombuffer(data, prop.dtype.newbyteorder(order), count, place))
            place += count * prop.dtype.itemsize
    for prop in element.properties:
        flat = np.concatenate(values[prop.name]).astype(prop.dtype)
        if prop.length is None:
            element.numbers[prop.name] = flat
        else:
            lengths = np.array([len(part) for part in values[prop.name]], dtype=np.int64)
            element.lists[prop.name] = lengths, flat
    return place


def _read_text(elements: list[Element], data: bytes) -> int:
    """Read all elements of a text file; returns how many words are left."""
    words = data.split()
    if max(map(len, words), default=0) > LONGEST_WORD:
        raise QuadshadeError(f"it has a word of more than {LONGEST_WORD} letters", "repair the mesh")
    try:
        numbers = np.array(words, dtype=np.bytes_).astype(np.float64)
    except ValueError as error:
        raise QuadshadeError(f"it has no number where one should be: {error}", "repair the mesh") from None
    place = 0
    for element in elements:
        place = _read_rows_of_text(element, numbers, place)
    return len(numbers) - place


def _read_rows_of_text(element: Element, numbers: np.ndarray, place: int) -> int:
    """Read an element from a place among all numbers on; returns the place behind it."""
    if not element.properties:
        return place
    if not any(prop.length for prop in element.properties):
        end = place + element.count * len(element.properties)
        if end > len(numbers):
            raise _cut_short(element, (len(numbers) - place) // len(element.properties))
        table = numbers[place:end].reshape(element.count, len(element.properties))
        for column, prop in enumerate(element.properties):
            element.numbers[prop.name] = _typed(table[:, column], prop)
        return end
    starts: dict[str, list[int]] = {prop.name: [] for prop in element.properties}
    counts: dict[str, list[int]] = {prop.name: [] for prop in element.properties}
    if element.count > len(numbers):
        raise _cut_short(element, len(numbers))
    for index in range(element.count):
        for prop in element.properties:
            count = 1
            if prop.length is not None:
                if place >= len(numbers):
                    raise _cut_short(element, index)
                length = numbers[place]
                if not (length >= 0 and length == np.floor(length)):
                    raise QuadshadeError(
                        f"{element.name} {index} has a list of {length:g}", "repair the mesh"
                    )
                count, place = int(min(length, len(numbers) + 1)), place + 1
            if place + count > len(numbers):
                raise _cut_short(element, index)
            starts[prop.name].append(place)
            counts[prop.name].append(count)
            place += count
    for prop in element.properties:
        lengths = np.array(counts[prop.name], dtype=np.int64)
        first = np.array(starts[prop.name], dtype=np.int64)
        offset = np.arange(lengths.sum()) - np.repeat(np.cumsum(lengths) - lengths, lengths)
        flat = _typed(numbers[np.repeat(first, lengths) + offset], prop)
        if prop.length is None:
            element.numbers[prop.name] = flat
        else:
            element.lists[prop.name] = lengths, flat
    return place


def _typed(values: np.ndarray, prop: Property) -> np.ndarray:
    """Numbers as the type that the header gives them."""
    if prop.dtype.kind == "f":
        with np.errstate(over="ignore"):
            return values.astype(prop.dtype)
    limits = np.iinfo(prop.dtype)
    bad = values[~((values >= limits.min) & (values <= limits.max) & (values == np.floor(values)))]
    if len(bad):
        raise QuadshadeError(f"its {prop.name} has {bad[0]:g}, which is no {prop.dtype}", "repair the mesh")
    return values.astype(prop.dtype)
