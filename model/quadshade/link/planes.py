# SPDX-License-Identifier: Apache-2.0
"""The board's planes over a session, piece by piece, checked from end to end."""

from __future__ import annotations

import zlib
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from quadshade.contract.identity import has_feature, plane_bytes
from quadshade.contract.protocol import MAX_READ, PACKED, PLANES, LinkError, Opcode
from quadshade.link.packed_pixels import unpack_pixels
from quadshade.link.session import Session

READS = 16
PACKED_READS = 48
"""READs on their way at a time: in a line's time of a few tens of thousand bits."""

COLOUR, DEPTH = PLANES.index("colour"), PLANES.index("depth")


@dataclass(frozen=True)
class Piece:
    """A part of a plane that one READ asks for: ``height`` scanlines of ``width`` pixels from (x, y) on."""

    x: int
    y: int
    width: int
    height: int

    @property
    def pixels(self) -> int:
        """How many there are."""
        return self.width * self.height

    def question(self, size: int, plane: int) -> dict[str, int]:
        """READ's fields, for pixels of some bytes."""
        place = {"x": self.x, "y": self.y, "width": self.width}
        return place | {"count": self.pixels * size, "pixels": self.pixels, "plane": plane}

    def halves(self) -> tuple[Piece, ...]:
        """Two pieces that are this one; a pixel cannot be divided."""
        if self.height > 1:
            first = self.height // 2
            below = Piece(self.x, self.y + first, self.width, self.height - first)
            return Piece(self.x, self.y, self.width, first), below
        if self.width > 1:
            first = self.width // 2
            beside = Piece(self.x + first, self.y, self.width - first, 1)
            return Piece(self.x, self.y, first, 1), beside
        return (self,)


def pieces(x: int, y: int, width: int, height: int, size: int) -> Iterator[Piece]:
    """An area in pieces that an answer holds; ``size`` bytes a pixel."""
    most = MAX_READ // size
    columns = min(width, most)
    rows = most // columns if columns == width else 1
    for top in range(y, y + height, rows):
        for left in range(x, x + width, columns):
            yield Piece(left, top, min(columns, x + width - left), min(rows, y + height - top))


def read_area(
    session: Session,
    x: int,
    y: int,
    width: int,
    height: int,
    plane: int = COLOUR,
    progress: Callable[[int, int], None] | None = None,
) -> np.ndarray:
    """
    Fetch an area of a plane.

    A piece that does not arrive is asked for again in two halves, so a bad line gets short answers. A board
    that can pack them does.

    Parameters
    ----------
    session : Session
      Connected.
    x, y, width, height : int
      Within the screen.
    plane : int
      Index of ``protocol.PLANES``.
    progress : callable, optional
      Called with pixels that are there, and pixels in all.

    Returns
    -------
    (height, width, bytes) uint8

    Raises
    ------
    LinkError
      The link is too bad, the board has no such plane, or packs what cannot be unpacked.
    """
    size = plane_bytes(session.identity)[plane]
    if not size:
        raise LinkError(f"the board has no plane {PLANES[plane]}", "build it with one")
    packed = has_feature(session.identity, "packed_read")
    asked_plane, reads = (plane | PACKED, PACKED_READS) if packed else (plane, READS)
    area = np.zeros((height, width, size), np.uint8)
    waiting = deque(pieces(x, y, width, height, size))
    fruitless = done = 0
    while waiting:
        asked = [waiting.popleft() for _ in range(min(reads, len(waiting)))]
        found = session.ask(Opcode.READ, [piece.question(size, asked_plane) for piece in asked])
        fruitless = 0 if found else fruitless + 1
        if fruitless > session.retries:
            raise session.too_bad("READ")
        for index, piece in enumerate(asked):
            if index in found:
                data = unpack_pixels(found[index], piece.pixels * size, size)
                part = np.frombuffer(data, np.uint8).reshape(piece.height, piece.width, size)
                top, left = piece.y - y, piece.x - x
                area[top : top + piece.height, left : left + piece.width] = part
                done += piece.pixels
            else:
                waiting.extendleft(reversed(piece.halves()))
        if progress:
            progress(done, width * height)
    return area


def read_picture(
    session: Session, plane: int = COLOUR, progress: Callable[[int, int], None] | None = None
) -> np.ndarray:
    """
    Fetch a whole plane and compare its CRC with the one that the board computes.

    Parameters
    ----------
    session, plane, progress
      As for :func:`read_area`.

    Returns
    -------
    (height, width, bytes) uint8

    Raises
    ------
    LinkError
      The link is too bad, or the CRC differs.
    """
    width, height = session.identity["screen_width"], session.identity["screen_height"]
    picture = read_area(session, 0, 0, width, height, plane, progress)
    crc = session.frame_crc(plane)
    got = zlib.crc32(picture.tobytes())
    if got != crc:
        raise LinkError(
            f"the picture that was read has CRC {got:08x}, the board's {crc:08x}", "read it again"
        )
    return picture
