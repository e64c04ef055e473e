# SPDX-License-Identifier: Apache-2.0
"""Channels to colours against the model: every pixel in order, states between them, latency."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import cocotb
import numpy as np
import pytest

from cocotb_tests.support.bench import SPEEDS, UNKNOWN, Bench, StreamSink, StreamSource
from cocotb_tests.support.resets import reset_amid
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.contract.formats import COEFFICIENT_FRAC_BITS, FACTOR_BITS, Formats
from quadshade.contract.shade_state import ShadeState, colour_state, power_curve, shade_state
from quadshade.golden.shade.shade import factors, products, shade
from tests.support.shade_stimuli import random_state, random_values

INPUTS = ("state_valid", "state_address", "state_data", "pixel_valid", "pixel_value", "pixel_along")


@dataclass(frozen=True)
class Config:
    """Generics of ``shade``."""

    num_channels: int = 2
    num_specular: int = 1
    value_bits: int = 8
    shade_guard_bits: int = 10
    along_bits: int = 41

    @property
    def formats(self) -> Formats:
        """Formats of a core with this unit."""
        return Formats(
            with_shade=1,
            num_channels=self.num_channels,
            num_specular=self.num_specular,
            value_bits=self.value_bits,
            shade_guard_bits=self.shade_guard_bits,
            frac_bits=16,
        )


CONFIGS = [
    Config(),
    Config(num_channels=1, value_bits=4, shade_guard_bits=4, along_bits=1),
    Config(num_channels=3, num_specular=3, shade_guard_bits=4, along_bits=5),
    Config(num_channels=5, num_specular=2, value_bits=12, shade_guard_bits=6),
    Config(num_channels=8, num_specular=4, shade_guard_bits=4, along_bits=17),
]


@pytest.mark.parametrize("config", CONFIGS, ids=identifier)
def test_shade(config: Config) -> None:
    simulate("shade", config)


class Unit:
    """The unit with its three streams, and what must come out."""

    def __init__(self, bench: Bench, source: str, sink: str) -> None:
        dut = bench.dut
        self.bench, self.formats = bench, bench.config.formats
        self.expected: list[tuple[int, int]] = []
        self.latest = colour_state(self.formats)
        pixel = [dut.pixel_value, dut.pixel_along]
        self.source = StreamSource(dut.pixel_valid, dut.pixel_ready, pixel, (), SPEEDS[source](bench.draw))
        state = [dut.state_address, dut.state_data]
        self.writes = StreamSource(dut.state_valid, dut.state_ready, state, (), SPEEDS[source](bench.draw))
        shaded = [dut.shaded_value, dut.shaded_along]
        self.sink = StreamSink(bench, dut.shaded_valid, dut.shaded_ready, shaded, SPEEDS[sink](bench.draw))

    @property
    def on_their_way(self) -> int:
        """Pixels that are in the unit."""
        return len(self.source.accepted_at) - len(self.sink.words)

    async def cycle(self) -> None:
        """Up to the next edge; busy and the state's ready say whether a pixel is in the unit."""
        self.source.drive()
        self.writes.drive()
        self.sink.drive()
        await self.bench.edge()
        dut = self.bench.dut
        self.bench.check("busy", bool(dut.busy.value), self.on_their_way > 0)
        self.bench.check("state_ready", bool(dut.state_ready.value), self.on_their_way == 0)
        self.source.sample(self.bench.cycle)
        self.writes.sample(self.bench.cycle)
        taken = len(self.sink.words)
        self.sink.sample(self.bench.cycle)
        for word, expected in zip(self.sink.words[taken:], self.expected[taken:], strict=False):
            self.bench.check("pixel (colour, along)", word, expected, taken)

    def load(self, state: ShadeState, tables: bool = True) -> None:
        """Offer a state's words, or those of its registers alone, and some that have no place."""
        unused = [(1 << 13, 0xFFFFFFFF), (1 << 31 | 4128, 7), (4096 + 3, 0xFFFFFFFF), (4200, 5)]
        words = [(address, word) for address, word in state.writes().tolist() if tables or address >= 4096]
        words += unused
        self.bench.draw.shuffle(words)
        self.writes.words = iter(words)
        self.writes.waiting = next(self.writes.words)
        self.latest = state if tables else dataclasses.replace(state, tables=self.latest.tables)

    def offer(self, count: int) -> None:
        """Offer pixels of any values."""
        self.offer_values(random_values(self.formats, self.bench.rng, count).tolist())

    def offer_values(self, pixels: list[list[int]]) -> None:
        """Offer pixels, to be shaded with the latest state."""
        config, words = self.bench.config, []
        lane = config.value_bits + config.shade_guard_bits
        for values in pixels:
            along = self.bench.bits(config.along_bits)
            words.append((sum(value << (lane * channel) for channel, value in enumerate(values)), along))
            colour = shade(values, self.latest, self.formats)
            shaded = sum(part << (config.value_bits * place) for place, part in enumerate(colour))
            self.expected.append((shaded, along))
        self.source.words = iter(words)
        self.source.waiting = next(self.source.words, None)

    async def settle(self) -> None:
        """Until all that was offered is through."""
        while not (self.source.empty and self.writes.empty) or self.on_their_way:
            await self.cycle()

    def finish(self) -> None:
        """Every pixel, none more, in their order."""
        self.bench.check("number of pixels", len(self.sink.words), len(self.expected))
        self.bench.finish(at_least=len(self.expected))


