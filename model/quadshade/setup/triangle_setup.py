# SPDX-License-Identifier: Apache-2.0
"""Triangles to primitives: exact edges, rounded words and their error bound. The set-up's one entry point."""

from __future__ import annotations

import numpy as np
from numba import njit

from quadshade.errors import QuadshadeError
from quadshade.formats import CONSTANT, LINEAR, ORDER_NAMES, PLANES_OF_ORDER, QUADRATIC, Formats
from quadshade.setup.coefficients import (
    FLOAT_LIMIT,
    FRAME_FIELDS,
    UNIT_ROUNDOFF,
    exact_words,
    float_words,
    lattice_frame,
    lattice_ratios,
)
from quadshade.setup.edges import (
    COLUMN,
    FIRST_Y,
    HEIGHT,
    INCREMENT,
    MIRROR,
    REMAINDER,
    ROWS_FIRST,
    ROWS_SECOND,
    STEP,
    TRIANGLE,
    Cut,
    cut_triangles,
)
from quadshade.setup.packet import Primitives
from quadshade.setup.quantise import (
    FIT_FIELDS,
    SAMPLE_POINTS,
    carried_error,
    fit_planes,
    reach,
    region,
    round_words,
)
from quadshade.triangles import ScreenTriangles

ROUNDINGS = ("joint", "independent")


@njit(cache=True)
def _wrap(value, half):
    """Two's complement of a word whose sign bit is worth ``half``, sign extended."""
    return ((value + half) & (2 * half - 1)) - half


@njit(cache=True, error_model="numpy")
def _colour(
    heads, edges, vertices, samples, orders, scales, pixel, fractional, joint, half, words, bounds, again
):
    """Words and bounds of all primitives; ``again`` marks those for which float64 is not good enough."""
    corners, scratch = np.zeros((8, 2)), np.zeros((SAMPLE_POINTS, 5))
    fit = np.zeros(FIT_FIELDS)
    frame = np.zeros(FRAME_FIELDS, np.int64)
    real, errors, fraction, off = np.zeros(6), np.zeros(6), np.zeros(6), np.zeros(6)
    for p in range(len(heads)):
        triangle = heads[p, TRIANGLE]
        count = region(heads[p], edges[p], fractional, corners)
        rows, columns = reach(corners, count)
        if joint:
            fit_planes(corners, count, scratch, fit)
        lattice_frame(vertices[triangle], heads[p], edges[p, 0], pixel, fractional, frame)
        ratios = lattice_ratios(frame)
        for channel in range(len(scales)):
            scale, order = scales[channel], orders[triangle, channel]
            sample = samples[triangle, channel]
            float_words(sample, order, ratios, scale, 0.5, rows > 0, columns >= 1, real, errors)
            largest = 0.0
            for plane in range(6):
                largest = max(largest, abs(real[plane]))
                fraction[plane] = real[plane] - np.floor(real[plane])
            if not largest < FLOAT_LIMIT:
                again[p, channel] = True
                continue
            carried = carried_error(rows, columns, errors)
            bound = round_words(fraction, order, corners, count, fit, joint, off)
            again[p, channel] = carried > 0.125 + bound / 16.0
            bounds[p, channel] = (bound + carried) / scale
            for plane in range(6):
                # Floor and fraction are exact below FLOAT_LIMIT, so this is the integer that was chosen.
                words[p, channel, plane] = _wrap(np.int64(np.rint(real[plane] + off[plane])), half)


@njit(cache=True)
def _first_bad_sample(samples, orders, tops):
    """Triangle and channel of the first sample that is used and outside 0 .. top (NaN is), or -1, -1."""
    for index in range(len(samples)):
        for channel in range(len(tops)):
            for place in range(PLANES_OF_ORDER[orders[index, channel]]):
                if not 0.0 <= samples[index, channel, place] <= tops[channel]:
                    return index, channel
    return -1, -1


@njit(cache=True)
def _first_misfit(heads, samples, orders, bounds, limits):
    """
    Primitive and channel of the first value that may reach its word's limit, or -1, -1.

    A quadratic through six samples strays at most 5/3 of their half range from their middle (the Lebesgue
    constant of these points); of lower orders none does.
    """
    for p in range(len(heads)):
        triangle = heads[p, TRIANGLE]
        for channel in range(len(limits)):
            order = orders[triangle, channel]
            low = high = samples[triangle, channel, 0]
            for place in range(1, PLANES_OF_ORDER[order]):
                low = min(low, samples[triangle, channel, place])
                high = max(high, samples[triangle, channel, place])
            stray = 0.5 * (high - low) * (5.0 / 3.0 if order == QUADRATIC else 1.0) + bounds[p, channel]
            middle = 0.5 * (high + low) + 0.5
            if not (middle + stray < limits[channel] and middle - stray >= -limits[channel]):
                return p, channel
    return -1, -1


