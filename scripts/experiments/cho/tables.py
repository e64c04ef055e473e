# SPDX-License-Identifier: Apache-2.0
"""
The tables of Cho, Neumann and Woo ("Improved Specular Highlights with Adaptive Shading"), measured again.

A teapot of 896 triangles from 60 sides, four point lights, 256 and 512 pixels: how many triangles each
scheme tests, divides and draws, how far its picture is from Phong's, and its time beside Gouraud's and
Phong's in one renderer that shades by either rule. Writes docs/reports/cho.md and cho.json.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import click
import numpy as np
from rich.progress import track

from quadshade.adapt import highlight_subdivision, potentially_highlighted, regular_subdivision
from quadshade.adapt.highlight import with_neighbours
from quadshade.contract.formats import Formats
from quadshade.files.markdown import markdown_table
from quadshade.scene import Projected, fit_camera, load_scene, project
from quadshade.scene.mesh import Mesh
from quadshade.shading.lights import AmbientLight, Light, PointLight
from quadshade.shading.material import Material
from quadshade.trade.page.papers import cho_tables
from scripts.experiments.cho.renderer import Picture, draw_software
from scripts.experiments.cho.shares import measured_shares, shares_text
from scripts.experiments.cho.teapot import teapot
from scripts.experiments.report_writer import (
    LICENCE,
    REPORTS,
    command_line,
    output_option,
    paragraph,
    write_report,
)
from scripts.one_line_errors import one_line_errors

REPORT = REPORTS / "cho.md"
SIZES = (256, 512)
FORMATS = Formats()
LIGHT_DISTANCE = 3.0
"""From the mesh's middle, over the radius of its bounding sphere."""
LIGHT_COLOUR = (0.5, 0.5, 0.5)
LIGHT_SIDES = np.array([[1, 1, 1], [-1, 1, -1], [1, 1, -1], [-1, 1, 1]]) / np.sqrt(3)
AREA = 32.0
"""Pixels, the paper's threshold of the regular subdivision."""
DIFFERENCE = 0.3
"""Relative to the true intensity, the paper's threshold of the highlight subdivision."""
COUNTS = ("front", "tested", "highlighted", "near", "subdivided", "parts", "per_pixel", "final")
STAGES = ("prepare", "draw")

Prepared = tuple[Projected, np.ndarray, np.ndarray | None, dict[str, int]]
"""Triangles to draw, the mesh's triangle of each, which of them by Phong's rule, and counts."""


def four_lights(mesh: Mesh) -> tuple[Light, ...]:
    """Ambient light and four points above the mesh, which stay where they are while the viewer goes round."""
    centre, radius = mesh.bounds
    places = centre + LIGHT_DISTANCE * radius * LIGHT_SIDES
    return AmbientLight(), *(PointLight(tuple(place.tolist()), LIGHT_COLOUR) for place in places)


def directions(views: int) -> np.ndarray:
    """(views, 3) directions from above the horizon, evenly: a spiral of golden angles."""
    index = np.arange(views) + 0.5
    up, turn = 1 - index / views, index * np.pi * (3 - np.sqrt(5))
    across = np.sqrt(1 - up**2)
    return np.stack([across * np.cos(turn), up, across * np.sin(turn)], axis=-1)


def _gouraud(projected: Projected, lights: tuple[Light, ...], material: Material) -> Prepared:
    return projected, np.arange(len(projected)), None, {}


def _phong(projected: Projected, lights: tuple[Light, ...], material: Material) -> Prepared:
    everywhere = np.ones(len(projected), dtype=bool)
    return projected, np.arange(len(projected)), everywhere, {"per_pixel": len(projected)}


def _highlighted_by_phong(projected: Projected, lights: tuple[Light, ...], material: Material) -> Prepared:
    highlighted = potentially_highlighted(projected, lights).any(axis=0)
    near = with_neighbours(projected.vertices, highlighted)
    counts = {"highlighted": highlighted.sum(), "near": near.sum(), "per_pixel": near.sum()}
    return projected, np.arange(len(projected)), near, {"tested": len(projected), **counts}