# A reset keeps what the host wrote, so only power-up sets the first state.
@cocotb.test(timeout_time=3, timeout_unit="ms", skip=UNKNOWN)
async def without_a_state_channels_are_the_colour(dut: Any) -> None:
    """From power-up on: this test is the first of a simulation."""
    bench = Bench(dut, Config, "without_a_state_channels_are_the_colour")
    await bench.start(*INPUTS, "shaded_ready")
    unit = Unit(bench, "full_speed", "full_speed")
    unit.offer(60)
    await unit.settle()
    unit.finish()


@cocotb.test(timeout_time=3, timeout_unit="ms")
@cocotb.parametrize(source=list(SPEEDS), sink=list(SPEEDS))
async def every_pixel(dut: Any, source: str, sink: str) -> None:
    """States as a host makes them, and any."""
    bench = Bench(dut, Config, f"every_pixel {source} {sink}")
    await bench.start(*INPUTS, "shaded_ready")
    unit = Unit(bench, source, sink)
    formats = unit.formats
    unit.load(random_state(formats, bench.rng))
    await unit.settle()
    unit.offer(40)
    await unit.settle()
    latency = unit.sink.taken_at[0] - unit.source.accepted_at[0]
    if source == sink == "full_speed":
        bench.check("latency", latency, formats.shade_stages + 1)
        times = unit.source.accepted_at
        bench.check("clocks of the pixels", times[-1] - times[0], len(times) - 1)
    for _ in range(2):
        unit.load(random_state(formats, bench.rng), tables=False)
        await unit.settle()
        unit.offer(100)
        await unit.settle()
    if source == sink == "full_speed":
        coefficients = bench.rng.uniform(0, 1.2, (formats.num_channels, 3))
        curves = [power_curve(5 + 40 * index) for index in range(formats.num_specular)]
        unit.load(shade_state(formats, [0.1, 0, 1], coefficients, curves, (1 << formats.num_specular) - 1))
        await unit.settle()
        unit.offer(200)
        await unit.settle()
    unit.load(colour_state(formats), tables=False)
    await unit.settle()
    unit.offer(50)
    await unit.settle()
    unit.finish()


