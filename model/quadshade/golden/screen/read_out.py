# SPDX-License-Identifier: Apache-2.0
"""An area of the framebuffer in scanline order, and its CRC (``rtl/screen/read_out.vhd``)."""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from quadshade.golden.common.crc32 import crc_of


@dataclass(frozen=True)
class Area:
    """
    What is read: ``count`` pixels from (x, y) on, ``width`` to a scanline.

    An area that reaches below the screen ends with the screen's last scanline.
    """

    x: int
    y: int
    width: int
    count: int

    def fits(self, width: int, height: int) -> bool:
        """Whether an area is not empty and within the screen's columns; any other is refused."""
        inside = self.x + self.width <= width and self.y < height
        return self.width > 0 and self.count > 0 and inside


def read_out(
    words: Sequence[int], width: int, height: int, area: Area, num_bytes: int
) -> tuple[list[int], int]:
    """
    Read an area, one pixel at a time.

    Parameters
    ----------
    words : sequence of int
      The framebuffer, scanline by scanline.
    width, height : int
      Of the screen.
    area : Area
    num_bytes : int
      Of a pixel, channel 0 lowest.

    Returns
    -------
    list of int
      Values in the order in which they are emitted; none if the area does not fit.
    int
      CRC-32 of their bytes.
    """
    values = []
    if area.fits(width, height):
        for index in range(area.count):
            row, column = divmod(index, area.width)
            if area.y + row < height:
                values.append(words[(area.y + row) * width + area.x + column])
    data = b"".join(value.to_bytes(num_bytes, "little") for value in values)
    return values, crc_of(data)


def read_area(picture: np.ndarray, area: Area) -> tuple[bytes, int]:
    """
    Bytes and CRC-32 of an area of a picture: the same as :func:`read_out`.

    Parameters
    ----------
    picture : (height, width, c) uint8
    area : Area

    Returns
    -------
    bytes
      Channel 0 first; of the whole picture those of a PNG's scanlines.
    int
      As ``zlib.crc32`` gives.
    """
    height, width, channels = picture.shape
    data = b""
    if area.fits(width, height):
        data = picture[area.y :, area.x : area.x + area.width].tobytes()[: area.count * channels]
    return data, zlib.crc32(data)
