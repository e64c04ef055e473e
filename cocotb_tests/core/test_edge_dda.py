# SPDX-License-Identifier: Apache-2.0
"""One edge's column, scanline by scanline, against the model, with edges back to back."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import cocotb
import pytest

from cocotb_tests.support.bench import SPEEDS, Bench
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.contract.formats import EDGE_FIELDS, Formats
from quadshade.golden.core.edge_dda import EdgeDda

LATENCY = 2
"""Enabled cycles from load to column; the carry comes one earlier."""


@dataclass(frozen=True)
class Config:
    """What the generics of ``edge_dda`` follow from."""

    coord_bits: int = 12
    subpixel_bits: int = 8

    @cached_property
    def formats(self) -> Formats:
        return Formats(coord_bits=self.coord_bits, subpixel_bits=self.subpixel_bits)


CONFIGS = [Config(), Config(coord_bits=3, subpixel_bits=0), Config(coord_bits=13, subpixel_bits=12)]


@pytest.mark.parametrize("config", CONFIGS, ids=identifier)
def test_edge_dda(config: Config) -> None:
    formats = config.formats
    generics = {"column_bits": formats.column_bits, "edge_bits": formats.edge_bits}
    simulate("edge_dda", config, generics)


def real_edge(bench: Bench, formats: Formats) -> tuple[dict[str, int], list[int]]:
    """Fields of an edge of random height and slope, and floor((m + k dx) / dy) for its scanlines."""
    height = bench.draw.randrange(1, 1 << (formats.edge_bits - 1))
    if bench.chance(0.5):
        height = bench.draw.randrange(1, 20)
    across = bench.draw.randrange(-4 * height, 4 * height + 1)
    start = bench.draw.randrange(0, height << formats.column_bits)
    column, rest = divmod(start, height)
    step, increment = divmod(across, height)
    fields = {
        "column": column,
        "error": rest + increment - height,
        "step": step,
        "increment": increment,
        "decrement": increment - height,
    }
    rows = bench.draw.randrange(1, 40)
    return fields, [(start + row * across) // height for row in range(rows)]


def raw(fields: dict[str, int], formats: Formats) -> dict[str, int]:
    """Two's complement fields under the names of the major edge."""
    return {f"major_{n}": fields[n] % (1 << formats.evaluate(width)) for n, width, _ in EDGE_FIELDS}


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(speed=list(SPEEDS))
async def every_scanline(dut: Any, speed: str) -> None:
    bench = Bench(dut, Config, f"every_scanline {speed}")
    formats = bench.config.formats
    ports = {name: formats.evaluate(width) for name, width, _ in EDGE_FIELDS}
    await bench.start("enable", "load", *(f"load_{name}" for name in ports), reset=False)
    go = SPEEDS[speed](bench.draw)
    columns = 1 << formats.column_bits
    pipeline: deque = deque([None] * LATENCY)
    for index in range(60):
        fields, exact = real_edge(bench, formats)
        # Every third edge is nonsense: there the model alone says what comes.
        if index % 3 == 2:
            fields = {name: bench.bits(width) for name, width in ports.items()}
            exact = None
        words = raw(fields, formats)
        model = EdgeDda(words, "major", formats)
        for row in range(len(exact) if exact else bench.draw.randrange(1, 30)):
            enable = False
            while not enable:
                enable = next(go)
                dut.enable.value = int(enable)
                dut.load.value = int(row == 0)
                for name, width in ports.items():
                    word = words[f"major_{name}"] if row == 0 else bench.bits(width)
                    getattr(dut, f"load_{name}").value = word
                await bench.edge()
                if pipeline[0] is not None:
                    column, _, what = pipeline[0]
                    bench.check("column", int(dut.column.value), column, index, what)
                if pipeline[1] is not None:
                    _, carry, what = pipeline[1]
                    bench.check("carry", int(dut.carry.value), carry, index, what)
            if exact is not None:
                bench.check("model's column", model.column, exact[row] % columns, index, fields)
            pipeline.append((model.column, model.carry, f"{fields} scanline {row}"))
            pipeline.popleft()
            model.step()
    bench.finish(at_least=1000)
