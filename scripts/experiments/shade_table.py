# SPDX-License-Identifier: Apache-2.0
"""
PSNR of every shading against Phong's on the spheres; writes ``docs/reports/shade.*`` and the page's table.

The golden model draws; the tests hold the engines to it bit for bit.
"""

from __future__ import annotations

import json
from pathlib import Path

from quadshade.contract.formats import Formats
from quadshade.engine import draw
from quadshade.image import paint, visible
from quadshade.image.compare import psnr
from quadshade.scene import load_scene, parse_camera, project
from quadshade.shading import Material, sample, sample_specular, specular_formats
from quadshade.shading.reference import phong
from scripts.readme import markdown, replace_block

ROOT = Path(__file__).resolve().parents[2]
SIZE = 512
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


def measure(camera: str, triangles: int, exponent: int) -> dict[str, float]:
    """dB of every shading against Phong's picture."""
    mesh = load_scene(f"sphere:{triangles}")
    projected = project(mesh, parse_camera(CAMERAS[camera], mesh), SIZE, SIZE)
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
        shown = visible(pixels, SIZE, SIZE)
        if reference is None:
            reference = paint(
                shown, phong(projected, pixels.triangle, pixels.x, pixels.y, None, material), black
            )
        row[name] = round(float(psnr(paint(shown, pixels.value, black), reference)), 2)
    return row


def main() -> None:
    """Measure, write the report and the page's table."""
    rows = [
        {"camera": camera, "triangles": triangles, "exponent": exponent}
        | measure(camera, triangles, exponent)
        for camera in CAMERAS
        for triangles in TRIANGLES
        for exponent in EXPONENTS
    ]
    header = ("camera", "triangles", "exponent", *COLUMNS.values())
    table = markdown(
        header,
        [
            (
                row["camera"],
                str(row["triangles"]),
                str(row["exponent"]),
                *(f"{row[name]:.1f}" for name in COLUMNS),
            )
            for row in rows
        ],
    )
    reports = ROOT / "docs" / "reports"
    (reports / "shade.json").write_text(json.dumps({"size": SIZE, "rows": rows}, indent=1) + "\n")
    title = "<!-- SPDX-License-Identifier: Apache-2.0 -->\n# Spheres against Phong shading\n\n"
    about = f"PSNR in dB, {SIZE}x{SIZE}, 8 bits, default lights; `make shade-table`"
    about += " ([about](../explanation/shade.md)).\n\n"
    (reports / "shade.md").write_text(f"{title}{about}{table}")
    page = ROOT / "docs" / "explanation" / "shade.md"
    page.write_text(replace_block(page.read_text(), "shade", table))
    print(table, end="")


if __name__ == "__main__":
    main()
