# SPDX-License-Identifier: Apache-2.0
"""Triangles given explicitly, in JSON (docs/reference/triangles_file.md)."""

from __future__ import annotations

import json
import math
import os
from pathlib import Path
from typing import Any

import numpy as np

from quadshade.contract.formats import CONSTANT, LINEAR, ORDER_NAMES, QUADRATIC, Formats
from quadshade.contract.triangles import ScreenTriangles
from quadshade.errors import QuadshadeError
from quadshade.files.atomic import write_text
from quadshade.files.shade_file import read_shade, shade_content

MAX_CHANNELS = 8
_ORDER_OF_LENGTH = {1: CONSTANT, 3: LINEAR, 6: QUADRATIC}
_MEMORY_PER_BYTE = 10
"""Bytes that a byte of JSON takes once read, rounded up: the text twice, and 32 for a number of 4 or more."""


class _Fault(Exception):
    """What is wrong with one triangle; the caller adds where."""


def _available_memory() -> int:
    """Bytes of memory that can still be had; a number too large to matter where the system does not say."""
    try:
        for line in Path("/proc/meminfo").read_text().splitlines():
            if line.startswith("MemAvailable:"):
                return int(line.split()[1]) * 1024
    except OSError:
        pass
    return 1 << 62


def _load(path: Path) -> dict[str, Any]:
    """The file's JSON object."""
    try:
        size = os.stat(path).st_size
        if size * _MEMORY_PER_BYTE > _available_memory():
            raise QuadshadeError(
                f"{path}: too many triangles for this machine's memory ({size >> 20} MiB of JSON)",
                "split the file",
            )
        content = json.loads(Path(path).read_bytes())
    except OSError as error:
        raise QuadshadeError(
            f"cannot read {path}: {error.strerror or error}", "give a triangles file"
        ) from None
    except MemoryError:
        raise QuadshadeError(f"{path}: too many triangles for memory", "split the file") from None
    except (ValueError, RecursionError) as error:
        text = "it is no text" if isinstance(error, UnicodeDecodeError) else " ".join(str(error).split())
        raise QuadshadeError(
            f"{path}: not JSON: {text}",
            "see docs/reference/triangles_file.md; `quadshade render` draws meshes",
        ) from None
    if not isinstance(content, dict):
        raise QuadshadeError(f"{path}: not a JSON object", "see docs/reference/triangles_file.md")
    return content