def _divided(divide: Callable[..., object]) -> Callable[..., Prepared]:
    def prepare(projected: Projected, lights: tuple[Light, ...], material: Material) -> Prepared:
        made = divide(projected, lights, material)
        divided = made.subdivided.sum()
        counts = {
            "tested": len(projected),
            "highlighted": made.highlighted.sum(),
            "subdivided": divided,
            "parts": len(made.projected) - len(projected) + divided,
        }
        return made.projected, made.root, None, counts

    return prepare


SCHEMES: dict[str, Callable[..., Prepared]] = {
    "Gouraud": _gouraud,
    "Highlight subdivision": _divided(
        lambda projected, lights, material: highlight_subdivision(projected, lights, material, DIFFERENCE)
    ),
    "Regular subdivision": _divided(
        lambda projected, lights, material: regular_subdivision(projected, lights, AREA, FORMATS)
    ),
    "Gouraud + Phong": _highlighted_by_phong,
    "Phong": _phong,
}
"""By the names of the paper's tables."""


def one_view(
    projected: Projected, lights: tuple[Light, ...], material: Material, repeats: int
) -> tuple[dict[str, dict], dict[str, Picture]]:
    """
    All schemes of one view: counts and least seconds of each stage, and pictures with the mesh's triangles.

    The schemes take turns, so that what else the machine does slows all of them down.
    """
    rows = {name: dict.fromkeys(STAGES, np.inf) for name in SCHEMES}
    roots = {}
    pictures = {name: Picture.empty(projected.width, projected.height) for name in SCHEMES}
    for _ in range(repeats):
        for name, prepare in SCHEMES.items():
            start = time.process_time()
            surface, roots[name], per_pixel, counts = prepare(projected, lights, material)
            between = time.process_time()
            draw_software(surface, lights, material, per_pixel, FORMATS, pictures[name])
            spent = between - start, time.process_time() - between
            for stage, seconds in zip(STAGES, spent, strict=True):
                rows[name][stage] = min(rows[name][stage], seconds)
            rows[name] |= {key: 0 for key in COUNTS} | {"front": len(projected), "final": len(surface)}
            rows[name] |= {key: int(value) for key, value in counts.items()}
    near = rows["Gouraud + Phong"]["near"]
    for name in ("Highlight subdivision", "Regular subdivision"):
        rows[name]["near"] = near
    for name, picture in pictures.items():
        picture.triangle[:] = np.where(picture.triangle < 0, -1, roots[name][picture.triangle])
    return rows, pictures


def squares(picture: Picture, phong: Picture) -> tuple[np.ndarray, np.ndarray]:
    """Squared differences (pixels, 3) over pixels of the same and of another triangle of the mesh."""
    both = (picture.triangle >= 0) & (phong.triangle >= 0)
    same = picture.triangle == phong.triangle
    error = (picture.value - phong.value) ** 2
    return error[both & same], error[both & ~same]


def measure(mesh: Mesh, size: int, views: int, repeats: int, material: Material) -> dict:
    """
    Means over the views at one size.

    Parameters
    ----------
    mesh : Mesh
    size, views, repeats : int
    material : Material

    Returns
    -------
    dict
      ``size``, ``pixels`` and ``schemes``: rows of counts, errors and times as ratios.
    """
    lights = four_lights(mesh)
    kept = (*COUNTS, *STAGES, "square", "values", "largest", "others", "largest_other")
    sums = {name: dict.fromkeys(kept, 0.0) for name in SCHEMES}
    transform = 0.0
    for direction in track(directions(views), f"{size} pixels", transient=True):
        camera = fit_camera(mesh, direction=direction)
        seconds = np.inf
        for _ in range(repeats):
            start = time.process_time()
            projected = project(mesh, camera, size, size, FORMATS)
            seconds = min(seconds, time.process_time() - start)
        transform += seconds
        rows, pictures = one_view(projected, lights, material, repeats)
        for name, total in sums.items():
            for key in (*COUNTS, *STAGES):
                total[key] += rows[name][key]
            error, other = squares(pictures[name], pictures["Phong"])
            total["square"] += error.sum() + other.sum()
            total["values"] += error.size + other.size
            total["others"] += len(other)
            for key, part in (("largest", error), ("largest_other", other)):
                total[key] = max(total[key], float(np.sqrt(part.max(initial=0))))
    times = {name: transform + total["prepare"] + total["draw"] for name, total in sums.items()}
    return {
        "size": size,
        "pixels": sums["Phong"]["values"] / 3 / views,
        "schemes": [_row(name, sums, times, views, len(mesh)) for name in SCHEMES],
    }


