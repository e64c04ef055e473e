# SPDX-License-Identifier: Apache-2.0
"""
Every limit of the protocol from both sides: frames that are just accepted, and that are just refused.

Made from the tables of ``quadshade.contract.protocol``; ``tests/test_link_limits.py`` says which of its
refusals and fields must be here, and that the benches of the receiver and of the decoder send them.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from cocotb_tests.support.link_stimuli import body_of
from quadshade.contract.protocol import (
    CRC_BYTES,
    HEADER_BYTES,
    MAX_BODY,
    MAX_READ,
    PAYLOADS,
    PHASE_BITS,
    SEQUENCES,
    WINDOW,
    WORD_BYTES,
    Opcode,
    pack_payload,
)
from quadshade.golden.link.frame_receiver import Reach
from quadshade.link.frames import sealed

REQUESTS = tuple(opcode for opcode in Opcode if not opcode.is_answer)
LENGTH_BITS = 16
TOP_RATE = 1 << (PHASE_BITS - 2)


class Case(NamedTuple):
    """
    A frame.

    Attributes
    ----------
    name : str
      The limit that it is at.
    opcode : int
    payload : bytes
    said : int or None
      The length in its header, if that is not the payload's.
    ahead : int
      Its number, counted from the one expected.
    flipped : int or None
      A bit of its body that is wrong, counted from the end.
    cut : int
      Bytes that are missing of header and payload, before the CRC.
    """

    name: str
    opcode: int
    payload: bytes = b""
    said: int | None = None
    ahead: int = 0
    flipped: int | None = None
    cut: int = 0

    def body(self, expected: int) -> bytes:
        """Header, payload and CRC."""
        number = (expected + self.ahead) % SEQUENCES
        body = body_of(self.opcode, number, self.payload)
        if self.said is not None or self.cut:
            said = len(self.payload) if self.said is None else self.said
            content = bytes([self.opcode, number]) + said.to_bytes(2, "little") + self.payload
            body = sealed(content[: len(content) - self.cut])
        if self.flipped is not None:
            whole = int.from_bytes(body, "big") ^ 1 << self.flipped
            body = whole.to_bytes(len(body), "big")
        return body


def limits(reach: Reach, far: bool = True) -> list[Case]:
    """
    Frames at every limit, in an order that only those of numbers need.

    Parameters
    ----------
    reach : Reach
      What READ and FRAME_CRC may name.
    far : bool
      Also what is far beyond: values and lengths with a bit that is wrong, every opcode, long bodies.
    """
    cases = [*limits_of_fields(reach, far), *_lengths(far), *_sizes(far), *_numbers()]
    cases += [Case("crc", Opcode.HELLO, flipped=bit) for bit in range(8 * (CRC_BYTES + HEADER_BYTES))]
    near = {opcode ^ 1 << bit for opcode in REQUESTS for bit in range(8)}
    cases += [Case("opcode", code) for code in (range(256) if far else sorted(near))]
    return [case for index, case in enumerate(cases) if case.name == "number" or case not in cases[:index]]


def _short(opcode: Opcode) -> bytes:
    """The shortest good payload."""
    good = {"width": 1, "count": 1, "pixels": 1, "phase_step": 1}
    fields = {name: good.get(name, 0) for name, _, _ in PAYLOADS[opcode].fields}
    return pack_payload(opcode, fields, bytes(PAYLOADS[opcode].least))


def limits_of_fields(reach: Reach, far: bool = True) -> Iterator[Case]:
    """READ, FRAME_CRC, BAUD: each field at its limits, and with a bit that is far beyond."""
    for area in _areas(reach, far):
        yield Case("read", Opcode.READ, pack_payload(Opcode.READ, area))
    bits = range(2, LENGTH_BITS) if far else ()
    for plane in (*range(len(reach.plane_bytes) + 2), *(1 << bit for bit in bits)):
        yield Case("plane", Opcode.FRAME_CRC, pack_payload(Opcode.FRAME_CRC, {"reserved": 0, "plane": plane}))
        area = {"x": 0, "y": 0, "width": 1, "count": 1, "pixels": 1, "plane": plane}
        yield Case("plane", Opcode.READ, pack_payload(Opcode.READ, area))
    rates = (0, 1, 2, TOP_RATE - 1, TOP_RATE, TOP_RATE + 1, (1 << 32) - 1)
    for step in (*rates, *(1 << bit for bit in range(PHASE_BITS - 4, 32))):
        yield Case("rate", Opcode.BAUD, pack_payload(Opcode.BAUD, {"phase_step": step}))


def _areas(reach: Reach, far: bool) -> Iterator[dict[str, int]]:
    """READ's fields: for every plane that is there, at each side of each limit."""
    wide, high = reach.width, reach.height
    names = ("x", "y", "width", "count", "pixels", "plane")
    for plane, size in enumerate(reach.plane_bytes):
        if not size:
            continue

        def area(
            x: int, y: int, width: int, pixels: int, more: int = 0, plane: int = plane
        ) -> dict[str, int]:
            count = max(pixels * reach.plane_bytes[plane] - more, 0)
            return dict(zip(names, (x, y, width, count, pixels, plane), strict=True))

        some = min(3, wide)
        # Columns, scanlines, and both.
        for x, y, width in (
            *((wide - some + more, 0, some) for more in (0, 1)),
            *((0, 0, wide + more) for more in (-1, 0, 1)),
            *((wide + more, 0, 1) for more in (-1, 0)),
            *((0, 0, more) for more in (0, 1)),
            *((0, high + more, 1) for more in (-1, 0, 1)),
            *((wide - more, high - more, 1) for more in (0, 1)),
            *((wide - some + more, high - 1 + more, some) for more in (0, 1)),
        ):
            yield area(x, y, width, 1)
        # Up to the screen's last pixel, and one more.
        for rows, width in ((1, 1), (1, some), (2, some), (2, 1)):
            for more in (-1, 0, 1):
                yield area(wide - width, high - rows, width, rows * width + more)
                yield area(0, high - rows, width, rows * width + more)
        # Bytes of the last pixel; pixels that are not what the bytes need.
        for missing in range(-1, size + 2):
            yield area(0, 0, some, 2, missing)
        for pixels in (0, 1, 2, 3):
            yield area(0, 0, some, 2) | {"pixels": pixels}
        most = -(-MAX_READ // size)
        for count in (MAX_READ - 1, MAX_READ, MAX_READ + 1):
            for pixels in (most, most + 1, -(-count // size)):
                yield area(0, 0, wide, pixels) | {"count": count}
        # Far beyond: a value that is right but for one bit.
        good = area(1, 1, min(2, wide - 1), 2)
        yield good
        for name in names if far else ():
            for bit in range(LENGTH_BITS):
                yield good | {name: good[name] ^ 1 << bit}


def _lengths(far: bool) -> Iterator[Case]:
    """Each opcode's shortest and longest payload, and the lengths beside them; headers that say another."""
    for bit in range(LENGTH_BITS):
        yield Case("length in the header", 0x7F, said=1 << bit)
    for opcode in REQUESTS:
        low, high = PAYLOADS[opcode].lengths
        short = _short(opcode)
        for length in range(max(low - WORD_BYTES, 0), low + WORD_BYTES + 1):
            yield Case("shortest", opcode, (short + bytes(WORD_BYTES))[:length])
        for length in (high, high + 1, high + WORD_BYTES):
            if low < length and (far or length < 100):
                yield Case("longest", opcode, short.ljust(length, b"\1"))
        for bit in range(LENGTH_BITS if far else 3):
            yield Case("length in the header", opcode, short, said=len(short) ^ 1 << bit)


def _sizes(far: bool) -> Iterator[Case]:
    """Bodies too short for header and CRC, and longer than any: by a byte, a word, and the counter's wrap."""
    for cut in range(HEADER_BYTES + 1):
        yield Case("body", Opcode.HELLO, cut=cut)
    # 2048 bytes more than the four that the header says.
    if far:
        yield Case("body", Opcode.TRIANGLES, bytes([1]) * (2 * MAX_BODY + WORD_BYTES), said=WORD_BYTES)


def _numbers() -> Iterator[Case]:
    """Numbers around the expected one, and around the window's end; twice in a row ahead."""
    payload = bytes([1]) * WORD_BYTES
    for ahead in (0, 1, 2, 3, 0, -1, 2, 3, 3, 4, -WINDOW, -WINDOW + 1, WINDOW - 1, WINDOW - 2, -2, 0):
        yield Case("number", Opcode.TRIANGLES, payload, ahead=ahead)
