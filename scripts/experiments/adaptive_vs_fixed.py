# SPDX-License-Identifier: Apache-2.0
"""
Adaptive pictures beside every fixed choice: error against bytes, on generated and on real meshes.

Writes docs/reports/adapt.md, adapt.json and adapt.png. The real meshes are those of the package pyvista,
which pip fetches at run time, or files given with --mesh; without a package index they are left out, and the
report says so.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import click
import matplotlib
import numpy as np
from rich.console import Console

from quadshade.adapt import (
    ColourShader,
    CosineShader,
    ErrorCurve,
    LightShader,
    adapt,
    error_figures,
    pixel_errors,
    refine,
)
from quadshade.adapt.costs import state_bytes
from quadshade.adapt.curve import Curve
from quadshade.adapt.plan import Planner
from quadshade.contract.formats import Formats
from quadshade.contract.triangles import ScreenTriangles
from quadshade.engine import draw
from quadshade.errors import QuadshadeError
from quadshade.files.markdown import markdown_table
from quadshade.scene import Projected, fit_camera, load_scene, project
from quadshade.shading import Material, sample, sample_specular, specular_formats
from scripts.experiments.real_meshes import PACKAGE, real_meshes
from scripts.experiments.report_writer import (
    REPORTS,
    command_line,
    keep_option,
    kept,
    output_option,
    write_report,
)
from scripts.one_line_errors import one_line_errors

matplotlib.use("Agg")
from matplotlib import pyplot as plt
from matplotlib.ticker import NullFormatter

REPORT = REPORTS / "adapt.md"
GENERATED = ("sphere:168", "sphere:690", "torus:288")
LEVELS = 3
"""Undivided, and every triangle divided into 4 and 16."""
SHADINGS = {"flat": "s", "gouraud": "^", "quadratic": "o", "linear-specular": "v", "quadratic-specular": "D"}
"""Fixed choices and their marks in the plot."""
MEASURES = ("max", "rms")
ERRORS = (16.0, 8.0, 4.0, 2.0, 1.0, 0.7)
"""Grey levels for which the mix is shown."""
MIX_COLUMNS = (
    "mesh", "max error", "channels", "bytes", "the other's", "divided", "parts", "constant", "linear",
    "quadratic", "with a power", "measured",
)  # fmt: skip
COLUMNS = (
    "mesh", "fixed choice", "bytes", "max", "bytes at no more max", "max at no more bytes",
    "rms", "bytes at no more rms", "rms at no more bytes",
)  # fmt: skip


def measured(
    triangles: ScreenTriangles, root: np.ndarray, whole: Projected, material: Material, formats: Formats
) -> dict:
    """Bytes, clocks and both errors of a drawing by the golden model."""
    drawing = draw(triangles, formats)
    figures = error_figures(pixel_errors(drawing.pixels, root, whole, None, material, formats))
    return {
        "triangles": len(triangles),
        "bytes": 4 * drawing.stats["words"] + state_bytes(triangles, formats),
        "clocks": drawing.stats["clocks"],
        "max": figures.largest,
        "rms": figures.rms,
    }


def fixed_choices(whole: Projected, material: Material, formats: Formats) -> Iterator[dict]:
    """Every shading at every level of uniform division."""
    parts, root = whole, np.arange(len(whole))
    core = specular_formats({}, whole, None, material)
    for level in range(LEVELS):
        for shading in SHADINGS:
            own = core if shading.endswith("-specular") else formats
            take = sample_specular if shading.endswith("-specular") else sample
            triangles = take(parts, shading, None, material, own)
            name = shading if not level else f"{shading}, each in {4**level}"
            yield {"choice": name, "shading": shading} | measured(triangles, root, whole, material, own)
        parts, parent = refine(parts, np.ones(len(parts), dtype=bool))
        root = root[parent]


def adaptive_curve(
    whole: Projected, measure: str, steps: int, most: int, material: Material, formats: Formats
) -> Iterator[dict]:
    """
    Pictures of each kind of channels from the cheapest to the best.

    Until one takes more than fixed choices; those without the power, only while they take less than with it.
    """
    with_power: dict[int, int] = {}
    core = specular_formats({}, whole, None, material)
    for kind, own in ((ColourShader, formats), (CosineShader, core), (LightShader, core)):
        curve = Curve(Planner(whole, kind(None, material, own, whole, measure)), verify=True)
        for index in np.unique(np.linspace(0, len(curve) - 1, steps).astype(int)).tolist():
            adapted = curve.picture(index).plan.adapted(verify=True)
            drawn = measured(adapted.triangles, adapted.root, whole, material, own)
            yield {"measure": measure} | adapted.mix() | drawn
            if kind is CosineShader:
                with_power[index] = drawn["bytes"]
            if drawn["bytes"] > (with_power.get(index, np.inf) if kind is LightShader else most):
                break


def mixes(whole: Projected, material: Material, formats: Formats) -> Iterator[dict]:
    """What is picked for several allowed errors, every pixel verified."""
    for error in ERRORS:
        adapted = adapt(whole, None, material, formats, max_error=error, shading="auto")
        point = measured(adapted.triangles, adapted.root, whole, material, adapted.formats)
        yield {"max_error": error} | adapted.mix() | point


def asked(curve: ErrorCurve, fixed: dict, whole: Projected, material: Material) -> Iterator[dict]:
    """What a user gets who asks for a fixed choice's error, or for its bytes."""
    questions = (
        lambda: curve.for_error(fixed[curve.measure]),
        lambda: curve.for_budget(fixed["bytes"]),
    )
    for question in questions:
        try:
            adapted = question()
        except QuadshadeError:
            # No picture keeps what a choice of many parts has by the chance of rounding.
            continue
        yield measured(adapted.triangles, adapted.root, whole, material, adapted.formats)


