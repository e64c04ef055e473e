# SPDX-License-Identifier: Apache-2.0
"""The command ``quadshade replay``: a packed picture goes to a board."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from quadshade.cli.options import PATH, TitledCommand, add_options, engine_option, output_option
from quadshade.cli.port_options import TITLE, port_options, resume_option, tile_store
from quadshade.cli.scene_options import VERIFY_BOARD, verify_options
from quadshade.cli.terminal import reporting, say_statistics, say_trace


@click.command(cls=TitledCommand, short_help="Draw FRAME.qs on a board.")
@click.argument("frame_path", metavar="FRAME.qs", type=PATH)
@add_options(
    [engine_option()],
    port_options(several=True),
    [resume_option],
    verify_options(TITLE, VERIFY_BOARD),
    [output_option("Read the picture back and write it: a PNG file.", required=False)],
)
def replay(frame_path: Path, output: Path | None, trace: bool, resume: bool, **options: Any) -> None:
    """
    Draw FRAME.qs, which `pack` made, on a board that has its generics; in tiles if its screen is another.

    \b
    quadshade replay frame.qs --port auto
    quadshade replay frame.qs --port sim -o picture.png
    """
    from quadshade.files.atomic import check_writable, write_atomically
    from quadshade.image import write_png
    from quadshade.rendering.groups import EngineChoice, PortChoice
    from quadshade.rendering.picture import check_png
    from quadshade.rendering.replay import replay_on_board
    from quadshade.rendering.settings import collect

    if output is not None:
        check_png(output)
    check_writable(output, inputs=[frame_path])
    if output is not None:
        options["resume"] = tile_store(output, resume)
    options["trace"] = say_trace if trace else None
    port = collect(PortChoice, options)
    with reporting() as reports:
        shown = replay_on_board(frame_path, collect(EngineChoice, options), port, output is not None, reports)
    say_statistics(shown.statistics)
    picture = shown.picture
    if output is not None and picture is not None:
        write_atomically(output, lambda temporary: write_png(temporary, picture))
    told = f", read into {output}" if output is not None else ""
    click.echo(f"{frame_path}: {shown.triangles} triangles drawn at {shown.port}{told}")
