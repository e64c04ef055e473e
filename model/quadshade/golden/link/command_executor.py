# SPDX-License-Identifier: Apache-2.0
"""Commands in their order (``rtl/link/command_executor.vhd``)."""

from __future__ import annotations

from typing import NamedTuple, Protocol

from quadshade.contract.protocol import WORD_BYTES, Opcode, unpack_payload
from quadshade.golden.link.frame_fifo import FrameFifo


class Drawing(Protocol):
    """What commands act on: the core and the units behind it."""

    def triangles(self, words: list[int]) -> None:
        """Set-up words, in order; a packet may go on in the next call."""

    def state(self, address: int, value: int) -> None:
        """A word of the shading state."""

    def clear(self, colour: int) -> None:
        """Fill the buffer that is drawn, empty the depth."""

    def swap(self) -> None:
        """Show the buffer that was drawn, draw the other."""

    def read(self, *, x: int, y: int, width: int, count: int, pixels: int, plane: int) -> bytes:
        """``count`` bytes of a plane, which are ``pixels`` pixels."""

    def frame_crc(self, plane: int) -> int:
        """CRC-32 of a plane."""

    def reset(self) -> None:
        """Forget a begun packet."""


class Command(NamedTuple):
    """
    A command that is begun.

    Attributes
    ----------
    opcode : Opcode
    number : int
      Of its frame.
    words : list of int
      What of its payload was taken from the FIFO.
    left : int
      How many words are still there.
    """

    opcode: Opcode
    number: int
    words: list[int]
    left: int


def begin(fifo: FrameFifo) -> Command:
    """The oldest command of a FIFO that has one, up to where it waits for the core."""
    header = fifo.take()
    opcode, count = Opcode(header & 0xFF), (header >> 16) // WORD_BYTES
    taken = {Opcode.TRIANGLES: 0, Opcode.STATE: 1}.get(opcode, count)
    return Command(opcode, header >> 8 & 0xFF, [fifo.take() for _ in range(taken)], count - taken)


def execute(command: Command, fifo: FrameFifo, drawing: Drawing) -> bytes | int | None:
    """
    The rest of a command that is begun.

    Returns
    -------
    bytes or int or None
      READ's bytes, FRAME_CRC's CRC.
    """
    opcode = command.opcode
    words = command.words + [fifo.take() for _ in range(command.left)]
    fields, _ = unpack_payload(opcode, b"".join(word.to_bytes(WORD_BYTES, "little") for word in words))
    if opcode is Opcode.TRIANGLES:
        drawing.triangles(words)
    elif opcode is Opcode.STATE:
        for offset, value in enumerate(words[1:]):
            drawing.state((fields["address"] + offset) % (1 << 32), value)
    elif opcode is Opcode.CLEAR:
        drawing.clear(**fields)
    elif opcode is Opcode.SWAP:
        drawing.swap()
    elif opcode is Opcode.READ:
        return drawing.read(**fields)
    else:
        return drawing.frame_crc(fields["plane"])
    return None
