# SPDX-License-Identifier: Apache-2.0
"""A packed picture, drawn on a board."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from quadshade.board import BoardSettings
from quadshade.choices import VERIFIES, parse_verify
from quadshade.packing.frame_file import read_frame_file
from quadshade.rendering.board import opened
from quadshade.rendering.groups import EngineChoice, PortChoice
from quadshade.rendering.settings import Reports


@dataclass(frozen=True, eq=False)
class Replayed:
    """
    What came of a packed picture.

    Attributes
    ----------
    picture : (height, width, 3) uint8 or None
      If it was to be read.
    triangles : int
    statistics : dict
      Of the board's line.
    """

    picture: np.ndarray | None
    triangles: int
    statistics: dict[str, float]


def replay_on_board(
    path: Path, engine: EngineChoice, port: PortChoice, read: bool, reports: Reports
) -> Replayed:
    """
    Draw a packed picture on a board that has its generics and its screen.

    Parameters
    ----------
    path : Path
      A .qs file.
    engine : EngineChoice
      What simulates the board.
    port : PortChoice
      Without a port, the one that ``QUADSHADE_PORT`` names.
    read : bool
      Whether to read the picture back.
    reports : Reports

    Returns
    -------
    Replayed

    Raises
    ------
    QuadshadeError
      A malformed file, a board with other generics, or one that shows what it should not.
    """
    frame = read_frame_file(path)
    settings = BoardSettings(frame.formats, frame.width, frame.height) if port.is_simulated else None
    with opened(port, settings, engine, reports) as board:
        board.replay(frame, verify=parse_verify(port.verify) != VERIFIES[-1])
        picture = board.read(verify=port.verify) if read else None
        return Replayed(picture, frame.triangles, board.statistics)
