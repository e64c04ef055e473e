# SPDX-License-Identifier: Apache-2.0
"""Whole frames dealt to several boards: each draws one by itself, and takes the next when it is free."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from typing import TypeVar

from quadshade.board import Board
from quadshade.board.pool import BoardPool, Work
from quadshade.board.tiled_screen import TiledScreen
from quadshade.errors import QuadshadeError

Frame = TypeVar("Frame")

HINT = "start it again: those that are done are kept"


class _FrameError(Exception):
    """A frame cannot be drawn, and no board is to blame: none of them is lost."""

    def __init__(self, error: QuadshadeError) -> None:
        super().__init__(str(error))
        self.error = error


def dealt_frames(
    screen: TiledScreen, pool: BoardPool, frames: Sequence[int], draw: Callable[[TiledScreen, int], Frame]
) -> Iterator[Frame]:
    """
    Frames, each drawn by one board, in tiles where its screen is smaller.

    Parameters
    ----------
    screen : TiledScreen
      Of all boards. What it draws in tiles, each of them draws alone, bit for bit.
    pool : BoardPool
      The screen's.
    frames : sequence of int
    draw : callable
      Draws a frame on a screen of one board.

    Yields
    ------
    object
      What ``draw`` returned, as frames get ready. A board that is lost leaves its frame to the others.

    Raises
    ------
    QuadshadeError
      A frame that cannot be drawn; or no board is left: how many frames are missing.
    """

    def draw_alone(board: Board, frame: int) -> Frame:
        alone = BoardPool([board], screen.notice)
        try:
            return draw(screen.on(alone), frame)
        except QuadshadeError as error:
            if alone.boards:
                raise _FrameError(error) from error
            raise QuadshadeError(alone.reason) from error

    work: Work[int, Frame] = Work(draw_alone, lambda _, frame: (frame, []), "frames", HINT)
    try:
        with closing(pool.share(work, [(1.0, frame) for frame in frames])) as shared:
            for done in shared:
                yield done.result
    except _FrameError as problem:
        raise problem.error from None
