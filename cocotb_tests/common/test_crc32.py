# SPDX-License-Identifier: Apache-2.0
"""The CRC against zlib in every cycle, and against the model."""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from typing import Any

import cocotb
import pytest

from cocotb_tests.support.bench import SPEEDS, UNKNOWN, Bench
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.golden.common.crc32 import CRC_RESIDUE, Crc32
from quadshade.link.frames import sealed


@dataclass(frozen=True)
class Config:
    """Generics of ``crc32``."""

    num_bytes: int = 1
    cycles: int = 1


@pytest.mark.parametrize(
    "config", [Config(), Config(num_bytes=3), Config(cycles=4), Config(cycles=8)], ids=identifier
)
def test_crc32(config: Config) -> None:
    simulate("crc32", config)


# Only power-up begins a sum without `clear`.
@cocotb.test(timeout_time=1, timeout_unit="ms", skip=UNKNOWN)
async def words_from_power_up_on(dut: Any) -> None:
    """This test is the first of a simulation."""
    bench = Bench(dut, Config, "words_from_power_up_on")
    await bench.start("clear", "byte_valid", "byte_data", reset=False)
    bench.check("crc of nothing", int(dut.crc.value), 0)
    data, step = bench.draw.randbytes(5 * bench.config.num_bytes), bench.config.num_bytes
    for place in range(0, len(data), step):
        dut.byte_valid.value = 1
        dut.byte_data.value = int.from_bytes(data[place : place + step], "little")
        await bench.edge()
        dut.byte_valid.value = 0
        for _ in range(1 + bench.config.cycles * (bench.config.cycles > 1)):
            await bench.edge()
        bench.check("crc", int(dut.crc.value), zlib.crc32(data[: place + step]), place)
    bench.finish(at_least=6)


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(source=list(SPEEDS))
async def every_cycle(dut: Any, source: str) -> None:
    bench = Bench(dut, Config, f"every_cycle {source}")
    await bench.start("clear", "byte_valid", "byte_data", reset=False)
    model, data, go = Crc32(), b"", SPEEDS[source](bench.draw)
    left = 0
    for index in range(1500):
        clears = index == 0 or bench.chance(0.01)
        valid, word = next(go) and not left, bench.bits(8 * bench.config.num_bytes)
        dut.clear.value, dut.byte_valid.value, dut.byte_data.value = int(clears), int(valid), word
        await bench.edge()
        if index:
            bench.check("busy", bool(dut.busy.value), left > 0, index)
        if index and not left:
            inputs = {"bytes": data}
            bench.check("crc", int(dut.crc.value), zlib.crc32(data), index, inputs)
            bench.check("model's crc", model.crc, zlib.crc32(data), index, inputs)
        left = max(left - 1, 0)
        if clears:
            left, data = 0, b""
            model.clear()
        if valid:
            left = bench.config.cycles * (bench.config.cycles > 1)
            some = word.to_bytes(bench.config.num_bytes, "little")
            data += some
            for byte in some:
                model.add(byte)
    bench.finish(at_least=2998 // (bench.config.cycles + 1))


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def residue(dut: Any) -> None:
    bench = Bench(dut, Config, "residue")
    await bench.start("clear", "byte_valid", "byte_data", reset=False)
    step = bench.config.num_bytes
    for index in range(20):
        # As many bytes that whole words end with the CRC.
        data = sealed(bench.draw.randbytes(index + (-index - 4) % step))
        for place in range(0, len(data), step):
            word = int.from_bytes(data[place : place + step], "little")
            dut.clear.value, dut.byte_valid.value, dut.byte_data.value = int(place == 0), 1, word
            await bench.edge()
            dut.clear.value = dut.byte_valid.value = 0
            for _ in range(bench.config.cycles * (bench.config.cycles > 1)):
                await bench.edge()
        dut.clear.value = dut.byte_valid.value = 0
        await bench.edge()
        bench.check("crc over bytes and their crc", int(dut.crc.value), CRC_RESIDUE, index)
    bench.finish(at_least=20)
