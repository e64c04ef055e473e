# SPDX-License-Identifier: Apache-2.0
"""The screen against its model: overlapping triangles in every order, then areas and CRCs of every plane."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice, permutations
from typing import Any

import cocotb
import numpy as np
import pytest

from cocotb_tests.support.bench import SPEEDS, Bench, StreamSource, full_speed
from cocotb_tests.support.link_stimuli import good_area
from cocotb_tests.support.resets import reset_amid
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.contract.protocol import EDGE_BYTES
from quadshade.golden.link.frame_receiver import Reach
from quadshade.golden.screen.screen import Screen

PIXEL = ("x", "y", "value", "depth")
AREA = ("x", "y", "width", "count", "plane")
INPUTS = (
    "read_reset",
    "clear_valid",
    "clear_colour",
    "swap_valid",
    "pixel_valid",
    *(f"pixel_{name}" for name in PIXEL),
    "read_valid",
    *(f"read_{name}" for name in AREA),
    "read_data_ready",
    "frame_crc_valid",
    "frame_crc_plane",
)
Pixel = tuple[int, int, int, int]


@dataclass(frozen=True)
class Config:
    """Generics of ``screen``."""

    width: int = 13
    height: int = 7
    coord_bits: int = 5
    num_channels: int = 3
    with_depth: int = 1
    depth_bits: int = 16
    with_edge_map: int = 1
    single_port_memory: int = 0
    crc_cycles: int = 1
    with_video: int = 0
    buffers: int = 1
    colour_bits: int = 8

    def model(self) -> Screen:
        """The golden model."""
        depth_bits = self.depth_bits if self.with_depth else None
        edges = bool(self.with_edge_map)
        return Screen(self.width, self.height, self.num_channels, depth_bits, edges, self.colour_bits)

    def reach(self) -> Reach:
        """What can be read."""
        edges = EDGE_BYTES * self.with_edge_map
        depth = -(-self.depth_bits // 8) * self.with_depth
        return Reach(self.width, self.height, (self.num_channels, depth, edges, edges))


CONFIGS = [
    Config(),
    Config(width=32, height=4, depth_bits=20),
    Config(num_channels=4, depth_bits=5, with_edge_map=0),
    Config(width=20, height=15, with_video=1),
    Config(buffers=2, colour_bits=4),
    Config(num_channels=4, with_depth=0, with_edge_map=0, buffers=2, colour_bits=6),
    Config(num_channels=1, with_depth=0, with_edge_map=0, single_port_memory=1, crc_cycles=4),
]


@pytest.mark.parametrize("config", CONFIGS, ids=identifier)
def test_screen(config: Config) -> None:
    simulate("screen", config)


def triangle(bench: Bench, corner: int, size: int, depth: int) -> list[Pixel]:
    """Pixels of a right triangle, scanline by scanline, all as near."""
    bits = 8 * bench.config.num_channels
    return [(corner + x, corner + y, bench.bits(bits), depth) for y in range(size) for x in range(size - y)]


def overlapping(bench: Bench) -> Iterator[list[Pixel]]:
    """Three triangles over each other in every order of depth, of sizes from one pixel on, back to back."""
    most = (1 << bench.config.depth_bits) - 1
    for size in (1, 2, 3, 4):
        for order in permutations((0, 1, 2)):
            base = bench.draw.randrange(max(most - 2, 1))
            parts = [triangle(bench, bench.draw.randrange(2), size, min(base + part, most)) for part in order]
            yield [pixel for part in parts for pixel in part]


class Driver:
    """The device under test beside its model."""

    def __init__(self, bench: Bench, speed: str) -> None:
        self.bench, self.dut, self.model = bench, bench.dut, bench.config.model()
        self.go = SPEEDS[speed](bench.draw)
        inputs = [getattr(self.dut, f"pixel_{name}") for name in PIXEL]
        self.source = StreamSource(self.dut.pixel_valid, self.dut.pixel_ready, inputs, (), self.go)

    async def begin(self) -> None:
        """Reset, and the fill that follows."""
        await self.bench.start(*INPUTS)
        await self.settle()

    async def settle(self) -> None:
        """Until the screen says that it is idle."""
        while not self.dut.idle.value or not self.source.empty:
            await self.cycle()

    async def cycle(self) -> None:
        """One clock, with the next pixel of those that wait."""
        self.source.drive()
        await self.bench.edge()
        self.source.sample(self.bench.cycle)

    def offer(self, pixels: list[Pixel]) -> None:
        """Pixels for the source; the model draws them at once."""
        self.source.words = iter(pixels)
        self.source.waiting = next(self.source.words, None)
        table = np.array(pixels, np.int64).reshape(-1, len(PIXEL))
        channels = self.bench.config.num_channels
        value = table[:, 2:3] >> (8 * np.arange(channels)) & 0xFF
        self.model.draw(table[:, 0], table[:, 1], value, table[:, 3])

    async def handshake(self, name: str) -> None:
        """Ask until it is taken."""
        valid, ready = getattr(self.dut, f"{name}_valid"), getattr(self.dut, f"{name}_ready")
        valid.value = 1
        await self.cycle()
        while not ready.value:
            await self.cycle()
        valid.value = 0

    async def clear(self, colour: int) -> None:
        """A clear, of both."""
        self.dut.clear_colour.value = colour
        await self.handshake("clear")
        self.model.clear(colour)
        await self.cycle()
        self.bench.check("idle in a clear", bool(self.dut.idle.value), False)

    async def swap(self) -> None:
        """The other buffer is drawn and read from now on, if there are two: without a monitor at once."""
        if self.bench.config.buffers == 2:
            await self.handshake("swap")
            self.model.swap()

    async def read(self, area: dict[str, int], most: int | None = None) -> bytes:
        """An area's bytes, or the first of them."""
        for name in AREA:
            getattr(self.dut, f"read_{name}").value = area[name]
        await self.handshake("read")
        found = bytearray()
        while len(found) < (area["count"] if most is None else most):
            takes = next(self.go)
            self.dut.read_data_ready.value = int(takes)
            await self.cycle()
            if takes and self.dut.read_data_valid.value:
                found.append(int(self.dut.read_data.value))
        self.dut.read_data_ready.value = 0
        return bytes(found)

    async def frame_crc(self, plane: int) -> int:
        """A plane's CRC."""
        self.dut.frame_crc_plane.value = plane
        await self.handshake("frame_crc")
        while not self.dut.frame_crc_done.value:
            await self.cycle()
        return int(self.dut.frame_crc_value.value)


