# SPDX-License-Identifier: Apache-2.0
"""The board's end of the link against the model: effects, answers, noise, credits, baud rates."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import repeat
from typing import Any

import cocotb
import pytest

from cocotb_tests.support.bench import SPEEDS, Bench
from cocotb_tests.support.command_recorder import CommandRecorder
from cocotb_tests.support.link_stimuli import body_of, good_payload, random_body
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.contract.formats import Formats
from quadshade.contract.protocol import (
    COUNTERS,
    MAGIC,
    VERSION,
    Opcode,
    Reason,
    definition_hash,
    unpack_payload,
)
from quadshade.golden.link.command_decoder import CommandDecoder
from quadshade.link.frames import Frame, FrameParser, enclosed

SEQUENCED = [opcode for opcode in Opcode if opcode.is_sequenced]
CLOCKS = ("clocks_busy", "clocks_idle")


@dataclass(frozen=True)
class Config:
    """Generics of ``command_decoder`` that say something about the board."""

    clk_frequency_hz: int = 100_000_000
    default_phase_step: int = 167772
    fifo_words: int = 64
    features: int = 5
    screen_width: int = 320
    screen_height: int = 240
    colour_bytes: int = 3
    depth_bytes: int = 2

    def identity(self) -> dict[str, int]:
        """What HELLO must say."""
        fixed = {"magic": MAGIC, "definition": definition_hash(), "version": VERSION}
        return {**fixed, "num_counters": len(COUNTERS), **vars(self), **Formats().generics()}


@pytest.mark.parametrize("config", [Config()], ids=identifier)
def test_command_decoder(config: Config) -> None:
    simulate("command_decoder", config)


def pattern(**fields: int) -> bytes:
    """What a READ finds: any bytes that follow from its fields."""
    seed = repr(sorted(fields.items())).encode()
    return bytes(zlib.crc32(seed + bytes([index % 256])) & 0xFF for index in range(fields["count"]))


class Effects(CommandRecorder):
    """A board whose pixels and CRCs tell one command from another."""

    def read(self, **fields: int) -> bytes:
        super().read(**fields)
        return pattern(**fields)

    def frame_crc(self, plane: int) -> int:
        super().frame_crc(plane)
        return zlib.crc32(bytes([plane, len(self.done) % 256]))


class Board:
    """The unit with all that is attached to it, cycle by cycle."""

    def __init__(self, bench: Bench, speed: str = "full_speed") -> None:
        self.bench, self.dut, draw = bench, bench.dut, bench.draw
        self.effects, self.parser, self.answers = Effects(), FrameParser(), []
        self.go = {
            name: SPEEDS[speed](draw) for name in ("setup", "state", "clear", "read", "frame_crc", "data")
        }
        self.send_go: Iterator[bool] = SPEEDS[speed](draw)
        self.busy, self.reading, self.crc = 0, b"", None
        self.quiet = 0

    async def start(self) -> None:
        """Reset, with everything ready."""
        inputs = (
            "line_valid",
            "line_data",
            "line_error",
            "break_seen",
            "send_ready",
            "send_busy",
            "core_idle",
        )
        more = ("pixel_done", "primitive_done", "setup_ready", "state_ready", "clear_ready", "read_ready")
        last = ("read_data_valid", "read_data", "frame_crc_ready", "frame_crc_done", "frame_crc_value")
        await self.bench.start(*inputs, *more, *last)

    async def step(self, byte: int | None = None, error: bool = False) -> None:
        """One cycle, with a byte from the line or none."""
        dut = self.dut
        dut.line_valid.value, dut.line_error.value = int(byte is not None), int(error)
        if byte is not None:
            dut.line_data.value = byte
        ready = {name: next(go) for name, go in self.go.items()}
        for name in ("setup", "state", "clear", "read", "frame_crc"):
            getattr(dut, f"{name}_ready").value = int(ready[name])
        dut.core_idle.value = int(self.busy == 0)
        sends = next(self.send_go)
        dut.send_ready.value = int(sends)
        offers = bool(self.reading) and ready["data"]
        dut.read_data_valid.value = int(offers)
        dut.read_data.value = self.reading[0] if offers else 0
        dut.frame_crc_done.value = int(self.crc is not None)
        dut.frame_crc_value.value = self.crc or 0
        self.crc = None
        await self.bench.edge()
        self.busy = max(0, self.busy - 1)
        self.quiet += 1
        if dut.core_reset.value:
            self.effects.reset()
            self.reading = b""
        if offers and dut.read_data_ready.value:
            self.reading = self.reading[1:]
        if dut.send_valid.value and sends:
            self.answers += self.parser.feed(bytes([int(dut.send_data.value)]))
            self.quiet = 0
        self.requests(ready)

    def requests(self, ready: dict[str, bool]) -> None:
        """What the unit asks for in this cycle."""
        dut, effects = self.dut, self.effects
        if dut.setup_valid.value and ready["setup"]:
            effects.triangles([int(dut.setup_data.value)])
            self.busy = self.bench.draw.randrange(1, 12)
        elif dut.state_valid.value and ready["state"]:
            effects.state(int(dut.state_address.value), int(dut.state_data.value))
        elif dut.clear_valid.value and ready["clear"]:
            effects.clear(int(dut.clear_colour.value))
            self.busy = 20
        elif dut.read_valid.value and ready["read"]:
            names = ("x", "y", "width", "count", "pixels", "plane")
            self.reading = effects.read(**{name: int(getattr(dut, f"read_{name}").value) for name in names})
        elif dut.frame_crc_valid.value and ready["frame_crc"]:
            self.crc = effects.frame_crc(int(dut.frame_crc_plane.value))
        else:
            return
        self.quiet = 0

    async def send(self, line: bytes, gaps: Iterator[bool] | None = None) -> None:
        """Bytes of the line."""
        for byte in line:
            for go in gaps or repeat(True):
                await self.step(byte if go else None)
                if go:
                    break

    async def settle(self) -> list[Frame]:
        """Wait until nothing happens any more; the answers since the last time."""
        self.quiet = 0
        while self.quiet < 90:
            await self.step()
        answers, self.answers = self.answers, []
        return answers


def told(answers: list[Frame]) -> list[tuple]:
    """Answers without what depends on time: room, clocks, and ACKs that say nothing new."""
    found: list[tuple] = []
    for frame in answers:
        fields, data = unpack_payload(frame.opcode, frame.payload)
        for name in ("free", *CLOCKS):
            fields.pop(name, None)
        entry = (frame.opcode.name, frame.sequence, tuple(fields.items()), data)
        if frame.opcode is not Opcode.ACK or not found or found[-1] != entry:
            found.append(entry)
    return found


def model_of(bench: Bench) -> CommandDecoder:
    """The model, with effects of its own."""
    return CommandDecoder(bench.config.identity(), Effects())


@cocotb.test(timeout_time=2, timeout_unit="ms")
@cocotb.parametrize(speed=list(SPEEDS))
async def one_at_a_time(dut: Any, speed: str) -> None:
    bench = Bench(dut, Config, f"one_at_a_time {speed}")
    board, model, parser = Board(bench, speed), model_of(bench), FrameParser()
    await board.start()
    opcodes = [opcode for opcode in Opcode if not opcode.is_answer]
    seen = set()
    for index in range(60):
        body = random_body(bench.draw, model.receiver, opcodes)
        if index < len(opcodes):
            payload = good_payload(bench.draw, opcodes[index])
            body = body_of(opcodes[index], model.receiver.expected, payload)
        elif body[0] == Opcode.RESET and bench.chance(0.6):
            body = body_of(Opcode.STATUS, index, b"")
        line = enclosed(body)
        if bench.chance(0.1):
            # The rest of a frame that was cut, which a leading 00 ends.
            line = line[: bench.draw.randrange(1, len(line))] + enclosed(body)
        expected = parser.feed(model.feed(line))
        await board.send(line)
        got = await board.settle()
        bench.check("answers", told(got), told(expected), index, line.hex())
        bench.check("effects", board.effects.done, model.drawing.done, index, line.hex())
        if got and model.receiver.expected == got[-1].payload[0]:
            free = int.from_bytes(got[-1].payload[2:4], "little")
            bench.check("room within the FIFO", free <= bench.config.fifo_words, True, index)
        board.effects.done.clear()
        model.drawing.done.clear()
        seen |= {frame.opcode for frame in got}
    bench.check("all kinds of answers", seen, {opcode for opcode in Opcode if opcode.is_answer})
    bench.check("line left over", parser.dropped.total(), 0)
    bench.finish(at_least=120)


@cocotb.test(timeout_time=2, timeout_unit="ms")
@cocotb.parametrize(speed=list(SPEEDS))
async def stream_with_gaps_in_credit(dut: Any, speed: str) -> None:
    """The host sends what the credits allow; frames are lost; it goes back: every word arrives, once."""
    bench = Bench(dut, Config, f"stream_with_gaps_in_credit {speed}")
    board, model = Board(bench, speed), model_of(bench)
    await board.start()
    frames = []
    for index in range(36):
        opcode = bench.draw.choice((Opcode.TRIANGLES, Opcode.TRIANGLES, Opcode.STATE, Opcode.CLEAR))
        frames.append(body_of(opcode, index, good_payload(bench.draw, opcode)))
        model.feed(enclosed(frames[-1]))
    base, sent, lost, naks = 0, 0, 0, 0
    while base < len(frames) and bench.cycle < 60000:
        for body in frames[sent : base + 3]:
            sent += 1
            damaged = bytearray(enclosed(body))
            if bench.chance(0.2):
                lost += 1
                damaged[bench.draw.randrange(1, len(damaged) - 1)] ^= 1 + bench.draw.randrange(255)
            await board.send(bytes(damaged), SPEEDS["throttled"](bench.draw))
        answers = await board.settle()
        naks += sum(frame.opcode is Opcode.NAK for frame in answers)
        base = answers[-1].payload[0] if answers else base
        sent = base
    bench.check("effects", board.effects.done, model.drawing.done)
    bench.check("frames were lost and asked for again", (lost > 3, naks > 1), (True, True))
    bench.finish(at_least=2)


@cocotb.test(timeout_time=2, timeout_unit="ms")
async def no_room(dut: Any) -> None:
    bench = Bench(dut, Config, "no_room")
    board = Board(bench)
    await board.start()
    board.go["setup"] = repeat(False)
    payloads = [bench.draw.randbytes(40) for _ in range(7)]
    for index, payload in enumerate(payloads):
        await board.send(enclosed(body_of(Opcode.TRIANGLES, index, payload)))
    answers = await board.settle()
    # Eleven words each, one of them waits at the core's door: five fit into 64.
    refused = [frame for frame in answers if frame.opcode is Opcode.NAK]
    reasons = [(frame.sequence, frame.payload[0], frame.payload[1]) for frame in refused]
    bench.check("refused", reasons[:1], [(5, 5, Reason.NO_ROOM)])
    board.go["setup"] = repeat(True)
    answers = await board.settle()
    room = [int.from_bytes(frame.payload[2:4], "little") for frame in answers]
    bench.check("credits were told without being asked", bool(room) and room[-1] >= 48, True, inputs=room)
    for index in (5, 6):
        await board.send(enclosed(body_of(Opcode.TRIANGLES, index, payloads[index])))
        await board.settle()
    words = [("setup", word) for payload in payloads for word in memoryview(payload).cast("I")]
    bench.check_all("effect", board.effects.done, words)
    bench.finish(at_least=70)


@cocotb.test(timeout_time=2, timeout_unit="ms")
async def noise(dut: Any) -> None:
    bench = Bench(dut, Config, "noise")
    board = Board(bench)
    await board.start()
    payload = bench.draw.randbytes(8)
    for index in range(4):
        for _ in range(1200):
            await board.step(bench.bits(8) if bench.chance(0.98) else None, bench.chance(0.002))
        bench.check("answers to noise", await board.settle(), [], index)
        bench.check("effects of noise", board.effects.done, [], index)
        await board.send(enclosed(body_of(Opcode.TRIANGLES, index, payload)))
        answers = [frame.opcode for frame in await board.settle()]
        bench.check("answers after noise", answers[:1], [Opcode.ACK], index)
        words = [("setup", word) for word in memoryview(payload).cast("I")]
        bench.check("a good frame after noise", board.effects.done, words, index)
        board.effects.done.clear()
    bench.finish(at_least=16)


@cocotb.test(timeout_time=2, timeout_unit="ms")
async def baud(dut: Any) -> None:
    bench = Bench(dut, Config, "baud")
    board = Board(bench)
    await board.start()
    default = bench.config.default_phase_step
    bench.check("phase_step after reset", int(dut.phase_step.value), default)
    step = bench.draw.randrange(1, 1 << 22)
    dut.send_busy.value = 1
    await board.send(enclosed(body_of(Opcode.BAUD, 9, step.to_bytes(4, "little"))))
    answers = await board.settle()
    bench.check("answer", [frame.opcode for frame in answers], [Opcode.BAUD_ANSWER])
    bench.check("phase_step while the answer is sent", int(dut.phase_step.value), default)
    # Another request waits until the rate has changed.
    await board.send(enclosed(body_of(Opcode.STATUS, 10, b"")))
    bench.check("answers at the old rate", await board.settle(), [])
    dut.send_busy.value = 0
    answers = await board.settle()
    bench.check("phase_step after the answer", int(dut.phase_step.value), step)
    bench.check("answer", [frame.opcode for frame in answers], [Opcode.STATUS_ANSWER])
    await board.send(enclosed(body_of(Opcode.RESET, 0, bytes(4))))
    await board.settle()
    bench.check("RESET keeps the rate", int(dut.phase_step.value), step)
    dut.break_seen.value = 1
    await board.step()
    dut.break_seen.value = 0
    await board.step()
    await board.step()
    bench.check("phase_step after a break", int(dut.phase_step.value), default)
    bench.finish(at_least=8)


@cocotb.test(timeout_time=2, timeout_unit="ms")
async def counters(dut: Any) -> None:
    bench = Bench(dut, Config, "counters")
    board = Board(bench)
    await board.start()
    for _ in range(50):
        await board.step()
    dut.pixel_done.value = 1
    for index in range(20):
        dut.primitive_done.value = index % 2
        await board.step(error=index < 7)
    dut.pixel_done.value = dut.primitive_done.value = 0
    await board.send(enclosed(body_of(Opcode.STATUS, 1, b"")))
    (answer,) = await board.settle()
    fields, _ = unpack_payload(answer.opcode, answer.payload)
    wanted = {
        "pixels": 20,
        "primitives": 10,
        "framing_errors": 7,
        "bad_cobs": 1,
        "frames": 0,
        "clocks_busy": 0,
    }
    for name, value in wanted.items():
        bench.check(name, fields[name], value)
    bench.check("clocks_idle", 70 < fields["clocks_idle"] < bench.cycle, True, inputs=fields)
    bench.finish(at_least=7)
