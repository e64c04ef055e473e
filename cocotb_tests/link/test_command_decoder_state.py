# SPDX-License-Identifier: Apache-2.0
"""What the board's end of the link keeps: counters that wrap, rate, credits told; and what forgets it."""

from __future__ import annotations

from dataclasses import asdict
from itertools import chain, repeat
from typing import Any

import cocotb
import pytest

from cocotb_tests.link.test_command_decoder import Config
from cocotb_tests.support.bench import Bench
from cocotb_tests.support.link_board import CLOCKS, GATES, Board, Effects, told
from cocotb_tests.support.link_stimuli import body_of, good_payload
from cocotb_tests.support.resets import reset_amid
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.contract.formats import Formats
from quadshade.contract.protocol import Opcode, unpack_payload
from quadshade.golden.link.command_decoder import CommandDecoder
from quadshade.link.frames import Frame, FrameParser, enclosed

FORMATS = {name: 7 * index + 3 for index, name in enumerate(Formats().generics())}
"""No two of HELLO's bytes are the same."""

SMALL = Config(
    clk_frequency_hz=0x12345678,
    default_phase_step=0x1ABCDE,
    fifo_words=32,
    features=23,
    screen_width=0x0141,
    screen_height=0x00F3,
    colour_bytes=4,
    most_counter_bits=4,
)


@pytest.mark.parametrize("config", [SMALL], ids=identifier)
def test_command_decoder_state(config: Config) -> None:
    simulate("command_decoder", config, asdict(config) | FORMATS, tests="command_decoder_state")


class Pair:
    """The unit and its model, which are sent the same."""

    def __init__(self, bench: Bench) -> None:
        self.bench, self.board = bench, Board(bench)
        identity = bench.config.identity() | FORMATS
        self.model = CommandDecoder(identity, Effects(), bench.config.most_counter_bits)
        self.parser = FrameParser()

    async def send(self, opcode: int, payload: bytes = b"", ahead: int = 0) -> None:
        """A frame, of which only the effects are compared."""
        line = enclosed(body_of(opcode, self.model.receiver.expected + ahead, payload))
        self.model.feed(line)
        await self.board.send(line)

    async def ask(self, opcode: int, payload: bytes = b"", ahead: int = 0) -> list[Frame]:
        """A frame, to whose answers the model's are equal."""
        line = enclosed(body_of(opcode, self.model.receiver.expected + ahead, payload))
        expected = self.parser.feed(self.model.feed(line))
        await self.board.send(line)
        await self.board.quiet_for(40)
        got, self.board.answers = self.board.answers, []
        self.bench.check("answers", told(got), told(expected), inputs=line.hex())
        return got

    async def line_break(self) -> None:
        """One, in one cycle."""
        self.bench.dut.break_seen.value = 1
        await self.board.step()
        self.bench.dut.break_seen.value = 0
        self.model.line_break()
        await self.board.wait(2)


@cocotb.test(timeout_time=2, timeout_unit="ms")
async def identity(dut: Any) -> None:
    bench = Bench(dut, Config, "identity")
    pair = Pair(bench)
    await pair.board.start()
    await pair.ask(Opcode.RESET, bytes([1, 2, 3, 4]))
    (answer,) = await pair.ask(Opcode.HELLO)
    fields, _ = unpack_payload(answer.opcode, answer.payload)
    for name, value in (FORMATS | {"session": 0x04030201}).items():
        bench.check(name, fields[name], value)
    bench.finish(at_least=2 + len(FORMATS))


@cocotb.test(timeout_time=2, timeout_unit="ms")
async def counters_wrap(dut: Any) -> None:
    """Every counter over its wrap, by another number each; the lights show what they should."""
    bench = Bench(dut, Config, "counters_wrap")
    pair = Pair(bench)
    board, model, draw = pair.board, pair.model, bench.draw
    await board.start()
    word, most = bytes([1, 0, 0, 0]), 1 << bench.config.most_counter_bits
    step = draw.randrange(1 << 20).to_bytes(4, "little")
    for index in range(26):
        if index < 17:
            await pair.ask(Opcode.TRIANGLES, word)
        if index < 18:
            await pair.ask(Opcode.TRIANGLES, word, ahead=-1)
        if index < 19:
            await pair.ask(Opcode.TRIANGLES, word, ahead=5)
        if index < 20:
            await pair.ask(0x7F)
        if index < 21:
            broken = bytearray(enclosed(body_of(Opcode.BAUD, 0, step)))
            broken[-3] = broken[-3] % 255 + 1 if broken[-3] != 255 else 1
            model.feed(bytes(broken))
            await board.send(bytes(broken))
        if index < 22:
            model.feed(b"\0\x09\1\0")
            await board.send(b"\0\x09\1\0")
        if index < 23:
            model.feed(enclosed(bytes(7)))
            await board.send(enclosed(bytes(7)))
    board.stalled = model.stalled = True
    while model.counts["overruns"] < most + 8:
        await pair.ask(Opcode.TRIANGLES, word * 9)
    board.stalled = model.stalled = False
    await board.quiet_for(60)
    model.run()
    board.answers = []
    wanted = {name: model.counts[name] for name in model.counts}
    wanted["pixels"], wanted["primitives"], wanted["framing_errors"] = 43, 25, 27
    for index in range(43):
        dut.pixel_done.value, dut.primitive_done.value = 1, int(index < 25)
        await board.step(error=index < 27)
    dut.pixel_done.value = dut.primitive_done.value = 0
    # A lost character ends in a frame that is none.
    model.feed(b"\0")
    await board.send(b"\0")
    wanted["bad_cobs"] += 1
    for idle, name in ((False, "clocks_idle"), (True, "clocks_busy")):
        board.idle = idle
        await pair.send(Opcode.STATUS)
        (answer,) = await board.settle()
        fields, _ = unpack_payload(answer.opcode, answer.payload)
        wanted[name] = board.clocks[name]
        for key in set(fields) & (set(wanted) - (set(CLOCKS) - {name})):
            bench.check(key, fields[key], wanted[key] % most)
        board.idle = not idle
        await board.wait(37)
    bench.check("every counter wrapped", [key for key, value in wanted.items() if value < most], [])
    seen = wanted["frames"] + wanted["duplicates"] + 2
    faults = sum(wanted[key] for key in ("bad_cobs", "bad_crc", "bad_length", "refused", "framing_errors"))
    bench.check("frame_seen, fault_seen", board.lights, [seen, faults])
    bench.finish(at_least=120)


