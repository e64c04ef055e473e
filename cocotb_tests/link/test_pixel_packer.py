# SPDX-License-Identifier: Apache-2.0
"""Answers against the model, packed and whole, byte by byte, at any pace."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from itertools import product
from typing import Any

import cocotb
import pytest

from cocotb_tests.support.bench import SPEEDS, Bench, StreamSink
from cocotb_tests.support.resets import reset_amid
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.contract.protocol import EDGE_BYTES, MAX_READ, PLANES
from quadshade.golden.link.pixel_packer import pack_pixels, predicted

INPUTS = (
    *("read_valid", "read_packed", "read_count", "read_plane", "data_ready"),
    *("area_ready", "byte_valid", "byte_data"),
)
MOST_CYCLES = 18
"""Of a byte, in the unit's header."""


@dataclass(frozen=True)
class Config:
    """Generics of ``pixel_packer``."""

    value_bytes: int = 3
    depth_bytes: int = 2


CONFIGS = [
    Config(),
    Config(value_bytes=1, depth_bytes=0),
    Config(value_bytes=4, depth_bytes=1),
    Config(value_bytes=1, depth_bytes=4),
]


@pytest.mark.parametrize("config", CONFIGS, ids=identifier)
def test_pixel_packer(config: Config) -> None:
    simulate("pixel_packer", config)


class Link:
    """The unit between a screen, which has the bytes of every area, and what takes an answer."""

    def __init__(self, bench: Bench, source: str, sink: str) -> None:
        dut, self.bench, self.dut = bench.dut, bench, bench.dut
        sizes = (bench.config.value_bytes, bench.config.depth_bytes, EDGE_BYTES, EDGE_BYTES)
        self.sizes = {plane: size for plane, size in enumerate(sizes[: len(PLANES)]) if size}
        self.source_go, self.area_go = SPEEDS[source](bench.draw), SPEEDS[source](bench.draw)
        self.takes = StreamSink(bench, dut.data_valid, dut.data_ready, [dut.data], SPEEDS[sink](bench.draw))

    async def read(self, data: bytes, plane: int, packed: bool = True) -> int:
        """Ask for an area of which the screen has these bytes; in how many cycles its answer was known."""
        bench, dut, draw = self.bench, self.dut, self.bench.draw
        expected = pack_pixels(data, self.sizes[plane]) if packed else data
        # The screen's bytes that are still to come; how often it was asked.
        screen: deque[int] = deque()
        asked, known, offering, told = 0, 0, False, False
        begin, first = bench.cycle, len(self.takes.words)
        dut.read_valid.value, dut.read_packed.value = 1, int(packed)
        dut.read_plane.value, dut.read_count.value = plane, len(data)
        most = begin + 100 * (len(data) + 10)
        while len(self.takes.words) - first < len(expected) and bench.cycle < most:
            dut.area_ready.value = area = int(not screen and next(self.area_go))
            offering = bool(screen) and (offering or next(self.source_go))
            dut.byte_valid.value = int(offering)
            dut.byte_data.value = screen[0] if offering else draw.getrandbits(8)
            self.takes.drive()
            await bench.edge()
            if known and not told:
                # What is asked for stands until the answer is begun.
                bench.check("answer_bytes", int(dut.answer_bytes.value), len(expected), inputs=(plane, data))
                told = True
                dut.read_plane.value, dut.read_count.value = draw.randrange(4), draw.getrandbits(16)
                dut.read_packed.value = draw.getrandbits(1)
            if not known:
                bench.check("data_valid before the answer", bool(dut.data_valid.value), False)
            if offering and dut.byte_ready.value:
                screen.popleft()
                offering = False
            if dut.area_valid.value and area:
                asked += 1
                screen.extend(data)
            if not known and dut.read_ready.value:
                known = bench.cycle
                dut.read_valid.value = 0
            self.takes.sample(bench.cycle)
        dut.area_ready.value = dut.byte_valid.value = 0
        got = bytes(word[0] for word in self.takes.words[first:])
        bench.check("answer", got.hex(), expected.hex(), inputs=(plane, data.hex()))
        bench.check("times that the screen was asked", asked, 1 + packed, inputs=(plane, data.hex()))
        bench.check("bytes of the screen left over", len(screen), 0)
        await bench.edge()
        bench.check("data_valid at rest", bool(dut.data_valid.value), False)
        return known - begin

    def bytes_of(self, plane: int, count: int) -> bytes:
        """Bytes as a picture has them, or noise, or with edges in it."""
        draw, size = self.bench.draw, self.sizes[plane]
        data = bytearray()
        wild = draw.choice((0.0, 0.0, 0.02, 0.2, 1.0))
        near = draw.choice(((0,), (0, 0, 0, 1, -1), (0, 0, 1, -1, 2, -2, 3, -3)))
        for index in range(count):
            byte = predicted(bytes(data) + b"\0", index, size) + draw.choice(near)
            data.append(draw.getrandbits(8) if self.bench.chance(wild) else byte % 256)
        return bytes(data)

    async def read_any(self, most: int = 90) -> None:
        """Any plane, packed or not."""
        plane = self.bench.draw.choice(list(self.sizes))
        count = self.bench.draw.choice((1, self.sizes[plane], self.bench.draw.randint(1, most)))
        await self.read(self.bytes_of(plane, count), plane, self.bench.chance(0.8))


