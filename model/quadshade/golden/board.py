# SPDX-License-Identifier: Apache-2.0
"""A whole board between two bytes of its line (``rtl/board.vhd``)."""

from __future__ import annotations

import numpy as np

from quadshade.contract.formats import Formats
from quadshade.contract.protocol import (
    COLOUR_BITS,
    COUNTERS,
    FEATURES,
    MAGIC,
    PACKED,
    VERSION,
    definition_hash,
    phase_step,
)
from quadshade.contract.shade_state import ShadeState, colour_state
from quadshade.golden.link.command_decoder import CommandDecoder
from quadshade.golden.link.pixel_packer import pack_pixels
from quadshade.golden.link.vertex_unpacker import VertexUnpacker
from quadshade.golden.link.word_unpacker import WordUnpacker
from quadshade.golden.screen.screen import Screen
from quadshade.golden.shade.render_core import draw


class DrawnScreen(Screen):
    """
    A screen with the core before it, which draws when the picture is looked at.

    Parameters
    ----------
    width, height : int
    formats : Formats
    with_edge_map : bool
    colour_bits : int
    with_vertices : bool
      Whether words are those of ``vertex_unpacker``.

    Attributes
    ----------
    words : list of int
      Packed words that are not drawn yet.
    registers : dict of int
      What STATE wrote, by address.
    """

    def __init__(
        self,
        width: int,
        height: int,
        formats: Formats,
        with_edge_map: bool = False,
        colour_bits: int = 8,
        with_vertices: bool = False,
    ) -> None:
        self.formats = formats
        self.words: list[int] = []
        self.unpacker = VertexUnpacker(formats) if with_vertices else WordUnpacker(formats)
        self.registers: dict[int, int] = {}
        if formats.with_shade:
            self.registers = dict(colour_state(formats).writes().tolist())
        depth_bits = formats.depth_bits if formats.with_depth else None
        super().__init__(width, height, formats.emitted_channels, depth_bits, with_edge_map, colour_bits)

    def triangles(self, words: list[int]) -> None:
        """Packed words, in order; a packet may go on in the next call."""
        self.words += words

    def state(self, address: int, value: int) -> None:
        """A word of the shading state; what was sent before it is drawn with the state before it."""
        if self.formats.with_shade:
            self.draw_words()
        self.registers[address] = value

    def reset(self) -> None:
        """Forget a begun packet."""
        self.words = []
        self.unpacker.reset()

    def clear(self, colour: int) -> None:
        """Fill the screen, empty the depth."""
        self.unpacked()
        super().clear(colour)

    def swap(self) -> None:
        """Show what was sent so far, draw the other buffer."""
        self.draw_words()
        super().swap()

    def unpacked(self) -> np.ndarray:
        """(m,) uint32: set-up words of the words that wait, which are then gone."""
        words, self.words = np.array(self.words, np.uint32), []
        return self.unpacker.feed(words)

    def draw_words(self) -> None:
        """Draw the words that wait."""
        words = self.unpacked()
        if not len(words):
            return
        state = ShadeState.from_registers(self.registers, self.formats) if self.formats.with_shade else None
        pixels = draw(words, self.formats, state)
        channels = self.formats.emitted_channels
        depth = pixels.value[:, channels] if self.formats.with_depth else None
        self.draw(pixels.x, pixels.y, pixels.value[:, :channels], depth)

    def plane(self, plane: int) -> np.ndarray:
        """As :meth:`Screen.plane`, of what was sent so far."""
        self.draw_words()
        return super().plane(plane)

    def read(self, x: int, y: int, width: int, count: int, plane: int, pixels: int = 0) -> bytes:
        """READ's answer, packed if its plane says so; ``pixels`` follows from ``count``."""
        plane, packs = plane & ~PACKED, bool(plane & PACKED)
        data = super().read(x, y, width, count, plane)
        return pack_pixels(data, self.plane(plane).shape[2]) if packs else data


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
    with_edge_map : bool
      Whether edges can be read.
    with_video : bool
      Whether it has words for a monitor: HELLO says so, nothing else is other.
    most_counter_bits : int
      STATUS's counters have no more bits.
    buffers : int
      2: one is drawn while the other is shown; SWAP swaps them.
    colour_bits : int
      Bits that the picture keeps of a colour: 8, 6 or 4.
    with_packed_read : bool
      Whether READ may ask for packed bytes.
    with_vertices : bool
      Whether triangles may come as their vertices.
    single_buffer : bool
      Whether packets wait for each other in its core: HELLO says so, no pixel is another.
    """

    def __init__(
        self,
        width: int = 160,
        height: int = 120,
        formats: Formats | None = None,
        clk_frequency_hz: int = 100_000_000,
        baud: int = 1_000_000,
        words: int = 1024,
        with_edge_map: bool = False,
        with_video: bool = False,
        most_counter_bits: int = 32,
        buffers: int = 1,
        colour_bits: int = 8,
        with_packed_read: bool = True,
        with_vertices: bool = False,
        single_buffer: bool = False,
    ) -> None:
        formats = formats or Formats()
        self.screen = screen = DrawnScreen(width, height, formats, with_edge_map, colour_bits, with_vertices)
        has = {
            "depth_test": formats.with_depth,
            "shade": formats.with_shade,
            "edge_map": with_edge_map,
            "display": with_video,
            "two_buffers": buffers == 2,
            COLOUR_BITS[colour_bits]: True,
            "packed_read": with_packed_read,
            "vertices": with_vertices,
            "single_buffer": single_buffer,
        }
        identity = {
            "magic": MAGIC,
            "definition": definition_hash(),
            "version": VERSION,
            "num_counters": len(COUNTERS),
            "clk_frequency_hz": clk_frequency_hz,
            "default_phase_step": phase_step(baud, clk_frequency_hz),
            "fifo_words": words,
            "features": sum(bool(has.get(name)) << bit for bit, name in enumerate(FEATURES)),
            "screen_width": width,
            "screen_height": height,
            "colour_bytes": formats.emitted_channels,
            "depth_bytes": screen.depth_bytes,
            **formats.generics(),
        }
        super().__init__(identity, screen, most_counter_bits)
