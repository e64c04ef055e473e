# SPDX-License-Identifier: Apache-2.0
"""The encoder against the model and the package cobs, at any speed, and what a reset leaves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cocotb
import pytest
from cobs import cobs

from cocotb_tests.support.bench import SPEEDS, Bench, StreamSink, StreamSource, full_speed
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


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(source=list(SPEEDS), sink=list(SPEEDS))
async def frames(dut: Any, source: str, sink: str) -> None:
    bench = Bench(dut, Config, f"frames {source} {sink}")
    await bench.start("byte_valid", "byte_data", "byte_last", "line_ready")
    bodies = [b"\0", b"\0\0", b"\1", b"\1\0", b"\1" * 253, b"\1" * 254, b"\1" * 255, b"\1" * 254 + b"\0"]
    bodies += [bench.draw.randbytes(bench.draw.randrange(1, 60)) for _ in range(6)]
    going = StreamSource(
        dut.byte_valid, dut.byte_ready, [dut.byte_data, dut.byte_last], stream_words(bodies),
        SPEEDS[source](bench.draw),
    )  # fmt: skip
    coming = StreamSink(bench, dut.line_valid, dut.line_ready, [dut.line_data], SPEEDS[sink](bench.draw))
    expected = b"".join(map(encode_line, bodies))
    assert expected == b"".join(b"\0" + cobs.encode(body) + b"\0" for body in bodies)
    while len(coming.words) < len(expected) and bench.cycle < 20000:
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
    if source == sink == "full_speed":
        # Four cycles a byte: gathering, fetching twice, sending; and a few for each block.
        bench.check("cycles", bench.cycle < 4.2 * len(expected), True, inputs=(bench.cycle, len(expected)))
    bench.finish(at_least=1000)


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def reset_forgets(dut: Any) -> None:
    bench = Bench(dut, Config, "reset_forgets")
    await bench.start("byte_valid", "byte_data", "byte_last", "line_ready")
    for cut in range(1, 40, 2):
        body = bench.draw.randbytes(12)
        going = StreamSource(
            dut.byte_valid, dut.byte_ready, [dut.byte_data, dut.byte_last], stream_words([body]),
            full_speed(bench.draw),
        )  # fmt: skip
        dut.line_ready.value = 1
        for _ in range(cut):
            going.drive()
            await bench.edge()
            going.sample(bench.cycle)
        dut.byte_valid.value = 0
        await bench.reset()
        await bench.edge()
        bench.check("idle after reset", bool(dut.idle.value), True, cut)
        bench.check("line_valid after reset", bool(dut.line_valid.value), False, cut)
    bench.finish(at_least=40)
