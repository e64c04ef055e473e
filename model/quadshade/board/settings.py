# SPDX-License-Identifier: Apache-2.0
"""Generics of a board (``rtl/board.vhd``): those of the core, and what is around it."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, fields, replace

from quadshade.contract.formats import Formats
from quadshade.contract.protocol import COLOUR_BITS, MAX_PAYLOAD
from quadshade.contract.vertex_program import check_formats
from quadshade.engine.sources import repository_root
from quadshade.errors import QuadshadeError
from quadshade.golden.screen.framebuffer import channel_bits
from quadshade.golden.screen.scan_out import Timing

LEAST_CLOCKS = 4
"""Fewest clocks of a bit on the line."""

ALLOWED: dict[str, Collection[int]] = {
    "with_edge_map": (0, 1),
    "single_port_memory": (0, 1),
    "with_video": (0, 1),
    "buffers": (1, 2),
    "colour_bits": tuple(COLOUR_BITS),
    "with_packed_read": (0, 1),
    "with_sdram": (0, 1),
    "sdram_row_bits": range(11, 14),
    "sdram_column_bits": range(8, 11),
    "sdram_refresh_clocks": range(100, 4096),
    "with_vertices": (0, 1),
    "single_buffer": (0, 1),
    "most_counter_bits": range(1, 33),
    "crc_cycles": (1, 2, 4, 8),
    "clocks_per_pixel": range(1, 17),
    "bank_words": tuple(1 << bits for bits in range(8, 17)),
}
"""Values of the board's own generics, those of sizes and rates apart."""


BOARD_FORMATS = {"value_bits": 8, "stream_width": 32}
"""A channel is a byte of the frame buffer, and the line gives 32 bits at a time."""

MOST_CHANNELS = 4
"""A clear has four bytes."""

SDRAM_DATA_BITS, SDRAM_RUN_WORDS = 16, 64
"""Of a word of the SDRAM, and words of a run, of which a scanline has at least two."""


