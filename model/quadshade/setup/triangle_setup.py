# SPDX-License-Identifier: Apache-2.0
"""Triangles to primitives: exact edges, rounded words and their error bound. The set-up's one entry point."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numba import njit

from quadshade.choices import ROUNDINGS
from quadshade.contract.arrays import Floats, Ints, Records
from quadshade.contract.formats import CONSTANT, DIFFERENCES_OF_ORDER, LINEAR, ORDER_NAMES, QUADRATIC, Formats
from quadshade.contract.shade_state import specular_gain
from quadshade.contract.triangles import ScreenTriangles
from quadshade.errors import QuadshadeError
from quadshade.setup.colour_words import Colours, colour_words, words_by_terms
from quadshade.setup.divide_primitives import beyond, divide
from quadshade.setup.edges import Cut, cut_triangles
from quadshade.setup.literature.terms import fit_terms
from quadshade.setup.packet import Primitives, edges_of, header_of

UNDEFINED = 4.0 / 3.0
"""A channel drawn as 0 is at most this share of full scale off any quadratic through its samples."""


@njit(cache=True)
def _first_bad_sample(samples: Floats, orders: Ints, lows: Ints, tops: Ints) -> tuple[int, int]:
    """Triangle and channel of the first sample that is used and outside low .. top (NaN is), or -1, -1."""
    for index in range(len(samples)):
        for channel in range(len(tops)):
            for place in range(DIFFERENCES_OF_ORDER[orders[index, channel]]):
                if not lows[channel] <= samples[index, channel, place] <= tops[channel]:
                    return index, channel
    return -1, -1


@njit(cache=True)
def _first_misfit(
    heads: Records, samples: Floats, orders: Ints, bounds: Floats, limits: Floats
) -> tuple[int, int]:
    """
    Primitive and channel of the first value that may reach its word's limit, or -1, -1.

    A quadratic through six samples strays at most 5/3 of their half range from their middle (the Lebesgue
    constant of these points); of lower orders none does.
    """
    for p in range(len(heads)):
        triangle = heads[p].triangle
        for channel in range(len(limits)):
            order = orders[triangle, channel]
            low = high = samples[triangle, channel, 0]
            for place in range(1, DIFFERENCES_OF_ORDER[order]):
                low = min(low, samples[triangle, channel, place])
                high = max(high, samples[triangle, channel, place])
            stray = 0.5 * (high - low) * (5.0 / 3.0 if order == QUADRATIC else 1.0) + bounds[p, channel]
            middle = 0.5 * (high + low) + 0.5
            if not (middle + stray < limits[channel] and middle - stray >= -limits[channel]):
                return p, channel
    return -1, -1


def has_constant_depth(depth: np.ndarray, formats: Formats) -> np.ndarray:
    """(n,) bool: triangles with one depth at all corners, where that saves words of their packets."""
    alone = len(formats.channel_groups[-1]) == 1
    same: np.ndarray = (depth == depth[:, :1]).all(axis=1) & alone
    return same


@lru_cache
def _channel_limits(formats: Formats) -> tuple[Ints, Ints, Ints]:
    """(carried,) each: the highest order, the lowest sample and the highest."""
    tops = np.array([(1 << bits) - 1 for bits in formats.channel_value_bits])
    # A cosine may be negative; the lane's clamp makes that zero.
    lows = np.where(np.arange(len(tops)) < formats.num_channels, -tops * formats.with_shade, 0)
    return np.array(formats.channel_max_order), lows, tops


def _checked_channels(triangles: ScreenTriangles, formats: Formats) -> tuple[np.ndarray, np.ndarray]:
    """Samples (n, carried, 6) and orders (n, carried) with depth as the last channel, all in range."""
    count, channels = len(triangles), formats.num_channels
    if triangles.samples.shape != (count, channels, 6) or triangles.orders.shape != (count, channels):
        raise QuadshadeError(
            f"triangles have {triangles.samples.shape[1] if triangles.samples.ndim == 3 else 'no'} channels,"
            f" the core's generic num_channels is {channels}",
            "make them equal",
        )
    names = tuple(triangles.channels) + ("depth",)
    samples = np.zeros((count, formats.carried_channels, 6))
    orders = np.zeros((count, formats.carried_channels), dtype=np.int64)
    samples[:, :channels], orders[:, :channels] = triangles.samples, triangles.orders
    if formats.with_depth and triangles.depth is not None:
        samples[:, channels, :3] = triangles.depth
        orders[:, channels] = np.where(has_constant_depth(triangles.depth, formats), CONSTANT, LINEAR)
    most, lows, tops = _channel_limits(formats)
    wrong = (orders < CONSTANT) | (orders > most)
    if wrong.any():
        channel, index = np.argwhere(wrong.T)[0]
        raise QuadshadeError(
            f"triangle {index}: channel {names[channel]} has order {orders[index, channel]}, above the core's"
            f" {ORDER_NAMES[most[channel]]}",
            "raise generic max_order or lower the order",
        )
    index, channel = _first_bad_sample(samples, orders, lows, tops)
    if index >= 0:
        raise QuadshadeError(
            f"triangle {index}: channel {names[channel]} has a sample outside"
            f" {lows[channel]} .. {tops[channel]}:"
            f" {samples[index, channel, : DIFFERENCES_OF_ORDER[orders[index, channel]]].tolist()}",
            "clamp the samples",
        )
    if guard_bits(triangles, formats):
        samples[:, channels - formats.num_specular : channels] *= specular_gain(formats)
    return samples, orders


def _check_geometry(triangles: ScreenTriangles, formats: Formats) -> None:
    """Arrays of the right shape, screen and vertices within what the core's coordinates can hold."""
    count = len(triangles)
    wanted: dict[str, tuple[int, ...]] = {"vertices": (count, 3, 2)}
    if triangles.depth is not None:
        wanted["depth"] = (count, 3)
    for name, shape in wanted.items():
        if np.shape(getattr(triangles, name)) != shape:
            raise QuadshadeError(
                f"the triangles' {name} has shape {np.shape(getattr(triangles, name))}", f"give {shape}"
            )
    if not np.issubdtype(np.asarray(triangles.vertices).dtype, np.integer):
        raise QuadshadeError(
            f"the triangles' vertices are {np.asarray(triangles.vertices).dtype}", "give whole sub-pixels"
        )
    largest = 1 << formats.coord_bits
    if not (1 <= triangles.width <= largest and 1 <= triangles.height <= largest):
        raise QuadshadeError(
            f"screen of {triangles.width} x {triangles.height} pixels",
            f"give 1 to {largest} (generic coord_bits)",
        )
    low, high = formats.guard_band
    if len(triangles) and not (triangles.vertices.min() >= low and triangles.vertices.max() <= high):
        index = int(np.argmax(((triangles.vertices < low) | (triangles.vertices > high)).any(axis=(1, 2))))
        corners = (triangles.vertices[index] / (1 << formats.subpixel_bits)).tolist()
        raise QuadshadeError(
            f"triangle out of range: triangle {index} has its vertices at {corners}",
            f"clip to {-largest} .. {2 * largest} pixels (generic coord_bits)",
        )


