# SPDX-License-Identifier: Apache-2.0
"""Frames judged as the model judges them, at full speed; the words of those that are accepted."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cocotb
import pytest

from cocotb_tests.support.bench import SPEEDS, Bench
from cocotb_tests.support.link_stimuli import body_of, good_payload, random_body
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.contract.protocol import CRC_BYTES, Opcode
from quadshade.golden.link.frame_receiver import FrameReceiver, Verdict

COUNTS = {
    "frames": "count_frame",
    "bad_cobs": "count_bad_cobs",
    "bad_crc": "count_bad_crc",
    "bad_length": "count_bad_length",
    "refused": "count_refused",
    "overruns": "count_overrun",
    "duplicates": "count_duplicate",
    "gaps": "count_gap",
}


@dataclass(frozen=True)
class Config:
    """``frame_receiver`` has no generics."""


@pytest.mark.parametrize("config", [Config()], ids=identifier)
def test_frame_receiver(config: Config) -> None:
    simulate("frame_receiver", config)


def verdict(dut: Any) -> Verdict:
    """What the ports say in this cycle."""
    counters = [name for name, port in COUNTS.items() if getattr(dut, port).value]
    return Verdict(
        commit=bool(dut.commit.value),
        ack=bool(dut.ack.value),
        nak=bool(dut.nak.value),
        request=bool(dut.request.value),
        reason=int(dut.reason.value),
        counter=" ".join(counters),
    )


@cocotb.test(timeout_time=2, timeout_unit="ms")
@cocotb.parametrize(source=list(SPEEDS))
async def frames(dut: Any, source: str) -> None:
    bench = Bench(dut, Config, f"frames {source}")
    await bench.start("byte_valid", "byte_data", "frame_end", "frame_good", "overflow")
    model, go, seen = FrameReceiver(), SPEEDS[source](bench.draw), set()
    opcodes = [opcode for opcode in Opcode if not opcode.is_answer]
    bodies = [b""] * 160
    for index in range(len(bodies)):
        if index == 60:
            await bench.reset()
            model = FrameReceiver()
        body = random_body(bench.draw, model, opcodes)
        if index < 3:
            # The longest one, the shortest, and one of no byte.
            body = [body_of(Opcode.TRIANGLES, index, bytes(1016)), b"", body_of(Opcode.HELLO, 7, b"")][index]
        whole, overflow = bench.chance(0.95), bench.chance(0.2)
        dut.overflow.value = int(overflow)
        written, waiting = [], list(body)
        while waiting:
            valid = next(go)
            dut.byte_valid.value, dut.byte_data.value = int(valid), waiting[0]
            await bench.edge()
            if dut.write_valid.value:
                written.append(int(dut.write_data.value))
            bench.check("no verdict within a frame", verdict(dut), Verdict(), index)
            if valid:
                del waiting[0]
        dut.byte_valid.value = 0
        dut.frame_end.value, dut.frame_good.value = 1, int(whole)
        await bench.edge()
        dut.frame_end.value = dut.frame_good.value = 0
        expected = model.judge(body, whole, overflow)
        await bench.edge()
        await bench.edge()
        got = verdict(dut)
        inputs = {"body": body.hex(), "whole": whole, "overflow": overflow}
        bench.check("verdict", got, expected, index, inputs)
        bench.check("discard", bool(dut.discard.value), not expected.commit, index, inputs)
        bench.check("expected number", int(dut.expected.value), model.expected, index, inputs)
        if expected.commit:
            content = [
                int.from_bytes(body[at : at + 4], "little") for at in range(0, len(body) - CRC_BYTES, 4)
            ]
            bench.check("words", written, content, index, inputs)
        if expected.ack or expected.nak or expected.request:
            fields = (int(dut.opcode.value), int(dut.number.value))
            bench.check("opcode and number", fields, (body[0], body[1]), index, inputs)
        if expected.request and len(body) > 8:
            bench.check(
                "argument", int(dut.argument.value), int.from_bytes(body[4:8], "little"), index, inputs
            )
        seen.add((expected.counter, int(expected.reason)))
    bench.check("verdicts of every kind", {name for name, _ in seen} - {""}, set(COUNTS))
    bench.check("reasons of every kind", {reason for _, reason in seen}, set(range(6)))
    bench.finish(at_least=1000)


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def back_to_back(dut: Any) -> None:
    bench = Bench(dut, Config, "back_to_back")
    await bench.start("byte_valid", "byte_data", "frame_end", "frame_good", "overflow")
    payloads = [good_payload(bench.draw, Opcode.TRIANGLES) for _ in range(40)]
    commits, accepted = 0, []
    for index, payload in enumerate(payloads):
        # As the deframer gives them from a line of a byte per cycle: one cycle's pause for each 00 and code.
        written = []
        for byte in body_of(Opcode.TRIANGLES, index, payload):
            dut.byte_valid.value, dut.byte_data.value = 1, byte
            await bench.edge()
            commits += int(dut.commit.value)
            if dut.write_valid.value:
                written.append(int(dut.write_data.value))
        accepted.append(written)
        dut.byte_valid.value, dut.frame_end.value, dut.frame_good.value = 0, 1, 1
        await bench.edge()
        dut.frame_end.value = 0
        await bench.edge()
    for _ in range(3):
        await bench.edge()
        commits += int(dut.commit.value)
    bench.check("frames accepted", int(dut.expected.value), len(payloads))
    contents = [
        [int.from_bytes(payload[at : at + 4], "little") for at in range(0, len(payload), 4)]
        for payload in payloads
    ]
    bench.check_all("payload", [words[1:] for words in accepted], contents)
    bench.finish(at_least=40)
