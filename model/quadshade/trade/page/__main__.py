#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""
Sweep the report's scenes and write the page that shows what accuracy costs: build/report/index.html.

What was measured before is not measured again. Sections that need a report nobody has written yet say which
command writes it.
"""

from __future__ import annotations

import sys
from pathlib import Path

import click

from quadshade.errors import QuadshadeError
from quadshade.trade import Grid, View, sweep
from quadshade.trade.page import build_page
from quadshade.trade.page.screenshot import take_screenshot
from quadshade.trade.progress import progress_bars

ROOT = Path(__file__).resolve().parents[4]
SCENES = ("sphere:374", "sphere:168", "sphere:690", "torus:288")
FRACTIONS = (8, 12, 16, 22)
EXPONENT = 50.0
# As in the demo: light and viewer infinitely far away, the sphere as large as the picture.
SPHERE_CAMERA = "ortho=1.05"


def view(scene: str, size: int) -> View:
    """How the report looks at a scene."""
    camera = SPHERE_CAMERA if scene.startswith("sphere") else ""
    return View(scene, size, size, camera=camera, exponent=EXPONENT)


def write_report(
    output: Path, scenes: tuple[str, ...], grid: Grid, size: int, area: bool, jobs: int, dask: str | None
) -> Path:
    """Sweep all scenes into ``output/data`` and write the page; its path."""
    names = []
    for scene in scenes:
        names.append(scene.replace(":", "-"))
        folder = output / "data" / names[-1]
        with progress_bars() as progress:
            result = sweep(
                view(scene, size), grid, folder, area=area, jobs=jobs, dask=dask, progress=progress
            )
        click.echo(f"{scene}: {len(result.records)} points, {result.reused} from before")
        if result.notice:
            click.echo(f"report: LUTs are not counted: {result.notice}", err=True)
    return build_page(output, ROOT / "docs" / "reports", ROOT / "synth" / "resources.json", names)


@click.command(help=__doc__)
@click.option("--output", type=click.Path(path_type=Path), default=Path("build/report"), show_default=True)
@click.option("--scene", "scenes", multiple=True, default=SCENES, show_default=True, help="Repeatable.")
@click.option("--size", type=click.IntRange(16, 4096), default=512, show_default=True, help="Pixels a side.")
@click.option("--fraction", "fractions", type=int, multiple=True, default=FRACTIONS, show_default=True)
@click.option("--area/--no-area", default=True, help="Count cells by synthesis.")
@click.option("--jobs", type=click.IntRange(1), help="Processes.  [default: all cores]")
@click.option("--dask", metavar="ADDRESS", help="Measure on a Dask cluster.")
@click.option("--screenshot", type=click.Path(path_type=Path), help="PNG file for a picture of the page.")
def main(
    output: Path,
    scenes: tuple[str, ...],
    size: int,
    fractions: tuple[int, ...],
    area: bool,
    jobs: int | None,
    dask: str | None,
    screenshot: Path | None,
) -> None:
    try:
        page = write_report(output, scenes, Grid(fractions), size, area, jobs or -1, dask)
        if screenshot is not None:
            take_screenshot(page, screenshot)
    except (QuadshadeError, OSError) as error:
        click.echo(f"report: error: {error}", err=True)
        sys.exit(2)
    click.echo(f"{page}: open it in a browser")


if __name__ == "__main__":
    main()
