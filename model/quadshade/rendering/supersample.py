# SPDX-License-Identifier: Apache-2.0
"""
Jittered pictures: what a picture is the mean of, if it is supersampled.

Vertices are exact in sub-pixels, so a frame that is moved by a part of a pixel is drawn as exactly as any
other, with the colours that were sampled once. The host takes the mean of their display values.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import TypeVar

import numpy as np

from quadshade.contract.arrays import Bytes
from quadshade.contract.formats import Formats
from quadshade.contract.triangles import ScreenTriangles
from quadshade.errors import QuadshadeError
from quadshade.scene import Projected

OnScreen = TypeVar("OnScreen", ScreenTriangles, Projected)


def jitter(count: int, formats: Formats) -> list[tuple[int, int]]:
    """
    How far each frame is moved.

    Parameters
    ----------
    count : int
      Frames along each side of a pixel: 1, 2 or 4.
    formats : Formats

    Returns
    -------
    list of (x, y)
      Sub-pixels, from the middles of count x count equal parts of a pixel to its centre.

    Raises
    ------
    QuadshadeError
      Sub-pixels that are too coarse for so many pictures.
    """
    pixel = 1 << formats.subpixel_bits
    if pixel % (2 * count) and count > 1:
        raise QuadshadeError(
            f"--supersample {count} with generic subpixel_bits = {formats.subpixel_bits}",
            f"give at least {(2 * count).bit_length() - 1}",
        )
    steps = [pixel // 2 - pixel * (2 * part + 1) // (2 * count) for part in range(count)]
    return [(across, down) for down in steps for across in steps]


def moved(triangles: OnScreen, by: tuple[int, int], formats: Formats) -> OnScreen:
    """The same triangles, moved by so many sub-pixels; a vertex on the guard band's border stays within."""
    lowest, highest = formats.guard_band
    vertices = triangles.vertices + np.array(by, dtype=np.int64)
    return replace(triangles, vertices=np.clip(vertices, lowest, highest))


def mean(frames: Iterable[Bytes]) -> Bytes:
    """The mean of (h, w, 3) pictures, rounded to nearest, halves to even."""
    total, count = np.zeros(()), 0
    for frame in frames:
        total, count = total + frame.astype(np.float64), count + 1
    return np.rint(total / count).astype(np.uint8)
