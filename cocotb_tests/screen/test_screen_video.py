# SPDX-License-Identifier: Apache-2.0
"""
What is drawn, on the monitor: the screen's words of 640 x 480 against the model, while it is read too.

With two buffers: a swap waits for the vertical blank, and what is shown then is changed by nothing that is
drawn, cleared or read.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cocotb
import numpy as np
import pytest
from cocotb.triggers import FallingEdge, RisingEdge, Timer
from cocotb.utils import get_sim_time

from cocotb_tests.support.bench import PERIOD_NS, Bench
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.golden.screen.framebuffer import kept_colours, thresholds
from quadshade.golden.screen.scan_out import Timing, frame_words

TIMING = Timing()
LATENCY = 7
"""Pixels from a place of the frame to its words."""
PIXEL = ("x", "y", "value", "depth")
AREA = ("x", "y", "width", "count", "plane")
FIRST, LAST = 16, 36
"""Lines that are compared; before them the memory is filled and drawn into."""
READ = 24
"""Line in which others read."""


@dataclass(frozen=True)
class Config:
    """Generics of ``screen``."""

    width: int = 160
    height: int = 120
    coord_bits: int = 8
    with_depth: int = 1
    with_video: int = 1
    buffers: int = 1
    colour_bits: int = 8
    clocks_per_pixel: int = 4
    bank_words: int = 16384

    @property
    def pixel_ns(self) -> float:
        """A pixel, in the simulation's time."""
        return self.clocks_per_pixel * PERIOD_NS

    def kept(self, picture: np.ndarray) -> np.ndarray:
        """A picture as it is shown, (h, w, 3) uint8."""
        y, x = np.indices(picture.shape[:2])
        return kept_colours(picture, thresholds(x, y), self.colour_bits).astype(np.uint8)


CONFIGS = [
    Config(),
    # Fewer memories to simulate, for a whole frame passes.
    Config(80, 60, coord_bits=7, with_depth=0, buffers=2, colour_bits=4, clocks_per_pixel=2, bank_words=4096),
]


@pytest.mark.parametrize("config", CONFIGS, ids=identifier)
def test_screen_video(config: Config) -> None:
    simulate("screen", config, tests="screen_video")


INPUTS = (
    *("read_reset", "clear_valid", "clear_colour", "swap_valid", "pixel_valid"),
    *(f"pixel_{name}" for name in PIXEL),
    *("read_valid", *(f"read_{name}" for name in AREA), "read_data_ready"),
    *("frame_crc_valid", "frame_crc_plane"),
)


