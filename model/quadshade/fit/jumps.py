# SPDX-License-Identifier: Apache-2.0
"""Mach bands as a quadratic form: how far the colour's derivative jumps across shared edges."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from quadshade.contract.arrays import Bools, Floats, Ints
from quadshade.contract.formats import Formats
from quadshade.fit.elements import ENDS, Elements, neighbours_of

ALONG = (np.arange(8) + 0.5) / 8
"""Where along an edge the derivative is compared."""


@dataclass(frozen=True)
class Jumps:
    """
    Jumps of the normal derivative at ``ALONG`` of each edge that two triangles share, one on each side.

    Attributes
    ----------
    triangle, side : (e, 2) int64
      Triangles on both sides, and which of their edges 12, 13, 23 it is.
    length : (e,) float64
      Pixels.
    matrix : (e * len(ALONG), m) sparse
      Jumps from unknowns, in output units per pixel.
    """

    triangle: Ints
    side: Ints
    length: Floats
    matrix: sparse.csr_array

    def of_edges(self, values: Floats) -> Floats:
        """(e,) the root of the mean squared jump of each edge, of the channel where it is largest."""
        jump = (self.matrix @ values).reshape(len(self.length), len(ALONG), values.shape[1])
        return np.sqrt((jump**2).mean(axis=1)).max(axis=1, initial=0.0)


def jumps_of(elements: Elements, vertices: Ints, formats: Formats, wanted: Bools | None = None) -> Jumps:
    """
    Jumps as a linear function of the unknowns.

    Parameters
    ----------
    elements : Elements
    vertices : (n, 3, 2) int64
      Sub-pixels.
    formats : Formats
    wanted : (n, 3) bool, optional
      Edges 12, 13, 23 that are asked for; by default all.

    Returns
    -------
    Jumps
    """
    pairs = neighbours_of(elements, vertices).pairs
    if wanted is not None:
        pairs = pairs[wanted[pairs[:, 0, 0], pairs[:, 0, 1]]]
    triangle, side = np.moveaxis(pairs, 2, 0)
    place = vertices / 2.0**formats.subpixel_bits
    corners = ENDS[side]
    ends = place[triangle[:, 0, None], corners[:, 0]]
    along = ends[:, 1] - ends[:, 0]
    length = np.linalg.norm(along, axis=1)
    across = np.stack([-along[:, 1], along[:, 0]], axis=1) / length[:, None]
    # One row of the matrix a place: the slope on one side less that on the other.
    entries = np.zeros((len(length), len(ALONG), 2, 6))
    for number, share in enumerate(ALONG):
        point = ends[:, 0] + share * along
        for which, sign in ((0, 1.0), (1, -1.0)):
            entries[:, number, which] = sign * _slopes(place[triangle[:, which]], point, across)
    columns = np.repeat(elements.index[triangle][:, None], len(ALONG), axis=1)
    starts = np.arange(0, entries.size + 1, 12)
    shape = (len(starts) - 1, len(elements.start))
    matrix = sparse.csr_array((entries.reshape(-1), columns.reshape(-1), starts), shape=shape)
    return Jumps(triangle, side, length, matrix)


def jump_penalty(elements: Elements, vertices: Ints, formats: Formats) -> sparse.csr_array:
    """
    Squared jumps of the normal derivative, integrated along the edges that two triangles share.

    Parameters
    ----------
    elements, vertices, formats
      As for :func:`jumps_of`.

    Returns
    -------
    (m, m) sparse
      Times unknowns from both sides: the sum over edges of length times mean squared jump, in output units
      squared per pixel.
    """
    jumps = jumps_of(elements, vertices, formats)
    weight = sparse.diags_array(np.repeat(jumps.length / len(ALONG), len(ALONG)))
    return sparse.csr_array(jumps.matrix.T @ weight @ jumps.matrix)


def _slopes(corners: Floats, point: Floats, across: Floats) -> Floats:
    """(e, 6) derivatives of the shape functions of triangles (e, 3, 2) at points (e, 2) along (e, 2)."""
    legs = corners[:, 1:] - corners[:, :1]
    area = legs[:, 0, 0] * legs[:, 1, 1] - legs[:, 0, 1] * legs[:, 1, 0]
    # Triangles without area have no gradient: they take no part.
    area = np.where(area == 0, np.inf, area)
    off = point - corners[:, 0]
    second = (off[:, 0] * legs[:, 1, 1] - off[:, 1] * legs[:, 1, 0]) / area
    third = (legs[:, 0, 0] * off[:, 1] - legs[:, 0, 1] * off[:, 0]) / area
    weights = np.stack([1 - second - third, second, third], axis=1)
    d_second = (across[:, 0] * legs[:, 1, 1] - across[:, 1] * legs[:, 1, 0]) / area
    d_third = (legs[:, 0, 0] * across[:, 1] - legs[:, 0, 1] * across[:, 0]) / area
    d_weights = np.stack([-d_second - d_third, d_second, d_third], axis=1)
    vertices = d_weights * (4 * weights - 1)
    one, two = ENDS.T
    middles = 4 * (d_weights[:, one] * weights[:, two] + weights[:, one] * d_weights[:, two])
    return np.concatenate([vertices, middles], axis=1)
