# SPDX-License-Identifier: Apache-2.0
"""
What fits and planning save of an adaptive picture's bytes, and the bytes below which no picture is.

Writes docs/reports/adapt_fits.md and adapt_fits.json. The real meshes are those of the package pyvista, which
pip fetches at run time; without a package index they are left out, and the report says so.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import click
import numpy as np
from rich.console import Console

from quadshade.adapt import ErrorCurve, adapt, error_figures, pixel_errors, stream_bytes
from quadshade.engine import draw
from quadshade.files.markdown import markdown_table
from quadshade.scene import Projected, fit_camera, load_scene, project
from quadshade.shading import Material
from scripts.experiments.real_meshes import PACKAGE, real_meshes
from scripts.experiments.report_writer import (
    REPORTS,
    command_line,
    keep_option,
    kept,
    output_option,
    paragraph,
    write_report,
)
from scripts.one_line_errors import one_line_errors

REPORT = REPORTS / "adapt_fits.md"
GENERATED = ("sphere:168", "sphere:374", "sphere:690", "torus:288")
ERRORS = (16.0, 8.0, 4.0, 2.0, 1.0, 0.7)
"""Grey levels."""
KINDS = {"plain": "six-point", "fitted": "minimax", "auto": "auto"}
"""Fits, by their names in the JSON file."""
TIMED = 4.0
"""The error for which planning is timed, every fit from the start."""
WANTED = 0.9
"""Share of the bytes that should be left."""
BEFORE: dict[str, tuple[int, ...]] = {
    "sphere:168": (4748, 5320, 6848, 7244, 7804, 11860),
    "sphere:374": (10140, 10772, 12516, 12860, 13848, 14680),
    "sphere:690": (16968, 17920, 18552, 20228, 21772, 22704),
    "torus:288": (12040, 13468, 14236, 15588, 31936, 64776),
    "airplane.ply": (64948, 67436, 70940, 73888, 77916, 81816),
    "ant.ply": (28188, 29096, 35968, 52528, 74852, 112624),
    "nut.ply": (23772, 24840, 26908, 27712, 30004, 49020),
}
"""Bytes for ``ERRORS`` in the first version of this report: whole power tables, plans by estimates alone."""
VERDICTS = "gained", "forbidden", "neither"
COLUMNS = (
    "mesh", "max error", "channels", "before", "six points", "minimax", "auto", "minimax over six points",
    "least over before", "at least", "10 % fewer", "flat", "parts", "parts with fits", "measured",
)  # fmt: skip


def rows_of(name: str, whole: Projected, material: Material) -> Iterator[dict]:
    """For each error what is picked without and with fits, every pixel drawn anew and compared."""
    curves = {key: ErrorCurve(whole, None, material, shading="auto", fit=fit) for key, fit in KINDS.items()}
    flat = min(curve.picture(0).plan.bytes for curve in curves["plain"].curves)
    for number, error in enumerate(ERRORS):
        row: dict = {"mesh": name, "max_error": error, "flat_bytes": flat}
        row["least_possible"] = curves["plain"].least_possible(error)
        row["before"] = BEFORE[name][number] if name in BEFORE else None
        for key, curve in curves.items():
            adapted = curve.for_error(error)
            drawing = draw(adapted.triangles, adapted.formats)
            off = pixel_errors(drawing.pixels, adapted.root, whole, None, material, adapted.formats)
            row[key] = {
                "channels": adapted.shading,
                "bytes": stream_bytes(adapted.triangles, adapted.formats),
                "parts": len(adapted.triangles),
                "max": error_figures(off).largest,
            }
            if error == TIMED:
                begun = time.process_time()
                adapt(whole, None, material, max_error=error, shading="auto", fit=KINDS[key])
                row[key]["seconds"] = time.process_time() - begun
        yield row


def shares(rows: list[dict], key: str, quantity: str = "bytes") -> list[float]:
    """What a fit takes over what six points take, of the rows where it is known."""
    return [row[key][quantity] / row["plain"][quantity] for row in rows if quantity in row[key]]


def least(row: dict) -> int:
    """Bytes of the cheapest of the row's pictures."""
    return min(row[key]["bytes"] for key in KINDS)


def verdict(row: dict) -> str:
    """Whether a tenth of the bytes before is gained, or forbidden by the bound."""
    wanted = WANTED * row["before"]
    return VERDICTS[0 if least(row) <= wanted else 1 if row["least_possible"] > wanted else 2]


def cells(row: dict) -> list[str]:
    """One line of the table."""
    plain, fitted, auto, before = row["plain"], row["fitted"], row["auto"], row["before"]
    known = (str(before), f"{least(row) / before:.3f}", verdict(row)) if before else ("–", "–", "–")
    return [
        row["mesh"], f"{row['max_error']:g}", fitted["channels"], known[0], str(plain["bytes"]),
        str(fitted["bytes"]), str(auto["bytes"]), f"{fitted['bytes'] / plain['bytes']:.3f}", known[1],
        str(row["least_possible"]), known[2], str(row["flat_bytes"]), str(plain["parts"]),
        str(fitted["parts"]), f"{fitted['max']:.2f}",
    ]  # fmt: skip


