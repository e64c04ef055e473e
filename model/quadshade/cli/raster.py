# SPDX-License-Identifier: Apache-2.0
"""The command ``quadshade raster``: draw the triangles of a file, pixel by pixel in the engine's order."""

from __future__ import annotations

from pathlib import Path

import click
import numpy as np

from quadshade.cli.options import (
    GENERICS_EPILOG,
    PATH,
    engine_option,
    generic_option,
    stats_option,
    waves_option,
)
from quadshade.cli.port_options import PortChoice, on_board, port_options
from quadshade.cli.setup_options import SAMPLED, setup_options, undefined_note
from quadshade.contract.formats import parse_generics
from quadshade.contract.triangles import Pixels
from quadshade.engine import default_engine, draw
from quadshade.errors import QuadshadeError
from quadshade.files.atomic import check_writable, write_atomically, write_json
from quadshade.files.triangle_file import open_triangles


def write_pixels(path: Path, pixels: Pixels) -> None:
    """
    Write pixels as npz: ``triangle``, ``x``, ``y``, ``value`` and, if there is one, ``depth``, all int32.
    """
    columns = {"triangle": pixels.triangle, "x": pixels.x, "y": pixels.y, "value": pixels.value}
    if pixels.depth is not None:
        columns["depth"] = pixels.depth

    def write(temporary: Path) -> None:
        with temporary.open("wb") as file:
            np.savez(file, **{name: column.astype(np.int32) for name, column in columns.items()})

    write_atomically(path, write)


@click.command(epilog=GENERICS_EPILOG)
@click.argument("triangles_path", metavar="TRIANGLES.json", type=PATH)
@click.option("-o", "--output", required=True, type=PATH, help="Where the pixels go, e.g. pixels.npz.")
@engine_option
@port_options(help_text="Draw on a board; OUTPUT is then a PNG file or its planes as npz")
@setup_options(SAMPLED)
@stats_option
@waves_option
@generic_option
def raster(
    triangles_path: Path,
    output: Path,
    engine: str | None,
    stats: Path | None,
    waves: Path | None,
    generics: tuple[str, ...],
    setup_choice: dict,
    port_choice: PortChoice,
) -> None:
    """
    Draw the triangles of TRIANGLES.json; pixels come out in the order in which the engine emits them.

    \b
    quadshade raster triangles.json -o pixels.npz
    quadshade raster triangles.json -o picture.png --port sim
    """
    check_writable(output, stats, waves, inputs=[triangles_path])
    if on_board(port_choice, engine):
        from quadshade.cli.draw_on_board import raster_on_board

        raster_on_board(triangles_path, port_choice, engine, generics, output, stats, waves, setup_choice)
        return
    if output.suffix.lower() == ".png":
        raise QuadshadeError(
            f"the output is {str(output)!r}, and an engine gives single pixels, not a picture",
            "give a name that ends in .npz, or --port",
        )
    triangles, formats = open_triangles(triangles_path, parse_generics(generics))
    engine = engine or default_engine()
    try:
        drawing = draw(triangles, formats, engine, waves, **setup_choice)
        write_pixels(output, drawing.pixels)
    except MemoryError:
        raise QuadshadeError(
            f"{triangles_path}: {len(triangles)} triangles are too many for this machine's memory",
            "split the file",
        ) from None
    if stats:
        write_json(stats, drawing.stats)
    click.echo(
        f"{output}: {len(drawing.pixels)} pixels of {len(triangles)} triangles, "
        f"{drawing.stats['clocks']} clocks ({engine})"
        f"{undefined_note(drawing.stats, setup_choice['method'])}"
    )