def _row(
    name: str, sums: dict[str, dict[str, float]], times: dict[str, float], views: int, faces: int
) -> dict:
    """One scheme: counts a view, errors, times beside Gouraud's and Phong's."""
    total, gouraud, phong = sums[name], sums["Gouraud"], sums["Phong"]
    rms = float(np.sqrt(total["square"] / total["values"]))
    return {
        "scheme": name,
        **{key: total[key] / views for key in COUNTS},
        "final_with_culled": faces + (total["final"] - total["front"]) / views,
        "rms": rms,
        "psnr": float(20 * np.log10(255 / rms)) if rms else None,
        "largest": total["largest"],
        "others": total["others"] / views,
        "largest_other": total["largest_other"],
        "time_over_gouraud": times[name] / times["Gouraud"],
        "time_over_phong": times[name] / times["Phong"],
        "draw_over_gouraud": total["draw"] / gouraud["draw"],
        "draw_over_phong": total["draw"] / phong["draw"],
    }


def beside_paper(measured: list[dict], faces: int) -> list[dict]:
    """The paper's two tables and ours as ratios: triangles to the mesh's, times to Gouraud's and Phong's."""
    tables = cho_tables()
    times = {row["method"]: row for row in tables["table_1"]}
    counts = {row["method"]: row for row in tables["table_2"]}
    rows = []
    for part in measured:
        size = part["size"]
        if size not in SIZES:
            continue
        for ours in part["schemes"]:
            name, column = ours["scheme"], f"software_{size}_ms"
            count = counts.get(name, {})
            final, divided = count.get(f"final_{size}"), count.get(f"subdivided_{size}")
            original = counts["Gouraud"][f"final_{size}"]
            rows.append(
                {
                    "size": size,
                    "scheme": name,
                    "paper_final": final and final / original,
                    "our_final": ours["final_with_culled"] / faces,
                    "paper_subdivided": divided and divided / original,
                    "our_subdivided": ours["subdivided"] / faces,
                    "paper_over_gouraud": times[name][column] / times["Gouraud"][column],
                    "our_over_gouraud": ours["time_over_gouraud"],
                    "our_draw_over_gouraud": ours["draw_over_gouraud"],
                    "paper_over_phong": times[name][column] / times["Phong"][column],
                    "our_over_phong": ours["time_over_phong"],
                    "our_draw_over_phong": ours["draw_over_phong"],
                }
            )
    return rows


def _number(value: float | None, digits: int) -> str:
    return "–" if value is None else f"{value:.{digits}f}"


def _measured_table(part: dict) -> str:
    columns = ("scheme", "tested", "highlighted", "with neighbours", "subdivided", "into", "final", "rms")
    columns += (
        "PSNR, dB",
        "largest",
        "other triangle",
        "largest there",
        "drawing ÷ Gouraud",
        "÷ Phong",
        "all ÷ Gouraud",
        "÷ Phong",
    )
    names = ("tested", "highlighted", "near", "subdivided", "parts", "final")
    rows = [
        [
            row["scheme"],
            *(f"{row[name]:.1f}" for name in names),
            f"{row['rms']:.2f}",
            _number(row["psnr"], 1),
            f"{row['largest']:.0f}",
            f"{row['others']:.1f}",
            f"{row['largest_other']:.0f}" if row["others"] else "–",
            *(
                f"{row[f'{what}_over_{base}']:.2f}"
                for what in ("draw", "time")
                for base in ("gouraud", "phong")
            ),
        ]
        for row in part["schemes"]
    ]
    return markdown_table(columns, rows)


def _paper_table(rows: list[dict]) -> str:
    columns = ("size", "scheme", "final ÷ mesh: paper", "ours", "subdivided ÷ mesh: paper", "ours")
    columns += ("time ÷ Gouraud: paper", "ours, all", "ours, drawing")
    columns += ("time ÷ Phong: paper", "ours, all", "ours, drawing")
    keys = tuple(rows[0])[2:] if rows else ()
    return markdown_table(
        columns, [[f"{row['size']}²", row["scheme"], *(_number(row[key], 2) for key in keys)] for row in rows]
    )


