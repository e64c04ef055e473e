# SPDX-License-Identifier: Apache-2.0
"""Bytes of the line to frames, byte by byte (``rtl/link/cobs_decoder.vhd``)."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass
class Decoded:
    """What one byte of the line gives: a byte of the frame, or the frame's end and whether it was whole."""

    data: int | None = None
    end: bool = False
    good: bool = False


class CobsDecoder:
    """Consistent overhead byte stuffing (Cheshire and Baker, 1999), taken apart; a 00 is a frame's end."""

    def __init__(self) -> None:
        self._begin()

    def _begin(self) -> None:
        self._begun = self._damaged = self._zero_due = False
        self._remaining = 0

    def error(self) -> None:
        """A character was lost."""
        self._damaged = True

    def add(self, byte: int) -> Decoded:
        """One byte of the line."""
        if byte == 0:
            whole = self._begun and not self._damaged and self._remaining == 0
            ended = Decoded(end=self._begun or self._damaged, good=whole)
            self._begin()
            return ended
        if self._remaining:
            self._remaining -= 1
            return Decoded(data=byte)
        decoded = Decoded(data=0 if self._zero_due else None)
        self._begun, self._zero_due, self._remaining = True, byte != 255, byte - 1
        return decoded


def decode_line(line: bytes) -> list[bytes]:
    """The good frames of some bytes of the line."""
    decoder, frames, partial = CobsDecoder(), [], bytearray()
    for byte in line:
        decoded = decoder.add(byte)
        if decoded.data is not None:
            partial.append(decoded.data)
        if decoded.end:
            if decoded.good:
                frames.append(bytes(partial))
            partial.clear()
    return frames
