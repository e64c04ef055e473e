# SPDX-License-Identifier: Apache-2.0
"""Bytes of every plane against the model: exactly as many as were asked for, at every pace, after resets."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import cocotb
import pytest

from cocotb_tests.support.bench import SPEEDS, Bench, StreamSink, StreamSource
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
    Config(value_bytes=1, depth_bytes=4),
    Config(value_bytes=4, depth_bytes=1),
]


@pytest.mark.parametrize("config", CONFIGS, ids=identifier)
def test_plane_reader(config: Config) -> None:
    simulate("plane_reader", config)


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(source=list(SPEEDS), sink=list(SPEEDS))
async def areas(dut: Any, source: str, sink: str) -> None:
    bench = Bench(dut, Config, f"areas {source} {sink}")
    config = bench.config
    sizes = (config.value_bytes, config.depth_bytes, EDGE_BYTES, EDGE_BYTES)
    await bench.start(*INPUTS, "byte_ready")
    takes = StreamSink(
        bench, dut.byte_valid, dut.byte_ready, [dut.byte_data, dut.byte_last], SPEEDS[sink](bench.draw)
    )
    bits = 8 * (config.value_bytes + config.depth_bytes)
    for index in range(60):
        plane = bench.draw.choice([number for number in range(len(PLANES)) if sizes[number]])
        count = bench.draw.choice((1, sizes[plane], bench.draw.randint(1, 40)))
        pixels = [
            (bench.bits(bits), bench.bits(8 * EDGE_BYTES)) for _ in range(-(-count // sizes[plane]) + 2)
        ]
        offers = StreamSource(
            dut.pixel_valid,
            dut.pixel_ready,
            [dut.pixel_data, dut.pixel_edges],
            pixels,
            SPEEDS[source](bench.draw),
        )
        dut.request_valid.value, dut.request_plane.value, dut.request_count.value = 1, plane, count
        await bench.edge()
        bench.check("request_ready", bool(dut.request_ready.value), True, index)
        # Another request is not heard before the last byte was taken.
        dut.request_plane.value, dut.request_count.value = bench.draw.randrange(4), 1
        expected = plane_reader(plane, count, pixels, config.value_bytes, config.depth_bytes)
        cut = bench.draw.randrange(count) if index % 7 == 6 else count
        begin = len(takes.words)
        while len(takes.words) - begin < cut:
            dut.request_valid.value = int(bench.chance(0.5))
            takes.drive()
            offers.drive()
            await bench.edge()
            bench.check("request_ready while reading", bool(dut.request_ready.value), False, index)
            takes.sample(bench.cycle)
            offers.sample(bench.cycle)
        dut.request_valid.value = 0
        words = [(byte, int(at == count - 1)) for at, byte in enumerate(expected)]
        bench.check_all("byte", takes.words[begin:], words[:cut])
        if source == sink == "full_speed" and cut == count:
            gaps = {later - one for one, later in pairwise(takes.taken_at[begin:])}
            bench.check("clocks between bytes", gaps <= {1}, True, index, (plane >= EDGES_DIAGONAL, gaps))
        if cut == count:
            taken = -(-count // sizes[plane])
            bench.check("pixels that were taken", len(offers.accepted_at), taken, index)
        else:
            takes.held = None
            await bench.reset()
        dut.pixel_valid.value = 0
        for _ in range(3):
            await bench.edge()
            bench.check("byte_valid at rest", bool(dut.byte_valid.value), False, index)
    bench.finish(at_least=300)