def _colour_exactly(
    cut: Cut,
    vertices: np.ndarray,
    samples: np.ndarray,
    orders: np.ndarray,
    formats: Formats,
    fractional: bool,
    joint: bool,
    words: np.ndarray,
    bounds: np.ndarray,
    again: np.ndarray,
) -> None:
    """Redo the marked primitives' words in integers (needles, wide words)."""
    corners, scratch = np.zeros((8, 2)), np.zeros((SAMPLE_POINTS, 5))
    fit, off = np.zeros(FIT_FIELDS), np.zeros(6)
    frame = np.zeros(FRAME_FIELDS, np.int64)
    errors = np.full(6, UNIT_ROUNDOFF)
    half, frac_bits = 1 << (formats.word_width - 1), formats.channel_frac_bits
    pixel = 1 << formats.subpixel_bits
    for p in np.flatnonzero(again.any(axis=1)):
        triangle = cut.heads[p, TRIANGLE]
        corners_used = region(cut.heads[p], cut.edges[p], fractional, corners)
        fit_planes(corners, corners_used, scratch, fit)
        lattice_frame(vertices[triangle], cut.heads[p], cut.edges[p, 0], pixel, fractional, frame)
        rows, columns = reach(corners, corners_used)
        for channel in np.flatnonzero(again[p]):
            order = orders[triangle, channel]
            fraction, whole = exact_words(
                samples[triangle, channel], order, frame, frac_bits[channel], rows > 0, columns >= 1
            )
            bound = round_words(fraction, order, corners, corners_used, fit, joint, off)
            bound += carried_error(rows, columns, errors)
            bounds[p, channel] = bound / 2.0 ** frac_bits[channel]
            more = np.rint(fraction + off).astype(np.int64)
            words[p, channel] = [
                (w + int(r) + half) % (2 * half) - half for w, r in zip(whole, more, strict=True)
            ]


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
        samples[:, channels, :3], orders[:, channels] = triangles.depth, LINEAR
    for channel, most in enumerate(formats.channel_max_order):
        order = orders[:, channel]
        wrong = (order < CONSTANT) | (order > most)
        if wrong.any():
            index = int(np.argmax(wrong))
            raise QuadshadeError(
                f"triangle {index}: channel {names[channel]} has order {order[index]}, above the core's"
                f" {ORDER_NAMES[most]}",
                "raise generic max_order or lower the order",
            )
    tops = np.array([(1 << bits) - 1 for bits in formats.channel_value_bits])
    index, channel = _first_bad_sample(samples, orders, tops)
    if index >= 0:
        raise QuadshadeError(
            f"triangle {index}: channel {names[channel]} has a sample outside 0 .. {tops[channel]}:"
            f" {samples[index, channel, : PLANES_OF_ORDER[orders[index, channel]]].tolist()}",
            "clamp the samples",
        )
    return samples, orders


def _check_geometry(triangles: ScreenTriangles, formats: Formats) -> None:
    """Arrays of the right shape, screen and vertices within what the core's coordinates can hold."""
    count = len(triangles)
    wanted = {"vertices": (count, 3, 2)}
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
            f"triangle {cut.heads[primitive, TRIANGLE]}: channel {channel} may not fit its word of"
            f" {formats.word_width} bits, {formats.channel_frac_bits[channel]} of them fraction",
            "raise word_width or frac_bits, or split the triangle",
        )


def setup_triangles(
    triangles: ScreenTriangles, formats: Formats, fractional: bool = False, rounding: str = "joint"
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

    Returns
    -------
    Primitives
      In triangle order, top to bottom within a triangle. Triangles without a pixel on the screen have none.
      Words are two's complement of ``word_width`` bits, sign extended. Depth, the last channel, is constant 0
      where none is given.

    Raises
    ------
    QuadshadeError
      A vertex outside the guard band, a sample out of range or not finite, an order or number of channels
      that the core is not built for, a screen larger than its coordinates, a word too narrow for the
      triangle.
    """
    if rounding not in ROUNDINGS:
        raise QuadshadeError(f"rounding is {rounding!r}", f"give one of {', '.join(ROUNDINGS)}")
    _check_geometry(triangles, formats)
    samples, orders = _checked_channels(triangles, formats)
    vertices = np.ascontiguousarray(triangles.vertices, dtype=np.int64)
    cut = cut_triangles(vertices, triangles.width, triangles.height, formats.subpixel_bits)
    count, carried = len(cut.heads), formats.carried_channels
    words = np.zeros((count, carried, 6), dtype=np.int64)
    bounds = np.zeros((count, carried))
    again = np.zeros((count, carried), dtype=np.bool_)
    scales = 2.0 ** np.array(formats.channel_frac_bits)
    pixel, joint = 1 << formats.subpixel_bits, rounding == "joint"
    half = 1 << (formats.word_width - 1)
    _colour(
        cut.heads,
        cut.edges,
        vertices,
        samples,
        orders,
        scales,
        pixel,
        fractional,
        joint,
        half,
        words,
        bounds,
        again,
    )
    if again.any():
        _colour_exactly(cut, vertices, samples, orders, formats, fractional, joint, words, bounds, again)
    bounds *= 1.0 + 2.0**-40
    _check_words(cut, samples, orders, bounds, formats)
    heads = cut.heads
    header = {
        "y": heads[:, FIRST_Y],
        "rows_first": heads[:, ROWS_FIRST],
        "rows_second": heads[:, ROWS_SECOND],
        "has_second": (heads[:, ROWS_SECOND] > 0).astype(np.int64),
        "mirror": heads[:, MIRROR],
        "fractional": np.full(count, int(fractional), dtype=np.int64),
    }
    edges = {}
    for index, name in enumerate(("major", "minor", "second")):
        state = cut.edges[:, index].T
        edges[name] = {
            "column": state[COLUMN],
            "error": state[REMAINDER] + state[INCREMENT] - state[HEIGHT],
            "step": state[STEP],
            "increment": state[INCREMENT],
            "decrement": state[INCREMENT] - state[HEIGHT],
        }
    return Primitives(heads[:, TRIANGLE].copy(), header, edges, orders[heads[:, TRIANGLE]], words, bounds)
