# SPDX-License-Identifier: Apache-2.0
"""Requests to read, one after the other (``rtl/screen/plane_requests.vhd``)."""

from __future__ import annotations

import zlib
from collections.abc import Iterable
from dataclasses import dataclass

from quadshade.golden.screen.plane_reader import plane_reader


@dataclass(frozen=True)
class Area:
    """What is read of a plane: columns x .. x + width − 1 from y on, so many bytes."""

    x: int
    y: int
    width: int
    count: int
    plane: int


def whole_plane(width: int, height: int, plane: int, pixel_bytes: int) -> Area:
    """The area of which FRAME_CRC is the CRC-32."""
    return Area(0, 0, width, width * height * pixel_bytes, plane)


def area_bytes(
    area: Area, pixels: Iterable[tuple[int, int]], value_bytes: int, depth_bytes: int
) -> tuple[bytes, int]:
    """Bytes of an area's pixels, (data, edges) each, and their CRC-32."""
    data = plane_reader(area.plane, area.count, pixels, value_bytes, depth_bytes)
    return data, zlib.crc32(data)
