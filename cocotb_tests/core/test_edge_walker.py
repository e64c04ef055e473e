# SPDX-License-Identifier: Apache-2.0
"""Primitives to spans against the model: what stands in which stage, in every cycle."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import repeat
from typing import Any

import cocotb
import pytest

from cocotb_tests.support.bench import SPEEDS, Bench
from cocotb_tests.support.resets import at_random
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.contract.formats import EDGE_FIELDS, EDGES, Formats
from quadshade.golden.clocks import WALK_STAGES
from quadshade.golden.core.edge_dda import EdgeDda
from quadshade.golden.core.edge_walker import Scanline, walk_edges
from tests.support.golden_stimuli import random_fields

PORTS = (
    "setup_has_second",
    "setup_mirror",
    "setup_fractional",
    "setup_y",
    "setup_rows_first",
    "setup_rows_second",
    *(f"setup_{edge}_{name}" for edge in EDGES for name, _, _ in EDGE_FIELDS),
)
PRIMITIVES = 80
LEAST_APART = 3
"""Stages between two primitives' first scanlines."""


@dataclass(frozen=True)
class Config:
    """What the generics of ``edge_walker`` follow from."""

    coord_bits: int = 12
    subpixel_bits: int = 8
    walk_stages: int = WALK_STAGES

    @cached_property
    def formats(self) -> Formats:
        return Formats(coord_bits=self.coord_bits, subpixel_bits=self.subpixel_bits)


CONFIGS = [
    Config(),
    Config(coord_bits=3, subpixel_bits=0, walk_stages=6),
    Config(coord_bits=6, walk_stages=9),
]


@pytest.mark.parametrize("config", CONFIGS, ids=identifier)
def test_edge_walker(config: Config) -> None:
    formats = config.formats
    generics = {
        "coord_bits": config.coord_bits,
        "column_bits": formats.column_bits,
        "edge_bits": formats.edge_bits,
        "walk_stages": config.walk_stages,
    }
    simulate("edge_walker", config, generics)


def sharpened(bench: Bench, fields: dict[str, int]) -> dict[str, int]:
    """Each edge's error is 0 or -1 in some scanline: there one more in any word decides on the carry."""
    formats, fields = bench.config.formats, dict(fields)
    for edge in EDGES:
        at = bench.draw.randrange(4)
        # What the shift changes before that scanline is settled by a few more.
        for _ in range(4):
            dda = EdgeDda(fields, edge, formats)
            for _ in range(at):
                dda.step()
            error = fields[f"{edge}_error"] - dda.error - bench.draw.randrange(2)
            fields[f"{edge}_error"] = error % (1 << formats.error_bits)
    return fields


class Stages:
    """Which scanline is in which stage, and the flags towards loader and channels."""

    def __init__(self, config: Config) -> None:
        self.column_bits = config.formats.column_bits
        self.lines: list[Scanline | None] = [None] * config.walk_stages
        self.coming: list[Scanline] = []
        self.copy = False

    @property
    def can_take(self) -> bool:
        near = self.lines[: LEAST_APART - 1]
        return not self.coming and not any(line and line.first for line in near)

    @property
    def busy(self) -> bool:
        return any(self.lines[:4]) or any(line and line.pixels for line in self.lines[4:])

    def first(self, stage: int) -> bool:
        line = self.lines[stage]
        return line is not None and line.first

    def clock(self, enable: bool, taken: list[Scanline] | None) -> None:
        self.copy = enable and self.first(0)
        if enable:
            if taken:
                self.coming = list(taken)
            self.lines = [self.coming.pop(0) if self.coming else None, *self.lines[:-1]]

    def reset(self) -> None:
        """No scanline is left; whether words are copied was settled before."""
        self.coming = []
        self.lines = [None] * len(self.lines)


