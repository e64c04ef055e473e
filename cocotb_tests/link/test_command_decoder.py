# SPDX-License-Identifier: Apache-2.0
"""The board's end of the link against the model: effects, answers, noise, credits, baud rates."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import repeat
from typing import Any

import cocotb
import pytest

from cocotb_tests.support.bench import SPEEDS, Bench
from cocotb_tests.support.link_board import CLOCKS, Board, Effects, told
from cocotb_tests.support.link_limits import limits
from cocotb_tests.support.link_stimuli import body_of, good_payload, random_body
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.contract.formats import Formats
from quadshade.contract.protocol import (
    BOARD_FIELDS,
    COUNTERS,
    FEATURES,
    MAGIC,
    VERSION,
    Opcode,
    Reason,
    definition_hash,
    unpack_payload,
)
from quadshade.golden.link.command_decoder import CommandDecoder
from quadshade.golden.link.frame_receiver import Reach
from quadshade.link.frames import Frame, FrameParser, enclosed

SEQUENCED = [opcode for opcode in Opcode if opcode.is_sequenced]


@dataclass(frozen=True)
class Config:
    """Generics of ``command_decoder`` that say something about the board."""

    clk_frequency_hz: int = 100_000_000
    default_phase_step: int = 167772
    fifo_words: int = 64
    features: int = sum(
        1 << FEATURES.index(name) for name in ("depth_test", "edge_map", "two_buffers", "packed_read")
    )
    screen_width: int = 320
    screen_height: int = 240
    colour_bytes: int = 3
    depth_bytes: int = 2
    most_counter_bits: int = 32

    @property
    def rounds(self) -> int:
        """Of the longest test."""
        return 100

    def identity(self) -> dict[str, int]:
        """What HELLO must say."""
        fixed = {"magic": MAGIC, "definition": definition_hash(), "version": VERSION}
        board = {name: getattr(self, name) for name, _, _ in BOARD_FIELDS}
        return {**fixed, "num_counters": len(COUNTERS), **board, **Formats().generics()}


@pytest.mark.parametrize("config", [Config()], ids=identifier)
def test_command_decoder(config: Config) -> None:
    simulate("command_decoder", config)


def model_of(bench: Bench) -> CommandDecoder:
    """The model, with effects of its own."""
    return CommandDecoder(bench.config.identity(), Effects(), bench.config.most_counter_bits)


@cocotb.test(timeout_time=2, timeout_unit="ms")
@cocotb.parametrize(speed=list(SPEEDS))
async def one_at_a_time(dut: Any, speed: str) -> None:
    bench = Bench(dut, Config, f"one_at_a_time {speed}")
    board, model, parser = Board(bench, speed), model_of(bench), FrameParser()
    await board.start()
    opcodes = [opcode for opcode in Opcode if not opcode.is_answer]
    seen = set()
    for index in range(60):
        body = random_body(bench.draw, model.receiver, opcodes, model.receiver.reach)
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


def results_of(frames: list[Frame]) -> list[tuple]:
    """What commands answer: all but the link state, which is of when it is sent."""
    return [(frame.opcode.name, frame.sequence, frame.payload[4:]) for frame in frames if frame.opcode & 0x10]


@cocotb.test(timeout_time=2, timeout_unit="ms")
async def results_in_a_row(dut: Any) -> None:
    """Each answer has its own command's CRC or bytes, however long the line takes for the one before it."""
    bench = Bench(dut, Config, "results_in_a_row")
    draw, speeds = bench.draw, ((0,), (30,), (0, 9, 60))
    await Board(bench).start()
    for cycles in speeds:
        await bench.reset()
        board, model, parser = Board(bench, char_cycles=cycles), model_of(bench), FrameParser()
        expected = []
        for index in range(8):
            opcode = draw.choice((Opcode.FRAME_CRC, Opcode.FRAME_CRC, Opcode.READ))
            line = enclosed(body_of(opcode, index, good_payload(draw, opcode)))
            expected += parser.feed(model.feed(line))
            await board.send(line)
        await board.quiet_for(120)
        bench.check_all("result", results_of(board.answers), results_of(expected))
        bench.check("effects", board.effects.done, model.drawing.done)
    bench.finish(at_least=9 * len(speeds))


def clocks_within(fields: dict[str, int], board: Board, before: dict[str, int], most: int) -> bool:
    """Whether the clocks of a STATUS lie between what the core said before the answer was sent, and after."""
    spans = {name: board.clocks[name] - before[name] for name in CLOCKS}
    return all((fields.pop(name) - before[name]) % most <= spans[name] for name in CLOCKS)


