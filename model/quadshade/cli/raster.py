# SPDX-License-Identifier: Apache-2.0
"""The command ``quadshade raster``: draw the triangles of a file, pixel by pixel in the engine's order."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from quadshade.choices import SAMPLED_SETUPS
from quadshade.cli.interrupts import leave_at_once
from quadshade.cli.options import (
    GENERICS_EPILOG,
    PATH,
    TitledCommand,
    add_options,
    engine_option,
    output_option,
    stats_option,
    waves_option,
)
from quadshade.cli.port_options import TITLE, port_options, resume_option, tile_store, with_board
from quadshade.cli.scene_options import GENERIC_OPTIONS, VERIFY_BOARD, setup_options, verify_options
from quadshade.cli.terminal import reporting, say_statistics
from quadshade.contract.formats import parse_generics
from quadshade.errors import QuadshadeError

if TYPE_CHECKING:
    from quadshade.rendering.groups import EngineChoice, PortChoice, SetupChoice


@click.command(cls=TitledCommand, epilog=GENERICS_EPILOG, short_help="Draw the screen triangles of a file.")
@click.argument("triangles_path", metavar="TRIANGLES.json", type=PATH)
@add_options(
    setup_options(SAMPLED_SETUPS),
    GENERIC_OPTIONS,
    [engine_option()],
    port_options("Draw on a board; OUTPUT is then a PNG file or its planes as npz", several=True),
    [resume_option],
    verify_options(TITLE, VERIFY_BOARD),
    [output_option("Where the pixels go, e.g. pixels.npz."), stats_option, waves_option],
)
def raster(
    triangles_path: Path,
    output: Path,
    stats: Path | None,
    generics: tuple[str, ...],
    resume: bool,
    **options: Any,
) -> None:
    """
    Draw the triangles of TRIANGLES.json; pixels come out in the order in which the engine emits them.

    \b
    quadshade raster triangles.json -o pixels.npz
    quadshade raster triangles.json -o picture.png --port sim
    """
    with leave_at_once():
        from quadshade.files.atomic import check_writable
        from quadshade.rendering.groups import EngineChoice, PortChoice, SetupChoice
        from quadshade.rendering.settings import collect

    check_writable(output, stats, options["waves"], inputs=[triangles_path])
    keywords = with_board(options)
    keywords["resume"] = tile_store(output, resume, keywords["port"])
    chosen = collect(SetupChoice, keywords), collect(EngineChoice, keywords), collect(PortChoice, keywords)
    if keywords["port"] is not None:
        _on_board(triangles_path, output, stats, parse_generics(generics), *chosen)
    else:
        _with_engine(triangles_path, output, stats, parse_generics(generics), *chosen[:2])


def _with_engine(
    path: Path,
    output: Path,
    stats: Path | None,
    generics: dict[str, int],
    setup: SetupChoice,
    engine: EngineChoice,
) -> None:
    """Pixels into a file."""
    from quadshade.files.atomic import write_json
    from quadshade.files.pixel_file import write_pixels
    from quadshade.rendering.draw import draw_triangles, undefined_note

    if output.suffix.lower() == ".png":
        raise QuadshadeError(
            f"the output is {str(output)!r}, and an engine gives single pixels, not a picture",
            "give a name that ends in .npz, or --port",
        )
    drawing = draw_triangles(path, generics, setup, engine)
    write_pixels(output, drawing.pixels)
    if stats:
        write_json(stats, drawing.stats)
    click.echo(
        f"{output}: {len(drawing.pixels)} pixels of {drawing.stats['triangles']} triangles, "
        f"{drawing.stats['clocks']} clocks ({drawing.stats['engine']}){undefined_note(drawing, setup)}"
    )


def _on_board(
    path: Path,
    output: Path,
    stats: Path | None,
    generics: dict[str, int],
    setup: SetupChoice,
    engine: EngineChoice,
    port: PortChoice,
) -> None:
    """What the board shows into a file."""
    from quadshade.files.atomic import write_atomically, write_json
    from quadshade.files.pixel_file import write_arrays
    from quadshade.image import write_png
    from quadshade.rendering.file_on_board import draw_triangles_on_board

    if output.suffix.lower() not in (".png", ".npz"):
        raise QuadshadeError(f"the output is {str(output)!r}", "give a name that ends in .png or .npz")
    with reporting() as reports:
        shown = draw_triangles_on_board(path, generics, setup, engine, port, reports)
    say_statistics(shown.statistics)
    if output.suffix.lower() == ".png":
        write_atomically(output, lambda temporary: write_png(temporary, shown.picture))
    else:
        write_arrays(output, shown.planes)
    if stats is not None:
        height, width = shown.picture.shape[:2]
        write_json(stats, {"port": shown.port, **shown.statistics, "width": width, "height": height})
    click.echo(f"{output}: {shown.triangles} triangles, drawn by the board at {shown.port}")
