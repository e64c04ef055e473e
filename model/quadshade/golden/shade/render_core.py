# SPDX-License-Identifier: Apache-2.0
"""Rasteriser core with the shade unit behind it (``rtl/shade/render_core.vhd``), plain, and fast in numba."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numba
import numpy as np

from quadshade.contract.arrays import Int, Ints
from quadshade.contract.formats import (
    COEFFICIENT_FRAC_BITS,
    FACTOR_BITS,
    POWER_BITS,
    POWER_MANTISSA_BITS,
    SHADED_COLOURS,
    Formats,
)
from quadshade.contract.shade_state import ShadeState, colour_state, table_entries
from quadshade.golden.compiled import EmittedPixels, draw_fast
from quadshade.golden.core import raster_core
from quadshade.golden.core.raster_core import EmittedPixel
from quadshade.golden.shade.shade import shade


def draw_scalar(
    words: Sequence[int], formats: Formats, state: ShadeState | None = None
) -> list[EmittedPixel]:
    """
    Draw a stream of set-up words, as ``raster_core.draw_scalar`` does, and shade the pixels.

    Parameters
    ----------
    words : sequence of int
      32-bit set-up words, whole packets.
    formats : Formats
    state : ShadeState, optional
      Of the shade unit; if left out, the first three channels are the colour.
    """
    pixels = raster_core.draw_scalar(words, formats.core)
    if not formats.with_shade:
        return pixels
    state = colour_state(formats) if state is None else state
    channels = formats.num_channels
    return [
        pixel._replace(value=(*shade(pixel.value[:channels], state, formats), *pixel.value[channels:]))
        for pixel in pixels
    ]


class ShadeGiven(NamedTuple):
    """The shade unit's state and formats, as the kernel needs them: see :class:`ShadeState`."""

    ambient: Ints
    coefficients: Ints
    tables: Ints
    linear: int
    gated: int
    lane_value_bits: int
    value_bits: int


@numba.njit(cache=True)
def _interval(value: Int, lane_value_bits: int) -> tuple[Int, Int]:
    """The entry of a power table at a lane's value, and the distance with the fraction below the entry's."""
    fraction_bits = lane_value_bits - POWER_MANTISSA_BITS - 1
    far = (np.int64(1) << lane_value_bits) - 1 - value
    octave = 0
    while far >> octave >= 2 << POWER_MANTISSA_BITS:
        octave += 1
    shifted = far << (fraction_bits - octave)
    return (octave << POWER_MANTISSA_BITS) + (shifted >> fraction_bits), shifted


@numba.njit(cache=True)
def _power(value: Int, table: Ints, lane_value_bits: int) -> Int:
    """The curve at a lane's value, as ``power_table.power_table``."""
    fraction_bits = lane_value_bits - POWER_MANTISSA_BITS - 1
    entry, shifted = _interval(value, lane_value_bits)
    word = table[entry]
    here, there = word & ((1 << POWER_BITS) - 1), word >> POWER_BITS
    product = (there - here) * (shifted & ((1 << fraction_bits) - 1))
    return here + ((product + (1 << (fraction_bits - 1))) >> fraction_bits)


@numba.njit(cache=True)
def shade_values(value: np.ndarray, given: ShadeGiven) -> np.ndarray:
    """(n, 3) int32 colours of (n, channels) values, as ``shade.shade``."""
    ambient, coefficients, tables, linear, gated, lane_value_bits, value_bits = given
    channels, specular = len(coefficients), len(tables)
    diffuse = channels - specular
    largest = (1 << value_bits) - 1
    out = np.empty((len(value), SHADED_COLOURS), np.int32)
    shift = FACTOR_BITS - value_bits
    for index in range(len(value)):
        red, green, blue = ambient[0], ambient[1], ambient[2]
        for channel in range(channels):
            part = np.int64(value[index, channel])
            factor: Int = part << (FACTOR_BITS - lane_value_bits)
            number = channel - diffuse
            if number >= 0:
                if not linear >> number & 1:
                    power = _power(part, tables[number], lane_value_bits)
                    factor = power << (FACTOR_BITS - POWER_BITS)
                if gated >> number & 1 and number < diffuse and value[index, number] == 0:
                    factor = np.int64(0)
            red += factor * coefficients[channel, 0] >> shift
            green += factor * coefficients[channel, 1] >> shift
            blue += factor * coefficients[channel, 2] >> shift
        out[index, 0] = min(red >> COEFFICIENT_FRAC_BITS, largest)
        out[index, 1] = min(green >> COEFFICIENT_FRAC_BITS, largest)
        out[index, 2] = min(blue >> COEFFICIENT_FRAC_BITS, largest)
    return out


def first_entry(highest: int, formats: Formats) -> int:
    """
    The first entry of the power tables that is read: entries lie the farther in front the higher a value.

    Parameters
    ----------
    highest : int
      The highest value of any lane that has a table; less than 0 where there is no pixel.
    formats : Formats

    Returns
    -------
    int
      As many as a table has where none is read.
    """
    entries = table_entries(formats)
    return entries if highest < 0 else min(int(_interval(highest, formats.lane_value_bits)[0]), entries)


def needed_writes(words: np.ndarray, state: ShadeState, formats: Formats) -> np.ndarray:
    """
    What loads a state for a picture: of the power tables only what its pixels read.

    Parameters
    ----------
    words : (m,) uint32
      Set-up words of the picture; it is drawn once.
    state : ShadeState
    formats : Formats

    Returns
    -------
    (k, 2) uint32
      Addresses and data.
    """
    if not state.tables.size:
        return state.writes()
    value = draw_fast(words, formats.core).value[:, formats.num_channels - formats.num_specular :]
    tables = [number for number in range(formats.num_specular) if not state.linear >> number & 1]
    highest = int(value[:, tables].max(initial=-1))
    return state.writes(first_entry(highest, formats))


def shade_given(state: ShadeState, formats: Formats) -> ShadeGiven:
    """What :func:`shade_values` takes."""
    tables = np.zeros((formats.num_specular, table_entries(formats)), np.int64)
    tables[:, : state.tables.shape[1]] = state.tables
    return ShadeGiven(
        state.ambient,
        state.coefficients,
        tables,
        state.linear,
        state.gated,
        formats.lane_value_bits,
        formats.value_bits,
    )


def shade_fast(value: np.ndarray, state: ShadeState, formats: Formats) -> np.ndarray:
    """
    Colours of many pixels.

    Parameters
    ----------
    value : (n, num_channels) int32
      What the lanes emit.
    state : ShadeState
    formats : Formats

    Returns
    -------
    (n, 3) int32
    """
    return shade_values(value, shade_given(state, formats))


def draw(
    words: np.ndarray, formats: Formats, state: ShadeState | None = None, stall_period: int = 0
) -> EmittedPixels:
    """
    Draw a stream of set-up words, shade the pixels, and predict the clocks.

    Parameters
    ----------
    words : (m,) uint32
      32-bit set-up words, whole packets.
    formats : Formats
    state : ShadeState, optional
      Of the shade unit; if left out, the first three channels are the colour.
    stall_period : int
      The sink is not ready in every n-th clock; 0: always ready.

    Returns
    -------
    EmittedPixels

    Raises
    ------
    QuadshadeError
      The stream ends within a packet.
    """
    drawn = draw_fast(words, formats.core, stall_period, formats.shade_stages)
    if not formats.with_shade:
        return drawn
    state = colour_state(formats) if state is None else state
    channels = formats.num_channels
    colours = shade_fast(drawn.value[:, :channels], state, formats)
    return replace(drawn, value=np.concatenate([colours, drawn.value[:, channels:]], axis=1))
