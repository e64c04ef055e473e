# SPDX-License-Identifier: Apache-2.0
"""One point of a sweep: draw it, compare it with Phong shading, count what it cost."""

from __future__ import annotations

import io
import math
import time
from dataclasses import dataclass
from typing import Any

import numpy as np
from PIL import Image

from quadshade.adapt import adapt
from quadshade.adapt.costs import state_bytes
from quadshade.contract.formats import SETUP_WORD_BITS, Formats
from quadshade.contract.triangles import ScreenTriangles
from quadshade.engine import draw
from quadshade.errors import QuadshadeError
from quadshade.fit import fit_colours
from quadshade.image import paint, visible
from quadshade.image.compare import error_map, psnr
from quadshade.packing.line import picture_line_bytes
from quadshade.scene import Projected
from quadshade.setup.triangle_setup import setup_triangles
from quadshade.shading import sample, sample_specular
from quadshade.trade.grid import Point
from quadshade.trade.view import BACKGROUND, Stage, phong_picture

HEAT_FULL = 32
"""Grey levels of error at the bright end of an error heat map; the same for all, so that they compare."""

HOST_RUNS = 2

REFERENCE = "reference.png"
"""Of a point whose triangles no other point has."""

MEASURED = (
    "psnr",
    "rms",
    "max_error",
    "bytes",
    "bytes_per_triangle",
    "line",
    "clocks",
    "pixels",
    "clocks_per_pixel",
    "host_seconds",
)


@dataclass(frozen=True)
class Measured:
    """
    What came out of a point.

    Attributes
    ----------
    record : dict
      The point, what was measured, and ``refused``: why the host refused to draw it, or None.
    files : dict of str to bytes
      ``picture.png``, ``error.png``, of an adaptive point ``reference.png``; none where it was refused.
    """

    record: dict[str, Any]
    files: dict[str, bytes]


def png(picture: np.ndarray) -> bytes:
    """A picture as the bytes of a PNG file."""
    buffer = io.BytesIO()
    Image.fromarray(picture).save(buffer, format="PNG", optimize=True)
    return buffer.getvalue()


def heat_map(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """
    The largest error of the channels at every pixel, from black (0) to bright (``HEAT_FULL`` and more).

    Parameters
    ----------
    one, other : (height, width, 3) uint8

    Returns
    -------
    (height, width, 3) uint8
    """
    from matplotlib import colormaps

    colours = colormaps["inferno"](np.linspace(0, 1, HEAT_FULL + 1), bytes=True)[:, :3]
    return colours[np.minimum(error_map(one, other), HEAT_FULL)]


def measure(point: Point, stage: Stage, base: Formats, engine: str) -> Measured:
    """
    Draw a point and compare it.

    Parameters
    ----------
    point : Point
    stage : Stage
      Of the point's subdivision.
    base : Formats
      Generics that the point does not set.
    engine : str

    Returns
    -------
    Measured
      ``psnr`` (dB, None where the picture is the reference), ``rms`` and ``max_error`` (grey levels) over all
      pixels and channels of the picture; ``bytes`` of set-up words a frame, of the shade unit's state too;
      ``line``, at most so many bytes on the serial line, None for a core that no board has; ``clocks`` a
      frame; ``host_seconds`` of processor time to shade, fit, set up and pack.

    Raises
    ------
    QuadshadeError
      The engine is missing or fails. A point that the host refuses raises nothing; its record says why.
    """
    formats = point.formats(base, stage.num_lights)
    record = {
        "name": point.name,
        "shading": point.shading,
        "order": point.order,
        "fraction": point.fraction,
        "subdivision": point.subdivision,
        "lod": point.lod,
        "fit": point.fit,
        "word_width": formats.word_width,
        "mesh_triangles": stage.mesh_triangles,
        "triangles": len(stage.projected),
        "refused": None,
    }
    try:
        parts, triangles = _triangles(point, stage, formats)
        record["triangles"] = len(parts)
        setup_triangles(triangles, formats)
        line = _line_bytes(triangles, formats)
        seconds = _host_seconds(point, stage, formats)
    except QuadshadeError as refusal:
        return Measured(record | dict.fromkeys(MEASURED) | {"refused": str(refusal)}, {})
    # No division for the bound of the rounding: what few fraction bits cost is what is looked for.
    drawing = draw(triangles, formats, engine, limit=None)
    shown = visible(drawing.pixels, parts.width, parts.height)
    picture = paint(shown, drawing.pixels.value, BACKGROUND, (1 << formats.value_bits) - 1)
    files = {"picture.png": png(picture)}
    reference = stage.reference
    if point.allowed is not None and not stage.is_level:
        # Division has moved vertices by up to half a sub-pixel: the reference is that of these triangles.
        reference = phong_picture(parts, stage.lights, stage.material, base)
        files[REFERENCE] = png(reference)
    files["error.png"] = png(heat_map(picture, reference))
    quality = psnr(picture, reference)
    difference = picture.astype(np.float64) - reference
    stats = drawing.stats
    size = stats["words"] * (SETUP_WORD_BITS // 8) + state_bytes(triangles, formats)
    record |= {
        "psnr": quality if math.isfinite(quality) else None,
        "rms": float(np.sqrt(np.mean(difference**2))),
        "max_error": int(np.abs(difference).max()),
        "bytes": size,
        "bytes_per_triangle": size / max(stage.mesh_triangles, 1),
        "line": line,
        "host_seconds": seconds,
        "clocks": stats["clocks"],
        "pixels": stats["pixels"],
        "clocks_per_pixel": stats["clocks_per_pixel"],
    }
    return Measured(record, files)


def _triangles(point: Point, stage: Stage, formats: Formats) -> tuple[Projected, ScreenTriangles]:
    """What is drawn, in the scene and on the screen."""
    parts = stage.projected
    if point.allowed is not None:
        adapted = adapt(parts, stage.lights, stage.material, formats, max_error=point.allowed, measure="rms")
        return adapted.projected, adapted.triangles
    if not formats.with_depth:
        parts = parts.back_to_front()
    if point.specular:
        return parts, sample_specular(parts, point.shading, stage.lights, stage.material, formats)
    triangles = sample(parts, point.shading, stage.lights, stage.material, formats)
    return parts, fit_colours(parts, triangles, point.fit, stage.lights, stage.material, formats)


def _line_bytes(triangles: ScreenTriangles, formats: Formats) -> int | None:
    """The most bytes on the line; None where no board has such a core."""
    try:
        return picture_line_bytes(triangles, formats, limit=None)
    except QuadshadeError:
        return None


def _host_seconds(point: Point, stage: Stage, formats: Formats) -> float:
    """Processor time from the mesh on the screen to packed words, the least of some runs."""
    least = math.inf
    for _ in range(HOST_RUNS):
        start = time.process_time()
        _line_bytes(_triangles(point, stage, formats)[1], formats)
        least = min(least, time.process_time() - start)
    return least
