# SPDX-License-Identifier: Apache-2.0
"""Words that count once they are committed (``rtl/link/frame_fifo.vhd``)."""

from __future__ import annotations


class FrameFifo:
    """
    A FIFO of frames.

    Parameters
    ----------
    num_words : int
      Room, for committed and for uncommitted words together.
    """

    def __init__(self, num_words: int) -> None:
        self.num_words = num_words
        self.committed: list[int] = []
        self.written: list[int] = []
        self.overflow = False

    @property
    def free(self) -> int:
        """Room that committed words leave."""
        return self.num_words - len(self.committed)

    def write(self, word: int) -> None:
        """A word of the frame that comes in; dropped if there is no room."""
        if len(self.committed) + len(self.written) == self.num_words:
            self.overflow = True
        else:
            self.written.append(word)

    def commit(self) -> None:
        """The frame stays, unless it did not fit."""
        if not self.overflow:
            self.committed += self.written
        self.discard()

    def discard(self) -> None:
        """The frame goes."""
        self.written = []
        self.overflow = False

    def take(self) -> int:
        """The oldest committed word."""
        return self.committed.pop(0)
