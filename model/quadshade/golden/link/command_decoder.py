# SPDX-License-Identifier: Apache-2.0
"""The board's end of the link, frame by frame (``rtl/link/command_decoder.vhd``)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import NamedTuple

from quadshade.contract.identity import has_feature, knows, plane_bytes
from quadshade.contract.protocol import (
    ANSWER_BIT,
    COUNTERS,
    CRC_BYTES,
    HEADER_BYTES,
    IDENTITY,
    MAX_BODY,
    PADDING,
    SEQUENCES,
    WORD_BYTES,
    Opcode,
    Reason,
)
from quadshade.golden.link.answer_sender import answer_bytes
from quadshade.golden.link.cobs_decoder import CobsDecoder
from quadshade.golden.link.cobs_encoder import encode_line
from quadshade.golden.link.command_executor import Command, Drawing, begin, execute
from quadshade.golden.link.frame_fifo import FrameFifo
from quadshade.golden.link.frame_receiver import FrameReceiver, Reach


def words_of(data: bytes) -> list[int]:
    """Whole words, lowest byte first."""
    return [int.from_bytes(data[at : at + WORD_BYTES], "little") for at in range(0, len(data), WORD_BYTES)]


def identity_words(identity: Mapping[str, int]) -> list[int]:
    """HELLO's words behind the session."""
    data = b"".join(identity.get(name, 0).to_bytes(size, "little") for name, size, _ in (*IDENTITY, PADDING))
    return words_of(data)


class Answer(NamedTuple):
    """An answer that is begun, with a result's bytes; other words are those of when it is sent."""

    opcode: int
    number: int
    reason: Reason = Reason.NONE
    data: bytes = b""


