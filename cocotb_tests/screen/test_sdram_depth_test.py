# SPDX-License-Identifier: Apache-2.0
"""
The z-buffer in an SDRAM: behind it stand the controller's model and a chip that refuses.

What is in the chip in the end is compared with the model, place by place. Beside it another port reads.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import cocotb
import pytest

from cocotb_tests.support.bench import SPEEDS, Bench, StreamSource, full_speed
from cocotb_tests.support.resets import reset_amid
from cocotb_tests.support.sdram import Memory, words_of
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.golden.common.sdram_controller import Run, SdramGenerics
from quadshade.golden.screen.sdram_depth_test import DEPTH_PLANE, Pixel, SdramDepthTest, span_clocks

INPUTS = (
    *("plane", "clear_valid", "clear_value", "pixel_valid", "pixel_x", "pixel_y", "pixel_value"),
    *("pixel_depth", "run_ready", "read_valid", "read_data", "write_next"),
)


@dataclass(frozen=True)
class Config:
    """Generics of ``sdram_depth_test``."""

    width: int = 24
    height: int = 5
    coord_bits: int = 6
    value_bits: int = 16
    depth_bits: int = 15
    data_bits: int = 16
    run_words: int = 8


CONFIGS = [
    Config(),
    Config(width=64, height=3, coord_bits=7, run_words=32),
    Config(width=6, height=8, coord_bits=3, value_bits=5, depth_bits=3, data_bits=7, run_words=2),
]


@pytest.mark.parametrize("config", CONFIGS, ids=identifier)
def test_sdram_depth_test(config: Config) -> None:
    simulate("sdram_depth_test", config)


def memory_of(bench: Bench, beside: float) -> Memory:
    """The memory behind the unit."""
    config = bench.config
    generics = SdramGenerics(
        data_bits=config.data_bits, run_words=config.run_words, refresh_clocks=150, power_up_refreshes=2
    )
    return Memory(bench, generics, beside)


def in_chip(memory: Memory, model: SdramDepthTest) -> dict[tuple[int, int, int], int]:
    """The words of the chip, where the model has some."""
    words = words_of(memory.chip, memory.generics, (model.address(*place) for place in model.words))
    return dict(zip(model.words, words, strict=True))


def random_pixels(bench: Bench, count: int) -> Iterator[Pixel]:
    """Scanlines of triangles in both directions, some of one pixel, some over the screen's border."""
    config, draw = bench.config, bench.draw
    limit = 1 << config.coord_bits
    depth = draw.getrandbits(config.depth_bits)
    for _ in range(count):
        x = draw.randrange(config.width + 2)
        y = draw.randrange(min(config.height + 1, limit))
        step, length = (
            draw.choice((-1, 1)),
            draw.choice((1, 2, config.run_words, draw.randint(1, config.width))),
        )
        if bench.chance(0.3):
            depth = bench.bits(config.depth_bits)
        for _ in range(length):
            if 0 <= x < limit:
                yield Pixel(x, y, bench.bits(config.value_bits), depth)
            x += step


def source_of(bench: Bench, pixels: list[Pixel], speed: str) -> StreamSource:
    dut = bench.dut
    data = (dut.pixel_x, dut.pixel_y, dut.pixel_value, dut.pixel_depth)
    return StreamSource(dut.pixel_valid, dut.pixel_ready, data, pixels, SPEEDS[speed](bench.draw))


