# SPDX-License-Identifier: Apache-2.0
"""
Every fit beside six points: PSNR and largest error against Phong, the jump across edges, and its time.

Fixed point, 8 bits, drawn by the golden model; writes ``docs/reports/fits.md``.
"""

from __future__ import annotations

import time
from pathlib import Path

import click
import numpy as np

from quadshade.choices import FITS
from quadshade.contract.formats import Formats
from quadshade.contract.triangles import ScreenTriangles
from quadshade.engine import draw
from quadshade.files.markdown import markdown_table
from quadshade.fit import PLACES, fit_colours
from quadshade.scene import load_scene, parse_camera, project
from quadshade.setup.triangle_setup import setup_triangles
from quadshade.shading import Material, sample
from quadshade.shading.reference import phong, polynomial
from scripts.experiments.continuity.mach_bands import jumps
from scripts.experiments.report_writer import (
    LICENCE,
    REPORTS,
    command_line,
    output_option,
    paragraph,
    write_report,
)
from scripts.one_line_errors import one_line_errors

REPORT = REPORTS / "fits.md"
SCENES = {
    "sphere:168": "from=0,0,1,ortho=1.05",
    "sphere:374": "from=0,0,1,ortho=1.05",
    "sphere:690": "from=0,0,1,ortho=1.05",
    "torus:288": "from=0,0,1",
}
EXPONENTS = (5.0, 50.0)
SMOOTHNESSES = (3.0, 30.0, 300.0)
LARGE = "sphere:317x317"
REPEATS = 3


def measured(projected, triangles: ScreenTriangles, material: Material) -> dict[str, float]:
    """Errors of what the golden model draws, in grey levels, and the jump of the derivative."""
    pixels = draw(triangles, Formats(), "model").pixels
    exact = np.rint(phong(projected, pixels.triangle, pixels.x, pixels.y, material=material))
    error = pixels.value - exact

    def shade(owner: np.ndarray, weights: np.ndarray) -> np.ndarray:
        return polynomial(triangles.samples[owner, :1], triangles.orders[owner, :1], weights)[:, 0]

    return {
        "psnr": round(float(10 * np.log10(255**2 / (error**2).mean())), 2),
        "largest": float(np.abs(error).max()),
        "jump": round(jumps(projected, shade)["rms"], 4),
    }


def accuracy(size: int) -> list[dict]:
    """A row a scene, exponent and fit."""
    rows = []
    for scene, camera in SCENES.items():
        mesh = load_scene(scene)
        projected = project(mesh, parse_camera(camera, mesh), size, size)
        for exponent in EXPONENTS:
            material = Material(exponent=exponent)
            six = sample(projected, material=material)
            ways = [(fit, {"places": "pixels"}) for fit in FITS if fit != "smooth"]
            ways.insert(2, ("least-squares", {"places": "points"}))
            ways += [("smooth", {"smoothness": weight}) for weight in SMOOTHNESSES]
            for fit, settings in ways:
                fitted = fit_colours(projected, six, fit, material=material, **settings)
                name = fit if fit == FITS[0] else f"{fit}, {' '.join(map(str, settings.values()))}"
                rows.append({"scene": scene, "exponent": exponent, "fit": name})
                rows[-1] |= measured(projected, fitted, material)
    return rows


def host_time(scene: str) -> list[dict]:
    """Processor time of each fit as a ratio to sampling and setting up six points, least of some runs."""
    mesh = load_scene(scene)
    projected = project(mesh, parse_camera("from=0,0,1", mesh), 1024, 1024)
    material, formats = Material(exponent=50.0), Formats()
    six = sample(projected, material=material)

    def path() -> None:
        setup_triangles(sample(projected, material=material), formats)

    jobs = {"six points, sampled and set up": path}
    for places in PLACES:
        jobs[f"least-squares, {places}"] = lambda places=places: fit_colours(
            projected, six, "least-squares", material=material, places=places
        )
    times: dict[str, float] = {}
    for _ in range(REPEATS + 1):
        for name, job in jobs.items():
            start = time.process_time()
            job()
            times[name] = min(times.get(name, np.inf), time.process_time() - start)
    first = next(iter(times.values()))
    return [
        {"what": name, "triangles": len(projected), "ratio": round(spent / first, 2)}
        for name, spent in times.items()
    ]


def report(results: dict) -> str:
    """The report's text, from nothing but the numbers."""
    cells = [
        (
            row["scene"],
            f"{row['exponent']:g}",
            row["fit"],
            f"{row['psnr']:.1f}",
            f"{row['largest']:g}",
            f"{row['jump']:.3f}",
        )
        for row in results["rows"]
    ]
    header = ("scene", "exponent", "fit", "PSNR, dB", "largest error", "RMS jump")
    about = f"""
    Written by `{results["command"]}` (`make fits`): {results["size"]}x{results["size"]} pixels, 8 bits,
    default lights, quadratic colours, drawn by the golden model; errors in grey levels against rounded Phong
    shading of the same mesh, over every pixel drawn. The words, bytes and clocks of a triangle are those of
    six points. *Jump* is that of the colour's derivative across shared edges, in grey levels per pixel, in
    float. Places and weights stand behind the fit's name; [fit](../explanation/fit.md) explains them.
    """
    speed = """
    Processor time of a fit, as a ratio to sampling six points and setting the triangles up, both in one run,
    the least of three.
    """
    ratios = [(row["what"], row["triangles"], f"{row['ratio']:.2f}") for row in results["times"]]
    return "\n\n".join(
        [
            f"{LICENCE}\n# Fits",
            paragraph(about),
            markdown_table(header, cells),
            "## Time",
            paragraph(speed),
            markdown_table(("what", "triangles", "ratio"), ratios) + "\n",
        ]
    )


@click.command(help=__doc__)
@click.option("--size", default=512, show_default=True, help="Pixels a side.")
@click.option("--large", default=LARGE, show_default=True, help="Scene that times are taken of.")
@output_option(REPORT)
@one_line_errors(REPORT.stem)
def main(size: int, large: str, output: Path) -> None:
    command = command_line("fits", size=size, large=large)
    results = {"command": command, "size": size, "rows": accuracy(size), "times": host_time(large)}
    write_report(output, report(results))
    click.echo(f"{output}: {len(results['rows'])} rows")


if __name__ == "__main__":
    main()
