# SPDX-License-Identifier: Apache-2.0
"""
The link protocol: opcodes, lengths, fields, counters, and the hash of all that both sides must agree on.

The one source: ``scripts/generate_vhdl`` writes ``rtl/generated/link_pkg.vhd`` from this module,
``docs/reference/protocol.md`` explains it. All integers on the wire are unsigned and little endian.
"""

from __future__ import annotations

import re
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, fields
from enum import IntEnum

from quadshade.contract import formats, packed_format, vertex_program
from quadshade.errors import QuadshadeError

VERSION = 1
MAGIC = 0x44485351
"""The bytes ``QSHD``: the first thing that HELLO's answer says."""

WORD_BYTES = 4
HEADER_FIELDS = (
    ("opcode", 1, "what is asked or answered"),
    ("sequence", 1, "number of the frame; an answer carries that of the frame it answers"),
    ("length", 2, "bytes of payload"),
)
HEADER_BYTES = sum(size for _, size, _ in HEADER_FIELDS)
CRC_BYTES = 4
MAX_BODY = 1024
"""Most bytes of a frame between its 00s, before COBS: header, payload and CRC."""
MAX_PAYLOAD = MAX_BODY - HEADER_BYTES - CRC_BYTES
SEQUENCES = 1 << 8
WINDOW = SEQUENCES // 2
"""Frames further behind than this count as ahead; the host keeps fewer than this unanswered."""

PHASE_BITS = 24
"""A baud rate is a phase step: 2**24 * baud / clk_frequency_hz, at most a quarter of the whole."""
BREAK_BITS = 20
"""A line that is low for this many bits is a break: the board goes back to its default baud rate."""


class LinkError(QuadshadeError):
    """The link or the board at its other end is not what it has to be."""


class PortError(LinkError):
    """The port cannot be opened."""


class LineGoneError(LinkError):
    """The port vanished, or the other end of a socket hung up: it may come back."""


class BoardResetError(LinkError):
    """The board was reset meanwhile: it knows nothing of what was sent; the picture must be drawn anew."""


class Opcode(IntEnum):
    """
    What a frame asks (bit 7 clear) or answers (bit 7 set).

    Requests with bit 4 are *sequenced*: accepted in the order of their numbers, each once, and executed in
    that order. The others are executed at once, however often they come.
    """

    HELLO = 0x01
    STATUS = 0x02
    RESET = 0x03
    BAUD = 0x04
    CLEAR = 0x10
    STATE = 0x11
    TRIANGLES = 0x12
    READ = 0x13
    FRAME_CRC = 0x14
    SWAP = 0x15
    ACK = 0x80
    HELLO_ANSWER = 0x81
    STATUS_ANSWER = 0x82
    RESET_ANSWER = 0x83
    BAUD_ANSWER = 0x84
    READ_ANSWER = 0x93
    FRAME_CRC_ANSWER = 0x94
    NAK = 0xC0

    @property
    def is_answer(self) -> bool:
        """True for what the board sends."""
        return bool(self & ANSWER_BIT)

    @property
    def is_sequenced(self) -> bool:
        """True for requests that are executed once, in order."""
        return not self.is_answer and bool(self & SEQUENCED_BIT)


ANSWER_BIT = 0x80
SEQUENCED_BIT = 0x10


class Reason(IntEnum):
    """Why a frame whose CRC is right was not accepted; 0 in every other answer."""

    NONE = 0
    OUT_OF_ORDER = 1
    UNKNOWN_OPCODE = 2
    BAD_LENGTH = 3
    BAD_FIELD = 4
    NO_ROOM = 5


LINK_STATE = (
    ("expected", 1, "sequence number that the board accepts next"),
    ("reason", 1, "why a frame was refused, 0 if none was"),
    ("free", 2, "words that the board's command FIFO has room for"),
)
"""First word of every answer: the acknowledgement and the credits."""

FEATURES = (
    *("depth_test", "shade", "edge_map", "display", "two_buffers", "colours_656", "colours_444"),
    *("packed_read", "vertices", "single_buffer", "colours_565"),
)
"""Bits of HELLO's ``features``, the lowest first."""

