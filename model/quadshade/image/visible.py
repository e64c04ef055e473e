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
    # Here, so that who compares two files does not wait for the compiler.
    from quadshade.image.visible_loops import last_drawn, nearest_drawn, outside

    if outside(pixels.x, pixels.y, width, height):
        raise QuadshadeError(
            f"a pixel lies outside the screen of {width}x{height}", "draw with the same size"
        )
    if pixels.depth is None:
        return last_drawn(pixels.x, pixels.y, width, height)
    return nearest_drawn(pixels.x, pixels.y, pixels.depth, width, height)


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
    from quadshade.image.visible_loops import fill

    picture = np.empty((*shown.shape, 3), dtype=np.uint8)
    picture[:] = background
    if full != 255 or value.dtype.kind == "f":
        value = np.rint(value * (255 / full))
    fill(picture, shown, value)
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
