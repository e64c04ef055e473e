# SPDX-License-Identifier: Apache-2.0
"""CRC-32 of a stream of bytes, bit by bit (``rtl/common/crc32.vhd``)."""

from __future__ import annotations

ONES = 0xFFFFFFFF
POLYNOMIAL = 0xEDB88320
"""0x04C11DB7 of IEEE 802.3, lowest bit first."""

CRC_RESIDUE = 0x2144DF1C
"""CRC of any bytes followed by their own CRC, lowest byte first."""


class Crc32:
    """The remainder register; :attr:`crc` is that of the bytes so far."""

    def __init__(self) -> None:
        self.remainder = ONES

    @property
    def crc(self) -> int:
        """CRC of the bytes since :meth:`clear`."""
        return self.remainder ^ ONES

    def clear(self) -> None:
        """Begin anew."""
        self.remainder = ONES

    def add(self, byte: int) -> None:
        """One byte, its lowest bit first."""
        for index in range(8):
            out_bit = (self.remainder ^ byte >> index) & 1
            self.remainder = self.remainder >> 1 ^ (POLYNOMIAL if out_bit else 0)


def _byte_remainder(byte: int) -> int:
    """What is left of one byte."""
    crc = Crc32()
    crc.remainder = 0
    crc.add(byte)
    return crc.remainder


_REMAINDERS = [_byte_remainder(byte) for byte in range(256)]


def crc_of(data: bytes) -> int:
    """CRC-32 of some bytes, a byte at a time."""
    remainder = ONES
    for byte in data:
        remainder = remainder >> 8 ^ _REMAINDERS[(remainder ^ byte) & 0xFF]
    return remainder ^ ONES
