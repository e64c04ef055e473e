# SPDX-License-Identifier: Apache-2.0
"""The monitor's words against the model: whole frames, scanlines that could not be fetched, pulses."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import cocotb
import numpy as np
import pytest

from cocotb_tests.support.bench import Bench
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.golden.common.block_ram import BlockRam
from quadshade.golden.screen.scan_out import Timing, frame_words

SMALL = Timing(24, 2, 3, 4, 18, 1, 2, 3)
LATENCY = 7
"""Pixels from a place of the frame to its words."""
ENCODER_LATENCY = 4
"""How many of them are the encoder's."""


@dataclass(frozen=True)
class Config:
    """Generics of ``scan_out``."""

    width: int = 8
    height: int = 6
    num_channels: int = 3
    read_stages: int = 5
    clocks_per_pixel: int = 4
    columns: int = SMALL.columns
    column_front: int = SMALL.column_front
    column_sync: int = SMALL.column_sync
    column_back: int = SMALL.column_back
    lines: int = SMALL.lines
    line_front: int = SMALL.line_front
    line_sync: int = SMALL.line_sync
    line_back: int = SMALL.line_back

    @property
    def timing(self) -> Timing:
        """Columns and lines of a frame."""
        return Timing(**{name: value for name, value in asdict(self).items() if name in asdict(SMALL)})


CONFIGS = [
    Config(),
    Config(num_channels=1, read_stages=3, clocks_per_pixel=5),
    Config(width=24, height=18, clocks_per_pixel=1),
    Config(width=4, height=3, clocks_per_pixel=2),
    Config(read_stages=0),
    Config(width=24, height=18, read_stages=0, clocks_per_pixel=3),
]


@pytest.mark.parametrize("config", CONFIGS, ids=identifier)
def test_scan_out(config: Config) -> None:
    simulate("scan_out", config)


class Monitor:
    """A device under test, the memory that it reads, and the words that came."""

    def __init__(self, bench: Bench) -> None:
        self.bench, self.timing = bench, bench.config.timing
        self.memory = BlockRam(max(bench.config.read_stages, 2))
        # Of values that come one by one: those of the scanline that is wanted, and which it is.
        self.coming: list[int] = []
        self.row = 0
        self.words: list[tuple[int, ...]] = []
        # Pixels since the frame's begin; whether it is blank, as the port says a cycle later.
        self.place, self.blank = 0, False

    def paint(self) -> np.ndarray:
        """Another picture in the memory, of any bytes."""
        config = self.bench.config
        shape = (config.height, config.width, config.num_channels)
        picture = self.bench.rng.integers(0, 256, shape, np.uint8)
        for address, pixel in enumerate(picture.reshape(-1, config.num_channels)):
            self.memory.words[address] = int.from_bytes(pixel.tobytes(), "little")
        return picture

    async def cycle(self, may_read: bool = True) -> None:
        """One clock; others have the memory if not `may_read`."""
        dut, bench, late = self.bench.dut, self.bench, False
        if bench.config.read_stages == 0:
            # What is late of the last scanline still comes, and is not shown.
            late = self.row == bench.config.height - 1 and bool(self.coming)
            may_read = may_read and bool(self.coming) and bench.chance(0.9)
            dut.read_value.value = self.coming.pop(0) if may_read else bench.bits(8)
        else:
            dut.read_value.value = self.memory.read_data or 0
        dut.may_read.value = int(may_read)
        await bench.edge()
        self.follow()
        bench.check("blank", bool(dut.blank.value), self.blank, self.place)
        if self.blank:
            read = bool(dut.reads.value) and not late
            bench.check("nothing is read while it is blank", read, False, self.place)
        line = self.place // self.timing.all_columns % self.timing.all_lines
        self.blank = self.timing.lines <= line < self.timing.all_lines - 1 and not dut.reset.value
        self.place = 0 if dut.reset.value else self.place + int(dut.word_next.value)
        if dut.word_next.value:
            word = int(dut.words.value)
            self.words.append(tuple(word >> 10 * channel & 0x3FF for channel in range(3)))
        address = bench.draw.randrange(len(self.memory.words))
        if dut.reads.value and bench.config.read_stages:
            bench.check("reads only where it may", may_read, True)
            address = int(dut.read_address.value)
            bench.check("address is of the picture", address < len(self.memory.words), True, address)
        self.memory.clock(None, address)

    def follow(self) -> None:
        """Which scanline is wanted now, if its values come one by one."""
        dut, width = self.bench.dut, self.bench.config.width
        if dut.line_start.value:
            self.row = 0 if dut.line_first.value else self.row + 1
            addresses = range(self.row * width, (self.row + 1) * width)
            self.coming = [self.memory.words[address] for address in addresses]
        if dut.reset.value:
            self.row, self.coming = 0, []

    async def until(self, frames: int, line: int, chance: float = 0.0) -> None:
        """Up to the first word of a line of a frame; now and then others read for a while."""
        pixels = (frames * self.timing.all_lines + line) * self.timing.all_columns
        waits = 0
        while len(self.words) < LATENCY + pixels:
            if chance and not waits and self.bench.chance(chance):
                waits = self.bench.draw.randrange(1, 400)
            waits = max(waits - 1, 0)
            await self.cycle(may_read=waits == 0)

    def lines(self, frame: int) -> list[list[tuple[int, ...]]]:
        """Words of a frame, line by line."""
        return split(
            self.words[LATENCY + frame * self.timing.all_columns * self.timing.all_lines :], self.timing
        )


