# SPDX-License-Identifier: Apache-2.0
"""Diffuse and specular channels to a colour, stage by stage (``rtl/shade/shade.vhd``)."""

from __future__ import annotations

from collections.abc import Sequence

from quadshade.contract.formats import COEFFICIENT_FRAC_BITS, FACTOR_BITS, POWER_BITS, SHADED_COLOURS, Formats
from quadshade.contract.shade_state import ShadeState
from quadshade.golden.shade.power_table import power_table


def factors(value: Sequence[int], state: ShadeState, formats: Formats) -> list[int]:
    """What the channels are multiplied as: left-aligned in 18 bits, specular ones through their tables."""
    aligned = [part << (FACTOR_BITS - formats.lane_value_bits) for part in value]
    diffuse = formats.num_channels - formats.num_specular
    for index in range(formats.num_specular):
        channel = diffuse + index
        if not state.linear >> index & 1:
            power = power_table(value[channel], state.tables[index], formats)
            aligned[channel] = power << (FACTOR_BITS - POWER_BITS)
        # The light's cosine: the channel of the same number, if that is a diffuse one.
        if state.gated >> index & 1 and index < diffuse and value[index] == 0:
            aligned[channel] = 0
    return aligned


def products(factor: int, coefficients: Sequence[int], formats: Formats) -> list[int]:
    """A channel's part of the three colours, cut to 16 bits of fraction."""
    return [factor * coefficient >> (FACTOR_BITS - formats.value_bits) for coefficient in coefficients]


def clamp(level: int, formats: Formats) -> int:
    """Whole output units; what is more than the largest is the largest."""
    return min(level >> COEFFICIENT_FRAC_BITS, (1 << formats.value_bits) - 1)


def shade(value: Sequence[int], state: ShadeState, formats: Formats) -> tuple[int, ...]:
    """
    The colour of a pixel.

    Parameters
    ----------
    value : sequence of int
      ``num_channels`` values of ``lane_value_bits`` bits; the specular ones last.
    state : ShadeState
    formats : Formats

    Returns
    -------
    3 ints
      ``value_bits`` bits each.
    """
    parts = [
        products(factor, coefficients, formats)
        for factor, coefficients in zip(
            factors(value, state, formats), state.coefficients.tolist(), strict=True
        )
    ]
    ambient = state.ambient.tolist()
    return tuple(
        clamp(ambient[colour] + sum(part[colour] for part in parts), formats)
        for colour in range(SHADED_COLOURS)
    )
