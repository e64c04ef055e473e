# SPDX-License-Identifier: Apache-2.0
"""The board's end of the link, frame by frame (``rtl/link/command_decoder.vhd``)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

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
    plane_bytes,
)
from quadshade.golden.link.answer_sender import answer_bytes
from quadshade.golden.link.cobs_decoder import CobsDecoder
from quadshade.golden.link.cobs_encoder import encode_line
from quadshade.golden.link.command_executor import Drawing, execute
from quadshade.golden.link.frame_fifo import FrameFifo
from quadshade.golden.link.frame_receiver import FrameReceiver, Reach, Verdict


def words_of(data: bytes) -> list[int]:
    """Whole words, lowest byte first."""
    return [int.from_bytes(data[at : at + WORD_BYTES], "little") for at in range(0, len(data), WORD_BYTES)]


def identity_words(identity: Mapping[str, int]) -> list[int]:
    """HELLO's words behind the session."""
    data = b"".join(identity.get(name, 0).to_bytes(size, "little") for name, size, _ in (*IDENTITY, PADDING))
    return words_of(data)


class CommandDecoder:
    """
    Bytes of the line to commands and answers.

    The hardware sends one ACK for several frames where it is busy sending; here each has its own.

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
      While it is set, accepted commands wait in the FIFO.
    phase_step : int
      The rate, after BAUD.
    counts : Counter of str
      What STATUS counts, but for what ``drawing`` does.
    """

    def __init__(self, identity: Mapping[str, int], drawing: Drawing, most_counter_bits: int = 32) -> None:
        self.identity, self.drawing = identity, drawing
        self.most_counter_bits = most_counter_bits
        self.session = 0
        self.stalled = False
        self.phase_step = identity["default_phase_step"]
        self._decoder, self._body = CobsDecoder(), bytearray()
        self._begin()

    def _begin(self) -> None:
        size = (self.identity["screen_width"], self.identity["screen_height"])
        self.receiver = FrameReceiver(Reach(*size, plane_bytes(self.identity)))
        self.fifo = FrameFifo(self.identity["fifo_words"])
        self.counts: Counter[str] = Counter()
        self._free_told = self.fifo.free

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
                answers += self._frame(bytes(self._body), decoded.good)
                self._body.clear()
                answers += self.run()
        return answers

    def run(self) -> bytes:
        """Execute what waits, unless stalled; the answers."""
        answers = b""
        while self.fifo.committed and not self.stalled:
            opcode, number, result = execute(self.fifo, self.drawing)
            if isinstance(result, bytes):
                answers += self._answer(opcode | ANSWER_BIT, number, data=result)
            elif result is not None:
                answers += self._answer(opcode | ANSWER_BIT, number, words=[result])
            if self.fifo.free - self._free_told >= self.fifo.num_words // 4:
                answers += self._answer(Opcode.ACK, (self.receiver.expected - 1) % SEQUENCES)
        return answers

    def _answer(
        self,
        opcode: int,
        number: int,
        words: Sequence[int] = (),
        data: bytes = b"",
        reason: Reason = Reason.NONE,
    ) -> bytes:
        """An answer on the line, with the link state of this moment."""
        self._free_told = self.fifo.free
        state = self.receiver.expected | reason << 8 | self.fifo.free << 16
        return encode_line(answer_bytes(opcode, number, [state, *words], data))

    def _frame(self, body: bytes, whole: bool) -> bytes:
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
        return self._reply(verdict, body)

    def _reply(self, verdict: Verdict, body: bytes) -> bytes:
        """What a verdict is answered by."""
        if verdict.nak:
            return self._answer(Opcode.NAK, body[1], reason=verdict.reason)
        if verdict.ack:
            return self._answer(Opcode.ACK, body[1])
        if verdict.request:
            return self._request(Opcode(body[0]), body[1], words_of(body[HEADER_BYTES:-CRC_BYTES]))
        return b""

    def _request(self, opcode: Opcode, number: int, argument: list[int]) -> bytes:
        """HELLO, STATUS, RESET or BAUD."""
        words: list[int] = []
        if opcode is Opcode.RESET:
            (self.session,) = argument
            self._begin()
            self.drawing.reset()
        elif opcode is Opcode.BAUD:
            (self.phase_step,) = argument
        elif opcode is Opcode.HELLO:
            words = [self.session, *identity_words(self.identity)]
        else:
            most = self.most_counter_bits
            words = [self.counts[name] % (1 << min(bits, most)) for name, bits, _ in COUNTERS]
        return self._answer(opcode | ANSWER_BIT, number, words)