async def drawn(bench: Bench, speed: str, rounds: int, spans: int, beside: float) -> None:
    """A fill by reset, then pictures: each is compared whole."""
    dut, config = bench.dut, bench.config
    memory = memory_of(bench, beside)
    model = SdramDepthTest(config.width, config.height, config.depth_bits, config.data_bits, config.run_words)
    value = 0
    model.clear(value)
    for index in range(rounds):
        pixels = list(random_pixels(bench, spans))
        source = source_of(bench, pixels, speed)
        while True:
            source.drive()
            await memory.edge()
            source.sample(bench.cycle)
            if source.empty and dut.idle.value:
                break
        # What was accepted in that clock is on its way.
        while True:
            await memory.edge()
            if dut.idle.value:
                break
        for pixel in pixels:
            model.draw(pixel)
        got = in_chip(memory, model)
        bench.check_all("word", list(got.items()), list(model.words.items()), lambda _, index=index: index)
        # The other plane of values; the next picture begins with a fill of it, and of the depths.
        value = bench.bits(config.value_bits)
        model.plane = 1 - model.plane
        dut.plane.value, dut.clear_value.value, dut.clear_valid.value = model.plane, value, 1
        await memory.edge()
        bench.check("clear_ready", bool(dut.clear_ready.value), True, index)
        dut.clear_valid.value, dut.clear_value.value = 0, bench.bits(config.value_bits)
        model.clear(value)
    dut.plane.value, dut.clear_value.value = 0, 0


@cocotb.test(timeout_time=10, timeout_unit="ms")
@cocotb.parametrize(speed=list(SPEEDS))
async def pictures(dut: Any, speed: str) -> None:
    bench = Bench(dut, Config, f"pictures {speed}")
    await bench.start(*INPUTS)
    await drawn(bench, speed, 2, 30, 0.02)
    bench.finish(at_least=4 * bench.config.width * bench.config.height)


@cocotb.test(timeout_time=10, timeout_unit="ms")
async def resets(dut: Any) -> None:
    """Of the unit and its controller together; a fill begins anew."""
    bench = Bench(dut, Config, "resets")
    await bench.start(*INPUTS)

    async def work() -> None:
        await drawn(bench, "throttled", 1, 8, 0.02)

    await reset_amid(bench, work, events=("run_valid", "write_next", "read_valid"), rounds=6)
    bench.finish(at_least=100)


@cocotb.test(timeout_time=10, timeout_unit="ms")
async def runs(dut: Any) -> None:
    """Without gaps the runs are those of whole spans: depths read, and what is nearer written."""
    bench = Bench(dut, Config, "runs")
    await bench.start(*INPUTS)
    config, memory = bench.config, memory_of(bench, 0.0)
    model = SdramDepthTest(config.width, config.height, config.depth_bits, config.data_bits, config.run_words)
    model.clear(0)
    while not dut.idle.value:
        await memory.edge()
    fills = 2 * config.height * config.width // config.run_words
    bench.check("runs of a fill", len(memory.runs), fills)
    memory.runs.clear()
    memory.accepted.clear()
    # No refresh comes amid the spans whose clocks are counted.
    memory.controller.interval, memory.controller.due = 1 << 20, False
    pixels = list(random_pixels(bench, 40))
    expected = []
    for span in model.spans(pixels):
        left = min(span)
        before = dict(model.words)
        for pixel in span:
            model.draw(pixel)
        more = len(span) - 1
        depths = model.address(DEPTH_PLANE, left.y, left.x)
        expected.append(Run(depths, more))
        if before != model.words:
            expected += [Run(depths, more, True), Run(model.address(0, left.y, left.x), more, True)]
    source = StreamSource(
        dut.pixel_valid,
        dut.pixel_ready,
        (dut.pixel_x, dut.pixel_y, dut.pixel_value, dut.pixel_depth),
        pixels,
        full_speed(bench.draw),
    )
    while not (source.empty and dut.idle.value and not dut.pixel_valid.value):
        source.drive()
        await memory.edge()
        source.sample(bench.cycle)
    bench.check_all("run", memory.runs, expected)
    spans = [index for index, run in enumerate(memory.runs) if not run.write]
    for index, following in pairwise(spans):
        # The next span was there, as it was gathered while this one was moved.
        if following - index == 3:
            took = memory.accepted[following] - memory.accepted[index]
            words = memory.runs[index].more + 1
            bench.check("clocks of a span", took, span_clocks(words, memory.generics), index)
    bench.finish(at_least=100)
