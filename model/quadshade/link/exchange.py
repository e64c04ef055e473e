# SPDX-License-Identifier: Apache-2.0
"""Single frames to a board and answers from it, over a line that may damage them, or vanish and come back."""

from __future__ import annotations

import secrets
from collections import Counter, deque
from collections.abc import Callable

from quadshade.contract.protocol import (
    ANSWER_BIT,
    MAGIC,
    SEQUENCES,
    VERSION,
    BoardResetError,
    LineGoneError,
    LinkError,
    Opcode,
    definition_hash,
    pack_payload,
    unpack_payload,
)
from quadshade.contract.releases import other_release
from quadshade.link.frames import Frame, FrameParser
from quadshade.link.transport import Transport

ANSWER_SECONDS = 0.5
"""How long an answer may take before it counts as lost; drawing must not take longer."""

RETRIES = 40
"""How often the same thing is sent before the link counts as too bad."""

NOISE_BYTES = 16384
"""So many bytes without a frame count as silence."""

RECONNECTS = 5
"""How often a line may vanish again before it has answered."""

SESSION_BITS = 32


class Exchange:
    """
    Frames out, answers in.

    Parameters
    ----------
    transport : Transport
    answer_seconds : float
      Time-out of an answer.
    retries : int
      Bound of every repetition.
    trace : callable, optional
      Called with a line of text for every frame.
    reopen : callable, optional
      Gives the line anew after it vanished, or raises :class:`LinkError`; without it a line that vanishes is
      the end.

    Attributes
    ----------
    identity : dict of int
      What HELLO said, after :meth:`connect`.
    number : int
      The session's, given to the board with RESET.
    statistics : Counter of str
      ``sent`` and ``received`` frames, ``resent``, ``recoveries``, ``timeouts``, ``reconnects``,
      ``bytes_sent``, ``bytes_received``.
    """

    def __init__(
        self,
        transport: Transport,
        answer_seconds: float = ANSWER_SECONDS,
        retries: int = RETRIES,
        trace: Callable[[str], None] | None = None,
        reopen: Callable[[], Transport] | None = None,
    ) -> None:
        self.transport, self.answer_seconds, self.retries = transport, answer_seconds, retries
        self.trace, self.reopen = trace, reopen
        self.identity: dict[str, int] = {}
        self.number = 0
        self.statistics: Counter[str] = Counter()
        self._parser = FrameParser()
        self._frames: deque[Frame] = deque()
        # An answer to a host that was here before has another number, but for once in 256.
        self._tag = secrets.randbelow(SEQUENCES)
        self._reattaching = False

    @property
    def name(self) -> str:
        """The line's name."""
        return getattr(self.transport, "name", "the line")

    def _say(self, text: str) -> None:
        if self.trace:
            self.trace(text)

    def _transmit(self, frame: Frame) -> None:
        data = frame.encode()
        self.statistics.update(sent=1, bytes_sent=len(data))
        self._say(f"> {frame.opcode.name} {frame.sequence} {len(frame.payload)} bytes")
        try:
            self.transport.write(data)
        except LineGoneError as problem:
            # The frame is lost, like one on a line that damages it.
            self._reattach(problem)

    def _receive(self) -> Frame | None:
        """The next answer, or None if none came in time."""
        noise = 0
        while not self._frames:
            try:
                data = self.transport.read(self.answer_seconds)
            except LineGoneError as problem:
                self._reattach(problem)
                return None
            noise += len(data)
            self.statistics["bytes_received"] += len(data)
            self._frames += [frame for frame in self._parser.feed(data) if frame.opcode.is_answer]
            if not self._frames and (not data or noise > NOISE_BYTES):
                self.statistics["timeouts"] += 1
                self._say(f"  no answer within {self.answer_seconds:g} s")
                return None
        frame = self._frames.popleft()
        self.statistics["received"] += 1
        self._say(f"< {frame.opcode.name} {frame.sequence} {len(frame.payload)} bytes")
        return frame

    def _reattach(self, problem: LineGoneError) -> None:
        """
        Get the line anew, and go on if the board still knows this session.

        Raises
        ------
        LineGoneError
          It does not come back.
        BoardResetError
          The board was reset meanwhile.
        LinkError
          Another board is there now.
        """
        if self.reopen is None or self._reattaching or not self.identity:
            raise problem
        self._say(f"  the line is gone: {problem}")
        self._reattaching = True
        try:
            identity = self._hello_again(problem)
        finally:
            self._reattaching = False
        self.statistics["reconnects"] += 1
        session = identity.pop("session")
        if identity != {name: value for name, value in self.identity.items() if name != "session"}:
            raise LinkError(f"another board is on {self.name} now", "start again")
        if session != self.number:
            raise BoardResetError("the board was reset while the line was gone", "draw the picture anew")
        self._say("  the line is back, the board goes on")

    def _hello_again(self, problem: LineGoneError) -> dict[str, int]:
        """HELLO on a line that may vanish again."""
        if self.reopen is None:
            raise problem
        for _ in range(RECONNECTS):
            self.transport = self.reopen()
            self._frames.clear()
            self._parser = FrameParser()
            try:
                return self._identify(self.request(Opcode.HELLO))
            except LineGoneError as again:
                problem = again
        raise problem

    def too_bad(self, what: str) -> LinkError:
        """The error for something that failed too often."""
        return LinkError(
            f"the link is too bad: {what} failed {self.retries} times",
            "try a lower baud rate, another cable, or reset the board",
        )

    def request(self, opcode: Opcode, **values: int) -> dict[str, int]:
        """
        HELLO, STATUS, RESET or BAUD, repeated until it is answered.

        Returns
        -------
        dict of int
          The answer's fields.

        Raises
        ------
        LinkError
          No answer after all repetitions, or the board refuses.
        """
        payload = pack_payload(opcode, values)
        heard = self.statistics["bytes_received"]
        for _ in range(self.retries):
            # A number of its own: where its answer comes, all that was sent before it has arrived or is lost.
            self._tag = tag = (self._tag + 1) % SEQUENCES
            self._transmit(Frame(opcode, tag, payload))
            while (answer := self._receive()) is not None:
                fields, _ = unpack_payload(answer.opcode, answer.payload)
                if answer.opcode == opcode | ANSWER_BIT and answer.sequence == tag:
                    return fields
                self._other(answer)
        heard = self.statistics["bytes_received"] - heard
        if heard and not self.identity:
            raise LinkError(
                f"no Quadshade board answers on {self.name}: {heard} bytes came, no answer to {opcode.name}",
                "is it the right port and baud rate?",
            )
        raise LinkError(
            f"no answer to {opcode.name} on {self.name} in {self.retries} times {self.answer_seconds:g} s",
            "is it a Quadshade board, powered, with this baud rate?",
        )

    def _other(self, answer: Frame) -> None:
        """What to make of an answer to something else."""

    @staticmethod
    def _identify(identity: dict[str, int]) -> dict[str, int]:
        """Fields of HELLO's answer but for the link state, once they are those of a board to talk to."""
        if identity["magic"] != MAGIC:
            raise LinkError("the other end is no Quadshade board", "is it the right port?")
        if identity["version"] != VERSION:
            raise LinkError(
                f"the board speaks version {identity['version']} of the protocol, this host {VERSION}",
                "use the bitstream and the host of one release",
            )
        if identity["definition"] != definition_hash():
            raise LinkError(
                other_release("the board", identity["definition"]),
                "load a bitstream of this release (`make bitstream`, `make program`), or use the board's",
            )
        return {name: value for name, value in identity.items() if name not in ("expected", "reason", "free")}

    def hello(self) -> dict[str, int]:
        """
        Ask who is there, and check it.

        Returns
        -------
        dict of int
          The board's identity.

        Raises
        ------
        LinkError
          No answer, no Quadshade board, another version, or other formats.
        """
        self.identity = self._identify(self.request(Opcode.HELLO))
        return self.identity

    def new_session(self) -> dict[str, int]:
        """
        RESET under a new number, until HELLO repeats it: then no answer is from before.

        Returns
        -------
        dict of int
          The link state after it.
        """
        for _ in range(self.retries):
            self.number = secrets.randbits(SESSION_BITS) or 1
            self.request(Opcode.RESET, session=self.number)
            fields = self.request(Opcode.HELLO)
            if fields["session"] == self.number:
                self.identity["session"] = self.number
                return fields
        raise self.too_bad("RESET")