def text(data: dict) -> str:
    """The report, from the JSON file's content."""
    front = data["measured"][0]["schemes"][0]["front"]
    lines = [
        LICENCE,
        "# Cho's adaptive shading, measured again",
        "",
        paragraph(
            f"Written by `{data['command']}`. {data['mesh']} ({data['faces']} triangles), {data['views']} "
            f"views from above the horizon, ambient light and four point lights that stay where they are, "
            f"Blinn's exponent {data['exponent']:g} (the paper gives none). Thresholds as in the paper: "
            f"{DIFFERENCE} of the true intensity (highlight subdivision), {AREA:g} pixels "
            f"(regular). Counts are means a view; "
            f"{front:.1f} triangles face the viewer."
        ),
        "",
        paragraph(
            "Highlighted: the test of H1 and H2 names the triangle for a light; with neighbours: those that "
            "share a vertex with one too. Subdivided: triangles of more than one part (whoever shares a "
            "split edge follows, so that there are no cracks), *into* is the number of their parts. Errors "
            "are grey levels of 255 against Phong shading in float, over all channels of all pixels drawn. "
            "*Largest* is over pixels in which both pictures have the same triangle of the mesh. *Other "
            "triangle*: pixels a view in which they have not, because a new vertex is rounded to 1/256 pixel "
            "and the surface that is nearest there, or to one side of an edge, is another one; the largest "
            "difference there is that of two surfaces."
        ),
        "",
        paragraph(
            "All schemes are drawn by one compiled scanline renderer with a z-buffer, in turns, on one core. "
            "*Drawing* is light and pixels; *all* adds the transformation, the test and the division, which "
            "are compiled loops too."
        ),
    ]
    for part in data["measured"]:
        lines += ["", f"## {part['size']} x {part['size']}", ""]
        lines += [f"{part['pixels']:.0f} pixels drawn a view.", "", _measured_table(part)]
    if data["paper"]:
        lines += ["", "## Beside the paper's Tables 1 and 2", ""]
        lines += [
            paragraph(
                "As ratios, the paper's software renderer and its teapot of 896 triangles. Its final numbers "
                "hold triangles that face away; here they are added, undivided."
            ),
            "",
            _paper_table(data["paper"]),
        ]
    if data["shares"]:
        lines += ["", *shares_text(data["shares"], data["paper"])]
    return "\n".join(lines) + "\n"


@click.command()
@click.option("--mesh", "scene", default="teapot", show_default=True, help="Or a file or a generated scene.")
@click.option("--size", "sizes", multiple=True, type=int, default=SIZES, show_default=True)
@click.option("--views", default=60, show_default=True, type=click.IntRange(1))
@click.option(
    "--repeats", default=3, show_default=True, type=click.IntRange(1), help="The least time counts."
)
@click.option("--exponent", default=50.0, show_default=True, help="Specular exponent.")
@output_option(REPORT)
@one_line_errors(REPORT.stem)
def main(scene: str, sizes: tuple[int, ...], views: int, repeats: int, exponent: float, output: Path) -> None:
    """Draw every scheme from all sides, and write the report."""
    mesh = teapot() if scene == "teapot" else load_scene(scene)
    material = Material(exponent=exponent)
    measure(mesh, 64, 1, 1, material)  # what is compiled at the first call is no part of the times
    measured = [measure(mesh, size, views, repeats, material) for size in sizes]
    data = {
        "command": command_line("cho.tables", mesh=Path(scene).name, views=views, exponent=exponent),
        "mesh": Path(scene).name,
        "faces": len(mesh),
        "views": views,
        "exponent": exponent,
        "measured": measured,
        "paper": beside_paper(measured, len(mesh)),
        "shares": measured_shares(mesh, four_lights(mesh), directions(max(views // 3, 1)), exponent),
    }
    write_report(output, text(data), data)
    click.echo(text(data))


if __name__ == "__main__":
    main()
