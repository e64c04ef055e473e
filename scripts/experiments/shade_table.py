# SPDX-License-Identifier: Apache-2.0
"""
PSNR of every shading against Phong's on the spheres; writes ``docs/reports/shade.*`` and the page's table.

The golden model draws; the tests hold the engines to it bit for bit.
"""

from __future__ import annotations

from pathlib import Path

import click

from quadshade.contract.formats import Formats
from quadshade.engine import draw
from quadshade.files.atomic import write_text
from quadshade.files.markdown import markdown_table
from quadshade.image import paint, visible
from quadshade.image.compare import psnr
from quadshade.scene import load_scene, parse_camera, project
from quadshade.shading import Material, sample, sample_specular, specular_formats
from quadshade.shading.reference import phong
from scripts.experiments.report_writer import LICENCE, REPORTS, ROOT, output_option, write_report
from scripts.one_line_errors import one_line_errors
from scripts.readme import replace_block

REPORT = REPORTS / "shade.md"
PAGE = ROOT / "docs" / "explanation" / "shade.md"
CAMERAS = {"perspective": "from=0,0,1", "orthographic": "from=0,0,1,ortho=1.05"}
TRIANGLES = (168, 374, 690)
EXPONENTS = (5, 50, 200, 1000)
COLUMNS = {
    "gouraud": "Gouraud",
    "quadratic": "quadratic",
    "linear-specular": "linear-specular",
    "quadratic-specular": "**quadratic-specular**",
    "guard 8": "with 8 guard bits",
}


def measure(camera: str, triangles: int, exponent: int, size: int) -> dict[str, float]:
    """dB of every shading against Phong's picture."""
    mesh = load_scene(f"sphere:{triangles}")
    projected = project(mesh, parse_camera(CAMERAS[camera], mesh), size, size)
    material = Material(exponent=exponent)
    specular = specular_formats({}, projected, None, material)
    coarse = specular_formats({"shade_guard_bits": 8}, projected, None, material)
    drawings = {
        name: (sample(projected, name, material=material), Formats()) for name in ("gouraud", "quadratic")
    }
    for name in ("linear-specular", "quadratic-specular"):
        drawings[name] = sample_specular(projected, name, None, material, specular), specular
    drawings["guard 8"] = sample_specular(projected, "quadratic-specular", None, material, coarse), coarse
    black, row, reference = (0, 0, 0), {}, None
    for name, (screen, formats) in drawings.items():
        pixels = draw(screen, formats).pixels
        shown = visible(pixels, size, size)
        if reference is None:
            reference = paint(
                shown, phong(projected, pixels.triangle, pixels.x, pixels.y, None, material), black
            )
        row[name] = round(float(psnr(paint(shown, pixels.value, black), reference)), 2)
    return row


def table(rows: list[dict]) -> str:
    """The report's table, which stands in the page on the shade unit as well."""
    header = ("camera", "triangles", "exponent", *COLUMNS.values())
    cells = [
        (row["camera"], row["triangles"], row["exponent"], *(f"{row[name]:.1f}" for name in COLUMNS))
        for row in rows
    ]
    return markdown_table(header, cells)


def report(results: dict) -> str:
    """The report's text, from nothing but the numbers of the JSON file."""
    title = f"{LICENCE}\n# Spheres against Phong shading\n\n"
    about = f"PSNR in dB, {results['size']}x{results['size']}, 8 bits, default lights; `make shade-table`"
    about += " ([about](../explanation/shade.md)).\n\n"
    return f"{title}{about}{table(results['rows'])}\n"


@click.command(help=__doc__)
@click.option("--size", default=512, show_default=True, help="Pixels a side.")
@output_option(REPORT)
@one_line_errors(REPORT.stem)
def main(size: int, output: Path) -> None:
    rows = [
        {"camera": camera, "triangles": triangles, "exponent": exponent}
        | measure(camera, triangles, exponent, size)
        for camera in CAMERAS
        for triangles in TRIANGLES
        for exponent in EXPONENTS
    ]
    results = {"size": size, "rows": rows}
    write_report(output, report(results), results)
    if output == REPORT:
        write_text(PAGE, replace_block(PAGE.read_text(), "shade", table(rows), PAGE.name))
    click.echo(table(rows))


if __name__ == "__main__":
    main()