def compared(fixed: dict, curves: dict[str, list[dict]]) -> dict:
    """For both measures the cheapest adaptive picture that is no worse, and the best that is no dearer."""
    row = dict(fixed)
    for measure in MEASURES:
        points = curves[measure]
        bytes_needed = [point["bytes"] for point in points if point[measure] <= fixed[measure]]
        errors = [point[measure] for point in points if point["bytes"] <= fixed["bytes"]]
        row[f"bytes_at_{measure}"] = min(bytes_needed, default=None)
        row[f"{measure}_at_bytes"] = min(errors, default=None)
    return row


def verdict(row: dict, measure: str) -> str:
    """Whether adaptive dominates: fewer bytes at no more error, and less error at no more bytes."""
    needed, error = row[f"bytes_at_{measure}"], row[f"{measure}_at_bytes"]
    if needed is None or error is None or error > row[measure] or needed > row["bytes"]:
        return "no"
    return "yes" if needed < row["bytes"] and error < row[measure] else "as many bytes, less error"


def scene_report(name: str, source: str, size: int, steps: int, material: Material) -> dict:
    """All points of one mesh."""
    formats = Formats()
    mesh = load_scene(source)
    whole = project(mesh, fit_camera(mesh), size, size, formats)
    fixed = list(fixed_choices(whole, material, formats))
    most = max(point["bytes"] for point in fixed)
    curves = {
        measure: list(adaptive_curve(whole, measure, steps, most, material, formats)) for measure in MEASURES
    }
    core = specular_formats({}, whole, None, material)
    asks = [
        ErrorCurve(whole, None, material, formats, measure=measure, shading="auto", specular=core)
        for measure in MEASURES
    ]
    rows = []
    for point in fixed:
        answers = {curve.measure: list(asked(curve, point, whole, material)) for curve in asks}
        rows.append(compared(point, {name: curves[name] + answers[name] for name in MEASURES}))
    for row in rows:
        for measure in MEASURES:
            row[f"dominated_{measure}"] = verdict(row, measure)
    about = {"mesh": name, "faces": len(mesh), "visible": len(whole)}
    return about | {"fixed": rows, "adaptive": curves, "mixes": list(mixes(whole, material, formats))}


