# SPDX-License-Identifier: Apache-2.0
"""A cosine through a curve: table lookup and interpolation, by stages (``rtl/shade/power_table.vhd``)."""

from __future__ import annotations

from collections.abc import Sequence

from quadshade.contract.formats import POWER_BITS, POWER_MANTISSA_BITS, Formats

_TOP_BITS = POWER_MANTISSA_BITS + 1


def distance(value: int, formats: Formats) -> int:
    """How far a lane's value lies below full scale: its bits inverted."""
    return ((1 << formats.lane_value_bits) - 1) - value


def exponent(far: int) -> int:
    """By how many bits the leading one of a distance lies above a mantissa; 0 where it does not."""
    return max(far.bit_length() - _TOP_BITS, 0)


def normalise(far: int, octave: int, formats: Formats) -> tuple[int, int]:
    """Index of the interval, and the fraction within it, of ``lane_value_bits`` - 6 bits."""
    fraction_bits = formats.lane_value_bits - _TOP_BITS
    shifted = far << (fraction_bits - octave)
    index = (octave << POWER_MANTISSA_BITS) + (shifted >> fraction_bits)
    return index, shifted & ((1 << fraction_bits) - 1)


def interpolate(word: int, fraction: int, formats: Formats) -> int:
    """Between the values of a table's word, rounded to nearest, half up."""
    fraction_bits = formats.lane_value_bits - _TOP_BITS
    here, there = word & ((1 << POWER_BITS) - 1), word >> POWER_BITS
    product = (there - here) * fraction
    return here + ((product + (1 << (fraction_bits - 1))) >> fraction_bits)


def power_table(value: int, table: Sequence[int], formats: Formats) -> int:
    """
    The curve at a lane's value.

    Parameters
    ----------
    value : int
      ``lane_value_bits`` bits.
    table : sequence of int
      Words of 32 bits; those that are missing are 0.
    formats : Formats

    Returns
    -------
    int
      16 bits; full scale is (2**value_bits - 1) * 2**(16 - value_bits).
    """
    far = distance(value, formats)
    index, fraction = normalise(far, exponent(far), formats)
    return interpolate(int(table[index]) if index < len(table) else 0, fraction, formats)
