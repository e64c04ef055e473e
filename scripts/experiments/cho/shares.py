# SPDX-License-Identifier: Apache-2.0
"""Why Cho's tables have other shares of triangles than ours: what the paper does not give, varied."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from quadshade.adapt import highlight_subdivision, regular_subdivision
from quadshade.files.markdown import markdown_table
from quadshade.scene import fit_camera, project
from quadshade.scene.mesh import Mesh
from quadshade.shading.lights import Light
from quadshade.shading.material import Material
from scripts.experiments.report_writer import paragraph

SIZES = (256, 512)
WIDTHS = (1.0, 0.9, 0.8, 0.75, 0.7)
MATERIALS = ((0.6, 0.35), (0.4, 0.5), (0.2, 0.7))
EXPONENTS = (20.0, 50.0, 100.0)


def measured_shares(
    mesh: Mesh, lights: Sequence[Light], directions: np.ndarray, exponent: float
) -> dict[str, list[dict]]:
    """
    Final triangles over those of the mesh, means over views.

    Parameters
    ----------
    mesh : Mesh
    lights : sequence of lights
    directions : (views, 3) float
    exponent : float
      Of the tables.

    Returns
    -------
    dict
      ``widths``: rows of regular subdivision on smaller pictures of the mesh; ``materials``: rows of
      highlight subdivision with other materials.
    """

    def views(size: int) -> list:
        return [project(mesh, fit_camera(mesh, direction=one), size, size) for one in directions]

    def final(parts: list, wholes: list) -> float:
        return 1 + float(
            np.mean([len(a.projected) - len(b) for a, b in zip(parts, wholes, strict=True)])
        ) / len(mesh)

    widths = []
    for width in WIDTHS:
        row = {"width": width}
        for size in SIZES:
            wholes = views(round(size * width))
            row[f"final_{size}"] = final([regular_subdivision(whole, lights) for whole in wholes], wholes)
        widths.append(row)
    wholes, materials = views(SIZES[0]), []
    for diffuse, specular in MATERIALS:
        for own in sorted({*EXPONENTS, exponent}):
            material = Material(exponent=own, diffuse=(diffuse,) * 3, specular=(specular,) * 3)
            parts = [highlight_subdivision(whole, lights, material) for whole in wholes]
            row = {"diffuse": diffuse, "specular": specular, "exponent": own}
            materials.append(row | {"final": final(parts, wholes)})
    return {"widths": widths, "materials": materials}


def shares_text(shares: dict[str, list[dict]], paper: list[dict]) -> list[str]:
    """A section of the report: tables, and what follows from them."""
    lines = ["## Why the shares differ", ""]
    theirs = {(row["size"], row["scheme"]): row["paper_final"] for row in paper}
    lines.append(
        paragraph(
            "The paper gives neither how large its teapot is in the picture nor its material or exponent. "
            "Regular subdivision depends on the first, highlight subdivision on the others. With the mesh "
            "so much narrower in the picture (means over a third of the views):"
        )
    )
    widths = [
        (f"{row['width']:g}", f"{row['final_256']:.2f}", f"{row['final_512']:.2f}")
        for row in shares["widths"]
    ]
    if paper:
        found = (theirs.get((size, "Regular subdivision")) for size in SIZES)
        widths.append(("paper", *("–" if share is None else f"{share:.2f}" for share in found)))
    header = ("width", "regular subdivision, final ÷ mesh, 256²", "512²")
    lines += ["", markdown_table(header, widths)]
    lines += ["", "With other materials (256²; the tables above have the first):", ""]
    materials = [
        (*(f"{row[name]:g}" for name in ("diffuse", "specular", "exponent")), f"{row['final']:.2f}")
        for row in shares["materials"]
    ]
    header = ("diffuse", "specular", "exponent", "highlight subdivision, final ÷ mesh")
    return [*lines, markdown_table(header, materials)]
