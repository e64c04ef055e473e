# SPDX-License-Identifier: Apache-2.0
"""The same on a board: it draws, and the picture is fetched."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace

import numpy as np

from quadshade.board import Board
from quadshade.board.tiled_screen import TiledScreen
from quadshade.choices import PHONG, parse_pack_error, parse_verify
from quadshade.contract.formats import Formats
from quadshade.errors import QuadshadeError
from quadshade.golden.screen.edge_map import edge_map
from quadshade.rendering.draw import adapt_note, draw_tones
from quadshade.rendering.groups import EngineChoice, PortChoice
from quadshade.rendering.in_time import in_time
from quadshade.rendering.levels import best_level, level_note
from quadshade.rendering.open_board import drawn_at, opened, screen_of, tile_store, workers_screen
from quadshade.rendering.picture import Picture, Stats
from quadshade.rendering.settings import RenderSettings, Reports
from quadshade.rendering.shade import ShownScene, board_count, shade_scene, show_scene
from quadshade.rendering.simulated import simulated_settings, worker_place
from quadshade.rendering.supersample import jitter, mean, moved
from quadshade.rendering.timing import Pace
from quadshade.style import EdgeMaps, draw_edges, draw_gbuffer, find_edges, sample_normals
from quadshade.style.edges import VARIANTS
from quadshade.style.gbuffer import background_normal, check_gbuffer, with_view_depth

VERIFIED = {
    "picture": ", as the golden model predicts",
    "crc": ", with the CRC of the golden model's picture, which this is",
    "none": "",
}
"""What a summary says of each of ``choices.VERIFIES``."""


def check_board(
    port: PortChoice, generics: Mapping[str, int], engine: EngineChoice, has_frame_time: bool = False
) -> None:
    """Refuse what only engines have, or only one board."""
    if has_frame_time and (port.dask is not None or len(port.ports) > 1):
        raise QuadshadeError(
            "a frame time is for one board",
            f"leave out {'--dask' if port.dask else 'all but one --port'}, or it",
        )
    if engine.waves is not None:
        raise QuadshadeError("a board has no waves", "leave --port out, and use --engine ghdl")
    if port.is_open and engine.engine is not None:
        raise QuadshadeError("an engine is given, and the board is open", "leave the engine out")
    if generics and port.port is not None and not port.is_simulated:
        raise QuadshadeError("--generic is given, and the board's generics are its own", "leave it out")


@contextmanager
def board_for(settings: RenderSettings, reports: Reports) -> Iterator[Board | TiledScreen]:
    """
    The board that settings name, or a simulated one that can draw what they ask for; of several, or for a
    picture that is larger than its screen, a screen that is drawn in tiles.

    Raises
    ------
    QuadshadeError
      What boards do not have, or no board.
    """
    choice, port = settings.scene, settings.port
    check_board(port, choice.set_generics, settings.engine, settings.adapt.frame_time is not None)
    if settings.style.gbuffer is not None:
        raise QuadshadeError("a board does not say which triangle it shows", "leave out --gbuffer, or --port")
    if choice.interpolation == PHONG:
        raise QuadshadeError("the shading is phong, which no board computes", "use another --shading")
    if isinstance(port.port, TiledScreen):
        yield port.port
        return
    if port.dask is not None:
        asked = choice.pixels if choice.size is not None or port.port is None else None
        with workers_screen(port, worker_place(settings), asked, reports) as tiled:
            yield tiled
        return
    simulated = simulated_settings(settings) if port.is_simulated else None
    with opened(port, simulated, settings.engine, reports) as pool:
        size = None if choice.size is None else choice.pixels
        screen = screen_of(pool, size, reports, tile_store(port))
        yield screen
        if isinstance(screen, TiledScreen):
            screen.forget_tiles()


def render_on_board(settings: RenderSettings, reports: Reports, pace: Pace | None = None) -> Picture:
    """
    Draw a scene on a board and fetch what it shows.

    Parameters
    ----------
    settings : RenderSettings
      Styled. Without a size the picture is as large as the board's screen.
    reports : Reports
    pace : Pace, optional
      Of the frames before, where there is a frame time.

    Returns
    -------
    Picture

    Raises
    ------
    QuadshadeError
      What boards do not have, a board that does not answer, or one that shows what it should not.
    """
    choice, port = settings.scene, settings.port
    with board_for(settings, reports) as board:
        pack_error = pack_error_for(port, board)
        size = (board.width, board.height) if choice.size is None else choice.size
        settings = settings.of_scene(generics=board.host_formats, size=size)
        formats = settings.checked()
        count = board_count(settings, board.formats)
        scene = best_level(settings, show_scene(settings, formats, reports), formats, reports, count)
        timing = None
        deadline: dict[str, float] = {}
        if settings.adapt.frame_time is not None:
            if isinstance(board, TiledScreen):
                raise QuadshadeError(
                    "a frame time for a picture in tiles",
                    "leave it out, or give one board, and no size beyond its screen",
                )
            paced = pace or Pace()
            scene, timing = in_time(settings, scene, formats, board.clock, reports, paced, board.formats)
            deadline = {"deadline": timing.milliseconds / 1000}
            pack_error = timing.levers.pack_error
        reports.step(f"shading {len(scene.projected)} triangles")
        shaded = shade_scene(settings, scene, formats, reports, count)
        triangles, (width, height) = shaded.triangles, settings.scene.pixels
        frames = []
        for by in jitter(choice.supersample, formats):
            placed = replace(scene, projected=moved(scene.projected, by, formats))
            board.clear(scene.ground)
            board.draw(moved(triangles, by, formats), pack_error, **deadline, **settings.setup.arguments())
            if isinstance(board, TiledScreen) and _needs_depth(settings, board):
                # In one go: each tile is drawn once for both.
                board.read_planes(("colour", "depth"), width, height, port.verify)
            frame = board.read(width, height, port.verify)
            frames.append(style_on_board(settings, frame, placed, board, reports))
        picture = mean(frames)
        if len(triangles) and (picture == board.nearest_colour(scene.ground)).all():
            reports.notice("the picture is empty: no triangle covers a pixel's centre; give a larger --size")
        stats = Stats(
            generics=board.formats.generics(),
            scene=choice.name,
            shading=choice.interpolation if shaded.adapted is None else "adaptive",
            width=width,
            height=height,
            faces=scene.faces,
            whole_faces=len(scene.whole),
            adaptive=None if shaded.adapted is None else shaded.adapted.mix(),
            port=drawn_at(port, board),
            line=board.statistics,
            timing=None if timing is None else timing.as_dict(),
        )
    note = adapt_note(shaded) + ("" if timing is None else timing.note())
    summary = (
        f"{width}x{height}, {len(triangles)} triangles{level_note(scene)}, drawn by the board at {stats.port}"
        + _tiles_note(board)
        + VERIFIED[parse_verify(port.verify)]
        + (f", the mean of {choice.supersample**2} pictures" if choice.supersample > 1 else "")
        + (f", {board.colour_bits} bits a colour, dithered" if board.colour_bits < 8 else "")
        + _packing_note(pack_error)
        + note
    )
    return Picture(picture, stats, triangles, None, None, (), summary, settings)


def _tiles_note(board: Board | TiledScreen) -> str:
    """In how many tiles a picture was drawn; an empty one is drawn in none."""
    if not isinstance(board, TiledScreen) or not board.tiles:
        return ""
    return f", in {board.tiles} tile{'s' * (board.tiles != 1)}"


def pack_error_for(port: PortChoice, board: Board | TiledScreen) -> float:
    """Grey levels that packing may add: those asked for, else none in tiles, whose picture is the model's."""
    if isinstance(board, TiledScreen) and port.pack_error is None:
        return 0.0
    return parse_pack_error(port.added_error)


