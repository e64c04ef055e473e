# SPDX-License-Identifier: Apache-2.0
"""
Words with fewer fraction bits: as many dropped from each difference as the triangle's size and an error
allow.

A unit of a difference is worth the more at a pixel the more steps follow it, so each difference drops its own
number of bits, such that all of them cost about the same. They are rounded jointly, each to its own unit, as
:mod:`quadshade.setup.quantise` does; what that adds is bounded by E's true maximum, again, before anything is
sent.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numba import njit

from quadshade.contract.formats import CONSTANT, DIFFERENCES, DIFFERENCES_OF_ORDER, Formats
from quadshade.contract.packed_format import CHANNEL_KINDS, channel_kinds
from quadshade.setup.edges import (
    COLUMN,
    HEAD_FIELDS,
    HEIGHT,
    INCREMENT,
    REMAINDER,
    ROWS_FIRST,
    ROWS_SECOND,
    STATE_FIELDS,
    STEP,
)
from quadshade.setup.packet import Primitives
from quadshade.setup.quantise import (
    FIT_FIELDS,
    SAMPLE_POINTS,
    coarse_words,
    difference_spreads,
    fit_linear,
    region,
)

NUM_DIFFERENCES = len(DIFFERENCES)
Hold = Callable[[np.ndarray, np.ndarray], np.ndarray]
STEP_BITS = 0.5
"""How finely the number of dropped bits is searched: differences follow one by one."""


@dataclass(frozen=True)
class Regions:
    """
    Where each primitive has its pixels, for error bounds.

    Attributes
    ----------
    corners : (n, 8, 2) float64
    count : (n,) int64
      Corners used.
    fit : (n, FIT_FIELDS) float64
    """

    corners: np.ndarray
    count: np.ndarray
    fit: np.ndarray


@njit(cache=True)
def _regions(heads, edges, fractional, corners, count, fit):
    scratch = np.zeros((SAMPLE_POINTS, 5))
    for p in range(len(heads)):
        count[p] = region(heads[p], edges[p], fractional[p], corners[p])
        fit_linear(corners[p], count[p], scratch, fit[p])


def primitive_regions(primitives: Primitives) -> Regions:
    """The regions of primitives."""
    size = len(primitives)
    heads, edges = np.zeros((size, HEAD_FIELDS), np.int64), np.zeros((size, 3, STATE_FIELDS), np.int64)
    heads[:, ROWS_FIRST] = primitives.header["rows_first"]
    heads[:, ROWS_SECOND] = primitives.header["rows_second"]
    for index, edge in enumerate(primitives.edges.values()):
        edges[:, index, COLUMN], edges[:, index, STEP] = edge["column"], edge["step"]
        edges[:, index, REMAINDER] = edge["error"] - edge["decrement"]
        edges[:, index, INCREMENT] = edge["increment"]
        edges[:, index, HEIGHT] = edge["increment"] - edge["decrement"]
    corners, count = np.zeros((size, 8, 2)), np.zeros(size, np.int64)
    fit = np.zeros((size, FIT_FIELDS))
    _regions(heads, edges, primitives.header["fractional"] != 0, corners, count, fit)
    return Regions(corners, count, fit)


@njit(cache=True)
def _round(p, words, orders, corners, count, fit, channels, shifts, budgets, word_width, out):
    """
    Round one kind's channels of a primitive (written to ``out``, (c, 6)); the largest share of a budget used.
    """
    worst = 0.0
    scaled, off = np.zeros(FIT_FIELDS), np.zeros(NUM_DIFFERENCES)
    half = np.int64(1) << (word_width - 1)
    for channel in channels:
        added = coarse_words(
            words[p, channel], shifts, orders[p, channel], corners[p], count[p], fit[p], scaled, off,
            out[channel],
        )  # fmt: skip
        worst = max(worst, added / budgets[channel])
        for difference in range(NUM_DIFFERENCES):
            out[channel, difference] = ((out[channel, difference] + half) & (2 * half - 1)) - half
    return worst


@njit(cache=True)
def _most(words, orders, corners, count, fit, channels, budgets, word_width, out):
    """Most bits that a kind of channels drops from each difference of every primitive (``out``, (n, 6))."""
    spreads, shifts = np.zeros(NUM_DIFFERENCES), np.zeros(NUM_DIFFERENCES, np.int64)
    rounded = np.zeros(words.shape[1:], np.int64)
    budget = np.inf
    for channel in channels:
        budget = min(budget, budgets[channel])
    for p in range(len(words)):
        difference_spreads(fit[p], spreads)
        highest = 0
        for channel in channels:
            highest = max(highest, orders[p, channel])
        start = np.log2(budget) + (1.0 if highest == CONSTANT else 1.5)
        while start > -1.0:
            for difference in range(NUM_DIFFERENCES):
                shifts[difference] = min(
                    max(np.int64(np.floor(start - spreads[difference])), 0), word_width - 1
                )
            share = _round(
                p, words, orders, corners, count, fit, channels, shifts, budgets, word_width, rounded
            )
            if share <= 1.0:
                out[p] = shifts
                break
            start -= STEP_BITS


@njit(cache=True)
def _apply(words, orders, corners, count, fit, channels, budgets, shifts, word_width, out, used):
    """Round every primitive's channels of a kind as ``shifts`` (n, 6) say; ``used`` shares of the budget."""
    for p in range(len(words)):
        used[p] = _round(
            p, words, orders, corners, count, fit, channels, shifts[p], budgets, word_width, out[p]
        )


def short_words(
    primitives: Primitives, formats: Formats, budgets: np.ndarray, hold: Hold
) -> tuple[Primitives, np.ndarray]:
    """
    Drop fraction bits of primitives' words.

    Parameters
    ----------
    primitives : Primitives
    formats : Formats
    budgets : (c,) float64
      Most that may be added to the error of each channel at any pixel, in output units.
    hold : callable
      What the bits dropped, (n, 6) per kind of channels, cost beside them: takes the most that each primitive
      may drop of each difference and how many channels have it, gives what it shall drop, which is not more.

    Returns
    -------
    primitives : Primitives
      With these words, and bounds that hold for them.
    shifts : (kinds, n, 6) int64
      Bits dropped.
    """
    scale = 2.0 ** np.array(formats.channel_frac_bits)
    regions, kinds = primitive_regions(primitives), np.array(channel_kinds(formats))
    words, bounds = primitives.words.copy(), primitives.bound.copy()
    shifts = np.zeros((len(CHANNEL_KINDS), len(primitives), NUM_DIFFERENCES), np.int64)
    for kind in np.unique(kinds):
        channels = np.flatnonzero(kinds == kind)
        shared = (
            primitives.words, primitives.orders, regions.corners, regions.count, regions.fit, channels,
            budgets * scale,
        )  # fmt: skip
        most, used = np.zeros((len(primitives), NUM_DIFFERENCES), np.int64), np.zeros(len(primitives))
        _most(*shared, formats.word_width, most)
        differences = np.array(DIFFERENCES_OF_ORDER)[primitives.orders[:, channels]]
        sent = (differences[:, :, None] > np.arange(NUM_DIFFERENCES)).sum(axis=1)
        while True:
            shifts[kind] = hold(most, sent)
            _apply(*shared, shifts[kind], formats.word_width, words, used)
            over = used > 1.0
            if not over.any():
                break
            # Fewer bits dropped than may be is not always better, where words are rounded together.
            most[over] = np.maximum(np.minimum(most, shifts[kind])[over] - 1, 0)
        bounds[:, channels] += used[:, None] * budgets[channels]
    return replace(primitives, words=words, bound=bounds), shifts
