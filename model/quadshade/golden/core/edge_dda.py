# SPDX-License-Identifier: Apache-2.0
"""One edge of a triangle as an exact rational DDA (``rtl/core/edge_dda.vhd``)."""

from __future__ import annotations

from quadshade.contract.formats import Formats


def signed(raw: int, bits: int) -> int:
    """Value of a two's complement number of ``bits`` bits."""
    raw &= (1 << bits) - 1
    return raw - (1 << bits) if raw >> (bits - 1) else raw


class EdgeDda:
    """
    Column of an edge, scanline by scanline: floor((m + k dx) / dy) in additions only.

    Parameters
    ----------
    fields : dict of int
      Raw packet fields.
    edge : str
      ``major``, ``minor`` or ``second``.
    formats : Formats
    """

    def __init__(self, fields: dict[str, int], edge: str, formats: Formats) -> None:
        self.formats = formats
        self.column = fields[f"{edge}_column"]
        self.error = signed(fields[f"{edge}_error"], formats.error_bits)
        self.length = fields[f"{edge}_step"]
        self.increment = fields[f"{edge}_increment"]
        self.decrement = signed(fields[f"{edge}_decrement"], formats.error_bits)

    @property
    def carry(self) -> int:
        """1 if the edge moves one pixel more on its way to the next scanline."""
        return int(self.error >= 0)

    def step(self) -> None:
        """One scanline down."""
        carry = self.carry
        self.column = (self.column + self.length + carry) % (1 << self.formats.column_bits)
        self.error = signed(
            self.error + (self.decrement if carry else self.increment), self.formats.error_bits
        )
