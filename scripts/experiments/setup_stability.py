# SPDX-License-Identifier: Apache-2.0
"""
Numerical stability of the set-up methods at the extremes: float32 and float64 against exact rationals.

Needles up to a million times as long as high, triangles from 4/256 of a pixel to 4096 pixels, and the cases
in which a printed formula divides by zero or nearly so. Writes docs/reports/stability.md, .json and .png.
"""

from __future__ import annotations

from fractions import Fraction
from math import gcd
from pathlib import Path

import click
import numpy as np

from quadshade.contract.formats import QUADRATIC, Formats
from quadshade.contract.triangles import ScreenTriangles
from quadshade.files.markdown import markdown_table
from quadshade.setup.literature.general_solution import general_in
from quadshade.setup.literature.methods import terms_in
from quadshade.setup.triangle_setup import setup_triangles
from scripts.experiments.report_writer import (
    REPORTS,
    command_line,
    output_option,
    paragraph,
    write_report,
)
from scripts.one_line_errors import one_line_errors

REPORT = REPORTS / "stability.md"
METHODS = ("abbas", "general", "unit_triangle", "x_shading")
TYPES = {"float32": np.float32, "float64": np.float64}
WORDS = ("set-up", "words")
"""The record of what the host itself sends: 32-bit words, 22 bits of them fraction, their bound."""
SUBPIXELS = 256
ASPECTS = tuple(10 ** (step / 2) for step in range(13))
SIZES = tuple(2.0**step for step in range(-6, 13))
NEEDLE = 256
"""Longest side of a needle, in pixels."""
FINE = 4
"""The error is looked for at the points (i, j) / FINE of the unit triangle."""


def needle(rng: np.random.Generator, length: float, aspect: float) -> list[int]:
    """
    X2, Y2, X3, Y3 in sub-pixels: side 1-2 of a length in pixels, a height ``aspect`` times less.

    With X2, Y2 coprime X2 Y3 - Y2 X3 can be any integer, so the height is not bound to whole sub-pixels.
    """
    side = length * SUBPIXELS
    while True:
        angle = rng.uniform(0, 2 * np.pi)
        x, y = round(side * np.cos(angle)), round(side * np.sin(angle))
        if gcd(x, y) != 1 or not x or not y:
            continue
        doubled = max(round(side * side / aspect * rng.uniform(0.9, 1.1)), 1)
        for area in range(doubled, doubled + 50):
            # x y3 - y x3 = area, then along the side until the foot lies between its ends.
            y3 = area * pow(x, -1, abs(y)) % abs(y)
            x3 = (x * y3 - area) // y
            shift = (x3 * x + y3 * y) // (x * x + y * y)
            x3, y3 = x3 - shift * x, y3 - shift * y
            if 0.25 < (x3 * x + y3 * y) / (x * x + y * y) < 0.75:
                return [x, y, x3, y3]


def stout(rng: np.random.Generator, length: float) -> list[int]:
    """A triangle without small angles whose sides are about as long as told, in pixels."""
    side = length * SUBPIXELS
    while True:
        legs = np.rint(rng.uniform(-side, side, 4)).astype(int).tolist()
        x2, y2, x3, y3 = legs
        longest = max(x2 * x2 + y2 * y2, x3 * x3 + y3 * y3, (x2 - x3) ** 2 + (y2 - y3) ** 2)
        if 0 < longest <= side * side * 1.1 and abs(x2 * y3 - y2 * x3) > 0.5 * longest and all(legs):
            return legs


def special(name: str, rng: np.random.Generator) -> list[int]:
    """A triangle of about 200 pixels in which something is zero, or one sub-pixel."""
    x2, y2, x3, y3 = stout(rng, 200)
    if name == "one sub-pixel squared":
        return needle(rng, 200, (200 * SUBPIXELS) ** 2)
    return {
        "Y2 = 0": [x2, 0, x3, y3],
        "Y2 = 1/256": [x2, 1, x3, y3],
        "Y2 = 1": [x2, SUBPIXELS, x3, y3],
        "Y3 = 0": [x2, y2, x3, 0],
        "X2 = 0": [0, y2, x3, y3],
        "X3 = 0": [x2, y2, 0, y3],
        "Y2 = Y3": [x2, y2, x3, y2],
        "X2 = X3": [x2, y2, x2, y3],
        "X2 Y3 = Y2 X3": [x2, y2, 2 * x2, 2 * y2],
    }[name]