@cocotb.test(timeout_time=3, timeout_unit="ms")
async def sums_at_the_largest(dut: Any) -> None:
    """Every channel and coefficient at full scale, with an ambient colour that carries the sum further."""
    bench = Bench(dut, Config, "sums_at_the_largest")
    await bench.start(*INPUTS, "shaded_ready")
    unit, formats = Unit(bench, "full_speed", "full_speed"), bench.config.formats
    lane = (1 << formats.lane_value_bits) - 1
    for bit in range(formats.value_bits + COEFFICIENT_FRAC_BITS):
        state = random_state(formats, bench.rng)
        state.ambient[:] = 1 << bit
        state.coefficients[:] = (1 << FACTOR_BITS) - 1
        unit.load(dataclasses.replace(state, linear=(1 << formats.num_specular) - 1, gated=0), tables=False)
        await unit.settle()
        unit.offer_values([[lane] * formats.num_channels, [lane - 1] * formats.num_channels])
        await unit.settle()
    unit.finish()


@cocotb.test(timeout_time=3, timeout_unit="ms")
async def the_lowest_bits_decide(dut: Any) -> None:
    """Sums on the border of two colours, or one below it: a unit of a product or of the ambient one shows."""
    bench = Bench(dut, Config, "the_lowest_bits_decide")
    await bench.start(*INPUTS, "shaded_ready")
    unit, formats = Unit(bench, "full_speed", "full_speed"), bench.config.formats
    unit.load(random_state(formats, bench.rng))
    await unit.settle()
    top = (1 << formats.value_bits) - 1
    for _ in range(40):
        state = dataclasses.replace(random_state(formats, bench.rng), tables=unit.latest.tables)
        most = (1 << (COEFFICIENT_FRAC_BITS - 1)) // formats.num_channels
        state.coefficients[:] = bench.rng.integers(0, most, state.coefficients.shape)
        (pixel,) = random_values(formats, bench.rng, 1).tolist()
        parts = zip(factors(pixel, state, formats), state.coefficients.tolist(), strict=True)
        sums = np.sum([products(factor, row, formats) for factor, row in parts], axis=0)
        wholes = [bench.draw.randint(1 + (part >> COEFFICIENT_FRAC_BITS), top) for part in sums.tolist()]
        state.ambient[:] = (np.array(wholes) << COEFFICIENT_FRAC_BITS) - bench.bits(1) - sums
        unit.load(state, tables=False)
        await unit.settle()
        unit.offer_values([pixel])
        await unit.settle()
    unit.finish()


@cocotb.test(timeout_time=3, timeout_unit="ms")
@cocotb.parametrize(sink=list(SPEEDS))
async def state_waits_for_the_last_pixel(dut: Any, sink: str) -> None:
    """A state that is offered amid pixels changes none of them, and all those that follow at once."""
    bench = Bench(dut, Config, f"state_waits_for_the_last_pixel {sink}")
    await bench.start(*INPUTS, "shaded_ready")
    unit = Unit(bench, "full_speed", sink)
    unit.load(random_state(unit.formats, bench.rng))
    await unit.settle()
    for _ in range(3):
        unit.offer(30)
        while len(unit.source.accepted_at) % 30 < 3:
            await unit.cycle()
        unit.load(random_state(unit.formats, bench.rng), tables=False)
        while not unit.writes.empty:
            await unit.cycle()
    unit.offer(30)
    await unit.settle()
    unit.finish()


@cocotb.test(timeout_time=3, timeout_unit="ms")
@cocotb.parametrize(sink=list(SPEEDS))
async def resets(dut: Any, sink: str) -> None:
    """Pixels on their way are gone, at any stage; the state stays."""
    bench = Bench(dut, Config, f"resets {sink}")
    await bench.start(*INPUTS, "shaded_ready")
    state = random_state(bench.config.formats, bench.rng)
    unit = Unit(bench, "full_speed", "full_speed")
    unit.load(state)
    await unit.settle()

    async def work() -> None:
        unit = Unit(bench, "full_speed", sink)
        unit.latest = state
        unit.offer(24)
        await unit.settle()
        bench.check("number of pixels", len(unit.sink.words), len(unit.expected))

    await reset_amid(bench, work, ("pixel_valid", "shaded_valid"), 16, quiet=("shaded_valid", "busy"))
    bench.finish(at_least=200)
