# SPDX-License-Identifier: Apache-2.0
"""Bytes of every plane against the model: exactly as many as were asked for, at every pace, after resets."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import cocotb
import pytest

from cocotb_tests.support.bench import SPEEDS, Bench, StreamSink, StreamSource
from cocotb_tests.support.resets import reset_amid
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.contract.protocol import EDGE_BYTES, PLANES
from quadshade.golden.screen.plane_reader import EDGES_DIAGONAL, plane_reader

INPUTS = ("request_valid", "request_plane", "request_count", "pixel_valid", "pixel_data", "pixel_edges")


@dataclass(frozen=True)
class Config:
    """Generics of ``plane_reader``."""

    value_bytes: int = 3
    depth_bytes: int = 2
    count_bits: int = 12


CONFIGS = [
    Config(),
    Config(value_bytes=1, depth_bytes=0, count_bits=20),
    Config(value_bytes=1, depth_bytes=4, count_bits=6),
    Config(value_bytes=4, depth_bytes=1),
]


@pytest.mark.parametrize("config", CONFIGS, ids=identifier)
def test_plane_reader(config: Config) -> None:
    simulate("plane_reader", config)


class Reader:
    """A device under test, and what takes its bytes."""

    def __init__(self, bench: Bench, source: str, sink: str) -> None:
        dut, self.bench, self.source = bench.dut, bench, source
        config = bench.config
        self.sizes = (config.value_bytes, config.depth_bytes, EDGE_BYTES, EDGE_BYTES)
        self.full_speed = source == sink == "full_speed"
        outputs = [dut.byte_data, dut.byte_last]
        self.takes = StreamSink(bench, dut.byte_valid, dut.byte_ready, outputs, SPEEDS[sink](bench.draw))

    async def read(self, count: int | None = None) -> None:
        """Any plane, and other requests meanwhile; pixels more than it takes are offered."""
        bench, dut, config, takes = self.bench, self.bench.dut, self.bench.config, self.takes
        plane = bench.draw.choice([number for number in range(len(PLANES)) if self.sizes[number]])
        size, bits = self.sizes[plane], 8 * (config.value_bytes + config.depth_bytes)
        count = count or bench.draw.choice((1, size, size + 1, bench.draw.randint(1, 40)))
        pixels = [(bench.bits(bits), bench.bits(8 * EDGE_BYTES)) for _ in range(-(-count // size) + 2)]
        inputs = [dut.pixel_data, dut.pixel_edges]
        offers = StreamSource(
            dut.pixel_valid, dut.pixel_ready, inputs, pixels, SPEEDS[self.source](bench.draw)
        )
        dut.request_valid.value, dut.request_plane.value, dut.request_count.value = 1, plane, count
        await bench.edge()
        bench.check("request_ready", bool(dut.request_ready.value), True)
        # Another request is not heard before the last byte was taken.
        dut.request_plane.value, dut.request_count.value = bench.draw.randrange(4), 1
        expected = plane_reader(plane, count, pixels, config.value_bytes, config.depth_bytes)
        begin = len(takes.words)
        while len(takes.words) - begin < count:
            dut.request_valid.value = int(bench.chance(0.5))
            takes.drive()
            offers.drive()
            await bench.edge()
            bench.check("request_ready while reading", bool(dut.request_ready.value), False)
            takes.sample(bench.cycle)
            offers.sample(bench.cycle)
        dut.request_valid.value = 0
        words = [(byte, int(at == count - 1)) for at, byte in enumerate(expected)]
        bench.check_all("byte", takes.words[begin:], words)
        if self.full_speed:
            gaps = {later - one for one, later in pairwise(takes.taken_at[begin:])}
            bench.check("clocks between bytes", gaps <= {1}, True, None, (plane >= EDGES_DIAGONAL, gaps))
        bench.check("pixels that were taken", len(offers.accepted_at), -(-count // size))
        # None is taken and no byte comes while there is no request, though pixels may wait.
        waits = bench.draw.randrange(4)
        for index in range(3):
            if index == waits:
                dut.pixel_valid.value = 0
            await bench.edge()
            bench.check("byte_valid at rest", bool(dut.byte_valid.value), False)
            bench.check("pixel_ready at rest", bool(dut.pixel_ready.value), False)
        dut.pixel_valid.value = 0


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(source=list(SPEEDS), sink=list(SPEEDS))
async def areas(dut: Any, source: str, sink: str) -> None:
    bench = Bench(dut, Config, f"areas {source} {sink}")
    await bench.start(*INPUTS, "byte_ready")
    reader = Reader(bench, source, sink)
    # As many bytes as the count can say, where those are few, or soon read.
    if bench.config.count_bits < (13 if reader.full_speed else 8):
        await reader.read((1 << bench.config.count_bits) - 1)
    for _ in range(40):
        await reader.read()
    bench.finish(at_least=300)


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def bytes_come_before_their_ready(dut: Any) -> None:
    """What takes the bytes may wait for each of them before it is ready."""
    bench = Bench(dut, Config, "bytes_come_before_their_ready")
    await bench.start(*INPUTS, "byte_ready")
    dut.request_valid.value, dut.request_count.value = 1, bench.config.value_bytes + 1
    await bench.edge()
    dut.request_valid.value, dut.pixel_valid.value = 0, 1
    for index in range(bench.config.value_bytes + 1):
        dut.byte_ready.value = 0
        for _ in range(4):
            await bench.edge()
        bench.check("byte_valid", bool(dut.byte_valid.value), True, index)
        dut.byte_ready.value = 1
        await bench.edge()
    dut.byte_ready.value = 0
    await bench.edge()
    bench.check("byte_valid after the last", bool(dut.byte_valid.value), False)
    bench.finish(at_least=3)


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(source=list(SPEEDS), sink=list(SPEEDS))
async def resets(dut: Any, source: str, sink: str) -> None:
    """Amid any byte of an area: the next one has its own bytes, all of them."""
    bench = Bench(dut, Config, f"resets {source} {sink}")
    await bench.start(*INPUTS, "byte_ready")

    async def work() -> None:
        reader = Reader(bench, source, sink)
        for _ in range(2):
            await reader.read()

    events = ("request_valid", ("pixel_valid", "pixel_ready"), "byte_valid", ("byte_valid", "byte_last"))
    await reset_amid(bench, work, events, 20, quiet=("byte_valid", "pixel_ready"))
    bench.finish(at_least=200)
