# SPDX-License-Identifier: Apache-2.0
"""The model of the board's end of the link: verdicts and answers, literally; what stays in its FIFO."""

from __future__ import annotations

from dataclasses import dataclass, field

import pytest

from quadshade.contract import protocol
from quadshade.contract.protocol import MAX_BODY, PHASE_BITS, Opcode, Reason, pack_payload, unpack_payload
from quadshade.golden.link.cobs_encoder import encode_line
from quadshade.golden.link.command_decoder import CommandDecoder
from quadshade.golden.link.frame_fifo import FrameFifo
from quadshade.golden.link.frame_receiver import FrameReceiver, Reach, Verdict
from quadshade.golden.link.uart_rx import Outputs, UartRx
from quadshade.golden.link.uart_tx import UartTx
from quadshade.link.frames import Frame, FrameParser, sealed

CLEAR = pack_payload(Opcode.CLEAR, {"colour": 0x01020304})
READ = {"x": 0, "y": 0, "width": 2, "count": 6, "pixels": 2, "plane": 0}


def body(opcode: int, number: int, payload: bytes = b"", length: int | None = None) -> bytes:
    """Of a frame, right or wrong."""
    size = len(payload) if length is None else length
    return sealed(bytes([opcode, number]) + size.to_bytes(2, "little") + payload)


def test_numbers_are_taken_once_and_in_order() -> None:
    receiver = FrameReceiver()
    taken = Verdict(commit=True, ack=True, counter="frames")
    again = Verdict(ack=True, counter="duplicates")
    assert receiver.is_in_order
    assert [receiver.judge(body(Opcode.CLEAR, number, CLEAR)) for number in range(200)] == [taken] * 200
    assert receiver.expected == 200 and receiver.is_in_order
    # Up to half of all numbers behind is behind.
    for number in (199, 201 - 129, 72):
        assert receiver.judge(body(Opcode.CLEAR, number, CLEAR)) == again
    assert not receiver.is_in_order
    ahead = Verdict(nak=True, reason=Reason.OUT_OF_ORDER, counter="gaps")
    assert receiver.judge(body(Opcode.CLEAR, 71, CLEAR)) == ahead
    # What follows a gap in order is not refused again.
    assert receiver.judge(body(Opcode.CLEAR, 210, CLEAR)) == ahead
    assert receiver.judge(body(Opcode.CLEAR, 211, CLEAR)) == Verdict(counter="gaps")
    assert receiver.judge(body(Opcode.CLEAR, 200, CLEAR), overflow=True) == Verdict(
        nak=True, reason=Reason.NO_ROOM, counter="overruns"
    )
    assert receiver.expected == 200
    assert receiver.judge(body(Opcode.CLEAR, 200, CLEAR)) == taken


@pytest.mark.parametrize(
    ("frame", "verdict"),
    [
        (body(Opcode.HELLO, 0), Verdict(request=True)),
        (b"\0" * 7, Verdict(counter="bad_length")),
        (b"\1" * 8, Verdict(counter="bad_crc")),
        (body(Opcode.TRIANGLES, 0, bytes(MAX_BODY - 8)), Verdict(commit=True, ack=True, counter="frames")),
        (body(Opcode.TRIANGLES, 0, bytes(MAX_BODY - 7)), Verdict(counter="bad_length")),
        (body(Opcode.ACK, 0), Verdict(counter="refused")),
        (body(Opcode.ACK, 0, b"", 4), Verdict(counter="bad_length")),
        (body(5, 0), Verdict(nak=True, reason=Reason.UNKNOWN_OPCODE, counter="refused")),
        (body(Opcode.HELLO, 0, b"", 4), Verdict(nak=True, reason=Reason.BAD_LENGTH, counter="bad_length")),
    ],
    ids=range(9),
)
def test_what_a_frame_is_worth(frame: bytes, verdict: Verdict) -> None:
    assert FrameReceiver().judge(frame) == verdict
    assert FrameReceiver().judge(frame, whole=False) == Verdict(counter="bad_cobs")


