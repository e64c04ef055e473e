# SPDX-License-Identifier: Apache-2.0
"""Areas against the model and zlib: all shapes, every pace; areas that do not fit give nothing."""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import cocotb
import pytest

from cocotb_tests.support.bench import SPEEDS, Bench, StreamSink, full_speed
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.golden.common.block_ram import BlockRam
from quadshade.golden.screen.read_out import Area, read_out

INPUTS = ("area_valid", "area_x", "area_y", "area_width", "area_count", "read_value", "pixel_ready")
BEHIND = 3
"""Clocks, beside those of the memory, from an area's acceptance to its first pixel at the output."""


@dataclass(frozen=True)
class Config:
    """Generics of ``read_out``."""

    width: int = 20
    height: int = 12
    coord_bits: int = 6
    num_channels: int = 3
    read_stages: int = 3


CONFIGS = [
    Config(),
    Config(width=8, height=8, coord_bits=3, num_channels=1, read_stages=2),
    Config(width=5, height=1, num_channels=4),
]


@pytest.mark.parametrize("config", CONFIGS, ids=identifier)
def test_read_out(config: Config) -> None:
    simulate("read_out", config)


class Reader:
    """A device under test, a memory behind it, and what takes its pixels."""

    def __init__(self, bench: Bench, sink: str) -> None:
        dut, self.bench = bench.dut, bench
        config = bench.config
        words = config.width * config.height
        self.words = [bench.draw.getrandbits(8 * config.num_channels) for _ in range(words)]
        self.memory = BlockRam(config.read_stages)
        self.memory.words = dict(enumerate(self.words))
        outputs = [dut.pixel_value, dut.pixel_last]
        self.sink = StreamSink(bench, dut.pixel_valid, dut.pixel_ready, outputs, SPEEDS[sink](bench.draw))

    async def cycle(self) -> None:
        """Up to the next edge, the memory with it."""
        dut = self.bench.dut
        self.sink.drive()
        dut.read_value.value = self.memory.read_data or 0
        await self.bench.edge()
        self.sink.sample(self.bench.cycle)
        address = int(dut.read_address.value)
        self.bench.check("address on the screen", address < len(self.words), True)
        self.memory.clock(None, address if dut.read_enable.value else None)

    async def read(self, area: Area) -> int:
        """Ask for an area; returns the cycle in which it was taken."""
        dut = self.bench.dut
        for name in ("x", "y", "width", "count"):
            getattr(dut, f"area_{name}").value = getattr(area, name)
        dut.area_valid.value = 1
        await self.cycle()
        while not dut.area_ready.value:
            await self.cycle()
        dut.area_valid.value = 0
        return self.bench.cycle


def areas(bench: Bench) -> list[Area]:
    """The screen, single pixels, columns, lines, part lines, areas below the screen, and random ones."""
    width, height = bench.config.width, bench.config.height
    some = [
        Area(0, 0, width, width * height),
        Area(width - 1, height - 1, 1, 1),
        Area(width - 1, 0, 1, height),
        Area(0, height - 1, width, width),
        Area(1, 0, 2, 3),
        Area(0, height - 1, width, width + 5),
        Area(0, 0, 0, 4),
        Area(0, 0, 1, 0),
        Area(1, 0, width, 4),
        Area(0, min(height, (1 << bench.config.coord_bits) - 1), 1, 1),
    ]
    for _ in range(15):
        x, y = bench.draw.randrange(width), bench.draw.randrange(height)
        some.append(Area(x, y, bench.draw.randint(1, width - x), bench.draw.randint(1, width * height // 2)))
    return some


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(sink=list(SPEEDS))
async def every_area(dut: Any, sink: str) -> None:
    bench = Bench(dut, Config, f"every_area {sink}")
    await bench.start(*INPUTS)
    config = bench.config
    reader = Reader(bench, sink)
    for index, area in enumerate(areas(bench)):
        values, crc = read_out(reader.words, config.width, config.height, area, config.num_channels)
        reader.sink.words, reader.sink.taken_at = [], []
        accepted = await reader.read(area)
        await reader.cycle()
        bench.check("refused", bool(dut.refused.value), not values, index, area)
        for _ in range(10_000):
            if len(reader.sink.words) >= len(values) and dut.area_ready.value:
                break
            await reader.cycle()
        expected = [(value, int(place == len(values) - 1)) for place, value in enumerate(values)]
        bench.check_all("pixel, last", reader.sink.words, expected)
        data = b"".join(value.to_bytes(config.num_channels, "little") for value in values)
        bench.check("crc", int(dut.crc.value), zlib.crc32(data), index, area)
        bench.check("model's crc", crc, zlib.crc32(data), index, area)
        times = reader.sink.taken_at
        if sink == "full_speed" and values:
            bench.check("latency", times[0] - accepted, bench.config.read_stages + BEHIND, index, area)
            bench.check(
                "clocks between pixels", {b - a for a, b in pairwise(times)} <= {1}, True, index, area
            )
    bench.finish(at_least=100)


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def reset_ends_an_area(dut: Any) -> None:
    bench = Bench(dut, Config, "reset_ends_an_area")
    await bench.start(*INPUTS)
    config = bench.config
    reader = Reader(bench, "throttled")
    whole = Area(0, 0, config.width, config.width * config.height)
    for waits in range(8):
        await reader.read(whole)
        for _ in range(waits):
            await reader.cycle()
        await bench.reset()
        reader.sink.held = None
        await bench.edge()
        bench.check("pixel_valid after reset", bool(dut.pixel_valid.value), False, waits)
        bench.check("area_ready after reset", bool(dut.area_ready.value), True, waits)
    reader.sink.words, reader.sink.go = [], full_speed(bench.draw)
    await reader.read(Area(0, 0, 2, 2))
    for _ in range(config.read_stages + BEHIND + 5):
        await reader.cycle()
    bench.check("pixels after reset", [word for word, _ in reader.sink.words], reader.words[:2])
    bench.finish(at_least=17)
