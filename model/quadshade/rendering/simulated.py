# SPDX-License-Identifier: Apache-2.0
"""Boards that are simulated, here or at workers: a real screen, and the generics that a picture needs."""

from __future__ import annotations

from quadshade.board import BoardSettings
from quadshade.board.settings import board_settings
from quadshade.board.worker_boards import ENGINE_SCREEN, Place
from quadshade.choices import SIM, SPECULAR_ORDERS, parse_faults, simulated_board
from quadshade.contract.formats import Formats
from quadshade.errors import QuadshadeError
from quadshade.rendering.settings import RenderSettings, Reports
from quadshade.rendering.shade import show_scene
from quadshade.setup.refit import picture_formats
from quadshade.shading import UnsuitedError, specular_formats
from quadshade.style.gbuffer import check_gbuffer

REAL_SCREEN = (BoardSettings.screen_width, BoardSettings.screen_height)
"""Of ULX3S 25F: a simulated board has it whatever is drawn, is built once, and draws larger ones in tiles."""


def simulated_screen(size: tuple[int, int] | None, coord_bits: int = Formats.coord_bits) -> tuple[int, int]:
    """
    The screen of a simulated board: a real one's, as far as its coordinates reach.

    Parameters
    ----------
    size : tuple of int or None
      Of the picture.
    coord_bits : int
      The board's generic.

    Raises
    ------
    QuadshadeError
      A picture that no core can address.
    """
    if size is not None:
        picture_formats([Formats()], *size)
    width, height = (min(side, 1 << coord_bits) for side in REAL_SCREEN)
    return width, height


def settings_of(name: str, settings: BoardSettings | None) -> BoardSettings | None:
    """
    Generics of the board that is simulated at a port: those of ``sim:BOARD``, else those that are given.

    Raises
    ------
    QuadshadeError
      No such board.
    """
    return board_settings(named, None, {}) if (named := simulated_board(name)) else settings


def simulated_settings(settings: RenderSettings) -> BoardSettings:
    """Generics of a simulated board that can draw what is asked for."""
    choice, style = settings.scene, settings.style
    given = choice.set_generics
    bits = given.get("coord_bits", Formats.coord_bits)
    size = None if choice.size is None else choice.pixels
    screen = simulated_screen(size, bits)
    channels = _shaded_channels(settings) if choice.interpolation in SPECULAR_ORDERS else {}
    built = board_settings(None, screen, channels | given)
    if (
        settings.adapt.is_adaptive
        and choice.shading is None
        and not settings.core_generics
        and not style.kinds
    ):
        # Enough for colours and, of one light, for cosines; edges need a board without shade.
        built = built.with_generics({"with_shade": 1, "num_channels": 3, "num_specular": 1})
    # The edge map of a screen that is larger than the picture ends elsewhere.
    is_filled = size is None or (size[0] >= built.screen_width and size[1] >= built.screen_height)
    if style.kinds and is_filled and _can_draw_gbuffer(built.formats):
        built = built.with_generics({"with_edge_map": 1})
    return built


def _shaded_channels(settings: RenderSettings) -> dict[str, int]:
    """Generics of a shade unit for a scene and its lights; none where it is drawn in colours instead."""
    choice = settings.scene
    scene = show_scene(settings, settings.checked(), Reports(notice=lambda _: None))
    try:
        formats = specular_formats(
            settings.core_generics, scene.projected, scene.lights, scene.surface, choice.toon is not None
        )
    except UnsuitedError:
        return {}
    return {name: getattr(formats, name) for name in ("with_shade", "num_channels", "num_specular")}


def _can_draw_gbuffer(formats: Formats) -> bool:
    """Whether a board with these generics can draw normals and depth."""
    try:
        check_gbuffer(formats, "linear")
    except QuadshadeError:
        return False
    return True


def worker_place(settings: RenderSettings) -> Place:
    """What each worker of a Dask scheduler draws with: a board of its own, or an engine."""
    port = settings.port
    # Of a board that is there already, nothing here counts.
    built = simulated_settings(settings) if port.is_simulated or port.port is None else BoardSettings()
    built = settings_of(port.port, built) or built
    if port.port is None:
        own = {"screen_width": ENGINE_SCREEN, "screen_height": ENGINE_SCREEN, "with_edge_map": 0}
        built = built.with_generics(own)
    faults = None if port.faults is None else parse_faults(port.faults)
    name = port.port if simulated_board(port.port) is None else SIM
    return Place(name, built, settings.engine.engine, port.baud, faults, port.timeout)