class CommandDecoder:
    """
    Bytes of the line to commands and answers.

    Answers are sent at once, unless ``holding`` is set: then one is begun, and the others wait as in the
    hardware, where of several that were asked at once (HELLO, STATUS, RESET, BAUD), of several NAKs, and of
    several ACKs only the last one is sent.

    Parameters
    ----------
    identity : mapping of str to int
      Every field of ``protocol.IDENTITY``.
    drawing : Drawing
      What commands act on.
    most_counter_bits : int
      STATUS's counters have no more bits.

    Attributes
    ----------
    stalled : bool
      While it is set, the oldest command waits for the core, and the others in the FIFO.
    holding : bool
      While it is set, an answer that is begun is sent by :meth:`finish_answer` alone.
    phase_step : int
      The rate: BAUD's after its answer, the default one after :meth:`line_break`.
    counts : Counter of str
      What STATUS counts, but for what ``drawing`` does.
    """

    def __init__(self, identity: Mapping[str, int], drawing: Drawing, most_counter_bits: int = 32) -> None:
        self.identity, self.drawing = identity, drawing
        self.most_counter_bits = most_counter_bits
        self.session = 0
        self.stalled = self.holding = False
        self.phase_step = identity["default_phase_step"]
        self._asked_step = 0
        self._decoder, self._body = CobsDecoder(), bytearray()
        self._begin()

    def _begin(self) -> None:
        size = (self.identity["screen_width"], self.identity["screen_height"])
        swaps, packs = knows(self.identity, Opcode.SWAP), has_feature(self.identity, "packed_read")
        self.receiver = FrameReceiver(Reach(*size, plane_bytes(self.identity), swaps, packs))
        self.fifo = FrameFifo(self.identity["fifo_words"])
        self.counts: Counter[str] = Counter()
        self._free_told = self.fifo.free
        self._command: Command | None = None
        self._result: bytes | int | None = None
        self._reply: tuple[Opcode, int] | None = None
        self._nak: tuple[int, Reason] | None = None
        self._ack: int | None = None
        self._sent: Answer | None = None
        self._step_due = False

    def feed(self, line: bytes) -> bytes:
        """
        Take bytes of the line, execute what can be executed, and answer.

        Parameters
        ----------
        line : bytes

        Returns
        -------
        bytes
          Of the line, back.
        """
        answers = b""
        for byte in line:
            decoded = self._decoder.add(byte)
            if decoded.data is not None and len(self._body) <= MAX_BODY:
                self._body.append(decoded.data)
            if decoded.end:
                self._frame(bytes(self._body), decoded.good)
                self._body.clear()
                answers += self.run()
        return answers

    def line_break(self) -> None:
        """The line was low for as long as a break is."""
        self.phase_step = self.identity["default_phase_step"]
        self._step_due = False
        if self._reply is not None and self._reply[0] is Opcode.BAUD:
            self._reply = None

    def run(self) -> bytes:
        """Execute what waits, unless stalled, and send what is due, unless holding; the answers."""
        answers = b""
        while True:
            if self._sent is None:
                self._sent = self._next_answer()
            if self._sent is not None and not self.holding:
                answers += self.finish_answer()
            elif not self._step():
                return answers

    @property
    def sending(self) -> bool:
        """Whether an answer is begun."""
        return self._sent is not None

    def _tell_credits(self) -> None:
        """An ACK with a quarter of the FIFO free since the last link state, unless an answer tells it."""
        due = (self._sent, self._reply, self._nak, self._ack, self._result)
        told = any(one is not None for one in due)
        if not told and self.fifo.free - self._free_told >= self.fifo.num_words // 4:
            self._ack = (self.receiver.expected - 1) % SEQUENCES

    def _step(self) -> bool:
        """Begin a command, or execute the one that is begun; False if neither can be."""
        if self._result is not None:
            return False
        if self._command is None:
            if not self.fifo.committed:
                return False
            self._command = begin(self.fifo)
        elif self.stalled:
            return False
        else:
            self._result = execute(self._command, self.fifo, self.drawing)
            self._command = self._command if self._result is not None else None
        self._tell_credits()
        return True

    def _next_answer(self) -> Answer | None:
        """The answer that is begun next, if one is due."""
        if self._reply is not None:
            (opcode, number), self._reply = self._reply, None
            self._step_due = opcode is Opcode.BAUD
            return Answer(opcode | ANSWER_BIT, number)
        if self._nak is not None:
            (number, reason), self._nak = self._nak, None
            return Answer(Opcode.NAK, number, reason)
        if self._ack is not None:
            number, self._ack = self._ack, None
            return Answer(Opcode.ACK, number)
        if self._command is None or self._result is None:
            return None
        (opcode, number, _, _), result = self._command, self._result
        if isinstance(result, bytes):
            return Answer(opcode | ANSWER_BIT, number, data=result)
        return Answer(opcode | ANSWER_BIT, number, data=result.to_bytes(WORD_BYTES, "little"))

    def finish_answer(self) -> bytes:
        """
        Send the answer that is begun, with the link state and the counters of this moment.

        Returns
        -------
        bytes
          Of the line; none if no answer is begun.
        """
        if self._sent is None:
            return b""
        answer, self._sent = self._sent, None
        words: list[int] = []
        if answer.opcode == Opcode.HELLO_ANSWER:
            words = [self.session, *identity_words(self.identity)]
        elif answer.opcode == Opcode.STATUS_ANSWER:
            most = self.most_counter_bits
            words = [self.counts[name] % (1 << min(bits, most)) for name, bits, _ in COUNTERS]
        if self._step_due:
            self.phase_step, self._step_due = self._asked_step, False
        self._free_told = self.fifo.free
        state = self.receiver.expected | answer.reason << 8 | self.fifo.free << 16
        if answer.opcode in (Opcode.READ_ANSWER, Opcode.FRAME_CRC_ANSWER):
            # Only now may the next command begin.
            self._command = self._result = None
        return encode_line(answer_bytes(answer.opcode, answer.number, [state, *words], answer.data))

    def _frame(self, body: bytes, whole: bool) -> None:
        """A frame that ended."""
        length = int.from_bytes(body[2:4], "little")
        for word in words_of(body[: min(HEADER_BYTES + length, len(body) - CRC_BYTES)]):
            self.fifo.write(word)
        verdict = self.receiver.judge(body, whole, self.fifo.overflow)
        if verdict.counter:
            self.counts[verdict.counter] += 1
        if verdict.commit:
            self.fifo.commit()
        self.fifo.discard()
        if verdict.nak:
            self._nak = body[1], verdict.reason
        if verdict.ack:
            self._ack = body[1]
        if verdict.request:
            self._request(Opcode(body[0]), body[1], words_of(body[HEADER_BYTES:-CRC_BYTES]))

    def _request(self, opcode: Opcode, number: int, argument: list[int]) -> None:
        """HELLO, STATUS, RESET or BAUD."""
        if opcode is Opcode.RESET:
            # Also what is being sent ends.
            (self.session,) = argument
            self._begin()
            self.drawing.reset()
        elif opcode is Opcode.BAUD:
            (self._asked_step,) = argument
        self._reply = opcode, number
