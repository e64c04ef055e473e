# SPDX-License-Identifier: Apache-2.0
"""The z-buffer against its model: every order and distance of overlapping pixels, clears, stalls."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise, permutations, product
from typing import Any

import cocotb
import pytest

from cocotb_tests.support.bench import SPEEDS, Bench, StreamSource
from cocotb_tests.support.resets import reset_amid
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.golden.screen.depth_test import DepthTest

PIXEL = ("x", "y", "value", "depth")
INPUTS = (
    "clear",
    "look",
    "look_enable",
    "look_address",
    "pixel_valid",
    *(f"pixel_{name}" for name in PIXEL),
)
LATENCY = 8
"""Clocks from a pixel's acceptance to the clock in which it stands at the output."""
READ_STAGES = 5
"""Enabled clocks from an address to its depth."""

Pixel = tuple[int, int, int, int]


@dataclass(frozen=True)
class Config:
    """Generics of ``depth_test``."""

    width: int = 20
    height: int = 12
    coord_bits: int = 6
    value_bits: int = 24
    depth_bits: int = 16


CONFIGS = [
    Config(),
    Config(width=8, height=8, coord_bits=3, value_bits=1, depth_bits=1),
    Config(width=1, height=1, coord_bits=3, value_bits=8, depth_bits=3),
    Config(width=64, height=2),
]


@pytest.mark.parametrize("config", CONFIGS, ids=identifier)
def test_depth_test(config: Config) -> None:
    simulate("depth_test", config)


class Screen:
    """A device under test, its source of pixels, what it keeps, and the model."""

    def __init__(self, bench: Bench, source: str) -> None:
        dut, config = bench.dut, bench.config
        self.bench = bench
        self.sent: list[Pixel] = []
        self.model = DepthTest(config.width, config.height, config.depth_bits)
        self.expected: list[Pixel] = []
        inputs, self.outputs = (
            [getattr(dut, f"{stream}_{name}") for name in PIXEL] for stream in ("pixel", "kept")
        )
        go = SPEEDS[source](bench.draw)
        self.source = StreamSource(dut.pixel_valid, dut.pixel_ready, inputs, (), go)
        self.kept: list[Pixel] = []
        self.kept_at: list[int] = []
        dut.look_enable.value = 1

    async def cycle(self) -> None:
        """Up to the next edge, with what is accepted at it given to the model."""
        self.source.drive()
        await self.bench.edge()
        waiting = self.source.waiting
        if self.source.sample(self.bench.cycle):
            self.sent.append(waiting)
            x, y, _, depth = waiting
            if self.model.test(x, y, depth):
                self.expected.append(waiting)
        if self.bench.dut.kept_valid.value:
            self.kept.append(tuple(int(signal.value) for signal in self.outputs))
            self.kept_at.append(self.bench.cycle)

    def offer(self, pixels: list[Pixel]) -> None:
        """Give the source more, once it is empty."""
        self.source.words = iter(pixels)
        self.source.waiting = next(self.source.words, None)

    async def drain(self) -> None:
        """No pixel more, until nothing can be on its way any more."""
        self.source.words = iter(())
        for _ in range(2 * LATENCY):
            await self.cycle()

    def compare(self) -> None:
        """Every pixel kept, none more, in their order."""
        self.bench.check_all("kept pixel", self.kept, self.expected)


async def look_at_all(screen: Screen, go: Iterator[bool]) -> None:
    """Every place's depth, while no pixel is taken."""
    bench, dut, model = screen.bench, screen.bench.dut, screen.model
    bench.check("idle", bool(dut.idle.value), True)
    dut.look.value, asked = 1, []
    await bench.edge()
    while len(asked) < len(model.stored) + READ_STAGES:
        moves = next(go)
        address = len(asked) if len(asked) < len(model.stored) else bench.draw.randrange(len(model.stored))
        dut.look_enable.value, dut.look_address.value = int(moves), address
        await bench.edge()
        bench.check("pixel_ready while looking", bool(dut.pixel_ready.value), False)
        if len(asked) >= READ_STAGES:
            depth = min(model.stored[asked[-READ_STAGES]], (1 << bench.config.depth_bits) - 1)
            bench.check("depth that is looked at", int(dut.look_depth.value), depth, asked[-READ_STAGES])
        if moves:
            asked.append(address)
    dut.look.value, dut.look_enable.value = 0, 1


async def begin(dut: Any, test: str) -> Bench:
    """Reset, and the fill that follows it."""
    bench = Bench(dut, Config, test)
    await bench.start(*INPUTS)
    words = bench.config.width * bench.config.height
    for index in range(words):
        await bench.edge()
        bench.check("busy in the fill after reset", bool(dut.busy.value), True, index)
        bench.check("pixel_ready in the fill", bool(dut.pixel_ready.value), False, index)
    await bench.edge()
    bench.check("busy after the fill", bool(dut.busy.value), False)
    return bench


