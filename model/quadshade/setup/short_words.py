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
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numba import njit

from quadshade.contract.arrays import Bools, Floats, Ints, Records
from quadshade.contract.formats import CONSTANT, DIFFERENCES, DIFFERENCES_OF_ORDER, Formats
from quadshade.contract.packed_format import CHANNEL_KINDS, channel_kinds
from quadshade.setup.edges import Cut
from quadshade.setup.packet import Primitives, cut_of
from quadshade.setup.quantise import (
    FIT,
    SAMPLE_POINTS,
    Fit,
    coarse_words,
    difference_spreads,
    fit_linear,
    region,
)

NUM_DIFFERENCES = len(DIFFERENCES)
Hold = Callable[[np.ndarray, np.ndarray], np.ndarray]
STEP_BITS = 0.5
"""How finely the number of dropped bits is searched: differences follow one by one."""


class Regions(NamedTuple):
    """
    Where each primitive has its pixels, for error bounds.

    Attributes
    ----------
    corners : (n, 8, 2) float64
    num_corners : (n,) int64
      Corners used.
    fit : (n,) records of :class:`quadshade.setup.quantise.Fit`
    """

    corners: Floats
    num_corners: Ints
    fit: Records


class _Channels(NamedTuple):
    """Words to be rounded: those of one kind's channels, with what each may add to its error, in units."""

    words: Ints
    orders: Ints
    channels: Ints
    budgets: Floats
    word_width: int


@njit(cache=True)
def _fill_regions(cut: Cut, fractional: Bools, out: Regions) -> None:
    scratch = np.zeros((SAMPLE_POINTS, 5))
    for p in range(len(cut.heads)):
        out.num_corners[p] = region(cut.heads[p], cut.edges[p], fractional[p], out.corners[p])
        fit_linear(out.corners[p], out.num_corners[p], scratch, out.fit[p])


def primitive_regions(primitives: Primitives) -> Regions:
    """The regions of primitives."""
    size = len(primitives)
    regions = Regions(np.zeros((size, 8, 2)), np.zeros(size, np.int64), np.zeros(size, FIT))
    _fill_regions(cut_of(primitives), primitives.header["fractional"] != 0, regions)
    return regions


@njit(cache=True)
def _round(
    given: _Channels, regions: Regions, p: int, shifts: Ints, scaled: Fit, out: Ints, most: float
) -> float:
    """
    Round the channels of a primitive (written to ``out``, (c, 6)); the largest share of a budget used.

    A share of more than ``most`` ends it: channels behind are not rounded then. ``scaled`` is room for a fit.
    """
    corners, count, fit = regions.corners[p], regions.num_corners[p], regions.fit[p]
    worst = 0.0
    off = np.zeros(NUM_DIFFERENCES)
    half = np.int64(1) << (given.word_width - 1)
    for channel in given.channels:
        words, order = given.words[p, channel], given.orders[p, channel]
        added = coarse_words(words, shifts, order, corners, count, fit, scaled, off, out[channel])
        worst = max(worst, added / given.budgets[channel])
        if worst > most:
            break
        for difference in range(NUM_DIFFERENCES):
            out[channel, difference] = ((out[channel, difference] + half) & (2 * half - 1)) - half
    return worst


@njit(cache=True)
def _most(given: _Channels, regions: Regions, room: Fit, out: Ints) -> None:
    """Most bits that the channels drop from each difference of every primitive (``out``, (n, 6))."""
    spreads, shifts = np.zeros(NUM_DIFFERENCES), np.zeros(NUM_DIFFERENCES, np.int64)
    rounded = np.zeros(given.words.shape[1:], np.int64)
    budget = np.inf
    for channel in given.channels:
        budget = min(budget, given.budgets[channel])
    for p in range(len(given.words)):
        difference_spreads(regions.fit[p], spreads)
        highest = 0
        for channel in given.channels:
            highest = max(highest, given.orders[p, channel])
        start = np.log2(budget) + (1.0 if highest == CONSTANT else 1.5)
        while start > -1.0:
            for difference in range(NUM_DIFFERENCES):
                shift = int(np.floor(start - spreads[difference]))
                shifts[difference] = min(max(shift, 0), given.word_width - 1)
            share = _round(given, regions, p, shifts, room, rounded, 1.0)
            if share <= 1.0:
                out[p] = shifts
                break
            start -= STEP_BITS


@njit(cache=True)
def _apply(
    given: _Channels, regions: Regions, rows: Ints, shifts: Ints, room: Fit, out: Ints, used: Floats
) -> None:
    """Round the channels of some primitives as ``shifts`` (n, 6) say; ``used`` shares of the budget."""
    for p in rows:
        used[p] = _round(given, regions, p, shifts[p], room, out[p], np.inf)


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
    room = np.zeros(1, FIT)[0]
    shifts = np.zeros((len(CHANNEL_KINDS), len(primitives), NUM_DIFFERENCES), np.int64)
    for kind in sorted(set(channel_kinds(formats))):
        channels = np.flatnonzero(kinds == kind)
        given = _Channels(primitives.words, primitives.orders, channels, budgets * scale, formats.word_width)
        most, used = np.zeros((len(primitives), NUM_DIFFERENCES), np.int64), np.zeros(len(primitives))
        _most(given, regions, room, most)
        differences = np.array(DIFFERENCES_OF_ORDER)[primitives.orders[:, channels]]
        sent = (differences[:, :, None] > np.arange(NUM_DIFFERENCES)).sum(axis=1)
        shifts[kind] = -1
        while True:
            held = hold(most, sent)
            rows = np.flatnonzero((held != shifts[kind]).any(axis=1))
            shifts[kind] = held
            _apply(given, regions, rows, held, room, words, used)
            over = used > 1.0
            if not over.any():
                break
            # Fewer bits dropped than may be is not always better, where words are rounded together.
            most[over] = np.maximum(np.minimum(most, shifts[kind])[over] - 1, 0)
        bounds[:, channels] += used[:, None] * budgets[channels]
    return replace(primitives, words=words, bound=bounds), shifts
