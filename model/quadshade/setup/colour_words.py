# SPDX-License-Identifier: Apache-2.0
"""Words of primitives: float64 where it is good enough, integers elsewhere, each with a bound."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit

from quadshade.contract.arrays import Bools, Floats, Ints
from quadshade.contract.formats import QUADRATIC, Formats
from quadshade.setup.coefficients import (
    FLOAT_LIMIT,
    UNIT_ROUNDOFF,
    exact_words,
    float_words,
    lattice_frame,
    lattice_ratios,
)
from quadshade.setup.edges import Cut
from quadshade.setup.literature.terms import Terms, lattice_steps, term_words
from quadshade.setup.quantise import (
    FIT,
    SAMPLE_POINTS,
    Fit,
    carried_error,
    fit_linear,
    reach,
    region,
    round_words,
)


@dataclass(frozen=True)
class Colours:
    """
    What the words of any primitive of a drawing follow from.

    Attributes
    ----------
    vertices : (n, 3, 2) int64
    samples : (n, c, 6) float64
      Of every carried channel, depth last.
    orders : (n, c) int64
    formats : Formats
    fractional : bool
    joint : bool
      How words are rounded.
    guard_bits : int
      Bits below an output unit at which colour lanes round.
    """

    vertices: np.ndarray
    samples: np.ndarray
    orders: np.ndarray
    formats: Formats
    fractional: bool
    joint: bool
    guard_bits: int = 0

    @property
    def guards(self) -> tuple[int, ...]:
        """Bits below an output unit at which each channel's lane rounds; depth has none."""
        return (self.guard_bits,) * self.formats.num_channels + (0,) * self.formats.with_depth

    @property
    def halves(self) -> np.ndarray:
        """(c,) float64: half a unit of what each channel's lane emits, in output units."""
        return 0.5 ** (1.0 + np.array(self.guards))


class _Given(NamedTuple):
    """
    What the kernels need of :class:`Colours`.

    ``scales`` and ``halves`` have an entry a channel: units in the last place of an output unit, and half a
    unit of what its lane emits. ``pixel`` is the sub-pixels of a pixel, ``half`` what a word's sign bit is
    worth.
    """

    vertices: Ints
    samples: Floats
    orders: Ints
    scales: Floats
    halves: Floats
    pixel: int
    fractional: bool
    joint: bool
    half: int


def _given(colours: Colours) -> _Given:
    formats = colours.formats
    return _Given(
        colours.vertices,
        colours.samples,
        colours.orders,
        2.0 ** np.array(formats.channel_frac_bits),
        colours.halves,
        1 << formats.subpixel_bits,
        colours.fractional,
        colours.joint,
        1 << (formats.word_width - 1),
    )


@njit(cache=True)
def _wrap(value: int, half: int) -> int:
    """Two's complement of a word whose sign bit is worth ``half``, sign extended."""
    return ((value + half) & (2 * half - 1)) - half


@njit(cache=True, error_model="numpy")
def _colour(cut: Cut, given: _Given, fit: Fit, words: Ints, bounds: Floats, again: Bools) -> None:
    """
    Words and bounds of all primitives; ``again`` marks those for which float64 is not good enough.

    ``fit`` is room for a fit.
    """
    vertices, samples, orders, scales, halves, pixel, fractional, joint, half = given
    heads, edges = cut
    corners, scratch = np.zeros((8, 2)), np.zeros((SAMPLE_POINTS, 5))
    real, errors, fraction, off = np.zeros(6), np.zeros(6), np.zeros(6), np.zeros(6)
    for p in range(len(heads)):
        triangle = heads[p].triangle
        count = region(heads[p], edges[p], fractional, corners)
        rows, columns = reach(corners, count)
        if joint:
            fit_linear(corners, count, scratch, fit)
        frame = lattice_frame(vertices[triangle], heads[p], edges[p, 0], pixel, fractional)
        ratios = lattice_ratios(frame)
        for channel in range(len(scales)):
            scale, order = scales[channel], orders[triangle, channel]
            sample = samples[triangle, channel]
            float_words(sample, order, ratios, scale, halves[channel], rows > 0, columns >= 1, real, errors)
            largest = 0.0
            for difference in range(6):
                largest = max(largest, abs(real[difference]))
                fraction[difference] = real[difference] - np.floor(real[difference])
            if not largest < FLOAT_LIMIT:
                again[p, channel] = True
                continue
            carried = carried_error(rows, columns, errors)
            bound = round_words(fraction, order, corners, count, fit, joint, off)
            again[p, channel] = carried > 0.125 + bound / 16.0
            bounds[p, channel] = (bound + carried) / scale
            for difference in range(6):
                # Floor and fraction are exact below FLOAT_LIMIT, so this is the integer that was chosen.
                words[p, channel, difference] = _wrap(int(np.rint(real[difference] + off[difference])), half)


