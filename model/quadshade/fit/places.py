# SPDX-License-Identifier: Apache-2.0
"""Where a fit takes the error: at the pixels that are drawn, or at some points of every triangle."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numba import njit

from quadshade.contract.arrays import Floats, Ints
from quadshade.contract.formats import Formats
from quadshade.errors import QuadshadeError
from quadshade.fit.columns import first_column
from quadshade.scene.project import Projected, doubled_area

PLACES = ("pixels", "points")
STEPS = 3
"""``points``: a triangle's edges are cut into so many parts; a point stands in the middle of each piece."""

BEYOND = 0.02
"""``pixels``: what a pixel's area counts where it is not drawn."""


@dataclass(frozen=True)
class Places:
    """
    Points of triangles.

    Attributes
    ----------
    triangle : (p,) int64
    weights : (p, 3) float64
      Barycentric coordinates on the screen.
    area : (p,) float64
      Pixels that the place stands for.
    """

    triangle: Ints
    weights: Floats
    area: Floats


def places_of(kind: str, projected: Projected, formats: Formats) -> Places:
    """
    The places of a kind.

    Parameters
    ----------
    kind : str
      ``pixels``: the centres of all pixels that the core draws. ``points``: 9 of every triangle.
    projected : Projected
    formats : Formats

    Returns
    -------
    Places

    Raises
    ------
    QuadshadeError
      An unknown kind.
    """
    if kind == "points":
        return _points(projected, formats)
    if kind == "pixels":
        vertices = np.asarray(projected.vertices, dtype=np.int64)
        screen = projected.width, projected.height, 1 << formats.subpixel_bits
        triangle, weights = _pixels(vertices, *_spans(vertices, *screen), screen[2])
        return Places(triangle, weights, np.ones(len(triangle)))
    raise QuadshadeError(f"a fit at {kind!r}", f"give {' or '.join(PLACES)}")


@njit(cache=True)
def _span(corners: Ints, y: int, width: int, scale: int) -> tuple[int, int]:
    """The first pixel of a triangle's scanline on the screen, and the one after its last."""
    left, right = width, 0
    height = y * scale + scale // 2
    for corner in range(3):
        top, bottom = corners[corner], corners[(corner + 1) % 3]
        if top[1] > bottom[1]:
            top, bottom = bottom, top
        if top[1] <= height < bottom[1]:
            column = min(max(first_column(top, bottom, height, scale), 0), width)
            left, right = min(left, column), max(right, column)
    return left, right


@njit(cache=True)
def _scanlines(corners: Ints, height: int, scale: int) -> tuple[int, int]:
    """The first scanline on the screen that a triangle may have a pixel on, and the one after the last."""
    low, high = corners[:, 1].min(), corners[:, 1].max()
    half = scale // 2
    return max(-((half - low) // scale), 0), min(-((half - high) // scale), height)


@njit(cache=True)
def _spans(vertices: Ints, width: int, height: int, scale: int) -> tuple[Ints, int]:
    """(s, 4) triangle, height, first pixel and the one after the last of every scanline; and all pixels."""
    rows = 0
    for triangle in range(len(vertices)):
        begin, end = _scanlines(vertices[triangle], height, scale)
        rows += max(end - begin, 0)
    spans, count, pixels = np.empty((rows, 4), np.int64), 0, 0
    for triangle in range(len(vertices)):
        begin, end = _scanlines(vertices[triangle], height, scale)
        for y in range(begin, end):
            left, right = _span(vertices[triangle], y, width, scale)
            if left < right:
                span = spans[count]
                span[0], span[1], span[2], span[3] = triangle, y, left, right
                count += 1
                pixels += right - left
    return spans[:count], pixels


@njit(cache=True)
def _pixels(vertices: Ints, spans: Ints, pixels: int, scale: int) -> tuple[Ints, Floats]:
    """Owners and barycentric coordinates of all pixels, with the exact coverage of the golden model."""
    owner, weights = np.empty(pixels, np.int64), np.empty((pixels, 3))
    at = 0
    for triangle, y, left, right in spans:
        one, two, three = vertices[triangle]
        out_x, out_y = two[0] - one[0], two[1] - one[1]
        back_x, back_y = three[0] - one[0], three[1] - one[1]
        area = float(out_x * back_y - back_x * out_y)
        down = y * scale + scale // 2 - one[1]
        for x in range(left, right):
            across = x * scale + scale // 2 - one[0]
            second, third = (across * back_y - back_x * down) / area, (out_x * down - across * out_y) / area
            owner[at] = triangle
            weights[at, 0], weights[at, 1], weights[at, 2] = 1 - second - third, second, third
            at += 1
    return owner, weights


def held_beyond(projected: Projected, formats: Formats) -> Floats:
    """(n,) what each of a triangle's six points counts beside its pixels: those may not see all of it."""
    return BEYOND / 6 * _areas(projected, formats)


def without_wrong(places: Places, target: Floats) -> tuple[Places, Floats, int]:
    """The same, without weight where a target (p, c) is no number; and how many triangles that is."""
    if np.isfinite(target).all():
        return places, target, 0
    wrong = np.asarray(~np.isfinite(target).all(axis=1))
    kept = replace(places, area=np.where(wrong, 0.0, places.area))
    return kept, np.where(wrong[:, None], 0.0, target), len(np.unique(places.triangle[wrong]))


def _areas(projected: Projected, formats: Formats) -> Floats:
    """(n,) pixels."""
    return np.abs(doubled_area(projected.vertices)) / 2 / 4.0**formats.subpixel_bits


def _points(projected: Projected, formats: Formats) -> Places:
    """The middles of the ``STEPS``**2 equal pieces that a triangle is cut into."""
    corners = [
        (np.array([first, second, STEPS - first - second - 1]) + turn) / STEPS
        for first in range(STEPS)
        for second in range(STEPS - first)
        for turn in ([1 / 3] * 3, [2 / 3, 2 / 3, -1 / 3])
    ]
    inside = np.array([corner for corner in corners if corner.min() > 0])
    area = _areas(projected, formats)
    return Places(
        np.repeat(np.arange(len(projected)), len(inside)),
        np.tile(inside, (len(projected), 1)),
        np.repeat(area / len(inside), len(inside)),
    )