LEAST_FIFO = 1 << (MAX_PAYLOAD // 4 - 1).bit_length()
"""Room for the words of the longest frame: a host waits until all of it fits."""


@dataclass(frozen=True)
class BoardSettings:
    """
    What a board is built with.

    Attributes
    ----------
    formats : Formats
    screen_width, screen_height : int
    clk_frequency_hz, baud : int
      System clock and the line's rate after power-up. A simulated clock is slow on purpose: a byte takes few
      clocks, and so little time.
    fifo_words : int
      Of the command FIFO: a power of two from 256, which hold the longest frame, to 32768.
    with_edge_map, single_port_memory, with_video, with_packed_read, with_vertices, single_buffer : int
      0 or 1. ``with_video`` makes words for a monitor, which only the golden model of a board shows.
    buffers : int
      2: one is shown while the other is drawn, until a swap.
    colour_bits : int
      Bits that the picture keeps of a colour: 8, or dithered 6 (of channel 1 five), 5 (of channel 1 six) or
      4.
    with_sdram : int
      1: both buffers and the depths are in an SDRAM.
    sdram_row_bits, sdram_column_bits, sdram_refresh_clocks : int
      Of the chip: its organisation, and clocks from a refresh to the next.
    most_counter_bits : int
      STATUS's counters wrap at that many bits, 1 to 32.
    crc_cycles : int
      Clocks that a byte of a CRC takes: a divisor of 8.
    clocks_per_pixel : int
      Of the monitor: 25 million pixels a second need 4 at 100 MHz.
    bank_words : int
      Words of a block of the device's memory, a bit wide: a power of two from 256 to 65536.

    Raises
    ------
    QuadshadeError
      A value out of range.
    """

    formats: Formats = field(default_factory=Formats)
    screen_width: int = 160
    screen_height: int = 120
    clk_frequency_hz: int = 5_000_000
    baud: int = 1_000_000
    fifo_words: int = 1024
    with_edge_map: int = 0
    single_port_memory: int = 0
    with_video: int = 0
    buffers: int = 1
    colour_bits: int = 8
    with_packed_read: int = 1
    with_vertices: int = 0
    most_counter_bits: int = 32
    single_buffer: int = 0
    crc_cycles: int = 1
    clocks_per_pixel: int = 4
    bank_words: int = 16384
    with_sdram: int = 0
    sdram_row_bits: int = 13
    sdram_column_bits: int = 9
    sdram_refresh_clocks: int = 780

    def __post_init__(self) -> None:
        limit = 1 << self.formats.coord_bits
        for name in ("screen_width", "screen_height"):
            if not 1 <= getattr(self, name) <= limit:
                raise QuadshadeError(
                    f"{name} is {getattr(self, name)}", f"give 1 to {limit} (generic coord_bits)"
                )
        self._check_formats()
        if self.fifo_words.bit_count() != 1 or not LEAST_FIFO <= self.fifo_words <= 32768:
            raise QuadshadeError(
                f"fifo_words is {self.fifo_words}", f"give a power of two from {LEAST_FIFO} to 32768"
            )
        if not 1 <= self.clk_frequency_hz < 1 << 30:
            raise QuadshadeError(f"clk_frequency_hz is {self.clk_frequency_hz}", "give hertz below 2**30")
        if not 1 <= self.baud <= self.clk_frequency_hz // LEAST_CLOCKS:
            raise QuadshadeError(
                f"{self.baud} baud at {self.clk_frequency_hz} Hz",
                f"give at most a quarter of the clock: {self.clk_frequency_hz // LEAST_CLOCKS}",
            )
        for name, allowed in ALLOWED.items():
            if getattr(self, name) not in allowed:
                raise QuadshadeError(f"{name} is {getattr(self, name)}", f"give {_choice(allowed)}")
        if self.with_sdram:
            self._check_sdram()
        if self.with_video:
            self._check_video()
        if self.with_vertices:
            check_formats(self.formats)

    def _check_formats(self) -> None:
        """What ``board`` and ``screen`` assert of the core's generics."""
        formats = self.formats
        for name, needed in BOARD_FORMATS.items():
            if getattr(formats, name) != needed:
                raise QuadshadeError(
                    f"generic {name} is {getattr(formats, name)}, and every board has {needed}",
                    "leave it out",
                )
        channels = formats.emitted_channels
        if channels > MOST_CHANNELS:
            raise QuadshadeError(
                f"a board with {channels} channels of colour", f"give at most {MOST_CHANNELS} (num_channels)"
            )
        if self.with_edge_map and not (formats.with_depth and channels == 3 and formats.depth_bits >= 8):
            raise QuadshadeError(
                f"with_edge_map=1 with {channels} channels and {formats.depth_bits * formats.with_depth} bits"
                " of depth",
                "give three channels and at least 8 bits",
            )
        if self.single_port_memory and (formats.with_depth or self.with_video):
            raise QuadshadeError(
                "single_port_memory=1 with a depth or a monitor", "give with_depth=0 and with_video=0"
            )
        if self.single_port_memory and self.buffers == 2:
            raise QuadshadeError("single_port_memory=1 with two buffers", "give buffers=1")

    def _check_video(self) -> None:
        """What ``scan_out`` asserts: whole squares fill the monitor."""
        monitor = Timing()
        scale, rest = divmod(monitor.columns, self.screen_width)
        if rest or scale * self.screen_height != monitor.lines or self.formats.emitted_channels not in (1, 3):
            raise QuadshadeError(
                f"with_video=1 with {self.screen_width}x{self.screen_height} pixels of"
                f" {self.formats.emitted_channels} channels on {monitor.columns}x{monitor.lines}",
                "give --generic with_video=0, or 1 or 3 channels and a screen that fills it as 320x240 does",
            )

    def _check_sdram(self) -> None:
        """What ``board`` and ``sdram_screen`` assert of a picture in an SDRAM."""
        formats, colours = self.formats, self.formats.emitted_channels
        bits = sum(channel_bits(channel, self.colour_bits) for channel in range(colours))
        if self.buffers != 2 or self.with_edge_map or self.single_port_memory:
            raise QuadshadeError(
                "with_sdram=1 with one buffer, an edge map or single_port_memory",
                "give buffers=2, with_edge_map=0 and single_port_memory=0",
            )
        if bits > SDRAM_DATA_BITS or not formats.with_depth or formats.depth_bits >= SDRAM_DATA_BITS:
            raise QuadshadeError(
                f"with_sdram=1 with {bits} bits of colours and"
                f" {formats.depth_bits * formats.with_depth} of depth",
                "a pixel has 16 and 1 to 15: give colour_bits=5 and depth_bits=15",
            )
        width, height = self.screen_width, self.screen_height
        if width % SDRAM_RUN_WORDS or width == SDRAM_RUN_WORDS:
            raise QuadshadeError(
                f"with_sdram=1 with a screen {width} pixels wide", "give a multiple of 64, from 128 on"
            )
        needed = 2 + (height - 1).bit_length() + (width - 1).bit_length()
        if needed > self.sdram_row_bits + 2 + self.sdram_column_bits:
            raise QuadshadeError(
                f"an SDRAM too small for three planes of {width}x{height}", "give a smaller screen"
            )

    def generics(self) -> dict[str, int]:
        """Every generic of the entity ``board`` by its VHDL name."""
        own = {name: getattr(self, name) for name in own_names()}
        return self.formats.generics() | own

    def with_generics(self, settings: Mapping[str, int]) -> BoardSettings:
        """
        A copy with some generics replaced, the core's or the board's.

        Raises
        ------
        QuadshadeError
          A name that neither has, or a value out of range.
        """
        own = {name: value for name, value in settings.items() if name in own_names()}
        core = {name: value for name, value in settings.items() if name not in own}
        unknown = sorted(core.keys() - self.formats.generics().keys())
        if unknown:
            known = ", ".join(self.generics())
            raise QuadshadeError(f"a board has no generic {unknown[0]!r}", f"the generics are {known}")
        return replace(self, formats=self.formats.with_generics(core), **own)


def _choice(allowed: Collection[int]) -> str:
    """Values as a user reads them."""
    if isinstance(allowed, range):
        return f"{allowed[0]} to {allowed[-1]}"
    return " or ".join(map(str, allowed))


def own_names() -> list[str]:
    """Generics that the core does not have."""
    return [one.name for one in fields(BoardSettings) if one.name != "formats"]


def board_settings(
    preset: str | None,
    screen: tuple[int, int] | None,
    generics: Mapping[str, int],
    shade: bool = False,
) -> BoardSettings:
    """
    Generics of a simulated board.

    Parameters
    ----------
    preset : str or None
      A real board, e.g. ``icebreaker``, whose generics it has, but for the clock.
    screen : tuple of int or None
      Width and height.
    generics : mapping of str to int
      Those that the user has set; they win.
    shade : bool
      With the shade unit: a diffuse and a specular channel.

    Raises
    ------
    QuadshadeError
      An unknown board, a wrong size, or generics that no board has.
    """
    given: dict[str, int] = {} if preset is None else _preset(preset)
    if shade:
        given |= {"with_shade": 1, "num_channels": 2, "num_specular": 1}
    if screen is not None:
        given["screen_width"], given["screen_height"] = screen
    # All at once: a size may be one that only another generic allows.
    return BoardSettings().with_generics(given | dict(generics))


def _preset(name: str) -> dict[str, int]:
    """
    Generics of a real board, but for its clock: a simulated one is slow on purpose.

    Raises
    ------
    QuadshadeError
      There is no such board, or no bitstream is built for it.
    """
    # Not for everyone who wants a board: it brings all of synthesis.
    from quadshade.synthesis.bitstream import read_board

    generics = read_board(name, repository_root()).generics
    return {key: value for key, value in generics.items() if key not in ("clk_frequency_hz", "baud")}
