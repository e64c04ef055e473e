# SPDX-License-Identifier: Apache-2.0
"""What ``render`` and ``raster`` do with ``--port``: a board draws, and the picture is fetched."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import click
import numpy as np

from quadshade.board.settings import board_settings
from quadshade.cli.adapt_options import adapt_note
from quadshade.cli.port_options import PortChoice, is_given, opened
from quadshade.cli.scene_options import PHONG, SceneChoice, progress, shade_scene, show_scene
from quadshade.cli.style_on_board import can_draw_gbuffer, style_on_board
from quadshade.cli.style_options import StyleChoice, styled_scene
from quadshade.contract.formats import Formats, parse_generics
from quadshade.errors import QuadshadeError
from quadshade.files.atomic import write_atomically, write_json
from quadshade.files.triangle_file import open_triangles
from quadshade.image import write_png
from quadshade.shading.specular import SPECULAR_ORDERS


def _check(port: PortChoice, generics: tuple[str, ...], waves: Path | None) -> None:
    """Refuse what only engines have."""
    if waves is not None:
        raise QuadshadeError("a board has no waves", "leave --port out, and use --engine ghdl")
    if generics and not port.is_simulated:
        raise QuadshadeError("--generic is given, and the board's generics are its own", "leave it out")


def _as_text(formats: Formats) -> tuple[str, ...]:
    return tuple(f"{name}={value}" for name, value in formats.generics().items())


def render_on_board(
    choice: SceneChoice,
    port: PortChoice,
    engine: str | None,
    output: Path,
    stats: Path | None,
    waves: Path | None,
    pack_error: float,
    style_choice: StyleChoice,
) -> None:
    """
    Draw a scene on a board and write what it shows.

    Parameters
    ----------
    choice : SceneChoice
      Without ``--size`` the picture is as large as the board's screen.
    port : PortChoice
    engine : str or None
      What simulates a board of one's own.
    output, stats, waves : Path
    pack_error : float
    style_choice : StyleChoice
    """
    _check(port, choice.generics, waves)
    if style_choice.gbuffer is not None:
        raise QuadshadeError("a board does not say which triangle it shows", "leave out --gbuffer, or --port")
    if choice.shading == PHONG:
        raise QuadshadeError("the shading is phong, which no board computes", "use another --shading")
    shaded = choice.shading in SPECULAR_ORDERS
    size = choice.size if is_given("size") else None
    settings = None
    if port.is_simulated:
        settings = board_settings(None, size, choice.generics, shaded)
        if style_choice.style == "cartoon":
            settings = settings.with_generics({"num_specular": settings.formats.num_channels})
        free = not is_given("shading") and not choice.generics and not style_choice.kinds
        if choice.adapt_choice is not None and free:
            # Enough for colours and, of one light, for cosines; edges need a board without shade.
            settings = settings.with_generics({"with_shade": 1, "num_channels": 3, "num_specular": 1})
        if style_choice.kinds and can_draw_gbuffer(settings.formats):
            settings = settings.with_generics({"with_edge_map": 1})
    with opened(port, settings, engine if port.is_simulated else None) as board:
        choice = replace(
            choice, generics=_as_text(board.host_formats), size=size or f"{board.width}x{board.height}"
        )
        formats = choice.checked()
        scene = styled_scene(style_choice, show_scene(choice, formats))
        with progress(f"shading {len(scene.projected)} triangles"):
            triangles, _, adapted = shade_scene(choice, scene, formats)
        width, height = triangles.width, triangles.height
        board.clear(scene.ground)
        board.draw(triangles, pack_error, **choice.setup_choice)
        picture = board.read(width, height, port.verify)
        picture = style_on_board(style_choice, picture, scene, board, port.verify, pack_error)
        figures = board.statistics
        generics = board.formats.generics()
    write_atomically(output, lambda temporary: write_png(temporary, picture))
    if stats is not None:
        kind = choice.shading if adapted is None else "adaptive"
        about = {"scene": choice.scene, "shading": kind, "width": width, "height": height}
        about |= {} if adapted is None else {"adaptive": adapted.mix()}
        write_json(stats, {"port": port.port, **figures, **about, "faces": scene.faces, "generics": generics})
    click.echo(
        f"{output}: {width}x{height}, {len(triangles)} triangles, drawn by the board at {port.port}"
        + (", as the golden model predicts" if port.verify else "")
        + ("" if adapted is None else f"; {adapt_note(adapted)}")
    )


def raster_on_board(
    path: Path,
    port: PortChoice,
    engine: str | None,
    generics: tuple[str, ...],
    output: Path,
    stats: Path | None,
    waves: Path | None,
    setup_choice: dict,
) -> None:
    """
    Draw the triangles of a file on a board and write what it shows: a PNG file, or its planes as npz.

    Parameters
    ----------
    path : Path
    port, engine, generics, output, stats, waves
      As for :func:`render_on_board`.
    setup_choice : dict
      Arguments of :meth:`quadshade.board.Board.draw`.
    """
    _check(port, generics, waves)
    if output.suffix.lower() not in (".png", ".npz"):
        raise QuadshadeError(f"the output is {str(output)!r}", "give a name that ends in .png or .npz")
    settings = None
    if port.is_simulated:
        core = {name: value for name, value in parse_generics(generics).items() if hasattr(Formats, name)}
        triangles, formats = open_triangles(path, core)
        given = board_settings(None, f"{triangles.width}x{triangles.height}", generics)
        settings = replace(given, formats=formats)
    with opened(port, settings, engine if port.is_simulated else None) as board:
        wanted = {
            name: value
            for name, value in board.formats.generics().items()
            if name not in ("num_channels", "with_depth", "max_order")
        }
        triangles, _ = open_triangles(path, wanted)
        board.draw(triangles, **setup_choice)
        planes = {"colour": board.read_plane("colour", triangles.width, triangles.height, port.verify)}
        if board.formats.with_depth:
            planes["depth"] = board.read_depth(triangles.width, triangles.height, port.verify)
        picture = board.as_rgb(planes["colour"])
        figures = board.statistics
    if output.suffix.lower() == ".png":
        write_atomically(output, lambda temporary: write_png(temporary, picture))
    else:

        def write(temporary: Path) -> None:
            with temporary.open("wb") as file:
                np.savez(file, **planes)

        write_atomically(output, write)
    if stats is not None:
        write_json(
            stats, {"port": port.port, **figures, "width": triangles.width, "height": triangles.height}
        )
    click.echo(f"{output}: {len(triangles)} triangles, drawn by the board at {port.port}")