def front(points: list[dict], measure: str) -> tuple[list, list]:
    """Bytes and least error so far, for the plot."""
    ordered = sorted(points, key=lambda point: point["bytes"])
    return [p["bytes"] for p in ordered], list(np.minimum.accumulate([p[measure] for p in ordered]))


def plot(scenes: list[dict], path: Path) -> None:
    """Error against bytes, a panel for each mesh and measure."""
    figure, axes = plt.subplots(2, len(scenes), figsize=(3.1 * len(scenes), 6.2), squeeze=False)
    for column, scene in enumerate(scenes):
        for line, measure in enumerate(MEASURES):
            panel = axes[line, column]
            for shading, mark in SHADINGS.items():
                points = [row for row in scene["fixed"] if row["shading"] == shading]
                panel.plot(
                    [p["bytes"] for p in points], [p[measure] for p in points], mark + ":", label=shading
                )
            for kind, line_style in ((ColourShader, "k--"), (CosineShader, "k-"), (LightShader, "k:")):
                points = [p for p in scene["adaptive"][measure] if p["adaptive_shading"] == kind.shading]
                panel.plot(*front(points, measure), line_style, label=f"adaptive, {kind.shading}")
            panel.set(xscale="log", yscale="log")
            panel.xaxis.set_minor_formatter(NullFormatter())
            panel.yaxis.set_minor_formatter(NullFormatter())
            panel.grid(alpha=0.3, which="both")
            if not line:
                panel.set_title(f"{scene['mesh']} ({scene['visible']} visible)", fontsize=9)
            else:
                panel.set_xlabel("bytes")
            if not column:
                panel.set_ylabel(f"{'largest' if measure == 'max' else 'rms'} error, grey levels")
    axes[0, 0].legend(fontsize=6)
    figure.tight_layout()
    figure.savefig(path, dpi=90, metadata={"Software": None})


def cells(scene: str, row: dict) -> list[str]:
    """One line of the table."""
    out = [scene, row["choice"], str(row["bytes"])]
    for measure, digits in (("max", 2), ("rms", 3)):
        needed, error = row[f"bytes_at_{measure}"], row[f"{measure}_at_bytes"]
        out.append(f"{row[measure]:.{digits}f}")
        out.append("none" if needed is None else f"{needed} ({needed / row['bytes']:.2f})")
        out.append("none" if error is None else f"{error:.{digits}f} ({error / row[measure]:.2f})")
    return out


def text(scenes: list[dict], command: str, settings: str, missing: bool) -> str:
    """The report."""
    verdicts = [row[f"dominated_{m}"] for scene in scenes for row in scene["fixed"] for m in MEASURES]
    counts = {kind: verdicts.count(kind) for kind in ("yes", "as many bytes, less error", "no")}
    lines = [
        "# Adaptive beside fixed choices",
        "",
        "Written by",
        f"`{command}`",
        f"(`make adapt`, which takes the real meshes from {PACKAGE}).",
        settings,
        "",
        "Errors are in grey levels against unrounded Phong shading of the undivided mesh, over every pixel",
        "that the golden model drew, `max` the largest of any channel, `rms` the root mean square. *At no",
        "more* is the cheapest (or best) picture of the adaptive curve that is no worse (or no dearer) than",
        "the fixed choice, in brackets its share of it; `--max-error` and `--budget` were asked for the",
        "fixed choice's error and bytes too. A fixed choice is *dominated* where adaptive needs",
        "fewer bytes for no more error and has less error for no more bytes.",
        "",
        f"Of {len(verdicts)} comparisons (fixed choices, both measures) {counts['yes']} are dominated,",
        f"{counts['as many bytes, less error']} have as many bytes and less error, {counts['no']} are not.",
        "",
        "Adaptive pictures have colour channels (`quadratic`), cosines (`quadratic-specular`: diffuse and",
        "specular, the power taken at the pixel, [shade.md](../explanation/shade.md)) or the light's parts",
        "(`quadratic-lights`: diffuse and specular, without the power); the curve is the best of them. Bytes",
        "are those of the set-up stream and of the shade unit's state where it is used.",
        "",
    ]
    if missing:
        lines += [f"The real meshes are missing: pip could not fetch {PACKAGE}.", ""]
    lines += [
        "![error against bytes](adapt.png)",
        "",
        markdown_table(COLUMNS, [cells(scene["mesh"], row) for scene in scenes for row in scene["fixed"]]),
    ]
    not_dominated = [
        f"- {scene['mesh']}, {row['choice']}, {measure}: {row[f'dominated_{measure}']}"
        for scene in scenes
        for row in scene["fixed"]
        for measure in MEASURES
        if row[f"dominated_{measure}"] != "yes"
    ]
    if not_dominated:
        lines += ["", "Where it is not fewer bytes and less error:", "", *not_dominated]
    return "\n".join([*lines, "", *mix_text(scenes)]) + "\n"


