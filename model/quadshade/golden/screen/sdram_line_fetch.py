# SPDX-License-Identifier: Apache-2.0
"""Scanlines of a picture in an SDRAM for a monitor (``rtl/screen/sdram_line_fetch.vhd``)."""

from __future__ import annotations

from quadshade.golden.common.sdram_controller import Run, SdramGenerics


def line_runs(plane: int, y: int, width: int, height: int, run_words: int) -> list[Run]:
    """Runs of a scanline, from the left; of a plane of values, 0 or 1."""
    y_bits, x_bits = ((count - 1).bit_length() for count in (height, width))
    line = (plane << y_bits | y) << x_bits
    return [Run(line + x, run_words - 1) for x in range(0, width, run_words)]


def most_line_clocks(width: int, generics: SdramGenerics) -> int:
    """
    Clocks from the one in which a scanline is wanted to its last word, at most.

    Each of its runs waits for another port's longest run and a refresh; a run of its own is over before the
    next one's wait is. ``formal/screen/sdram_line_fetch.sv`` has the same.
    """
    longest = generics.run_clocks(generics.run_words, True) + generics.rfc_clocks
    return width // generics.run_words * (longest + 1) + generics.latency() + generics.run_words
