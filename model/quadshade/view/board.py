# SPDX-License-Identifier: Apache-2.0
"""The same picture on a board, which must show what the golden model predicts."""

from __future__ import annotations

from typing import Any

from quadshade.board import Board
from quadshade.errors import QuadshadeError
from quadshade.view.shown import Viewed
from quadshade.view.state import ViewState


class ViewedBoard:
    """
    A board that draws what is looked at.

    Parameters
    ----------
    board : Board
      Open; it is closed with this object.
    viewed : Viewed
    """

    def __init__(self, board: Board, viewed: Viewed) -> None:
        self._board, self._viewed = board, viewed
        self.name = f"{board.width}x{board.height}"
        self._stopped = ""

    def draw(self, state: ViewState) -> dict[str, Any]:
        """
        Draw a state, read the screen back and compare its CRC; after a difference nothing is drawn any more.

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
            picture = self._viewed.picture(state, size=size, port=self._board, engine=None, generics=())
        except QuadshadeError as error:
            self._stopped = f"stopped: {error}"
            return {"text": self._stopped, "goes_on": False}
        height, width = picture.array.shape[:2]
        return {"text": f"CRC equal, {width}x{height}", "goes_on": True}

    def close(self) -> None:
        """Close the board."""
        self._board.close()
