# SPDX-License-Identifier: Apache-2.0
"""
What the shade unit keeps for a frame: ambient colour, coefficients of every channel, power tables.

    addresses           data
    0 .. 4095           word ``address % 512`` of power table ``address // 512``: values at both ends
    4096 + 4 c + k      coefficient of channel c for colour k (0 red, 1 green, 2 blue)
    4128 + k            ambient of colour k, half a unit included
    4131                bit j: specular channel j skips its table; 8 + j: it counts where channel j is not 0
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from quadshade.contract.formats import (
    AMBIENT_ROW,
    COEFFICIENT_FRAC_BITS,
    FACTOR_BITS,
    POWER_BITS,
    POWER_MANTISSA_BITS,
    SHADED_COLOURS,
    STATE_REGISTERS,
    TABLE_WORDS,
    Formats,
)
from quadshade.errors import QuadshadeError

COEFFICIENT_LIMIT = 1 << (FACTOR_BITS - COEFFICIENT_FRAC_BITS)
"""A coefficient is less than this."""

Curve = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class ShadeState:
    """
    The shade unit's registers and tables, raw.

    A pixel is clamp(floor(ambient + sum of coefficient * factor)), a factor being a channel's value or,
    of a specular channel, its power (Barrera et al.: diffuse and specular interpolated apart).

    Attributes
    ----------
    ambient : (3,) int64
      Output units, 16 bits of fraction, one half added.
    coefficients : (channels, 3) int64
      16 bits of fraction; specular channels are the last.
    tables : (num_specular, entries) uint32
      Power tables: the value where an interval begins in the low half, where it ends in the high one.
    linear : int
      Bit j: specular channel j skips its table.
    gated : int
      Bit j: specular channel j counts only where channel j (its light's cosine) is more than zero.
    guard_bits : int
      Bits below an output unit at which the host rounds: 0 where the first channels are the colour.
    """

    ambient: np.ndarray
    coefficients: np.ndarray
    tables: np.ndarray
    linear: int
    gated: int
    guard_bits: int

    @classmethod
    def from_registers(cls, registers: Mapping[int, int], formats: Formats) -> ShadeState:
        """The state that words at addresses are: the inverse of :meth:`writes`. What is not there is 0."""

        def row(first: int, count: int) -> list[int]:
            return [registers.get(first + index, 0) for index in range(count)]

        colours = [row(STATE_REGISTERS + 4 * channel, 3) for channel in range(formats.num_channels)]
        *ambient, masks = row(STATE_REGISTERS + 4 * AMBIENT_ROW, SHADED_COLOURS + 1)
        tables = [row(table * TABLE_WORDS, table_entries(formats)) for table in range(formats.num_specular)]
        used = (1 << formats.num_specular) - 1
        return cls(
            np.array(ambient, dtype=np.int64),
            np.array(colours, dtype=np.int64),
            np.array(tables, dtype=np.uint32),
            masks & used,
            masks >> 8 & used,
            0,
        )

    def num_writes(self, first: int = 0) -> int:
        """How many :meth:`writes` are."""
        colours = self.coefficients.size + self.ambient.size + 1
        return colours + len(self.tables) * max(self.tables.shape[1] - first, 0)

    def writes(self, first: int = 0) -> np.ndarray:
        """(m, 2) uint32: addresses and data that load this state, of its tables from an entry on."""
        rows = [
            (table * TABLE_WORDS + first + index, word)
            for table, words in enumerate(self.tables.tolist())
            for index, word in enumerate(words[first:])
        ]
        for row, colours in enumerate([*self.coefficients.tolist()]):
            rows += [(STATE_REGISTERS + 4 * row + column, value) for column, value in enumerate(colours)]
        last = [*self.ambient.tolist(), self.linear | self.gated << 8]
        rows += [(STATE_REGISTERS + 4 * AMBIENT_ROW + column, value) for column, value in enumerate(last)]
        return np.array(rows, dtype=np.uint32)


def table_entries(formats: Formats) -> int:
    """Words of a power table that a lane's value can reach."""
    return (formats.lane_value_bits - POWER_MANTISSA_BITS + 1) << POWER_MANTISSA_BITS


@lru_cache
def table_places(formats: Formats) -> np.ndarray:
    """
    Where the intervals of a power table begin.

    The index is logarithmic in the distance from 1: 32 intervals for each factor of two, so that a
    narrow highlight has as many of them as a wide one.

    Returns
    -------
    (entries + 1,) float64
      Cosines, falling from 1; not below 0. Remembered, so not to be written.
    """
    index = np.arange(table_entries(formats) + 1)
    first = 1 << POWER_MANTISSA_BITS
    octave = np.maximum(index // first - 1, 0)
    distance = (index - first * octave) << octave
    places: np.ndarray = np.maximum(1 - distance / ((1 << formats.lane_value_bits) - 1), 0.0)
    places.setflags(write=False)
    return places


def specular_gain(formats: Formats) -> float:
    """
    What a specular channel's samples are multiplied by: a cosine of 1 becomes the lane's largest value.

    The distance from it is then the value with its bits inverted.
    """
    largest = (1 << formats.lane_value_bits) - 1
    return largest / (((1 << formats.value_bits) - 1) << formats.shade_guard_bits)


def curve_table(curve: Curve, formats: Formats) -> np.ndarray:
    """
    The power table of any curve.

    Parameters
    ----------
    curve : callable
      (m,) float64 cosines in [0, 1] to (m,) values in [0, 1]. A jump becomes a ramp over one interval.
    formats : Formats

    Returns
    -------
    (entries,) uint32

    Raises
    ------
    QuadshadeError
      A value outside [0, 1].
    """
    values = np.asarray(curve(table_places(formats)), dtype=np.float64)
    if not ((values >= 0) & (values <= 1)).all():
        raise QuadshadeError("the specular curve leaves 0 .. 1", "scale it, and the light's colour instead")
    full = ((1 << formats.value_bits) - 1) << (POWER_BITS - formats.value_bits)
    levels = np.rint(values * full).astype(np.uint32)
    return levels[:-1] | levels[1:] << np.uint32(POWER_BITS)


def power_curve(exponent: float, reach: float = 1.0) -> Curve:
    """The curve (x / reach)**exponent, where x is a cosine times ``reach``: 1 at most."""
    return lambda cosine: np.minimum(cosine / reach, 1.0) ** exponent


def channel_gains(state: ShadeState, formats: Formats) -> np.ndarray:
    """
    What the shade unit makes of an error in a channel.

    Parameters
    ----------
    state : ShadeState
    formats : Formats

    Returns
    -------
    (num_channels,) float64
      Most output units of a colour for one of the channel: its largest coefficient, times the steepest slope
      of its power table.
    """
    gains = state.coefficients.max(axis=1) / (1 << COEFFICIENT_FRAC_BITS)
    first = formats.num_channels - formats.num_specular
    distances = -np.diff(table_places(formats))
    full = ((1 << formats.value_bits) - 1) << (POWER_BITS - formats.value_bits)
    for number, table in enumerate(state.tables.astype(np.int64)):
        if not state.linear >> number & 1:
            rise = np.abs((table >> POWER_BITS) - (table & ((1 << POWER_BITS) - 1))) / full
            # The last interval may be cut at a cosine of 0.
            slopes = rise[:-1] / distances[: len(table) - 1]
            gains[first + number] *= slopes.max(initial=0.0)
    return gains


def shade_state(
    formats: Formats,
    ambient: npt.ArrayLike,
    coefficients: npt.ArrayLike,
    curves: Sequence[Curve],
    gated: int = 0,
) -> ShadeState:
    """
    The state of a frame.

    Parameters
    ----------
    formats : Formats
      With shade.
    ambient : 3 floats
      1 is full intensity; what is more is cut there.
    coefficients : (num_channels, 3) floats
      Colour that a channel's full value adds, 0 <= c < 4; the specular channels come last.
    curves : num_specular callables
      What each specular channel goes through: see :func:`curve_table`.
    gated : int
      Bit j: specular channel j counts only where channel j is more than zero.

    Returns
    -------
    ShadeState

    Raises
    ------
    QuadshadeError
      A coefficient or a number of channels or curves that the unit cannot have.
    """
    wanted = (formats.num_channels, SHADED_COLOURS)
    factors = np.asarray(coefficients, dtype=np.float64)
    factors = factors.reshape(factors.shape[0], -1)
    if factors.shape != wanted or len(curves) != formats.num_specular:
        raise QuadshadeError(
            f"colours of {len(factors)} channels and {len(curves)} curves for"
            f" {formats.num_channels} channels, {formats.num_specular} of them specular",
            "give as many as generics num_channels and num_specular say",
        )
    raw = np.rint(factors * (1 << COEFFICIENT_FRAC_BITS))
    if not ((raw >= 0) & (raw < 1 << FACTOR_BITS)).all():
        raise QuadshadeError(
            f"a channel's colour is not in 0 .. {COEFFICIENT_LIMIT}", "scale the channel's samples"
        )
    top = (1 << formats.value_bits) - 1
    levels = np.clip(np.asarray(ambient, dtype=np.float64), 0, 1) * top + 0.5
    return ShadeState(
        np.rint(levels * (1 << COEFFICIENT_FRAC_BITS)).astype(np.int64),
        raw.astype(np.int64),
        np.stack([curve_table(curve, formats) for curve in curves]),
        0,
        gated,
        formats.shade_guard_bits,
    )


def colour_state(formats: Formats) -> ShadeState:
    """The state in which the first three channels are the colour, bit for bit as without the shade unit."""
    coefficients = np.zeros((formats.num_channels, SHADED_COLOURS), dtype=np.int64)
    np.fill_diagonal(coefficients[:SHADED_COLOURS], 1 << COEFFICIENT_FRAC_BITS)
    return ShadeState(
        np.zeros(SHADED_COLOURS, dtype=np.int64),
        coefficients,
        np.zeros((formats.num_specular, 0), dtype=np.uint32),
        (1 << formats.num_specular) - 1,
        0,
        0,
    )
