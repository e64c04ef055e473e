# SPDX-License-Identifier: Apache-2.0
"""The fill of a memory, cycle by cycle (``rtl/common/memory_clear.vhd``)."""

from __future__ import annotations


class MemoryClear:
    """
    Fills on request, when nothing is on its way to the memory.

    Parameters
    ----------
    num_words : int

    Attributes
    ----------
    draining : bool
      A request waits.
    address : int or None
      Word that is filled in this cycle; 0 after reset.
    """

    def __init__(self, num_words: int) -> None:
        self.num_words = num_words
        self.reset()

    def reset(self) -> None:
        """Begin a fill."""
        self.draining = False
        self.address: int | None = 0

    @property
    def busy(self) -> bool:
        """True if nothing new may come, and no request is heard."""
        return self.draining or self.address is not None

    def clock(self, clear: bool, emptied: bool) -> None:
        """One clock edge."""
        if self.address is not None:
            self.address = self.address + 1 if self.address < self.num_words - 1 else None
        elif self.draining and emptied:
            self.draining, self.address = False, 0
        elif clear and not self.busy:
            self.draining = True
