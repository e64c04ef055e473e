# SPDX-License-Identifier: Apache-2.0
"""Memory against the model: every word, both ports at once, a read port that waits."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cocotb
import pytest

from cocotb_tests.support.bench import SPEEDS, Bench
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.golden.common.block_ram import BlockRam

PORTS = ("write_enable", "write_address", "write_data", "read_enable", "read_address")


@dataclass(frozen=True)
class Config:
    """Generics of ``block_ram``."""

    num_words: int = 512
    data_bits: int = 16
    bank_words: int = 16384
    slice_bits: int = 4096
    read_stages: int = 2


CONFIGS = [
    Config(),
    Config(num_words=1),
    Config(num_words=300, data_bits=17),
    Config(num_words=5, data_bits=1),
    Config(num_words=385, bank_words=128),
    Config(num_words=512, bank_words=64, data_bits=3),
    Config(num_words=375, bank_words=64, read_stages=3),
    Config(num_words=385, bank_words=128, read_stages=3),
    Config(num_words=300, data_bits=1, read_stages=3),
    Config(read_stages=4),
    Config(num_words=300, data_bits=20, slice_bits=9),
    Config(num_words=385, bank_words=128, read_stages=4),
    Config(num_words=385, bank_words=128, read_stages=5),
]


@pytest.mark.parametrize("config", CONFIGS, ids=identifier)
def test_block_ram(config: Config) -> None:
    simulate("block_ram", config)


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(speed=list(SPEEDS))
async def every_cycle(dut: Any, speed: str) -> None:
    bench = Bench(dut, Config, f"every_cycle {speed}")
    config = bench.config
    await bench.start(*PORTS, reset=False)
    go = SPEEDS[speed](bench.draw)
    model = BlockRam(config.read_stages)
    # Every word once, in a random order; then everything at random, often where something was just written.
    order = bench.rng.permutation(config.num_words).tolist()
    recent = 0
    for index in range(config.num_words + 1500):
        filling = index < config.num_words
        write = None
        if filling or bench.chance(0.5):
            address = order[index] if filling else bench.draw.randrange(config.num_words)
            write = (address, bench.bits(config.data_bits))
        reads = next(go)
        address = recent if bench.chance(0.4) else bench.draw.randrange(config.num_words)
        dut.write_enable.value = int(write is not None)
        if write is not None:
            dut.write_address.value, dut.write_data.value = write
        dut.read_enable.value = int(reads)
        dut.read_address.value = address
        await bench.edge()
        if model.read_data is not None:
            inputs = {"write": write, "read_address": address, "read_enable": reads}
            bench.check("read_data", int(dut.read_data.value), model.read_data, index, inputs)
        model.clock(write, address if reads else None)
        if write is not None:
            recent = write[0]
    bench.finish(at_least=700)
