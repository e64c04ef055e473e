# SPDX-License-Identifier: Apache-2.0
"""Frames that the tests of the link's units send: good ones, and wrong ones of every kind."""

from __future__ import annotations

import random

from quadshade.contract.protocol import MAX_PAYLOAD, MAX_READ, PACKED, SEQUENCES, Opcode, pack_payload
from quadshade.golden.link.frame_receiver import FrameReceiver, Reach
from quadshade.link.frames import sealed

MOST_WORDS = 12
REACH = Reach()


def good_payload(
    draw: random.Random, opcode: Opcode, most_words: int = MOST_WORDS, reach: Reach = REACH
) -> bytes:
    """A payload that its opcode can have."""
    word = draw.getrandbits(32)
    tail = draw.randbytes(4 * draw.randint(1, most_words))
    if opcode is Opcode.TRIANGLES:
        return tail
    if opcode is Opcode.STATE:
        return pack_payload(opcode, {"address": word}, tail)
    if opcode is Opcode.READ:
        return pack_payload(opcode, good_area(draw, reach))
    values: dict[Opcode, dict[str, int]] = {
        Opcode.CLEAR: {"colour": word},
        Opcode.RESET: {"session": word},
        Opcode.BAUD: {"phase_step": draw.randint(1, 1 << 22)},
        Opcode.FRAME_CRC: {"reserved": word >> 16, "plane": draw.choice(planes_of(reach))},
    }
    return pack_payload(opcode, values.get(opcode, {}))


def planes_of(reach: Reach) -> list[int]:
    """The planes that are there."""
    return [number for number, size in enumerate(reach.plane_bytes) if size]


def good_area(draw: random.Random, reach: Reach, most: int = 20) -> dict[str, int]:
    """READ's fields for an area on the screen."""
    plane = draw.choice(planes_of(reach))
    x, y = draw.randrange(reach.width), draw.choice((0, reach.height - 1, draw.randrange(reach.height)))
    width = draw.choice((1, reach.width - x, draw.randint(1, reach.width - x)))
    room = min(width * (reach.height - y) * reach.plane_bytes[plane], MAX_READ)
    count = draw.choice((1, min(room, most), draw.randint(1, min(room, most))))
    pixels = -(-count // reach.plane_bytes[plane])
    if reach.with_packed_read:
        plane += draw.choice((0, PACKED))
    return {"x": x, "y": y, "width": width, "count": count, "pixels": pixels, "plane": plane}


def wrong_area(draw: random.Random, reach: Reach) -> dict[str, int]:
    """READ's fields for an area that is just not on the screen, or a plane that is not there."""
    area = good_area(draw, reach, MAX_READ)
    size = reach.plane_bytes[area["plane"] % PACKED]
    kinds = ("count", "plane", "right", "below", "corner", "rows", "width", "pixels", "bit", "any")
    kind = draw.choice(kinds)
    if kind == "count":
        area["count"] = draw.choice((0, MAX_READ + 1, 65535))
        area["pixels"] = -(-area["count"] // size)
    elif kind == "plane":
        area["plane"] = draw.choice([n for n in (1, 2, 3, 4, 7, 1 << 15) if not reach.holds(n)])
    elif kind in ("right", "below", "corner"):
        if kind != "below":
            area["x"] = reach.width - area["width"] + draw.choice((1, 2, 65535 - reach.width))
        if kind != "right":
            area["y"] = draw.choice((reach.height, reach.height + 1, 65535))
    elif kind == "bit":
        area[draw.choice(sorted(area))] ^= 1 << draw.randrange(16)
    elif kind == "rows":
        area.update(y=reach.height - 1, count=(area["width"] + 1) * size, pixels=area["width"] + 1)
    elif kind == "width":
        area["width"] = 0
    elif kind == "pixels":
        area["pixels"] += draw.choice((-1, 1, 1 << 10, 1 << 13))
    else:
        area.update({name: draw.getrandbits(16) for name in ("x", "y", "width", "pixels")})
    return area


def wrong_body(draw: random.Random, expected: int, reach: Reach = REACH) -> bytes:
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
        return body_of(draw.choice((0x00, 0x1E, 0x7F, 0x1F)), expected, payload)
    if kind == "answer":
        return body_of(draw.choice((0x80, 0xC0, 0x92)), expected, payload)
    if kind == "fields":
        if draw.random() < 0.2:
            plane = draw.choice([n for n in (1, 2, 3, 4, 1 << 15) if not reach.holds(n)])
            return body_of(
                Opcode.FRAME_CRC, expected, pack_payload(Opcode.FRAME_CRC, {"reserved": 0, "plane": plane})
            )
        if draw.random() < 0.2:
            step = draw.choice((0, (1 << 22) + 1, 1 << draw.randint(23, 31), draw.getrandbits(32) | 1 << 31))
            return body_of(Opcode.BAUD, expected, pack_payload(Opcode.BAUD, {"phase_step": step}))
        return body_of(Opcode.READ, expected, pack_payload(Opcode.READ, wrong_area(draw, reach)))
    if kind == "size":
        return body_of(
            draw.choice((Opcode.CLEAR, Opcode.READ, Opcode.STATE, Opcode.HELLO)), expected, payload[:4] * 5
        )
    return body_of(Opcode.TRIANGLES, expected, bytes([1]) * (MAX_PAYLOAD + draw.choice((1, 4, 40, 700))))


def body_of(opcode: int, number: int, payload: bytes) -> bytes:
    """Header, payload, CRC, unchecked."""
    return sealed(bytes([opcode, number % SEQUENCES]) + len(payload).to_bytes(2, "little") + payload)


def random_body(
    draw: random.Random, receiver: FrameReceiver, opcodes: list[Opcode], reach: Reach = REACH
) -> bytes:
    """A good frame, next in order; a repeated one; one ahead of a gap; or a wrong one."""
    if draw.random() < 0.4:
        return wrong_body(draw, receiver.expected, reach)
    offset = draw.choice((0, 0, 0, 0, 0, -1, -3, -128, 1, 2, 127))
    opcode = draw.choice(opcodes)
    return body_of(opcode, receiver.expected + offset, good_payload(draw, opcode, reach=reach))
