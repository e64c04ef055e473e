# SPDX-License-Identifier: Apache-2.0
"""
Requests against the model: areas and CRCs of every plane, one after the other, also those that are cut.

Somebody gives pixels of any area as soon as one begins, more than are needed.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import cocotb
import pytest

from cocotb_tests.support.bench import SPEEDS, Bench, StreamSource
from cocotb_tests.support.resets import reset_amid
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.contract.protocol import EDGE_BYTES
from quadshade.golden.screen.plane_requests import Area, area_bytes, whole_plane

AREA = ("x", "y", "width", "count", "plane")
INPUTS = (
    *("read_reset", "free", "read_valid", *(f"read_{name}" for name in AREA), "read_data_ready"),
    *("frame_crc_valid", "frame_crc_plane", "pixel_valid", "pixel_data", "pixel_edges"),
)


@dataclass(frozen=True)
class Config:
    """Generics of ``plane_requests``."""

    width: int = 13
    height: int = 3
    coord_bits: int = 5
    num_channels: int = 3
    depth_bytes: int = 2
    crc_cycles: int = 1

    @property
    def pixel_bytes(self) -> tuple[int, ...]:
        """Of every plane."""
        return (self.num_channels, self.depth_bytes, EDGE_BYTES, EDGE_BYTES)


CONFIGS = [Config(), Config(width=5, height=1, num_channels=1, depth_bytes=0, crc_cycles=4)]


@pytest.mark.parametrize("config", CONFIGS, ids=identifier)
def test_plane_requests(config: Config) -> None:
    simulate("plane_requests", config)


class Reader:
    """The unit, and who gives pixels."""

    def __init__(self, bench: Bench, speed: str) -> None:
        self.bench, self.dut = bench, bench.dut
        self.go = SPEEDS[speed](bench.draw)
        self.offers: StreamSource | None = None
        self.pixels: list[tuple[int, int]] = []
        self.areas: list[Area] = []
        self.standing: Area | None = None

    def area_at_ports(self) -> Area:
        """Of which pixels are asked for."""
        place = (int(getattr(self.dut, f"area_{name}").value) for name in ("x", "y", "width"))
        return Area(*place, 0, int(self.dut.area_plane.value))

    async def cycle(self) -> None:
        """One clock; pixels come from the one behind an area's start until it is stopped."""
        bench, dut, config = self.bench, self.dut, self.bench.config
        if self.offers:
            self.offers.drive()
        await bench.edge()
        if self.offers:
            self.offers.sample(bench.cycle)
        if self.standing is not None:
            bench.check("area that stands", self.area_at_ports(), self.standing)
        if dut.area_start.value:
            self.standing = self.area_at_ports()
            self.areas.append(self.standing)
            bits = 8 * (config.num_channels + config.depth_bytes)
            self.pixels = [(bench.bits(bits), bench.bits(8 * EDGE_BYTES)) for _ in range(80)]
            inputs = [dut.pixel_data, dut.pixel_edges]
            self.offers = StreamSource(dut.pixel_valid, dut.pixel_ready, inputs, self.pixels, self.go)
        if dut.area_stop.value:
            self.offers, self.standing = None, None
            dut.pixel_valid.value = 0

    async def ask(self, name: str) -> None:
        """A request is taken once it may begin, and nobody draws from that clock on."""
        bench, dut = self.bench, self.dut
        valid, ready = getattr(dut, f"{name}_valid"), getattr(dut, f"{name}_ready")
        valid.value = 1
        for _ in range(bench.draw.randrange(3)):
            dut.free.value = 0
            await self.cycle()
            bench.check("not while pixels are drawn", bool(ready.value), False)
        dut.free.value = 1
        await self.cycle()
        while not ready.value:
            await self.cycle()
        valid.value = 0
        bench.check("held", bool(dut.held.value), True)
        bench.check("quiet", bool(dut.quiet.value), True)

    def expected(self, area: Area) -> tuple[bytes, int]:
        """The answer, from the pixels that were given; and the area that was asked for."""
        config = self.bench.config
        self.bench.check("area", self.areas.pop(0), replace(area, count=0))
        self.bench.check("areas", self.areas, [])
        return area_bytes(area, self.pixels, config.num_channels, config.depth_bytes)

    async def read(self, area: Area, most: int | None = None) -> None:
        """An area, or the first of its bytes."""
        bench, dut = self.bench, self.dut
        for name in AREA:
            getattr(dut, f"read_{name}").value = getattr(area, name)
        await self.ask("read")
        dut.read_plane.value, dut.read_count.value = bench.draw.randrange(4), 1
        got = bytearray()
        while len(got) < (area.count if most is None else most):
            takes = next(self.go)
            dut.read_data_ready.value = int(takes)
            await self.cycle()
            bench.check("held amid", bool(dut.held.value), True)
            bench.check("resting amid", bool(dut.resting.value), False)
            if takes and dut.read_data_valid.value:
                got.append(int(dut.read_data.value))
        dut.read_data_ready.value = 0
        if most is None:
            bench.check("bytes", bytes(got), self.expected(area)[0], None, area)
            await self.cycle()
            bench.check("a byte more", bool(dut.read_data_valid.value), False)
            bench.check("area stopped behind its last byte", self.offers is None, True)

    async def frame_crc(self, plane: int) -> None:
        """A plane's CRC."""
        bench, dut, config = self.bench, self.dut, self.bench.config
        dut.frame_crc_plane.value = plane
        # Another request, which comes after it or before.
        await self.ask("frame_crc")
        while not dut.frame_crc_done.value:
            await self.cycle()
            bench.check("no byte of a CRC", bool(dut.read_data_valid.value), False)
        bench.check("area stopped before its CRC", self.offers is None, True)
        area = whole_plane(config.width, config.height, plane, config.pixel_bytes[plane])
        bench.check("CRC", int(dut.frame_crc_value.value), self.expected(area)[1], None, area)

    def any_area(self) -> Area:
        """Within the screen, or with any numbers that the ports hold: what is on the screen others know."""
        draw, config = self.bench.draw, self.bench.config
        plane = draw.choice([number for number, size in enumerate(config.pixel_bytes) if size])
        if self.bench.chance(0.3):
            place = (self.bench.bits(config.coord_bits + more) for more in (0, 0, 1))
            return Area(*place, draw.randint(1, min(60, 4 * config.width * config.height)), plane)
        x = draw.randrange(config.width)
        width = draw.randint(1, config.width - x)
        y = draw.randrange(config.height)
        most = min(60, width * (config.height - y) * config.pixel_bytes[plane])
        return Area(x, y, width, draw.choice((1, most, draw.randint(1, most))), plane)

    async def some(self, count: int) -> None:
        """Requests of both kinds, as many of either; then none."""
        bench, begin = self.bench, self.bench.draw.randrange(2)
        kinds = [(begin + index) % 2 for index in range(count)]
        bench.draw.shuffle(kinds)
        for kind in kinds:
            if kind:
                await self.read(self.any_area())
            else:
                await self.frame_crc(self.any_area().plane)
        while not self.dut.resting.value:
            await self.cycle()
        bench.check("not held while nothing is asked", bool(self.dut.held.value), False)


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(speed=list(SPEEDS))
async def requests(dut: Any, speed: str) -> None:
    bench = Bench(dut, Config, f"requests {speed}")
    await bench.start(*INPUTS)
    await Reader(bench, speed).some(30)
    bench.finish(at_least=90)


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def both_at_once(dut: Any) -> None:
    """The read goes first."""
    bench = Bench(dut, Config, "both_at_once")
    await bench.start(*INPUTS)
    reader = Reader(bench, "full_speed")
    dut.free.value, dut.read_valid.value, dut.frame_crc_valid.value = 1, 1, 1
    await reader.cycle()
    while not dut.read_ready.value:
        await reader.cycle()
    bench.check("frame_crc_ready", bool(dut.frame_crc_ready.value), False)
    bench.finish()


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(kind=["reset", "read_reset"])
async def resets(dut: Any, kind: str) -> None:
    """Either ends what is read, and the next request is a new one."""
    bench = Bench(dut, Config, f"resets {kind}")
    await bench.start(*INPUTS)

    async def work() -> None:
        await Reader(bench, "throttled").some(3)

    events = ("area_start", "read_data_valid", ("pixel_valid", "pixel_ready"), "frame_crc_done")
    if kind == "reset":
        await reset_amid(bench, work, events, 12, quiet=("read_data_valid", "frame_crc_done", "area_start"))
    else:
        for _ in range(12):
            reader = Reader(bench, "throttled")
            area = reader.any_area()
            await reader.read(area, bench.draw.randrange(area.count))
            dut.read_reset.value = 1
            await reader.cycle()
            dut.read_reset.value = 0
            await reader.cycle()
            bench.check("a byte after the reset", bool(dut.read_data_valid.value), False)
            bench.check("quiet", bool(dut.quiet.value), True)
            bench.rest()
            await bench.edge()
            bench.check("resting", bool(dut.resting.value), True)
            await Reader(bench, "throttled").some(1)
    bench.finish(at_least=40)
