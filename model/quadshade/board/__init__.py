# SPDX-License-Identifier: Apache-2.0
"""
Boards: the API to one (``Board``), and simulated ones.

``ports`` is the way to a board, ``fit`` what the host does for one that lacks something; ``settings`` are
the generics of a simulated board, ``engines`` what runs, ``lines`` its end of the line, ``simulated`` joins
them. ``docs/guide/board_api.md`` is the description.
"""

from quadshade.board.board import Board
from quadshade.board.settings import BoardSettings
from quadshade.board.simulated import SimulatedBoard

__all__ = ["Board", "BoardSettings", "SimulatedBoard"]
