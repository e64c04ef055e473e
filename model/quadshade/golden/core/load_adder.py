# SPDX-License-Identifier: Apache-2.0
"""What stands before an accumulator's register (``rtl/core/load_adder.vhd``)."""

from __future__ import annotations


def load_adder(load: int, start: int, value: int, step: int, width: int, carry_in: int = 0) -> int:
    """start if load, else value + step + carry_in modulo 2**width."""
    return start if load else (value + step + carry_in) % (1 << width)