SPECIAL = (
    "Y2 = 0",
    "Y2 = 1/256",
    "Y2 = 1",
    "Y3 = 0",
    "X2 = 0",
    "X3 = 0",
    "Y2 = Y3",
    "X2 = X3",
    "one sub-pixel squared",
    "X2 Y3 = Y2 X3",
)


def samples_of(method: str, rng: np.random.Generator, count: int) -> np.ndarray:
    """(n, 6) what a method starts from, exact in float32: grey levels, for X-shading Ni . Nj - 1 as well."""
    samples = rng.uniform(0, 255, (count, 6))
    if method == "x_shading":
        # Normals up to 45 degrees apart.
        samples[:, 3:] = rng.uniform(np.cos(np.pi / 4) - 1, 0, (count, 3))
    return samples.astype(np.float32)


def computed(method: str, dtype: type, legs: np.ndarray, samples: np.ndarray) -> np.ndarray:
    """(n, 6) T0 to T5 by a method in a type of floating point."""
    with np.errstate(all="ignore"):
        typed, given = legs.astype(dtype), samples.astype(dtype)
        if method == "general":
            return general_in(dtype, typed, given)
        return np.stack(np.broadcast_arrays(*terms_in(method, tuple(typed.T), tuple(given.T))), axis=1)


def errors(method: str, legs: np.ndarray, samples: np.ndarray, found: dict) -> dict[str, tuple]:
    """
    Of one triangle, for each type: most grey levels off inside it, and the relative coefficient error.

    The latter weighs each coefficient by its term's size on the triangle, and is of the largest of them. None
    where a coefficient is not finite.
    """
    x2, y2, x3, y3 = exact_legs = [Fraction(float(leg)) for leg in legs]
    if x2 * y3 == y2 * x3:
        return dict.fromkeys(found)
    formula = method if method == "x_shading" else "unit_triangle"
    exact = terms_in(formula, tuple(exact_legs), tuple(Fraction(float(sample)) for sample in samples))
    size = max(abs(leg) for leg in (*exact_legs, x2 - x3, y2 - y3))
    weights = [1, size, size, size**2, size**2, size**2]
    largest = max(abs(term) * weight for term, weight in zip(exact, weights, strict=True))
    results = {}
    for name, terms in found.items():
        if not np.isfinite(terms).all():
            results[name] = None
            continue
        off = [Fraction(float(term)) - want for term, want in zip(terms, exact, strict=True)]
        relative = max(abs(term) * weight for term, weight in zip(off, weights, strict=True)) / largest
        most = Fraction(0)
        for i in range(FINE + 1):
            for j in range(FINE + 1 - i):
                x, y = (i * x2 + j * x3) / FINE, (i * y2 + j * y3) / FINE
                here = off[0] + (off[1] + off[3] * y + off[4] * x) * y + (off[2] + off[5] * x) * x
                most = max(most, abs(here))
        results[name] = float(most), float(relative)
    return results


def words_record(legs: np.ndarray, rng: np.random.Generator) -> dict:
    """The bound of the set-up's own words, rounding included, over the triangles that cover a pixel."""
    formats = Formats(num_channels=1, with_depth=0)
    size, count = 1 << formats.coord_bits, len(legs)
    corners = np.zeros((count, 3, 2))
    corners[:, 1:] = legs.reshape(-1, 2, 2)
    corners -= corners.min(axis=1, keepdims=True)
    room = np.maximum(size - corners.max(axis=1), 0)
    corners += np.floor(rng.uniform(0, 1, (count, 2)) * room * SUBPIXELS)[:, None] / SUBPIXELS
    vertices = np.rint(corners * SUBPIXELS).astype(np.int64)
    samples = rng.uniform(0, 255, (count, 1, 6))
    orders = np.full((count, 1), QUADRATIC)
    bound = setup_triangles(
        ScreenTriangles(size, size, vertices, samples, orders, None, ("grey",)), formats
    ).bound[:, 0]
    return {
        "method": WORDS[0],
        "type": WORDS[1],
        "undefined": 0,
        "drawn": len(bound),
        "worst_grey": float(bound.max()) if len(bound) else None,
        "median_grey": float(np.median(bound)) if len(bound) else None,
        "worst_relative": None,
        "median_relative": None,
    }


