# SPDX-License-Identifier: Apache-2.0
"""A screen of any size: boards draw it tile by tile, and the host puts together what they show."""

from __future__ import annotations

import time
import zlib
from collections.abc import Callable, Sequence
from contextlib import closing
from functools import partial
from typing import Any

import numpy as np

from quadshade.board.board import Board, Progress
from quadshade.board.fallbacks import host_formats
from quadshade.board.pool import BoardPool, Work
from quadshade.board.readback import BoardReader
from quadshade.board.tile_store import TileStore
from quadshade.board.tiled_picture import COLOUR, DEPTH, Planes, TiledPicture, margin_of, paste
from quadshade.board.worker_boards import WorkerBoard, WorkerPool
from quadshade.choices import MAX_ERROR, VERIFIES, parse_verify
from quadshade.contract.formats import Formats
from quadshade.contract.identity import has_feature
from quadshade.contract.shade_state import ShadeState
from quadshade.contract.triangles import ScreenTriangles
from quadshade.errors import QuadshadeError
from quadshade.packing.frame_file import FrameFile
from quadshade.packing.read_primitives import read_primitives
from quadshade.setup.refit import picture_formats, why_unfit
from quadshade.setup.tile import Rectangle

TILES = "drawing tiles"
"""What a tiled screen's progress is called."""


