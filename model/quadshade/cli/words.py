# SPDX-License-Identifier: Apache-2.0
"""``quadshade words``: set-up words and expected pixels for a design of one's own."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from quadshade.choices import BOARD_SHADINGS
from quadshade.cli.interrupts import leave_at_once
from quadshade.cli.options import (
    GENERICS_EPILOG,
    TitledCommand,
    add_options,
    generic_option,
    is_given,
    output_option,
)
from quadshade.cli.scene_options import (
    ERROR_OPTIONS,
    scene_options,
    setup_options,
    shading_options,
    verify_option,
)
from quadshade.cli.terminal import reporting
from quadshade.errors import QuadshadeError

FOR_FILES = ("scene", "output", "generics", "setup", "rounding", "stepping", "strict", "divide")


@click.command(
    cls=TitledCommand, epilog=GENERICS_EPILOG, short_help="Set-up words and pixels for your own design."
)
@add_options(
    scene_options(),
    shading_options(BOARD_SHADINGS),
    ERROR_OPTIONS,
    verify_option(),
    setup_options(),
    [generic_option(board=False), output_option("Where the words go: words.hex, .mem, .bin, .c or .vhd.")],
)
def words(scene: str, output: Path, generics: tuple[str, ...], **options: Any) -> None:
    """
    Write the set-up words of SCENE, a mesh or a triangles file, for a bench or a ROM of your own.

    Beside them stand where every field lies, the packets, and every pixel that the core emits for them:
    words.layout.csv, words.packets.csv, words.pixels.csv.

    \b
    quadshade words sphere:168 -o words.hex --size 160x120
    quadshade words triangles.json -o words.vhd
    """
    with leave_at_once():
        from quadshade.contract.formats import parse_generics
        from quadshade.files.atomic import check_writable
        from quadshade.files.word_file import table_path, writer_of
        from quadshade.rendering.groups import SetupChoice
        from quadshade.rendering.settings import RenderSettings, collect
        from quadshade.rendering.words import file_words, picture_words

    writer_of(output)
    tables = [table_path(output, name) for name in ("layout", "packets", "pixels", "state")]
    check_writable(output, *tables, inputs=[Path(scene)])
    with reporting() as reports:
        if scene.lower().endswith(".json"):
            for option in click.get_current_context().command.params:
                if option.name and option.name not in FOR_FILES and is_given(option.name):
                    raise QuadshadeError(
                        f"{option.opts[0]} is for a mesh, and {scene} is a triangles file", "leave it out"
                    )
            made = file_words(Path(scene), parse_generics(generics), collect(SetupChoice, options))
        else:
            made = picture_words(
                RenderSettings.collect({"scene": scene, "generics": generics, **options}), reports
            )
    made.save(output)
    click.echo(f"{output}: {made.summary}")
