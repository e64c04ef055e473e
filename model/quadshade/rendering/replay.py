# SPDX-License-Identifier: Apache-2.0
"""A packed picture, drawn on a board."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from quadshade.board import BoardSettings
from quadshade.board.tiled_screen import TiledScreen
from quadshade.choices import VERIFIES, parse_verify
from quadshade.packing.frame_file import read_frame_file
from quadshade.rendering.groups import EngineChoice, PortChoice
from quadshade.rendering.open_board import drawn_at, opened, tile_store
from quadshade.rendering.settings import Reports
from quadshade.rendering.simulated import simulated_screen


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
    port : str
      Where the board is, or the boards are.
    """

    picture: np.ndarray | None
    triangles: int
    statistics: dict[str, float]
    port: str


def replay_on_board(
    path: Path, engine: EngineChoice, port: PortChoice, read: bool, reports: Reports
) -> Replayed:
    """
    Draw a packed picture on boards that have its generics; in tiles where a screen is not of its size.

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
      A malformed file, a board with other generics or that takes no vertices, or one that shows what it
      should not.
    """
    frame = read_frame_file(path)
    size = (frame.width, frame.height)
    settings = None
    if port.is_simulated:
        screen_size = simulated_screen(size, frame.formats.coord_bits)
        settings = BoardSettings(frame.formats, *screen_size, with_vertices=int(frame.vertices))
    with opened(port, settings, engine, reports) as pool:
        first = pool.boards[0]
        if len(pool.boards) == 1 and size == (first.width, first.height):
            first.replay(frame, verify=parse_verify(port.verify) != VERIFIES[-1])
            picture = first.read(verify=port.verify) if read else None
            first.show()
            return Replayed(picture, frame.triangles, first.statistics, drawn_at(port, first))
        screen = TiledScreen(pool, *size, reports.notice, reports.progress, tile_store(port), frame.formats)
        picture = screen.replay(frame, port.verify)
        screen.forget_tiles()
        return Replayed(picture, frame.triangles, screen.statistics, drawn_at(port, screen))
