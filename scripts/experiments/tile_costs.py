# SPDX-License-Identifier: Apache-2.0
"""What a tile takes of a board: bytes of its line both ways, clocks of its core and of what it reads."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

from quadshade.board import BoardSettings
from quadshade.board.fallbacks import host_formats
from quadshade.board.tiled_picture import TiledPicture
from quadshade.contract.formats import Formats
from quadshade.contract.protocol import MAX_PAYLOAD, PAYLOADS, WORD_BYTES, Opcode
from quadshade.engine.draw import draw_words
from quadshade.golden.link.pixel_packer import BYTE_BITS, packed_bits
from quadshade.golden.screen.screen import Screen
from quadshade.link.planes import pieces
from quadshade.packing.line import frame_bytes, frames_bytes
from quadshade.packing.pack import unpack
from quadshade.scene import fit_camera, load_scene, project
from quadshade.setup.refit import picture_formats
from quadshade.setup.tile import Rectangle
from quadshade.shading.sample import sample

WHOLE, PACKED, CRC = "whole", "packed", "crc"
"""How a tile comes back: byte by byte, packed, or by the CRC of what the host knows already."""

LINE_BITS = 10
"""Of a byte on the line."""

PACK_CLOCKS = 4
"""Of a byte that is packed, beside one for each bit: the first reading, before an answer begins."""


class Taken(NamedTuple):
    """
    What a tile takes.

    Attributes
    ----------
    sent, received : int
      Bytes to the board and from it.
    core : int
      Clocks in which the board clears and draws, while it is sent to.
    more : int
      Clocks in which the line waits: a CRC over the whole screen, and answers that are packed.
    """

    sent: int
    received: int
    core: int
    more: int = 0

    def clocks(self, baud: int, hertz: int) -> float:
        """Clocks of the board: it draws while it is sent to, and then it is read."""
        byte = LINE_BITS * hertz / baud
        return max(self.sent * byte, float(self.core)) + self.received * byte + self.more


@cache
def picture_of(scene: str, size: tuple[int, int], board: Formats) -> TiledPicture:
    """A scene, set up for a board's formats."""
    formats = picture_formats([board], *size)
    mesh, shading = load_scene(scene), host_formats(formats)
    projected = project(mesh, fit_camera(mesh), *size, shading)
    picture = TiledPicture(formats, *size)
    picture.draw(sample(projected, "quadratic", formats=shading), 0.0)
    return picture


def frame(opcode: Opcode, more: int = 0) -> int:
    """Bytes of a frame on the line, with ``more`` bytes behind its fields."""
    return frame_bytes(PAYLOADS[opcode].field_bytes + more)


def take(picture: TiledPicture, settings: BoardSettings, tile: Rectangle) -> dict[str, Taken]:
    """
    What a session with a board sends and gets for a tile.

    Parameters
    ----------
    picture : TiledPicture
    settings : BoardSettings
    tile : Rectangle

    Returns
    -------
    dict of str to Taken
      For each way of reading that the board has.
    """
    formats = settings.formats
    parts = picture.parts(tile, formats)
    size = formats.emitted_channels
    words = sum(len(part.words) for part in parts)
    acknowledged = 1 + sum(-(-len(part.words) * WORD_BYTES // MAX_PAYLOAD) for part in parts)
    pixels = settings.screen_width * settings.screen_height
    crc_clocks = pixels * size * settings.crc_cycles
    # Whether the board was reset is asked with every CRC, and before a picture is read.
    asked = frame(Opcode.FRAME_CRC) + frame(Opcode.STATUS)
    answered = frame(Opcode.FRAME_CRC_ANSWER) + frame(Opcode.STATUS_ANSWER)
    sent = frame(Opcode.CLEAR) + frames_bytes(words) + asked
    received = acknowledged * frame(Opcode.ACK) + answered

    drawn = [draw_words(unpack(part.words, formats), formats) for part in parts]
    depth_bits = formats.depth_bits if formats.with_depth else None
    screen = Screen(tile.width, tile.height, size, depth_bits)
    for one in drawn:
        depth = one.value[:, size] if formats.with_depth else None
        screen.draw(one.x, one.y, one.value[:, :size], depth)
    core = pixels + sum(one.clocks for one in drawn)
    taken = {CRC: Taken(sent, received, core, crc_clocks)}

    reads = list(pieces(0, 0, tile.width, tile.height, size))
    sent += len(reads) * frame(Opcode.READ) + frame(Opcode.STATUS)
    received += frame(Opcode.STATUS_ANSWER)
    answers = sum(frame(Opcode.READ_ANSWER, piece.pixels * size) for piece in reads)
    taken[WHOLE] = Taken(sent, received + answers, core, crc_clocks)
    if settings.with_packed_read:
        plane, more, answers = screen.plane(0), 0, 0
        for piece in reads:
            rows = plane[piece.y : piece.y + piece.height, piece.x : piece.x + piece.width]
            bits = len(packed_bits(rows.tobytes(), size))
            more += PACK_CLOCKS * rows.size + bits
            answers += frame(Opcode.READ_ANSWER, min(-(-bits // BYTE_BITS), rows.size))
        taken[PACKED] = Taken(sent, received + answers, core, crc_clocks + more)
    return taken


def schedule(jobs: list[float], count: int) -> float:
    """When the last of some boards is done that take jobs in their order, each as it gets free."""
    free = [0.0] * count
    for job in jobs:
        free[free.index(min(free))] += job
    return max(free)
