# SPDX-License-Identifier: Apache-2.0
"""
Boards: the API to one (``Board``), and simulated ones.

``ports`` opens the line to a board, ``readback`` reads its planes, ``fallbacks`` replaces what it lacks,
``frame_time`` says how long a picture takes.
A simulated board has its generics from ``settings``; ``engines`` runs the design, ``endpoints`` is its end of
the line, and ``simulated`` joins the two. ``docs/guide/board_api.md`` describes the use.
"""

from quadshade.board.board import Board
from quadshade.board.settings import BoardSettings
from quadshade.board.simulated import SimulatedBoard

__all__ = ["Board", "BoardSettings", "SimulatedBoard"]
