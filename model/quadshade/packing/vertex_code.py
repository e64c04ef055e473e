# SPDX-License-Identifier: Apache-2.0
"""
Tokens of packets that carry vertices to bits (``docs/reference/vertices.md``): numbers in Exponential-Golomb
codes with the best parameters of their kinds, bits, and runs of packed words.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from quadshade.contract.arrays import Int, Ints, Words32
from quadshade.contract.formats import SETUP_WORD_BITS
from quadshade.contract.vertex_program import (
    LARGEST_RUN,
    LONG_BITS,
    LONGEST_PREFIX,
    PARAMETER_BITS,
    RUN_BITS,
)

PLACE, COLOUR, DEPTH, MIDDLE, BITS, ONES, RUN = range(7)
"""Kinds of tokens: residuals by their parameter, bits, a number of ones and a zero, a run of packed words."""

NUM_CODED = 4


class Tokens(NamedTuple):
    """Kind and value of what the line carries, and the bits of plain ones."""

    kinds: Ints
    values: Ints
    bits: Ints


@njit(cache=True)
def _folded(value: Int) -> Int:
    """0, -1, 1, -2, 2 become 0, 1, 2, 3, 4."""
    return 2 * value if value >= 0 else -2 * value - 1


@njit(cache=True)
def _ones(left: Int, k: Int) -> int:
    """Ones before a folded residual with a parameter: each doubles how many it may be one of."""
    ones, least = 0, (left >> k) + 1
    while least > 1 and ones < LONGEST_PREFIX:
        least >>= 1
        ones += 1
    return ones


def _small_costs(size: int, most: int) -> Ints:
    """(size, most) int64: bits of folded residuals from 0 on, with each parameter."""
    parameters = np.arange(most)
    # As :func:`_ones`: the bits of a number, but one.
    ones = np.frexp((np.arange(size)[:, None] >> parameters) + 1.0)[1].astype(np.int64) - 1
    return 2 * ones + 1 + parameters


_SMALL_COSTS = _small_costs(128, 16)


@njit(cache=True)
def code_parameters(tokens: Tokens, count: int, parameters: Ints) -> None:
    """The parameter of each kind of residuals with the fewest bits (``parameters``, (4,))."""
    size, most = _SMALL_COSTS.shape
    costs = np.zeros((NUM_CODED, most), np.int64)
    # Most are small: how often each of those comes.
    small = np.zeros((NUM_CODED, size), np.int64)
    for at in range(count):
        kind = tokens.kinds[at]
        if kind >= NUM_CODED:
            continue
        left = _folded(tokens.values[at])
        if left < size:
            small[kind, left] += 1
            continue
        for k in range(most):
            ones = _ones(left, k)
            costs[kind, k] += 2 * ones + 1 + k if ones < LONGEST_PREFIX else LONGEST_PREFIX + LONG_BITS
    for kind in range(NUM_CODED):
        for left in range(size):
            for k in range(most):
                costs[kind, k] += small[kind, left] * _SMALL_COSTS[left, k]
        parameters[kind] = np.argmin(costs[kind])


@njit(cache=True)
def _put_bit(out: Words32, at: int, bit: Int) -> int:
    out[at // SETUP_WORD_BITS] |= np.uint32(np.uint32(bit) << np.uint32(at % SETUP_WORD_BITS))
    return at + 1


@njit(cache=True)
def _put(out: Words32, at: int, value: Int, bits: int) -> int:
    """So many bits of a value, the highest first."""
    for place in range(bits - 1, -1, -1):
        at = _put_bit(out, at, (value >> place) & 1)
    return at


@njit(cache=True)
def _put_ones(out: Words32, at: int, count: int) -> int:
    """So many ones and a zero, which the longest row of ones does not need."""
    for _ in range(count):
        at = _put_bit(out, at, np.int64(1))
    return at + (count < LONGEST_PREFIX)


def run_head(count: int) -> np.ndarray:
    """(m,) uint32: what stands before so many packed words."""
    out = np.zeros(1 + (3 + RUN_BITS) // SETUP_WORD_BITS, np.uint32)
    _put(out, _put(out, 0, np.int64(0b111), 3), np.int64(count), RUN_BITS)
    return out


@njit(cache=True)
def write_tokens(
    tokens: Tokens, count: int, parameters: Ints, packed: Words32, ends: Ints, out: Words32
) -> int:
    """
    Write parameters and tokens; returns the number of bits.

    Parameters
    ----------
    tokens, count
      From :func:`tokens_of`.
    parameters : (6,) int64
    packed : (m,) uint32
      Packed words of the runs, each from a whole word on.
    ends : (k,) int64
      Where each run's words end.
    out : uint32, written
      Zeros, and long enough.
    """
    at = _put(out, 0, np.int64(0b110), 3)
    for parameter in parameters:
        at = _put(out, at, parameter, PARAMETER_BITS)
    run = 0
    for index in range(count):
        kind, value = tokens.kinds[index], tokens.values[index]
        if kind == BITS:
            at = _put(out, at, value, tokens.bits[index])
        elif kind == ONES:
            at = _put_ones(out, at, value)
        elif kind == RUN:
            start, end = (ends[run - 1] if run else 0), ends[run]
            while start < end:
                size = min(end - start, LARGEST_RUN)
                at = _put(out, at, np.int64(0b111), 3)
                at = _put(out, at, np.int64(size), RUN_BITS)
                word = -(-at // SETUP_WORD_BITS)
                out[word : word + size] = packed[start : start + size]
                at = (word + size) * SETUP_WORD_BITS
                start += size
            run += 1
        else:
            left = _folded(value)
            k = parameters[kind]
            ones = _ones(left, k)
            if ones < LONGEST_PREFIX:
                at = _put(out, _put_ones(out, at, ones), left + (np.int64(1) << k), ones + k)
            else:
                at = _put(out, _put_ones(out, at, LONGEST_PREFIX), left, LONG_BITS)
    return at
