# SPDX-License-Identifier: Apache-2.0
"""
Clocks per covered pixel, measured in simulation: random triangles of five sizes, and the worst cases.

Every case is drawn with a set-up stream of 128, 64 and 32 bits, by a simulator of the RTL and by the golden
model; pixels and clocks have to agree.
Writes docs/reports/throughput.md and throughput.json.
"""

from __future__ import annotations

from pathlib import Path

import click
import numpy as np
from rich.console import Console
from rich.table import Table

from quadshade.choices import ENGINES
from quadshade.contract.formats import LINEAR, ORDER_NAMES, QUADRATIC, Formats
from quadshade.contract.triangles import ScreenTriangles
from quadshade.engine.draw import draw_words
from quadshade.engine.ghdl import draw_ghdl
from quadshade.errors import QuadshadeError
from quadshade.files.markdown import markdown_table
from quadshade.golden.compiled import draw_fast
from quadshade.setup.packet import pack
from quadshade.setup.triangle_setup import setup_triangles
from scripts.experiments.report_writer import REPORTS, command_line, output_option, write_report
from scripts.one_line_errors import one_line_errors

REPORT = REPORTS / "throughput.md"
SCREEN = 1024
BOXES = (8.1, 16.3, 32.8, 81.4, 224.6)
"""Sides of the square from which vertices are drawn, so that the means are near those of the peer's runs."""
PEER = (8.64, 4.69, 2.87, 1.75, 1.24)
"""RasterIX, linear, 60 random triangles a class of a mean of 4.85 / 19.4 / 78.9 / 490 / 3736 pixels."""
STREAM_WIDTHS = (128, 64, 32)
"""Bits of the set-up stream; 32 is the default of the core, and what the boards have."""
TARGET_WIDTH = 128
TARGETS = {LINEAR: (1.50, 1.05, 1.01, 1.002, 1.001), QUADRATIC: (2.2, 1.10, 1.01, 1.002, 1.001)}


def scene(vertices: np.ndarray, order: int, rng: np.random.Generator) -> ScreenTriangles:
    """Triangles of pixel coordinates with random colours and depth."""
    count = len(vertices)
    return ScreenTriangles(
        SCREEN,
        SCREEN,
        np.rint(vertices * 256).astype(np.int64),
        rng.uniform(0, 255, (count, 3, 6)),
        np.full((count, 3), order),
        rng.uniform(0, 65535, (count, 3)),
        ("r", "g", "b"),
    )


def random_triangles(box: float, count: int, rng: np.random.Generator) -> np.ndarray:
    """Three vertices in a square of side ``box`` somewhere on the screen."""
    centre = rng.uniform(box, SCREEN - box, (count, 1, 2))
    return centre + rng.uniform(-box / 2, box / 2, (count, 3, 2))


def needles(count: int, rng: np.random.Generator) -> np.ndarray:
    """Slivers a quarter of a pixel wide and 300 pixels long: most of their scanlines are empty."""
    top = rng.uniform(310, SCREEN - 310, (count, 1, 2))
    lean = np.stack([rng.uniform(-60, 60, count), np.full(count, 300.0)], axis=1)
    return np.concatenate([top, top + lean[:, None], top + lean[:, None] + [0.25, 0.0]], axis=1)


def single_pixels(count: int, rng: np.random.Generator) -> np.ndarray:
    """Triangles that cover exactly one pixel centre."""
    corner = rng.integers(0, SCREEN - 1, (count, 1, 2)).astype(float)
    return corner + np.array([[0.2, 0.2], [0.9, 0.3], [0.4, 0.9]])


def measure(triangles: ScreenTriangles, formats: Formats, engine: str, stall: int = 0) -> dict:
    """
    Draw with the simulator and the model.

    Parameters
    ----------
    triangles : ScreenTriangles
    formats : Formats
    engine : str
      Simulator of the RTL.
    stall : int
      The sink is not ready in every clock of this number; 0 is always ready.

    Raises
    ------
    QuadshadeError
      Simulator and model differ.
    """
    primitives = setup_triangles(triangles, formats)
    words = pack(primitives, formats)
    model = draw_fast(words, formats, stall)
    # Stalls are in the VHDL test bench only.
    drawn = draw_ghdl(words, formats, stall_period=stall) if stall else draw_words(words, formats, engine)
    same = all(
        np.array_equal(getattr(model, name), getattr(drawn, name)) for name in ("x", "y", "value", "clocks")
    )
    if not same:
        raise QuadshadeError(
            f"engine {engine} and the golden model differ", "this is a bug: please report it"
        )
    pixels = len(model.x)
    return {
        "stream_width": formats.stream_width,
        "triangles": len(triangles.vertices),
        "pixels": pixels,
        "mean_pixels": pixels / len(triangles.vertices),
        "beats": len(words) // formats.beat_words,
        "clocks": model.clocks,
        "clocks_per_pixel": model.clocks / pixels,
    }


