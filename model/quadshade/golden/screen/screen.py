# SPDX-License-Identifier: Apache-2.0
"""The picture and what can be read of it (``rtl/screen/screen.vhd``)."""

from __future__ import annotations

import zlib

import numpy as np

from quadshade.errors import QuadshadeError
from quadshade.golden.screen.depth_test import empty_depths, kept_pixels
from quadshade.golden.screen.edge_map import DEPTH_BITS, DIAGONAL, EIGHT, edge_map
from quadshade.golden.screen.framebuffer import HALF_STEP, kept_colours, thresholds
from quadshade.golden.screen.plane_reader import COLOUR, DEPTH, EDGES_DIAGONAL

EDGE_VARIANTS = (DIAGONAL, EIGHT)


def edge_plane(colour: np.ndarray, depth: np.ndarray, depth_bits: int, variant: int) -> np.ndarray:
    """
    The edge map as the link sends it.

    Parameters
    ----------
    colour : (h, w, 3) uint8
      Normals, encoded.
    depth : (h, w) int
      0 .. 2**depth_bits − 1; of more than 16 bits the top ones count.
    depth_bits : int
    variant : int
      ``edge_map.DIAGONAL`` or ``EIGHT``.

    Returns
    -------
    (h, w, 2) uint8
      Intensities from normals and from depth.
    """
    used = min(depth_bits, DEPTH_BITS[-1])
    return np.stack(edge_map(colour, depth >> (depth_bits - used), used, variant), axis=2)


class Screen:
    """
    z-buffer, framebuffer, and the planes that are read.

    Parameters
    ----------
    width, height : int
    num_channels : int
      Bytes of a pixel of the picture, 1 to 4.
    depth_bits : int or None
      None: there is no z-buffer, the last pixel of a place stays.
    with_edge_map : bool
    colour_bits : int
      Bits that are kept of a colour.

    Attributes
    ----------
    colour : (height, width, num_channels) uint8
      What is drawn and read.
    shown : (height, width, num_channels) uint8
      What a monitor shows of two buffers.
    depth : (height, width) int64
      2**depth_bits where nothing was drawn.

    Raises
    ------
    QuadshadeError
      An edge map without three channels and depth.
    """

    def __init__(
        self,
        width: int,
        height: int,
        num_channels: int = 3,
        depth_bits: int | None = 16,
        with_edge_map: bool = False,
        colour_bits: int = 8,
    ) -> None:
        if with_edge_map and (num_channels != 3 or depth_bits is None or depth_bits < DEPTH_BITS[0]):
            raise QuadshadeError("an edge map needs three channels and depth of at least 8 bits")
        self.depth_bits, self.with_edge_map, self.colour_bits = depth_bits, with_edge_map, colour_bits
        self.colour, self.shown = np.zeros((2, height, width, num_channels), np.uint8)
        self.clear(0)

    @property
    def depth_bytes(self) -> int:
        """Bytes of a pixel of the depth plane; 0 if there is none."""
        return -(-(self.depth_bits or 0) // 8)

    def clear(self, colour: int) -> None:
        """Fill the picture that is drawn, empty the z-buffer."""
        height, width, channels = self.colour.shape
        value = np.array(list(colour.to_bytes(4, "little")[:channels]))
        self.colour[:] = kept_colours(value, HALF_STEP, self.colour_bits)
        self.depth = empty_depths(width, height, self.depth_bits or 0)
        self._edges: dict[int, np.ndarray] = {}

    def swap(self) -> None:
        """Show the picture that was drawn, and draw the one that was shown; the z-buffer stays."""
        self.colour, self.shown = self.shown, self.colour
        self._edges = {}

    def draw(self, x: np.ndarray, y: np.ndarray, value: np.ndarray, depth: np.ndarray | None) -> None:
        """
        Draw pixels in their order.

        Parameters
        ----------
        x, y : (n,) int
        value : (n, num_channels) int
        depth : (n,) int or None
          None where there is no z-buffer.
        """
        height, width = self.depth.shape
        if self.depth_bits is None:
            kept = (x < width) & (y < height)
        elif depth is None:
            raise QuadshadeError("pixels without depth for a screen with a z-buffer", "give their depth")
        else:
            kept = kept_pixels(x, y, depth, self.depth)
        value = kept_colours(value, thresholds(x, y), self.colour_bits)
        for row, column, pixel in zip(y[kept].tolist(), x[kept].tolist(), value[kept].tolist(), strict=True):
            self.colour[row, column] = pixel
        self._edges = {}

    def plane(self, plane: int) -> np.ndarray:
        """(height, width, bytes) uint8: a plane of ``protocol.PLANES`` as the link sends it."""
        if plane == COLOUR:
            return self.colour
        if self.depth_bits is None:
            raise QuadshadeError("the screen has no depth", "read plane 0 only")
        height, width = self.depth.shape
        # An empty place has no depth; it reads as the farthest.
        depth = np.minimum(self.depth, (1 << self.depth_bits) - 1)
        if plane == DEPTH:
            return depth.astype("<u4").view(np.uint8).reshape(height, width, 4)[:, :, : self.depth_bytes]
        if plane not in self._edges:
            variant = EDGE_VARIANTS[plane - EDGES_DIAGONAL]
            self._edges[plane] = edge_plane(self.colour, depth, self.depth_bits, variant)
        return self._edges[plane]

    def read(self, x: int, y: int, width: int, count: int, plane: int) -> bytes:
        """``count`` bytes of a plane from (x, y) on, ``width`` pixels to a scanline."""
        return self.plane(plane)[y:, x : x + width].tobytes()[:count]

    def frame_crc(self, plane: int) -> int:
        """CRC-32 of a plane, scanline by scanline."""
        return zlib.crc32(self.plane(plane).tobytes())
