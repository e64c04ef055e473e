# SPDX-License-Identifier: Apache-2.0
"""
Quadratic Lagrange elements over the mesh on the screen: one unknown a vertex, one an edge.

Six values, at the vertices and the middles of the edges, are a quadratic. Neighbours that share an edge share
its three values, so they meet in value all along it. Where the six points differ (a crease, a seam between
colours, a border), each side keeps values of its own.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from quadshade.contract.arrays import Floats, Ints
from quadshade.contract.triangles import ScreenTriangles

SAME = 256
"""Corners at one place share an unknown if their colours are equal to 1 / 256 of an output unit."""

ENDS = np.array([[0, 1], [0, 2], [1, 2]])
"""Corners that edges 12, 13 and 23 join, in the order of the samples."""


@dataclass(frozen=True)
class Elements:
    """
    The unknowns of a mesh.

    Attributes
    ----------
    index : (n, 6) int64
      Unknown of each triangle's sample, in the order of ``ScreenTriangles.samples``.
    start : (m, c) float64
      The six points' values of the unknowns.
    """

    index: Ints
    start: Floats

    def samples(self, values: Floats) -> Floats:
        """(n, c, 6) samples of (m, c) values."""
        return values[self.index].transpose(0, 2, 1)


def shared_elements(triangles: ScreenTriangles) -> Elements:
    """
    Number the unknowns of quadratic triangles.

    Parameters
    ----------
    triangles : ScreenTriangles
      Sampled at six points.

    Returns
    -------
    Elements
    """
    count, channels = triangles.samples.shape[:2]
    colours = np.rint(triangles.samples.transpose(0, 2, 1) * SAME).astype(np.int64)
    corner = _numbers(
        np.concatenate([triangles.vertices.reshape(-1, 2), colours[:, :3].reshape(-1, channels)], axis=1)
    ).reshape(count, 3)
    ends = np.sort(corner[:, ENDS], axis=2).reshape(-1, 2)
    middle = _numbers(np.concatenate([ends, colours[:, 3:].reshape(-1, channels)], axis=1)).reshape(count, 3)
    index = np.concatenate([corner, middle + corner.max(initial=-1) + 1], axis=1)
    start = np.empty((int(index.max(initial=-1)) + 1, channels))
    start[index.reshape(-1)] = triangles.samples.transpose(0, 2, 1).reshape(-1, channels)
    return Elements(index, start)


def _numbers(rows: Ints) -> Ints:
    """(k,) the number of each distinct row of (k, w) int64."""
    return np.unique(rows, axis=0, return_inverse=True)[1].reshape(-1)
