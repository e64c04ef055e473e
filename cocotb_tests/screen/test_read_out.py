# SPDX-License-Identifier: Apache-2.0
"""Areas against the model and zlib: all shapes, every pace; areas that do not fit give nothing."""

from __future__ import annotations

import zlib
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import cocotb
import pytest

from cocotb_tests.support.bench import SPEEDS, Bench, StreamSink
from cocotb_tests.support.resets import reset_amid
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
    with_count: int = 1
    with_crc: int = 1


CONFIGS = [
    Config(),
    Config(width=8, height=8, coord_bits=3, num_channels=1, read_stages=2),
    Config(width=5, height=1, num_channels=4),
    Config(width=1, height=1, coord_bits=1, read_stages=5),
    Config(width=7, height=8, coord_bits=3, with_count=0, with_crc=0),
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
        # The memory is read before the first area too.
        address = self.bench.unqualified(dut.read_address)
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


def corner_areas(config: Config) -> list[Area]:
    """The screen, single pixels, columns, lines, part lines; what ends at an edge, and what passes one."""
    width, height = config.width, config.height
    # What the ports can say at most.
    last, widest = (1 << config.coord_bits) - 1, (2 << config.coord_bits) - 1
    most = (2 << max((width * height - 1).bit_length(), 1)) - 1
    some = [
        Area(0, 0, width, width * height),
        Area(0, 0, width, most),
        Area(0, 0, 1, 1),
        Area(width - 1, 0, 1, 1),
        Area(0, height - 1, 1, 1),
        Area(width - 1, height - 1, 1, 1),
        Area(width - 1, height - 1, 1, most),
        Area(width - 1, 0, 1, height),
        Area(width - 1, 0, 1, most),
        Area(0, height - 1, width, width),
        Area(0, height - 1, width, width + 5),
        Area(width // 2, height // 2, width - width // 2, most),
        Area(0, 0, 0, 4),
        Area(0, 0, 1, 0),
        Area(1, 0, width, 4),
        Area(0, min(height, last), 1, 1),
        Area(0, last, 1, 1),
        Area(last, 0, 1, 1),
        Area(last, last, widest, most),
        Area(0, 0, width + 1, 1),
        Area(0, 0, widest, 1),
    ]
    # Sums beyond the widest, which an adder of a bit too few would take for small ones.
    for total in range(widest + 1, min(widest + width, widest + last) + 1):
        some.append(Area(total - widest, 0, widest, 2))
        some.append(Area(last, 0, total - last, 2))
    return [area for area in some if area.width <= widest and area.count <= most]


def random_area(bench: Bench) -> Area:
    """An area within the screen."""
    width, height = bench.config.width, bench.config.height
    x, y = bench.draw.randrange(width), bench.draw.randrange(height)
    count = bench.draw.randint(1, max(width * height // 2, 1))
    return Area(x, y, bench.draw.randint(1, width - x), count)


async def read_all(reader: Reader, asked: list[Area], sink: str) -> None:
    """Areas, one after the other."""
    bench, dut, config = reader.bench, reader.bench.dut, reader.bench.config
    for index, area in enumerate(asked):
        # Without a count an area ends with the screen.
        meant = area if config.with_count or not area.count else replace(area, count=len(reader.words))
        values, crc = read_out(reader.words, config.width, config.height, meant, config.num_channels)
        reader.sink.words, reader.sink.taken_at = [], []
        accepted = await reader.read(area)
        await reader.cycle()
        bench.check("refused", bool(dut.refused.value), not values, index, area)
        for _ in range(10_000):
            whole = len(reader.sink.words) >= len(values)
            bench.check(
                "area_ready amid pixels", bool(dut.area_ready.value) and not whole, False, index, area
            )
            if whole and dut.area_ready.value:
                break
            await reader.cycle()
            bench.check("refused once", bool(dut.refused.value), False, index, area)
        expected = [(value, int(place == len(values) - 1)) for place, value in enumerate(values)]
        bench.check_all("pixel, last", reader.sink.words, expected)
        data = b"".join(value.to_bytes(config.num_channels, "little") for value in values)
        bench.check("crc", int(dut.crc.value), zlib.crc32(data) * config.with_crc, index, area)
        bench.check("model's crc", crc, zlib.crc32(data), index, area)
        times = reader.sink.taken_at
        if sink == "full_speed" and values:
            bench.check("latency", times[0] - accepted, config.read_stages + BEHIND, index, area)
            bench.check(
                "clocks between pixels", {b - a for a, b in pairwise(times)} <= {1}, True, index, area
            )


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(sink=list(SPEEDS))
async def every_area(dut: Any, sink: str) -> None:
    bench = Bench(dut, Config, f"every_area {sink}")
    await bench.start(*INPUTS)
    asked = corner_areas(bench.config) + [random_area(bench) for _ in range(15)]
    await read_all(Reader(bench, sink), asked, sink)
    bench.finish(at_least=100)


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(sink=list(SPEEDS))
async def resets(dut: Any, sink: str) -> None:
    """Amid an area, and in the cycle in which one is refused."""
    bench = Bench(dut, Config, f"resets {sink}")
    await bench.start(*INPUTS)

    async def work() -> None:
        refused = Area(0, 0, 0, 1)
        asked = [random_area(bench), refused, random_area(bench), refused]
        await read_all(Reader(bench, sink), asked, sink)

    events = ("area_valid", "refused", "pixel_valid")
    await reset_amid(bench, work, events, 24, quiet=("pixel_valid", "refused"))
    bench.finish(at_least=200)
