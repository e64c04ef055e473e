# SPDX-License-Identifier: Apache-2.0
"""A channel along spans against the model: exhaustive for tiny words, random for real ones."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import Any

import cocotb
import pytest

from cocotb_tests.support.bench import SPEEDS, Bench
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.golden.core.pixel_channel import PixelChannel

EXHAUSTIVE_BITS = 3


@dataclass(frozen=True)
class Config:
    """Generics of ``pixel_channel``."""

    word_width: int = 32
    max_order: int = 2


CONFIGS = [
    Config(),
    Config(word_width=3),
    Config(word_width=40, max_order=1),
    Config(word_width=24, max_order=0),
]


@pytest.mark.parametrize("config", CONFIGS, ids=identifier)
def test_pixel_channel(config: Config) -> None:
    simulate("pixel_channel", config)


def spans(bench: Bench) -> list[tuple[tuple[int, int, int], int]]:
    """Value, first and second difference of spans, and the pixels of each."""
    width = bench.config.word_width
    if width <= EXHAUSTIVE_BITS:
        return [(words, 4) for words in product(range(1 << width), repeat=3)]
    lengths = [1, 1, 2, 1, 60] + bench.rng.integers(1, 9, 150).tolist()
    return [(tuple(bench.bits(width) for _ in range(3)), length) for length in lengths]


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(speed=list(SPEEDS))
async def every_pixel(dut: Any, speed: str) -> None:
    bench = Bench(dut, Config, f"every_pixel {speed}")
    ports = ("span_value", "span_d_col", "span_dd_col")
    await bench.start("advance", "load", *ports, reset=False)
    go = SPEEDS[speed](bench.draw)
    width, order = bench.config.word_width, bench.config.max_order
    channel = None
    for index, (words, length) in enumerate(spans(bench)):
        for pixel in range(length):
            advance = False
            while not advance:
                advance = next(go)
                dut.advance.value = int(advance)
                dut.load.value = int(pixel == 0)
                for port, word in zip(ports, words, strict=True):
                    # The span's words stand there while it is loaded, and not a cycle longer.
                    getattr(dut, port).value = word if pixel == 0 else bench.bits(width)
                await bench.edge()
                # Latency 1: the pixel of the last step, until there is another.
                if channel is not None:
                    got = int(dut.pixel_value.value)
                    bench.check("pixel_value", got, channel.value, index, {"words": words, "pixel": pixel})
            if pixel == 0:
                differences = [word if order > level else 0 for level, word in enumerate(words[1:])]
                channel = PixelChannel(words[0], *differences, width)
            else:
                channel.step()
    bench.finish(at_least=700)
