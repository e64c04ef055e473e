# SPDX-License-Identifier: Apache-2.0
"""Loading and adding against the model: every input of tiny widths, carries through all of large ones."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from typing import Any

import cocotb
import pytest
from cocotb.triggers import Timer

from cocotb_tests.support.bench import Bench
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.golden.core.load_adder import load_adder

EXHAUSTIVE_BITS = 3


@dataclass(frozen=True)
class Config:
    """Generics of ``load_adder``."""

    width: int = 32
    with_carry: int = 0


CONFIGS = [
    Config(),
    Config(width=1, with_carry=1),
    Config(width=2),
    Config(width=3),
    Config(width=3, with_carry=1),
    Config(width=13, with_carry=1),
    Config(width=64, with_carry=1),
]


@pytest.mark.parametrize("config", CONFIGS, ids=identifier)
def test_load_adder(config: Config) -> None:
    simulate("load_adder", config)


def inputs(bench: Bench) -> Iterator[tuple[int, ...]]:
    """load, carry_in, start, value, step."""
    width = bench.config.width
    if width <= EXHAUSTIVE_BITS:
        words = range(1 << width)
        yield from product((0, 1), (0, 1), words, words, words)
        return
    top = (1 << width) - 1
    edges = (0, 1, top, top - 1, top >> 1, 1 << width - 1, top // 3, top - top // 3)
    yield from product((0, 1), (0, 1), edges, edges, edges)
    for _ in range(2000):
        yield bench.bits(1), bench.bits(1), bench.bits(width), bench.bits(width), bench.bits(width)


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def every_sum(dut: Any) -> None:
    bench = Bench(dut, Config, "every_sum")
    width, with_carry = bench.config.width, bench.config.with_carry
    for index, (load, carry_in, start, value, step) in enumerate(inputs(bench)):
        dut.load.value, dut.carry_in.value = load, carry_in
        dut.start.value, dut.value.value, dut.step.value = start, value, step
        await Timer(1, "ns")
        expected = load_adder(load, start, value, step, width, carry_in if with_carry else 0)
        bench.check("sum", int(dut.sum.value), expected, index, (load, carry_in, start, value, step))
    bench.finish(at_least=32)