def measure(legs: np.ndarray, rng: np.random.Generator) -> list[dict]:
    """A record for every method and type, over triangles (n, 4) in pixels."""
    records = []
    for method in METHODS:
        samples = samples_of(method, rng, len(legs))
        found = {name: computed(method, dtype, legs, samples) for name, dtype in TYPES.items()}
        each = [
            errors(method, *pair, {name: terms[index] for name, terms in found.items()})
            for index, pair in enumerate(zip(legs, samples, strict=True))
        ]
        for name in TYPES:
            good = np.array([one[name] for one in each if one[name] is not None]).reshape(-1, 2)
            record = {"method": method, "type": name, "undefined": len(legs) - len(good)}
            for column, what in enumerate(("grey", "relative")):
                record[f"worst_{what}"] = float(good[:, column].max()) if len(good) else None
                record[f"median_{what}"] = float(np.median(good[:, column])) if len(good) else None
            records.append(record)
    return [*records, words_record(legs, rng)]


def sweep(triangles: int, seed: int) -> list[dict]:
    """Records of all families."""
    rng = np.random.default_rng(seed)
    families = [
        *(("aspect", aspect, lambda a=aspect: needle(rng, NEEDLE, a)) for aspect in ASPECTS),
        *(("size", size, lambda s=size: stout(rng, s)) for size in SIZES),
        *(("special", name, lambda n=name: special(n, rng)) for name in SPECIAL),
    ]
    rows = []
    for family, value, make in families:
        legs = np.array([make() for _ in range(triangles)]) / SUBPIXELS
        rows += [
            {"family": family, "value": value, "triangles": triangles} | record
            for record in measure(legs, rng)
        ]
    return rows


def plot(rows: list[dict], path: Path) -> None:
    """Worst error in grey levels over aspect ratio and size, a column a type."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(2, 2, figsize=(11, 7.5), sharey="row", layout="constrained")
    names = {"aspect": f"longest side over height ({NEEDLE} pixels long)", "size": "side in pixels"}
    for line, (family, label) in zip(axes, names.items(), strict=True):
        for axis, kind in zip(line, TYPES, strict=True):
            for method, marker in zip(METHODS, "os^v", strict=True):
                chosen = [
                    row
                    for row in rows
                    if (row["family"], row["type"], row["method"]) == (family, kind, method)
                    and row["worst_grey"]
                ]
                axis.loglog(
                    [row["value"] for row in chosen],
                    [row["worst_grey"] for row in chosen],
                    marker=marker,
                    markersize=4,
                    linewidth=1.2,
                    label=method,
                )
            chosen = [row for row in rows if row["family"] == family and row["method"] == WORDS[0]]
            axis.loglog(
                [row["value"] for row in chosen],
                [row["worst_grey"] or np.nan for row in chosen],
                color="black",
                linestyle="--",
                linewidth=1,
                label="bound of the words sent",
            )
            axis.axhline(0.5, color="grey", linestyle=":", linewidth=1)
            axis.set_title(kind, fontsize=10)
            axis.set_xlabel(label)
            axis.grid(alpha=0.3)
        line[0].set_ylabel("worst error inside, grey levels")
    axes[0, 0].legend(fontsize=8)
    figure.suptitle("Coefficients of the quadratic against exact rationals (dotted: half a grey level)")
    figure.savefig(path, dpi=110, metadata={"Software": None})
    pyplot.close(figure)


def number(value: float | None) -> str:
    """A table's cell."""
    return "none" if value is None else f"{value:.2g}"


def worst(rows: list[dict], family: str, method: str, kind: str, values: tuple) -> float:
    """Worst error in grey levels of a method over some values of a family; infinite where it is undefined."""
    chosen = [
        row
        for row in rows
        if (row["family"], row["method"], row["type"]) == (family, method, kind) and row["value"] in values
    ]
    return max(np.inf if row["undefined"] else row["worst_grey"] for row in chosen)


def held(rows: list[dict], method: str, kind: str, limit: float = 0.5) -> float:
    """Largest aspect ratio of the sweep up to which a method is never worse than a limit."""
    good = [aspect for aspect in ASPECTS if worst(rows, "aspect", method, kind, (aspect,)) <= limit]
    return max(aspect for aspect in good if all(other in good for other in ASPECTS if other <= aspect))


