# SPDX-License-Identifier: Apache-2.0
"""The deframer against the model in every cycle, and against the package cobs; noise, and frames after it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cocotb
import pytest
from cobs import cobs

from cocotb_tests.support.bench import SPEEDS, Bench
from cocotb_tests.support.resets import at_random
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.golden.link.cobs_decoder import CobsDecoder, Decoded


@dataclass(frozen=True)
class Config:
    """``cobs_decoder`` has no generics."""


@pytest.mark.parametrize("config", [Config()], ids=identifier)
def test_cobs_decoder(config: Config) -> None:
    simulate("cobs_decoder", config)


def random_body(bench: Bench) -> bytes:
    """A frame's bytes: with and without zeros, around the length of a block."""
    length = bench.draw.choice((1, 2, 12, 40, 253, 254, 255, 300))
    body = bytearray(bench.draw.choice((bytes(length), bench.draw.randbytes(length), b"\1" * length)))
    if bench.chance(0.5):
        body[bench.draw.randrange(length)] = 0
    return bytes(body)


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(source=list(SPEEDS))
async def every_cycle(dut: Any, source: str) -> None:
    bench = Bench(dut, Config, f"every_cycle {source}")
    await bench.start("line_valid", "line_data", "line_error")
    # Pairs of a line's piece and the frame that it must give; noise gives what the model says.
    pieces: list[tuple[bytes, bytes | None]] = []
    for _ in range(15):
        body = random_body(bench)
        pieces.append((b"\0" + cobs.encode(body) + b"\0", body))
        noise = bench.draw.randbytes(bench.draw.randrange(60))
        pieces.append((noise + b"\0", None))
    model, go = CobsDecoder(), SPEEDS[source](bench.draw)
    reset = at_random(bench.draw, 300)
    expected, got = Decoded(), bytearray()
    for index, (piece, body) in enumerate(pieces):
        waiting = list(piece)
        while waiting or expected != Decoded():
            valid = bool(waiting) and next(go)
            error = body is None and bool(waiting) and not valid and bench.chance(0.02)
            dut.line_valid.value, dut.line_error.value = int(valid), int(error)
            dut.line_data.value = waiting[0] if waiting else 0
            resets = next(reset)
            dut.reset.value = int(resets)
            await bench.edge()
            ports = (bool(dut.byte_valid.value), bool(dut.frame_end.value), bool(dut.frame_good.value))
            wanted = (expected.data is not None, expected.end, expected.good)
            bench.check("byte_valid, frame_end, frame_good", ports, wanted, index, piece)
            if ports[0]:
                bench.check("byte_data", int(dut.byte_data.value), expected.data, index, piece)
                got.append(int(dut.byte_data.value))
            if ports[1]:
                if body is not None:
                    bench.check("frame", (bytes(got), ports[2]), (body, True), index, piece)
                got.clear()
            expected = Decoded()
            if error:
                model.error()
            if valid:
                expected = model.add(waiting.pop(0))
            if resets:
                # Of this piece the rest may be anything.
                model, expected, body = CobsDecoder(), Decoded(), None
                got.clear()
    bench.finish(at_least=2000)
