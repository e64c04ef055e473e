# SPDX-License-Identifier: Apache-2.0
"""
What the fraction of a word costs: error over triangle size and fraction bits, measured in the golden model.

Beside it the bound that the host computes, and the rule of Abbas et al., section 5: no error if b > log2 M
with M the triangle's height plus its width. Colour is emitted in 16 bits, 8 of them taken from the fraction,
so that errors down to 1/512 of a grey level show; the words are those of 8-bit colour with b bits of
fraction.
Writes docs/reports/extremes.md, .json and .png.
"""

from __future__ import annotations

import math
import sys
from itertools import pairwise
from pathlib import Path

import click
import numpy as np

from quadshade.choices import MAX_ERROR, ROUNDINGS
from quadshade.contract.formats import QUADRATIC, Formats
from quadshade.contract.triangles import ScreenTriangles
from quadshade.engine import draw
from quadshade.files.markdown import markdown_table
from quadshade.shading.reference import interpolated
from scripts.experiments.report_writer import (
    REPORTS,
    command_line,
    output_option,
    paragraph,
    write_report,
)
from scripts.one_line_errors import one_line_errors

REPORT = REPORTS / "extremes.md"
FRACTIONS = tuple(range(8, 27, 2))
SHAPES = (
    ((0, 0), (0, 1), (1, 1)),
    ((0, 0), (1, 0), (0.5, 1)),
    ((1, 0), (0.85, 1), (0, 0.5)),
    ((0.98, 0), (1, 1), (0, 0.99)),
)
"""Right, flat-topped, leaning and nearly mirrored right triangles in a square of side 1."""
FINER = 8
"""Fraction bits that are emitted, below the whole grey level."""
FLOOR = 0.5 / (1 << FINER)
"""What the emitted value itself is off, in grey levels."""
CHANNELS = 2


def formats_of(bits: int) -> Formats:
    """Formats whose words have ``bits`` of fraction below a grey level, and room above."""
    return Formats(
        num_channels=CHANNELS,
        with_depth=0,
        word_width=max(bits + 26, 36),
        frac_bits=bits - FINER,
        value_bits=8 + FINER,
    )


def triangles_of(size: int, count: int, rng: np.random.Generator) -> ScreenTriangles:
    """Triangles of a size in pixels, every shape in turn, shaken by a sub-pixel or so, random samples."""
    unit = np.array([SHAPES[index % len(SHAPES)] for index in range(count)])
    vertices = np.rint(unit * size * 256).astype(np.int64) + rng.integers(0, 200, (count, 3, 2))
    samples = rng.uniform(0, 255, (count, CHANNELS, 6)) * (1 << FINER)
    orders = np.full((count, CHANNELS), QUADRATIC)
    names = tuple(f"c{channel}" for channel in range(CHANNELS))
    return ScreenTriangles(min(size + 1, 4096), min(size + 1, 4096), vertices, samples, orders, None, names)


def measure(size: int, count: int, seed: int) -> list[dict]:
    """Records of a size: every fraction and rounding, and dividing where the bound asks for it."""
    triangles = triangles_of(size, count, np.random.default_rng([seed, size]))
    reference, rows = None, []
    for bits in FRACTIONS:
        formats = formats_of(bits)
        for rounding in ROUNDINGS:
            for divided in (False, True):
                limit = MAX_ERROR * (1 << FINER) if divided else None
                if divided and rows[-1]["bound"] <= MAX_ERROR:
                    continue
                drawing = draw(triangles, formats, rounding=rounding, limit=limit)
                pixels = drawing.pixels
                if divided or reference is None:
                    exact = interpolated(triangles, pixels.triangle, pixels.x, pixels.y, formats)
                    reference = reference if divided else exact
                off = np.abs(pixels.value - (exact if divided else reference)) / (1 << FINER)
                rows.append(
                    {
                        "size": size,
                        "fraction": bits,
                        "rounding": rounding,
                        "divided": divided,
                        "triangles": count,
                        "channels": CHANNELS,
                        "pixels": len(pixels),
                        "worst": float(off.max()),
                        "typical": float(np.sqrt((off**2).mean())),
                        "bound": drawing.stats["bound"] / (1 << FINER),
                        "packets": drawing.stats["packets"],
                        "clocks": drawing.stats["clocks"],
                    }
                )
    return rows


def chosen(rows: list[dict], rounding: str = "joint", divided: bool = False) -> list[dict]:
    """Records of one rounding, divided or not."""
    return [row for row in rows if row["rounding"] == rounding and row["divided"] == divided]


