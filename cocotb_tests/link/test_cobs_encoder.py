# SPDX-License-Identifier: Apache-2.0
"""The encoder against the model and the package cobs, at any speed, and what a reset leaves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cocotb
import pytest
from cobs import cobs

from cocotb_tests.support.bench import SPEEDS, Bench, StreamSink, StreamSource
from cocotb_tests.support.resets import reset_amid
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.golden.link.cobs_encoder import encode_line


@dataclass(frozen=True)
class Config:
    """``cobs_encoder`` has no generics."""


@pytest.mark.parametrize("config", [Config()], ids=identifier)
def test_cobs_encoder(config: Config) -> None:
    simulate("cobs_encoder", config)


def stream_words(bodies: list[bytes]) -> list[tuple[int, int]]:
    """Data and last."""
    return [(byte, int(place == len(body) - 1)) for body in bodies for place, byte in enumerate(body)]


async def send(bench: Bench, bodies: list[bytes], source: str, sink: str) -> int:
    """Frames through the unit, which is idle afterwards; bytes of the line."""
    dut, end = bench.dut, bench.cycle + 20000
    going = StreamSource(
        dut.byte_valid, dut.byte_ready, [dut.byte_data, dut.byte_last], stream_words(bodies),
        SPEEDS[source](bench.draw),
    )  # fmt: skip
    coming = StreamSink(bench, dut.line_valid, dut.line_ready, [dut.line_data], SPEEDS[sink](bench.draw))
    expected = b"".join(map(encode_line, bodies))
    assert expected == b"".join(b"\0" + cobs.encode(body) + b"\0" for body in bodies)
    while len(coming.words) < len(expected) and bench.cycle < end:
        going.drive()
        coming.drive()
        await bench.edge()
        coming.sample(bench.cycle)
        going.sample(bench.cycle)
    for _ in range(20):
        coming.drive()
        await bench.edge()
        coming.sample(bench.cycle)
    bench.check_all("byte of the line", [word[0] for word in coming.words], list(expected))
    bench.check("idle", bool(dut.idle.value), True)
    bench.check("all was taken", going.empty, True)
    return len(expected)


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(source=list(SPEEDS), sink=list(SPEEDS))
async def frames(dut: Any, source: str, sink: str) -> None:
    bench = Bench(dut, Config, f"frames {source} {sink}")
    await bench.start("byte_valid", "byte_data", "byte_last", "line_ready")
    bodies = [b"\0", b"\0\0", b"\1", b"\1\0", b"\1" * 253, b"\1" * 254, b"\1" * 255, b"\1" * 254 + b"\0"]
    bodies += [bench.draw.randbytes(bench.draw.randrange(1, 60)) for _ in range(6)]
    length = await send(bench, bodies, source, sink)
    if source == sink == "full_speed":
        # Four cycles a byte: gathering, fetching twice, sending; and a few for each block.
        bench.check("cycles", bench.cycle < 4.2 * length, True, inputs=(bench.cycle, length))
    bench.finish(at_least=1000)


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(source=list(SPEEDS), sink=list(SPEEDS))
async def resets(dut: Any, source: str, sink: str) -> None:
    bench = Bench(dut, Config, f"resets {source} {sink}")
    await bench.start("byte_valid", "byte_data", "byte_last", "line_ready")

    async def work() -> None:
        bodies = [bench.draw.randbytes(bench.draw.randint(1, 4)) + bytes(bench.draw.randint(0, 1)), b"\1"]
        await send(bench, bodies, source, sink)

    events = (("byte_valid", "byte_ready"), "line_valid", "byte_last")
    await reset_amid(bench, work, events, 60, quiet=("line_valid", "byte_ready"))
    bench.finish(at_least=100)
