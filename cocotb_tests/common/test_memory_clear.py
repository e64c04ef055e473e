# SPDX-License-Identifier: Apache-2.0
"""The fill of a memory against the model, every port in every cycle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cocotb
import pytest

from cocotb_tests.support.bench import Bench
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.golden.common.memory_clear import MemoryClear


@dataclass(frozen=True)
class Config:
    """Generics of ``memory_clear``."""

    num_words: int = 12


CONFIGS = [Config(), Config(num_words=1), Config(num_words=16)]


@pytest.mark.parametrize("config", CONFIGS, ids=identifier)
def test_memory_clear(config: Config) -> None:
    simulate("memory_clear", config)


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def every_cycle(dut: Any) -> None:
    bench = Bench(dut, Config, "every_cycle")
    await bench.start("clear", "emptied")
    model = MemoryClear(bench.config.num_words)
    for index in range(1500):
        resets, clear, emptied = bench.chance(0.01), bench.chance(0.3), bench.chance(0.3)
        dut.reset.value, dut.clear.value, dut.emptied.value = int(resets), int(clear), int(emptied)
        await bench.edge()
        inputs = {"reset": resets, "clear": clear, "emptied": emptied}
        bench.check("busy", bool(dut.busy.value), model.busy, index, inputs)
        bench.check("drained", bool(dut.drained.value), model.draining and emptied, index, inputs)
        bench.check("filling", bool(dut.filling.value), model.address is not None, index, inputs)
        if model.address is not None:
            bench.check("fill_address", int(dut.fill_address.value), model.address, index, inputs)
        model.clock(clear, emptied)
        if resets:
            model.reset()
    bench.finish(at_least=4500)
