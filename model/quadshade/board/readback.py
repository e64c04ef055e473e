# SPDX-License-Identifier: Apache-2.0
"""What a board shows: its planes, read back and compared with the golden model's."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from quadshade.board.fallbacks import COLOURS, clear_word
from quadshade.board.frame_time import BoardClock
from quadshade.choices import parse_verify
from quadshade.contract.formats import Formats
from quadshade.contract.identity import colour_bits, has_feature, plane_bytes
from quadshade.contract.protocol import PLANES
from quadshade.errors import QuadshadeError
from quadshade.golden.board import DrawnScreen
from quadshade.golden.screen.framebuffer import HALF_STEP, kept_colours
from quadshade.link.planes import read_area, read_picture
from quadshade.link.session import Session

if TYPE_CHECKING:
    from quadshade.board.ports import Port


class BoardReader:
    """The reading half of :class:`quadshade.board.Board`, which has the attributes below."""

    session: Session
    _port: Port
    identity: dict[str, int]
    formats: Formats
    width: int
    height: int
    _expected: DrawnScreen
    _is_shown: bool
    _ask: Callable[[Callable[[], Any]], Any]
    _report: Callable[[str, float, float], None]

    @property
    def clock(self) -> BoardClock:
        """What a picture's time depends on."""
        baud = self._port.baud or self.session.default_baud
        return BoardClock(
            self.identity["clk_frequency_hz"],
            baud,
            self.width,
            self.height,
            has_feature(self.identity, "single_buffer"),
            has_feature(self.identity, "vertices"),
            self.identity["fifo_words"],
        )

    def _check_size(self, width: int, height: int) -> None:
        for name, number in (("width", width), ("height", height)):
            if not isinstance(number, int | np.integer) or number < 1:
                raise QuadshadeError(f"the picture's {name} is {number!r}", "give a whole number from 1")
        if width > self.width or height > self.height:
            raise QuadshadeError(
                f"the picture has {width}x{height} pixels, the board's screen {self.width}x{self.height}",
                "draw a smaller one",
            )

    @property
    def colour_bits(self) -> int:
        """Bits that the board keeps of a colour: 8, or dithered 6 (of channel 1 five) or 4."""
        return colour_bits(self.identity)

    def nearest_colour(self, colour: tuple[int, int, int]) -> np.ndarray:
        """(3,) int: what is read of the pixels that a clear to a colour has filled."""
        channels = clear_word(colour, self.formats).to_bytes(4, "little")[: self.formats.emitted_channels]
        kept = kept_colours(np.array([[list(channels)]]), HALF_STEP, self.colour_bits)
        return self.as_rgb(kept)[0, 0]

    def _check_drawn(self) -> None:
        """What is drawn and read must be the picture that was begun with the last clear."""
        if self._is_shown:
            raise QuadshadeError(
                "the picture is shown by now, and the board draws and reads its other buffer",
                "read it before show(), or begin another one with clear()",
            )

    def read_plane(
        self,
        plane: str = "colour",
        width: int | None = None,
        height: int | None = None,
        verify: bool | str = True,
    ) -> np.ndarray:
        """
        Read a plane, or the part of it at the top left.

        Parameters
        ----------
        plane : str
          One of ``protocol.PLANES``: colour, depth, edges_diagonal, edges_eight.
        width, height : int, optional
          Of the part; all of it if left out.
        verify : bool or str
          One of ``choices.VERIFIES``. ``picture`` (True) fetches the plane and asks for the CRC of all of it,
          which must be that of the golden model's; ``crc`` asks for the CRC alone, and the plane is the
          model's; ``none`` (False) only fetches it.

        Returns
        -------
        (height, width, bytes) uint8

        Raises
        ------
        QuadshadeError
          The board has no such plane, or what it shows is not what the golden model predicts.
        """
        self._check_drawn()
        number = self._plane(plane)
        width = self.width if width is None else width
        height = self.height if height is None else height
        self._check_size(width, height)

        how = parse_verify(verify)
        if how == "crc":
            self.verify(plane)
            return self._expected.plane(number)[:height, :width].copy()

        def report(done: int, total: int) -> None:
            self._report("reading", done, total)

        if (width, height) == (self.width, self.height):
            picture = self._ask(lambda: read_picture(self.session, number, report))
        else:
            picture = self._ask(lambda: read_area(self.session, 0, 0, width, height, number, report))
        if how == "picture":
            self.verify(plane)
            if not np.array_equal(picture, self._expected.plane(number)[:height, :width]):
                raise self._mismatch(plane, picture)
        return picture

    def read(
        self, width: int | None = None, height: int | None = None, verify: bool | str = True
    ) -> np.ndarray:
        """
        The picture as RGB, (height, width, 3) uint8; as :meth:`read_plane`.

        One channel is shown grey, of more than three the first three.
        """
        return self.as_rgb(self.read_plane("colour", width, height, verify))

    @staticmethod
    def as_rgb(colour: np.ndarray) -> np.ndarray:
        """(h, w, 3) of a colour plane (h, w, c)."""
        return np.repeat(colour, COLOURS, axis=2) if colour.shape[2] == 1 else colour[:, :, :COLOURS]

    def read_depth(
        self, width: int | None = None, height: int | None = None, verify: bool | str = True
    ) -> np.ndarray:
        """(height, width) uint32 depth, 2**depth_bits - 1 where nothing was drawn; as :meth:`read_plane`."""
        return self.as_depth(self.read_plane("depth", width, height, verify))

    def read_planes(
        self,
        planes: Sequence[str],
        width: int | None = None,
        height: int | None = None,
        verify: bool | str = True,
    ) -> dict[str, np.ndarray]:
        """Several planes by their names; as :meth:`read_plane`."""
        return {plane: self.read_plane(plane, width, height, verify) for plane in planes}

    @staticmethod
    def as_depth(raw: np.ndarray) -> np.ndarray:
        """(h, w) uint32 of a depth plane (h, w, bytes)."""
        whole = np.zeros((*raw.shape[:2], 4), np.uint8)
        whole[:, :, : raw.shape[2]] = raw
        return whole.view("<u4")[:, :, 0]

    def _plane(self, plane: str) -> int:
        if plane not in PLANES:
            raise QuadshadeError(f"there is no plane {plane!r}", f"the planes are {', '.join(PLANES)}")
        number = PLANES.index(plane)
        if not self.has_plane(plane):
            raise QuadshadeError(f"the board has no plane {plane}", "build one with it")
        return number

    def verify(self, plane: str = "colour") -> int:
        """
        The CRC-32 of a plane, by the board; it is that of the golden model's plane.

        Raises
        ------
        QuadshadeError
          It is not. The plane is fetched then, to say where it differs.
        """
        self._check_drawn()
        number = self._plane(plane)
        crc = self._ask(lambda: self.session.frame_crc(number))
        if crc != zlib.crc32(self._expected.plane(number).tobytes()):
            size = (self.width, self.height)
            raise self._mismatch(plane, self._ask(lambda: read_area(self.session, 0, 0, *size, number)))
        return crc

    def _mismatch(self, plane: str, picture: np.ndarray) -> QuadshadeError:
        """What to say of a plane that the board shows, and of the first pixel that should be another."""
        height, width = picture.shape[:2]
        expected = self._expected.plane(PLANES.index(plane))[:height, :width]
        rows, columns = np.nonzero((picture != expected).any(axis=2))
        where = "its CRC is another, every pixel that was read is the same"
        if len(rows):
            y, x = rows[0], columns[0]
            shown, wanted = (" ".join(map(str, one[y, x])) for one in (picture, expected))
            where = (
                f"{len(rows)} of {height * width} pixels differ, the first at {x},{y}: {shown}, not {wanted}"
            )
        return QuadshadeError(
            f"the board's {plane} is not what the golden model predicts: {where}",
            "the bitstream is another, or the board fails: build it again, and try a lower clock",
        )

    def has_plane(self, plane: str) -> bool:
        """Whether the board can read a plane of ``protocol.PLANES``."""
        return plane in PLANES and bool(plane_bytes(self.identity)[PLANES.index(plane)])
