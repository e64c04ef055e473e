# SPDX-License-Identifier: Apache-2.0
"""Loops over emitted pixels, compiled: which of them a place shows, and its colour."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from numba import njit

from quadshade.contract.arrays import Bytes, Ints

NOTHING = -1
"""Shown where no pixel was drawn."""

Columns = npt.NDArray[np.int32]


@njit(cache=True)
def outside(x: Columns, y: Columns, width: int, height: int) -> bool:
    """Whether any pixel lies outside the screen."""
    for index in range(len(x)):
        if not (0 <= x[index] < width and 0 <= y[index] < height):
            return True
    return False


@njit(cache=True)
def last_drawn(x: Columns, y: Columns, width: int, height: int) -> Ints:
    """(height, width) int64 index of the pixel drawn last at each place, or ``NOTHING``."""
    shown = np.full((height, width), NOTHING, dtype=np.int64)
    for index in range(len(x)):
        shown[y[index], x[index]] = index
    return shown


@njit(cache=True)
def nearest_drawn(x: Columns, y: Columns, depth: Columns, width: int, height: int) -> Ints:
    """(height, width) int64 index of the nearest pixel at each place, the first of equals, or ``NOTHING``."""
    shown = np.full((height, width), NOTHING, dtype=np.int64)
    for index in range(len(x)):
        before = shown[y[index], x[index]]
        if before == NOTHING or depth[index] < depth[before]:
            shown[y[index], x[index]] = index
    return shown


@njit(cache=True)
def fill(picture: Bytes, shown: Ints, value: npt.NDArray[np.int32]) -> None:
    """
    Write the colours of what is shown into a (height, width, 3) picture.

    One channel of ``value`` is shown grey, of more than three the first three; two leave blue black.
    """
    channels = value.shape[1]
    for row in range(picture.shape[0]):
        for column in range(picture.shape[1]):
            index = shown[row, column]
            if index == NOTHING:
                continue
            for colour in range(3):
                channel = 0 if channels == 1 else colour
                level = value[index, channel] if channel < channels else 0
                picture[row, column, colour] = min(max(level, 0), 255)


@njit(cache=True)
def differences(one: Bytes, other: Bytes) -> tuple[int, int]:
    """The largest difference of two rows of bytes, and the sum of all differences' squares."""
    largest, total = 0, 0
    for index in range(len(one)):
        # Bytes are unsigned, and so would be their difference.
        off = abs(int(np.int64(one[index])) - int(np.int64(other[index])))
        largest = max(largest, off)
        total += off * off
    return largest, total
