# SPDX-License-Identifier: Apache-2.0
"""What ``vertex_unpacker`` counts with: an accumulator, a shift register, what operations make of them."""

from __future__ import annotations

import numpy as np
from numba import njit

from quadshade.contract.arrays import Int
from quadshade.contract.vertex_program import SPENT_BITS, WIDTH

GUARD = WIDTH + 2
"""Bits of the accumulator: a sum may be twice the operand beside a word."""

_DIGIT = 12


@njit(cache=True)
def cut(value: Int, bits: int) -> Int:
    """The lowest bits, sign extended."""
    unused = 64 - bits
    return (value << unused) >> unused


@njit(cache=True)
def muli(acc: Int, operand: Int, shifter: Int, count: int) -> Int:
    """Accumulator plus operand times the lowest bits of the shift register, signed; cut to a word."""
    return cut(acc + operand * cut(shifter, count), WIDTH)


@njit(cache=True)
def muli_steps(shifter: Int, count: int) -> int:
    """Clocks of :func:`muli`: until all bits that are left, as far as is looked, are the same."""
    steps = 1
    ones = (1 << (SPENT_BITS - 1)) - 1
    while 2 * steps < count:
        left = (shifter >> (2 * steps - 1)) & ones
        if left in (0, ones):
            break
        steps += 1
    return steps


@njit(cache=True)
def shift_clocks(count: Int) -> int:
    """Clocks of a shift by so many bits: four at a time, then one."""
    return int(max(count // 4 + count % 4, 1))


@njit(cache=True)
def mulf(acc: Int, operand: Int, shifter: Int, count: int) -> Int:
    """Floor of (accumulator + operand times the lowest bits of the shift register) / 2**count."""
    left, digits = cut(shifter, count), count
    # Digit by digit, so that products stay in 64 bits: the floor of a floor is the floor.
    while digits > _DIGIT:
        acc = (acc + operand * (left & ((1 << _DIGIT) - 1))) >> _DIGIT
        left >>= _DIGIT
        digits -= _DIGIT
    return (acc + operand * left) >> digits


@njit(cache=True)
def _quotient(acc: Int, operand: Int, count: int) -> tuple[Int, Int]:
    """As :func:`div` of what is no more than a fraction, which takes as many bits of it at a time as fit."""
    quotient: Int = np.int64(0)
    while count > 0:
        bits = min(count, 62 - WIDTH)
        wide = acc << bits
        digits = wide // operand
        acc = wide - digits * operand
        quotient = quotient << bits | digits
        count -= bits
    # The last bit was 0: the remainder that does not restore is below 0.
    return (acc if quotient & 1 else acc - operand), quotient


@njit(cache=True)
def div(acc: Int, operand: Int, shifter: Int, count: int) -> tuple[Int, Int]:
    """
    Steps of the non-restoring division of accumulator and shift register; what both then are.

    The quotient's bits are those of the restoring one; a remainder below 0 lacks the operand.
    """
    if shifter == 0 and 0 <= acc < operand < 1 << (WIDTH - 2):
        return _quotient(acc, operand, count)
    below = False
    for _ in range(count):
        ahead = 2 * acc + ((shifter >> (WIDTH - 1)) & 1)
        acc = cut(ahead + operand if below else ahead - operand, GUARD)
        below = bool(acc < 0)
        shifter = cut(2 * shifter + (not below), WIDTH)
    return acc, shifter


@njit(cache=True)
def fold(acc: Int) -> Int:
    """0, 1, 2, 3, 4 become 0, -1, 1, -2, 2."""
    return (acc >> 1) ^ -(acc & 1)