OPTIONAL = {Opcode.SWAP: "two_buffers"}
"""Requests that only boards with a feature know; the others refuse them as unknown."""

COLOUR_BITS = {8: "", 6: "colours_656", 5: "colours_565", 4: "colours_444"}
"""Bits that a board may keep of a colour, and the feature that says so; 6 are 5 of channel 1, 5 are 6."""

BOARD_FIELDS = (
    ("clk_frequency_hz", 4, "system clock"),
    ("default_phase_step", 4, "phase step after power-up and after a break"),
    ("fifo_words", 2, "words of the command FIFO"),
    ("features", 2, "what it has, a bit each"),
    ("screen_width", 2, "pixels"),
    ("screen_height", 2, "pixels"),
    ("colour_bytes", 1, "bytes of a pixel in plane 0"),
    ("depth_bytes", 1, "bytes of a pixel in plane 1, 0 if there is none"),
)
"""What a board top says about itself."""

GENERIC_FIELDS = tuple((name, 1, f"generic {name} of the core") for name in formats.Formats().generics())

IDENTITY = (
    ("magic", 4, "QSHD"),
    ("definition", 4, "hash of formats, packet layout and protocol"),
    ("version", 2, "of the protocol"),
    ("num_counters", 2, "words of STATUS's answer after its first"),
    *BOARD_FIELDS,
    *GENERIC_FIELDS,
)
"""What HELLO's answer says after link state and session; padded to whole words."""

COUNTERS = (
    ("frames", 32, "sequenced frames accepted"),
    ("primitives", 32, "primitives drawn to their last pixel"),
    ("pixels", 32, "pixels that the core emitted"),
    ("clocks_busy", 32, "clocks in which the core was not idle"),
    ("clocks_idle", 32, "clocks in which it was"),
    ("bad_cobs", 16, "frames that end within a block, or with a framing error"),
    ("bad_crc", 16, "frames with a wrong CRC"),
    ("bad_length", 16, "frames of a length that their opcode does not have, CRC right or not"),
    ("refused", 16, "frames with a right CRC and an unknown opcode or a field out of range"),
    ("framing_errors", 16, "characters without a stop bit"),
    ("overruns", 16, "sequenced frames for which the FIFO had no room"),
    ("duplicates", 16, "sequenced frames that had been accepted before"),
    ("gaps", 16, "sequenced frames ahead of the one expected"),
)
"""STATUS: name, bits, what is counted since the last RESET. A counter wraps; on the wire it is a word."""

PLANES = ("colour", "depth", "edges_diagonal", "edges_eight")
"""What READ and FRAME_CRC can name; a board without depth or edge map refuses those planes."""

PACKED = 1 << 8
"""Added to READ's plane: the answer may be packed, and is where that takes fewer bytes."""

ESCAPE_ONES = 5
"""Ones before a byte of a packed answer that is sent whole (docs/reference/readback.md)."""

EDGE_BYTES = 2
"""A pixel of a plane of edges: the intensities from normals and from depth."""


@dataclass(frozen=True)
class Payload:
    """
    What a frame carries.

    Attributes
    ----------
    fields : tuple of (name, bytes, meaning)
    least, most : int
      Bytes that follow the fields: a number of whole words (READ's answer: of bytes) in this range.
    """

    fields: tuple[tuple[str, int, str], ...] = ()
    least: int = 0
    most: int = 0

    @property
    def field_bytes(self) -> int:
        """Bytes of the fields."""
        return sum(size for _, size, _ in self.fields)

    @property
    def lengths(self) -> tuple[int, int]:
        """Shortest and longest payload."""
        return self.field_bytes + self.least, self.field_bytes + self.most