def colour_exactly(
    cut: Cut, colours: Colours, words: np.ndarray, bounds: np.ndarray, again: np.ndarray
) -> None:
    """
    Set up marked primitives' words in integers (needles, wide words).

    Parameters
    ----------
    cut : Cut
    colours : Colours
    words, bounds : (n, c, 6) int64, (n, c) float64
      Written where marked.
    again : (n, c) bool
    """
    formats, fractional = colours.formats, colours.fractional
    corners, scratch = np.zeros((8, 2)), np.zeros((SAMPLE_POINTS, 5))
    fit, off = np.zeros(1, FIT)[0], np.zeros(6)
    errors = np.full(6, UNIT_ROUNDOFF)
    half, frac_bits = 1 << (formats.word_width - 1), formats.channel_frac_bits
    pixel = 1 << formats.subpixel_bits
    for p in np.flatnonzero(again.any(axis=1)):
        triangle = cut.heads["triangle"][p]
        corners_used = region(cut.heads[p], cut.edges[p], fractional, corners)
        fit_linear(corners, corners_used, scratch, fit)
        frame = lattice_frame(colours.vertices[triangle], cut.heads[p], cut.edges[p, 0], pixel, fractional)
        rows, columns = reach(corners, corners_used)
        for channel in np.flatnonzero(again[p]):
            order = colours.orders[triangle, channel]
            fraction, whole = exact_words(
                colours.samples[triangle, channel],
                order,
                frame,
                frac_bits[channel],
                rows > 0,
                columns >= 1,
                colours.guards[channel],
            )
            bound = round_words(fraction, order, corners, corners_used, fit, colours.joint, off)
            bound += carried_error(rows, columns, errors)
            bounds[p, channel] = bound / 2.0 ** frac_bits[channel]
            more = np.rint(fraction + off).astype(np.int64)
            words[p, channel] = [
                (w + int(r) + half) % (2 * half) - half for w, r in zip(whole, more, strict=True)
            ]


@njit(cache=True, error_model="numpy")
def _colour_by_terms(
    cut: Cut,
    given: _Given,
    origins: Ints,
    terms: Floats,
    fit: Fit,
    words: Ints,
    bounds: Floats,
    undefined: Bools,
) -> None:
    """
    Words of quadratic channels from coefficients T0 to T5; what they are off the set-up's own goes into the
    bound. ``undefined`` marks coefficients that are not finite, or whose words float64 cannot round; ``fit``
    is room for a fit.
    """
    corners, scratch = np.zeros((8, 2)), np.zeros((SAMPLE_POINTS, 5))
    vertices, samples, orders, scales, halves, pixel, fractional, joint, half = given
    heads, edges = cut
    true, errors, real, fraction, off = (
        np.zeros(6), np.zeros(6), np.zeros(6), np.zeros(6), np.zeros(6),
    )  # fmt: skip
    for p in range(len(heads)):
        triangle = heads[p].triangle
        count = region(heads[p], edges[p], fractional, corners)
        rows, columns = reach(corners, count)
        fit_linear(corners, count, scratch, fit)
        frame = lattice_frame(vertices[triangle], heads[p], edges[p, 0], pixel, fractional)
        ratios = lattice_ratios(frame)
        steps = lattice_steps(vertices[triangle], origins[triangle], heads[p], edges[p, 0], pixel, fractional)
        for channel in range(len(scales)):
            scale, order = scales[channel], orders[triangle, channel]
            if order != QUADRATIC:
                continue
            sample = samples[triangle, channel]
            above = halves[channel]
            float_words(sample, order, ratios, scale, above, rows > 0, columns >= 1, true, errors)
            term_words(terms[triangle, channel], steps, scale, above, rows > 0, columns >= 1, real)
            fits = True
            for difference in range(6):
                fits = fits and abs(real[difference]) < FLOAT_LIMIT
                errors[difference] += abs(real[difference] - true[difference])
                fraction[difference] = real[difference] - np.floor(real[difference])
            if not fits:
                undefined[p, channel] = True
                continue
            bound = round_words(fraction, order, corners, count, fit, joint, off)
            bounds[p, channel] = (bound + carried_error(rows, columns, errors)) / scale
            for difference in range(6):
                words[p, channel, difference] = _wrap(int(np.rint(real[difference] + off[difference])), half)


def colour_words(cut: Cut, colours: Colours) -> tuple[np.ndarray, np.ndarray]:
    """
    Words and error bounds of primitives, by the set-up's own method.

    Parameters
    ----------
    cut : Cut
    colours : Colours

    Returns
    -------
    words : (n, c, 6) int64
      Two's complement, sign extended.
    bounds : (n, c) float64
      Most that an emitted value is off the exact quadratic, in output units, before the final rounding.
    """
    shape = (len(cut.heads), colours.formats.carried_channels)
    words, bounds = np.zeros((*shape, 6), dtype=np.int64), np.zeros(shape)
    again = np.zeros(shape, dtype=np.bool_)
    _colour(cut, _given(colours), np.zeros(1, FIT)[0], words, bounds, again)
    if again.any():
        colour_exactly(cut, colours, words, bounds, again)
    return words, bounds * (1.0 + 2.0**-40)


def words_by_terms(
    cut: Cut, colours: Colours, terms: Terms, words: np.ndarray, bounds: np.ndarray
) -> np.ndarray:
    """
    Replace quadratic channels' words by those of coefficients; the bounds then hold their error as well.

    Parameters
    ----------
    cut : Cut
    colours : Colours
    terms : Terms
      By another method than the set-up's own.
    words, bounds : (n, c, 6) int64, (n, c) float64
      From :func:`colour_words`; written.

    Returns
    -------
    (n, c) bool
      Undefined: the coefficients are not finite, or may be off by more than half of full scale, which words
      need not hold; words and bound are 0.
    """
    formats = colours.formats
    undefined = np.zeros(bounds.shape, dtype=np.bool_)
    room = np.zeros(1, FIT)[0]
    _colour_by_terms(cut, _given(colours), terms.origins, terms.values, room, words, bounds, undefined)
    quadratic = colours.orders[cut.heads["triangle"]] == QUADRATIC
    undefined |= quadratic & (bounds > 0.5 * 2.0 ** np.array(formats.channel_value_bits))
    words[undefined], bounds[undefined] = 0, 0.0
    return undefined