@cocotb.test(timeout_time=2, timeout_unit="ms")
async def credits_are_told(dut: Any) -> None:
    """Words become free singly: an ACK that nobody asked for comes with a quarter of the FIFO, not before."""
    bench = Bench(dut, Config, "credits_are_told")
    pair = Pair(bench)
    board = pair.board
    await board.start()
    board.go["setup"] = repeat(False)
    quarter = bench.config.fifo_words // 4
    for _ in range(2):
        await board.send(enclosed(body_of(Opcode.TRIANGLES, pair.model.receiver.expected, bytes(4 * 27))))
        pair.model.receiver.expected += 1
        (answer,) = await board.settle()
        begin = int.from_bytes(answer.payload[2:4], "little")
        board.answers, freed = [], 0
        while not board.answers and freed <= 27:
            board.go["setup"] = chain([True], repeat(False))
            await board.wait(60)
            freed += 1
        await board.quiet_for(60)
        told_free = [int.from_bytes(frame.payload[2:4], "little") - begin for frame in board.answers]
        bench.check("credits, told once", (told_free, freed), ([quarter], quarter))
        board.go["setup"] = repeat(True)
        board.answers = []
        await board.settle()
        board.go["setup"] = repeat(False)
    # RESET empties a FIFO that was said to be full: its answer says so, and no other one does.
    await board.send(enclosed(body_of(Opcode.TRIANGLES, pair.model.receiver.expected, bytes(4 * 27))))
    await board.settle()
    await board.send(enclosed(body_of(Opcode.RESET, 0, bytes(4))))
    answers = [(frame.opcode, frame.payload[2]) for frame in await board.settle()]
    bench.check("answers to RESET", answers, [(Opcode.RESET_ANSWER, bench.config.fifo_words)])
    bench.finish(at_least=3)


@cocotb.test(timeout_time=2, timeout_unit="ms")
async def credits_beside_an_answer(dut: Any) -> None:
    """What becomes free before an answer's link state is told by it alone, what does later by one ACK."""
    bench = Bench(dut, Config, "credits_beside_an_answer")
    pair = Pair(bench)
    board = pair.board
    await board.start()
    for before, after in ((1, 0), (0, 1), (1, 1), (0, 0), (1, 1)):
        board.go["setup"] = repeat(False)
        await pair.send(Opcode.TRIANGLES, bytes(4 * 27))
        (answer,) = await board.settle()
        free = int.from_bytes(answer.payload[2:4], "little")
        board.door = True
        await pair.send(Opcode.HELLO)
        await board.wait(60)
        bench.check("an answer waits", board.at_door, True, inputs=(before, after))
        expected = [(Opcode.HELLO_ANSWER, free + 11 * before)]
        expected += [(Opcode.ACK, free + 11 * (before + after))] * after
        for begun, freed in ((False, 11 * before), (True, 11 * after)):
            if begun:
                board.door, board.char_cycles = False, (40,)
                await board.wait(120)
            for _ in range(freed):
                board.go["setup"] = chain([True], repeat(False))
                await board.wait(8)
            bench.check("nothing was answered meanwhile", board.answers, [], inputs=(before, after))
        board.char_cycles = (0,)
        got = [(frame.opcode, int.from_bytes(frame.payload[2:4], "little")) for frame in await board.settle()]
        bench.check("answers, credits", got, expected, inputs=(before, after))
        board.go["setup"] = repeat(True)
        await board.settle()
    bench.finish(at_least=25)


