# SPDX-License-Identifier: Apache-2.0
"""``quadshade render``: a mesh becomes a picture."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click
import numpy as np

from quadshade.cli.adapt_options import adapt_report
from quadshade.cli.interrupts import leave_at_once
from quadshade.cli.options import GENERICS_EPILOG, PATH, engine_option, stats_option, waves_option
from quadshade.cli.pack import pack_error_option
from quadshade.cli.port_options import PortChoice, on_board, port_options
from quadshade.cli.scene_options import (
    COLOUR_CHANNELS,
    PHONG,
    SceneChoice,
    ShownScene,
    progress,
    scene_options,
    shade_scene,
    show_scene,
)
from quadshade.cli.setup_options import undefined_note
from quadshade.cli.style_options import StyleChoice, draw_style, style_options, styled_choice, styled_scene
from quadshade.errors import QuadshadeError
from quadshade.files.atomic import check_writable, write_atomically, write_json

if TYPE_CHECKING:
    from quadshade.contract.formats import Formats
    from quadshade.contract.triangles import Drawing, ScreenTriangles


@click.command(epilog=GENERICS_EPILOG)
@click.option("-o", "--output", required=True, type=PATH, help="PNG file to write.")
@engine_option
@scene_options
@style_options
@port_options(own_verify=False, help_text="Draw on a board and fetch the picture")
@pack_error_option
@stats_option
@waves_option
def render(
    output: Path,
    engine: str | None,
    choice: SceneChoice,
    style_choice: StyleChoice,
    port_choice: PortChoice,
    pack_error: float,
    stats: Path | None,
    waves: Path | None,
) -> None:
    """
    Draw SCENE: a mesh file (OBJ, PLY, STL, GLB) or a generated mesh.

    Generated: sphere:168, sphere:12x17 (stacks x slices), torus:288, torus:16x9 (rings x sides), icosphere:3,
    cube:2 (divisions of an edge).

    \b
    quadshade render sphere:168 -o sphere.png --exponent 50
    quadshade render part.stl -o part.png --camera from=1,1,2 --material colour=0.8,0.3,0.1
    quadshade render scene.glb -o scene.png --light dir=1,1,1 --light ambient=0.2 --size 640x480
    quadshade render torus:288 -o torus.png --engine ghdl --stats stats.json --waves torus.ghw
    quadshade render torus:288 -o torus.png --generic stream_width=128
    quadshade render sphere:690 -o sphere.png --max-error 4
    quadshade render sphere:690 -o sphere.png --budget 30000bytes --error-measure rms
    quadshade render part.stl -o part.png --style gooch --edges profile,inner
    quadshade render sphere:690 -o sphere.png --port sim
    """
    with leave_at_once():
        from quadshade.engine import default_engine
        from quadshade.image import paint, write_png

        if not choice.scene.startswith(("sphere:", "torus:", "cube:")):
            import trimesh  # noqa: F401 - what reads it takes it from there

    choice = styled_choice(style_choice, choice)
    if output.suffix.lower() != ".png":
        raise QuadshadeError(f"the output is {str(output)!r}", "give a name that ends in .png")
    if on_board(port_choice, engine):
        from quadshade.cli.draw_on_board import render_on_board

        check_writable(output, stats, inputs=[choice.path])
        render_on_board(choice, port_choice, engine, output, stats, waves, pack_error, style_choice)
        return
    formats = choice.checked()
    # Phong shading is the host's own work: of the engine it needs coverage and depth only.
    engine = engine or ("model" if choice.shading == PHONG else default_engine())
    check_writable(output, stats, waves, style_choice.gbuffer, inputs=[choice.path])

    scene = styled_scene(style_choice, show_scene(choice, formats))
    projected = scene.projected
    with progress(f"drawing {len(projected)} triangles with the engine {engine}"):
        triangles, formats, adapted = shade_scene(choice, scene, formats)
        drawing, shown, value = _draw(scene, triangles, choice, formats, engine, waves)
        adaptive, note = adapt_report(
            choice.adapt_choice, adapted, drawing, projected, scene.lights, scene.surface, formats
        )
    picture = paint(shown, value, scene.ground, (1 << formats.value_bits) - 1)
    picture, more = draw_style(style_choice, picture, shown, scene, choice.generics, engine)
    write_atomically(output, lambda temporary: write_png(temporary, picture))
    if stats is not None:
        kind = "adaptive" if adaptive else choice.shading
        write_json(stats, _stats(drawing, choice.scene, kind, scene.faces, shown) | adaptive | more)
    clocks = "" if choice.shading == PHONG else f", {drawing.stats['clocks']} clocks"
    clocks += undefined_note(drawing.stats, choice.setup_choice["method"])
    click.echo(
        f"{output}: {projected.width}x{projected.height}, {len(projected)} triangles,"
        f" {len(drawing.pixels)} pixels{clocks}{note}"
    )


def _draw(
    scene: ShownScene,
    triangles: ScreenTriangles,
    choice: SceneChoice,
    formats: Formats,
    engine: str,
    waves: Path | None,
) -> tuple[Drawing, np.ndarray, np.ndarray]:
    """What the engine drew, which of its pixels are seen, and their colours."""
    from quadshade.engine import draw
    from quadshade.image import visible
    from quadshade.shading.reference import phong

    projected = scene.projected
    drawing = draw(triangles, formats, engine, waves, **choice.setup_choice)
    pixels = drawing.pixels
    shown = visible(pixels, projected.width, projected.height)
    if choice.shading != PHONG:
        return drawing, shown, pixels.value
    # The engine's coverage and depth; only what is seen is worth shading.
    seen = shown[shown >= 0]
    value = np.zeros((len(pixels), COLOUR_CHANNELS), dtype=np.float32)
    value[seen] = phong(
        projected, pixels.triangle[seen], pixels.x[seen], pixels.y[seen], scene.lights, scene.surface, formats
    )
    return drawing, shown, value


def _stats(drawing: Drawing, scene: str, shading: str, faces: int, shown: np.ndarray) -> dict:
    """The engine's counts, with what the picture is of."""
    stats = dict(drawing.stats)
    if shading == PHONG:
        # The engine drew coverage and depth only: its clocks are not those of Phong shading.
        stats.update(clocks=None, clocks_per_pixel=None, words=None)
    height, width = shown.shape
    return stats | {
        "scene": scene,
        "shading": shading,
        "width": width,
        "height": height,
        "faces": faces,
        "visible_pixels": int(np.count_nonzero(shown >= 0)),
    }
