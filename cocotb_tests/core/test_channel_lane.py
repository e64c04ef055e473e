# SPDX-License-Identifier: Apache-2.0
"""A channel from words to output values against the model, within a core made of the units' models."""

from __future__ import annotations

from collections.abc import Iterator
from copy import deepcopy
from dataclasses import dataclass, field
from itertools import dropwhile, repeat
from typing import Any

import cocotb
import pytest

from cocotb_tests.support.bench import SPEEDS, Bench
from cocotb_tests.support.resets import at_random
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.contract.formats import DIFFERENCES, Formats
from quadshade.golden.clocks import WALK_STAGES
from quadshade.golden.common.skid_buffer import SkidBuffer
from quadshade.golden.core.channel_lane import ChannelLane
from quadshade.golden.core.lane_handshake import LaneHandshake, LaneInputs
from quadshade.golden.core.span_chain import SpanChain

PRIMITIVES = 60
LEAST_APART = 3
"""Stages between two primitives' first scanlines."""


@dataclass(frozen=True)
class Config:
    """Which of a core's channels the lane is, and the core's generics that it depends on."""

    channel: int = 0
    max_order: int = 2
    word_width: int = 32
    frac_bits: int = 22
    span_depth: int = Formats().span_depth

    @property
    def formats(self) -> Formats:
        return Formats(
            num_channels=1,
            max_order=self.max_order,
            word_width=self.word_width,
            frac_bits=self.frac_bits,
            span_depth=self.span_depth,
        )


CONFIGS = [
    Config(),
    Config(channel=1, span_depth=1),
    Config(max_order=1, word_width=24, frac_bits=14),
    Config(max_order=0, word_width=40, frac_bits=30, span_depth=4),
]


@pytest.mark.parametrize("config", CONFIGS, ids=identifier)
def test_channel_lane(config: Config) -> None:
    formats = config.formats
    generics = {
        "word_width": formats.word_width,
        "max_order": formats.channel_max_order[config.channel],
        "frac_bits": formats.channel_frac_bits[config.channel],
        "value_bits": formats.channel_value_bits[config.channel],
        "span_depth": formats.span_depth,
    }
    simulate("channel_lane", config, generics)


@dataclass
class Line:
    """A scanline: its primitive's words, the carry after it, its span's values (none: an empty span)."""

    words: list[int]
    first: bool
    carry: int
    values: list[int]


def words_at_edges(bench: Bench) -> list[int]:
    """A value where an output unit begins, or one below it, and steps of one: the lowest bits decide."""
    formats, channel = bench.config.formats, bench.config.channel
    whole = bench.bits(formats.channel_value_bits[channel]) << formats.channel_frac_bits[channel]
    steps = [bench.draw.choice((-1, 0, 1)) for _ in DIFFERENCES[1:]]
    return [word % (1 << formats.word_width) for word in (whole - bench.bits(1), *steps)]


def scanlines(bench: Bench) -> Iterator[Line | None]:
    """Primitives with all kinds of spans, empty ones among them; None where the edge walker has a gap."""
    formats = bench.config.formats
    for index in range(PRIMITIVES):
        words = [bench.bits(formats.word_width) for _ in DIFFERENCES]
        if index % 2:
            words = words_at_edges(bench)
        lane = ChannelLane(words, bench.config.channel, formats)
        rows = 1 + index % 4 if index < 12 else bench.draw.randint(1, 12)
        longest = bench.draw.choice((1, 3, 9))
        for row in range(rows):
            carry = int(bench.chance(0.5))
            yield Line(words, row == 0, carry, list(lane.span(bench.draw.randint(0, longest))))
            lane.step(carry)
        # Often so many that all before is out: then pixels come behind bubbles, before a stalled output.
        yield from [None] * max(LEAST_APART - rows, bench.draw.choice((0, 0, 9)))


