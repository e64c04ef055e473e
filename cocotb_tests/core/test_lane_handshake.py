# SPDX-License-Identifier: Apache-2.0
"""The handshake's state against the model, every port in every cycle."""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields
from typing import Any

import cocotb
import pytest

from cocotb_tests.support.bench import Bench
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.golden.core.lane_handshake import LaneHandshake, LaneInputs

INPUTS = tuple(field.name for field in fields(LaneInputs))
CYCLES = 3000


@dataclass(frozen=True)
class Config:
    """The unit has no generics."""


@pytest.mark.parametrize("config", [Config()], ids=identifier)
def test_lane_handshake(config: Config) -> None:
    simulate("lane_handshake", config)


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def every_cycle(dut: Any) -> None:
    bench = Bench(dut, Config, "every_cycle")
    await bench.start(*INPUTS)
    model = LaneHandshake()
    for index in range(CYCLES):
        # Any input in any state, and a reset now and then.
        inputs = LaneInputs(**{name: bench.chance(0.5) for name in INPUTS})
        resets = bench.chance(0.02)
        for name, value in asdict(inputs).items():
            getattr(dut, name).value = int(value)
        dut.reset.value = int(resets)
        await bench.edge()
        outputs = {
            "walk": model.walk,
            "walked_valid": model.walked_valid,
            "span_taken": model.span_taken,
            "load": model.load,
            "advance": model.advance,
        }
        for name, expected in outputs.items():
            bench.check(name, bool(getattr(dut, name).value), expected, index, inputs)
        model.clock(inputs)
        if resets:
            model = LaneHandshake()
    bench.finish(at_least=5 * CYCLES)