def _needs_depth(settings: RenderSettings, board: Board | TiledScreen) -> bool:
    """Whether a style looks at where something was drawn, and the board can say it by its depth."""
    return settings.style.style in ("hatch", "cartoon") and bool(board.formats.with_depth)


def _packing_note(pack_error: float) -> str:
    """How far shorter words may take a picture from the model's, and what gives equality."""
    if pack_error == 0:
        return ""
    return (
        f"; its words are packed to {pack_error:g} grey levels, which may move a pixel by one"
        " (--pack-error 0: none)"
    )


def style_on_board(
    settings: RenderSettings,
    picture: np.ndarray,
    scene: ShownScene,
    board: Board | TiledScreen,
    reports: Reports,
) -> np.ndarray:
    """
    Show a picture that a board has drawn, and make of it what a style says; the same board draws its edges.

    Parameters
    ----------
    settings : RenderSettings
    picture : (h, w, 3) uint8
    scene : ShownScene
    board : Board or TiledScreen
    reports : Reports

    Returns
    -------
    (h, w, 3) uint8
    """
    choice, verify = settings.style, settings.port.verify
    height, width = picture.shape[:2]
    if choice.style in ("hatch", "cartoon"):
        if board.formats.with_depth:
            drawn = board.read_depth(width, height, verify) < (1 << board.formats.depth_bits) - 1
        else:
            drawn = (picture != board.nearest_colour(scene.ground)).any(axis=2)
        picture = draw_tones(choice.style, picture, drawn, scene.ground)
    board.show()
    if not choice.kinds:
        return picture
    edges = _edges(settings, scene, board, reports)
    return draw_edges(picture, edges, choice.kinds, choice.colours)


def _edges(
    settings: RenderSettings, scene: ShownScene, board: Board | TiledScreen, reports: Reports
) -> EdgeMaps:
    """The edge map: the board's, that of the board's G-buffer, or the host's own."""
    choice, verify = settings.style, settings.port.verify
    order, space, variant = choice.gbuffer_order, choice.gbuffer_space, choice.edge_variant
    projected, formats = scene.projected, board.formats
    try:
        check_gbuffer(formats, order)
        reason = "" if board.colour_bits == 8 else f"the board keeps {board.colour_bits} bits of a colour"
    except QuadshadeError as error:
        reason = f"the board can draw no G-buffer: {error.message}"
    if reason:
        reports.notice(f"edges drawn by the host, as {reason}")
        return find_edges(draw_gbuffer(projected, Formats(), "model", order, space)[0], variant)
    placed, _ = with_view_depth(projected, formats)
    red, green, blue = background_normal(projected.axes, space).tolist()
    board.clear((red, green, blue))
    board.draw(sample_normals(placed, order, space, formats), pack_error_for(settings.port, board))
    plane, size = f"edges_{variant}", (projected.width, projected.height)
    # A board repeats the border of its screen, which has to be the picture's.
    if board.has_plane(plane) and size == (board.width, board.height):
        read = board.read_plane(plane, *size, verify)
        return EdgeMaps(read[..., 0], read[..., 1], variant)
    has = "its screen is of another size" if board.has_plane(plane) else "the board has no edge map"
    reports.notice(f"edges found by the host in the board's G-buffer, as {has}")
    shown = board.read_planes(("colour", "depth"), *size, verify)
    normal, depth = shown["colour"], board.as_depth(shown["depth"])
    maps = edge_map(normal, depth.astype(np.int64), formats.depth_bits, VARIANTS[variant])
    return EdgeMaps(*maps, variant)