def paper_bits(size: int) -> int:
    """Least fraction that the rule b > log2 M allows, with M = height + width (Abbas et al., section 5)."""
    return math.floor(math.log2(2 * size)) + 1


def needed(rows: list[dict], size: int, what: str, rounding: str) -> float | None:
    """Fraction at which an error falls to half a grey level, interpolated; None where all or no rows do."""
    points = [(row["fraction"], row[what]) for row in chosen(rows, rounding) if row["size"] == size]
    for (low, above), (high, below) in pairwise(points):
        if above > MAX_ERROR >= below:
            return low + (high - low) * math.log(above / MAX_ERROR) / math.log(above / below)
    return None


def error_at(rows: list[dict], size: int, bits: float, what: str, rounding: str) -> float | None:
    """An error at a fraction between two of the sweep, interpolated in its logarithm."""
    points = [(row["fraction"], row[what]) for row in chosen(rows, rounding) if row["size"] == size]
    for (low, above), (high, below) in pairwise(points):
        if low <= bits <= high:
            return above * (below / above) ** ((bits - low) / (high - low))
    return None


def gains(rows: list[dict], what: str) -> np.ndarray:
    """Bits that joint rounding gains at each size and fraction where the emitted value does not hide it."""
    pairs = zip(chosen(rows, "joint"), chosen(rows, "independent"), strict=True)
    return np.array(
        [
            math.log2(one[what] / other[what])
            for other, one in pairs
            if other["worst"] > 8 * FLOOR and one["worst"] < 64
        ]
    )


def plot(rows: list[dict], path: Path) -> None:
    """Bits needed for half a grey level over size; error over size at three fractions."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    sizes = sorted({row["size"] for row in rows})
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(12, 5), layout="constrained")
    left.plot(sizes, [paper_bits(size) for size in sizes], "k--", label="rule of the paper, b > log2 M")
    left.plot(
        sizes, [2 * math.log2(size) + 1 for size in sizes], color="grey", ls=":", label="2 log2 size + 1"
    )
    for rounding, colour in zip(ROUNDINGS, ("C0", "C3"), strict=True):
        for what, style, name in (("worst", "o-", "measured"), ("bound", "x--", "bound")):
            left.plot(
                sizes,
                [needed(rows, size, what, rounding) or math.nan for size in sizes],
                style,
                color=colour,
                label=f"{rounding}, {name}",
            )
    left.set_xscale("log", base=2)
    left.set_ylabel("fraction bits for an error of half a grey level")
    left.legend(fontsize=8)
    for bits, colour in ((12, "C1"), (16, "C2"), (22, "C0")):
        own = [row for row in chosen(rows) if row["fraction"] == bits]
        right.loglog(sizes, [row["worst"] for row in own], "o-", color=colour, label=f"{bits} bits, measured")
        right.loglog(sizes, [row["bound"] for row in own], "x--", color=colour, label=f"{bits} bits, bound")
    for rounding, style in zip(ROUNDINGS, ("k^-", "k^:"), strict=True):
        errors = [error_at(rows, size, paper_bits(size), "worst", rounding) for size in sizes]
        right.loglog(
            sizes,
            [math.nan if error is None else error for error in errors],
            style,
            label=f"the paper's bits, {rounding}, measured",
        )
    right.axhline(MAX_ERROR, color="grey", lw=1)
    right.axhline(FLOOR, color="grey", lw=1, ls=":")
    right.set_xscale("log", base=2)
    right.set_ylabel("worst error, grey levels (joint rounding)")
    right.legend(fontsize=8)
    for axis in (left, right):
        axis.set_xlabel("triangle's width and height, pixels")
        axis.grid(alpha=0.3)
    figure.savefig(path, dpi=110, metadata={"Software": None})
    pyplot.close(figure)


def number(value: float | None, bits: bool = False) -> str:
    """A table's cell."""
    return "" if value is None else f"{value:.1f}" if bits else f"{value:.3g}"


def rule_table(rows: list[dict]) -> str:
    """For every size: the rule's bits and what they cost, the bits that are needed."""
    header = (
        "size",
        "paper's b",
        "error with it, independent",
        "joint",
        "bits needed, joint: measured",
        "bound",
        "independent: measured",
        "bound",
    )
    return markdown_table(
        header,
        [
            (
                str(size),
                str(paper_bits(size)),
                *(number(error_at(rows, size, paper_bits(size), "worst", way)) for way in ROUNDINGS[::-1]),
                *(
                    number(needed(rows, size, what, way), bits=True)
                    for way in ROUNDINGS
                    for what in ("worst", "bound")
                ),
            )
            for size in sorted({row["size"] for row in rows})
        ],
    )


