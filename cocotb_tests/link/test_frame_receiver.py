# SPDX-License-Identifier: Apache-2.0
"""Frames judged as the model judges them, at full speed; the words of those that are accepted."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import cycle, product
from typing import Any

import cocotb
import pytest

from cocotb_tests.support.bench import SPEEDS, Bench
from cocotb_tests.support.cover import Cover
from cocotb_tests.support.link_limits import limits, limits_of_fields
from cocotb_tests.support.link_stimuli import body_of, good_payload, random_body
from cocotb_tests.support.resets import reset_amid
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.contract.protocol import CRC_BYTES, EDGE_BYTES, Opcode, Reason, pack_payload
from quadshade.golden.link.frame_receiver import FrameReceiver, Reach, Verdict
from quadshade.link.frames import sealed

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


EFFECTS = ("commit", "ack", "nak", "request", *COUNTS.values())
INPUTS = ("byte_valid", "byte_data", "frame_end", "frame_good", "overflow")


@dataclass(frozen=True)
class Config:
    """Generics of ``frame_receiver``."""

    screen_width: int = 320
    screen_height: int = 240
    colour_bytes: int = 3
    depth_bytes: int = 2
    with_edge_map: int = 0
    with_swap: int = 1
    with_packed_read: int = 0
    crc_cycles: int = 1

    @property
    def reach(self) -> Reach:
        """What READ and FRAME_CRC may name."""
        edges = EDGE_BYTES * self.with_edge_map
        planes = (self.colour_bytes, self.depth_bytes, edges, edges)
        features = bool(self.with_swap), bool(self.with_packed_read)
        return Reach(self.screen_width, self.screen_height, planes, *features)

    @property
    def pause(self) -> int:
        """Cycles between two bytes."""
        return self.crc_cycles if self.crc_cycles > 1 else 0


CONFIGS = [
    Config(),
    Config(screen_width=64, screen_height=31, colour_bytes=1, depth_bytes=0, with_edge_map=1, crc_cycles=4),
    Config(screen_width=9, screen_height=6, colour_bytes=4, with_swap=0, with_packed_read=1),
]


@pytest.mark.parametrize("config", CONFIGS, ids=identifier)
def test_frame_receiver(config: Config) -> None:
    simulate("frame_receiver", config)


REQUESTS = [opcode for opcode in Opcode if not opcode.is_answer]
FAULTS = {
    "frames": "none",
    "": "none",
    "bad_cobs": "damaged",
    "bad_crc": "wrong CRC",
    "bad_length": "wrong length",
    "refused": "wrong field",
    "overruns": "no room",
    "duplicates": "sent again",
}
"""By the counter that goes up."""

ORDER_FAULTS = ("no room", "sent again", "gap goes on", "out of order")
LINK_BINS = {
    "state": ("in order", "behind a gap"),
    "request": tuple(opcode.name for opcode in REQUESTS),
    "fault": ("none", "damaged", "wrong CRC", "wrong length", "wrong field", *ORDER_FAULTS),
}
LINK_IMPOSSIBLE = (
    (
        "it is answered at once, whatever its number",
        {"request": [one.name for one in REQUESTS if not one.is_sequenced], "fault": ORDER_FAULTS},
    ),
    (
        "every value of its fields is allowed",
        {
            "request": [one.name for one in REQUESTS if one.name not in ("READ", "FRAME_CRC", "BAUD")],
            "fault": ["wrong field"],
        },
    ),
    ("the next number in order is no gap", {"state": ["in order"], "fault": ["gap goes on"]}),
)


def fault_of(said: Verdict) -> str:
    """What was wrong with a frame; nothing where its request is not known."""
    if said.reason is Reason.UNKNOWN_OPCODE:
        return ""
    if said.counter == "gaps":
        return "out of order" if said.nak else "gap goes on"
    return FAULTS[said.counter]


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


class Line:
    """
    The unit behind a deframer: a frame and its verdict at a time.

    Parameters
    ----------
    bench : Bench
    speed : str
      With which bytes come; a byte takes as many cycles as the CRC needs.
    """

    def __init__(self, bench: Bench, speed: str) -> None:
        self.bench, self.dut = bench, bench.dut
        self.model = FrameReceiver(bench.config.reach)
        self.go, self.pause = SPEEDS[speed](bench.draw), bench.config.pause
        self.seen: set[tuple[str, int]] = set()
        self.cover = Cover("link", LINK_BINS, LINK_IMPOSSIBLE)
        self.watched = [getattr(self.dut, name) for name in EFFECTS]

    async def edge(self, index: int) -> None:
        """A cycle without a verdict."""
        await self.bench.edge()
        said = [int(port.value) for port in self.watched]
        self.bench.check("no verdict within a frame", any(said), False, index)

    async def frame(self, index: int, body: bytes, whole: bool = True, overflow: bool = False) -> None:
        """Send a frame; compare words, verdict and fields."""
        bench, dut = self.bench, self.dut
        dut.overflow.value = int(overflow)
        written, waiting = [], list(body)
        while waiting:
            valid = next(self.go)
            dut.byte_valid.value, dut.byte_data.value = int(valid), waiting[0]
            await self.edge(index)
            if dut.write_valid.value:
                written.append(int(dut.write_data.value))
            if valid:
                del waiting[0]
                dut.byte_valid.value = 0
                for _ in range(self.pause):
                    await self.edge(index)
        dut.byte_valid.value = 0
        dut.frame_end.value, dut.frame_good.value = 1, int(whole)
        await self.edge(index)
        dut.frame_end.value = dut.frame_good.value = 0
        in_order = self.model.is_in_order
        expected = self.model.judge(body, whole, overflow)
        if (fault := fault_of(expected)) and body and body[0] in REQUESTS:
            state = "in order" if in_order else "behind a gap"
            self.cover.sample(state=state, request=Opcode(body[0]).name, fault=fault)
        await self.edge(index)
        await bench.edge()
        got = verdict(dut)
        inputs = {"body": body.hex(), "whole": whole, "overflow": overflow}
        bench.check("verdict", got, expected, index, inputs)
        bench.check("discard", bool(dut.discard.value), not expected.commit, index, inputs)
        bench.check("expected number", int(dut.expected.value), self.model.expected, index, inputs)
        if expected.commit:
            content = [
                int.from_bytes(body[at : at + 4], "little") for at in range(0, len(body) - CRC_BYTES, 4)
            ]
            bench.check("words", written, content, index, inputs)
        if expected.ack or expected.nak or expected.request:
            fields = (int(dut.opcode.value), int(dut.number.value))
            bench.check("opcode and number", fields, (body[0], body[1]), index, inputs)
        if expected.request and len(body) > 8:
            argument = int.from_bytes(body[4:8], "little")
            bench.check("argument", int(dut.argument.value), argument, index, inputs)
        self.seen.add((expected.counter, int(expected.reason)))


@cocotb.test(timeout_time=2, timeout_unit="ms")
@cocotb.parametrize(source=list(SPEEDS))
async def frames(dut: Any, source: str) -> None:
    bench = Bench(dut, Config, f"frames {source}")
    await bench.start(*INPUTS)
    line = Line(bench, source)
    opcodes = [opcode for opcode in Opcode if not opcode.is_answer]
    first = [body_of(Opcode.TRIANGLES, 0, bytes(1016)), b"", body_of(Opcode.HELLO, 7, b"")]
    for index in range(160 if bench.default else 60):
        # The longest one, one of no byte, and the shortest, before the others.
        body = random_body(bench.draw, line.model, opcodes, bench.config.reach)
        body = first[index] if index < len(first) else body
        await line.frame(index, body, bench.chance(0.95), bench.chance(0.2))
    if bench.default:
        bench.check("verdicts of every kind", {name for name, _ in line.seen} - {""}, set(COUNTS))
        bench.check("reasons of every kind", {reason for _, reason in line.seen}, set(Reason))
    bench.finish(at_least=1000)


@cocotb.test(timeout_time=2, timeout_unit="ms")
async def numbers_come_round(dut: Any) -> None:
    """More frames than there are numbers; some are sent again, or ahead of their turn, two in a row."""
    bench = Bench(dut, Config, "numbers_come_round")
    await bench.start(*INPUTS)
    line = Line(bench, "full_speed")
    for index in range(270):
        body = body_of(Opcode.TRIANGLES, line.model.expected, bench.draw.randbytes(4))
        await line.frame(index, body)
        if index % 7 == 0:
            number = line.model.expected + bench.draw.choice((-127, -128, -1, 1, 2, 127))
            for after in (number, number + 1):
                await line.frame(index, body_of(Opcode.TRIANGLES, after, bytes(4)))
    bench.finish(at_least=270)


def excluded(combination: tuple[str, ...]) -> bool:
    """Whether a state, a request and a fault cannot come together."""
    values = dict(zip(LINK_BINS, combination, strict=True))
    return any(all(values[name] in some for name, some in where.items()) for _, where in LINK_IMPOSSIBLE)


def faulty(bench: Bench, opcode: Opcode, fault: str, expected: int) -> bytes:
    """A request with a fault, of a board that awaits a number."""
    payload = good_payload(bench.draw, opcode, 1, bench.config.reach)
    number = {"sent again": expected - 1, "gap goes on": expected + 4, "out of order": expected + 9}
    if fault == "wrong field":
        wrong = {
            Opcode.READ: {},
            Opcode.FRAME_CRC: {"reserved": 0, "plane": 7},
            Opcode.BAUD: {"phase_step": 0},
        }
        payload = pack_payload(opcode, wrong[opcode]) if wrong[opcode] else bytes(len(payload))
    if fault == "wrong length":
        return sealed(bytes([opcode, expected]) + (len(payload) + 4).to_bytes(2, "little") + payload)
    body = body_of(opcode, number.get(fault, expected), payload)
    return body[:-1] + bytes([body[-1] ^ 1]) if fault == "wrong CRC" else body


@cocotb.test(timeout_time=4, timeout_unit="ms")
async def every_request_and_fault(dut: Any) -> None:
    """Each fault of each request, where the frame before was in order and where it was not."""
    bench = Bench(dut, Config, "every_request_and_fault")
    await bench.start(*INPUTS)
    line = Line(bench, "full_speed")
    words = good_payload(bench.draw, Opcode.TRIANGLES, 1)
    wanted = [one for one in product(*LINK_BINS.values()) if not excluded(one)]
    if not bench.config.with_swap:
        wanted = [one for one in wanted if one[1] != Opcode.SWAP.name]
    for index, (state, request, fault) in enumerate(wanted):
        # Behind a gap too, each case has other numbers.
        await line.frame(index, body_of(Opcode.TRIANGLES, line.model.expected, words))
        ahead = 0 if state == "in order" else 3
        await line.frame(index, body_of(Opcode.TRIANGLES, line.model.expected + ahead, words))
        body = faulty(bench, Opcode[request], fault, line.model.expected)
        before = line.cover.hits[state, request, fault]
        await line.frame(index, body, fault != "damaged", fault == "no room")
        after = line.cover.hits[state, request, fault]
        bench.check("the fault that was meant", after, before + 1, index, (state, request, fault))
        # What was refused between them ends no run of numbers behind a gap, nor does a payload too long.
        await line.frame(index, body_of(Opcode.HELLO, index, bytes(4)))
        await line.frame(index, body_of(Opcode.TRIANGLES, line.model.expected + ahead + 1, words))
    line.cover.save()
    bench.finish(at_least=100)


@cocotb.test(timeout_time=2, timeout_unit="ms")
async def every_limit(dut: Any) -> None:
    bench = Bench(dut, Config, "every_limit")
    await bench.start(*INPUTS)
    line = Line(bench, "full_speed")
    # What does not follow from the generics is sent to one of them.
    some = limits if bench.default else limits_of_fields
    for index, case in enumerate(some(bench.config.reach)):
        # There is no room for the first one that is next in order.
        overflow = case.name == "number" and Reason.NO_ROOM not in {reason for _, reason in line.seen}
        await line.frame(index, case.body(line.model.expected), True, overflow)
    wanted = set(Reason) if bench.default else {Reason.NONE, Reason.BAD_FIELD}
    bench.check("reasons of every kind", {reason for _, reason in line.seen}, wanted)
    bench.finish(at_least=5000)


@cocotb.test(timeout_time=2, timeout_unit="ms")
@cocotb.parametrize(source=list(SPEEDS))
async def resets(dut: Any, source: str) -> None:
    bench = Bench(dut, Config, f"resets {source}")
    await bench.start(*INPUTS)

    sent = cycle(((0, 2), (0, 1), (1, 0), (2, 0), (5, 6)))

    async def work() -> None:
        line = Line(bench, source)
        payload = bench.draw.randbytes(4)
        # A number that is ahead is refused unless it follows the last one that was judged: after reset 255.
        numbers = next(sent)
        bodies = [body_of(Opcode.TRIANGLES, number, payload) for number in numbers]
        bodies.insert(bench.draw.randrange(3), body_of(Opcode.HELLO, 3, b""))
        for index, body in enumerate(bodies):
            await line.frame(index, body)

    events = ("byte_valid", "frame_end", "ack", "nak", "request", "commit", "write_valid")
    await reset_amid(bench, work, events, 60 if bench.default else 16, quiet=EFFECTS)
    bench.finish(at_least=1000)


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def reset_in_the_cycle_of_a_verdict(dut: Any) -> None:
    """A frame whose verdict falls into a reset has no effect and no answer, whatever it is."""
    bench = Bench(dut, Config, "reset_in_the_cycle_of_a_verdict")
    await bench.start(*INPUTS)
    bodies = [
        body_of(Opcode.TRIANGLES, 0, bytes(4)),
        body_of(Opcode.TRIANGLES, 9, bytes(4)),
        body_of(Opcode.TRIANGLES, 255, bytes(4)),
        body_of(Opcode.STATUS, 0, b""),
        body_of(0x77, 0, b""),
    ]
    for index, body in enumerate(3 * bodies):
        line, late = Line(bench, "full_speed"), index // len(bodies)
        for byte in body:
            dut.byte_valid.value, dut.byte_data.value = 1, byte
            await bench.edge()
            dut.byte_valid.value = 0
            for _ in range(line.pause):
                await bench.edge()
        # The reset comes with the frame's end, with the verdict, or with what it says.
        dut.frame_end.value, dut.frame_good.value, dut.reset.value = 1, 1, int(late == 0)
        for after in (1, 2, 3):
            await bench.edge()
            dut.frame_end.value, dut.frame_good.value, dut.reset.value = 0, 0, int(after == late)
            if after > late + 1:
                ports = [int(port.value) for port in line.watched]
                bench.check("effects and counts", ports, [0] * len(ports), index)
        await bench.edge()
        bench.check("expected number", int(dut.expected.value), 0, index)
        await line.frame(index, bodies[0])
        await bench.reset()
    bench.finish(at_least=60)


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def back_to_back(dut: Any) -> None:
    bench = Bench(dut, Config, "back_to_back")
    await bench.start(*INPUTS)
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
            dut.byte_valid.value = 0
            for _ in range(bench.config.pause):
                await bench.edge()
                commits += int(dut.commit.value)
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
