# SPDX-License-Identifier: Apache-2.0
"""
What the cocotb tests share: clock, replayable random numbers, stream driver and monitor, scoreboard.

A test drives, waits for the clock edge, and then looks at what stood there before it: :meth:`Bench.edge`.
"""

from __future__ import annotations

import json
import os
import random
import zlib
from collections.abc import Awaitable, Callable, Iterable, Iterator, Sequence
from itertools import repeat
from typing import Any

import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge

from cocotb_tests.support.simulation import NETLIST, identifier

PERIOD_NS = 10
UNKNOWN = NETLIST == "unknown"
UNKNOWN_CYCLES = 64
"""Of reset after a power-up that sets no register, for what no reset sets; a board's are 255."""
MAX_SHOWN = 600
"""Characters of a value in a failure's text."""

FAIL_FAST = bool(os.environ.get("QUADSHADE_FAIL_FAST"))
"""Whether the first wrong word ends its test: for runs that only ask whether one is wrong."""


def full_speed(draw: random.Random) -> Iterator[bool]:
    """Always on."""
    del draw
    return repeat(True)


def throttled(draw: random.Random) -> Iterator[bool]:
    """On and off in bursts, some of them long."""
    while True:
        for state in (True, False):
            yield from repeat(state, draw.randint(1, draw.choice((1, 3, 12))))


SPEEDS: dict[str, Callable[[random.Random], Iterator[bool]]] = {
    "full_speed": full_speed,
    "throttled": throttled,
}


class WorkCut(Exception):
    """The unit was reset in the middle of its work."""


class Bench:
    """
    One cocotb test of one unit.

    Parameters
    ----------
    dut : cocotb handle
    config_class : type
      Dataclass of the unit's configuration; the values come from the pytest function.
    test : str
      The test's name: it and the configuration choose the random numbers, with the seed.

    Attributes
    ----------
    draw, rng : random.Random, numpy Generator
      The test's random numbers: singly, and in arrays.
    resets_now : coroutine function or None
      Asked before each edge: whether it resets the unit there, which ends the work (``support/resets.py``).
    """

    resets_now: Callable[[], Awaitable[bool]] | None = None

    def __init__(self, dut: Any, config_class: type, test: str) -> None:
        self.dut = dut
        self.config = config_class(**json.loads(os.environ["QUADSHADE_CONFIG"]))
        self.name = f"{os.environ['QUADSHADE_UNIT']}[{identifier(self.config)}] {test}"
        self.seed = int(os.environ.get("QUADSHADE_SEED") or 1)
        self.rng = np.random.default_rng([self.seed, zlib.crc32(self.name.encode())])
        self.draw = random.Random(f"{self.name} {self.seed}")
        self.cycle = 0
        self.checked = 0
        self.wrong = 0
        self.first_fault = ""
        dut._log.info("%s, seed %d", self.name, self.seed)

    async def start(self, *inputs: str, reset: bool = True) -> None:
        """Set inputs to zero, start the clock and, where the unit has a reset, reset it."""
        self.inputs = inputs
        self.rest()
        Clock(self.dut.clk, PERIOD_NS, "ns").start(start_high=False)
        self._edge = RisingEdge(self.dut.clk)
        if reset:
            for _ in range(UNKNOWN_CYCLES if UNKNOWN else 1):
                await self.reset()
        else:
            await self.edge()

    @property
    def default(self) -> bool:
        """Whether this is the configuration without changes, which is tested at greatest length."""
        return bool(self.config == type(self.config)())

    def rest(self) -> None:
        """Set the inputs that :meth:`start` was given to zero."""
        for name in self.inputs:
            getattr(self.dut, name).value = 0

    async def edge(self) -> None:
        """
        Up to the next clock edge; what is read then is what stood there before it.

        Raises
        ------
        WorkCut
          The unit was reset at this edge.
        """
        cut = self.resets_now is not None and await self.resets_now()
        await self._edge
        self.cycle += 1
        if cut:
            raise WorkCut

    async def reset(self) -> None:
        """One cycle of reset: that must be enough."""
        self.dut.reset.value = 1
        await self.edge()
        self.dut.reset.value = 0

    def unqualified(self, signal: Any) -> int:
        """A value that nothing says is valid: any one, if no register was set at power-up."""
        value = signal.value
        return int(value) if value.is_resolvable or not UNKNOWN else 0

    def bits(self, width: int) -> int:
        """A random word; corners (zero, ones, the sign bit) more often than chance would have it."""
        if self.draw.random() < 0.6:
            return self.draw.getrandbits(width)
        return self.draw.choice((0, (1 << width) - 1, 1 << (width - 1), (1 << (width - 1)) - 1))

    def chance(self, probability: float) -> bool:
        """True that often."""
        return self.draw.random() < probability

    def check(self, what: str, got: Any, expected: Any, index: int | None = None, inputs: Any = None) -> None:
        """Count a word, and note the first that is wrong; :meth:`finish` fails the test."""
        self.checked += 1
        if got == expected:
            return
        self.wrong += 1
        if not self.first_fault:
            place = f"cycle {self.cycle}" if index is None else f"index {index} (cycle {self.cycle})"
            lines = [f"first wrong: {what} at {place}"]
            if inputs is not None:
                lines.append(f"  inputs:   {str(inputs)[:MAX_SHOWN]}")
            lines += [f"  got:      {str(got)[:MAX_SHOWN]}", f"  expected: {str(expected)[:MAX_SHOWN]}"]
            self.first_fault = "\n".join(lines)
        if FAIL_FAST:
            self.finish()

    def check_all(
        self,
        what: str,
        got: Sequence[Any],
        expected: Sequence[Any],
        inputs: Callable[[int], Any] | None = None,
    ) -> None:
        """Compare two sequences word by word; neither may have words left over."""
        for index, (one, other) in enumerate(zip(got, expected, strict=False)):
            self.check(what, one, other, index, inputs(index) if inputs and one != other else None)
        self.check(f"number of {what}s", len(got), len(expected))

    def finish(self, at_least: int = 1) -> None:
        """
        End the test.

        Raises
        ------
        AssertionError
          A word was wrong, or fewer than ``at_least`` were checked.
        """
        summary = f"{self.name}, seed {self.seed}: {self.wrong} of {self.checked} words wrong"
        if self.wrong:
            raise AssertionError(f"{summary}\n{self.first_fault}")
        if self.checked < at_least:
            raise AssertionError(f"{summary}, but {at_least} should have been checked")
        self.dut._log.info("%s", summary)