def _check_words(
    cut: Cut, samples: np.ndarray, orders: np.ndarray, bounds: np.ndarray, formats: Formats
) -> None:
    """Every covered pixel's value fits its word."""
    limits = 2.0 ** (formats.word_width - 1 - np.array(formats.channel_frac_bits))
    primitive, channel = _first_misfit(cut.heads, samples, orders, bounds, limits)
    if primitive >= 0:
        raise QuadshadeError(
            f"triangle {cut.heads['triangle'][primitive]}: channel {channel} may not fit its word of"
            f" {formats.word_width} bits, {formats.channel_frac_bits[channel]} of them fraction",
            "raise word_width or frac_bits, or split the triangle",
        )


def _refuse_beyond(limit: float, cut: Cut, bounds: np.ndarray, names: tuple[str, ...]) -> None:
    """Raise for the first triangle with a colour channel whose bound exceeds a limit."""
    over = beyond(bounds, len(names), limit)
    if over.any():
        primitive, channel = np.argwhere(over)[0]
        raise QuadshadeError(
            f"triangle {cut.heads['triangle'][primitive]}: channel {names[channel]} may be"
            f" {bounds[primitive, channel]:.3g} grey levels off, more than {limit:g}",
            "raise generic frac_bits, or leave --strict out",
        )


