# SPDX-License-Identifier: Apache-2.0
"""Memory of a write and a read port, cycle by cycle (``rtl/common/block_ram.vhd``)."""

from __future__ import annotations


class BlockRam:
    """
    Memory without initial contents, read through registers.

    Parameters
    ----------
    read_stages : int
      Registers of the read port. Of four or more the first holds the address, and a write waits in one too.

    Attributes
    ----------
    words : dict of int
      By address; what was never written is not there.
    fetched : list of int or None
      The read port's registers of words, the first one first; None where the word is undefined.
    """

    def __init__(self, read_stages: int = 2) -> None:
        self.words: dict[int, int] = {}
        self.early = read_stages >= 4
        self.fetched: list[int | None] = [None] * (read_stages - self.early)
        self._write: tuple[int, int] | None = None
        self._read_address: int | None = None

    @property
    def read_data(self) -> int | None:
        """The last register."""
        return self.fetched[-1]

    def clock(self, write: tuple[int, int] | None, read_address: int | None) -> None:
        """
        One clock edge.

        Parameters
        ----------
        write : (int, int) or None
          Address and word.
        read_address : int or None
          None if the read port is not enabled.
        """
        enabled, wanted = read_address is not None, read_address
        if self.early:
            self._write, write = write, self._write
            if enabled:
                self._read_address, wanted = read_address, self._read_address
        if enabled:
            collides = write is not None and write[0] == wanted
            self.fetched = [
                None if collides else None if wanted is None else self.words.get(wanted),
                *self.fetched[:-1],
            ]
        if write is not None:
            self.words[write[0]] = write[1]

    def fill(self, word: int, num_words: int) -> None:
        """Write every word, over what waits to be written."""
        self.words = dict.fromkeys(range(num_words), word)
        self._write = None
