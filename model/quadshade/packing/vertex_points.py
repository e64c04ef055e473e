# SPDX-License-Identifier: Apache-2.0
"""The corners and edge middles of primitives, as packets with vertices carry them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from quadshade.contract.arrays import Floats, Ints
from quadshade.contract.formats import CONSTANT, QUADRATIC, Formats
from quadshade.contract.triangles import ScreenTriangles
from quadshade.contract.vertex_program import LARGEST_SPAN, LARGEST_TRIM
from quadshade.packing.vertices import Points
from quadshade.setup.packet import Primitives


class _Triangles(NamedTuple):
    """
    What points come from: of each primitive its triangle and its channels' orders; the triangles' vertices
    (t, 3, 2) in sub-pixels, samples (t, c, 6) and depth (t, 3).
    """

    owners: Ints
    orders: Ints
    vertices: Ints
    samples: Floats
    depth: Floats


@njit(cache=True)
def _span(corners: Ints, column: int) -> tuple[int, int]:
    """Least and greatest number of a column of three corners."""
    one, two, three = corners[0, column], corners[1, column], corners[2, column]
    return min(one, two, three), max(one, two, three)


@njit(cache=True)
def _fill_points(given: _Triangles, covers: Ints, widths: tuple[int, int], scale: float, out: Points) -> None:
    """
    Write the points of primitives (``out``), of which only ``sent`` is given: those that may be.

    ``covers`` (n, k) begin with y and both counts of rows, ``widths`` are those of sub-pixels and of places
    on the screen, a sample has ``scale`` units a grey level.
    """
    subpixel_bits, screen_bits = widths
    pixel, size = 1 << subpixel_bits, 1 << screen_bits
    channels, three = out.middles.shape[2], np.zeros(3, np.int64)
    for p in range(len(out.sent)):
        owner, corners = given.owners[p], out.corners[p]
        for channel in range(channels):
            order, samples = given.orders[p, channel], given.samples[owner, channel]
            for corner in range(3):
                # What a channel of a lower order leaves out of its samples.
                three[corner] = np.int64(np.rint(samples[0 if order == CONSTANT else corner] * scale))
                corners[corner, 2 + channel] = three[corner]
            for middle in range(3):
                if order == QUADRATIC:
                    out.middles[p, middle, channel] = np.int64(np.rint(samples[3 + middle] * scale))
                    out.quadratic[p] = True
                else:
                    ends = three[0 if middle < 2 else 1] + three[1 if middle < 1 else 2]
                    out.middles[p, middle, channel] = ends >> 1
        for corner in range(3):
            corners[corner, :2] = given.vertices[owner, corner]
            if out.corners.shape[2] > 2 + channels:
                corners[corner, 2 + channels] = np.int64(np.rint(given.depth[owner, corner]))
        for column in range(2):
            low, high = _span(corners, column)
            out.sent[p] &= low >= 0 and high <= size and high - low < 1 << LARGEST_SPAN
        # The rows with a centre between the highest and the lowest corner; the last ``low`` is that of y.
        first = (2 * low + pixel - 1) >> (subpixel_bits + 1)
        end = (2 * high + pixel - 1) >> (subpixel_bits + 1)
        out.trims[p, 0] = covers[p, 0] - first
        out.trims[p, 1] = end - covers[p, 0] - covers[p, 1] - covers[p, 2]
        for trim in out.trims[p]:
            out.sent[p] &= 0 <= trim <= LARGEST_TRIM


def points_of(
    primitives: Primitives, triangles: ScreenTriangles, covers: Ints, formats: Formats, bits: int
) -> Points:
    """
    The points of all primitives, and which of them may be sent as such.

    Parameters
    ----------
    primitives : Primitives
    triangles : ScreenTriangles
      Those that they were set up from.
    covers : (n, k) int64
      Of each primitive, first y and both counts of rows.
    formats : Formats
    bits : int
      Fraction bits of a colour's sample.
    """
    size, owners = len(primitives), np.ascontiguousarray(primitives.triangle, np.int64)
    depth = triangles.depth
    sent = np.bincount(owners, minlength=len(triangles))[owners] == 1
    sent &= (primitives.header["fractional"] == 0) & ~primitives.undefined
    if formats.with_depth and depth is None:
        sent[:] = False
    given = _Triangles(
        owners,
        np.ascontiguousarray(primitives.orders, np.int64),
        np.ascontiguousarray(triangles.vertices, np.int64),
        np.ascontiguousarray(triangles.samples, np.float64),
        np.ascontiguousarray(np.zeros((len(triangles), 3)) if depth is None else depth, np.float64),
    )
    channels = formats.num_channels
    points = Points(
        np.zeros((size, 3, 2 + channels + formats.with_depth), np.int64),
        np.zeros((size, 3, channels), np.int64),
        np.zeros(size, np.bool_),
        np.zeros((size, 2), np.int64),
        sent,
    )
    widths = formats.subpixel_bits, formats.coord_bits + formats.subpixel_bits
    _fill_points(given, covers, widths, 2.0**bits, points)
    return points