async def drawn_and_read(driver: Driver, rounds: int) -> None:
    """Overlapping triangles, a plane's CRC and an area behind each; clears and swaps among them."""
    bench, reach = driver.bench, driver.bench.config.reach()
    planes = [number for number, size in enumerate(reach.plane_bytes) if size]
    await driver.begin()
    await driver.clear(bench.bits(32))
    for index, pixels in enumerate(islice(overlapping(bench), rounds)):
        beside = [
            (bench.bits(bench.config.coord_bits), bench.bits(bench.config.coord_bits)) for _ in range(40)
        ]
        bits = 8 * bench.config.num_channels
        more = [(*at, bench.bits(bits), bench.bits(bench.config.depth_bits)) for at in beside]
        await driver.settle()
        driver.offer([*pixels, *more[: 40 * (index % 3)]])
        await driver.settle()
        plane = planes[index % len(planes)]
        bench.check(
            "CRC of a plane", await driver.frame_crc(plane), driver.model.frame_crc(plane), index, plane
        )
        area = good_area(bench.draw, reach, 60)
        expected = driver.model.read(**{name: area[name] for name in AREA})
        # Pixels that come while something is read wait: the bytes are those from before them.
        await driver.settle()
        if index % 2:
            driver.offer(pixels[::-1])
        bench.check("bytes of an area", await driver.read(area), expected, index, area)
        if index % 6 == 5:
            await driver.settle()
            await driver.clear(bench.bits(32))
        if index % 4 == 3:
            await driver.settle()
            await driver.swap()
    await driver.settle()
    for plane in planes:
        bytes_there = driver.model.plane(plane).tobytes()
        bench.check("CRC of a plane", await driver.frame_crc(plane), zlib.crc32(bytes_there), plane)
    bench.check("rounds", index, rounds - 1)