@pytest.mark.parametrize(
    ("step", "good"),
    [(0, False), (1, True), (2, True), (1 << (PHASE_BITS - 2), True), ((1 << (PHASE_BITS - 2)) + 1, False)],
)
def test_rates_up_to_a_quarter(step: int, good: bool) -> None:
    verdict = FrameReceiver().judge(body(Opcode.BAUD, 0, step.to_bytes(4, "little")))
    assert verdict == (
        Verdict(request=True) if good else Verdict(nak=True, reason=Reason.BAD_FIELD, counter="refused")
    )


def test_areas_and_planes_within_reach() -> None:
    assert [Reach().holds(plane) for plane in range(5)] == [True, True, False, False, False]
    one = {"x": 0, "y": 0, "width": 1, "pixels": 1}
    sizes = [[n for n in range(9) if Reach(8, 4).holds_area(**one, count=n, plane=p)] for p in range(4)]
    assert sizes == [[1, 2, 3], [1, 2], [], []]
    reach = Reach(8, 4, (3, 2, 2, 0))
    good = {"x": 6, "y": 3, "width": 2, "count": 6, "pixels": 2, "plane": 0}
    assert reach.holds_area(**good)
    assert reach.holds_area(**{**good, "count": 4}) and reach.holds_area(**{**good, "plane": 1, "count": 3})
    for wrong in (
        {"x": 7},
        {"y": 4},
        {"width": 0},
        {"width": 3},
        {"width": 1},
        {"count": 0, "pixels": 0},
        {"count": 7},
        {"count": 3},
        {"count": 7, "pixels": 3},
        {"plane": 3},
        {"plane": 4},
        {"plane": 1},
    ):
        assert not reach.holds_area(**{**good, **wrong}), wrong
    most = {"x": 0, "y": 0, "width": 2000, "plane": 0}
    large = Reach(2000, 2000, (1,))
    assert large.holds_area(**most, count=protocol.MAX_READ, pixels=protocol.MAX_READ)
    assert not large.holds_area(**most, count=protocol.MAX_READ + 1, pixels=protocol.MAX_READ + 1)


@dataclass
class Recorder:
    """Notes what commands do."""

    done: list[tuple] = field(default_factory=list)

    def triangles(self, words: list[int]) -> None:
        self.done.append(("triangles", *words))

    def state(self, address: int, value: int) -> None:
        self.done.append(("state", address, value))

    def clear(self, colour: int) -> None:
        self.done.append(("clear", colour))

    def read(self, **fields: int) -> bytes:
        self.done.append(("read", fields))
        return bytes(range(1, 1 + fields["count"]))

    def frame_crc(self, plane: int) -> int:
        self.done.append(("frame_crc", plane))
        return 0x01020304

    def reset(self) -> None:
        self.done.append(("reset",))


@pytest.fixture
def decoder() -> CommandDecoder:
    identity = {name: 0 for name, _, _ in protocol.IDENTITY}
    identity |= {"fifo_words": 16, "screen_width": 8, "screen_height": 4, "colour_bytes": 3, "magic": 7}
    return CommandDecoder(identity | {"default_phase_step": 99}, Recorder(), most_counter_bits=3)


def said(decoder: CommandDecoder, *frames: tuple) -> list[tuple[str, int, dict, bytes]]:
    """What is answered to frames: opcode, number, fields, and bytes behind them."""
    answers = decoder.feed(b"".join(encode_line(body(*frame)) for frame in frames))
    return parsed(answers)


def parsed(line: bytes) -> list[tuple[str, int, dict, bytes]]:
    frames = list(FrameParser().feed(line))
    assert all(isinstance(frame, Frame) for frame in frames)
    return [(f.opcode.name, f.sequence, *unpack_payload(f.opcode, f.payload)) for f in frames]


