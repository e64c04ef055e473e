# SPDX-License-Identifier: Apache-2.0
"""A plane's pixels as bytes (``rtl/screen/plane_reader.vhd``)."""

from __future__ import annotations

from collections.abc import Iterable

from quadshade.contract.protocol import EDGE_BYTES, PLANES

COLOUR, DEPTH, EDGES_DIAGONAL, EDGES_EIGHT = range(len(PLANES))


def plane_reader(
    plane: int, count: int, pixels: Iterable[tuple[int, int]], value_bytes: int, depth_bytes: int
) -> bytes:
    """
    Bytes of a run of pixels, the lowest byte of each first.

    Parameters
    ----------
    plane : int
      Of ``protocol.PLANES``.
    count : int
      Bytes wanted; the last pixel's may be cut.
    pixels : iterable of (data, edges)
      Depth above value, and the pixel of the edge map.
    value_bytes, depth_bytes : int
      Of a pixel.

    Returns
    -------
    bytes
      ``count``, fewer where the pixels end.
    """
    data = bytearray()
    for pixel, edges in pixels:
        if len(data) >= count:
            break
        if plane in (EDGES_DIAGONAL, EDGES_EIGHT):
            data += edges.to_bytes(EDGE_BYTES, "little")
        else:
            every = pixel.to_bytes(value_bytes + depth_bytes, "little")
            data += every[value_bytes:] if plane == DEPTH else every[:value_bytes]
    return bytes(data[:count])
