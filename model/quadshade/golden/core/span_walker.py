# SPDX-License-Identifier: Apache-2.0
"""A span's pixels (``rtl/core/span_walker.vhd``)."""

from __future__ import annotations

from collections.abc import Iterator

from quadshade.contract.formats import Formats
from quadshade.golden.core.edge_walker import Scanline


def walk_span(scanline: Scanline, formats: Formats) -> Iterator[tuple[int, int, bool]]:
    """
    Walk a span away from the major edge.

    Yields
    ------
    x, y : int
    last : bool
      The primitive's last pixel.
    """
    mask = (1 << formats.coord_bits) - 1
    for index in range(scanline.pixels):
        u = scanline.column + index
        x = (~u if scanline.mirror else u) & mask
        yield x, scanline.y, scanline.last and index == scanline.pixels - 1