def _number(value: object) -> float:
    """A JSON number as float; a _Fault with the reason where it is none, or not finite."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise _Fault(f"{json.dumps(value)[:40]} is not a number")
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise _Fault(f"{number} is not finite")
    return number


def _numbers(values: object, lengths: tuple[int, ...], what: str) -> list[float]:
    """A JSON array of numbers of one of the given lengths."""
    if not isinstance(values, list) or len(values) not in lengths:
        got = f"{len(values)} values" if isinstance(values, list) else json.dumps(values)[:40]
        raise _Fault(f"{what} is {got}, not {' or '.join(map(str, lengths))} numbers")
    try:
        return [_number(value) for value in values]
    except _Fault as error:
        raise _Fault(f"{what}: {error}") from None


def _in_range(values: list[float], top: int, what: str, low: int = 0) -> list[float]:
    if min(values) < low or max(values) > top:
        raise _Fault(f"{what} has {next(v for v in values if not low <= v <= top)}, outside {low} .. {top}")
    return values


def _read_vertices(triangle: dict[str, Any], formats: Formats, out: np.ndarray) -> None:
    corners = triangle.get("vertices")
    if not isinstance(corners, list) or len(corners) != 3:
        raise _Fault("vertices is missing or is not three points")
    scale = 1 << formats.subpixel_bits
    low, high = formats.guard_band
    for corner, point in enumerate(corners):
        for axis, value in enumerate(_numbers(point, (2,), f"vertex {corner + 1}")):
            # Scaling by a power of two is exact, and round() takes ties to even.
            place = round(value * scale) if abs(value) < 2 * high else 2 * high
            if not low <= place <= high:
                raise _Fault(
                    f"triangle out of range: vertex {corner + 1} at {value},"
                    f" outside {low // scale} .. {high / scale:.10g} pixels"
                )
            out[corner, axis] = place


def _read_samples(
    triangle: dict[str, Any], channels: list[str], low: int, top: int, samples: np.ndarray, orders: np.ndarray
) -> None:
    given = triangle.get("samples")
    if not isinstance(given, dict):
        raise _Fault("samples is missing or is not an object")
    for name in given:
        if name not in channels:
            raise _Fault(f"unknown channel {name!r}, the file's channels are {', '.join(channels)}")
    for index, name in enumerate(channels):
        if name not in given:
            raise _Fault(f"no samples for channel {name!r}")
        what = f"channel {name!r}"
        values = _in_range(_numbers(given[name], (6, 3, 1), what), top, what, low)
        samples[index, : len(values)] = values
        orders[index] = _ORDER_OF_LENGTH[len(values)]


def _check_head(content: dict[str, Any], path: Path) -> tuple[list[str], list[Any]]:
    """Channel names and triangles of a file's object; the screen's size is checked too."""
    for key in ("width", "height"):
        value = content.get(key)
        if isinstance(value, bool) or not isinstance(value, int) or value < 1:
            raise QuadshadeError(
                f"{path}: {key} is {json.dumps(value)[:40]}", "give a whole number of pixels, at least 1"
            )
    channels = content.get("channels")
    if (
        not isinstance(channels, list)
        or not 1 <= len(channels) <= MAX_CHANNELS
        or not all(isinstance(name, str) and name for name in channels)
        or len(set(channels)) != len(channels)
    ):
        raise QuadshadeError(
            f"{path}: channels is {json.dumps(channels)[:60]}",
            f"give a list of 1 to {MAX_CHANNELS} different names",
        )
    triangles = content.get("triangles")
    if not isinstance(triangles, list):
        raise QuadshadeError(
            f"{path}: triangles is missing or is not a list", "see docs/reference/triangles_file.md"
        )
    return channels, triangles


def _has_depth(triangles: list[Any]) -> bool:
    return any(isinstance(triangle, dict) and "depth" in triangle for triangle in triangles)


def _convert(content: dict[str, Any], path: Path, formats: Formats) -> ScreenTriangles:
    """The file's triangles, each checked."""
    channels, given = _check_head(content, path)
    limit = 1 << formats.coord_bits
    for key in ("width", "height"):
        if content[key] > limit:
            raise QuadshadeError(
                f"{path}: {key} is {content[key]}", f"give at most {limit}, or raise generic coord_bits"
            )
    count, with_depth = len(given), _has_depth(given)
    vertices = np.zeros((count, 3, 2), dtype=np.int64)
    samples = np.zeros((count, len(channels), 6))
    orders = np.zeros((count, len(channels)), dtype=np.int64)
    depth = np.zeros((count, 3)) if with_depth else None
    value_top, depth_top = (1 << formats.value_bits) - 1, (1 << formats.depth_bits) - 1
    # A cosine may be negative: with shade it becomes zero at each pixel, not at the samples.
    value_low = -value_top if "shade" in content else 0
    for index, triangle in enumerate(given):
        try:
            if not isinstance(triangle, dict):
                raise _Fault("is not an object")
            _read_vertices(triangle, formats, vertices[index])
            _read_samples(triangle, channels, value_low, value_top, samples[index], orders[index])
            if orders[index].max() > formats.max_order:
                raise _Fault(
                    f"is {ORDER_NAMES[orders[index].max()]}, generic max_order is {formats.max_order}"
                )
            if depth is not None:
                if "depth" not in triangle:
                    raise _Fault("has no depth, others have")
                depth[index] = _in_range(_numbers(triangle["depth"], (3,), "depth"), depth_top, "depth")
        except _Fault as error:
            raise QuadshadeError(
                f"{path}: triangle {index}: {error}", "see docs/reference/triangles_file.md"
            ) from None
    shade = None
    if "shade" in content:
        shade = read_shade(content["shade"], channels, path).state(formats)
    return ScreenTriangles(
        content["width"], content["height"], vertices, samples, orders, depth, tuple(channels), shade
    )