def state(expected: int, free: int = 16, reason: Reason = Reason.NONE) -> dict[str, int]:
    return {"expected": expected, "reason": reason, "free": free}


def test_commands_are_executed_and_answered(decoder: CommandDecoder) -> None:
    done = decoder.drawing.done
    # Acknowledged with the room that there is before it is executed.
    assert said(decoder, (Opcode.CLEAR, 0, CLEAR)) == [("ACK", 0, state(1, 14), b"")]
    assert done == [("clear", 0x01020304)]
    payload = pack_payload(Opcode.STATE, {"address": 0xFFFFFFFF}, bytes([1, 0, 0, 0, 2, 0, 0, 0]))
    said(decoder, (Opcode.STATE, 1, payload))
    assert done[1:] == [("state", 0xFFFFFFFF, 1), ("state", 0, 2)]
    said(decoder, (Opcode.TRIANGLES, 2, bytes([1, 0, 0, 0, 2, 0, 0, 1])))
    assert done[3:] == [("triangles", 1, 0x01000002)]
    answers = said(decoder, (Opcode.READ, 3, pack_payload(Opcode.READ, READ)))
    assert done[4:] == [("read", READ)]
    assert ("READ_ANSWER", 3, state(4), bytes([1, 2, 3, 4, 5, 6])) in answers
    answers = said(
        decoder, (Opcode.FRAME_CRC, 4, pack_payload(Opcode.FRAME_CRC, {"reserved": 0, "plane": 0}))
    )
    assert done[5:] == [("frame_crc", 0)]
    assert ("FRAME_CRC_ANSWER", 4, {**state(5), "crc": 0x01020304}, b"") in answers
    assert decoder.counts == {"frames": 5}


def test_requests_are_answered_at_once(decoder: CommandDecoder) -> None:
    ((name, number, fields, _),) = said(decoder, (Opcode.HELLO, 9))
    assert (name, number, fields["session"], fields["magic"]) == ("HELLO_ANSWER", 9, 0, 7)
    (answer,) = said(decoder, (Opcode.RESET, 8, pack_payload(Opcode.RESET, {"session": 0x04030201})))
    assert answer == ("RESET_ANSWER", 8, state(0), b"") and decoder.drawing.done == [("reset",)]
    assert said(decoder, (Opcode.HELLO, 9))[0][2]["session"] == 0x04030201
    said(decoder, *[(5, number) for number in range(9)])
    ((name, number, fields, _),) = said(decoder, (Opcode.STATUS, 7))
    # Counters of three bits.
    assert (name, number, fields["refused"], fields["frames"]) == ("STATUS_ANSWER", 7, 1, 0)
    assert decoder.phase_step == 99
    assert said(decoder, (Opcode.BAUD, 6, (5).to_bytes(4, "little"))) == [("BAUD_ANSWER", 6, state(0), b"")]
    assert decoder.phase_step == 5
    said(decoder, (Opcode.HELLO, 9))
    assert decoder.phase_step == 5
    decoder.line_break()
    assert decoder.phase_step == 99


def test_refusals_carry_number_and_reason(decoder: CommandDecoder) -> None:
    assert said(decoder, (5, 77)) == [("NAK", 77, state(0, reason=Reason.UNKNOWN_OPCODE), b"")]
    assert said(decoder, (Opcode.CLEAR, 3, CLEAR)) == [("NAK", 3, state(0, reason=Reason.OUT_OF_ORDER), b"")]
    assert said(decoder, (Opcode.TRIANGLES, 0, bytes(64))) == [
        ("NAK", 0, state(0, reason=Reason.NO_ROOM), b"")
    ]
    assert decoder.fifo.free == 16 and not decoder.drawing.done
    assert decoder.feed(b"\0" + b"\2" * 30) == b"" and not decoder.fifo.written


