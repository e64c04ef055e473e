# SPDX-License-Identifier: Apache-2.0
"""
A picture as it goes to a board, in a file: ``docs/reference/qs_file.md`` is the format.

Read with :func:`read_frame_file`, which says everything that has to be sent; :meth:`FrameFile.send` sends it.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from quadshade.choices import MAX_ERROR, PACK_ERROR
from quadshade.contract.formats import Formats
from quadshade.contract.identity import has_feature
from quadshade.contract.protocol import MAX_PAYLOAD, SEQUENCES, WORD_BYTES, Opcode, definition_hash
from quadshade.contract.releases import other_release
from quadshade.contract.shade_state import colour_state
from quadshade.contract.triangles import ScreenTriangles
from quadshade.errors import QuadshadeError
from quadshade.golden.screen.plane_reader import COLOUR, DEPTH
from quadshade.golden.screen.screen import Screen
from quadshade.golden.shade import render_core
from quadshade.link.frames import Frame
from quadshade.packing.neighbours import ordered_for_vertices
from quadshade.packing.pack import Packed, pack_primitives, unpack
from quadshade.packing.pack_vertices import as_run, pack_vertices, unpack_vertices
from quadshade.setup.triangle_setup import setup_triangles

if TYPE_CHECKING:
    from quadshade.link.session import Session

MAGIC = b"\x89QSF\r\n\x1a\n"
"""As PNG's: a transfer that takes the file for text damages it visibly."""

VERSION = 1
HEAD, STATE, TRIANGLES, VERTICES, END = b"HEAD", b"STAT", b"TRIS", b"VERT", b"DONE"
MAX_BLOCK = 1 << 16
"""Most bytes of a block's content."""

BOARD_VALUE_BITS = 8
"""A channel of a board's picture is a byte."""

GENERICS = tuple(Formats().generics())
HEAD_LAYOUT = f"<HHIHHIII{len(GENERICS)}B"
"""Version, number of generics, definition, width, height, clear colour, triangles, packets, generics."""

END_LAYOUT = "<III"
"""Packed words, CRC-32 of the picture, of the depth plane (0 without depth)."""


@dataclass(frozen=True)
class FrameFile:
    """
    A picture for a board.

    Attributes
    ----------
    formats : Formats
      Generics that the board has to have.
    width, height : int
      Screen of the board.
    clear_colour : int
      What CLEAR fills it with, the first channel in the lowest byte.
    words : (m,) uint32
      Packed words, in order.
    triangles, packets : int
      Drawn.
    state : tuple of (int, (k,) uint32)
      Address and words of each STATE, in order.
    crc, depth_crc : int
      What FRAME_CRC has to say of the picture, and of the depth plane (0 without depth).
    definition : int
      Hash of formats, packet layout and protocol.
    vertices : bool
      The words are for a board with ``vertex_unpacker``.
    """

    formats: Formats
    width: int
    height: int
    clear_colour: int
    words: np.ndarray
    triangles: int
    packets: int
    state: tuple[tuple[int, np.ndarray], ...] = ()
    crc: int = 0
    depth_crc: int = 0
    definition: int = field(default_factory=definition_hash)
    vertices: bool = False

    def send(self, session: Session) -> None:
        """
        Send everything.

        Parameters
        ----------
        session : quadshade.link.session.Session

        Raises
        ------
        QuadshadeError
          As for :meth:`check_sendable`.
        """
        self.check_sendable(session.identity)
        session.clear(self.clear_colour)
        for address, words in self.state:
            session.state(address, words)
        runs = has_feature(session.identity, "vertices") and not self.vertices
        session.triangles(as_run(self.words) if runs else self.words)

    def check_sendable(self, board: Mapping[str, int]) -> None:
        """Raise :class:`QuadshadeError` for a board, by HELLO's fields, that cannot draw the file."""
        if self.vertices and not has_feature(board, "vertices"):
            raise QuadshadeError(
                "the file holds vertices, which the board does not take", "pack without --vertices"
            )
        other = [pair for pair in self.formats.generics().items() if pair[1] != board[pair[0]]]
        if other:
            names = ", ".join(f"{name}={value} (the board: {board[name]})" for name, value in other)
            raise QuadshadeError(f"the file is for a board with {names}", "pack it again for this board")
        size = f"{board['screen_width']}x{board['screen_height']}"
        if f"{self.width}x{self.height}" != size:
            raise QuadshadeError(
                f"the file is for a screen of {self.width}x{self.height}, the board's is {size}",
                f"pack it with --size {size}",
            )

    def set_up_words(self) -> np.ndarray:
        """(n,) uint32: what the core gets."""
        return set_up_words(self.words, self.formats, self.vertices)

    def line_bytes(self) -> int:
        """Bytes of the triangles on an undamaged line: framing, header and CRC of full frames included."""
        return line_bytes(self.words)


