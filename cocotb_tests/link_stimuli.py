# SPDX-License-Identifier: Apache-2.0
"""Frames that the tests of the link's units send: good ones, and wrong ones of every kind."""

from __future__ import annotations

import random

from quadshade.golden.frame_receiver import FrameReceiver
from quadshade.link.frames import sealed
from quadshade.link.protocol import MAX_PAYLOAD, MAX_READ, SEQUENCES, Opcode, pack_payload

MOST_WORDS = 12


def good_payload(draw: random.Random, opcode: Opcode, most_words: int = MOST_WORDS) -> bytes:
    """A payload that its opcode can have."""
    word = draw.getrandbits(32)
    tail = draw.randbytes(4 * draw.randint(1, most_words))
    if opcode is Opcode.TRIANGLES:
        return tail
    if opcode is Opcode.STATE:
        return pack_payload(opcode, {"address": word}, tail)
    if opcode is Opcode.READ:
        place = {name: draw.getrandbits(16) for name in ("x", "y", "width", "pixels")}
        return pack_payload(opcode, {**place, "count": draw.randint(1, 20), "plane": draw.randint(0, 1)})
    values: dict[Opcode, dict[str, int]] = {
        Opcode.CLEAR: {"colour": word},
        Opcode.RESET: {"session": word},
        Opcode.BAUD: {"phase_step": draw.randint(1, 1 << 22)},
        Opcode.FRAME_CRC: {"reserved": word >> 16, "plane": word & 1},
    }
    return pack_payload(opcode, values.get(opcode, {}))


def wrong_body(draw: random.Random, expected: int) -> bytes:
    """A body that must have no effect."""
    kinds = ("crc", "short", "length", "opcode", "answer", "fields", "size")
    kind = "long" if draw.random() < 0.04 else draw.choice(kinds)
    payload = good_payload(draw, Opcode.TRIANGLES)
    if kind == "crc":
        body = bytearray(body_of(Opcode.TRIANGLES, expected, payload))
        body[draw.randrange(len(body))] ^= 1 << draw.randrange(8)
        return bytes(body)
    if kind == "short":
        return draw.randbytes(draw.randint(1, 7))
    if kind == "length":
        return sealed(bytes([0x12, expected]) + (len(payload) + 4).to_bytes(2, "little") + payload)
    if kind == "opcode":
        return body_of(draw.choice((0x00, 0x15, 0x7F, 0x1F)), expected, payload)
    if kind == "answer":
        return body_of(draw.choice((0x80, 0xC0, 0x92)), expected, payload)
    if kind == "fields":
        count, plane = draw.choice(((0, 0), (MAX_READ + 1, 0), (65535, 1), (5, 2 << 16), (5, 1 << 31)))
        return body_of(
            Opcode.READ, expected, bytes(6) + count.to_bytes(2, "little") + plane.to_bytes(4, "little")
        )
    if kind == "size":
        return body_of(
            draw.choice((Opcode.CLEAR, Opcode.READ, Opcode.STATE, Opcode.HELLO)), expected, payload[:4] * 5
        )
    return body_of(Opcode.TRIANGLES, expected, bytes([1]) * (MAX_PAYLOAD + draw.choice((1, 4, 40, 700))))


def body_of(opcode: int, number: int, payload: bytes) -> bytes:
    """Header, payload, CRC, unchecked."""
    return sealed(bytes([opcode, number % SEQUENCES]) + len(payload).to_bytes(2, "little") + payload)


def random_body(draw: random.Random, receiver: FrameReceiver, opcodes: list[Opcode]) -> bytes:
    """A good frame, next in order; a repeated one; one ahead of a gap; or a wrong one."""
    if draw.random() < 0.4:
        return wrong_body(draw, receiver.expected)
    offset = draw.choice((0, 0, 0, 0, 0, -1, -3, -128, 1, 2, 127))
    opcode = draw.choice(opcodes)
    return body_of(opcode, receiver.expected + offset, good_payload(draw, opcode))
