# SPDX-License-Identifier: Apache-2.0
"""A channel along the major edge against the model, every scanline in every cycle."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Any

import cocotb
import pytest

from cocotb_tests.support.bench import SPEEDS, Bench
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.contract.formats import DIFFERENCES
from quadshade.golden.core.scanline_channel import ScanlineChannel

LATENCY = 4
"""Enabled cycles from stage 2 to the span."""
LEAST_APART = 3
"""Stages between two primitives' first scanlines."""
PRIMITIVES = 80


@dataclass(frozen=True)
class Config:
    """Generics of ``scanline_channel``."""

    word_width: int = 32
    max_order: int = 2


CONFIGS = [
    Config(),
    Config(word_width=2),
    Config(word_width=40),
    Config(max_order=1),
    Config(word_width=24, max_order=0),
]


@pytest.mark.parametrize("config", CONFIGS, ids=identifier)
def test_scanline_channel(config: Config) -> None:
    simulate("scanline_channel", config)


@dataclass
class Line:
    """A scanline on its way: the primitive's words, the carry after it, and the span's words."""

    primitive: int
    words: list[int]
    first: bool
    carry: int
    span: tuple[int, int, int]


def primitive_lines(bench: Bench, primitive: int) -> list[Line | None]:
    """Scanlines of a primitive, then gaps: none, or what the next may not come closer than."""
    width = bench.config.word_width
    words = [bench.bits(width) for _ in DIFFERENCES]
    channel = ScanlineChannel(words, bench.config.max_order, width)
    lines: list[Line | None] = []
    # Short ones first: they are closest to each other.
    rows = 1 + primitive % 4 if primitive < 16 else bench.draw.randint(1, 20)
    carries = bench.draw.choice((0.0, 0.5, 1.0))
    for row in range(rows):
        carry = int(bench.chance(carries))
        lines.append(Line(primitive, words, row == 0, carry, channel.span()))
        channel.step(carry)
    gaps = max(LEAST_APART - rows, 0) + (bench.draw.randint(0, 4) if bench.chance(0.2) else 0)
    return lines + [None] * gaps


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(speed=list(SPEEDS))
async def every_scanline(dut: Any, speed: str) -> None:
    bench = Bench(dut, Config, f"every_scanline {speed}")
    ports = [f"setup_{difference}" for difference in DIFFERENCES]
    await bench.start("enable", "copy", "first", "carry", *ports, reset=False)
    enables = SPEEDS[speed](bench.draw)
    width = bench.config.word_width
    lines = [line for primitive in range(PRIMITIVES) for line in primitive_lines(bench, primitive)]
    # From stage 1 to the span's, which is LATENCY after stage 2.
    stages: deque[Line | None] = deque([None] * (LATENCY + 2))
    seen = 0
    for line in lines + [None] * len(stages):
        stages.appendleft(line)
        stages.pop()
        enable, copy = False, line is not None and line.first
        while not enable:
            enable = next(enables)
            dut.enable.value = int(enable)
            dut.copy.value = int(copy)
            for difference, port in enumerate(ports):
                # The words stand there in the cycle of the copy, and no longer.
                getattr(dut, port).value = line.words[difference] if copy else bench.bits(width)
            # Where there is no scanline the carry means nothing.
            dut.first.value = int(stages[1].first) if stages[1] else 0
            dut.carry.value = stages[1].carry if stages[1] else int(bench.chance(0.5))
            await bench.edge()
            copy = False
            out = stages[-1]
            if out is not None:
                got = tuple(int(getattr(dut, f"span_{n}").value) for n in ("value", "d_col", "dd_col"))
                inputs = f"primitive {out.primitive}, words {out.words}"
                bench.check("span's words", got, out.span, seen, inputs)
        seen += stages[-1] is not None
    bench.check("scanlines seen", seen, sum(line is not None for line in lines))
    bench.finish(at_least=4 * PRIMITIVES)
