# SPDX-License-Identifier: Apache-2.0
"""What is found out for each triangle by itself, remembered: plans for other errors meet the same parts."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from quadshade.adapt.pair_numbers import PairNumbers
from quadshade.scene.project import Projected

WHOLE = -1
"""The parent of what is undivided."""
MOST_PARTS = 1 << 16
"""Remembered at a time, beside those of one call; about a kilobyte each."""


class Assessed(NamedTuple):
    """
    How well each order would do on triangles.

    Attributes
    ----------
    pixels : (n,) float64
      How many each triangle has.
    bound : (n,) float64
      What rounding the words of the highest order costs at most, in output units, from the set-up.
    packets : (n, 2) int64
      How many it takes to draw each, and how many of these have a second edge; negative where the words of
      the highest order are so coarse that the set-up divides it.
    samples : (n, channels, orders, 6) float64
      The best polynomial of each order.
    errors : (n, ...) float64
      What each order, or each of the options, leaves; by the shader's measure, output units (squared).
    options : (n, k, channels) int64
      Combinations of orders that are judged together; none where channels need not know of each other.
    words : (n, k) float64
      What these take.
    """

    pixels: np.ndarray
    bound: np.ndarray
    packets: np.ndarray
    samples: np.ndarray
    errors: np.ndarray
    options: np.ndarray
    words: np.ndarray

    def take(self, rows: np.ndarray) -> Assessed:
        """Some of the triangles, copied, in the order of (m,) int ``rows``."""
        return Assessed(*(values[rows] for values in self))

    def put(self, rows: np.ndarray | slice, values: Assessed) -> None:
        """Overwrite triangles in place."""
        for mine, others in zip(self, values, strict=True):
            mine[rows] = others

    def resized(self, count: int) -> Assessed:
        """The first ``count`` triangles, with room for those that there are not."""
        made = []
        for values in self:
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
        self._numbers = PairNumbers()
        self._store: Assessed | None = None
        self._halves, self._halved = np.empty((0, 3, 2, 0)), np.empty(0, dtype=bool)
        self._forgotten = 0

    def assessed(
        self, projected: Projected, root: np.ndarray, parent: np.ndarray, child: np.ndarray
    ) -> tuple[Assessed, np.ndarray]:
        """
        What is known of triangles.

        Parameters
        ----------
        projected : Projected
        root : (n,) int64
        parent, child : (n,) int64
          The number of the part that each is a part of, and which part of it; ``WHOLE`` and the root for a
          triangle of the undivided mesh. What a part is follows from them.

        Returns
        -------
        assessed : Assessed
        part : (n,) int64
          A number for each: the same triangle has the same one until it is forgotten, and no other has it.
        """
        if len(self._numbers) + len(root) > self._most:
            self._forgotten += len(self._numbers)
            self._numbers, self._store = PairNumbers(), None
            self._halves, self._halved = self._halves[:0], self._halved[:0]
        known = len(self._numbers)
        part = self._numbers.numbers(parent, child)
        new, first = np.unique(part, return_index=True)
        rows = first[new >= known]
        if len(rows) or self._store is None:
            made = self._assess(projected.ordered(rows), root[rows])
            store = made.resized(0) if self._store is None else self._store
            if len(store.pixels) < len(self._numbers):
                store = store.resized(max(len(self._numbers), 2 * len(store.pixels)))
            store.put(slice(known, len(self._numbers)), made)
            self._store = store
        return self._store.take(part), part + self._forgotten

    def halves(self, part: np.ndarray, make: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
        """
        What is known of triangles' halves.

        Parameters
        ----------
        part : (n,) int64
          Numbers from :meth:`assessed`, all different.
        make : function
          Finds it out, (m, 3, 2, ...) float64, for the rows (m,) int64 of ``part`` that are asked for first.

        Returns
        -------
        (n, 3, 2, ...) float64
        """
        place = part - self._forgotten
        if (place < 0).any():
            return make(np.arange(len(part)))
        if len(self._halved) < len(self._numbers):
            more = np.zeros(2 * len(self._numbers) - len(self._halved), dtype=bool)
            self._halved = np.concatenate([self._halved, more])
        new = np.flatnonzero(~self._halved[place])
        if len(new):
            made = make(new)
            if len(self._halves) < len(self._halved):
                grown = np.empty((len(self._halved), *made.shape[1:]))
                if len(self._halves):
                    grown[: len(self._halves)] = self._halves
                self._halves = grown
            self._halves[place[new]], self._halved[place[new]] = made, True
        return self._halves[place]
