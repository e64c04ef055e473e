# SPDX-License-Identifier: Apache-2.0
"""
More triangles or a higher order? Mesh density, order, fit and power at the pixel, for a given error.

Every combination is drawn by the golden model and compared with Phong shading of the finest mesh; writes
docs/reports/density.md, density.json and density.png.
"""

from __future__ import annotations

from io import BytesIO
from pathlib import Path

import click
import matplotlib
import numpy as np
from joblib import Parallel, delayed
from PIL import Image
from rich.console import Console

from quadshade.contract.formats import Formats
from quadshade.engine import draw
from quadshade.files.atomic import write_atomically
from quadshade.files.markdown import markdown_table
from quadshade.image import visible
from quadshade.scene import Projected
from quadshade.scene.detail import level_of_detail
from quadshade.shading import sample
from quadshade.trade import Point, View, pareto_front
from quadshade.trade.grid import ALL
from quadshade.trade.measure import measure
from quadshade.trade.view import phong_picture, stage
from scripts.examples import scene_path
from scripts.experiments.report_writer import (
    LICENCE,
    REPORTS,
    command_line,
    output_option,
    paragraph,
    write_report,
)
from scripts.one_line_errors import one_line_errors

matplotlib.use("Agg")
from matplotlib import pyplot as plt
from matplotlib.ticker import NullFormatter

REPORT = REPORTS / "density.md"
SCENES = {
    "sphere:2760": "from=0,0,1,ortho=1.05",
    "torus:1152": "from=0,0,1",
    "knot.glb": "",
    "pawn.obj": "",
}
EXPONENT = 50.0
WAYS = (
    ("flat", "six-point"),
    ("gouraud", "six-point"),
    ("quadratic", "six-point"),
    ("quadratic", "least-squares"),
    ("quadratic", "minimax"),
    ("linear-specular", "six-point"),
    ("quadratic-specular", "six-point"),
    ("adaptive:0.5", "six-point"),
    ("adaptive:2", "six-point"),
)
"""Shading and fit."""
MARKS = {"flat": "s", "gouraud": "^", "quadratic": "o", "linear-specular": "v", "quadratic-specular": "D"}
MARKS |= {"adaptive:0.5": "P", "adaptive:2": "X"}
COLOURS = {"six-point": "tab:blue", "least-squares": "tab:red", "minimax": "tab:green"}
"""Of quadratic colours, by fit;"""
OTHER_COLOURS = {
    "flat": "0.6",
    "gouraud": "0.35",
    "linear-specular": "tan",
    "quadratic-specular": "tab:orange",
}
OTHER_COLOURS |= {"adaptive:0.5": "tab:purple", "adaptive:2": "orchid"}
STEP = 2
LEAST_TRIANGLES = 24
ERRORS = {"inner": (8.0, 4.0, 2.0, 1.0, 0.7, 0.5), "rms": (32.0, 16.0, 8.0, 4.0, 2.0, 1.0)}
"""Grey levels of root mean square that the tables ask for: within the outlines, and of the whole picture."""
COSTS = {"line": "bytes on the line", "clocks": "clocks", "host": "host time"}


def lods(view: View) -> list[str]:
    """Levels that a scene can be drawn in, the finest first."""
    names, faces, count = [ALL], len(view.mesh), len(view.mesh) // STEP
    while count >= LEAST_TRIANGLES:
        level = len(level_of_detail(view.mesh, count, view.scene))
        if level == faces:
            break
        names.append(str(count))
        faces, count = level, count // STEP
    return names


def covered(projected: Projected) -> np.ndarray:
    """(h, w) bool: pixels that show the scene."""
    pixels = draw(sample(projected, "flat"), Formats()).pixels
    return visible(pixels, projected.width, projected.height) >= 0


def level_rows(name: str, size: int, lod: str) -> list[dict]:
    """A row for each shading and fit of one level of a scene, and one for what the outlines cost."""
    view = View(scene_path(name), size, size, camera=SCENES[name], exponent=EXPONENT)
    base = Formats()
    whole = view.projected(base)
    level = whole if lod == ALL else view.projected(base, lod)
    place = stage(view, level, "none", base, None if lod == ALL else whole)
    inside = covered(whole) & covered(level)

    def errors(picture: np.ndarray) -> dict[str, float]:
        square = (picture.astype(float) - place.reference) ** 2
        return {
            "rms": round(float(np.sqrt(square.mean())), 4),
            "inner": round(float(np.sqrt(square[inside].mean())), 4),
        }

    head = {"scene": name, "lod": lod, "triangles": len(level)}
    outside = int(np.count_nonzero(covered(whole) ^ covered(level)))
    ideal = phong_picture(level, view.lamps, view.surface, base)
    rows = [head | {"shading": "phong", "fit": "", "outside": outside} | errors(ideal)]
    for shading, fit in WAYS:
        measured = measure(Point(shading, base.frac_bits, "none", lod, fit), place, base, "model")
        record = measured.record
        if record["refused"] is None:
            with Image.open(BytesIO(measured.files["picture.png"])) as image:
                found = errors(np.asarray(image))
            kept = {key: record[key] for key in ("line", "clocks")}
            rows.append(head | {"shading": shading, "fit": fit} | found | kept)
            rows[-1]["host"] = record["host_seconds"]
    return rows


