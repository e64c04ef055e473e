#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""
The pictures of Abbas et al., figure 3: spheres of 168, 374 and 690 triangles, exponents 5 and 50.

Gouraud, quadratic and Phong shading side by side, the quadratic one through the six points of the paper and
as the best one over the whole picture (``--fit least-squares``). Both quadratic pictures go through the VHDL
in GHDL, and every pixel and the number of clocks are compared with the golden model's. Gouraud shading is the
golden model's linear order, Phong shading float. Exit code 1 if anything differs.
"""

from __future__ import annotations

import shutil
import sys
from dataclasses import dataclass
from pathlib import Path

import click
import numpy as np
from joblib import Parallel, cpu_count, delayed
from PIL import Image, ImageDraw, ImageFont
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.progress import MofNCompleteColumn, Progress, TimeElapsedColumn
from rich.table import Table

from quadshade.contract.formats import Formats
from quadshade.contract.triangles import Drawing
from quadshade.engine import draw
from quadshade.files.atomic import write_json
from quadshade.fit import fit_colours
from quadshade.image import paint, visible, write_png
from quadshade.image.compare import psnr
from quadshade.scene import load_scene, parse_camera, project
from quadshade.shading import DEFAULT_LIGHTS, Material, sample
from quadshade.shading.reference import phong
from scripts.one_line_errors import one_line_errors

SPHERES = (168, 374, 690)
EXPONENTS = (5, 50)
SHADINGS = ("Gouraud", "six points", "least squares", "Phong")
FITS = ("six-point", "least-squares")
"""What the VHDL draws: the quadratics of the second and third picture."""

# Light and viewer infinitely far away: only the normal varies over a triangle (Abbas et al., section 2).
CAMERA = "from=0,0,1,ortho=1.05"
MODEL = "blinn"
BACKGROUND = (0, 0, 0)

DOCS = Path(__file__).resolve().parents[1] / "docs"

CAPTION_HEIGHT = 28
SHEET_SIZE = 256


@dataclass(frozen=True)
class Result:
    """
    One sphere at one exponent.

    Attributes
    ----------
    triangles, exponent, pixels : int
      Of the mesh; of the material; as emitted, the same for both fits.
    clocks : tuple of int
      As counted by the simulation, a fit each.
    pictures : tuple of (size, size, 3) uint8
      In the order of ``SHADINGS``.
    difference : str
      Where the VHDL differs from the golden model; empty if nowhere.
    """

    triangles: int
    exponent: int
    pixels: int
    clocks: tuple[int, ...]
    pictures: tuple[np.ndarray, ...]
    difference: str

    @property
    def quality(self) -> tuple[float, ...]:
        """Each picture but the last against that one, Phong shading, in dB, over the whole picture."""
        return tuple(psnr(picture, self.pictures[-1]) for picture in self.pictures[:-1])


def first_difference(got: Drawing, expected: Drawing) -> str:
    """
    What differs first between two drawings: counts, then pixels in the order in which they were emitted.

    Parameters
    ----------
    got, expected : Drawing

    Returns
    -------
    str
      Empty for identical drawings.
    """
    for name in ("pixels", "clocks"):
        if got.stats[name] != expected.stats[name]:
            return f"{name}: got {got.stats[name]}, expected {expected.stats[name]}"
    for name in ("triangle", "x", "y", "value", "depth"):
        one, other = getattr(got.pixels, name), getattr(expected.pixels, name)
        wrong = np.flatnonzero((one != other).reshape(len(one), -1).any(axis=1))
        if len(wrong):
            at = wrong[0]
            return f"{len(wrong)} pixels: first {name} of pixel {at}: got {one[at]}, expected {other[at]}"
    return ""


def shade(triangles: int, exponent: int, size: int, engine: str = "ghdl") -> Result:
    """
    Draw one sphere in all shadings.

    Parameters
    ----------
    triangles, exponent, size : int
      Of the mesh; of the specular term; pixels along a side.
    engine : str
      What draws the quadratic pictures, to be compared with the golden model.

    Returns
    -------
    Result
    """
    formats = Formats()
    mesh = load_scene(f"sphere:{triangles}")
    projected = project(mesh, parse_camera(CAMERA, mesh), size, size, formats)
    material = Material(exponent=float(exponent), model=MODEL)

    sampled = sample(projected, "quadratic", DEFAULT_LIGHTS, material, formats)
    drawn, clocks, difference = [], [], ""
    for fit in FITS:
        fitted = fit_colours(projected, sampled, fit, DEFAULT_LIGHTS, material, formats)
        got = draw(fitted, formats, engine)
        wrong = first_difference(got, draw(fitted, formats, "model"))
        difference = difference or (wrong and f"{fit}: {wrong}")
        drawn.append(got.pixels)
        clocks.append(got.stats["clocks"])
    pixels = drawn[0]
    reference = phong(projected, pixels.triangle, pixels.x, pixels.y, DEFAULT_LIGHTS, material, formats)
    gouraud = draw(sample(projected, "gouraud", DEFAULT_LIGHTS, material, formats), formats, "model").pixels
    pictures = (
        *(paint(visible(one, size, size), one.value, BACKGROUND) for one in (gouraud, *drawn)),
        paint(visible(pixels, size, size), reference, BACKGROUND),
    )
    return Result(len(mesh), exponent, len(pixels), tuple(clocks), pictures, difference)


def captioned(picture: np.ndarray, caption: str) -> np.ndarray:
    """A picture with a line of text above it."""
    canvas = Image.new("RGB", (picture.shape[1], picture.shape[0] + CAPTION_HEIGHT), (255, 255, 255))
    canvas.paste(Image.fromarray(picture), (0, CAPTION_HEIGHT))
    font = ImageFont.load_default(CAPTION_HEIGHT // 2)
    ImageDraw.Draw(canvas).text((6, CAPTION_HEIGHT // 4), caption, fill=(0, 0, 0), font=font)
    return np.asarray(canvas)


def side_by_side(result: Result, size: int) -> np.ndarray:
    """The pictures of a result at a size, each under its name and PSNR."""
    quality = (*(f"{value:.1f} dB" for value in result.quality), "reference")
    captions = [f"{name}, {text}" for name, text in zip(SHADINGS, quality, strict=True)]
    captions[0] = f"{result.triangles} triangles, n = {result.exponent}: {captions[0]}"
    scaled = [np.asarray(Image.fromarray(picture).resize((size, size))) for picture in result.pictures]
    return np.hstack([captioned(*pair) for pair in zip(scaled, captions, strict=True)])


def write_pictures(results: list[Result], output: Path) -> None:
    """A PNG for each result, and ``overview.png`` with all of them: a row a sphere."""
    output.mkdir(parents=True, exist_ok=True)
    for result in results:
        size = len(result.pictures[0])
        name = f"sphere_{result.triangles}_n{result.exponent}.png"
        write_png(output / name, side_by_side(result, size))
    rows = [[r for r in results if r.triangles == triangles] for triangles in SPHERES]
    sheet = np.vstack([np.hstack([side_by_side(r, SHEET_SIZE) for r in row]) for row in rows])
    write_png(output / "overview.png", sheet)


def report(results: list[Result], size: int) -> dict:
    """What was measured, for JSON."""
    rows = [
        {"triangles": r.triangles, "exponent": r.exponent, "pixels": r.pixels}
        | {"clocks": dict(zip(FITS, r.clocks, strict=True))}
        | {"psnr": dict(zip(SHADINGS, r.quality, strict=False))}
        for r in results
    ]
    return {"size": size, "rows": rows}


def table(results: list[Result]) -> Table:
    """What was measured, a row a picture."""
    out = Table(
        title="PSNR in dB against Phong; equal: VHDL and model, every pixel and the clocks",
        box=SIMPLE_HEAD,
        pad_edge=False,
        padding=(0, 1, 0, 0),
    )
    for heading in ("triangles", "exponent", "pixels", "clocks", *SHADINGS[:-1], "equal"):
        out.add_column(heading, justify="right")
    for r in results:
        out.add_row(
            f"{r.triangles}",
            f"{r.exponent}",
            f"{r.pixels}",
            " or ".join(f"{clocks}" for clocks in sorted(set(r.clocks))),
            *(f"{value:.1f}" for value in r.quality),
            "no" if r.difference else "yes",
        )
    return out


def draw_all(size: int, jobs: int, console: Console) -> list[Result]:
    """All pictures, ``jobs`` at a time, with a progress bar; in the order of the table."""
    cases = [(triangles, exponent) for triangles in SPHERES for exponent in EXPONENTS]
    columns = (*Progress.get_default_columns()[:2], MofNCompleteColumn(), TimeElapsedColumn())
    results = []
    with Progress(*columns, console=console) as progress:
        bar = progress.add_task("simulating the VHDL", total=len(cases))
        parallel = Parallel(n_jobs=jobs, return_as="generator_unordered")
        for result in parallel(delayed(shade)(*case, size) for case in cases):
            results.append(result)
            progress.advance(bar)
    return sorted(results, key=lambda r: (r.triangles, r.exponent))


@click.command(help=__doc__)
@click.option("--size", type=click.IntRange(16, 4096), default=512, show_default=True, help="Pixels a side.")
@click.option("--jobs", type=click.IntRange(1), default=cpu_count(), help="Simulations at a time.")
@click.option(
    "--output", type=click.Path(path_type=Path), default=Path("build/demo"), show_default=True, help="Folder."
)
@click.option("--publish", is_flag=True, help="Write the README's picture and numbers to docs/ as well.")
@one_line_errors("demo")
def main(size: int, jobs: int, output: Path, publish: bool) -> None:
    console = Console()
    results = draw_all(size, jobs, console)
    write_pictures(results, output)
    console.print(table(results))
    different = [r for r in results if r.difference]
    for r in different:
        click.echo(f"sphere:{r.triangles}, exponent {r.exponent}: {r.difference}", err=True)
    if different:
        sys.exit(1)
    pixels = len(FITS) * sum(r.pixels for r in results)
    said = f"{pixels} pixels, their order and the clocks are the golden model's; pictures in {output}/"
    console.print(said, soft_wrap=True)
    if publish:
        for folder in ("images", "reports"):
            (DOCS / folder).mkdir(parents=True, exist_ok=True)
        shutil.copyfile(output / "overview.png", DOCS / "images" / "spheres.png")
        write_json(DOCS / "reports" / "demo.json", report(results, size))


if __name__ == "__main__":
    main()