PLANE_HELP = ", ".join(f"{number} {name}" for number, name in enumerate(PLANES))
LINK_STATE_BYTES = sum(size for _, size, _ in LINK_STATE)
MAX_READ = MAX_PAYLOAD - LINK_STATE_BYTES
SESSION = ("session", 4, "number that the host gave with RESET, 0 after power-up")
IDENTITY_BYTES = sum(size for _, size, _ in IDENTITY)
PADDING = ("padding", -IDENTITY_BYTES % WORD_BYTES, "0")

PAYLOADS = {
    Opcode.HELLO: Payload(),
    Opcode.STATUS: Payload(),
    Opcode.RESET: Payload((("session", 4, "any number; HELLO repeats it"),)),
    Opcode.BAUD: Payload((("phase_step", 4, "the new rate: round(2**24 * baud / clk_frequency_hz)"),)),
    Opcode.CLEAR: Payload((("colour", 4, "every pixel of plane 0; plane 1 becomes empty: farthest"),)),
    Opcode.STATE: Payload(
        (("address", 4, "where the first word goes; the others follow"),),
        least=WORD_BYTES,
        most=MAX_PAYLOAD - WORD_BYTES,
    ),
    Opcode.TRIANGLES: Payload((), least=WORD_BYTES, most=MAX_PAYLOAD),
    Opcode.READ: Payload(
        (
            ("x", 2, "first column"),
            ("y", 2, "first scanline"),
            ("width", 2, "columns; after the last one the next scanline's follow"),
            ("count", 2, f"bytes wanted, 1 to {MAX_READ}"),
            ("pixels", 2, "pixels that these are"),
            ("plane", 2, f"{PLANE_HELP}; {PACKED} more: packed if that is shorter"),
        )
    ),
    Opcode.FRAME_CRC: Payload((("reserved", 2, "0"), ("plane", 2, PLANE_HELP))),
    Opcode.SWAP: Payload(),
    Opcode.ACK: Payload(LINK_STATE),
    Opcode.NAK: Payload(LINK_STATE),
    Opcode.RESET_ANSWER: Payload(LINK_STATE),
    Opcode.BAUD_ANSWER: Payload(LINK_STATE),
    Opcode.HELLO_ANSWER: Payload((*LINK_STATE, SESSION, *IDENTITY, PADDING)),
    Opcode.STATUS_ANSWER: Payload((*LINK_STATE, *((name, WORD_BYTES, text) for name, _, text in COUNTERS))),
    Opcode.READ_ANSWER: Payload(LINK_STATE, least=1, most=MAX_READ),
    Opcode.FRAME_CRC_ANSWER: Payload((*LINK_STATE, ("crc", 4, "CRC-32 of the plane, scanline by scanline"))),
}
"""Every opcode's payload."""


def _numbers(table: object) -> object:
    """A table without its prose: what has to be the same on both sides."""
    if isinstance(table, tuple) and len(table) == 3 and isinstance(table[0], str):
        return table[:2]
    if isinstance(table, tuple):
        return tuple(_numbers(row) for row in table)
    return table


HASHED_NAMES = (("beat_words", "stream_lanes"), ("difference_words", "word_lanes"))
"""
Derived widths and the names under which :func:`definition_text` has them. A name means nothing on the line,
so boards built before these were renamed still agree with the host.
"""


def definition_text() -> str:
    """
    Everything that host and board must agree on, as text: formats, packet layout, protocol.

    Its labels and the names of :data:`HASHED_NAMES` never change: HELLO's ``definition`` is made from it.
    """
    tables = (
        ("derived", formats.DERIVED),
        ("sections", tuple((name, _numbers(section)) for name, section in formats.SECTIONS)),
        ("planes", formats.DIFFERENCES),
        ("planes_of_order", formats.DIFFERENCES_OF_ORDER),
        ("packed", (packed_format.FIELD_KINDS, packed_format.RAW_FIELDS, packed_format.FILLS)),
        ("channel_kinds", packed_format.CHANNEL_KINDS),
        ("vertices", vertex_program.REVISION),
        ("widths", (packed_format.KIND_WIDTHS, packed_format.FIELD_WIDTHS, packed_format.SIZES)),
        ("generics", tuple(field.name for field in fields(formats.Formats))),
        ("protocol", (VERSION, HEADER_FIELDS, CRC_BYTES, MAX_BODY, PHASE_BITS, BREAK_BITS)),
        ("reasons", tuple((reason.name, int(reason)) for reason in Reason)),
        ("features", FEATURES),
        ("counters", COUNTERS),
        ("planes", PLANES),
        ("packed_read", (PACKED, ESCAPE_ONES)),
        (
            "payloads",
            tuple(
                (opcode.name, int(opcode), payload.fields, payload.least, payload.most)
                for opcode, payload in PAYLOADS.items()
            ),
        ),
    )
    text = "\n".join(f"{name} {_numbers(table)!r}" for name, table in tables)
    for name, hashed in HASHED_NAMES:
        text = re.sub(rf"\b{name}\b", hashed, text)
    return text


