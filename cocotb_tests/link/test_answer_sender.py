# SPDX-License-Identifier: Apache-2.0
"""Answers against the model, byte by byte, at any speed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cocotb
import pytest

from cocotb_tests.support.bench import SPEEDS, Bench, StreamSink, StreamSource
from cocotb_tests.support.resets import reset_amid
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.golden.link.answer_sender import answer_bytes


@dataclass(frozen=True)
class Config:
    """Generics of ``answer_sender``."""

    crc_cycles: int = 1


@pytest.mark.parametrize("config", [Config(), Config(crc_cycles=4)], ids=identifier)
def test_answer_sender(config: Config) -> None:
    simulate("answer_sender", config)


NAMES = ("opcode", "number", "words", "bytes")


async def start(dut: Any, test: str) -> Bench:
    """The bench after reset."""
    bench = Bench(dut, Config, test)
    inputs = (*(f"answer_{name}" for name in NAMES), "answer_valid", "word_data", "data", "data_valid")
    await bench.start(*inputs, "byte_ready")
    return bench


async def one_answer(bench: Bench, source: str, sink: str, words: list[int], data: bytes) -> None:
    """Ask for an answer, and compare it with the model's."""
    dut, draw = bench.dut, bench.draw
    opcode, number = draw.getrandbits(8), draw.getrandbits(8)
    request = StreamSource(
        dut.answer_valid, dut.answer_ready, [getattr(dut, f"answer_{name}") for name in NAMES],
        [(opcode, number, len(words), len(data))], SPEEDS["full_speed"](draw),
    )  # fmt: skip
    stream = StreamSource(
        dut.data_valid, dut.data_ready, [dut.data], [(byte,) for byte in data], SPEEDS[source](draw)
    )
    sink_ports = [dut.byte_data, dut.byte_last]
    coming = StreamSink(bench, dut.byte_valid, dut.byte_ready, sink_ports, SPEEDS[sink](draw))
    expected = answer_bytes(opcode, number, words, data)
    start = bench.cycle
    while len(coming.words) < len(expected) and bench.cycle < start + 8000:
        request.drive()
        stream.drive()
        coming.drive()
        await bench.edge()
        # A word changes as soon as it was taken.
        dut.word_data.value = words[min(int(dut.word_index.value), len(words) - 1)]
        if dut.word_taken.value:
            dut.word_data.value = words[min(int(dut.word_index.value) + 1, len(words) - 1)]
        coming.sample(bench.cycle)
        request.sample(bench.cycle)
        stream.sample(bench.cycle)
    got = bytes(word[0] for word in coming.words)
    bench.check("answer", got.hex(), expected.hex(), inputs=(words, data))
    lasts = [word[1] for word in coming.words]
    bench.check("last", lasts, [0] * (len(expected) - 1) + [1])
    bench.check("all of the stream was taken", stream.empty, True)
    dut.byte_ready.value = 0
    await bench.edge()


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(source=list(SPEEDS), sink=list(SPEEDS))
async def answers(dut: Any, source: str, sink: str) -> None:
    bench = await start(dut, f"answers {source} {sink}")
    draw = bench.draw
    for _ in range(25):
        words = [draw.getrandbits(32) for _ in range(draw.choice((1, 2, 13)))]
        await one_answer(bench, source, sink, words, draw.randbytes(draw.choice((0, 0, 1, 7, 40))))
    if source == sink == "full_speed":
        # As many as can be said.
        await one_answer(bench, source, sink, [draw.getrandbits(32) for _ in range(63)], draw.randbytes(1023))
    bench.finish(at_least=75)


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def resets(dut: Any) -> None:
    bench = await start(dut, "resets")
    draw = bench.draw

    async def work() -> None:
        for data in (b"", draw.randbytes(draw.choice((1, 5)))):
            words = [draw.getrandbits(32) for _ in range(draw.randint(1, 3))]
            await one_answer(bench, "throttled", "throttled", words, data)

    sent = ("byte_valid", "byte_ready")
    events = (("answer_valid", "answer_ready"), "word_taken", ("data_valid", "data_ready"), sent)
    await reset_amid(bench, work, (*events, (*sent, "byte_last")), quiet=("byte_valid", "data_ready"))
    bench.finish(at_least=100)