def pack_frame(
    triangles: ScreenTriangles,
    formats: Formats,
    background: tuple[int, int, int] = (0, 0, 0),
    error: float = PACK_ERROR,
    limit: float | None = MAX_ERROR,
    vertices: bool = False,
    **setup: Any,
) -> tuple[FrameFile, Packed]:
    """
    Set triangles up, pack them, and predict the picture.

    Parameters
    ----------
    triangles : ScreenTriangles
    formats : Formats
    background : 3 ints
      0 .. 255.
    error : float
      As for :func:`quadshade.packing.pack.pack_primitives`.
    limit, **setup
      As for :func:`quadshade.setup.triangle_setup.setup_triangles`.
    vertices : bool
      For a board with ``vertex_unpacker``.

    Returns
    -------
    FrameFile, Packed

    Raises
    ------
    QuadshadeError
      A triangle out of range, formats that no board has: colours of other than 8 bits, a set-up stream of
      other than 32.
    """
    if formats.value_bits != BOARD_VALUE_BITS:
        raise QuadshadeError(f"generic value_bits is {formats.value_bits}", "a board's colours have 8 bits")
    if vertices:
        triangles = ordered_for_vertices(triangles, formats)
    primitives = setup_triangles(triangles, formats, limit=limit, **setup)
    if vertices:
        batch = pack_vertices(primitives, triangles, formats, error)
    else:
        batch = pack_primitives(primitives, formats, error, triangles.shade)
    state = None
    if formats.with_shade:
        state = colour_state(formats) if triangles.shade is None else triangles.shade
    colour = sum(level << 8 * index for index, level in enumerate(background))
    depth_bits = formats.depth_bits if formats.with_depth else None
    screen = Screen(triangles.width, triangles.height, formats.emitted_channels, depth_bits)
    screen.clear(colour)
    words = set_up_words(batch.words, formats, vertices)
    pixels = render_core.draw(words, formats, state)
    value, channels = pixels.value, formats.emitted_channels
    screen.draw(pixels.x, pixels.y, value[:, :channels], value[:, channels] if formats.with_depth else None)
    frame = FrameFile(
        formats,
        triangles.width,
        triangles.height,
        colour,
        batch.words,
        len(np.unique(primitives.triangle)),
        len(primitives),
        () if state is None else state_runs(render_core.needed_writes(words, state, formats)),
        screen.frame_crc(COLOUR),
        screen.frame_crc(DEPTH) if formats.with_depth else 0,
        vertices=vertices,
    )
    return frame, batch


def set_up_words(words: np.ndarray, formats: Formats, vertices: bool) -> np.ndarray:
    """(n,) uint32: what the core gets of packed words, or of those of a board with ``vertex_unpacker``."""
    return unpack_vertices(words, formats) if vertices else unpack(words, formats)


def state_runs(writes: np.ndarray) -> tuple[tuple[int, np.ndarray], ...]:
    """Writes (m, 2) of consecutive addresses together: address of the first, words."""
    breaks = np.flatnonzero(np.diff(writes[:, 0].astype(np.int64)) != 1) + 1
    return tuple((int(run[0, 0]), run[:, 1].copy()) for run in np.split(writes, breaks))


def line_bytes(words: np.ndarray) -> int:
    """Bytes that packed words take on the line in full TRIANGLES frames, everything included."""
    data = np.ascontiguousarray(words, "<u4").tobytes()
    pieces = [data[at : at + MAX_PAYLOAD] for at in range(0, len(data), MAX_PAYLOAD)]
    return sum(
        len(Frame(Opcode.TRIANGLES, number % SEQUENCES, piece).encode())
        for number, piece in enumerate(pieces)
    )


def block(kind: bytes, content: bytes) -> bytes:
    """A block: kind, length, content, CRC-32 of all three."""
    data = kind + struct.pack("<I", len(content)) + content
    return data + struct.pack("<I", zlib.crc32(data))


