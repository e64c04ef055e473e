# SPDX-License-Identifier: Apache-2.0
"""The triangles of which a picture shows something, with depth only where one of them hides another."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from quadshade.contract.formats import CONSTANT, Formats
from quadshade.contract.triangles import ScreenTriangles
from quadshade.engine import draw
from quadshade.image import visible
from quadshade.scene import Projected


def shown_triangles(projected: Projected, formats: Formats, keeps_depth: bool = False) -> Projected:
    """
    What of a scene draws the same picture in fewer bytes: its first lever, as it costs nothing.

    A triangle of which no pixel is seen is left out. One that shares no pixel with those that are left needs
    no depth: it gets that of the nearest, at all corners, which is one word instead of three. Those come
    first, so that packets of a kind follow each other.

    Parameters
    ----------
    projected : Projected
    formats : Formats
      Of a core of colours; without depth the last drawn is seen.
    keeps_depth : bool
      For who looks at the depth of the picture.

    Returns
    -------
    Projected
    """
    count = len(projected)
    if not count:
        return projected
    samples = np.zeros((count, formats.num_channels, 6))
    orders = np.full((count, formats.num_channels), CONSTANT)
    names = tuple(f"unused{index}" for index in range(formats.num_channels))
    depth = projected.depth if formats.with_depth else None
    width, height = projected.width, projected.height
    flat = ScreenTriangles(width, height, projected.vertices, samples, orders, depth, names)
    pixels = draw(flat, formats).pixels
    seen = visible(pixels, width, height)
    is_seen = np.zeros(count, bool)
    is_seen[pixels.triangle[seen[seen >= 0]]] = True
    if depth is None or keeps_depth:
        return projected.ordered(is_seen)
    # Of the pixels that are left, those where more than one was drawn.
    place = (pixels.y * width + pixels.x)[is_seen[pixels.triangle]]
    owner = pixels.triangle[is_seen[pixels.triangle]]
    needs_depth = np.zeros(count, bool)
    needs_depth[owner[np.bincount(place)[place] > 1]] = True
    order = np.concatenate([np.flatnonzero(is_seen & ~needs_depth), np.flatnonzero(needs_depth)])
    depth = np.where(needs_depth[:, None], projected.depth, 0.0)
    return replace(projected, depth=depth).ordered(order)