def split(words: list[tuple[int, ...]], timing: Timing) -> list[list[tuple[int, ...]]]:
    """Words of one frame, line by line."""
    step = timing.all_columns
    return [words[begin : begin + step] for begin in range(0, timing.all_lines * step, step)]


@cocotb.test(timeout_time=4, timeout_unit="ms")
async def whole_frames(dut: Any) -> None:
    bench = Bench(dut, Config, "whole_frames")
    await bench.start("may_read", "read_value")
    monitor, config = Monitor(bench), bench.config
    blank_line = config.timing.lines + 1
    picture = monitor.paint()
    for frame in range(3):
        await monitor.until(frame, blank_line)
        following = monitor.paint()
        await monitor.until(frame + 1, 0)
        if frame == 0:
            # The first scanline is fetched in the last line of the frame before.
            picture = np.concatenate([np.zeros_like(picture[:1]), picture[1:]])
        expected = split(list(frame_words(picture, config.timing)), config.timing)
        for line, (words, right) in enumerate(zip(monitor.lines(frame), expected, strict=True)):
            bench.check("words of a line", words, right, (frame, line))
        picture = following
    bench.finish(at_least=60)


@cocotb.test(timeout_time=12, timeout_unit="ms")
async def others_read(dut: Any) -> None:
    """A scanline that could not be fetched whole is black; the next frame is right again."""
    bench = Bench(dut, Config, "others_read")
    await bench.start("may_read", "read_value")
    monitor, timing = Monitor(bench), bench.config.timing
    picture = monitor.paint()
    # Of values that come one by one a scanline may be whole too late; of either row of the memory.
    frames = 4 if bench.config.read_stages else 8
    await monitor.until(frames, 0, chance=0.002)
    await monitor.until(frames + 2, 0)
    right = split(list(frame_words(picture, timing)), timing)
    black = split(list(frame_words(np.zeros_like(picture), timing)), timing)
    scale, blacks = timing.columns // bench.config.width, 0
    for frame in range(frames):
        lines = monitor.lines(frame)
        for row in range(bench.config.height):
            rows = slice(row * scale, (row + 1) * scale)
            is_black = lines[rows] == black[rows]
            blacks += is_black
            bench.check(
                "a scanline is whole or black", is_black or lines[rows] == right[rows], True, (frame, row)
            )
        bench.check("what is not shown", lines[timing.lines :], right[timing.lines :], frame)
    bench.check("some scanlines were black", 0 < blacks < frames * bench.config.height, True)
    bench.check("a frame without others", monitor.lines(frames + 1), right)
    bench.finish(at_least=20)


@cocotb.test(timeout_time=4, timeout_unit="ms")
async def resets(dut: Any) -> None:
    """A reset in any clock begins a frame, without its first scanline; the one behind it is whole."""
    bench = Bench(dut, Config, "resets")
    await bench.start("may_read", "read_value")
    monitor, config, timing = Monitor(bench), bench.config, bench.config.timing
    step = timing.all_columns
    scale = timing.columns // config.width
    for index in range(10):
        picture = monitor.paint()
        monitor.words = []
        # Often where a line begins, in the clock in which a scanline's fetch may start.
        line = bench.draw.choice((0, scale, 2 * scale, 2 * scale, timing.all_lines - 1))
        pixels = line * step + bench.draw.choice((0, 0, 0, 1, bench.draw.randrange(step)))
        while len(monitor.words) < pixels:
            await monitor.cycle()
        late = config.clocks_per_pixel - 1
        for _ in range(bench.draw.choice((late, late, bench.draw.randint(0, late)))):
            await monitor.cycle()
        for _ in range(bench.draw.choice((1, 1, 1, 5))):
            dut.reset.value = 1
            await monitor.cycle()
        dut.reset.value = 0
        monitor.words = []
        rows = bench.draw.choice((1, 2, 3)) * scale
        await monitor.until(0, min(rows, timing.all_lines))
        shown = np.concatenate([np.zeros_like(picture[:1]), picture[1:]])
        right = split(list(frame_words(shown, timing)), timing)
        for words in monitor.words[ENCODER_LATENCY:LATENCY]:
            bench.check("a word of before is a pixel", words[1:], right[-1][0][1:], index)
        got = monitor.words[LATENCY:]
        for begin in range(0, len(got), step):
            bench.check("words of a line", got[begin : begin + step], right[begin // step], (index, begin))
    await monitor.until(1, timing.lines)
    right = split(list(frame_words(picture, timing)), timing)
    bench.check("the frame behind", monitor.lines(1)[: timing.lines], right[: timing.lines])
    bench.finish(at_least=60)
