# SPDX-License-Identifier: Apache-2.0
"""The triangles of a file on a board."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from quadshade.board.settings import board_settings
from quadshade.board.tiled_screen import TiledScreen
from quadshade.contract.formats import Formats
from quadshade.contract.triangles import ScreenTriangles
from quadshade.files.triangle_file import open_triangles, screen_size
from quadshade.rendering.board import check_board, pack_error_for
from quadshade.rendering.groups import EngineChoice, PortChoice, SetupChoice
from quadshade.rendering.open_board import drawn_at, opened, screen_of, tile_store
from quadshade.rendering.settings import Reports
from quadshade.rendering.simulated import simulated_screen


@dataclass(frozen=True, eq=False)
class BoardPlanes:
    """
    What a board shows after it drew the triangles of a file.

    Attributes
    ----------
    planes : dict of str to array
      ``colour``, (height, width, channels) uint8; where the board has it ``depth``, (height, width) uint32.
    picture : (height, width, 3) uint8
    triangles : int
    statistics : dict
      Of the board's line.
    port : str
      Where the board is, or the boards are.
    """

    planes: dict[str, np.ndarray]
    picture: np.ndarray
    triangles: int
    statistics: dict[str, float]
    port: str


def draw_triangles_on_board(
    path: Path,
    generics: dict[str, int],
    setup: SetupChoice,
    engine: EngineChoice,
    port: PortChoice,
    reports: Reports,
) -> BoardPlanes:
    """
    Draw the triangles of a file on a board and fetch what it shows.

    Parameters
    ----------
    path : Path
      A triangles file.
    generics : dict of str to int
      Of a simulated board.
    setup : SetupChoice
    engine : EngineChoice
      What simulates it.
    port : PortChoice
    reports : Reports

    Returns
    -------
    BoardPlanes

    Raises
    ------
    QuadshadeError
      As for :func:`render_on_board`, or a malformed file.
    """
    check_board(port, generics, engine)
    settings, (width, height) = None, screen_size(path)
    if port.is_simulated:
        core = {name: value for name, value in generics.items() if name in Formats().generics()}
        formats = open_triangles(path, core)[1]
        screen = simulated_screen((width, height), formats.coord_bits)
        given = board_settings(None, screen, generics)
        settings = replace(given, formats=formats)
    with opened(port, settings, engine, reports) as pool:
        board = screen_of(pool, (width, height), reports, tile_store(port))
        wanted = {
            name: value
            for name, value in board.host_formats.generics().items()
            if name not in ("num_channels", "with_depth", "max_order")
        }
        loaded: ScreenTriangles = open_triangles(path, wanted)[0]
        pack_error = pack_error_for(port, board)
        board.draw(loaded, pack_error, **setup.arguments())
        names = ("colour", "depth") if board.formats.with_depth else ("colour",)
        planes = board.read_planes(names, width, height, port.verify)
        if "depth" in planes:
            planes["depth"] = board.as_depth(planes["depth"])
        if isinstance(board, TiledScreen):
            board.forget_tiles()
        board.show()
        return BoardPlanes(
            planes, board.as_rgb(planes["colour"]), len(loaded), board.statistics, drawn_at(port, board)
        )
