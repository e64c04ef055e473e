# SPDX-License-Identifier: Apache-2.0
"""Mach bands as a quadratic form: how far the colour's derivative jumps across shared edges."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from quadshade.contract.arrays import Floats, Ints
from quadshade.contract.formats import Formats
from quadshade.fit.elements import ENDS, Elements

ALONG = (np.arange(8) + 0.5) / 8
"""Where along an edge the derivative is compared."""


def jump_penalty(elements: Elements, vertices: Ints, formats: Formats) -> sparse.csr_array:
    """
    Squared jumps of the normal derivative, integrated along the edges that two triangles share.

    Parameters
    ----------
    elements : Elements
    vertices : (n, 3, 2) int64
      Sub-pixels.
    formats : Formats

    Returns
    -------
    (m, m) sparse
      Times unknowns from both sides: the sum over edges of length times mean squared jump, in output units
      squared per pixel.
    """
    triangle, side = _shared_edges(elements)
    place = vertices / 2.0**formats.subpixel_bits
    corners = ENDS[side]
    ends = place[triangle[:, 0, None], corners[:, 0]]
    along = ends[:, 1] - ends[:, 0]
    length = np.linalg.norm(along, axis=1)
    # Two corners on one sub-pixel have no edge between them.
    keep = length > 0
    triangle, ends, along, length = triangle[keep], ends[keep], along[keep], length[keep]
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
    jump = sparse.csr_array((entries.reshape(-1), columns.reshape(-1), starts), shape=shape)
    weight = sparse.diags_array(np.repeat(length / len(ALONG), len(ALONG)))
    return sparse.csr_array(jump.T @ weight @ jump)


def _shared_edges(elements: Elements) -> tuple[Ints, Ints]:
    """(e, 2) triangles on both sides of edges that exactly two share, and (e, 2) which edge it is."""
    middles = elements.index[:, 3:].reshape(-1)
    order = np.argsort(middles, kind="stable")
    counts = np.bincount(middles, minlength=len(elements.start))
    first = (np.cumsum(counts) - counts)[counts == 2]
    pairs = np.stack([order[first], order[first + 1]], axis=1)
    return pairs // 3, pairs % 3


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
