# SPDX-License-Identifier: Apache-2.0
"""
Processor time of planning and of every fit, beside the host path of six points in the same run.

Writes docs/reports/planspeed.md and planspeed.json.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import click

from quadshade.adapt import adapt
from quadshade.choices import FITS, SPECULAR_FITS
from quadshade.contract.formats import Formats
from quadshade.files.markdown import markdown_table
from quadshade.fit import fit_scene
from quadshade.scene import fit_camera, load_scene, project
from quadshade.setup.packet import pack
from quadshade.setup.triangle_setup import setup_triangles
from quadshade.shading import Material, sample, sample_specular, specular_formats
from scripts.experiments.host_speed import peak_memory
from scripts.experiments.report_writer import REPORTS, command_line, met, output_option, write_report
from scripts.experiments.setup_speed import least_seconds
from scripts.one_line_errors import one_line_errors

REPORT = REPORTS / "planspeed.md"
SIZE = 512
SHINY = Material(exponent=50)
MAX_ERROR = 4.0
TARGETS = {"sphere:690": 15.0, "sphere:159x159": 1000.0}
"""Milliseconds that planning may take, of scenes of 690 and of 50,244 triangles."""
LEAST_SQUARES, MOST_RATIO = "sphere:317x317", 3.0
"""A mesh of 200,344 faces, and what least squares may take there, over the host path of six points."""
LARGE = (1001, 500)
"""Stacks and slices of a sphere of a million faces."""
LARGE_FITS = "six-point", "least-squares", "c1"
PATH = "six points"
PLAN = f"--max-error {MAX_ERROR:g}"


def _works(scene: str) -> tuple[int, dict[str, Callable[[], object]]]:
    """
    Visible triangles, and what is measured: the path of six points first, from mesh to packets.

    Of the mesh for least squares only these.
    """
    mesh = load_scene(scene)
    camera = fit_camera(mesh)
    seen = project(mesh, camera, SIZE, SIZE)
    kinds = {"": Formats(), "cosines, ": specular_formats({}, seen, None, SHINY)}

    def path(kind: str, fit: str) -> None:
        formats, shade = kinds[kind], sample_specular if kind else sample
        projected = project(mesh, camera, SIZE, SIZE, formats)
        triangles = shade(projected, material=SHINY, formats=formats)
        fitted = fit_scene(projected, triangles, fit, material=SHINY, formats=formats).triangles
        pack(setup_triangles(fitted, formats), formats)

    works: dict[str, Callable[[], object]] = {}
    for kind, fits in zip(kinds, (FITS, SPECULAR_FITS), strict=True):
        for fit in fits:
            works[kind + (PATH if fit == FITS[0] else fit)] = partial(path, kind, fit)
    if scene == LEAST_SQUARES:
        return len(seen), {what: works[what] for what in (PATH, "least-squares")}
    works[PLAN] = partial(adapt, seen, None, SHINY, max_error=MAX_ERROR, shading="auto")
    return len(seen), works


def measure(scenes: Sequence[str], repeats: int) -> list[dict[str, Any]]:
    """Rows: ``scene``, ``triangles`` that are seen, ``what``, ``seconds``, ``ratio`` to six points."""
    rows = []
    for scene in scenes:
        count, works = _works(scene)
        times = least_seconds(works, repeats)
        for what, seconds in times.items():
            ratio = seconds / times[PATH]
            rows.append(
                {"scene": scene, "triangles": count, "what": what, "seconds": seconds, "ratio": ratio}
            )
    return rows


def report(results: dict[str, Any]) -> str:
    """The report's text, from nothing but the numbers of the JSON file."""
    header = "scene", "triangles seen", "what", "ms", "to six points", "target, ms"
    cells = []
    for row in results["rows"]:
        spent, limit = 1e3 * row["seconds"], TARGETS.get(row["scene"])
        goal = "" if row["what"] != PLAN or limit is None else met(spent, limit, most=True)
        if row["scene"] == LEAST_SQUARES and row["what"] != PATH:
            goal = f"ratio {met(row['ratio'], MOST_RATIO, most=True)}"
        scene, count = row["scene"], f"{row['triangles']:,}"
        cells.append((scene, count, f"`{row['what']}`", f"{spent:.1f}", f"{row['ratio']:.2f}", goal))
    large = [
        (
            f"`--fit {fit}`",
            f"{run['processor_seconds']:.0f}",
            f"{run['gibibytes']:.2f}",
            _said(run["notices"]),
        )
        for fit, run in results["large"].items()
    ]
    columns = "fit", "seconds of a processor, start included", "peak GiB", "notices"
    return f"""# Speed of planning and of fits

Written by `{results["command"]}`
(`make hostspeed`). {SIZE} x {SIZE} pixels, the whole scene in the picture, exponent {SHINY.exponent:g}.
Processor time of one core, the least of several repetitions that took turns, compilation not counted;
the machine's load was {results["load"]}.

`{PATH}` is the path from the mesh to packets: transform, light, set up, pack. With the name of a
fit it is that path with the fit in it. `{PLAN}` plans an adaptive picture, every pixel
verified, channels chosen automatically; it contains Phong shading at every pixel and the drawing of
what it compares.

{markdown_table(header, cells)}

## A million faces

`quadshade render sphere:{LARGE[0]}x{LARGE[1]} --engine model --no-cull --size 1024x1024 --fit NAME`, in a
process of its own.
Above a million values `c1` is least squares.

{markdown_table(columns, large)}
"""


def _said(notices: list[str]) -> str:
    """What a fit says of itself on a mesh, without the pipe that would end a table's cell."""
    mark = "notice: "
    about = [line.split(mark, 1)[1] for line in notices if mark in line]
    return "; ".join(about).replace("|", "/") or "none"


@click.command()
@click.option(
    "--scene", multiple=True, default=(*TARGETS, LEAST_SQUARES), show_default=True, help="Generated meshes."
)
@click.option("--large/--no-large", default=True, help="Time a million faces too.")
@click.option("--repeats", default=5, show_default=True, help="Repetitions, of which the fastest counts.")
@output_option(REPORT)
@one_line_errors(REPORT.stem)
def main(scene: tuple[str, ...], large: bool, repeats: int, output: Path) -> None:
    """Measure planning and every fit on one core and write the table."""
    command = command_line("plan_speed", scene=scene, repeats=repeats)
    rows = measure(scene, repeats)
    fits = LARGE_FITS if large else ()
    results = {"command": command, "load": round(os.getloadavg()[0], 1), "rows": rows}
    results["large"] = {fit: peak_memory(*LARGE, "--fit", fit) for fit in fits}
    write_report(output, report(results), results)
    click.echo(report(results))


if __name__ == "__main__":
    main()