def error_table(rows: list[dict]) -> str:
    """Worst and typical error and the bound over size and fraction, joint rounding."""
    lines = []
    for size in sorted({row["size"] for row in rows}):
        own = [row for row in chosen(rows) if row["size"] == size]
        cells = (f"{row['worst']:.2g} / {row['typical']:.2g} / {row['bound']:.2g}" for row in own)
        lines.append((str(size), *cells))
    return markdown_table(("size", *(f"{bits} bits" for bits in FRACTIONS)), lines)


def division_table(rows: list[dict]) -> str:
    """Packets, clocks and worst error of what the host divides."""
    whole = {(row["size"], row["fraction"]): row for row in chosen(rows)}
    lines = []
    for row in chosen(rows, divided=True):
        before = whole[row["size"], row["fraction"]]
        lines.append(
            (
                f"{row['size']}",
                f"{row['fraction']}",
                f"{row['packets'] / row['triangles']:.1f}",
                f"{row['clocks'] / before['clocks'] - 1:+.2%}",
                f"{before['worst']:.3g}",
                f"{row['worst']:.3g}",
                f"{row['bound']:.3g}",
            )
        )
    header = "size", "fraction", "packets a triangle", "clocks", "error before", "error after", "bound after"
    return markdown_table(header, lines)


def report(results: dict) -> str:
    """The report's text, from nothing but the numbers of the JSON file."""
    rows = results["rows"]
    measured, bounded = (np.median(gains(rows, what)) for what in ("worst", "bound"))
    within = max(row["worst"] - FLOOR - row["bound"] for row in rows)
    sizes: dict[int, list[int]] = {}
    for row in rows:
        sizes.setdefault(row["triangles"], []).append(row["size"])
    spans = (str(min(own)) if len(set(own)) == 1 else f"{min(own)} to {max(own)}" for own in sizes.values())
    counts = ", ".join(f"{count} of {span} pixels" for count, span in zip(sizes, spans, strict=True))
    head = f"""
Written by `{results["command"]}` (`make extremes`): the golden model against the float64 quadratic at every
pixel of random triangles ({counts}), {CHANNELS} channels each, clamped to 0 … 255. Colour is emitted in
1/{1 << FINER} of a grey level, so what is measured is at most {FLOOR:.3g} larger than what the words are off.
Errors are in grey levels of 8-bit colour, before rounding to whole ones.
"""
    finding = f"""
The bound holds everywhere (largest excess over bound and emitted digit: {within:.2g} grey levels), and the
rule of Abbas et al., b > log2 M, does not: it counts one rounding a step, but the error of a second
difference grows with the square of the steps. Rounding the six words together gains {measured:.1f} bits in
the measured worst error (median over sizes and fractions, {bounded:.1f} in the bound), which is why it is the
default.
"""
    dividing = f"""
Where the bound exceeds {MAX_ERROR} grey levels the host divides the triangle
([setup](../explanation/setup.md)): the same pixels, more packets, and the clocks
compared with those of the same triangles undivided.
"""
    return "\n\n".join(
        [
            "# Error over triangle size and fraction",
            paragraph(head),
            "![Fraction needed, and error over size](extremes.png)",
            paragraph(finding),
            "## The rule and what is needed for half a grey level",
            rule_table(rows),
            "## Worst / root-mean-square error / bound, joint rounding",
            error_table(rows),
            "## Dividing",
            paragraph(dividing),
            division_table(rows) + "\n",
        ]
    )


@click.command()
@click.option("--largest", default=4096, show_default=True, help="Largest size, in pixels.")
@click.option("--triangles", default=16, show_default=True, help="Triangles a size, fewer of the large ones.")
@click.option("--seed", default=1, show_default=True)
@output_option(REPORT)
@one_line_errors(REPORT.stem)
def main(largest: int, triangles: int, seed: int, output: Path) -> None:
    """Measure the error over triangle size and fraction."""
    rows, size = [], 8
    while size <= largest:
        count = max(min(triangles, triangles * 512 * 512 // (size * size)), 2)
        rows += measure(size, count, seed)
        print(f"size {size}: {count} triangles", file=sys.stderr)
        size *= 2
    command = command_line("error_extremes", largest=largest, triangles=triangles, seed=seed)
    results = {"command": command, "rows": rows}
    write_report(output, report(results), results)
    plot(rows, output.with_suffix(".png"))


if __name__ == "__main__":
    main()
