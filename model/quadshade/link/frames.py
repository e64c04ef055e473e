# SPDX-License-Identifier: Apache-2.0
"""Frames on the wire: ``00 COBS(opcode, sequence, length, payload, CRC-32) 00``, both ways."""

from __future__ import annotations

import zlib
from collections import Counter
from dataclasses import dataclass

from cobs import cobs

from quadshade.contract.protocol import (
    CRC_BYTES,
    HEADER_BYTES,
    MAX_BODY,
    SEQUENCES,
    LinkError,
    Opcode,
    is_length_of,
)

MAX_ENCODED = MAX_BODY + -(-MAX_BODY // 254)
"""Most bytes between two 00s."""


@dataclass(frozen=True)
class Frame:
    """
    What a frame says.

    Attributes
    ----------
    opcode : Opcode
    sequence : int
      0 .. 255.
    payload : bytes
    """

    opcode: Opcode
    sequence: int
    payload: bytes = b""

    def body(self) -> bytes:
        """
        Header, payload and CRC, before COBS.

        Raises
        ------
        LinkError
          A sequence number that is no byte, or a length that the opcode does not have.
        """
        if not 0 <= self.sequence < SEQUENCES:
            raise LinkError(f"sequence number {self.sequence}", "give 0 to 255")
        if not is_length_of(self.opcode, len(self.payload)):
            raise LinkError(f"{self.opcode.name} with {len(self.payload)} bytes of payload")
        return sealed(
            bytes([self.opcode, self.sequence]) + len(self.payload).to_bytes(2, "little") + self.payload
        )

    def encode(self) -> bytes:
        """The bytes on the wire, with a 00 before and one after."""
        return enclosed(self.body())


def sealed(data: bytes) -> bytes:
    """Bytes with their CRC-32 (that of zlib, IEEE 802.3) behind them, lowest byte first."""
    return data + zlib.crc32(data).to_bytes(CRC_BYTES, "little")


def enclosed(body: bytes) -> bytes:
    """A body between two 00s; the first one ends whatever noise was before."""
    return b"\0" + cobs.encode(body) + b"\0"


def parse_body(body: bytes) -> Frame | str:
    """
    The frame that a body holds, or why it holds none.

    Returns
    -------
    Frame or str
      Or one of ``bad_length``, ``bad_crc``, ``refused`` (an unknown opcode), as STATUS counts them.
    """
    if not HEADER_BYTES + CRC_BYTES <= len(body) <= MAX_BODY:
        return "bad_length"
    if zlib.crc32(body[:-CRC_BYTES]) != int.from_bytes(body[-CRC_BYTES:], "little"):
        return "bad_crc"
    payload = body[HEADER_BYTES:-CRC_BYTES]
    if int.from_bytes(body[2:HEADER_BYTES], "little") != len(payload):
        return "bad_length"
    try:
        opcode = Opcode(body[0])
    except ValueError:
        return "refused"
    if not is_length_of(opcode, len(payload)):
        return "bad_length"
    return Frame(opcode, body[1], payload)


class FrameParser:
    """
    Bytes to frames: begins anew at every 00, and drops what is not a frame.

    Attributes
    ----------
    dropped : Counter of str
      Pieces between 00s that were no frames, by reason: ``bad_cobs``, ``bad_length``, ``bad_crc``,
      ``refused``.
    """

    def __init__(self) -> None:
        self.dropped: Counter[str] = Counter()
        self._partial = bytearray()
        self._too_long = False

    def feed(self, data: bytes) -> list[Frame]:
        """
        Take bytes, in pieces of any size, and give the frames that end within them.

        Parameters
        ----------
        data : bytes

        Returns
        -------
        list of Frame
        """
        frames = []
        *ended, rest = bytes(data).split(b"\0")
        for piece in ended:
            self._gather(piece)
            frame = self._finish()
            if frame is not None:
                frames.append(frame)
        self._gather(rest)
        return frames

    def _gather(self, piece: bytes) -> None:
        """Add bytes to the piece that is not ended yet, without keeping more than a frame can have."""
        if len(self._partial) + len(piece) > MAX_ENCODED:
            self._too_long = True
            self._partial.clear()
        if not self._too_long:
            self._partial += piece

    def _finish(self) -> Frame | None:
        """The frame that ends here, if it is one."""
        encoded, too_long = bytes(self._partial), self._too_long
        self._partial.clear()
        self._too_long = False
        if too_long:
            self.dropped["bad_length"] += 1
            return None
        if not encoded:
            return None
        try:
            body = cobs.decode(encoded)
        except cobs.DecodeError:
            self.dropped["bad_cobs"] += 1
            return None
        frame = parse_body(body)
        if isinstance(frame, str):
            self.dropped[frame] += 1
            return None
        return frame
