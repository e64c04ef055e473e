# SPDX-License-Identifier: Apache-2.0
"""The command ``quadshade replay``: a packed picture goes to a board."""

from __future__ import annotations

from pathlib import Path

import click

from quadshade.cli.options import PATH, engine_option
from quadshade.cli.port_options import PortChoice, opened, port_options
from quadshade.errors import QuadshadeError
from quadshade.files.atomic import check_writable, write_atomically


@click.command()
@click.argument("frame_path", metavar="FRAME.qs", type=PATH)
@click.option("-o", "--output", type=PATH, help="Read the picture back and write it: a PNG file.")
@engine_option
@port_options()
def replay(frame_path: Path, output: Path | None, engine: str | None, port_choice: PortChoice) -> None:
    """
    Draw FRAME.qs, which `pack` made, on a board that has its generics and its screen.

    \b
    quadshade replay frame.qs --port auto
    quadshade replay frame.qs --port sim -o picture.png
    """
    from quadshade.board.settings import BoardSettings
    from quadshade.image import write_png
    from quadshade.packing.frame_file import read_frame_file

    if output is not None and output.suffix.lower() != ".png":
        raise QuadshadeError(f"the output is {str(output)!r}", "give a name that ends in .png")
    check_writable(output, inputs=[frame_path])
    frame = read_frame_file(frame_path)
    settings = BoardSettings(frame.formats, frame.width, frame.height) if port_choice.is_simulated else None
    with opened(port_choice, settings, engine if port_choice.is_simulated else None) as board:
        board.replay(frame, verify=port_choice.verify)
        if output is not None:
            picture = board.read(verify=port_choice.verify)
            write_atomically(output, lambda temporary: write_png(temporary, picture))
    told = f", read into {output}" if output is not None else ""
    click.echo(f"{frame_path}: {frame.triangles} triangles drawn at {port_choice.port}{told}")
