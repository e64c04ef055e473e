# SPDX-License-Identifier: Apache-2.0
"""The picture memory against its model: pixels anywhere, reads at any time, clears amid pixels, swaps."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import repeat
from typing import Any

import cocotb
import numpy as np
import pytest

from cocotb_tests.support.bench import SPEEDS, Bench
from cocotb_tests.support.resets import at_random
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.golden.common.block_ram import BlockRam
from quadshade.golden.screen.framebuffer import HALF_STEP, kept_colours, thresholds

PIXEL = ("x", "y", "value")
INPUTS = (
    "clear",
    "clear_value",
    "pixel_valid",
    *(f"pixel_{n}" for n in PIXEL),
    "read_enable",
    "read_address",
    "swap",
    "show_address",
)


@dataclass(frozen=True)
class Config:
    """Generics of ``framebuffer``."""

    width: int = 20
    height: int = 12
    coord_bits: int = 6
    value_bits: int = 24
    single_port: int = 0
    buffers: int = 1
    colour_bits: int = 8

    def kept(self, value: int, threshold: int) -> int:
        """A value as it is read again."""
        if self.colour_bits == 8:
            return value
        data = value.to_bytes(self.value_bits // 8, "little")
        kept = kept_colours(np.array(list(data)), threshold, self.colour_bits)
        return int.from_bytes(bytes(kept.tolist()), "little")

    def drawn(self, x: int, y: int, value: int) -> int:
        """A pixel as it is read again."""
        return self.kept(value, int(thresholds(np.array(x), np.array(y))))


CONFIGS = [
    Config(),
    Config(buffers=2),
    Config(width=8, height=8, coord_bits=3, value_bits=1),
    Config(width=1, height=1, value_bits=8),
    Config(value_bits=8, single_port=1),
    Config(width=9, height=7, buffers=2, colour_bits=4),
    Config(buffers=2, colour_bits=5),
    Config(value_bits=32, colour_bits=6),
    Config(width=1, height=1, coord_bits=1, value_bits=8, buffers=2, colour_bits=4),
]


@pytest.mark.parametrize("config", CONFIGS, ids=identifier)
def test_framebuffer(config: Config) -> None:
    simulate("framebuffer", config)


async def compare(bench: Bench, pixels: str, reads: str, resets: Iterator[bool]) -> None:
    """Every port in every cycle."""
    dut, config = bench.dut, bench.config
    words = config.width * config.height
    await bench.start(*INPUTS)
    # Not a pixel that is accepted with a clear, nor one that is being written, may be lost or come late.
    offers, looks = SPEEDS[pixels](bench.draw), SPEEDS[reads](bench.draw)
    memories = [BlockRam(5 - 3 * config.single_port) for _ in range(config.buffers)]
    for memory in memories:
        memory.fill(0, words)
    # The buffer that is drawn and read; another one is shown.
    drawn = config.buffers - 1
    # Pixels are readable three cycles after they are accepted; one being written may read as anything.
    coming: deque[list[tuple[int, int, int]]] = deque([[], []])
    busy, was_busy, filling_both = words, True, config.buffers == 2
    for index in range(words + 1600):
        offered = None
        if next(offers):
            offered = [bench.bits(config.coord_bits), bench.bits(config.coord_bits)]
            if bench.chance(0.8):
                offered = [offered[0] % config.width, offered[1] % config.height]
            offered.append(bench.bits(config.value_bits))
        clear = bench.chance(0.002) or index == words + 50
        value = bench.bits(config.value_bits)
        address = bench.draw.randrange(words)
        if coming[0] and bench.chance(0.7):
            x, y, _ = coming[0][0]
            if x < config.width and y < config.height:
                address = y * config.width + x
        look, reset = next(looks), next(resets)
        shown_address = bench.draw.randrange(words)
        on_their_way = any(x < config.width and y < config.height for some in coming for x, y, _ in some)
        idle = busy == 0 and not on_their_way
        swap = config.buffers == 2 and idle and bench.chance(0.1)
        dut.swap.value, dut.show_address.value = int(swap), shown_address
        dut.reset.value = int(reset)
        dut.pixel_valid.value = int(offered is not None)
        for name, word in zip(PIXEL, offered or (0, 0, 0), strict=True):
            getattr(dut, f"pixel_{name}").value = word
        dut.clear.value, dut.clear_value.value = int(clear), value
        dut.read_enable.value, dut.read_address.value = int(look), address
        await bench.edge()
        bench.check("busy", bool(dut.busy.value), busy > 0, index)
        bench.check("pixel_ready", bool(dut.pixel_ready.value), busy == 0, index)
        bench.check("idle", bool(dut.idle.value), idle, index)
        memory = memories[drawn]
        if memory.read_data is not None:
            bench.check("read_value", int(dut.read_value.value), memory.read_data, index)
        write = None
        for x, y, pixel in coming.popleft():
            if x < config.width and y < config.height:
                write = (y * config.width + x, config.drawn(x, y, pixel))
        memory.clock(write, address if look else None)
        for shown in (memories[1 - drawn],) if config.buffers == 2 else ():
            if shown.read_data is not None:
                bench.check("show_value", int(dut.show_value.value), shown.read_data, index)
            shown.clock(None, shown_address)
        # The fill's last word is written in the cycle after it, at the latest.
        if look and (busy > 0 or was_busy):
            memory.fetched[0] = None
        if config.single_port and (busy > 0 or write is not None):
            memory.fetched[0] = None
        filling_both = filling_both and (busy > 0 or was_busy)
        if filling_both:
            memories[1 - drawn].fetched[0] = None
        was_busy = busy > 0
        if swap:
            drawn = 1 - drawn
            memory = memories[drawn]
        coming.append([tuple(offered)] if offered is not None and busy == 0 else [])
        if busy == 0 and clear:
            # Those on their way are written first, so the fill may cover them at once here.
            pixels_ahead = [pixel for some in coming for pixel in some]
            on_screen = [p for p in pixels_ahead if p[0] < config.width and p[1] < config.height]
            waits = max(
                (3 - 1 - age for age, some in enumerate(reversed(coming)) if set(some) & set(on_screen)),
                default=0,
            )
            busy = words + 1 + waits
            coming = deque([[], []])
            memory.fill(config.kept(value, HALF_STEP), words)
        elif busy > 0:
            busy -= 1
        if reset:
            # To the value that stands there, whatever was on its way or was filled.
            coming, busy = deque([[], []]), words
            drawn, filling_both = config.buffers - 1, config.buffers == 2
            for memory in memories:
                memory.fill(config.kept(value, HALF_STEP), words)


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(pixels=list(SPEEDS), reads=list(SPEEDS))
async def every_cycle(dut: Any, pixels: str, reads: str) -> None:
    bench = Bench(dut, Config, f"every_cycle {pixels} {reads}")
    await compare(bench, pixels, reads, repeat(False))
    bench.finish(at_least=3000)


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(pixels=list(SPEEDS))
async def resets(dut: Any, pixels: str) -> None:
    """A reset amid pixels, reads and clears begins a clear."""
    bench = Bench(dut, Config, f"resets {pixels}")
    words = bench.config.width * bench.config.height
    await compare(bench, pixels, "full_speed", at_random(bench.draw, words + 20))
    bench.finish(at_least=3000)