def table(rows: list[dict], family: str, values: tuple, label: str) -> str:
    """Worst errors in grey levels, a row a value of a family, a column a method and type."""
    keys = [*((method, kind) for kind in TYPES for method in METHODS), WORDS]
    lines = []
    for value in values:
        cells = []
        for method, kind in keys:
            (row,) = (
                row
                for row in rows
                if (row["family"], row["value"], row["method"], row["type"]) == (family, value, method, kind)
            )
            failed = f", {row['undefined']} of {row['triangles']} undefined" if row["undefined"] else ""
            cells.append(number(row["worst_grey"]) + failed)
        lines.append([value if isinstance(value, str) else f"{value:.3g}", *cells])
    return markdown_table([label, *(f"{method}, {kind}" for method, kind in keys)], lines)


def advice(rows: list[dict]) -> str:
    """Which method to trust where, from the numbers."""
    single = {method: f"{held(rows, method, 'float32'):,.0f}" for method in METHODS}
    needles = max(worst(rows, "aspect", method, "float64", ASPECTS) for method in METHODS)
    stout_worst = {
        (method, kind): f"{worst(rows, 'size', method, kind, SIZES):.2g}"
        for method in METHODS
        for kind in TYPES
    }
    flat = f"{worst(rows, 'special', 'abbas', 'float32', ('Y2 = 1/256',)):.2g}"
    thinnest = f"{worst(rows, 'special', 'unit_triangle', 'float64', ('one sub-pixel squared',)):.2g}"
    sent = max(row["worst_grey"] for row in rows if row["method"] == WORDS[0] and row["worst_grey"])
    text = f"""
**Stout triangles** of any size, sub-pixel ones too: the unit triangle and the general solution are equally
good, at most {stout_worst["unit_triangle", "float32"]} and {stout_worst["general", "float32"]} grey levels
off in float32; take the unit triangle, it is the faster. Abbas's formulas divide by Y2 squared: they lose
{stout_worst["abbas", "float32"]} levels where Y2 is small by chance, {flat} where it is one sub-pixel, and
have no result where it is zero. In float64 that loss does not matter, only Y2 = 0 itself does; a host that
must use them orders the vertices so that |Y2| is large. The other special cases harm no method. **Needles**
harm all alike, with the square of the aspect ratio: the coefficients in X and Y are steep across the needle
and cancel along it, however they were found. Half a grey level is held in float32 up to
{single["unit_triangle"]} (unit triangle), {single["general"]} (general), {single["abbas"]} (Abbas) and
{single["x_shading"]} (X-shading, whose samples curve less) times as long as high; in float64 by every method
up to a million times ({needles:.2g} levels at most). Of an area of one sub-pixel squared nothing can be
computed this way: {thinnest} grey levels off in float64. **Trust** the unit triangle, in float64; float32
only where needles are clipped away. The host sends none of these coefficients: it sets words up on the pixel
lattice, from the first covered pixel and in integers where float64 is too short, and the bound of what it
sends was {sent:.2g} grey levels at most over all these triangles ([setup](../explanation/setup.md)).
"""
    return paragraph(text)


def report(results: dict) -> str:
    """The report's text, from nothing but the numbers of the JSON file."""
    rows = results["rows"]
    count = rows[0]["triangles"]
    return f"""
# Numerical stability of the set-up methods

Written by `{results["command"]}` (`make stability`). Most grey levels by which the
polynomial of the computed coefficients is off the exact one inside the triangle (15 points, exact
rationals), worst of {count} random triangles each; inputs are exact in float32. The relative error of the
coefficients and the medians stand in [stability.json](stability.json).

![Worst error over aspect ratio and size](stability.png)

## Which method to trust where
{advice(rows)}

## Aspect ratio
{table(rows, "aspect", ASPECTS, "length over height")}

## Size
{table(rows, "size", SIZES, "side, pixels")}

## Special cases
Triangles of about 200 pixels.

{table(rows, "special", SPECIAL, "case")}
""".lstrip()


@click.command()
@click.option("--triangles", default=24, show_default=True, help="Triangles a case.")
@click.option("--seed", default=1, show_default=True)
@output_option(REPORT)
@one_line_errors(REPORT.stem)
def main(triangles: int, seed: int, output: Path) -> None:
    """Measure the set-up methods against exact rationals."""
    command = command_line("setup_stability", triangles=triangles, seed=seed)
    results = {"command": command, "rows": sweep(triangles, seed)}
    write_report(output, report(results), results)
    plot(results["rows"], output.with_suffix(".png"))
    click.echo(advice(results["rows"]))


if __name__ == "__main__":
    main()
