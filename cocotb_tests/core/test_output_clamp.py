# SPDX-License-Identifier: Apache-2.0
"""Word to output value against the model: every word of tiny formats, the edges of large ones."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cocotb
import pytest
from cocotb.triggers import Timer

from cocotb_tests.support.bench import Bench
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.golden.core.output_clamp import output_clamp

EXHAUSTIVE_BITS = 12


@dataclass(frozen=True)
class Config:
    """Generics of ``output_clamp``."""

    word_width: int = 32
    frac_bits: int = 22
    value_bits: int = 8


CONFIGS = [
    Config(),
    Config(word_width=12, frac_bits=2, value_bits=8),
    Config(word_width=12, frac_bits=0, value_bits=4),
    Config(word_width=8, frac_bits=5, value_bits=1),
    Config(word_width=40, frac_bits=22, value_bits=16),
]


@pytest.mark.parametrize("config", CONFIGS, ids=identifier)
def test_output_clamp(config: Config) -> None:
    simulate("output_clamp", config)


def words(bench: Bench) -> list[int]:
    """Every word, or those around the places where the output changes, and random ones."""
    width, frac = bench.config.word_width, bench.config.frac_bits
    if width <= EXHAUSTIVE_BITS:
        return list(range(1 << width))
    steps = [0, 1, 1 << bench.config.value_bits, 1 << (width - 1 - frac), 1 << (width - frac)]
    near = [(step << frac) + offset for step in steps for offset in (-2, -1, 0, 1)]
    return [word % (1 << width) for word in near] + [bench.bits(width) for _ in range(2000)]


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def every_word(dut: Any) -> None:
    bench = Bench(dut, Config, "every_word")
    config = bench.config
    for index, word in enumerate(words(bench)):
        dut.word.value = word
        await Timer(1, "ns")
        expected = output_clamp(word, config.word_width, config.frac_bits, config.value_bits)
        bench.check("value", int(dut.value.value), expected, index, f"word {word:#x}")
    bench.finish(at_least=256)
