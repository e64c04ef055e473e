# SPDX-License-Identifier: Apache-2.0
"""Word to output value (``rtl/core/output_clamp.vhd``)."""

from __future__ import annotations

from quadshade.golden.core.edge_dda import signed


def output_clamp(word: int, word_width: int, frac_bits: int, value_bits: int) -> int:
    """clamp(floor(word / 2**frac_bits), 0, 2**value_bits - 1) of a two's complement word."""
    return min(max(signed(word, word_width) >> frac_bits, 0), (1 << value_bits) - 1)
