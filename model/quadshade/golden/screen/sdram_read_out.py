# SPDX-License-Identifier: Apache-2.0
"""An area of a plane in an SDRAM, word by word (``rtl/screen/sdram_read_out.vhd``)."""

from __future__ import annotations

from collections.abc import Iterator

from quadshade.golden.common.sdram_controller import Run


def area_runs(
    plane: int, x: int, y: int, columns: int, width: int, height: int, run_words: int
) -> Iterator[Run]:
    """
    Runs of an area down to the last scanline, in their order.

    Parameters
    ----------
    plane, x, y, columns : int
      Of the memory; first place, and columns of the area.
    width, height, run_words : int
      Of the screen; no run goes over a multiple of ``run_words``.
    """
    y_bits, x_bits = ((count - 1).bit_length() for count in (height, width))
    for row in range(y, height):
        column, end = x, x + columns
        while column < end:
            words = min(run_words - column % run_words, end - column)
            yield Run((plane << y_bits | row) << x_bits | column, words - 1)
            column += words
