# SPDX-License-Identifier: Apache-2.0
"""A board in this process: the golden models of link, core and z-buffer, behind bytes of a serial line."""

from __future__ import annotations

import zlib

import numpy as np

from quadshade.formats import Formats
from quadshade.golden.command_decoder import CommandDecoder
from quadshade.golden.depth_test import empty_depths, kept_pixels
from quadshade.golden.fast import draw_fast
from quadshade.link.protocol import COUNTERS, MAGIC, VERSION, definition_hash, phase_step


class Screen:
    """
    Core, z-buffer and framebuffer, drawing when the picture is looked at.

    Parameters
    ----------
    width, height : int
    formats : Formats

    Attributes
    ----------
    colour : (height, width, channels) uint8
    words : list of int
      Set-up words that are not drawn yet.
    """

    def __init__(self, width: int, height: int, formats: Formats) -> None:
        self.formats = formats
        self.colour = np.zeros((height, width, formats.num_channels), np.uint8)
        self.words: list[int] = []
        self.registers: dict[int, int] = {}
        self.clear(0)

    def triangles(self, words: list[int]) -> None:
        self.words += words

    def state(self, address: int, value: int) -> None:
        self.registers[address] = value

    def reset(self) -> None:
        self.words = []

    def clear(self, colour: int) -> None:
        self.words = []
        height, width, channels = self.colour.shape
        self.colour[:] = list(colour.to_bytes(4, "little")[:channels])
        self.depth = empty_depths(width, height, self.formats.depth_bits)

    def draw(self) -> None:
        """Draw the words that wait."""
        words, self.words = np.array(self.words, np.uint32), []
        if not len(words):
            return
        pixels = draw_fast(words, self.formats)
        x, y, value = pixels.x, pixels.y, pixels.value
        channels = self.formats.num_channels
        if self.formats.with_depth:
            kept = kept_pixels(x, y, value[:, channels], self.depth)
            x, y, value = x[kept], y[kept], value[kept]
        for place in zip(y.tolist(), x.tolist(), value[:, :channels].tolist(), strict=True):
            self.colour[place[0], place[1]] = place[2]

    def plane(self, plane: int) -> np.ndarray:
        """(height, width, bytes) uint8: colour, or depth as the link sends it."""
        self.draw()
        if plane == 0:
            return self.colour
        height, width = self.depth.shape
        # An empty place has no depth; it reads as the farthest.
        depth = np.minimum(self.depth, (1 << self.formats.depth_bits) - 1).astype("<u4")
        return depth.view(np.uint8).reshape(height, width, 4)[:, :, : -(-self.formats.depth_bits // 8)]

    def read(self, x: int, y: int, width: int, count: int, pixels: int, plane: int) -> bytes:
        return self.plane(plane)[y:, x : x + width].tobytes()[:count]

    def frame_crc(self, plane: int) -> int:
        return zlib.crc32(self.plane(plane).tobytes())


class BoardModel(CommandDecoder):
    """
    A whole board: bytes in, bytes out.

    Parameters
    ----------
    width, height : int
      Of the screen.
    formats : Formats, optional
    clk_frequency_hz, baud, words : int
      System clock, default rate, words of the command FIFO.
    """

    def __init__(
        self,
        width: int = 160,
        height: int = 120,
        formats: Formats | None = None,
        clk_frequency_hz: int = 100_000_000,
        baud: int = 1_000_000,
        words: int = 1024,
    ) -> None:
        formats = formats or Formats()
        identity = {
            "magic": MAGIC,
            "definition": definition_hash(),
            "version": VERSION,
            "num_counters": len(COUNTERS),
            "clk_frequency_hz": clk_frequency_hz,
            "default_phase_step": phase_step(baud, clk_frequency_hz),
            "fifo_words": words,
            "features": formats.with_depth,
            "screen_width": width,
            "screen_height": height,
            "colour_bytes": formats.num_channels,
            "depth_bytes": -(-formats.depth_bits // 8) * formats.with_depth,
            **formats.generics(),
        }
        super().__init__(identity, Screen(width, height, formats))