def overlaps(bench: Bench) -> Iterator[list[Pixel]]:
    """
    Batches of pixels, a clear to be put between them: three of one place in every order of depth and at every
    distance up to beyond the pipeline's length, others between them; then crowds on few places.

    Three pixels are nearer than all before them in their batch, so that their own order decides.
    """
    config = bench.config
    most = (1 << config.depth_bits) - 1

    def at(address: int, depth: int) -> Pixel:
        address %= config.width * config.height
        value = bench.bits(config.value_bits)
        return address % config.width, address // config.width, value, max(0, min(depth, most))

    orders = [*permutations((0, 1, 2)), (1, 1, 1), (0, 1, 1), (1, 1, 0), (0, 0, 0)]
    cases = list(product(range(1, 9), range(1, 9), orders))
    room = max((most - 2) // 3, 1)
    if room < len(cases):
        cases = bench.draw.sample(cases, 20 * room)
    for begin in range(0, len(cases), room):
        batch = []
        for index, (first, second, order) in enumerate(cases[begin : begin + room]):
            place = bench.draw.randrange(config.width * config.height)
            base = most - 2 - 3 * index
            for depth, gap in zip(order, (first, second, 1), strict=True):
                batch.append(at(place, base + depth))
                batch += [at(place + step, base + bench.draw.randrange(3)) for step in range(1, gap)]
        yield batch
    for _ in range(4):
        batch = []
        for _ in range(200):
            x = bench.draw.randrange(3) if bench.chance(0.9) else bench.bits(config.coord_bits)
            y = bench.draw.randrange(2) if bench.chance(0.9) else bench.bits(config.coord_bits)
            batch.append((x, y, bench.bits(config.value_bits), bench.bits(config.depth_bits)))
        yield batch


@cocotb.test(timeout_time=2, timeout_unit="ms")
@cocotb.parametrize(source=list(SPEEDS), looks=list(SPEEDS))
async def every_overlap(dut: Any, source: str, looks: str) -> None:
    bench = await begin(dut, f"every_overlap {source} {looks}")
    screen = Screen(bench, source)
    for batch in overlaps(bench):
        begin_at = len(screen.sent)
        screen.offer(batch)
        while not screen.source.empty:
            await screen.cycle()
        if source == "full_speed":
            # No order and no distance costs a clock.
            times = screen.source.accepted_at[begin_at:]
            bench.check("clocks between pixels", {b - a for a, b in pairwise(times)} <= {1}, True)
        if begin_at == 0 or not bench.draw.randrange(8):
            await screen.drain()
            await look_at_all(screen, SPEEDS[looks](bench.draw))
        dut.clear.value = 1
        await screen.cycle()
        dut.clear.value = 0
        screen.model.clear()
        while dut.busy.value:
            await screen.cycle()
    await screen.drain()
    screen.compare()
    accepted_at = screen.source.accepted_at[screen.sent.index(screen.expected[0])]
    bench.check("latency", screen.kept_at[0] - accepted_at, LATENCY)
    bench.finish(at_least=20)


@cocotb.test(timeout_time=2, timeout_unit="ms")
@cocotb.parametrize(source=list(SPEEDS))
async def clear_forgets_what_was_before(dut: Any, source: str) -> None:
    """A clear amid pixels: those accepted with it are before it, and leave before `drained`."""
    bench = await begin(dut, f"clear_forgets_what_was_before {source}")
    words = bench.config.width * bench.config.height
    screen = Screen(bench, source)
    screen.offer([pixel for batch in overlaps(bench) for pixel in batch])
    for _ in range(6):
        for _ in range(bench.draw.randrange(40)):
            await screen.cycle()
        dut.clear.value = 1
        await screen.cycle()
        bench.check("busy before the clear", bool(dut.busy.value), False)
        # A second request while busy is not heard.
        dut.clear.value = int(bench.chance(0.5))
        screen.model.clear()
        drained_at, ended_at, drains = None, None, 0
        while ended_at is None:
            await screen.cycle()
            if dut.drained.value:
                drains += 1
                drained_at = bench.cycle
                bench.check("pixels taken before drained", len(screen.kept), len(screen.expected))
            if not dut.busy.value:
                ended_at = bench.cycle
            else:
                bench.check("pixel_ready while busy", bool(dut.pixel_ready.value), False)
                if drained_at is not None:
                    dut.clear.value = 0
        bench.check("drained pulses", drains, 1)
        bench.check("clocks of the fill", ended_at - drained_at, words + 1)
    await screen.drain()
    screen.compare()
    bench.finish(at_least=20)


@cocotb.test(timeout_time=2, timeout_unit="ms")
@cocotb.parametrize(source=list(SPEEDS))
async def resets(dut: Any, source: str) -> None:
    """A reset amid pixels, a look or a clear forgets every pixel and depth; its fill comes first."""
    bench = await begin(dut, f"resets {source}")
    words = bench.config.width * bench.config.height
    batches = list(overlaps(bench))

    async def work() -> None:
        await bench.edge()
        while dut.busy.value:
            bench.check("kept_valid in the fill", bool(dut.kept_valid.value), False)
            await bench.edge()
        screen = Screen(bench, source)
        for _ in range(2):
            batch = bench.draw.choice(batches)
            first = bench.draw.randrange(len(batch))
            screen.offer(batch[first : first + 20])
            while not screen.source.empty:
                await screen.cycle()
            dut.clear.value = 1
            await screen.cycle()
            dut.clear.value = 0
            screen.model.clear()
            while dut.busy.value:
                await screen.cycle()
        screen.offer(bench.draw.choice(batches)[:20])
        while not screen.source.empty:
            await screen.cycle()
        await screen.drain()
        screen.compare()
        await look_at_all(screen, SPEEDS[source](bench.draw))
        # As a reset does, for the work behind this.
        dut.clear.value = 1
        await bench.edge()
        dut.clear.value = 0
        await bench.edge()

    events = ("pixel_valid", "kept_valid", "look", "clear", "drained")
    await reset_amid(bench, work, events, 20 if words < 100 else 10, quiet=("kept_valid", "idle"))
    bench.finish(at_least=200)