def encode_frame_file(frame: FrameFile) -> bytes:
    """The bytes of a file."""
    words = np.ascontiguousarray(frame.words, "<u4").tobytes()
    head = struct.pack(
        HEAD_LAYOUT,
        VERSION,
        len(GENERICS),
        frame.definition,
        frame.width,
        frame.height,
        frame.clear_colour,
        frame.triangles,
        frame.packets,
        *frame.formats.generics().values(),
    )
    most = MAX_BLOCK - WORD_BYTES
    blocks = [block(HEAD, head)]
    for address, values in frame.state:
        data = np.ascontiguousarray(values, "<u4").tobytes()
        for at in range(0, len(data), most):
            first = struct.pack("<I", address + at // WORD_BYTES)
            blocks.append(block(STATE, first + data[at : at + most]))
    kind = VERTICES if frame.vertices else TRIANGLES
    blocks += [block(kind, words[at : at + MAX_BLOCK]) for at in range(0, len(words), MAX_BLOCK)]
    end = struct.pack(END_LAYOUT, len(frame.words), frame.crc, frame.depth_crc)
    return MAGIC + b"".join(blocks) + block(END, end)


def _damaged(name: str, what: str) -> NoReturn:
    raise QuadshadeError(f"{name}: {what}", "make the file again with `quadshade pack`")


def _blocks(data: bytes, name: str) -> list[tuple[bytes, bytes]]:
    """Kind and content of every block, each with the right CRC, up to the last one."""
    blocks: list[tuple[bytes, bytes]] = []
    at = len(MAGIC)
    while not blocks or blocks[-1][0] != END:
        if at == len(data):
            _damaged(name, "the file is cut short: its last block is missing")
        kind, size = data[at : at + 4], int.from_bytes(data[at + 4 : at + 8], "little")
        if size > MAX_BLOCK:
            _damaged(name, f"the file is damaged: a block of {size} bytes at byte {at}")
        end = at + 8 + size
        if end + 4 > len(data):
            _damaged(name, f"the file is cut short within the block at byte {at}")
        if zlib.crc32(data[at:end]) != int.from_bytes(data[end : end + 4], "little"):
            _damaged(name, f"the file is damaged: wrong CRC of the block at byte {at}")
        blocks.append((kind, data[at + 8 : end]))
        at = end + 4
    if at != len(data):
        _damaged(name, f"{len(data) - at} bytes stand behind the last block")
    return blocks


def _head(content: bytes, name: str) -> dict[str, Any]:
    """What the first block says, as arguments of :class:`FrameFile`."""
    version = int.from_bytes(content[:2], "little")
    if version != VERSION:
        raise QuadshadeError(
            f"{name}: version {version} of the format, this is {VERSION}", "use the release that wrote it"
        )
    if len(content) != struct.calcsize(HEAD_LAYOUT):
        _damaged(name, "the header has the wrong length")
    _, count, definition, width, height, colour, triangles, packets, *generics = struct.unpack(
        HEAD_LAYOUT, content
    )
    if definition != definition_hash() or count != len(GENERICS):
        raise QuadshadeError(
            other_release(name, definition),
            "make the file again with `quadshade pack`, or use the release that wrote it",
        )
    try:
        formats = Formats(**dict(zip(GENERICS, generics, strict=True)))
    except QuadshadeError as error:
        _damaged(name, f"its generics are wrong: {error}")
    if not (1 <= width <= 1 << formats.coord_bits and 1 <= height <= 1 << formats.coord_bits):
        _damaged(name, f"a screen of {width} x {height} pixels")
    return {
        "formats": formats,
        "width": width,
        "height": height,
        "clear_colour": colour,
        "triangles": triangles,
        "packets": packets,
        "definition": definition,
    }


def decode_frame_file(data: bytes, name: str = "frame.qs") -> FrameFile:
    """
    The file that bytes hold.

    Parameters
    ----------
    data : bytes
    name : str
      What errors call it.

    Returns
    -------
    FrameFile

    Raises
    ------
    QuadshadeError
      No such file, a damaged one, one cut short, of another version or for other formats, or one whose packed
      words end within a packet.
    """
    if not data.startswith(MAGIC):
        raise QuadshadeError(f"{name}: no .qs file", "make one with `quadshade pack`")
    (first, head), *others, (_, end) = [*_blocks(data, name)]
    if first != HEAD or len(end) != struct.calcsize(END_LAYOUT):
        _damaged(name, "its first or last block is wrong")
    fields = _head(head, name)
    parts: list[bytes] = []
    state: list[tuple[int, np.ndarray]] = []
    kinds: set[bytes] = set()
    for kind, content in others:
        if kind not in (STATE, TRIANGLES, VERTICES) or len(content) % WORD_BYTES or len(content) < WORD_BYTES:
            _damaged(name, f"a block {kind!r} of {len(content)} bytes")
        if kind != STATE:
            parts.append(content)
            kinds.add(kind)
        else:
            address, *values = struct.unpack(f"<{len(content) // WORD_BYTES}I", content)
            state.append((address, np.array(values, np.uint32)))
    words = np.frombuffer(b"".join(parts), "<u4")
    count, crc, depth_crc = struct.unpack(END_LAYOUT, end)
    if count != len(words):
        _damaged(name, f"{len(words)} words, and not the {count} that its last block says")
    if len(kinds) > 1:
        _damaged(name, "its words are of two kinds")
    vertices = kinds == {VERTICES}
    frame = FrameFile(
        words=words, state=tuple(state), crc=crc, depth_crc=depth_crc, vertices=vertices, **fields
    )
    try:
        frame.set_up_words()
    except QuadshadeError as error:
        _damaged(name, str(error))
    return frame


def read_frame_file(path: Path) -> FrameFile:
    """
    Read a file.

    Raises
    ------
    QuadshadeError
      As for :func:`decode_frame_file`, or it cannot be read.
    """
    try:
        data = Path(path).read_bytes()
    except OSError as error:
        raise QuadshadeError(f"cannot read {path}: {error.strerror}", "give a .qs file") from None
    return decode_frame_file(data, str(path))