def scene_rows(name: str, size: int, jobs: int) -> list[dict]:
    """All rows of a scene; host time as a ratio to six points of all triangles, in one run on one core."""
    view = View(scene_path(name), size, size, camera=SCENES[name], exponent=EXPONENT)
    run = Parallel(n_jobs=jobs)
    rows = [row for part in run(delayed(level_rows)(name, size, lod) for lod in lods(view)) for row in part]
    first = next(
        row["host"]
        for row in rows
        if (row["lod"], row["shading"], row["fit"]) == (ALL, "quadratic", "six-point")
    )
    for row in rows:
        if "host" in row:
            row["host"] = round(row["host"] / first, 3)
    return rows


def way(row: dict) -> str:
    """Shading and fit in words."""
    return row["shading"] if row["shading"] != "quadratic" else f"quadratic, {row['fit']}"


def cheapest(rows: list[dict], measure: str, error: float, cost: str) -> dict | None:
    """The row that costs least of those that keep an error, ``inner`` or ``rms``."""
    kept = [row for row in rows if row[measure] <= error and row.get(cost) is not None]
    return min(kept, key=lambda row: (row[cost], row[measure])) if kept else None


def plot(rows: list[dict], path: Path) -> None:
    """Error against bytes on the line, a panel a scene: order and fit by mark and colour, density by size."""
    figure, panels = plt.subplots(2, 2, figsize=(12, 9.5), constrained_layout=True)
    scenes = list(dict.fromkeys(row["scene"] for row in rows))
    for axes, scene in zip(panels.flat, scenes, strict=False):
        drawn = [row for row in rows if row["scene"] == scene and row.get("line")]
        most = max(row["triangles"] for row in drawn)
        for shading, fit in WAYS:
            own = [row for row in drawn if (row["shading"], row["fit"]) == (shading, fit)]
            own.sort(key=lambda row: row["triangles"])
            colour = OTHER_COLOURS.get(shading, COLOURS[fit])
            line = {"color": colour, "linewidth": 0.6, "alpha": 0.6}
            axes.plot([row["line"] for row in own], [row["inner"] for row in own], **line)
            axes.scatter(
                [row["line"] for row in own],
                [row["inner"] for row in own],
                s=[14 + 80 * (row["triangles"] / most) ** 0.5 for row in own],
                marker=MARKS[shading],
                color=colour,
                alpha=0.75,
                linewidths=0.4,
                edgecolors="white",
                label=shading if shading != "quadratic" else f"quadratic, {fit}",
            )
        front = pareto_front([row["line"] for row in drawn], [row["inner"] for row in drawn])
        best = sorted((row["line"], row["inner"]) for row, on in zip(drawn, front, strict=True) if on)
        axes.step(*zip(*best, strict=True), where="post", color="black", linewidth=1.2, label="front")
        axes.set(xscale="log", yscale="log", title=f"{scene}, {most} triangles seen")
        axes.set(xlabel="bytes on the line", ylabel="inner rms error, grey levels")
        axes.xaxis.set_minor_formatter(NullFormatter())
        axes.grid(True, which="both", linewidth=0.3)
    panels.flat[0].legend(fontsize=8, title="size of a mark: density")
    write_atomically(path, lambda temporary: figure.savefig(temporary, format="png", dpi=110))
    plt.close(figure)


def answers(rows: list[dict], measure: str) -> list[tuple[str, ...]]:
    """For every scene and error what is cheapest, by each cost."""
    lines = []
    for scene in dict.fromkeys(row["scene"] for row in rows):
        own = [row for row in rows if row["scene"] == scene and row["shading"] != "phong"]
        for error in ERRORS[measure]:
            cells = []
            for cost in COSTS:
                best = cheapest(own, measure, error, cost)
                unit = "" if best is None else f"{best[cost]:.2f}" if cost == "host" else f"{best[cost]}"
                cells.append("–" if best is None else f"{unit}: {best['triangles']} {way(best)}")
            lines.append((scene, f"{error:g}", *cells))
    return lines