def screen_size(path: Path) -> tuple[int, int]:
    """
    Width and height that a triangles file is for.

    Raises
    ------
    QuadshadeError
      As :func:`read_triangles`, of the file's beginning.
    """
    content = _load(path)
    _check_head(content, path)
    return content["width"], content["height"]


def read_triangles(path: Path, formats: Formats) -> ScreenTriangles:
    """
    Read a triangles file.

    Parameters
    ----------
    path : Path
    formats : Formats
      Its sub-pixel bits round the vertices (ties to even); its value and depth bits, coordinates and highest
      order limit what is accepted. Its number of channels is not looked at: see :func:`open_triangles`.

    Returns
    -------
    ScreenTriangles
      ``depth`` is None where no triangle has one.

    Raises
    ------
    QuadshadeError
      A file that cannot be read, is malformed, or holds something out of range; it names file and triangle.
    """
    return _convert(_load(path), path, formats)


def open_triangles(path: Path, generics: dict[str, int]) -> tuple[ScreenTriangles, Formats]:
    """
    Read a triangles file, and fit the core's formats to it: number of channels, depth, shade.

    Parameters
    ----------
    path : Path
    generics : dict of str to int
      Generics that the user has set; they win.

    Returns
    -------
    triangles : ScreenTriangles
    formats : Formats

    Raises
    ------
    QuadshadeError
      As :func:`read_triangles`; a wrong generic; one that contradicts the file.
    """
    content = _load(path)
    channels, given = _check_head(content, path)
    fitted = {"num_channels": len(channels), "with_depth": int(_has_depth(given))}
    if "shade" in content:
        shade = read_shade(content["shade"], channels, path)
        fitted |= {"with_shade": 1, "num_specular": shade.specular}
    formats = Formats().with_generics(fitted | generics)
    for name in ("with_shade", "num_specular"):
        if name in fitted and getattr(formats, name) != fitted[name]:
            raise QuadshadeError(
                f"generic {name} is {getattr(formats, name)}, {path} needs {fitted[name]}",
                "leave the generic out",
            )
    if formats.num_channels != len(channels):
        raise QuadshadeError(
            f"generic num_channels is {formats.num_channels}, {path} has {len(channels)} channels",
            "leave the generic out",
        )
    if fitted["with_depth"] and not formats.with_depth:
        raise QuadshadeError(f"generic with_depth is 0, {path} has depth", "leave the generic out")
    return _convert(content, path, formats), formats


def write_triangles(path: Path, triangles: ScreenTriangles, formats: Formats) -> None:
    """
    Write a triangles file; :func:`read_triangles` gives the same triangles back.

    Parameters
    ----------
    path : Path
    triangles : ScreenTriangles
    formats : Formats
      Its sub-pixel bits turn the vertices into pixels; its other formats are those of the shade unit's state.

    Raises
    ------
    QuadshadeError
      The file cannot be written.
    """
    corners = (triangles.vertices / (1 << formats.subpixel_bits)).tolist()
    length = {order: length for length, order in _ORDER_OF_LENGTH.items()}
    listed = []
    for index in range(len(triangles)):
        entry = {
            "vertices": corners[index],
            "samples": {
                name: triangles.samples[index, channel, : length[int(order)]].tolist()
                for channel, (name, order) in enumerate(
                    zip(triangles.channels, triangles.orders[index], strict=True)
                )
            },
        }
        if triangles.depth is not None:
            entry["depth"] = triangles.depth[index].tolist()
        listed.append(entry)
    content = {
        "width": int(triangles.width),
        "height": int(triangles.height),
        "channels": list(triangles.channels),
        "triangles": listed,
    }
    if triangles.shade is not None:
        content["shade"] = shade_content(triangles.shade, formats)
    write_text(Path(path), json.dumps(content) + "\n")
