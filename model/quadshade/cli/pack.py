# SPDX-License-Identifier: Apache-2.0
"""``quadshade pack``: what `render` draws, as the words that go over a board's line."""

from __future__ import annotations

import math
from pathlib import Path

import click
import numpy as np

from quadshade.cli.adapt_options import adapt_note
from quadshade.cli.interrupts import leave_at_once
from quadshade.cli.options import GENERICS_EPILOG, PATH
from quadshade.cli.scene_options import PHONG, SceneChoice, progress, scene_options, shade_scene, show_scene
from quadshade.errors import QuadshadeError
from quadshade.files.atomic import check_writable, write_atomically


class PackError(click.ParamType):
    """A number of grey levels, or 0."""

    name = "GREY"

    def convert(self, value: object, param: click.Parameter | None, context: click.Context | None) -> float:
        """The number, or a usage error that says where to write it."""
        try:
            levels = float(value)
        except ValueError:
            levels = math.nan
        if not 0 <= levels < math.inf:
            self.fail(f"{value!r} is not a number of grey levels from 0; write for example 0.0625")
        return levels


pack_error_option = click.option(
    "--pack-error",
    type=PackError(),
    default="0.03125",
    show_default=True,
    help="Grey levels that words with fewer fraction bits may add to a pixel's error; 0 leaves every word "
    "and every edge as it is (docs/reference/packing.md).",
)


@click.command(epilog=GENERICS_EPILOG)
@click.option("-o", "--output", required=True, type=PATH, help="Where the packed picture goes: frame.qs.")
@scene_options
@pack_error_option
def pack(output: Path, choice: SceneChoice, pack_error: float) -> None:
    """
    Pack SCENE for a board: what `render` draws, as the words that go over its line.

    \b
    quadshade pack sphere:690 -o frame.qs --size 320x240
    quadshade pack sphere:690 -o frame.qs --size 320x240 --pack-error 0
    quadshade dump frame.qs
    """
    with leave_at_once():
        from quadshade.packing.frame_file import encode_frame_file, pack_frame

    formats = choice.checked()
    if choice.shading == PHONG:
        raise QuadshadeError("the shading is phong, which no board computes", "use another --shading")
    check_writable(output, inputs=[choice.path])
    scene = show_scene(choice, formats)
    with progress(f"packing {len(scene.projected)} triangles"):
        triangles, formats, adapted = shade_scene(choice, scene, formats)
        frame, batch = pack_frame(triangles, formats, scene.ground, pack_error, **choice.setup_choice)
    content = encode_frame_file(frame)
    write_atomically(output, lambda temporary: temporary.write_bytes(content))
    size = frame.line_bytes() / max(1, frame.triangles)
    undefined = int(np.count_nonzero(batch.primitives.undefined))
    click.echo(
        f"{output}: {frame.width}x{frame.height}, {frame.triangles} triangles in {frame.packets} packets, "
        f"{size:.1f} bytes a triangle on the line, at most {batch.added:.4f} grey levels added"
        + (f", {undefined} packets undefined and drawn as 0" if undefined else "")
        + ("" if adapted is None else f"; unpacked {adapt_note(adapted)}")
    )