def measure_all(engine: str, count: int, rng: np.random.Generator) -> list[dict]:
    """Every case with every stream width; the triangles of a case are the same for all widths."""
    cases = []
    for order in (LINEAR, QUADRATIC):
        for box, peer, target in zip(BOXES, PEER, TARGETS[order], strict=True):
            drawn = scene(random_triangles(box, count, rng), order, rng)
            cases.append(("random", order, drawn, 0, target, peer))
    for order in (LINEAR, QUADRATIC):
        for name, vertices, stall in (
            ("needles, a quarter pixel wide", needles(count, rng), 0),
            ("one pixel each", single_pixels(count, rng), 0),
            ("random, sink stalls one clock in four", random_triangles(BOXES[2], count, rng), 4),
        ):
            cases.append((name, order, scene(vertices, order, rng), stall, None, None))
    rows = []
    for width in STREAM_WIDTHS:
        for name, order, drawn, stall, target, peer in cases:
            formats = Formats(stream_width=width, max_order=order)
            head = {
                "case": name,
                "order": ORDER_NAMES[order],
                "target": target if width == TARGET_WIDTH else None,
                "peer": peer,
            }
            rows.append(head | measure(drawn, formats, engine, stall))
    return rows


HEADER = (
    "stream",
    "case",
    "order",
    "triangles",
    "mean pixels",
    "beats",
    "clocks",
    "clocks per pixel",
    "target",
    "RasterIX",
)


def cells(row: dict) -> tuple[str, ...]:
    """A row of the table."""
    met = row["target"] is None or row["clocks_per_pixel"] <= row["target"]
    peer = row["peer"] if row["order"] == "linear" and row["peer"] else None
    return (
        str(row["stream_width"]),
        row["case"],
        row["order"],
        str(row["triangles"]),
        f"{row['mean_pixels']:.2f}",
        str(row["beats"]),
        str(row["clocks"]),
        f"{row['clocks_per_pixel']:.4f}",
        "" if row["target"] is None else f"≤ {row['target']} {'met' if met else 'MISSED'}",
        f"{peer}" if peer else "",
    )


def report(results: dict) -> str:
    """The report's text, from nothing but the numbers of the JSON file."""
    return (
        "# Clocks per covered pixel\n\n"
        f"Written by `{results['command']}` (`make throughput`).\n"
        "RGB with depth, a set-up stream of 128, 64 and 32 bits, generics otherwise by default. The default\n"
        "stream, and that of every board, has 32 bits; the targets are those of 128. The triangles of a\n"
        "case are the same for all widths. Simulated RTL and golden model agree in every pixel and in the\n"
        "clocks, which count from the first beat accepted to the last pixel out. Triangles that cover no\n"
        "pixel centre count in the mean, but are not sent.\n\n"
        f"{markdown_table(HEADER, map(cells, results['rows']))}\n"
    )


@click.command()
@click.option(
    "--engine",
    type=click.Choice(ENGINES),
    default="verilator",
    show_default=True,
    help="Simulator of the RTL.",
)
@click.option("--triangles", default=1000, show_default=True, help="Triangles a class.")
@click.option("--seed", default=1, show_default=True)
@output_option(REPORT)
@one_line_errors(REPORT.stem)
def main(engine: str, triangles: int, seed: int, output: Path) -> None:
    """Measure clocks per covered pixel in simulation and write the table."""
    rows = measure_all(engine, triangles, np.random.default_rng(seed))
    table = Table(*HEADER)
    for row in rows:
        table.add_row(*cells(row))
    console = Console()
    console.width = max(console.width, 120)
    console.print(table)
    command = command_line("throughput", engine=engine, triangles=triangles, seed=seed)
    results = {"command": command, "rows": rows}
    write_report(output, report(results), results)


if __name__ == "__main__":
    main()