@cocotb.test(timeout_time=4, timeout_unit="ms")
@cocotb.parametrize(speed=list(SPEEDS))
async def overlaps(dut: Any, speed: str) -> None:
    """
    Frames come, several at once, while a command waits for the core and while an answer is sent: every field
    of every answer, each effect, each light.
    """
    bench = Bench(dut, Config, f"overlaps {speed}")
    board, model, parser = Board(bench, speed, (0, 0, 3, 12)), model_of(bench), FrameParser()
    await board.start()
    draw, opcodes = bench.draw, [opcode for opcode in Opcode if not opcode.is_answer]
    likely = [*SEQUENCED, *SEQUENCED, *opcodes, Opcode.RESET]
    board.door = board.stalled = model.holding = model.stalled = True
    seen = set()
    for index in range(bench.config.rounds):
        board.idle = bench.chance(0.5)
        for _ in range(draw.randint(0, 3)):
            body = random_body(draw, model.receiver, likely)
            if body[0] == Opcode.RESET and bench.chance(0.4):
                body = body_of(Opcode.STATUS, index, b"")
            model.feed(enclosed(body))
            await board.send(enclosed(body))
            # A character of the line takes far longer.
            await board.wait(8)
        if bench.chance(0.1):
            await board.wait(60)
            dut.break_seen.value = 1
            await board.step()
            dut.break_seen.value = 0
            model.line_break()
        await board.wait(60)
        if bench.chance(0.5):
            # The core and all behind it take what there is.
            board.stalled, board.idle, model.stalled = False, None, False
            model.run()
            await board.quiet_for(50)
            board.stalled = model.stalled = True
            board.idle = bench.chance(0.5)
            await board.wait(10)
        done = model.drawing.done
        bench.check("effects", board.effects.done, done[: len(board.effects.done)], index)
        bench.check("rate", board.rate, model.phase_step, index)
        bench.check("an answer waits", board.at_door, model.sending, index)
        while model.sending and bench.chance(0.8):
            before = dict(board.clocks)
            (expected,) = parser.feed(model.finish_answer())
            await board.let_one_out()
            bench.check("answers", len(board.answers), 1, index, expected)
            for got in board.answers[:1]:
                fields, data = unpack_payload(got.opcode, got.payload)
                wanted, wanted_data = unpack_payload(expected.opcode, expected.payload)
                if got.opcode is Opcode.STATUS_ANSWER:
                    most = 1 << bench.config.most_counter_bits
                    bench.check("clocks", clocks_within(fields, board, before, most), True, index, fields)
                    wanted = {name: value for name, value in wanted.items() if name not in CLOCKS}
                answer = (got.opcode, got.sequence, fields, data)
                bench.check(
                    "answer", answer, (expected.opcode, expected.sequence, wanted, wanted_data), index
                )
                seen.add(got.opcode)
            board.answers = []
            await board.wait(60)
            model.run()
            bench.check("rate", board.rate, model.phase_step, index)
    bench.check("the rate changed when nothing was sent", all(quiet for _, quiet in board.rates), True)
    bench.check("all kinds of answers", seen, {opcode for opcode in Opcode if opcode.is_answer})
    bench.finish(at_least=200)


@cocotb.test(timeout_time=2, timeout_unit="ms")
async def every_limit(dut: Any) -> None:
    bench = Bench(dut, Config, "every_limit")
    board, model, parser, reasons = Board(bench), model_of(bench), FrameParser(), set()
    await board.start()
    for index, case in enumerate(limits(Reach(with_swap=True), far=False)):
        line = enclosed(case.body(model.receiver.expected))
        expected = parser.feed(model.feed(line))
        await board.send(line)
        end = bench.cycle + (6000 if expected else 12)
        while bench.cycle < end and (not expected or len(board.answers) < len(expected)):
            await board.step()
        bench.check("answers", told(board.answers), told(expected), index, case)
        reasons |= {frame.payload[1] for frame in board.answers}
        board.answers = []
    await board.settle()
    bench.check("answers left over", board.answers, [])
    bench.check("effects", board.effects.done, model.drawing.done)
    # It always has room for one frame.
    bench.check("reasons of every kind", reasons, set(Reason) - {Reason.NO_ROOM})
    bench.finish(at_least=200)


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
    board.line_busy = True
    await board.send(enclosed(body_of(Opcode.BAUD, 9, step.to_bytes(4, "little"))))
    answers = await board.settle()
    bench.check("answer", [frame.opcode for frame in answers], [Opcode.BAUD_ANSWER])
    bench.check("phase_step while the answer is sent", int(dut.phase_step.value), default)
    # Another request waits until the rate has changed.
    await board.send(enclosed(body_of(Opcode.STATUS, 10, b"")))
    bench.check("answers at the old rate", await board.settle(), [])
    board.line_busy = False
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
