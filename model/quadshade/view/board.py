# SPDX-License-Identifier: Apache-2.0
"""The same picture on a board, which must show what the golden model predicts."""

from __future__ import annotations

from typing import Any

from quadshade.board import Board
from quadshade.errors import QuadshadeError
from quadshade.view.shown import Viewed
from quadshade.view.state import ViewState

SAYS = {"picture": "picture and CRC equal", "crc": "CRC equal", "none": "drawn, not compared"}
"""What the page says of each of ``choices.VERIFIES``."""


class ViewedBoard:
    """
    A board that draws what is looked at.

    Parameters
    ----------
    board : Board
      Open; it is closed with this object.
    viewed : Viewed
    verify : str
      One of ``choices.VERIFIES``.
    """

    def __init__(self, board: Board, viewed: Viewed, verify: str = "crc") -> None:
        self._board, self._viewed, self._verify = board, viewed, verify
        self.name = f"{board.width}x{board.height}"
        self._stopped = ""

    def draw(self, state: ViewState) -> dict[str, Any]:
        """
        Draw a state, and compare what the screen shows; after a difference nothing is drawn any more.

        Returns
        -------
        dict
          ``text`` for the page, and whether the board goes on.
        """
        if self._stopped:
            return {"text": self._stopped, "goes_on": False}
        if state.is_reference:
            return {"text": "a board does not compute Phong shading", "goes_on": True}
        try:
            size = (min(state.width, self._board.width), min(state.height, self._board.height))
            choice = {"size": size, "port": self._board, "verify": self._verify}
            picture = self._viewed.picture(state, engine=None, generics=(), **choice)
        except QuadshadeError as error:
            self._stopped = f"stopped: {error}"
            return {"text": self._stopped, "goes_on": False}
        height, width = picture.array.shape[:2]
        return {"text": f"{SAYS[self._verify]}, {width}x{height}", "goes_on": True}

    def close(self) -> None:
        """Close the board."""
        self._board.close()
