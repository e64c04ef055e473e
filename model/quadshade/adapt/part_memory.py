# SPDX-License-Identifier: Apache-2.0
"""What is found out for each triangle by itself, remembered: plans for other errors meet the same parts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields

import numpy as np

from quadshade.scene.project import Projected

MOST_PARTS = 1 << 16
"""Remembered at a time, beside those of one call; about a kilobyte each."""


@dataclass(frozen=True)
class Assessed:
    """
    How well each order would do on triangles.

    Attributes
    ----------
    pixels : (n,) float64
      How many each triangle has.
    bound : (n,) float64
      What rounding the words of the highest order costs at most, in output units, from the set-up.
    samples : (n, channels, orders, 6) float64
      The best polynomial of each order.
    errors : (n, ...) float64
      What each order, or each of the options, leaves; by the shader's measure, output units (squared).
    halves : (n, 3, 2, ...) float64
      The same for the halves, if edge 0-1, 1-2 or 2-0 is split.
    options : (n, k, channels) int64
      Combinations of orders that are judged together; none where channels need not know of each other.
    """

    pixels: np.ndarray
    bound: np.ndarray
    samples: np.ndarray
    errors: np.ndarray
    halves: np.ndarray
    options: np.ndarray

    def take(self, rows: np.ndarray) -> Assessed:
        """Some of the triangles, copied, in the order of (m,) int ``rows``."""
        return Assessed(*(getattr(self, field.name)[rows] for field in fields(self)))

    def put(self, rows: np.ndarray | slice, values: Assessed) -> None:
        """Overwrite triangles in place."""
        for field in fields(self):
            getattr(self, field.name)[rows] = getattr(values, field.name)

    def resized(self, count: int) -> Assessed:
        """The first ``count`` triangles, with room for those that there are not."""
        made = []
        for field in fields(self):
            values = getattr(self, field.name)
            grown = np.zeros((count, *values.shape[1:]), dtype=values.dtype)
            grown[: len(values)] = values[:count]
            made.append(grown)
        return Assessed(*made)


class PartMemory:
    """
    Assess triangles, each once.

    Parameters
    ----------
    assess : function
      What is found out about triangles and their roots, each by itself.
    most : int
      Triangles that are remembered; where they would be more, all are forgotten first.
    """

    def __init__(self, assess: Callable[[Projected, np.ndarray], Assessed], most: int = MOST_PARTS) -> None:
        self._assess, self._most = assess, most
        self._rows: dict[bytes, int] = {}
        self._store: Assessed | None = None
        self._forgotten = 0

    def assessed(self, projected: Projected, root: np.ndarray) -> tuple[Assessed, np.ndarray]:
        """
        What is known of triangles.

        Parameters
        ----------
        projected : Projected
        root : (n,) int64

        Returns
        -------
        assessed : Assessed
        part : (n,) int64
          A number for each: the same triangle has the same one until it is forgotten, and no other has it.
        """
        keys = _keys(projected, root)
        if len(self._rows) + len(keys) > self._most:
            self._forgotten += len(self._rows)
            self._rows, self._store = {}, None
        known, new = len(self._rows), []
        for index, key in enumerate(keys):
            if key not in self._rows:
                self._rows[key] = len(self._rows)
                new.append(index)
        if new or self._store is None:
            rows = np.array(new, dtype=np.int64)
            made = self._assess(projected.ordered(rows), root[rows])
            store = made.resized(0) if self._store is None else self._store
            if len(store.pixels) < len(self._rows):
                store = store.resized(max(len(self._rows), 2 * len(store.pixels)))
            store.put(slice(known, len(self._rows)), made)
            self._store = store
        part = np.array([self._rows[key] for key in keys], dtype=np.int64)
        return self._store.take(part), part + self._forgotten


def _keys(projected: Projected, root: np.ndarray) -> list[bytes]:
    """All that shading, covering and rounding of each triangle depend on, as bytes."""
    if not len(root):
        return []
    parts = [root, projected.vertices, projected.position, projected.normal, projected.weight]
    if projected.colour is not None:
        parts.append(projected.colour)
    columns = [np.asarray(values, dtype=np.float64).reshape(len(root), -1) for values in parts]
    table = np.ascontiguousarray(np.concatenate(columns, axis=1))
    return table.view(f"V{table.shape[1] * table.itemsize}").ravel().tolist()
