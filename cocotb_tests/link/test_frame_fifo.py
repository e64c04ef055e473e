# SPDX-License-Identifier: Apache-2.0
"""The FIFO of frames against the model: room in every cycle, words in order, and frames that go."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cocotb
import pytest

from cocotb_tests.support.bench import SPEEDS, Bench
from cocotb_tests.support.resets import at_random
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.golden.link.frame_fifo import FrameFifo


@dataclass(frozen=True)
class Config:
    """Generics of ``frame_fifo``."""

    num_words: int = 16
    data_bits: int = 32
    read_stages: int = 4


CONFIGS = [Config(), Config(num_words=4, data_bits=8), Config(read_stages=2)]


@pytest.mark.parametrize("config", CONFIGS, ids=identifier)
def test_frame_fifo(config: Config) -> None:
    simulate("frame_fifo", config)


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(source=list(SPEEDS), sink=list(SPEEDS))
async def frames(dut: Any, source: str, sink: str) -> None:
    bench = Bench(dut, Config, f"frames {source} {sink}")
    await bench.start("write_valid", "write_data", "commit", "discard", "read_ready")
    writes, reads = SPEEDS[source](bench.draw), SPEEDS[sink](bench.draw)
    model, held, read, overflows = FrameFifo(bench.config.num_words), None, 0, 0
    reset = at_random(bench.draw, 120)
    for index in range(1600):
        resets = next(reset)
        ends = bench.chance(0.2)
        commits = ends and bench.chance(0.6)
        write = not ends and next(writes)
        word, ready = bench.bits(bench.config.data_bits), next(reads)
        dut.reset.value = int(resets)
        dut.write_valid.value, dut.write_data.value = int(write), word
        dut.commit.value, dut.discard.value = int(commits), int(ends and not commits)
        dut.read_ready.value = int(ready)
        await bench.edge()
        bench.check("free", int(dut.free.value), model.free, index)
        bench.check("overflow", bool(dut.overflow.value), model.overflow, index)
        shown = int(dut.read_data.value) if dut.read_valid.value else None
        if held is not None:
            bench.check("word that waits", shown, held, index)
        if shown is not None:
            bench.check("read_data", shown, model.committed[0] if model.committed else None, index)
        held = None if ready else shown
        # What is read in a cycle makes room for the next one.
        if write:
            model.write(word)
            overflows += model.overflow
        if ends:
            model.commit() if commits else model.discard()
        if shown is not None and ready:
            model.take()
            read += 1
        if resets:
            model, held = FrameFifo(bench.config.num_words), None
    bench.check("words were read, and frames did not fit", (read > 30, overflows > 3), (True, True))
    bench.finish(at_least=3000)


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def latency(dut: Any) -> None:
    bench = Bench(dut, Config, "latency")
    await bench.start("write_valid", "write_data", "commit", "discard", "read_ready")
    dut.write_valid.value = 1
    await bench.edge()
    dut.write_valid.value, dut.commit.value, dut.read_ready.value = 0, 1, 1
    await bench.edge()
    dut.commit.value = 0
    cycles = 0
    while not dut.read_valid.value and cycles < 20:
        await bench.edge()
        cycles += 1
    bench.check("cycles from commit to output", cycles, 5)
    bench.finish(at_least=1)