class StreamSource:
    """
    Drives an AXI4-Stream: valid, once up, stays with its data until the word is accepted.

    Parameters
    ----------
    valid, ready : cocotb handles
    data : sequence of cocotb handles
      One for every element of a word.
    words : iterable of tuples of int
    go : iterator of bool
      Whether to offer the next word now.
    """

    def __init__(
        self, valid: Any, ready: Any, data: Sequence[Any], words: Iterable[Sequence[int]], go: Iterator[bool]
    ) -> None:
        self.valid, self.ready, self.data = valid, ready, data
        self.words = iter(words)
        self.go = go
        self.waiting = next(self.words, None)
        self.offering = False
        self.accepted_at: list[int] = []
        valid.value = 0

    @property
    def empty(self) -> bool:
        """True if every word was accepted."""
        return self.waiting is None

    def drive(self) -> None:
        """Set the signals for the next edge."""
        if self.offering or self.waiting is None or not next(self.go):
            return
        self.offering = True
        self.valid.value = 1
        for signal, value in zip(self.data, self.waiting, strict=True):
            signal.value = value

    def sample(self, cycle: int) -> bool:
        """Look whether the word was accepted at this edge."""
        if not self.offering or not self.ready.value:
            return False
        self.accepted_at.append(cycle)
        self.waiting = next(self.words, None)
        self.offering = False
        self.valid.value = 0
        return True


class StreamSink:
    """
    Takes words from an AXI4-Stream and checks that an offered word stays until it is taken.

    Every second pause ends only where a word stands there, as a word must not wait for its ready; unless
    ``exact`` is set.

    Parameters
    ----------
    bench : Bench
    valid, ready : cocotb handles
    data : sequence of cocotb handles
    go : iterator of bool
      Whether to be ready.
    """

    def __init__(self, bench: Bench, valid: Any, ready: Any, data: Sequence[Any], go: Iterator[bool]) -> None:
        self.bench, self.valid, self.ready, self.data, self.go = bench, valid, ready, data, go
        self.words: list[tuple[int, ...]] = []
        self.taken_at: list[int] = []
        self.is_ready = False
        self.pauses, self.exact = 0, False
        self.held: tuple[int, ...] | None = None
        ready.value = 0

    def drive(self) -> None:
        """Set ready for the next edge."""
        wanted = next(self.go)
        if not (self.exact or self.is_ready) and self.pauses % 2 and self.held is None:
            wanted = False
        if wanted != self.is_ready:
            self.is_ready = wanted
            self.pauses += not wanted
            self.ready.value = int(wanted)

    def sample(self, cycle: int) -> None:
        """Take the word that stands there at this edge, if ready was given."""
        word = None
        if self.valid.value:
            word = tuple(int(signal.value) for signal in self.data)
        if self.held is not None and word != self.held:
            self.bench.check("word that waits for ready", word, self.held)
        self.held = word
        if word is not None and self.is_ready:
            self.words.append(word)
            self.taken_at.append(cycle)
            self.held = None