def test_a_stalled_board_keeps_commands_and_holds_answers(decoder: CommandDecoder) -> None:
    decoder.stalled = True
    assert said(decoder, (Opcode.TRIANGLES, 0, bytes(12)), (Opcode.CLEAR, 1, CLEAR)) == [
        ("ACK", 0, state(1, 12), b""),
        ("ACK", 1, state(2, 11), b""),
    ]
    assert not decoder.drawing.done
    decoder.holding, decoder.stalled = True, False
    assert decoder.run() == b"" and decoder.sending
    assert len(decoder.drawing.done) == 2
    assert parsed(decoder.finish_answer()) == [("ACK", 1, state(2), b"")]
    assert not decoder.sending and decoder.finish_answer() == b""
    # What became free while it was held it has told: no other is due.
    decoder.holding = False
    assert decoder.run() == b""


def test_credits_are_told_when_a_quarter_is_free_again(decoder: CommandDecoder) -> None:
    """Of 16 words: a command of four frees a quarter, one of three less."""
    for number, (size, told) in enumerate([(12, [("ACK", 0, state(1), b"")]), (8, [])]):
        decoder.stalled = True
        waiting = ("ACK", number, state(number + 1, 16 - 1 - size // 4), b"")
        assert said(decoder, (Opcode.TRIANGLES, number, bytes(size))) == [waiting]
        decoder.stalled = False
        assert parsed(decoder.run()) == told
        assert decoder.fifo.free == 16


def test_a_frame_one_byte_too_long_is_no_frame(decoder: CommandDecoder) -> None:
    """Without its last byte it would be one that does not fit into the FIFO."""
    longest = body(Opcode.TRIANGLES, 0, bytes(MAX_BODY - 8))
    assert decoder.feed(encode_line(longest + b"\1")) == b""
    assert decoder.counts == {"bad_length": 1}
    assert parsed(decoder.feed(encode_line(longest)))[0][2]["reason"] == Reason.NO_ROOM


def test_every_word_of_a_long_frame_is_executed(decoder: CommandDecoder) -> None:
    """A length of more than a byte."""
    decoder = CommandDecoder(decoder.identity | {"fifo_words": 512}, Recorder())
    words = list(range(1, 71))
    payload = b"".join(word.to_bytes(4, "little") for word in words)
    assert said(decoder, (Opcode.TRIANGLES, 0, payload))[0] == ("ACK", 0, state(1, 512 - 71), b"")
    assert decoder.drawing.done == [("triangles", *words)]


def test_frames_stay_whole_in_the_fifo() -> None:
    fifo = FrameFifo(4)
    for word in range(4):
        fifo.write(word)
    fifo.commit()
    assert (fifo.committed, fifo.written, fifo.free, fifo.overflow) == ([0, 1, 2, 3], [], 0, False)
    assert [fifo.take(), fifo.take()] == [0, 1]
    for word in range(3):
        fifo.write(word)
    assert fifo.overflow and fifo.free == 2
    fifo.commit()
    assert (fifo.committed, fifo.written, fifo.overflow) == ([2, 3], [], False)


def test_the_receiver_after_a_reset_and_between_characters() -> None:
    assert Outputs() == Outputs(False, 0, False, False)
    uart, quarter = UartRx(), 1 << (PHASE_BITS - 2)
    assert uart._samples == [1, 1]
    for level in (1, 0, 0, 0, 0, 1, 1):
        uart.clock(level, quarter)
    uart.reset()
    assert uart._samples == [1, 1] and uart.outputs == Outputs()


def test_the_transmitter_is_ready_in_the_last_clock_of_a_character() -> None:
    uart, quarter = UartTx(), 1 << (PHASE_BITS - 2)
    ready, line = [], []
    for _ in range(81):
        ready.append(uart.ready(quarter))
        uart.clock(0xA5, quarter)
        line.append(uart.tx)
    assert [index for index, one in enumerate(ready) if one] == [0, 40, 80]
    assert line[:40] == [level for level in (0, 1, 0, 1, 0, 0, 1, 0, 1, 1) for _ in range(4)]
