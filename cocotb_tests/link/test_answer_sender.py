# SPDX-License-Identifier: Apache-2.0
"""Answers against the model, byte by byte, at any speed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cocotb
import pytest

from cocotb_tests.support.bench import SPEEDS, Bench, StreamSink, StreamSource
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.golden.link.answer_sender import answer_bytes


@dataclass(frozen=True)
class Config:
    """Generics of ``answer_sender``."""

    crc_cycles: int = 1


@pytest.mark.parametrize("config", [Config(), Config(crc_cycles=4)], ids=identifier)
def test_answer_sender(config: Config) -> None:
    simulate("answer_sender", config)


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(source=list(SPEEDS), sink=list(SPEEDS))
async def answers(dut: Any, source: str, sink: str) -> None:
    bench = Bench(dut, Config, f"answers {source} {sink}")
    names = ("opcode", "number", "words", "bytes")
    await bench.start(
        *(f"answer_{name}" for name in names), "answer_valid", "word_data", "data", "data_valid"
    )
    draw = bench.draw
    for index in range(25):
        if index == 12:
            # A reset in the middle of an answer: the next one is whole.
            dut.answer_valid.value, dut.answer_words.value, dut.byte_ready.value = 1, 5, 1
            for _ in range(draw.randrange(2, 20)):
                await bench.edge()
            dut.answer_valid.value = 0
            await bench.reset()
        words = [draw.getrandbits(32) for _ in range(draw.choice((1, 2, 13)))]
        data = draw.randbytes(draw.choice((0, 0, 1, 7, 40)))
        opcode, number = draw.getrandbits(8), draw.getrandbits(8)
        request = StreamSource(
            dut.answer_valid, dut.answer_ready, [getattr(dut, f"answer_{name}") for name in names],
            [(opcode, number, len(words), len(data))], SPEEDS["full_speed"](draw),
        )  # fmt: skip
        stream = StreamSource(
            dut.data_valid, dut.data_ready, [dut.data], [(byte,) for byte in data], SPEEDS[source](draw)
        )
        sink_ports = [dut.byte_data, dut.byte_last]
        coming = StreamSink(bench, dut.byte_valid, dut.byte_ready, sink_ports, SPEEDS[sink](draw))
        expected = answer_bytes(opcode, number, words, data)
        start = bench.cycle
        while len(coming.words) < len(expected) and bench.cycle < start + 2000:
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
        bench.check("answer", got.hex(), expected.hex(), index, (words, data))
        lasts = [word[1] for word in coming.words]
        bench.check("last", lasts, [0] * (len(expected) - 1) + [1], index)
        bench.check("all of the stream was taken", stream.empty, True, index)
        dut.byte_ready.value = 0
        await bench.edge()
    bench.finish(at_least=75)
