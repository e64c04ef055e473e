# SPDX-License-Identifier: Apache-2.0
"""A number for each pair of integers that was ever met, in a compiled hash table."""

from __future__ import annotations

import numpy as np
from numba import njit

from quadshade.contract.arrays import Ints
from quadshade.scene.subdivide_loops import empty_slots, numbered


@njit(cache=True)
def _number_all(slots: Ints, pairs: Ints, count: int, first: Ints, second: Ints, out: Ints) -> int:
    """Numbers of pairs; returned is how many are known then."""
    for index in range(len(out)):
        out[index] = numbered(slots, pairs, count, first[index], second[index])
        count = max(count, out[index] + 1)
    return count


class PairNumbers:
    """Counts from 0: a pair that is new gets the next number, one that was met before keeps its own."""

    def __init__(self) -> None:
        self._slots, self._pairs, self._count = empty_slots(0), np.empty((0, 2), np.int64), 0

    def __len__(self) -> int:
        return self._count

    def numbers(self, first: Ints, second: Ints) -> Ints:
        """(n,) int64 numbers of (n,) pairs."""
        most = self._count + len(first)
        if most > len(self._pairs):
            pairs = np.empty((2 * most, 2), np.int64)
            pairs[: self._count] = self._pairs[: self._count]
            self._slots, self._pairs = empty_slots(len(pairs)), pairs
            known = pairs[: self._count].copy()
            _number_all(self._slots, pairs, 0, known[:, 0], known[:, 1], np.empty(len(known), np.int64))
        out = np.empty(len(first), np.int64)
        self._count = _number_all(self._slots, self._pairs, self._count, first, second, out)
        return out