class Monitor:
    """
    A screen, and the words that it shows.

    Attributes
    ----------
    words : dict of int
      By their place in the row of all since reset; None where the memory was never written.
    """

    def __init__(self, bench: Bench) -> None:
        self.bench, self.dut = bench, bench.dut
        self.words: dict[int, int | None] = {}
        self.begin: float | None = None
        self.watching = True

    async def watch(self) -> None:
        """Take the words while they are looked at."""
        while self.watching:
            # In the middle of a cycle everything has settled.
            await FallingEdge(self.dut.clk)
            if self.dut.video_next.value:
                if self.begin is None:
                    self.begin = get_sim_time("ns")
                # The first scanlines are shown before anything was written.
                value = self.dut.video_words.value
                self.words[self.place()] = int(value) if value.is_resolvable else None

    def place(self) -> int:
        """The place of the word that came last."""
        return (
            0 if self.begin is None else int((get_sim_time("ns") - self.begin) // self.bench.config.pixel_ns)
        )

    async def until(self, line: int) -> None:
        """Up to a line, of all since reset."""
        while self.place() < line * TIMING.all_columns + LATENCY:
            await self.bench.edge()

    async def draw(self, picture: np.ndarray, rows: int) -> None:
        """The first scanlines of a picture, a pixel a clock."""
        dut = self.dut
        dut.pixel_valid.value = 1
        for y in range(rows):
            for x in range(picture.shape[1]):
                dut.pixel_x.value, dut.pixel_y.value = x, y
                dut.pixel_value.value = int.from_bytes(picture[y, x].tobytes(), "little")
                await self.bench.edge()
                self.bench.check("pixel_ready", bool(dut.pixel_ready.value), True)
        dut.pixel_valid.value = 0

    async def read(self, width: int) -> bytes:
        """The first scanline's bytes."""
        dut = self.dut
        dut.read_valid.value, dut.read_data_ready.value = 1, 1
        dut.read_width.value, dut.read_count.value = width, 3 * width
        await self.bench.edge()
        while not dut.read_ready.value:
            await self.bench.edge()
        dut.read_valid.value = 0
        got = bytearray()
        while len(got) < 3 * width:
            await self.bench.edge()
            if dut.read_data_valid.value:
                got.append(int(dut.read_data.value))
        return bytes(got)

    def compare(self, picture: np.ndarray, first: int, last: int, frame: int = 0) -> None:
        """Lines of what was shown against the model."""
        begin = LATENCY + frame * TIMING.all_lines * TIMING.all_columns
        step = TIMING.all_columns
        right = [red << 20 | green << 10 | blue for blue, green, red in frame_words(picture, TIMING)]
        for line in range(first, last):
            shown = [self.words.get(begin + place) for place in range(line * step, (line + 1) * step)]
            self.bench.check("words of a line", shown, right[line * step : (line + 1) * step], line)


async def begin(dut: Any, test: str) -> tuple[Bench, Monitor, np.ndarray]:
    """A screen after its fill, its monitor, a picture of which LAST lines are not black."""
    bench = Bench(dut, Config, test)
    await bench.start(*INPUTS)
    monitor, config = Monitor(bench), bench.config
    cocotb.start_soon(monitor.watch())
    await bench.edge()
    while not dut.idle.value:
        await bench.edge()
    picture = np.zeros((config.height, config.width, 3), np.uint8)
    rows = LAST * config.height // TIMING.lines
    picture[:rows] = bench.rng.integers(0, 256, (rows, config.width, 3), np.uint8)
    return bench, monitor, picture


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def what_is_drawn_is_shown(dut: Any) -> None:
    bench, monitor, picture = await begin(dut, "what_is_drawn_is_shown")
    config = bench.config
    await monitor.draw(picture, LAST * config.height // TIMING.lines)
    bench.check("drawn in time", monitor.place() < FIRST * TIMING.all_columns, True)

    # A scanline of the picture is read; where its fetch falls into that, it is black.
    while monitor.place() < READ * TIMING.all_columns - 10:
        await bench.edge()
    bench.check("what is read", await monitor.read(config.width), config.kept(picture)[0].tobytes())

    await monitor.until(LAST)
    picture = config.kept(picture)
    if config.buffers == 1:
        picture[READ * config.height // TIMING.lines + 1] = 0
    else:
        # The other buffer is shown, as the reset has filled it.
        picture[:] = 0
    monitor.compare(picture, FIRST, LAST)
    bench.finish(at_least=LAST - FIRST)


@cocotb.test(timeout_time=60, timeout_unit="ms")
async def a_swap_shows_it(dut: Any) -> None:
    bench, monitor, picture = await begin(dut, "a_swap_shows_it")
    config = bench.config
    if config.buffers == 1:
        return
    rows = LAST * config.height // TIMING.lines
    await monitor.draw(picture, rows)
    while not dut.idle.value:
        await bench.edge()
    # Most of the frame goes by without being looked at, in millions of clocks.
    dut.swap_valid.value, monitor.watching = 1, False
    await RisingEdge(dut.swap_ready)
    line, column = divmod(monitor.place() + 1, TIMING.all_columns)
    bench.check("the swap comes with the vertical blank", (line, column), (TIMING.lines, 0))
    await bench.edge()
    dut.swap_valid.value = 0
    await bench.edge()
    bench.check("idle", bool(dut.idle.value), True)
    frame = TIMING.all_lines * TIMING.all_columns
    await Timer((frame - 2 - monitor.place()) * config.pixel_ns, "ns")
    monitor.watching = True
    cocotb.start_soon(monitor.watch())

    # Meanwhile the other buffer is cleared, drawn and read.
    await monitor.until(TIMING.all_lines + 4)
    dut.clear_valid.value, dut.clear_colour.value = 1, 0xFFFFFF
    await bench.edge()
    dut.clear_valid.value = 0
    await bench.edge()
    while not dut.idle.value:
        await bench.edge()
    other = 255 - picture
    await monitor.draw(other, rows)
    bench.check("what is read", await monitor.read(config.width), config.kept(other)[0].tobytes())
    await monitor.until(TIMING.all_lines + LAST)
    monitor.compare(config.kept(picture), 0, LAST, frame=1)
    bench.finish(at_least=LAST)
