# SPDX-License-Identifier: Apache-2.0
"""Memory of one port, cycle by cycle (``rtl/common/single_port_ram.vhd``)."""

from __future__ import annotations

from quadshade.golden.common.block_ram import BlockRam


class SinglePortRam(BlockRam):
    """
    Memory without initial contents, read through two registers in cycles that do not write.

    Attributes
    ----------
    words, fetched, read_data
      As in :class:`BlockRam`.
    """

    def clock(self, write: tuple[int, int] | None, read_address: int | None) -> None:
        """
        One clock edge.

        Parameters
        ----------
        write : (int, int) or None
          Address and word.
        read_address : int or None
          None if the read port is not enabled. A cycle that writes leaves what is fetched undefined.
        """
        super().clock(write, read_address)
        if write is not None:
            self.fetched[0] = None
