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


def every_length() -> bytes:
    """A frame with a whole block, and blocks whose codes differ from that one's in a single bit."""
    lengths = [254, *(254 - (1 << bit) for bit in range(8))]
    return b"\0".join(b"\1" * length for length in lengths) + b"\2" * 254 + b"\3"


class Unit:
    """The unit beside its model, cycle by cycle."""

    def __init__(self, bench: Bench) -> None:
        self.bench, self.model, self.expected = bench, CobsDecoder(), Decoded()
        self.got = bytearray()
        self.frames: list[tuple[bytes, bool]] = []

    async def cycle(self, byte: int | None = None, error: bool = False, reset: bool = False) -> None:
        """One cycle with these inputs; what follows from them is compared in the next one."""
        dut = self.bench.dut
        dut.line_valid.value, dut.line_data.value = int(byte is not None), byte or 0
        dut.line_error.value, dut.reset.value = int(error), int(reset)
        await self.bench.edge()
        ports = (bool(dut.byte_valid.value), bool(dut.frame_end.value), bool(dut.frame_good.value))
        wanted = (self.expected.data is not None, self.expected.end, self.expected.good)
        self.bench.check("byte_valid, frame_end, frame_good", ports, wanted, inputs=(byte, error, reset))
        if ports[0]:
            self.got.append(int(dut.byte_data.value))
            self.bench.check("byte_data", self.got[-1], self.expected.data, inputs=(byte, error, reset))
        if ports[1]:
            self.frames.append((bytes(self.got), ports[2]))
            self.got.clear()
        self.expected = Decoded()
        if error:
            self.model.error()
        if byte is not None:
            self.expected = self.model.add(byte)
        if reset:
            self.model, self.expected = CobsDecoder(), Decoded()
            self.got.clear()


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def whole_blocks(dut: Any) -> None:
    """A zero follows every block but a whole one, and one at the frame's end."""
    bench = Bench(dut, Config, "whole_blocks")
    await bench.start("line_valid", "line_data", "line_error")
    unit = Unit(bench)
    bodies = [every_length(), b"\1" * 254, b"\1" * 255, b"\1" * 254 + b"\0", b"\0" + b"\1" * 253]
    for body in bodies:
        for byte in cobs.encode(body) + b"\0":
            await unit.cycle(byte)
    await unit.cycle()
    bench.check_all("frames", unit.frames, [(body, True) for body in bodies])
    bench.finish(at_least=2000)


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def cut_blocks(dut: Any) -> None:
    """A frame that ends so many bytes too early is not good, each bit of their number alone."""
    bench = Bench(dut, Config, "cut_blocks")
    await bench.start("line_valid", "line_data", "line_error")
    unit = Unit(bench)
    for bit in range(8):
        for byte in bytes([2 + (1 << bit), 7, 0]):
            await unit.cycle(byte)
    await unit.cycle()
    bench.check_all("frames", unit.frames, [(b"\7", False)] * 8)
    bench.finish(at_least=30)


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def a_character_is_lost(dut: Any) -> None:
    """A frame whose blocks are whole is not good where the line lost a character before any of its bytes."""
    bench = Bench(dut, Config, "a_character_is_lost")
    await bench.start("line_valid", "line_data", "line_error")
    unit = Unit(bench)
    line = cobs.encode(b"a\0bc\0") + b"\0"
    for lost in range(len(line)):
        for place, byte in enumerate(line):
            if place == lost:
                await unit.cycle(error=True)
            await unit.cycle(byte)
    await unit.cycle()
    bench.check_all("frames", unit.frames, [(b"a\0bc\0", False)] * len(line))
    bench.finish(at_least=60)


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def reset_in_any_cycle(dut: Any) -> None:
    """With every byte of a frame, its end among them, and after a character was lost: nothing is left."""
    bench = Bench(dut, Config, "reset_in_any_cycle")
    await bench.start("line_valid", "line_data", "line_error")
    unit = Unit(bench)
    line = cobs.encode(b"a\0bc\0") + b"\0"
    for last in range(len(line)):
        for lost in (False, True):
            unit.frames.clear()
            await unit.cycle(error=lost)
            for place in range(last + 1):
                await unit.cycle(line[place], reset=place == last)
            for byte in line:
                await unit.cycle(byte)
            await unit.cycle()
            bench.check("frames after the reset", unit.frames, [(b"a\0bc\0", True)], inputs=(last, lost))
    bench.finish(at_least=200)


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
    unit, go = Unit(bench), SPEEDS[source](bench.draw)
    reset = at_random(bench.draw, 300)
    for piece, wanted in pieces:
        waiting, whole = list(piece), True
        unit.frames.clear()
        while waiting or unit.expected != Decoded():
            valid = bool(waiting) and next(go)
            error = wanted is None and bool(waiting) and not valid and bench.chance(0.02)
            resets = next(reset)
            # Of a piece in which there is a reset the rest may be anything.
            whole = whole and not resets
            await unit.cycle(waiting.pop(0) if valid else None, error, resets)
        if wanted is not None and whole:
            bench.check("frames", unit.frames, [(wanted, True)], inputs=piece)
    bench.finish(at_least=2000)
