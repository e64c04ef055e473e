# SPDX-License-Identifier: Apache-2.0
"""A primitive's scanlines from top to bottom (``rtl/core/edge_walker.vhd``)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from quadshade.contract.formats import Formats
from quadshade.golden.core.edge_dda import EdgeDda, signed


@dataclass
class Scanline:
    """
    One scanline of a primitive.

    Attributes
    ----------
    first, last : bool
      First and last scanline of the primitive.
    y, column : int
      Where the span starts, ``column`` counted from the major side.
    count : int
      Pixels minus 2, as the register holds it: -2 is an empty span, any other negative number one pixel.
    carry : int
      What the channels see of the major edge's carry on the way to the next scanline.
    mirror : bool
    """

    first: bool
    last: bool
    y: int
    column: int
    count: int
    carry: int
    mirror: bool

    @property
    def pixels(self) -> int:
        """Pixels drawn: the register's parity tells an empty span from a single pixel."""
        return self.count + 2 if self.count >= 0 else self.count & 1


def walk_edges(fields: dict[str, int], formats: Formats) -> Iterator[Scanline]:
    """
    Walk a primitive.

    Parameters
    ----------
    fields : dict of int
      Raw packet fields.
    formats : Formats

    Yields
    ------
    Scanline
      Empty ones too: the channels step over them.
    """
    major = EdgeDda(fields, "major", formats)
    minor = EdgeDda(fields, "minor", formats)
    rows = signed(fields["rows_first"], formats.column_bits)
    second_pending = bool(fields["has_second"])
    y = fields["y"]
    first = True
    while True:
        last = rows < 0 and not second_pending
        count = signed(minor.column - major.column - 2, formats.column_bits)
        carry = 0 if fields["fractional"] else major.carry
        yield Scanline(first, last, y, major.column, count, carry, bool(fields["mirror"]))
        if last:
            return
        major.step()
        if rows < 0:
            minor = EdgeDda(fields, "second", formats)
            rows = signed(fields["rows_second"], formats.column_bits)
            second_pending = False
        else:
            minor.step()
            rows -= 1
        y = (y + 1) % (1 << formats.coord_bits)
        first = False