@cocotb.test(timeout_time=3, timeout_unit="ms")
@cocotb.parametrize(speed=list(SPEEDS))
async def pictures(dut: Any, speed: str) -> None:
    bench = Bench(dut, Config, f"pictures {speed}")
    await drawn_and_read(Driver(bench, speed), 24)
    bench.finish(at_least=48)


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def reset_ends_a_read(dut: Any) -> None:
    """A read that is reset gives no byte more, and the picture stays."""
    bench = Bench(dut, Config, "reset_ends_a_read")
    driver = Driver(bench, "full_speed")
    reach = bench.config.reach()
    planes = [number for number, size in enumerate(reach.plane_bytes) if size]
    await driver.begin()
    await driver.clear(bench.bits(32))
    await driver.settle()
    driver.go = full_speed(bench.draw)
    driver.offer([pixel for pixels in overlapping(bench) for pixel in pixels])
    await driver.settle()
    for index in range(16):
        area = good_area(bench.draw, reach, 40)
        await driver.read(area, bench.draw.randrange(area["count"]))
        for _ in range(bench.draw.randrange(4)):
            await driver.cycle()
        dut.read_reset.value = 1
        await driver.cycle()
        dut.read_reset.value = 0
        await driver.cycle()
        bench.check("a byte after the reset", bool(dut.read_data_valid.value), False, index)
        bench.check("idle after the reset", bool(dut.idle.value), True, index)
        plane = planes[index % len(planes)]
        bench.check("CRC of a plane", await driver.frame_crc(plane), driver.model.frame_crc(plane), index)
    bench.finish(at_least=48)


@cocotb.test(timeout_time=2, timeout_unit="ms")
@cocotb.parametrize(speed=list(SPEEDS))
async def resets(dut: Any, speed: str) -> None:
    """A reset amid pixels, a clear, a read or a plane's CRC: the screen is cleared, nothing else is left."""
    bench = Bench(dut, Config, f"resets {speed}")
    await bench.start(*INPUTS)
    reach = bench.config.reach()
    planes = [number for number, size in enumerate(reach.plane_bytes) if size]
    batches = list(overlapping(bench))
    # What stands at the port: a reset clears to it.
    colour = 0

    async def work() -> None:
        nonlocal colour
        driver = Driver(bench, speed)
        driver.model.clear(colour)
        colour = 0
        await bench.edge()
        await driver.settle()
        for pixels in bench.draw.sample(batches, 1):
            driver.offer(pixels)
            await driver.settle()
            area = good_area(bench.draw, reach, 20)
            expected = driver.model.read(**{name: area[name] for name in AREA})
            bench.check("bytes of an area", await driver.read(area), expected, None, area)
            await driver.settle()
            plane = bench.draw.choice(planes)
            crc = await driver.frame_crc(plane)
            bench.check("CRC of a plane", crc, driver.model.frame_crc(plane), None, plane)
            await driver.settle()
            await driver.swap()
            colour = bench.bits(32)
            await driver.clear(colour)
            await driver.settle()
        colour = 0
        await driver.clear(colour)

    events = (
        ("pixel_valid", "pixel_ready"),
        ("read_valid", "read_ready"),
        "read_data_valid",
        ("frame_crc_valid", "frame_crc_ready"),
        "frame_crc_done",
        ("clear_valid", "clear_ready"),
        *([("swap_valid", "swap_ready")] if bench.config.buffers == 2 else []),
    )
    await reset_amid(bench, work, events, 10, quiet=("read_data_valid", "frame_crc_done", "idle"))
    bench.finish(at_least=40)
