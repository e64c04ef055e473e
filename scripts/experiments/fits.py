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

from quadshade.choices import JUMP, SPECULAR_FITS
from quadshade.contract.formats import Formats
from quadshade.engine import draw
from quadshade.files.markdown import markdown_table
from quadshade.fit import PLACES, Fitted, fit_colours, fit_scene
from quadshade.scene import Projected, load_scene, parse_camera, project
from quadshade.setup.packet import pack
from quadshade.setup.triangle_setup import setup_triangles
from quadshade.shading import Material, default_lights, sample, sample_specular, specular_formats
from quadshade.shading.reference import phong, phong_at, polynomial
from scripts.examples import scene_path
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
    "pawn.obj": "",
    "part.stl": "",
    "knot.glb": "",
}
"""Cameras; what has an ending is in ``examples``."""
EXPONENTS = (5.0, 50.0)
SMOOTHNESSES = (30.0, 300.0, 3e3, 3e4, 3e5, 1e6, 1e9)
JUMPS = (0.0, JUMP, 0.3)
LARGE = "sphere:317x317"
REPEATS = 3


def ways() -> list[tuple[str, dict]]:
    """Fits of colours, with their settings."""
    return [
        ("six-point", {}),
        ("least-squares", {"places": "pixels"}),
        ("least-squares", {"places": "points"}),
        ("minimax", {"places": "pixels"}),
        *(("smooth", {"smoothness": weight}) for weight in SMOOTHNESSES),
        *(("c1", {"jump": jump}) for jump in JUMPS),
    ]


def measured(projected: Projected, fitted: Fitted, material: Material, formats: Formats) -> dict[str, float]:
    """Errors of what the golden model draws, in grey levels, and its words."""
    drawing = draw(fitted.triangles, formats, "model")
    pixels = drawing.pixels
    exact = np.rint(phong(projected, fitted.parent[pixels.triangle], pixels.x, pixels.y, material=material))
    error = pixels.value - exact
    return {
        "psnr": round(float(10 * np.log10(255**2 / (error**2).mean())), 2),
        "largest": float(np.abs(error).max()),
        "triangles": len(fitted.triangles),
        "words": drawing.stats["words"],
    }


def colour_jump(fitted: Fitted) -> float:
    """Root mean square jump of the derivative of red."""
    triangles = fitted.triangles

    def shade(owner: np.ndarray, weights: np.ndarray) -> np.ndarray:
        return polynomial(triangles.samples[owner, :1], triangles.orders[owner, :1], weights)[:, 0]

    return round(jumps(fitted.projected, shade)["rms"], 4)


def phong_jump(projected: Projected, material: Material) -> float:
    """The same of Phong shading itself."""
    lights, formats = default_lights(projected.axes), Formats()

    def shade(owner: np.ndarray, weights: np.ndarray) -> np.ndarray:
        return phong_at(projected, owner, weights, lights, material, formats)[:, 0]

    return round(jumps(projected, shade)["rms"], 4)


def accuracy(size: int) -> tuple[list[dict], list[dict]]:
    """A row a scene, exponent and fit: of colours, and of cosines."""
    rows, cosines = [], []
    for scene, camera in SCENES.items():
        mesh = load_scene(scene_path(scene))
        projected = project(mesh, parse_camera(camera, mesh), size, size)
        for exponent in EXPONENTS:
            material, about = Material(exponent=exponent), {"scene": scene, "exponent": exponent}
            six = sample(projected, material=material)
            for fit, settings in ways():
                fitted = fit_scene(projected, six, fit, material=material, **settings)
                shown = (value if isinstance(value, str) else f"{value:g}" for value in settings.values())
                name = ", ".join([fit, *shown])
                rows.append(about | {"fit": name, "jump": colour_jump(fitted)})
                rows[-1] |= measured(projected, fitted, material, Formats())
            rows.append(about | {"fit": "Phong shading", "jump": phong_jump(projected, material)})
            if mesh.colours is not None:
                continue
            formats = specular_formats({}, projected, None, material)
            six = sample_specular(projected, material=material, formats=formats)
            for fit in SPECULAR_FITS:
                fitted = fit_scene(projected, six, fit, material=material, formats=formats)
                cosines.append(about | {"fit": fit} | measured(projected, fitted, material, formats))
    return rows, cosines


def host_time(scene: str) -> list[dict]:
    """Processor time of each fit as a ratio to sampling and setting up six points, least of some runs."""
    mesh = load_scene(scene)
    camera, formats = parse_camera("from=0,0,1", mesh), Formats()
    projected = project(mesh, camera, 1024, 1024, formats)
    material = Material(exponent=50.0)
    six = sample(projected, material=material)

    def shade_and_set_up() -> None:
        setup_triangles(sample(projected, material=material), formats)

    def whole() -> None:
        seen = project(mesh, camera, 1024, 1024, formats)
        pack(setup_triangles(sample(seen, material=material), formats), formats)

    jobs = {"six points, sampled and set up": shade_and_set_up, "six points, from mesh to words": whole}
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
            f"{row['psnr']:.1f}" if "psnr" in row else "",
            f"{row['largest']:g}" if "psnr" in row else "",
            f"{row['jump']:.3f}",
            row.get("triangles", ""),
            row.get("words", ""),
        )
        for row in results["rows"]
    ]
    header = ("scene", "exponent", "fit", "PSNR, dB", "largest error", "RMS jump", "triangles", "words")
    powers = [
        (row["scene"], f"{row['exponent']:g}", row["fit"], f"{row['psnr']:.1f}", f"{row['largest']:g}")
        for row in results["cosines"]
    ]
    about = f"""
    Written by `{results["command"]}` (`make fits`): {results["size"]}x{results["size"]} pixels, 8 bits,
    default lights, quadratic colours, drawn by the golden model; errors in grey levels against rounded Phong
    shading of the same mesh, over every pixel drawn. *Jump* is that of red's derivative across shared
    edges, in grey levels per pixel, in float, of edges whose normals lie within 60 degrees of the viewer;
    *triangles* and *words* are those that are sent. Behind a fit's name stand where its error is taken, its
    smoothness (pixels) or its jump (grey levels per pixel); [fit](../explanation/fit.md) explains them. The
    largest smoothness is the bound: hardly a jump is left, and what remains of the picture is nearly one
    quadratic; where that leaves the range it is cut, and jumps there. Edges between triangles of less than
    four pixels count here, though `c1` leaves them as they are unless its jump is 0: in `pawn.obj` such edges
    make up most of what is left.
    """
    power = """
    The same with `--shading quadratic-specular`: cosines are interpolated, the power is taken at the pixel.
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
            "## The power at the pixel",
            paragraph(power),
            markdown_table(header[:5], powers),
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
    rows, cosines = accuracy(size)
    results = {"command": command, "size": size, "rows": rows, "cosines": cosines, "times": host_time(large)}
    write_report(output, report(results))
    click.echo(f"{output}: {len(results['rows'])} rows")


if __name__ == "__main__":
    main()
