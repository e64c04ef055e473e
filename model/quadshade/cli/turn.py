# SPDX-License-Identifier: Apache-2.0
"""``quadshade turn``: a scene that moves becomes a film."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from quadshade.choices import parse_turn_time
from quadshade.cli.interrupts import leave_at_once
from quadshade.cli.options import (
    GENERICS_EPILOG,
    Parsed,
    TitledCommand,
    add_options,
    dask_option,
    engine_option,
    option,
    supersample_option,
)
from quadshade.cli.port_options import port_options, with_board
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
from quadshade.cli.style_options import STYLE_OPTIONS
from quadshade.cli.terminal import reporting

MOTION_OPTIONS = [
    option("Motion", "--frames", type=int, default=60, show_default=True, help="How many pictures."),
    option("Motion", "--fps", type=float, default=25.0, show_default=True, help="Frames a second."),
    option(
        "Motion",
        "--frame-time",
        type=Parsed("MS|auto", parse_turn_time),
        help=f"{FRAME_TIME} auto: as long as --fps shows a frame. Level and channels stay.",
    ),
    option(
        "Motion",
        "--axis",
        default="y",
        show_default=True,
        metavar="AXIS",
        help="x, y, z or a direction such as 1,1,0, through the middle of the scene.",
    ),
    option(
        "Motion",
        "--turn",
        "degrees",
        type=float,
        metavar="DEGREES",
        help="By how much the object turns in all frames together.  [default: 360, or 0 where something else "
        "moves]",
    ),
    option(
        "Motion",
        "--light-orbit",
        type=float,
        metavar="DEGREES",
        help="By how much the lights turn about the same axis.",
    ),
    option(
        "Motion",
        "--keyframes",
        type=click.Path(path_type=Path),
        metavar="JSON",
        help='A list such as [{"frame": 0, "turn": 0}, {"frame": 30, "turn": 90, "fov": 12}]; also '
        "light_orbit, eye, from, target, up, ortho and exponent. Between key frames they change evenly.",
    ),
]

FILM_OPTIONS = [
    option(
        "Output",
        "-o",
        "--output",
        required=True,
        type=click.Path(path_type=Path),
        help="File to write, .gif, .webp, .png or .apng, or a folder for numbered pictures. Beside it: a "
        "table (CSV) and a plot of bytes, clocks and error.",
    ),
    option(
        "Output",
        "--errors/--no-errors",
        default=True,
        show_default=True,
        help="Measure every frame against Phong shading, for table and plot.",
    ),
    option(
        "Output",
        "--jobs",
        type=click.IntRange(1, 256),
        default=1,
        show_default=True,
        help="Processes that draw frames.",
    ),
]


@click.command(cls=TitledCommand, epilog=GENERICS_EPILOG, short_help="Turn a scene: a GIF, WebP or APNG.")
@add_options(
    scene_options("512x512, or with --port the board's screen", "black; white with --style or --edges"),
    MOTION_OPTIONS,
    shading_options(),
    ERROR_OPTIONS,
    CLOCK_OPTIONS,
    verify_options("Accuracy", VERIFY_PICTURE),
    setup_options(),
    GENERIC_OPTIONS,
    PACK_OPTIONS,
    STYLE_OPTIONS,
    [engine_option("model"), dask_option],
    port_options("Draw on a board and fetch every frame", several=True),
    FILM_OPTIONS,
    [supersample_option],
)
def turn(scene: str, output: Path, **options: Any) -> None:
    """
    Turn SCENE, or its lights, and write an animated picture.

    A killed run goes on where it stopped when it is started again; Ctrl-C leaves the frames so far.

    \b
    quadshade turn sphere:690 -o turn.gif
    quadshade turn part.stl -o part.webp --frames 120 --axis 1,1,0 --size 320x240
    quadshade turn knot.glb -o frames --light-orbit 360 --exponent 50
    quadshade turn pawn.obj -o pawn.png --keyframes keys.json --max-error 4
    quadshade turn torus:288 -o torus.gif --frames 8 --port sim
    quadshade turn torus:1152 -o torus.gif --fps 10 --frame-time auto --baud 1000000
    """
    with leave_at_once():
        from quadshade.animation.face import turn as turn_scene

    keywords = with_board(options)
    with reporting() as reports:
        animation = turn_scene(scene, **keywords, reports=reports)
        rows = animation.save(output)
    errors = [row.largest_error for row in rows if row.largest_error is not None]
    sizes = [row.bytes for row in rows if row.bytes is not None]
    texts = [f"{len(rows)} frame{'s' * (len(rows) != 1)} at {animation.motion.fps:g} a second"]
    if sizes:
        texts.append(f"{sum(sizes) / len(sizes):.0f} bytes a frame")
    if errors:
        texts.append(f"largest error {max(errors)} grey levels")
    times = [
        row.board_clocks / row.deadline_clocks for row in rows if row.board_clocks and row.deadline_clocks
    ]
    if times:
        late = sum(row.late or 0 for row in rows)
        shares = dict.fromkeys(f"{share(times):.1%}" for share in (min, max))
        texts.append(f"{' to '.join(shares)} of the frame time, {late} frame{'s' * (late != 1)} late")
    click.echo(f"{output}: {', '.join(texts)}")
