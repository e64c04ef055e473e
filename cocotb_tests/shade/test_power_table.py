# SPDX-License-Identifier: Apache-2.0
"""A cosine through a curve against the model: every value of a narrow lane, all octaves of a wide one."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Any

import cocotb
import pytest

from cocotb_tests.support.bench import SPEEDS, Bench
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.contract.formats import POWER_STAGES, TABLE_WORDS, Formats
from quadshade.contract.shade_state import curve_table, power_curve
from quadshade.golden.shade.power_table import power_table

EXHAUSTIVE_BITS = 10


@dataclass(frozen=True)
class Config:
    """Generics of ``power_table``."""

    lane_value_bits: int = 18

    @property
    def formats(self) -> Formats:
        """Formats of a core with such a lane."""
        return Formats(with_shade=1, value_bits=4, shade_guard_bits=self.lane_value_bits - 4, frac_bits=20)


CONFIGS = [Config(), Config(lane_value_bits=8), Config(lane_value_bits=9), Config(lane_value_bits=13)]


@pytest.mark.parametrize("config", CONFIGS, ids=identifier)
def test_power_table(config: Config) -> None:
    simulate("power_table", config)


def values(bench: Bench) -> list[int]:
    """Every value, or those around the octaves' ends and random ones of all sizes."""
    bits = bench.config.lane_value_bits
    full = (1 << bits) - 1
    if bits <= EXHAUSTIVE_BITS:
        return list(range(full + 1))
    near = [full - far for place in range(bits) for far in range((1 << place) - 2, (1 << place) + 3)]
    wide = [full - (bench.draw.getrandbits(bits) >> bench.draw.randrange(bits)) for _ in range(1500)]
    return [value for value in near if 0 <= value <= full] + wide


async def load(dut: Any, bench: Bench, table: list[int]) -> None:
    """Write a table, words in any order."""
    for address in bench.draw.sample(range(len(table)), len(table)):
        dut.write_enable.value = 1
        dut.write_address.value = address
        dut.write_data.value = table[address]
        await bench.edge()
    dut.write_enable.value = 0
    await bench.edge()


@cocotb.test(timeout_time=2, timeout_unit="ms")
@cocotb.parametrize(curve=["random", "power"], speed=list(SPEEDS))
async def every_octave(dut: Any, curve: str, speed: str) -> None:
    bench = Bench(dut, Config, f"every_octave {curve} {speed}")
    formats = bench.config.formats
    await bench.start("advance", "value", "write_enable", "write_address", "write_data", reset=False)
    if curve == "random":
        table = [bench.bits(32) for _ in range(TABLE_WORDS)]
    else:
        table = curve_table(power_curve(37.5), formats).tolist()
    await load(dut, bench, table)
    moves, waiting = SPEEDS[speed](bench.draw), deque()
    stimulus = values(bench)
    index = 0
    while index < len(stimulus) or len(waiting) == POWER_STAGES:
        offered = stimulus[index] if index < len(stimulus) else None
        dut.value.value = offered or 0
        advance = next(moves)
        dut.advance.value = int(advance)
        await bench.edge()
        # What stands there before this edge went in so many enabled edges ago.
        if len(waiting) == POWER_STAGES:
            value, expected = waiting[0]
            bench.check("power", int(dut.power.value), expected, None, f"value {value:#x}")
            if advance:
                waiting.popleft()
        if advance and offered is not None:
            waiting.append((offered, power_table(offered, table, formats)))
            index += 1
    bench.finish(at_least=len(stimulus) - POWER_STAGES)
