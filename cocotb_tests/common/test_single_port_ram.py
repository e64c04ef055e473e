# SPDX-License-Identifier: Apache-2.0
"""Memory of one port against the model: every word, reads in cycles that do not write."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cocotb
import pytest

from cocotb_tests.support.bench import SPEEDS, Bench
from cocotb_tests.support.simulation import ROOT, identifier, simulate
from quadshade.golden.common.single_port_ram import SinglePortRam

PORTS = ("write_enable", "write_address", "write_data", "read_enable", "read_address")


@dataclass(frozen=True)
class Config:
    """Generics of ``single_port_ram``."""

    num_words: int = 600
    data_bits: int = 8


CONFIGS = [Config(), Config(num_words=2, data_bits=1)]


@pytest.mark.parametrize("config", CONFIGS, ids=identifier)
def test_single_port_ram(config: Config) -> None:
    simulate("single_port_ram", config)


@pytest.mark.parametrize("num_words", [600, 76800])
def test_cells(num_words: int, tmp_path: Path) -> None:
    """What synthesis for iCE40UP5K puts in its place, over Yosys' model of the SPRAM."""
    # Here, because this module is imported inside every simulation too.
    from quadshade.synthesis.mapped import cell_models

    models = tmp_path / "cells.v"
    models.write_text(cell_models("ice40"))
    cells = ROOT / "synth" / "cells" / "single_port_ram.v"
    simulate("single_port_ram", Config(num_words=num_words), {"num_words": num_words}, [cells, models])


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(speed=list(SPEEDS))
async def every_cycle(dut: Any, speed: str) -> None:
    bench = Bench(dut, Config, f"every_cycle {speed}")
    config = bench.config
    await bench.start(*PORTS, reset=False)
    go = SPEEDS[speed](bench.draw)
    model = SinglePortRam()
    # Of a large memory some words, from its whole range.
    count = min(config.num_words, 1000)
    order = bench.rng.choice(config.num_words, count, replace=False).tolist()
    recent = 0
    for index in range(count + 1500):
        filling = index < count
        write = None
        if filling or bench.chance(0.4):
            address = order[index] if filling else bench.draw.choice(order)
            write = (address, bench.bits(config.data_bits))
        # Both at once only now and then: what is read then is undefined.
        reads = next(go) and (write is None or bench.chance(0.1))
        address = recent if bench.chance(0.4) else bench.draw.choice(order)
        dut.write_enable.value = int(write is not None)
        if write is not None:
            dut.write_address.value, dut.write_data.value = write
        dut.read_enable.value, dut.read_address.value = int(reads), address
        await bench.edge()
        if model.read_data is not None:
            inputs = {"write": write, "read_address": address, "read_enable": reads}
            bench.check("read_data", int(dut.read_data.value), model.read_data, index, inputs)
        model.clock(write, address if reads else None)
        if write is not None:
            recent = write[0]
    bench.finish(at_least=400)