def guard_bits(triangles: ScreenTriangles, formats: Formats) -> int:
    """Bits below an output unit at which colour lanes round: with shade those that its state says."""
    return triangles.shade.guard_bits if formats.with_shade and triangles.shade is not None else 0


def setup_triangles(
    triangles: ScreenTriangles,
    formats: Formats,
    fractional: bool = False,
    rounding: str = "joint",
    method: str = "unit",
    limit: float | None = None,
    strict: bool = False,
) -> Primitives:
    """
    Set up triangles: what the hardware needs to draw them, and how far from exact it will be.

    Parameters
    ----------
    triangles : ScreenTriangles
    formats : Formats
    fractional : bool
      Step colour along the fractional major edge, one pixel a step from there (the loop of Abbas et al.,
      section 5), instead of at pixel centres. Coverage is the same; the bound is against the quadratic at
      those positions.
    rounding : {"joint", "independent"}
      Joint: lower orders absorb what higher ones lost. Independent: each word to its nearest.
    method : str
      Where the coefficients of quadratic channels come from: one of
      :data:`quadshade.setup.literature.terms.SETUPS`.
      ``xshading`` and ``taylor`` are ``unit`` here: they differ in their samples.
    limit : float, optional
      Most that the bound of a colour channel may be, in output units. A triangle beyond it is divided: drawn
      by several primitives, each of a part of the screen. With ``fractional`` it is not, because there a
      part's own major edge would decide where colour is sampled.
    strict : bool
      Refuse such a triangle instead.

    Returns
    -------
    Primitives
      In triangle order, by first scanline within a triangle. Triangles without a pixel on the screen have
      none. Words are two's complement of ``word_width`` bits, sign extended. Depth, the last
      channel, is constant 0 where none is given.

    Raises
    ------
    QuadshadeError
      A vertex outside the guard band, a sample out of range or not finite, an order or number of channels
      that the core is not built for, a screen larger than its coordinates, a word too narrow for the
      triangle, a limit that is exceeded (``strict``) or that no division meets.
    """
    if rounding not in ROUNDINGS:
        raise QuadshadeError(f"rounding is {rounding!r}", f"give one of {', '.join(ROUNDINGS)}")
    if limit is not None and not limit > 0:
        raise QuadshadeError(f"the limit is {limit} grey levels", "give a number above 0")
    _check_geometry(triangles, formats)
    samples, orders = _checked_channels(triangles, formats)
    vertices = np.ascontiguousarray(triangles.vertices, dtype=np.int64)
    terms = fit_terms(method, vertices, samples, formats.subpixel_bits)
    guard = guard_bits(triangles, formats)
    colours = Colours(vertices, samples, orders, formats, fractional, rounding == "joint", guard)
    cut = cut_triangles(vertices, triangles.width, triangles.height, formats.subpixel_bits)
    words, bounds = colour_words(cut, colours)
    if limit is not None and not (strict or fractional):
        cut, words, bounds = divide(cut, words, bounds, limit, colours, triangles.width, triangles.height)
    undefined = np.zeros(bounds.shape, dtype=np.bool_)
    if terms is not None:
        undefined = words_by_terms(cut, colours, terms, words, bounds)
    _check_words(cut, samples, orders, bounds, formats)
    bounds[undefined] = 2.0**formats.value_bits * UNDEFINED
    if limit is not None and strict:
        _refuse_beyond(limit, cut, bounds, triangles.channels)
    header = header_of(cut, np.full(len(cut.heads), int(fractional), dtype=np.int64))
    owners = cut.heads["triangle"].copy()
    return Primitives(owners, header, edges_of(cut), orders[owners], words, bounds, np.any(undefined, axis=1))