def mix_text(scenes: list[dict]) -> list[str]:
    """What `--max-error` picks."""
    rows = []
    for scene in scenes:
        for row in scene["mixes"]:
            orders, powers = row["triangles_by_order"], row["specular_by_order"]
            rival = row["rival"] or {}
            line = [scene["mesh"], f"{row['max_error']:g}", row["adaptive_shading"], row["bytes"]]
            line += [rival.get("bytes") or "–", row["divided"], row["triangles"], *orders.values()]
            varying = powers["linear"] + powers["quadratic"]
            line += [varying if row["adaptive_shading"] == CosineShader.shading else "–", f"{row['max']:.2f}"]
            rows.append(line)
    return [
        "## What is picked",
        "",
        "`quadshade render --max-error`: every pixel verified. *Parts* are triangles sent, counted by their",
        "highest order; *with a power* are those whose specular cosine is linear or quadratic. *The other's*",
        "bytes are those of the next best channels that were tried.",
        "",
        markdown_table(MIX_COLUMNS, rows),
    ]


@click.command()
@click.option("--size", default=512, show_default=True, help="Pixels each way.")
@click.option("--exponent", default=50.0, show_default=True, help="Specular exponent.")
@click.option("--steps", default=31, show_default=True, help="Points of each adaptive curve, at most.")
@click.option(
    "--mesh",
    "files",
    multiple=True,
    type=click.Path(exists=True, path_type=Path),
    help="Instead of pyvista's.",
)
@keep_option
@output_option(REPORT)
@one_line_errors(REPORT.stem)
def main(
    size: int, exponent: float, steps: int, files: tuple[Path, ...], keep: Path | None, output: Path
) -> None:
    """Draw every fixed choice and the adaptive curves, and write the report."""
    console, material = Console(stderr=True), Material(exponent=exponent)
    scenes = []
    with tempfile.TemporaryDirectory() as folder:
        real = list(files) or real_meshes(Path(folder))
        if not real:
            console.print(f"adapt: pip cannot fetch {PACKAGE}; real meshes are left out (give --mesh FILE)")
        for name, source in [*((n, n) for n in GENERATED), *((path.name, str(path)) for path in real)]:
            console.print(f"drawing {name}")
            scenes.append(kept(keep, name, partial(scene_report, name, source, size, steps, material)))
    names = [path.name for path in files]
    command = command_line("adaptive_vs_fixed", size=size, exponent=exponent, steps=steps, mesh=names)
    settings = f"{size}x{size} pixels, default lights, exponent {exponent:g}, default generics."
    written = text(scenes, command, settings, not real)
    write_report(output, written, {"command": command, "scenes": scenes})
    plot(scenes, output.with_suffix(".png"))
    click.echo(written)


if __name__ == "__main__":
    main()
