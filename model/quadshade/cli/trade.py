# SPDX-License-Identifier: Apache-2.0
"""``quadshade trade``: what each step of accuracy costs, over five axes."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from quadshade.choices import COSTS, DEFAULT_SIZE, ENGINES
from quadshade.cli.interrupts import leave_at_once
from quadshade.cli.options import GENERICS_EPILOG, complete_file, generic_option
from quadshade.cli.render import render
from quadshade.contract.formats import Formats, parse_generics
from quadshade.errors import QuadshadeError

if TYPE_CHECKING:
    from quadshade.trade import Sweep

VIEW = ("size", "camera", "lights", "material", "exponent", "cull", "crease")


def view_options(command: Callable[..., None]) -> Callable[..., None]:
    """The options of ``quadshade render`` that say what is looked at."""
    by_name = {option.name: option for option in render.params}
    declared = getattr(command, "__click_params__", [])
    params = [*declared, *(by_name[name] for name in reversed(VIEW))]
    command.__click_params__ = params  # type: ignore[attr-defined]
    return command


def _words(text: str) -> tuple[str, ...]:
    """Values between commas."""
    return tuple(word.strip() for word in text.split(",") if word.strip())


def _fractions(text: str) -> tuple[int, ...]:
    """Whole numbers between commas."""
    try:
        return tuple(int(word) for word in _words(text))
    except ValueError:
        raise QuadshadeError(f"the fractions are {text!r}", "give whole numbers, e.g. 8,12,22") from None


@click.command(epilog=GENERICS_EPILOG, short_help="Sweep settings of a scene: error against cost.")
@click.argument("scene", shell_complete=complete_file)
@click.option(
    "-o",
    "--output",
    type=click.Path(file_okay=False, path_type=Path),
    default=Path("trade"),
    show_default=True,
    help="Folder for trade.json, trade.csv and the pictures; what it holds already is not measured again.",
)
@click.option(
    "--fractions", default="8,10,12,16,22", show_default=True, help="Fraction bits of a colour word."
)
@click.option(
    "--shadings",
    help="Those of `quadshade render` but phong, and adaptive:E: the cheapest for an rms error of E.  "
    "[default: all, adaptive:1, adaptive:0.5]",
)
@click.option(
    "--subdivisions",
    default="none,all:1,all:2,highlights:128,centre:2",
    show_default=True,
    help="none, all:K (into four, K times), highlights:PIXELS (Cho et al.), centre:LEVELS (Abbas et al.).",
)
@click.option(
    "--lods",
    default="all",
    show_default=True,
    help="Levels of detail: all, or numbers of triangles at most; compared with Phong shading of all.",
)
@click.option(
    "--fits",
    default="six-point",
    show_default=True,
    help="Of the shading quadratic: those of `quadshade render`.",
)
@view_options
@click.option("--engine", type=click.Choice(ENGINES), default="model", show_default=True)
@click.option("--area/--no-area", default=True, show_default=True, help="Count cells by synthesis.")
@click.option("--device", default="ecp5-25k-6", show_default=True, help="What cells are counted on.")
@click.option(
    "--max-error",
    type=float,
    metavar="GREY",
    help="Recommend one point: of those whose largest error is no more, in grey levels, the cheapest.",
)
@click.option(
    "--minimise",
    type=click.Choice(COSTS),
    help="What --max-error minimises.  [default: bytes]",
)
@click.option("--jobs", type=click.IntRange(1, 256), help="Processes.  [default: all cores]")
@click.option("--dask", metavar="ADDRESS", help="Measure on a Dask cluster, e.g. tcp://host:8786.")
@generic_option(board=False)
def trade(
    scene: str,
    output: Path,
    fractions: str,
    shadings: str | None,
    subdivisions: str,
    lods: str,
    fits: str,
    size: str | None,
    camera: str,
    lights: tuple[str, ...],
    material: str,
    exponent: float | None,
    cull: bool,
    crease: float | None,
    engine: str,
    area: bool,
    device: str,
    max_error: float | None,
    minimise: str | None,
    jobs: int | None,
    dask: str | None,
    generics: tuple[str, ...],
) -> None:
    """
    Sweep fraction, shading, subdivision, density and fit over SCENE and mark the points that no other beats.

    Error is that against Phong shading of the same triangles, with --lods of all triangles; cost is bytes of
    set-up words, bytes on the serial line and clocks a picture, and LUTs of the smallest core that can draw
    it. A killed sweep goes on where it stopped.

    \b
    quadshade trade sphere:374 -o trade --exponent 50
    quadshade trade part.stl --size 256x256 --fractions 12,22 --subdivisions none,centre:4 --no-area
    quadshade trade sphere:374 --max-error 2 --minimise lut4
    quadshade trade knot.glb --lods all,500,100 --fits six-point,least-squares --subdivisions none --no-area
    quadshade trade torus:288 --dask tcp://host:8786
    """
    if minimise is not None and max_error is None:
        raise QuadshadeError("--minimise is given without an error", "give --max-error too")
    if max_error is not None and not 0 <= max_error < math.inf:
        raise QuadshadeError(f"the allowed error is {max_error:g}", "give a number of grey levels from 0")
    cost = minimise or COSTS[0]
    if max_error is not None and cost == "lut4" and not area:
        raise QuadshadeError("--minimise lut4 is given with --no-area", "leave --no-area out")
    with leave_at_once():
        from quadshade.scene.key_values import parse_size
        from quadshade.trade import Grid, View, sweep
        from quadshade.trade.grid import DEFAULT_SHADINGS, USUAL_SHADINGS
        from quadshade.trade.progress import progress_bars
        from quadshade.trade.subdivision import WHOLE

    base = Formats().with_generics(parse_generics(generics))
    if base.num_channels != 3:
        raise QuadshadeError(f"generic num_channels is {base.num_channels}", "a picture needs 3")
    width, height = parse_size(DEFAULT_SIZE if size is None else size)
    view = View(scene, width, height, camera, lights, material, exponent, crease, cull)
    divisions = _words(subdivisions)
    usual = DEFAULT_SHADINGS if WHOLE in divisions else USUAL_SHADINGS
    shadings_swept = usual if shadings is None else _words(shadings)
    grid = Grid(_fractions(fractions), shadings_swept, divisions, _words(lods), _words(fits))
    with progress_bars() as progress:
        result = sweep(view, grid, output, base, engine, area, device, jobs or -1, dask, progress)
    _say(result, output)
    if max_error is not None:
        from quadshade.trade.recommend import recommend

        found = recommend(result.records, max_error, cost, view, base)
        click.echo(f"recommended: {found.record['name']}")
        for part in found.reason.split("; "):
            click.echo(f"  {part}")
        click.echo(f"draw it: {found.command}")


def _say(result: Sweep, output: Path) -> None:
    """What was measured: counts, and the points that no other beats in bytes and error, as columns."""
    from quadshade.trade.recommend import table

    refused = sum(record["refused"] is not None for record in result.records)
    count = len(result.records)
    points = f"{count} point" if count == 1 else f"{count} points"
    click.echo(f"{output}/trade.json: {points}, {result.reused} from before, {refused} refused")
    if result.notice:
        click.echo(f"quadshade: notice: LUTs are not counted: {result.notice}", err=True)
    shown: dict[tuple[int, float], dict[str, Any]] = {}
    for record in result.records:
        if "bytes" in record["pareto"]:
            shown.setdefault((record["bytes"], record["rms"]), record)
    for line in table(sorted(shown.values(), key=lambda record: record["bytes"])):
        click.echo(line)
