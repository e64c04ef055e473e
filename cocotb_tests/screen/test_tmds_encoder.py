# SPDX-License-Identifier: Apache-2.0
"""The TMDS encoder against its model: every byte in every disparity that lines bring, and control words."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Any

import cocotb
import pytest

from cocotb_tests.support.bench import SPEEDS, Bench
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.golden.screen.tmds_encoder import TmdsEncoder, decode

LATENCY = 4


@dataclass(frozen=True)
class Config:
    """``tmds_encoder`` has no generics."""


@pytest.mark.parametrize("config", [Config()], ids=identifier)
def test_tmds_encoder(config: Config) -> None:
    simulate("tmds_encoder", config)


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(speed=list(SPEEDS))
async def every_byte(dut: Any, speed: str) -> None:
    bench = Bench(dut, Config, f"every_byte {speed}")
    await bench.start("enable", "active", "value", "control", reset=False)
    go, model = SPEEDS[speed](bench.draw), TmdsEncoder()
    # Bytes of every kind, long runs of one of them among them, between stretches of control words.
    values = [None] * 3 + [value for value in range(256) for _ in range(3)]
    for _ in range(30):
        values += [None] * bench.draw.randrange(1, 4)
        values += bench.draw.choices(range(256), k=40) + [bench.draw.randrange(256)] * 20
    coming: deque[tuple[int | None, int]] = deque()
    disparities = set()
    for value in values:
        control = bench.bits(2)
        dut.active.value, dut.value.value = int(value is not None), value or 0
        dut.control.value = control
        while True:
            moves = next(go)
            dut.enable.value = int(moves)
            await bench.edge()
            if len(coming) == LATENCY:
                shown, word = coming[0]
                bench.check("word", int(dut.word.value), word, shown)
                if shown is not None:
                    bench.check("byte of the word", decode(word), shown)
            if moves:
                break
        coming.append((value, model.encode(value, control)))
        disparities.add(model.disparity)
        if len(coming) > LATENCY:
            coming.popleft()
    bench.check("disparity stays small", max(map(abs, disparities)) <= 8, True)
    bench.check("and is of every kind", len(disparities) > 6, True)
    bench.finish(at_least=2000)