async def start(dut: Any, test: str) -> Bench:
    """The bench after reset."""
    bench = Bench(dut, Config, test)
    await bench.start(*INPUTS)
    return bench


@cocotb.test(timeout_time=4, timeout_unit="ms")
@cocotb.parametrize(source=list(SPEEDS), sink=list(SPEEDS))
async def areas(dut: Any, source: str, sink: str) -> None:
    bench = await start(dut, f"areas {source} {sink}")
    link = Link(bench, source, sink)
    for _ in range(30):
        await link.read_any()
    bench.finish(at_least=100)


@cocotb.test(timeout_time=6, timeout_unit="ms")
async def every_short_row(dut: Any) -> None:
    """All rows of a few bytes, of every word of the code; predicted bytes behind them."""
    bench = await start(dut, "every_short_row")
    link = Link(bench, "full_speed", "full_speed")
    plane = 0 if bench.config.value_bytes == 1 or not bench.config.depth_bytes else 1
    size = link.sizes[plane]
    steps = (0, 1, 255, 2, 254, 3) if bench.config.value_bytes == 1 else (0, 1, 3)
    for row in product(steps, repeat=3 if len(steps) > 3 else 4):
        data = bytearray()
        for index in range(size + len(row) + 9):
            place = index - size
            step = row[place] if 0 <= place < len(row) else 0
            data.append((predicted(bytes(data) + b"\0", index, size) + step) % 256)
        await link.read(bytes(data), plane)
    bench.finish(at_least=200)


@cocotb.test(timeout_time=6, timeout_unit="ms")
async def longest(dut: Any) -> None:
    """As many bytes as a READ may ask for: noise is sent as it is, a flat row in a few bytes."""
    bench = await start(dut, "longest")
    link = Link(bench, "full_speed", "full_speed")
    # Runs that end behind so many bytes: each bit of their length is sent.
    lengths = (85, 300, 600, 900, 1011) if bench.default else (1011,)
    broken = [bytes(at) + b"\1" + bytes(MAX_READ - at - 1) for at in lengths]
    for data in (bench.draw.randbytes(MAX_READ), bytes(MAX_READ), link.bytes_of(0, MAX_READ), *broken):
        cycles = await link.read(data, 0)
        bench.check("in time", cycles <= MOST_CYCLES * MAX_READ + 20, True, inputs=cycles)
    bench.check("a flat row", len(pack_pixels(bytes(MAX_READ), link.sizes[0])) < 4, True)
    bench.finish(at_least=10)


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def bytes_come_before_their_ready(dut: Any) -> None:
    """What takes the bytes may wait for each of them before it is ready."""
    bench = await start(dut, "bytes_come_before_their_ready")
    data = bytes(range(0, 60, 2)) + b"\x99" * 9
    expected, got = pack_pixels(data, bench.config.value_bytes), bytearray()
    assert 4 < len(expected) < len(data)
    dut.read_valid.value, dut.read_packed.value, dut.read_count.value = 1, 1, len(data)
    screen: list[int] = []
    for _ in range(4000):
        dut.area_ready.value, dut.byte_valid.value = int(not screen), int(bool(screen))
        dut.byte_data.value = screen[0] if screen else 0
        dut.data_ready.value = 0
        await bench.edge()
        if screen and dut.byte_ready.value:
            screen.pop(0)
        if dut.data_valid.value:
            for _ in range(3):
                dut.byte_valid.value = dut.area_ready.value = 0
                await bench.edge()
                bench.check("data_valid stays", bool(dut.data_valid.value), True)
            dut.data_ready.value = 1
            await bench.edge()
            got.append(int(dut.data.value))
        elif dut.area_valid.value:
            screen = list(data)
            dut.read_valid.value = int(not dut.read_ready.value)
        if len(got) == len(expected):
            break
    bench.check("answer", got.hex(), expected.hex())
    bench.finish(at_least=10)


@cocotb.test(timeout_time=4, timeout_unit="ms")
@cocotb.parametrize(source=list(SPEEDS), sink=list(SPEEDS))
async def resets(dut: Any, source: str, sink: str) -> None:
    """Amid either reading, and amid an answer: the next answer is whole, and its own."""
    bench = await start(dut, f"resets {source} {sink}")
    # Every pair of speeds by default, the equal ones in each configuration.
    if source != sink and not bench.default:
        return

    async def work() -> None:
        link = Link(bench, source, sink)
        for plane in list(link.sizes)[:2]:
            await link.read(link.bytes_of(plane, 30), plane)
        await link.read(bytes(12), 0)

    events = (
        *(("area_valid", "area_ready"), ("byte_valid", "byte_ready"), ("read_valid", "read_ready")),
        ("data_valid", "data_ready"),
    )
    await reset_amid(bench, work, events, 16, quiet=("data_valid", "area_valid", "byte_ready"))
    bench.finish(at_least=100)