@dataclass
class Core:
    """What stands around the lane: edge walker's stages, chain, span walker, output."""

    lines: Iterator[Line | None]
    chain: SpanChain
    stages: list[Line | None] = field(default_factory=lambda: [None] * WALK_STAGES)
    handshake: LaneHandshake = field(default_factory=LaneHandshake)
    skid: SkidBuffer = field(default_factory=SkidBuffer)
    copy: bool = False
    drawing: list[int] = field(default_factory=list)
    clamped: int | None = None
    ended: bool = False

    @property
    def walked(self) -> list[int] | None:
        """The span in the edge walker's last stage; None if there is none, or an empty one."""
        return (self.stages[-1].values or None) if self.stages[-1] else None

    def inputs(self, emitted_ready: bool) -> LaneInputs:
        """What the lane's handshake sees in this cycle."""
        coming = self.stages[-2]
        waiting = self.chain.output
        after = deepcopy(self.chain)
        after.clock(self.walked, self.handshake.span_taken)
        return LaneInputs(
            walk_span_coming=bool(coming and coming.values),
            chain_full_next=all(stage is not None for stage in after.stages),
            span_valid=waiting is not None,
            span_single=waiting is not None and len(waiting) == 1,
            span_ending=len(self.drawing) == 2,
            clamped_valid=self.clamped is not None,
            emitted_valid=self.skid.front is not None,
            emitted_ready=emitted_ready,
        )

    def clock(self, inputs: LaneInputs) -> None:
        """One clock edge, downstream first."""
        state = self.handshake
        self.skid.clock(self.clamped, inputs.emitted_ready)
        if state.advance:
            self.clamped = self.drawing[0] if self.drawing else None
            self.drawing = list(self.chain.output or []) if state.load else self.drawing[1:]
        self.chain.clock(self.walked, state.span_taken)
        self.copy = False
        if state.walk:
            self.copy = bool(self.stages[0] and self.stages[0].first)
            line = next(self.lines, self)
            self.ended = line is self
            self.stages = [None if line is self else line, *self.stages[:-1]]
        state.clock(inputs)

    @property
    def busy(self) -> bool:
        held = any(stage is not None for stage in self.chain.stages)
        return held or any(self.stages) or bool(self.drawing) or self.clamped is not None or not self.ended


async def compare(bench: Bench, speed: str, resets: Iterator[bool]) -> None:
    """Every value in every cycle."""
    dut = bench.dut
    ports = (
        "walk_span_coming",
        "span_single",
        "span_ending",
        "clamped_valid",
        "emitted_valid",
        "emitted_ready",
    )
    await bench.start("setup_words", "setup_copy", "walk_first_coming", "walk_carry", *ports)
    wants = SPEEDS[speed](bench.draw)
    width, depth = bench.config.word_width, bench.config.span_depth
    lines = scanlines(bench)
    core = Core(lines, SpanChain(depth))
    index = 0
    while core.busy:
        inputs, reset = core.inputs(next(wants)), next(resets)
        dut.reset.value = int(reset)
        for port in ports:
            getattr(dut, port).value = int(getattr(inputs, port))
        copied, walked = core.stages[1], core.stages[2]
        dut.setup_copy.value = int(core.copy)
        words = copied.words if core.copy else [bench.bits(width) for _ in DIFFERENCES]
        dut.setup_words.value = sum(word << (difference * width) for difference, word in enumerate(words))
        dut.walk_first_coming.value = int(bool(copied and copied.first))
        dut.walk_carry.value = walked.carry if walked else int(bench.chance(0.5))
        await bench.edge()
        if core.clamped is not None:
            got = int(dut.clamped_value.value)
            bench.check("clamped_value", got, core.clamped, index, inputs)
            index += core.handshake.advance
        core.clock(inputs)
        if reset:
            # What was walked is gone: the next scanline is a primitive's first.
            ahead = dropwhile(lambda line: line is None or not line.first, lines)
            core = Core(ahead, SpanChain(depth), ended=core.ended)


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(speed=list(SPEEDS))
async def every_pixel(dut: Any, speed: str) -> None:
    bench = Bench(dut, Config, f"every_pixel {speed}")
    await compare(bench, speed, repeat(False))
    bench.finish(at_least=300)


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(speed=list(SPEEDS))
async def resets(dut: Any, speed: str) -> None:
    """A reset at any stage; the primitives behind it have their own colours."""
    bench = Bench(dut, Config, f"resets {speed}")
    await compare(bench, speed, at_random(bench.draw, 30))
    bench.finish(at_least=50)