def reading(rows: list[dict]) -> str:
    """What the table of inner errors comes to, in a sentence."""
    asked, coarser, adaptive, fitted = 0, 0, 0, 0
    for scene in dict.fromkeys(row["scene"] for row in rows):
        own = [row for row in rows if row["scene"] == scene and row["shading"] != "phong"]
        for error in ERRORS["inner"]:
            best = cheapest(own, "inner", error, "line")
            if best is not None:
                asked += 1
                coarser += best["lod"] != ALL
                adaptive += best["shading"].startswith("adaptive")
                fitted += best["fit"] != "six-point"
    return (
        f"Of these {asked} answers on the line, {coarser} are a coarser mesh than the finest, {adaptive} an "
        f"adaptive picture of it, and {fitted} a fit over the whole picture. An error below that of a "
        "density itself (Phong, below) asks for more triangles, whatever the order; above it a higher order "
        "of fewer triangles takes less."
    )


def floors(rows: list[dict]) -> list[tuple[str, ...]]:
    """What fewer triangles cost whatever shades them, and the best and cheapest way of each density."""
    lines = []
    for row in rows:
        if row["shading"] == "phong":
            level = [one for one in rows if (one["scene"], one["lod"]) == (row["scene"], row["lod"])]
            drawn = [one for one in level if one["shading"] != "phong"]
            best = min(drawn, key=lambda one: (one["inner"], one["line"]))
            lines.append(
                (
                    row["scene"], str(row["triangles"]), str(row["outside"]), f"{row['rms']:.2f}",
                    f"{row['inner']:.2f}", way(best), f"{best['inner']:.2f}", str(best["line"]),
                )
            )  # fmt: skip
    return lines


def report(results: dict) -> str:
    """The report's text, from nothing but the numbers."""
    rows = results["rows"]
    about = f"""
    Written by `{results["command"]}` (`make density`): {results["size"]}x{results["size"]} pixels, exponent
    {EXPONENT:g}, default lights. Every level of detail has half of the triangles of the one before it,
    sphere and torus tessellated anew, the meshes decimated (`--lod`), with the normals of the finest mesh.
    Error is the root mean square from Phong shading of the finest mesh, over the pixels that both pictures
    cover (*inner*), or over the whole picture with its black background, to which outlines contribute most.
    *Bytes on the line* are those of the packed picture with its framing. Host time is processor time to
    shade, fit, set up and pack, as a ratio to six points of the finest mesh, in one run; that of
    `adaptive:E` has its planning, which picks orders of colours and division for an rms error of E from
    Phong shading of its own level. In front of each way stand its triangles, of those that face the viewer.
    """
    answer = """
    For an inner error of no more than so many grey levels, the cheapest is:
    """
    whole = """
    The same for the error of the whole picture. No shading mends an outline, so the density decides.
    """
    floor = """
    *Pixels outside* are those that one of the two pictures covers and the other does not. *Phong* is the
    error of that density itself: its triangles, shaded at every pixel by the host. Beside it the way with
    the least inner error.
    """
    header = ("scene", "rms error", *COSTS.values())
    floor_header = (
        "scene", "triangles", "pixels outside", "Phong, whole", "Phong, inner", "best way", "inner",
        "bytes on the line",
    )  # fmt: skip
    return "\n\n".join(
        [
            f"{LICENCE}\n# More triangles, or a higher order?",
            paragraph(about),
            "![error against bytes on the line](density.png)",
            paragraph(answer),
            markdown_table(header, answers(rows, "inner")),
            paragraph(reading(rows)),
            paragraph(whole),
            markdown_table(header, answers(rows, "rms")),
            "## What each density can be",
            paragraph(floor),
            markdown_table(floor_header, floors(rows)) + "\n",
        ]
    )


@click.command(help=__doc__)
@click.option("--size", default=256, show_default=True, help="Pixels a side.")
@click.option("--scene", "scenes", multiple=True, type=click.Choice(tuple(SCENES)), help="Repeatable.")
@click.option("--jobs", type=click.IntRange(1), default=1, show_default=True, help="Processes.")
@output_option(REPORT)
@one_line_errors(REPORT.stem)
def main(size: int, scenes: tuple[str, ...], jobs: int, output: Path) -> None:
    console, rows = Console(stderr=True), []
    for name in scenes or SCENES:
        console.print(f"measuring {name}")
        rows += scene_rows(name, size, jobs)
    given = {"scene": list(scenes)} if scenes else {}
    results = {"command": command_line("density", size=size, **given), "size": size, "rows": rows}
    plot(rows, output.with_suffix(".png"))
    write_report(output, report(results), results)
    click.echo(f"{output}: {len(rows)} rows")


if __name__ == "__main__":
    main()
