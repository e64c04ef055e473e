# SPDX-License-Identifier: Apache-2.0
"""What is drawn, on the monitor: the screen's words of 640 x 480 against the model, while it is read too."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cocotb
import numpy as np
import pytest
from cocotb.triggers import FallingEdge

from cocotb_tests.support.bench import Bench
from cocotb_tests.support.simulation import identifier, simulate
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


@pytest.mark.parametrize("config", [Config()], ids=identifier)
def test_screen_video(config: Config) -> None:
    simulate("screen", config, tests="screen_video")


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def what_is_drawn_is_shown(dut: Any) -> None:
    bench = Bench(dut, Config, "what_is_drawn_is_shown")
    config, words = bench.config, []
    inputs = [
        "read_reset",
        "clear_valid",
        "clear_colour",
        "pixel_valid",
        *(f"pixel_{name}" for name in PIXEL),
    ]
    inputs += ["read_valid", *(f"read_{name}" for name in AREA), "read_data_ready"]
    await bench.start(*inputs, "frame_crc_valid", "frame_crc_plane")

    async def watch() -> None:
        # In the middle of a cycle everything has settled.
        while True:
            await FallingEdge(dut.clk)
            if dut.video_next.value:
                # The first scanlines are shown before anything was written.
                value = dut.video_words.value
                words.append(int(value) if value.is_resolvable else None)

    cocotb.start_soon(watch())
    while not dut.idle.value:
        await bench.edge()
    rows = LAST * config.height // TIMING.lines
    picture = np.zeros((config.height, config.width, 3), np.uint8)
    picture[:rows] = bench.rng.integers(0, 256, (rows, config.width, 3), np.uint8)
    dut.pixel_valid.value = 1
    for y in range(rows):
        for x in range(config.width):
            dut.pixel_x.value, dut.pixel_y.value = x, y
            dut.pixel_value.value = int.from_bytes(picture[y, x].tobytes(), "little")
            await bench.edge()
            bench.check("pixel_ready", bool(dut.pixel_ready.value), True)
    dut.pixel_valid.value = 0
    bench.check("drawn in time", len(words) < FIRST * TIMING.all_columns, True)

    # A scanline of the picture is read; where its fetch falls into that, it is black.
    while len(words) < READ * TIMING.all_columns - 10:
        await bench.edge()
    dut.read_valid.value, dut.read_data_ready.value = 1, 1
    dut.read_width.value, dut.read_count.value = config.width, 3 * config.width
    await bench.edge()
    dut.read_valid.value = 0
    got = bytearray()
    while len(got) < 3 * config.width:
        await bench.edge()
        if dut.read_data_valid.value:
            got.append(int(dut.read_data.value))
    bench.check("what is read", bytes(got), picture[0].tobytes())

    while len(words) < LATENCY + LAST * TIMING.all_columns:
        await bench.edge()
    scale = TIMING.lines // config.height
    picture[READ // scale + 1] = 0
    step = TIMING.all_columns
    right = [red << 20 | green << 10 | blue for blue, green, red in frame_words(picture, TIMING)]
    for line in range(FIRST, LAST):
        shown = words[LATENCY + line * step : LATENCY + (line + 1) * step]
        bench.check("words of a line", shown, right[line * step : (line + 1) * step], line)
    bench.finish(at_least=LAST - FIRST)
