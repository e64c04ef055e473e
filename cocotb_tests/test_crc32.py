# SPDX-License-Identifier: Apache-2.0
"""The CRC against zlib in every cycle, and against the model."""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from typing import Any

import cocotb
import pytest

from bench import SPEEDS, Bench
from quadshade.golden.crc32 import CRC_RESIDUE, Crc32
from quadshade.link.frames import sealed
from simulation import identifier, simulate


@dataclass(frozen=True)
class Config:
    """``crc32`` has no generics."""


@pytest.mark.parametrize("config", [Config()], ids=identifier)
def test_crc32(config: Config) -> None:
    simulate("crc32", config)


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(source=list(SPEEDS))
async def every_cycle(dut: Any, source: str) -> None:
    bench = Bench(dut, Config, f"every_cycle {source}")
    await bench.start("clear", "byte_valid", "byte_data", reset=False)
    model, data, go = Crc32(), b"", SPEEDS[source](bench.draw)
    for index in range(1500):
        clears = index == 0 or bench.chance(0.01)
        valid, byte = next(go), bench.bits(8)
        dut.clear.value, dut.byte_valid.value, dut.byte_data.value = int(clears), int(valid), byte
        await bench.edge()
        if index:
            inputs = {"bytes": data}
            bench.check("crc", int(dut.crc.value), zlib.crc32(data), index, inputs)
            bench.check("model's crc", model.crc, zlib.crc32(data), index, inputs)
        if clears:
            data = b""
            model.clear()
        if valid:
            data += bytes([byte])
            model.add(byte)
    bench.finish(at_least=2998)


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def residue(dut: Any) -> None:
    bench = Bench(dut, Config, "residue")
    await bench.start("clear", "byte_valid", "byte_data", reset=False)
    for index in range(20):
        for place, byte in enumerate(sealed(bench.draw.randbytes(index))):
            dut.clear.value, dut.byte_valid.value, dut.byte_data.value = int(place == 0), 1, byte
            await bench.edge()
        dut.clear.value = dut.byte_valid.value = 0
        await bench.edge()
        bench.check("crc over bytes and their crc", int(dut.crc.value), CRC_RESIDUE, index)
    bench.finish(at_least=20)