def definition_hash() -> int:
    """32 bits of :func:`definition_text`: HELLO's ``definition``."""
    return zlib.crc32(definition_text().encode())


def is_length_of(opcode: Opcode, length: int) -> bool:
    """Whether a payload of that many bytes is one of the opcode's."""
    low, high = PAYLOADS[opcode].lengths
    whole = opcode is Opcode.READ_ANSWER or length % WORD_BYTES == 0
    return low <= length <= high and whole


def pack_payload(opcode: Opcode, values: Mapping[str, int] | None = None, tail: bytes = b"") -> bytes:
    """
    A payload from its fields and what follows them.

    Parameters
    ----------
    opcode : Opcode
    values : mapping of str to int, optional
      Every field by name.
    tail : bytes
      What follows: words little endian, or READ's bytes.

    Raises
    ------
    LinkError
      A value that its field cannot hold, or a wrong length.
    """
    values = values or {}
    parts = []
    for name, size, _ in PAYLOADS[opcode].fields:
        value = 0 if name == "padding" else values[name]
        if not 0 <= value < 1 << (8 * size):
            raise LinkError(f"{opcode.name}: {name} is {value}", f"give 0 to {(1 << 8 * size) - 1}")
        parts.append(value.to_bytes(size, "little"))
    payload = b"".join(parts) + bytes(tail)
    if not is_length_of(opcode, len(payload)):
        low, high = PAYLOADS[opcode].lengths
        raise LinkError(
            f"{opcode.name}: {len(payload)} bytes of payload", f"give {low} to {high}, whole words"
        )
    return payload


def unpack_payload(opcode: Opcode, payload: bytes) -> tuple[dict[str, int], bytes]:
    """
    Fields of a payload and what follows them: the inverse of :func:`pack_payload`.

    Raises
    ------
    LinkError
      The payload has a length that the opcode does not have.
    """
    if not is_length_of(opcode, len(payload)):
        raise LinkError(f"{opcode.name} of {len(payload)} bytes", "the other end speaks another protocol")
    values = {}
    offset = 0
    for name, size, _ in PAYLOADS[opcode].fields:
        values[name] = int.from_bytes(payload[offset : offset + size], "little")
        offset += size
    values.pop("padding", None)
    return values, payload[offset:]


def phase_step(baud: int, clk_frequency_hz: int) -> int:
    """
    The phase step of a baud rate, rounded to nearest.

    Raises
    ------
    LinkError
      Fewer than four clocks a bit, or a rate that rounds to nothing.
    """
    if baud <= 0 or 4 * baud > clk_frequency_hz:
        raise LinkError(f"{baud} baud at {clk_frequency_hz} Hz", f"give 1 to {clk_frequency_hz // 4} baud")
    step = ((baud << (PHASE_BITS + 1)) // clk_frequency_hz + 1) // 2
    if step == 0:
        raise LinkError(f"{baud} baud is too slow at {clk_frequency_hz} Hz", "give a higher rate")
    return step


def fifo_words(payload_bytes: int) -> int:
    """Words that a sequenced frame takes in the board's command FIFO: its payload and one of header."""
    return 1 + payload_bytes // WORD_BYTES
