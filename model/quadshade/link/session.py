# SPDX-License-Identifier: Apache-2.0
"""A host's session with a board: numbers, window, credits and repetition."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from quadshade.contract.protocol import (
    HEADER_BYTES,
    MAX_PAYLOAD,
    PHASE_BITS,
    SEQUENCES,
    WORD_BYTES,
    BoardResetError,
    LinkError,
    Opcode,
    Reason,
    fifo_words,
    pack_payload,
    phase_step,
    unpack_payload,
)
from quadshade.link.exchange import ANSWER_SECONDS, RETRIES, Exchange
from quadshade.link.frames import Frame
from quadshade.link.transport import Transport

MAX_WORDS = MAX_PAYLOAD // WORD_BYTES
LEAST_WORDS = 4
"""A bad line gets short frames, down to this."""

FRAME_COUNTS = 1 << 32
"""STATUS's counter of frames wraps here."""


@dataclass
class Pending:
    """A sequenced frame that is not acknowledged."""

    frame: Frame
    words: int


class Session(Exchange):
    """
    A conversation with a board: what is sent arrives once and in order, or there is an error.

    Parameters
    ----------
    transport, answer_seconds, retries, trace, reopen
      As for :class:`quadshade.link.exchange.Exchange`.
    """

    def __init__(
        self,
        transport: Transport,
        answer_seconds: float = ANSWER_SECONDS,
        retries: int = RETRIES,
        trace: Callable[[str], None] | None = None,
        reopen: Callable[[], Transport] | None = None,
    ) -> None:
        super().__init__(transport, answer_seconds, retries, trace, reopen)
        self._results: dict[int, bytes] = {}
        self._frame_words = MAX_WORDS
        self._clean = 0
        self._restart()

    def _restart(self) -> None:
        """What is so after RESET."""
        self._pending: deque[Pending] = deque()
        # What the line lost and credits do not allow yet.
        self._backlog: deque[tuple[Opcode, bytes]] = deque()
        self._next = self._free = self._attempts = self._accepted = 0

    def _attempt(self, what: str) -> None:
        """Count a repetition of something."""
        self._attempts += 1
        if self._attempts > self.retries:
            raise self.too_bad(what)

    def _other(self, answer: Frame) -> None:
        self._result(answer)
        if self._pending:
            self._state(answer)

    # The session.

    def connect(self, reset: bool = True) -> dict[str, int]:
        """
        Ask who is there, check it, and begin anew.

        Parameters
        ----------
        reset : bool
          False only looks, and sends nothing but HELLO.

        Returns
        -------
        dict of int
          The board's identity.

        Raises
        ------
        LinkError
          No answer, no Quadshade board, another version, or other formats.
        """
        self._restart()
        identity = self.hello()
        if reset:
            self.reset()
        return identity

    def reset(self) -> None:
        """RESET: the board forgets frames, counters and a begun packet; the screen stays."""
        self._restart()
        fields = self.new_session()
        self._restart()
        self._free = fields["free"]

    @property
    def default_baud(self) -> int:
        """The board's rate after power-up and after a break."""
        step, clock = self.identity["default_phase_step"], self.identity["clk_frequency_hz"]
        return round(step * clock / (1 << PHASE_BITS))

    def set_baud(self, baud: int) -> None:
        """
        Another baud rate, on both sides; everything sent must have been answered.

        Raises
        ------
        LinkError
          The line has one rate only, the board's clock does not allow this one, or it does not answer at it.
        """
        if getattr(self.transport, "fixed_rate", False):
            raise LinkError(f"the baud rate of {self.name} cannot be changed", "leave the rate out")
        step = phase_step(baud, self.identity["clk_frequency_hz"])
        default = self.default_baud
        self.flush()
        self.request(Opcode.BAUD, phase_step=step)
        self.transport.set_baud(baud)
        try:
            self.request(Opcode.HELLO)
        except LinkError:
            self.transport.send_break()
            self.transport.set_baud(default)
            self.request(Opcode.HELLO)
            raise LinkError(f"the board does not answer at {baud} baud", "use a lower rate") from None

    def status(self) -> dict[str, int]:
        """The board's counters and link state."""
        return self.request(Opcode.STATUS)

    def check(self) -> dict[str, int]:
        """
        STATUS, once everything is acknowledged: the board must have accepted as many frames as it was sent.

        Raises
        ------
        BoardResetError
          It was reset meanwhile.
        """
        self.flush()
        fields = self.status()
        self._check_count(fields)
        return fields

    def _check_count(self, fields: dict[str, int]) -> None:
        """
        That the board is in this session: its count of frames says so, for after a reset it is another.

        A small board counts in fewer bits than the host. Where only the count differs, its session decides.
        """
        count = (fields["frames"] - self._accepted) % FRAME_COUNTS
        number = (fields["expected"] - self._accepted) % SEQUENCES
        if number > len(self._pending):
            raise self._lost()
        if count != number and self.request(Opcode.HELLO)["session"] != self.number:
            raise self._lost()

    @staticmethod
    def _lost() -> BoardResetError:
        return BoardResetError("the board has lost the session: it was reset meanwhile", "start again")

    # Sequenced frames.

    def _send(self, opcode: Opcode, payload: bytes) -> int:
        """Send a sequenced frame as soon as window and credits allow; its number."""
        while self._backlog or not self._fits(payload):
            self._wait()
        return self._number(opcode, payload)

    def _fits(self, payload: bytes) -> bool:
        """Whether window and credits allow another frame."""
        words = sum(one.words for one in self._pending) + fifo_words(len(payload))
        return len(self._pending) < SEQUENCES // 4 and words <= self._free

    def _number(self, opcode: Opcode, payload: bytes) -> int:
        """Send a frame with the next number, which is given back."""
        number = self._next
        self._next = (number + 1) % SEQUENCES
        self._pending.append(Pending(Frame(opcode, number, payload), fifo_words(len(payload))))
        self._transmit(self._pending[-1].frame)
        return number

    def _wait(self) -> None:
        """One answer, or what follows from none."""
        answer = self._receive()
        if answer is None or answer.opcode is Opcode.NAK and answer.payload[1] == Reason.OUT_OF_ORDER:
            self._recover()
        else:
            self._result(answer)
            self._state(answer)
        while self._backlog and self._fits(self._backlog[0][1]):
            self._number(*self._backlog.popleft())

    def _result(self, answer: Frame) -> None:
        """Keep READ's and FRAME_CRC's results, and stop at a refusal that repetition does not help."""
        _, data = unpack_payload(answer.opcode, answer.payload)
        if answer.opcode in (Opcode.READ_ANSWER, Opcode.FRAME_CRC_ANSWER):
            self._results[answer.sequence] = data or answer.payload[-WORD_BYTES:]
        refusals = (Reason.UNKNOWN_OPCODE, Reason.BAD_LENGTH, Reason.BAD_FIELD)
        if answer.opcode is Opcode.NAK and answer.payload[1] in refusals:
            reason = Reason(answer.payload[1]).name.lower().replace("_", " ")
            raise LinkError(f"the board refuses frame {answer.sequence}: {reason}")

    def _state(self, answer: Frame) -> None:
        """Acknowledgement and credits of any answer."""
        expected, free = answer.payload[0], int.from_bytes(answer.payload[2:HEADER_BYTES], "little")
        first = (self._next - len(self._pending)) % SEQUENCES
        done = (expected - first) % SEQUENCES
        if done > len(self._pending):
            raise self._lost()
        for _ in range(done):
            self._pending.popleft()
        self._accepted = (self._accepted + done) % FRAME_COUNTS
        self._free = free
        if done:
            self._attempts = 0
            self._clean += done
            if self._clean > 64:
                self._frame_words, self._clean = min(2 * self._frame_words, MAX_WORDS), 0

    def _recover(self) -> None:
        """Ask where the board stands; then send what it does not have, in shorter frames."""
        self._attempt("a frame")
        self.statistics["recoveries"] += 1
        self._clean = 0
        fields = self.status()
        self._check_count(fields)
        state = fields["expected"].to_bytes(1, "little") + b"\0" + fields["free"].to_bytes(2, "little")
        self._state(Frame(Opcode.ACK, 0, state))
        lost = list(self._pending)
        if not lost:
            return
        # The line keeps its order: no copy of these is on its way any more, their numbers are free again.
        self._frame_words = max(LEAST_WORDS, self._frame_words // 2)
        self._pending.clear()
        self._next = fields["expected"]
        self.statistics["resent"] += len(lost)
        again = [(one.frame.opcode, one.frame.payload) for one in lost]
        self._backlog = deque(self._cut([*again, *self._backlog]))

    def _cut(self, frames: list[tuple[Opcode, bytes]]) -> Iterator[tuple[Opcode, bytes]]:
        """Frames again, with no more set-up words than they now may have, but no questions: `ask` repeats."""
        size = self._frame_words * WORD_BYTES
        for opcode, payload in frames:
            if opcode is Opcode.TRIANGLES:
                yield from ((opcode, payload[at : at + size]) for at in range(0, len(payload), size))
            elif opcode not in (Opcode.READ, Opcode.FRAME_CRC):
                yield opcode, payload

    def flush(self) -> None:
        """Wait until every frame is acknowledged."""
        while self._pending or self._backlog:
            self._wait()

    # What a user wants.

    def triangles(self, words: Sequence[int] | np.ndarray) -> None:
        """Set-up words, (m,) uint32, as many frames as they need."""
        data = np.ascontiguousarray(words, dtype="<u4").tobytes()
        while data:
            size = self._frame_words * WORD_BYTES
            self._send(Opcode.TRIANGLES, data[:size])
            data = data[size:]

    def clear(self, colour: int = 0) -> None:
        """Fill the screen with a colour, the first channel in the lowest byte, and empty the depth."""
        self._send(Opcode.CLEAR, pack_payload(Opcode.CLEAR, {"colour": colour}))

    def swap(self) -> None:
        """Show what was drawn, and draw the other of two buffers; returns once that is accepted."""
        self._send(Opcode.SWAP, pack_payload(Opcode.SWAP))
        self.flush()

    def state(self, address: int, words: Sequence[int] | np.ndarray) -> None:
        """Words of the shading state, from an address on."""
        data = np.ascontiguousarray(words, dtype="<u4").tobytes()
        most = MAX_PAYLOAD - WORD_BYTES
        for at in range(0, len(data), most):
            fields = {"address": address + at // WORD_BYTES}
            self._send(Opcode.STATE, pack_payload(Opcode.STATE, fields, data[at : at + most]))

    def ask(self, opcode: Opcode, questions: list[dict[str, int]]) -> dict[int, bytes]:
        """
        READs or FRAME_CRCs on their way together, once.

        Parameters
        ----------
        opcode : Opcode
        questions : list of dict of int
          Their fields; a few, as all are sent before the first answer is waited for.

        Returns
        -------
        dict of bytes
          Results by question; those that the line lost are missing.
        """
        self.flush()
        self._results.clear()
        recoveries = self.statistics["recoveries"]
        numbers: dict[int, int] = {}
        for index, question in enumerate(questions):
            numbers[self._send(opcode, pack_payload(opcode, question))] = index
        while not numbers.keys() <= self._results.keys():
            self._wait()
            if self.statistics["recoveries"] != recoveries:
                # Some were lost: their frames, or their answers.
                break
        self.flush()
        return {index: self._results[number] for number, index in numbers.items() if number in self._results}

    def frame_crc(self, plane: int = 0) -> int:
        """CRC-32 of a whole plane, as the board computes it."""
        for _ in range(self.retries):
            found = self.ask(Opcode.FRAME_CRC, [{"reserved": 0, "plane": plane}])
            if found:
                return int.from_bytes(found[0], "little")
        raise self.too_bad("FRAME_CRC")