def summary(rows: list[dict]) -> list[list[str]]:
    """For each error what is left over the meshes, and how often a tenth is gained or forbidden."""
    out = []
    for error in ERRORS:
        mine = [row for row in rows if row["max_error"] == error]
        left, known = shares(mine, "fitted"), [row for row in mine if row["before"]]
        now = [least(row) / row["before"] for row in known] or [1.0]
        verdicts = [verdict(row) for row in known]
        out.append(
            [f"{error:g}", f"{np.median(left):.3f}", f"{min(left):.3f}", f"{max(left):.3f}",
             f"{np.median(now):.3f}", f"{max(now):.3f}", *(str(verdicts.count(one)) for one in VERDICTS)]
        )  # fmt: skip
    return out


def text(rows: list[dict], command: str, size: int, exponent: float, missing: bool) -> str:
    """The report."""
    left, auto = shares(rows, "fitted"), shares(rows, "auto")
    now = [least(row) / row["before"] for row in rows if row["before"]] or [1.0]
    more = sum(share > 1 for share in left + auto)
    beyond = sum(row[key]["max"] > row["max_error"] for row in rows for key in KINDS)
    time_auto, time_minimax = (shares(rows, key, "seconds") for key in ("auto", "fitted"))
    lines = [
        "# Fits for an allowed error",
        "",
        "Written by",
        f"`{command}`",
        f"(`make adapt-fits`, which takes the real meshes from {PACKAGE}).",
        f"{size}x{size} pixels, default lights, exponent {exponent:g}, default generics.",
        "",
        paragraph(
            "`quadshade render --max-error`, every pixel verified: bytes of the set-up stream and of the "
            "shade unit's state as planned by default (*six points*) and "
            "with `--fit minimax` or `--fit auto`, all by this run. "
            "*Flat* is the picture with every channel of the undivided mesh constant, of the "
            "channels of which it takes least."
        ),
        "",
        paragraph(
            "*Before* are the bytes of the planner of this report's first version: it sent whole power "
            "tables and planned by estimates, not by what is drawn. *Least over before* is the cheapest of "
            "the three now over that. *At least* is a bound for all polynomials on this mesh "
            "(`ErrorCurve.least_possible`): constants, and one linear channel wherever the light varies by "
            "more than twice the error. A tenth fewer bytes than before is *gained*, or the bound says that "
            "it is *forbidden*, or *neither*. The bound cannot say that a quadratic is needed: a linear "
            "cosine that is raised to a power makes a colour that bends."
        ),
        "",
        paragraph(
            f"Over all {len(rows)} rows the median share that fits leave is {np.median(left):.3f}, the least "
            f"{min(left):.3f}. {more} rows take more bytes with fits, {beyond} exceed the error. "
            f"Over what was taken before the median is {np.median(now):.3f}, the least {min(now):.3f}, the "
            f"most {max(now):.3f}."
        ),
        "",
        paragraph(
            f"`--fit auto` fits only the picture that is found: the median share is {np.median(auto):.3f}, "
            f"the least {min(auto):.3f}. For {TIMED:g} grey levels planning takes "
            f"{np.median(time_auto):.1f} times as much processor time as with six points "
            f"({min(time_auto):.1f} to {max(time_auto):.1f}), with "
            f"`minimax` {np.median(time_minimax):.1f} times ({min(time_minimax):.1f} to "
            f"{max(time_minimax):.1f})."
        ),
        "",
    ]
    if missing:
        lines += [f"The real meshes are missing: pip could not fetch {PACKAGE}.", ""]
    heads = (
        "max error", "fits leave, median", "least", "most", "over before, median", "most", *VERDICTS,
    )  # fmt: skip
    return "\n".join(
        [
            *lines,
            markdown_table(heads, summary(rows)),
            "",
            markdown_table(COLUMNS, [cells(row) for row in rows]),
            "",
        ]
    )


@click.command()
@click.option("--size", default=512, show_default=True, help="Pixels each way.")
@click.option("--exponent", default=50.0, show_default=True, help="Specular exponent.")
@keep_option
@output_option(REPORT)
@one_line_errors(REPORT.stem)
def main(size: int, exponent: float, keep: Path | None, output: Path) -> None:
    """Plan every mesh for every error without and with fits, and write the report."""
    console, material = Console(stderr=True), Material(exponent=exponent)
    rows: list[dict] = []
    with tempfile.TemporaryDirectory() as folder:
        real = real_meshes(Path(folder))
        if not real:
            console.print(f"adapt-fits: pip cannot fetch {PACKAGE}; real meshes are left out")
        for name, source in [*((n, n) for n in GENERATED), *((path.name, str(path)) for path in real)]:
            console.print(f"planning {name}")
            mesh = load_scene(source)
            whole = project(mesh, fit_camera(mesh), size, size)
            rows += kept(keep, name, lambda name=name, whole=whole: list(rows_of(name, whole, material)))
    command = command_line("adaptive_fits", size=size, exponent=exponent)
    written = text(rows, command, size, exponent, not real)
    write_report(output, written, {"command": command, "rows": rows})
    click.echo(written)


if __name__ == "__main__":
    main()