@cocotb.test(timeout_time=2, timeout_unit="ms")
async def credits_are_forgotten(dut: Any) -> None:
    """A reset in any cycle about that in which a quarter becomes free: nothing is told of it."""
    bench = Bench(dut, Config, "credits_are_forgotten")
    await Board(bench).start()
    for cycles in range(1, 9):
        pair = Pair(bench)
        board = pair.board
        board.go["setup"] = repeat(False)
        await pair.send(Opcode.TRIANGLES, bytes(4 * 27))
        await board.quiet_for(60)
        for wait in (*repeat(8, bench.config.fifo_words // 4 - 1), cycles):
            board.go["setup"] = chain([True], repeat(False))
            await board.wait(wait)
        bench.check("answers before", [frame.opcode for frame in board.answers], [Opcode.ACK], cycles)
        board.answers = []
        dut.reset.value = 1
        await board.wait(1)
        dut.reset.value = 0
        await board.quiet_for(60)
        bench.check("answers after a reset", board.answers, [], cycles)
    bench.finish(at_least=16)


@cocotb.test(timeout_time=2, timeout_unit="ms")
async def a_change_of_rate_is_forgotten(dut: Any) -> None:
    """By a break or RESET, before BAUD's answer is begun and while it is sent."""
    bench = Bench(dut, Config, "a_change_of_rate_is_forgotten")
    pair = Pair(bench)
    board, model, default = pair.board, pair.model, bench.config.default_phase_step
    await board.start()
    for waits in (False, True, False, True):
        for ends in ("", "break", "RESET"):
            await pair.line_break()
            bench.check("the default rate", (board.rate, model.phase_step), (default, default))
            board.door = model.holding = True
            if waits:
                # Its answer is at the door, and BAUD's behind it.
                await pair.send(Opcode.STATUS)
                await board.wait(60)
            rate = bench.draw.randrange(1, 1 << 22)
            await pair.send(Opcode.BAUD, rate.to_bytes(4, "little"))
            await board.wait(60)
            bench.check("an answer is begun", (board.at_door, model.sending), (True, True))
            bench.check("no change before the answer", board.rate, default)
            if ends == "break":
                await pair.line_break()
            elif ends:
                await pair.send(Opcode.RESET, bytes(4))
                await board.wait(60)
            for _ in range(2):
                if model.sending:
                    expected = pair.parser.feed(model.finish_answer())
                    await board.let_one_out()
                    bench.check("answer", told(board.answers), told(expected), inputs=(waits, ends))
                board.answers = []
                await board.wait(60)
                model.run()
            bench.check("rate", board.rate, model.phase_step, inputs=(waits, ends))
            bench.check("model's rate", model.phase_step, default if ends else rate, inputs=(waits, ends))
            bench.check("nothing waits", (board.at_door, model.sending), (False, False))
            board.door = model.holding = False
            await pair.ask(Opcode.STATUS)
            bench.check("rate later", board.rate, model.phase_step, inputs=(waits, ends))
    bench.finish(at_least=80)


@cocotb.test(timeout_time=2, timeout_unit="ms")
async def reset_beside_a_reset(dut: Any) -> None:
    """RESET resets what is drawn with, in one cycle; not where the board is reset in the cycle before."""
    bench = Bench(dut, Config, "reset_beside_a_reset")
    board = Board(bench)
    await board.start()
    line, after = enclosed(body_of(Opcode.RESET, 0, bytes(4))), 0
    await board.send(line)
    while not dut.core_reset.value and after < 40:
        await board.wait(1)
        after += 1
    bench.check("RESET resets", after < 40, True)
    await board.quiet_for(60)
    for early in (3, 2, 1):
        board = Board(bench)
        await board.send(line)
        await board.wait(after - early)
        dut.reset.value = 1
        await board.wait(1)
        dut.reset.value = 0
        for _ in range(5):
            await board.wait(1)
            bench.check("core_reset behind a reset", int(dut.core_reset.value), 0, early)
    bench.finish(at_least=16)


@cocotb.test(timeout_time=2, timeout_unit="ms")
async def resets(dut: Any) -> None:
    """In any cycle of any command: rate, session, numbers, counters and all that waits are as at first."""
    bench = Bench(dut, Config, "resets")
    await Board(bench).start()
    opcodes = [opcode for opcode in Opcode if not opcode.is_answer and opcode is not Opcode.RESET]

    async def work() -> None:
        pair = Pair(bench)
        await pair.board.wait(1)
        bench.check("rate", int(dut.phase_step.value), bench.config.default_phase_step)
        draw = bench.draw
        for opcode in (Opcode.HELLO, *draw.sample(opcodes, len(opcodes)), Opcode.RESET, Opcode.TRIANGLES):
            await pair.ask(opcode, good_payload(draw, opcode, 3))
            if bench.chance(0.1):
                await pair.line_break()
        bench.check("effects", pair.board.effects.done, pair.model.drawing.done)
        bench.check("rate at the end", pair.board.rate, pair.model.phase_step)

    gates = [(f"{name}_valid", f"{name}_ready") for name in GATES]
    lines = ["line_valid", ("send_valid", "send_ready"), "frame_seen", "core_reset", "frame_crc_done"]
    quiet = [
        *(f"{name}_valid" for name in (*GATES, "send")),
        "core_reset",
    ]
    await reset_amid(bench, work, [*gates, *lines], rounds=12, quiet=quiet)
    bench.finish(at_least=100)
