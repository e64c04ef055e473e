# SPDX-License-Identifier: Apache-2.0
"""``quadshade pack``: what `render` draws, as the words that go over a board's line."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from quadshade.choices import BOARD_SHADINGS, PACK_ERROR
from quadshade.cli.interrupts import leave_at_once
from quadshade.cli.options import GENERICS_EPILOG, TitledCommand, add_options, generic_option, output_option
from quadshade.cli.scene_options import (
    ERROR_OPTIONS,
    PACK_OPTIONS,
    VERTEX_OPTIONS,
    scene_options,
    setup_options,
    shading_options,
    verify_option,
)
from quadshade.cli.terminal import reporting


@click.command(
    cls=TitledCommand, epilog=GENERICS_EPILOG, short_help="Pack a scene for a board, into FRAME.qs."
)
@add_options(
    scene_options(),
    shading_options(BOARD_SHADINGS),
    ERROR_OPTIONS,
    verify_option(),
    setup_options(),
    [generic_option(board=False)],
    PACK_OPTIONS,
    VERTEX_OPTIONS,
    [output_option("Where the packed picture goes: frame.qs.")],
)
def pack(scene: str, output: Path, pack_error: float | None, vertices: bool, **options: Any) -> None:
    """
    Pack SCENE for a board: what `render` draws, as the words that go over its line.

    \b
    quadshade pack sphere:690 -o frame.qs --size 320x240
    quadshade pack sphere:690 -o frame.qs --size 320x240 --pack-error 0
    quadshade pack sphere:690 -o vertices.qs --size 320x240 --vertices
    quadshade dump frame.qs
    """
    with leave_at_once():
        from quadshade.files.atomic import check_writable, write_bytes
        from quadshade.rendering.pack import pack_picture
        from quadshade.rendering.settings import RenderSettings

    check_writable(output, inputs=[Path(scene)])
    settings = RenderSettings.collect({"scene": scene, **options})
    with reporting() as reports:
        error = PACK_ERROR if pack_error is None else pack_error
        packed = pack_picture(settings, error, reports, vertices)
    write_bytes(output, packed.content)
    click.echo(f"{output}: {packed.summary}")
