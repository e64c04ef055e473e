# SPDX-License-Identifier: Apache-2.0
"""``quadshade render``: a mesh becomes a picture."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from quadshade.choices import parse_fps, parse_frame_time
from quadshade.cli.interrupts import leave_at_once
from quadshade.cli.options import (
    GENERICS_EPILOG,
    Parsed,
    TitledCommand,
    add_options,
    dask_option,
    engine_option,
    option,
    output_option,
    stats_option,
    supersample_option,
    waves_option,
)
from quadshade.cli.port_options import port_options, resume_option, tile_store, with_board
from quadshade.cli.scene_options import (
    CLOCK_OPTIONS,
    ERROR_OPTIONS,
    FRAME_TIME,
    GENERIC_OPTIONS,
    PACK_OPTIONS,
    VERIFY_PICTURE,
    scene_options,
    setup_options,
    shading_options,
    verify_options,
)
from quadshade.cli.style_options import GBUFFER_OPTIONS, STYLE_OPTIONS
from quadshade.cli.terminal import reporting, say_statistics


@click.command(cls=TitledCommand, epilog=GENERICS_EPILOG, short_help="Draw a mesh file or a generated scene.")
@add_options(
    scene_options("512x512, or with --port the board's screen", "black; white with --style or --edges"),
    shading_options(),
    ERROR_OPTIONS,
    [
        option("Accuracy", "--frame-time", type=Parsed("MS", parse_frame_time), help=FRAME_TIME),
        option("Accuracy", "--fps", type=Parsed("N", parse_fps), help="--frame-time as frames a second."),
    ],
    CLOCK_OPTIONS,
    verify_options("Accuracy", VERIFY_PICTURE),
    setup_options(),
    GENERIC_OPTIONS,
    PACK_OPTIONS,
    STYLE_OPTIONS,
    GBUFFER_OPTIONS,
    [engine_option()],
    port_options("Draw on a board and fetch the picture", several=True),
    [resume_option, dask_option],
    [output_option("PNG file to write."), supersample_option, stats_option, waves_option],
)
def render(scene: str, output: Path, stats: Path | None, resume: bool, **options: Any) -> None:
    """
    Draw SCENE: a mesh file (OBJ, PLY, STL, GLB) or a generated mesh.

    Generated: sphere:168, sphere:12x17 (stacks x slices), torus:288, torus:16x9 (rings x sides), icosphere:3,
    cube:2 (divisions of an edge).

    \b
    quadshade render sphere:168 -o sphere.png --exponent 50
    quadshade render part.stl -o part.png --camera from=1,1,2 --material colour=1,0.5,0.1
    quadshade render knot.glb -o knot.png --light dir=1,1,1 --light ambient=0.2 --size 640x480
    quadshade render torus:288 -o torus.png --engine ghdl --stats stats.json --waves torus.ghw
    quadshade render torus:288 -o torus.png --generic stream_width=128
    quadshade render sphere:690 -o sphere.png --max-error 4
    quadshade render sphere:690 -o sphere.png --budget 30000bytes --error-measure rms
    quadshade render sphere:690 -o sphere.png --fps 10 --port sim
    quadshade render part.stl -o part.png --style gooch --edges profile,inner
    quadshade render sphere:690 -o sphere.png --port sim
    quadshade render sphere:690 -o sphere.png --size 1920x1080 --port sim:4
    """
    with leave_at_once():
        from quadshade.files.atomic import check_writable, write_json
        from quadshade.rendering.face import render as render_scene
        from quadshade.rendering.picture import check_png

        if scene.startswith("icosphere:"):
            import trimesh  # noqa: F401 - what divides it takes it from there

    check_png(output)
    keywords = with_board(options)
    check_writable(output, stats, options["waves"], options["gbuffer"], inputs=[Path(scene)])
    drawn_by = keywords["port"] if keywords["dask"] is None else keywords["dask"]
    keywords["resume"] = tile_store(output, resume, drawn_by)
    with reporting() as reports:
        picture = render_scene(scene, **keywords, reports=reports)
    if picture.stats.line is not None:
        say_statistics(picture.stats.line)
    picture.save(output)
    if stats is not None:
        write_json(stats, picture.stats.as_dict())
    click.echo(f"{output}: {picture.summary}")