def span_words(dut: Any) -> tuple[int, ...]:
    """The span at the output ports."""
    bits = [int(getattr(dut, f"span_{name}").value) for name in ("last", "mirror")]
    words = [int(getattr(dut, f"span_{name}").value) for name in ("y", "column", "count")]
    return tuple(bits + words)


def expected_words(line: Scanline, column_bits: int) -> tuple[int, ...]:
    """The same from the model."""
    count = line.count % (1 << column_bits)
    return int(line.last), int(line.mirror), line.y, line.column, count


def check_outputs(bench: Bench, stages: Stages, enable: bool, index: int, inputs: Any) -> None:
    """Every output of this cycle."""
    dut = bench.dut
    last = stages.lines[-1]
    flags = {
        "busy": stages.busy,
        "setup_ready": enable and stages.can_take,
        "words_pending": stages.first(0),
        "words_copy": stages.copy,
        "channel_first_coming": stages.first(1),
        "span_coming": bool(stages.lines[-2] and stages.lines[-2].pixels),
        "span_valid": bool(last and last.pixels),
    }
    for name, expected in flags.items():
        bench.check(name, bool(getattr(dut, name).value), expected, index, inputs)
    if stages.lines[2]:
        bench.check("channel_carry", int(dut.channel_carry.value), stages.lines[2].carry, index, inputs)
    if last and last.pixels:
        expected = expected_words(last, stages.column_bits)
        bench.check("last, mirror, y, column, count", span_words(dut), expected, index, inputs)


async def compare(bench: Bench, source: str, sink: str, resets: Iterator[bool]) -> tuple[int, int]:
    """Every port in every cycle; cycles from the first primitive to the last, and scanlines."""
    dut = bench.dut
    await bench.start("enable", "setup_valid", *PORTS)
    offers, enables = SPEEDS[source](bench.draw), SPEEDS[sink](bench.draw)
    formats = bench.config.formats
    stages = Stages(bench.config)
    fields: dict[str, int] | None = None
    offered, index, rows = False, 0, 0
    first_take = last_take = 0
    while index < PRIMITIVES or stages.busy or stages.coming:
        if not offered and index < PRIMITIVES and next(offers):
            offered = True
            fields = random_fields(formats, bench.rng, sized=0.8)
            fields = sharpened(bench, fields) if bench.chance(0.5) else fields
            for port in PORTS:
                getattr(dut, port).value = fields[port.removeprefix("setup_")]
        enable, reset = next(enables), next(resets)
        dut.reset.value = int(reset)
        dut.enable.value = int(enable)
        dut.setup_valid.value = int(offered)
        await bench.edge()
        check_outputs(bench, stages, enable, index, fields)
        taken = None
        if offered and enable and stages.can_take:
            taken = list(walk_edges(fields, formats))
            index += 1
            offered = False
            first_take = first_take or bench.cycle
            last_take = bench.cycle
            if index < PRIMITIVES:
                rows += max(len(taken), LEAST_APART)
        stages.clock(enable, taken)
        if reset:
            stages.reset()
    return last_take - first_take, rows


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(source=list(SPEEDS), sink=list(SPEEDS))
async def every_cycle(dut: Any, source: str, sink: str) -> None:
    bench = Bench(dut, Config, f"every_cycle {source} {sink}")
    cycles, rows = await compare(bench, source, sink, repeat(False))
    if source == sink == "full_speed":
        # A scanline in every cycle, no bubble at the middle vertex or between primitives.
        bench.check("cycles from first to last primitive", cycles, rows)
    bench.finish(at_least=10 * PRIMITIVES)


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(source=list(SPEEDS), sink=list(SPEEDS))
async def resets(dut: Any, source: str, sink: str) -> None:
    """A reset forgets the primitive that is walked, and every scanline on its way."""
    bench = Bench(dut, Config, f"resets {source} {sink}")
    await compare(bench, source, sink, at_random(bench.draw, 10))
    bench.finish(at_least=10 * PRIMITIVES)
