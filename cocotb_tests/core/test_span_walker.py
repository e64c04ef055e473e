# SPDX-License-Identifier: Apache-2.0
"""Spans to pixels against the model, every port in every cycle."""

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
from quadshade.contract.formats import Formats
from quadshade.golden.core.edge_walker import Scanline
from quadshade.golden.core.span_walker import walk_span

PORTS = ("span_last", "span_mirror", "span_column", "span_y", "span_count")


@dataclass(frozen=True)
class Config:
    """What the generics of ``span_walker`` follow from."""

    coord_bits: int = 12

    @cached_property
    def formats(self) -> Formats:
        return Formats(coord_bits=self.coord_bits)


CONFIGS = [Config(), Config(coord_bits=3), Config(coord_bits=6)]


@pytest.mark.parametrize("config", CONFIGS, ids=identifier)
def test_span_walker(config: Config) -> None:
    simulate("span_walker", config, {"coord_bits": config.coord_bits, "column_bits": config.coord_bits + 1})


def spans(bench: Bench) -> Iterator[Scanline]:
    """Spans of at least one pixel: single ones first, then all lengths."""
    longest = min(1 << bench.config.coord_bits, 90)
    lengths = [1, 1, 1, 2, 1, 3, 2, 2, longest]
    yield from spans_of(bench, lengths + bench.rng.integers(1, min(longest, 12), 100).tolist())


def spans_of(bench: Bench, lengths: list[int]) -> Iterator[Scanline]:
    """Spans of these lengths, and anything else about them."""
    coord_bits = bench.config.coord_bits
    column_bits = coord_bits + 1
    for length in lengths:
        # The count is pixels - 2; any odd negative one is a single pixel.
        count = length - 2 if length > 1 else -1 - 2 * bench.draw.randrange(0, 1 << (coord_bits - 1))
        yield Scanline(
            first=False,
            last=bench.chance(0.5),
            y=bench.bits(coord_bits),
            column=bench.bits(column_bits),
            count=count,
            carry=0,
            mirror=bench.chance(0.5),
        )


def words(span: Scanline, column_bits: int) -> tuple[int, ...]:
    """A span as it stands at the ports."""
    return int(span.last), int(span.mirror), span.column, span.y, span.count % (1 << column_bits)


async def compare(
    bench: Bench, source: str, sink: str, resets: Iterator[bool], lengths: list[int] | None = None
) -> tuple[int, int]:
    """Every port in every cycle; cycles, and pixels that were taken."""
    dut = bench.dut
    await bench.start("span_valid", "advance", *PORTS)
    offers, wants = SPEEDS[source](bench.draw), SPEEDS[sink](bench.draw)
    formats = bench.config.formats
    column_bits = formats.column_bits
    waiting = spans_of(bench, lengths) if lengths else spans(bench)
    offered: Scanline | None = None
    drawing: list[tuple[int, int, bool]] = []
    index, pixels, cycles, more = 0, 0, 0, True
    while more or drawing:
        if offered is None and more and next(offers):
            offered = next(waiting, None)
            more = offered is not None
        advance, reset = next(wants), next(resets)
        dut.reset.value = int(reset)
        dut.advance.value = int(advance)
        dut.span_valid.value = int(offered is not None)
        ports = words(offered, column_bits) if offered else tuple(bench.bits(1) for _ in PORTS)
        for name, word in zip(PORTS, ports, strict=True):
            getattr(dut, name).value = word
        await bench.edge()
        inputs = {"span": offered, "advance": advance, "pixels left": len(drawing)}
        wanted = len(drawing) <= 1
        bench.check("span_wanted", bool(dut.span_wanted.value), wanted, index, inputs)
        bench.check("span_ending", bool(dut.span_ending.value), len(drawing) == 2, index, inputs)
        if offered is not None:
            bench.check("span_single", bool(dut.span_single.value), offered.pixels == 1, index, inputs)
        bench.check("pixel_valid", bool(dut.pixel_valid.value), bool(drawing), index, inputs)
        if drawing:
            got = tuple(int(getattr(dut, f"pixel_{name}").value) for name in ("x", "y"))
            got += (bool(dut.pixel_last.value),)
            bench.check("pixel x, y, last", got, drawing[0], index, inputs)
            pixels += advance
        cycles += 1
        if advance:
            drawing = drawing[1:]
            if wanted and offered is not None:
                drawing = list(walk_span(offered, formats))
                offered = None
                index += 1
        if reset:
            drawing = []
    return cycles, pixels


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(source=list(SPEEDS), sink=list(SPEEDS))
async def every_cycle(dut: Any, source: str, sink: str) -> None:
    bench = Bench(dut, Config, f"every_cycle {source} {sink}")
    cycles, pixels = await compare(bench, source, sink, repeat(False))
    if source == sink == "full_speed":
        # A pixel in every cycle but the first, in which the first span is loaded, and the last.
        bench.check("cycles at full speed", cycles, pixels + 1)
    bench.finish(at_least=1000)


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def lengths_of_every_bit(dut: Any) -> None:
    """Counts of which each bit is set alone, up to the longest span."""
    bench = Bench(dut, Config, "lengths_of_every_bit")
    lengths = [min((1 << bit) + 2, 1 << bench.config.coord_bits) for bit in range(bench.config.coord_bits)]
    _, pixels = await compare(bench, "full_speed", "full_speed", repeat(False), lengths)
    bench.check("pixels", pixels, sum(lengths))
    bench.finish(at_least=sum(lengths))


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(source=list(SPEEDS), sink=list(SPEEDS))
async def resets(dut: Any, source: str, sink: str) -> None:
    """A reset ends a span at any of its pixels."""
    bench = Bench(dut, Config, f"resets {source} {sink}")
    await compare(bench, source, sink, at_random(bench.draw, 10))
    bench.finish(at_least=300)
