# SPDX-License-Identifier: Apache-2.0
"""From the pixels that an engine emits to a picture."""

from __future__ import annotations

import numpy as np

from quadshade.contract.triangles import Pixels
from quadshade.errors import QuadshadeError


def visible(pixels: Pixels, width: int, height: int) -> np.ndarray:
    """
    Which emitted pixel each place of the screen shows.

    With depth, the nearest one; of equally near ones the first drawn. Without, the last drawn (painter's
    order).

    Parameters
    ----------
    pixels : Pixels
    width, height : int

    Returns
    -------
    (height, width) int64
      Index into ``pixels``, or -1 where nothing was drawn.

    Raises
    ------
    QuadshadeError
      A pixel outside the screen.
    """
    count = len(pixels)
    if count and not (
        pixels.x.min() >= 0 and pixels.x.max() < width and pixels.y.min() >= 0 and pixels.y.max() < height
    ):
        raise QuadshadeError(
            f"a pixel lies outside the screen of {width}x{height}", "draw with the same size"
        )
    place = pixels.y.astype(np.int64) * width + pixels.x
    index = np.arange(count, dtype=np.int64)
    shown = np.full(width * height, -1, dtype=np.int64)
    if pixels.depth is None:
        np.maximum.at(shown, place, index)
        return shown.reshape(height, width)
    nearest = np.full(width * height, np.iinfo(np.int64).max)
    depth = pixels.depth.astype(np.int64)
    np.minimum.at(nearest, place, depth)
    first = np.full(width * height, count, dtype=np.int64)
    candidates = np.flatnonzero(depth == nearest[place])
    np.minimum.at(first, place[candidates], candidates)
    shown[first < count] = first[first < count]
    return shown.reshape(height, width)


def paint(
    shown: np.ndarray, value: np.ndarray, background: tuple[int, int, int], full: int = 255
) -> np.ndarray:
    """
    The picture of chosen pixels.

    Parameters
    ----------
    shown : (height, width) int
      From :func:`visible`.
    value : (n, channels) int or float
      One channel is shown grey, of more than three the first three; two leave blue black.
    background : 3 ints
      0 .. 255.
    full : int
      Value of full intensity, 2**value_bits - 1.

    Returns
    -------
    (height, width, 3) uint8
    """
    picture = np.empty((*shown.shape, 3), dtype=np.uint8)
    picture[:] = background
    drawn = shown >= 0
    chosen = value[shown[drawn]][:, :3]
    if full != 255 or chosen.dtype.kind == "f":
        chosen = np.rint(chosen * (255 / full))
    colours = np.zeros((len(chosen), 3), dtype=np.uint8)
    colours[:, : chosen.shape[1]] = np.clip(chosen, 0, 255)
    if chosen.shape[1] == 1:
        colours[:] = colours[:, :1]
    picture[drawn] = colours
    return picture


def resolve(
    pixels: Pixels,
    width: int,
    height: int,
    background: tuple[int, int, int] = (0, 0, 0),
    full: int = 255,
) -> np.ndarray:
    """(height, width, 3) uint8 picture of emitted pixels: :func:`visible`, then :func:`paint`."""
    return paint(visible(pixels, width, height), pixels.value, background, full)
