# SPDX-License-Identifier: Apache-2.0
"""
Resets at every stage of a unit's work, at random; two ways, by how the unit's test is written.

A test that sends something through the unit has its body in a function ``work`` that makes new drivers,
monitors and models, and is one line longer::

    await reset_amid(bench, work, events=("line_valid", ("byte_valid", "byte_ready")), quiet=("busy",))

A test that compares with its model in every cycle takes the reset from an iterator, and gives the model's
state anew where that said so::

    resets = at_random(bench.draw)
    dut.reset.value = int(next(resets))
"""

from __future__ import annotations

import random
from collections.abc import Awaitable, Callable, Iterator, Sequence
from contextlib import suppress
from itertools import repeat
from typing import Any

from cocotb.triggers import FallingEdge

from cocotb_tests.support.bench import Bench, WorkCut

LENGTHS = (1, 1, 1, 2, 7)
"""Cycles of a reset: one must be enough, and a long one is no other."""

Event = str | tuple[str, ...]
"""A port that is high, or several in the same cycle."""


def at_random(draw: random.Random, cycles: int = 150) -> Iterator[bool]:
    """Whether to reset, cycle by cycle: about every so many cycles, sometimes soon after the last one."""
    while True:
        yield from repeat(False, draw.choice((draw.randint(1, 8), draw.randint(1, 2 * cycles))))
        yield from repeat(True, draw.choice(LENGTHS))


def _ports_of(bench: Bench, event: Event) -> list[Any]:
    """Handles of an event's ports."""
    return [getattr(bench.dut, name) for name in ((event,) if isinstance(event, str) else event)]


class _Watch:
    """Counts every event of some work, and resets nothing."""

    def __init__(self, bench: Bench, events: Sequence[Event]) -> None:
        self.bench = bench
        self.ports = {event: _ports_of(bench, event) for event in events}
        self.counts = dict.fromkeys(events, 0)

    async def __call__(self) -> bool:
        """Before an edge."""
        # The inputs of this cycle are set; what follows from them stands there in its second half.
        await FallingEdge(self.bench.dut.clk)
        for event, ports in self.ports.items():
            self.counts[event] += all(int(port.value) for port in ports)
        return False


class _Cut:
    """
    Resets the unit in one cycle: with the ``count``-th event (None: in the cycle of that number), or
    ``delay`` cycles later.
    """

    def __init__(self, bench: Bench, event: Event | None, count: int, delay: int = 0) -> None:
        self.bench, self.ports = bench, _ports_of(bench, event) if event else []
        self.count, self.delay = count, delay
        self.done = False

    async def __call__(self) -> bool:
        """Before an edge: whether the unit is reset there."""
        if self.count > 0:
            if self.ports:
                await FallingEdge(self.bench.dut.clk)
            self.count -= all(int(port.value) for port in self.ports)
            if self.count > 0:
                return False
        self.delay -= 1
        if self.delay >= 0:
            return False
        self.bench.dut.reset.value = 1
        self.done = True
        return True


async def reset_amid(
    bench: Bench,
    work: Callable[[], Awaitable[None]],
    events: Sequence[Event] = (),
    rounds: int = 24,
    quiet: Sequence[str] = (),
) -> None:
    """
    Reset a unit in the middle of its work, and let it do work to the end, many times.

    Parameters
    ----------
    bench : Bench
      After ``start``, which was given the unit's inputs: they stay as they are in the cycles of the reset,
      and are zero after it. The reset comes in the cycle of an event, soon after one, or in any cycle.
    work : coroutine function
      Finds the unit as a reset has left it, makes new drivers, monitors and models, sends, and compares;
      time passes in ``bench.edge`` alone, and no task is left behind where that raises. What a reset keeps
      is the function's to know. Short work meets more stages in the same time.
    events : sequence of Event
      Each must come in the first work.
    rounds : int
      Resets.
    quiet : sequence of str
      Ports that are low in the cycle after a reset, as long as the inputs are zero.
    """
    draw, begin = bench.draw, bench.cycle
    watch = _Watch(bench, events)
    bench.resets_now = watch
    await work()
    bench.resets_now = None
    cycles = bench.cycle - begin
    for event, count in watch.counts.items():
        bench.check(f"{event} came", count > 0, True)
    await bench.reset()
    bench.rest()
    kinds: list[Event | None] = [None, *events]
    for index in range(max(rounds, len(kinds))):
        event = kinds[index % len(kinds)]
        if event is None:
            cut = _Cut(bench, None, draw.choice((draw.randint(1, 12), draw.randint(1, cycles))))
        else:
            count = draw.randint(1, max(1, watch.counts[event]))
            cut = _Cut(bench, event, count, draw.choice((0, 0, 0, 1, 2)))
        bench.resets_now = cut
        with suppress(WorkCut):
            await work()
        bench.resets_now = None
        # That reset was one cycle long, unless the work ended before it.
        bench.dut.reset.value = 1
        for _ in range(draw.choice(LENGTHS) - cut.done):
            await bench.edge()
        bench.dut.reset.value = 0
        bench.rest()
        if quiet and bench.chance(0.5):
            await bench.edge()
            for name in quiet:
                bench.check(f"{name} after reset", int(getattr(bench.dut, name).value), 0, index, event)
        if bench.chance(0.8):
            await work()
            await bench.reset()
            bench.rest()
    await work()
