# SPDX-License-Identifier: Apache-2.0
"""What a frame is worth at its end (``rtl/link/frame_receiver.vhd``)."""

from __future__ import annotations

from dataclasses import dataclass

from quadshade.contract.protocol import (
    ANSWER_BIT,
    CRC_BYTES,
    HEADER_BYTES,
    MAX_BODY,
    MAX_READ,
    PACKED,
    PHASE_BITS,
    SEQUENCES,
    WINDOW,
    Opcode,
    Reason,
    is_length_of,
    unpack_payload,
)
from quadshade.golden.common.crc32 import CRC_RESIDUE, crc_of


@dataclass
class Verdict:
    """
    What follows from a frame's end.

    Attributes
    ----------
    commit, ack, nak, request : bool
      The frame stays; it is acknowledged, refused, or answered at once.
    reason : Reason
      Why it is refused.
    counter : str
      The counter of STATUS that goes up; empty if none does.
    """

    commit: bool = False
    ack: bool = False
    nak: bool = False
    request: bool = False
    reason: Reason = Reason.NONE
    counter: str = ""


@dataclass(frozen=True)
class Reach:
    """
    What READ and FRAME_CRC may name, and whether there is SWAP.

    Attributes
    ----------
    width, height : int
      Of the screen.
    plane_bytes : tuple of int
      Of a pixel in every plane; 0 where there is no such plane.
    with_swap : bool
    with_packed_read : bool
      Whether READ may ask for packed bytes.
    """

    width: int = 320
    height: int = 240
    plane_bytes: tuple[int, ...] = (3, 2, 0, 0)
    with_swap: bool = False
    with_packed_read: bool = False

    def holds(self, plane: int) -> bool:
        """Whether there is such a plane."""
        return plane < len(self.plane_bytes) and self.plane_bytes[plane] > 0

    def holds_area(self, x: int, y: int, width: int, count: int, pixels: int, plane: int) -> bool:
        """Whether READ's area is on the screen, and ``pixels`` is what ``count`` bytes need."""
        if self.with_packed_read:
            plane &= ~PACKED
        return (
            self.holds(plane)
            and 1 <= count <= MAX_READ
            and pixels == -(-count // self.plane_bytes[plane])
            and width > 0
            and x + width <= self.width
            and y < self.height
            and pixels <= width * (self.height - y)
        )


class FrameReceiver:
    """
    Frames in order, each once.

    Parameters
    ----------
    reach : Reach, optional

    Attributes
    ----------
    expected : int
      Number of the frame that is accepted next.
    """

    def __init__(self, reach: Reach | None = None) -> None:
        self.reach = reach or Reach()
        self.expected = 0
        self._previous = SEQUENCES - 1

    @property
    def is_in_order(self) -> bool:
        """Whether the frame judged last left no gap: the next number is the one that is expected."""
        return self.expected == (self._previous + 1) % SEQUENCES

    def judge(self, body: bytes, whole: bool = True, overflow: bool = False) -> Verdict:
        """
        A frame that ends.

        Parameters
        ----------
        body : bytes
          Header, payload, CRC.
        whole : bool
          COBS and all characters were good.
        overflow : bool
          The FIFO had no room for it.
        """
        if not whole:
            return Verdict(counter="bad_cobs")
        if not HEADER_BYTES + CRC_BYTES <= len(body) <= MAX_BODY:
            return Verdict(counter="bad_length")
        if crc_of(body) != CRC_RESIDUE:
            return Verdict(counter="bad_crc")
        payload = body[HEADER_BYTES:-CRC_BYTES]
        reason = self._fault(body[0], int.from_bytes(body[2:4], "little"), payload)
        if reason is not Reason.NONE:
            counter = "bad_length" if reason is Reason.BAD_LENGTH else "refused"
            return self._refused(body[0], reason, counter)
        if not Opcode(body[0]).is_sequenced:
            return Verdict(request=True)
        return self._ordered(body[1], overflow)

    def _fault(self, code: int, length: int, payload: bytes) -> Reason:
        """What is wrong with a frame whose CRC is right."""
        if length != len(payload):
            return Reason.BAD_LENGTH
        missing = code == Opcode.SWAP and not self.reach.with_swap
        if code not in set(Opcode) or code & ANSWER_BIT or missing:
            return Reason.UNKNOWN_OPCODE
        opcode = Opcode(code)
        if not is_length_of(opcode, length):
            return Reason.BAD_LENGTH
        fields, _ = unpack_payload(opcode, payload)
        good = True
        if opcode is Opcode.READ:
            good = self.reach.holds_area(**fields)
        elif opcode is Opcode.FRAME_CRC:
            good = self.reach.holds(fields["plane"])
        elif opcode is Opcode.BAUD:
            good = 1 <= fields["phase_step"] <= 1 << (PHASE_BITS - 2)
        return Reason.NONE if good else Reason.BAD_FIELD

    @staticmethod
    def _refused(code: int, reason: Reason, counter: str) -> Verdict:
        """Counted, and answered unless it is an answer itself."""
        if code & ANSWER_BIT:
            return Verdict(counter=counter)
        return Verdict(nak=True, reason=reason, counter=counter)

    def _ordered(self, number: int, overflow: bool) -> Verdict:
        """A sequenced frame by its number."""
        follows = number == (self._previous + 1) % SEQUENCES
        self._previous = number
        behind = (self.expected - number) % SEQUENCES
        if behind == 0:
            if overflow:
                return Verdict(nak=True, reason=Reason.NO_ROOM, counter="overruns")
            self.expected = (self.expected + 1) % SEQUENCES
            return Verdict(commit=True, ack=True, counter="frames")
        if behind <= WINDOW:
            return Verdict(ack=True, counter="duplicates")
        if follows:
            return Verdict(counter="gaps")
        return Verdict(nak=True, reason=Reason.OUT_OF_ORDER, counter="gaps")