class TiledScreen:
    """
    What :class:`quadshade.Board` is for one screen, for a picture of any size and for any number of boards.

    Parameters
    ----------
    pool : BoardPool or WorkerPool
      Boards that cannot draw together with the first one are lost.
    width, height : int
      Of the picture.
    notice : callable
      Called with what the boards cannot do as asked.
    progress : callable, optional
      As for :class:`quadshade.Board`; it counts tiles.
    store : TileStore, optional
      Keeps the tiles that are done, and has those from before.
    formats : Formats, optional
      Of the picture; by default those that all boards have, with coordinates for its size. Boards that do
      not draw them bit for bit are lost.

    Attributes
    ----------
    formats : Formats
    host_formats : Formats
      Those to shade for.
    width, height : int
    pool : BoardPool or WorkerPool
    drawers : tuple of boards
      Those that go together; some may be lost by now.
    tiles : int
      Drawn so far.

    Raises
    ------
    QuadshadeError
      A picture that no core can address.
    """

    colour_bits = 8

    def __init__(
        self,
        pool: BoardPool | WorkerPool,
        width: int,
        height: int,
        notice: Callable[[str], None],
        progress: Progress | None = None,
        store: TileStore | None = None,
        formats: Formats | None = None,
    ) -> None:
        if any(board.colour_bits < self.colour_bits for board in pool.boards):
            raise QuadshadeError(
                "a board that keeps less than 8 bits of a colour draws no tiles", "draw a picture of its size"
            )
        self.pool, self.width, self.height = pool, width, height
        self._notice, self._progress, self._store = notice, progress, store
        self.formats = self._common(width, height) if formats is None else self._given(formats)
        self.host_formats = host_formats(self.formats)
        # Those of other formats are lost by now.
        self.drawers: tuple[Any, ...] = tuple(pool.boards)
        self._picture = TiledPicture(self.formats, width, height)
        self.tiles = 0
        self._start = time.monotonic()
        self.clear()

    def _common(self, width: int, height: int) -> Formats:
        """Formats that all boards draw; boards that do not go with those before them are lost."""
        kept: list[Any] = []
        boards: list[Any] = [*self.pool.boards]
        for board in boards:
            together = [one.formats for one in (*kept, board)]
            reasons = [why_unfit(picture_formats(together, width, height), one) for one in together]
            if any(reasons):
                # What it has other than those before it says more than what they all lack.
                before = picture_formats(together[:-1], width, height)
                reason = why_unfit(before, board.formats) or next(filter(None, reasons))
                self.pool.lose(board, f"it is of another design: {reason}")
            else:
                kept.append(board)
        return picture_formats([one.formats for one in kept], width, height)

    def _given(self, formats: Formats) -> Formats:
        """Formats that are given; boards that do not draw them are lost."""
        boards: list[Any] = [*self.pool.boards]
        for board in boards:
            if reason := why_unfit(formats, board.formats):
                self.pool.lose(board, reason)
        if not self.pool.boards:
            raise QuadshadeError(f"no board draws the picture: {reason}", "pack it again for these boards")
        return formats

    def on(self, pool: BoardPool) -> TiledScreen:
        """A screen of some of the boards, which draw by themselves what all of them would draw."""
        return TiledScreen(pool, self.width, self.height, self._notice, formats=self.formats)

    @property
    def name(self) -> str:
        """Where its boards are."""
        return ", ".join(board.session.name for board in self.drawers)

    @property
    def statistics(self) -> dict[str, float]:
        """Sums of what the boards' lines did (:attr:`quadshade.Board.statistics`), tiles, and seconds."""
        each = [board.statistics for board in self.pool.everyone]
        sums = {name: sum(one[name] for one in each) for name in each[0]}
        seconds = time.monotonic() - self._start
        return sums | {"triangles": self._picture.triangles, "seconds": seconds, "tiles": self.tiles}

    @property
    def each_statistics(self) -> dict[str, dict[str, float]]:
        """What each board's line did, by its name."""
        return {board.session.name: board.statistics for board in self.pool.everyone}

    def close(self) -> None:
        """Close all boards."""
        for board in self.pool.everyone:
            board.close()

    def notice(self, text: str) -> None:
        """Say what is not as asked."""
        self._notice(text)

    def clear(self, colour: tuple[int, int, int] = (0, 0, 0)) -> None:
        """Begin a picture: as :meth:`quadshade.Board.clear`."""
        self._picture.clear(colour)
        self._shown: Planes = {}

    def nearest_colour(self, colour: tuple[int, int, int]) -> np.ndarray:
        """(3,) int: as :meth:`quadshade.Board.nearest_colour`, of boards that keep every bit."""
        return np.array(colour)

    def show(self) -> None:
        """Nothing: each board has shown its tiles, one after the other."""

    def draw(
        self,
        triangles: ScreenTriangles,
        pack_error: float = 0.0,
        limit: float | None = MAX_ERROR,
        **setup: Any,
    ) -> None:
        """
        Draw triangles, made with :attr:`host_formats`; boards are told when something is read.

        Parameters
        ----------
        triangles, pack_error, limit, **setup
          As for :meth:`quadshade.board.tiled_picture.TiledPicture.draw`.
        """
        self._shown = {}
        for text in self._picture.draw(triangles, pack_error, limit, **setup):
            self._notice(text)

    def replay(self, frame: FrameFile, verify: bool | str = True) -> np.ndarray:
        """
        Draw a packed picture, as :meth:`quadshade.Board.replay`, for a screen that has its formats.

        Returns
        -------
        (height, width, 3) uint8
          The picture as RGB.
        """
        red, green, blue, _ = frame.clear_colour.to_bytes(4, "little")
        self.clear((red, green, blue) if self.formats.emitted_channels > 1 else (red,) * 3)
        shade = None
        if frame.state:
            written = {at + i: int(word) for at, words in frame.state for i, word in enumerate(words)}
            shade = ShadeState.from_registers(written, self.formats)
        self._picture.add(read_primitives(frame.set_up_words(), self.formats), shade, frame.triangles)
        wanted = {COLOUR: frame.crc} | ({DEPTH: frame.depth_crc} if self.formats.with_depth else {})
        self._shown = {}
        checks = parse_verify(verify) != VERIFIES[-1]
        planes = self.read_planes(tuple(wanted) if checks else (COLOUR,), verify=verify)
        for plane, pixels in planes.items():
            if checks and zlib.crc32(pixels.tobytes()) != wanted[plane]:
                raise QuadshadeError(f"the {plane} of the boards is not that of the file", "pack it again")
        return self.as_rgb(planes[COLOUR])

    # Reading, which is when boards draw.

    def has_plane(self, plane: str) -> bool:
        """Whether a plane of ``protocol.PLANES`` can be read."""
        if plane in (COLOUR, DEPTH):
            return plane == COLOUR or bool(self.formats.with_depth)
        # A board repeats its screen's border, so that has to be the picture's.
        fits = all(self.width >= one.width > 2 and self.height >= one.height > 2 for one in self.pool.boards)
        return fits and all(board.has_plane(plane) for board in self.pool.boards)

    def read_planes(
        self,
        planes: Sequence[str],
        width: int | None = None,
        height: int | None = None,
        verify: bool | str = True,
    ) -> dict[str, np.ndarray]:
        """
        Draw the picture, and read planes of it tile by tile: each tile is drawn once for all of them.

        Parameters
        ----------
        planes, width, height, verify
          As for :meth:`quadshade.Board.read_planes`.

        Returns
        -------
        dict of str to (height, width, bytes) uint8

        Raises
        ------
        QuadshadeError
          No such plane, or no board is left: then how many tiles are missing.
        """
        for plane in planes:
            if not self.has_plane(plane):
                raise QuadshadeError(f"the boards have no plane {plane}", "build them with it")
        missing = tuple(plane for plane in planes if plane not in self._shown)
        if missing:
            self._shown |= self._draw_tiles(missing, verify)
        return {plane: self._shown[plane][:height, :width] for plane in planes}

    def read_plane(
        self,
        plane: str = COLOUR,
        width: int | None = None,
        height: int | None = None,
        verify: bool | str = True,
    ) -> np.ndarray:
        """One of :meth:`read_planes`."""
        return self.read_planes([plane], width, height, verify)[plane]

    def read(
        self, width: int | None = None, height: int | None = None, verify: bool | str = True
    ) -> np.ndarray:
        """The picture as RGB, (height, width, 3) uint8."""
        return self.as_rgb(self.read_plane(COLOUR, width, height, verify))

    def read_depth(
        self, width: int | None = None, height: int | None = None, verify: bool | str = True
    ) -> np.ndarray:
        """(height, width) uint32 depth, as :meth:`quadshade.Board.read_depth`."""
        return self.as_depth(self.read_plane(DEPTH, width, height, verify))

    as_rgb, as_depth = staticmethod(BoardReader.as_rgb), staticmethod(BoardReader.as_depth)

    def forget_tiles(self) -> None:
        """The picture is whole: its tiles need not be kept any more."""
        if self._store is not None:
            self._store.remove()

    def _draw_tiles(self, planes: tuple[str, ...], verify: bool | str) -> Planes:
        """Planes of the picture, from those tiles that are there already and from the boards."""
        picture = self._picture
        made = picture.ground(planes)
        work: Work[Rectangle, Planes] = Work(
            partial(_draw_tile, picture, planes, verify),
            lambda board, tile: self._split(board, tile, planes),
            "tiles",
            "start it again with --resume: those that are done are kept" if self._store else "start it again",
        )
        most = [self._most(board, planes) for board in self.pool.boards]
        largest = max(most, key=lambda size: size[0] * size[1], default=(1, 1))
        packed = all(
            has_feature(board.identity, "packed_read")
            for board in self.pool.boards
            if isinstance(board, Board)
        )
        plan = picture.plan(largest, planes, len(self.pool.boards), packed)
        jobs = [(float(cost.bytes), cost.tile) for cost in plan]
        total, done = sum(cost for cost, _ in jobs), 0.0
        if self._store is not None:
            self._store.begin(picture.content(), planes)
            before = self._store.tiles()
            for tile, found in before:
                paste(made, tile, found)
            jobs = [job for job in jobs if not _is_covered(job[1], [tile for tile, _ in before])]
            done = total - sum(cost for cost, _ in jobs)
            if before:
                self._notice(f"{len(plan) - len(jobs)} of {len(plan)} tiles were drawn before")
        with closing(self.pool.share(work, jobs)) as shared:
            for finished in shared:
                self.tiles += 1
                paste(made, finished.job, finished.result)
                if self._store is not None:
                    self._store.add(finished.job, finished.result)
                done += finished.cost
                if self._progress is not None:
                    sums = self.statistics
                    sent = int(sums["bytes_sent"] + sums["bytes_received"])
                    self._progress(TILES, len(plan) * done / total, len(plan), sent)
        return made

    def _most(self, board: Board | WorkerBoard, planes: Sequence[str]) -> tuple[int, int]:
        """Largest tile that a board draws; a margin only where the picture goes on."""
        both = 2 * margin_of(planes)
        width, height = board.width, board.height
        return width - both * (self.width > width), height - both * (self.height > height)

    def _split(
        self, board: Board | WorkerBoard, tile: Rectangle, planes: Sequence[str]
    ) -> tuple[Rectangle, list[Rectangle]]:
        """The first part of a tile that fits a board's screen, and the others."""
        width, height = self._most(board, planes)
        across, down = -(-tile.width // width), -(-tile.height // height)
        xs = np.linspace(tile.left, tile.right, across + 1).astype(int).tolist()
        ys = np.linspace(tile.top, tile.bottom, down + 1).astype(int).tolist()
        parts = [
            Rectangle(xs[i], ys[j], xs[i + 1] - xs[i], ys[j + 1] - ys[j])
            for j in range(down)
            for i in range(across)
        ]
        return parts[0], parts[1:]


def _draw_tile(
    picture: TiledPicture, planes: Sequence[str], verify: bool | str, board: Board, tile: Rectangle
) -> Planes:
    """As :meth:`TiledPicture.draw_tile`, for a job that goes to other machines."""
    return picture.draw_tile(board, tile, planes, verify)


def _is_covered(tile: Rectangle, others: Sequence[Rectangle]) -> bool:
    """Whether other tiles, which do not overlap, have all of a tile's pixels."""
    area = 0
    for other in others:
        width = min(tile.right, other.right) - max(tile.left, other.left)
        height = min(tile.bottom, other.bottom) - max(tile.top, other.top)
        area += max(width, 0) * max(height, 0)
    return area == tile.width * tile.height
