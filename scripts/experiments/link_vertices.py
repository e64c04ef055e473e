#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""
Bytes of a triangle that goes as vertices, and the clocks of the unit that reads them; writes
docs/reports/link_vertices.*.

Bytes are those of full frames with COBS, header and CRC. Clocks are those that the golden model counts, which
the unit's bench compares with the VHDL's; the line beside them is one of 3 Mbaud at 100 MHz.
"""

from __future__ import annotations

import time
from pathlib import Path

import click
import numpy as np

from quadshade.choices import MAX_ERROR, PACK_ERROR
from quadshade.files.markdown import markdown_table
from quadshade.golden.unpacker_clocks import unpacking_clocks, unpacking_of
from quadshade.packing.frame_file import line_bytes
from quadshade.packing.neighbours import ordered_for_vertices
from quadshade.packing.pack import pack_primitives
from quadshade.packing.pack_vertices import choose_vertices, pack_vertices
from quadshade.scene import load_scene, parse_camera, project
from quadshade.setup.triangle_setup import setup_triangles
from scripts.experiments.link_bytes import CAMERAS, HEIGHT, WIDTH, triangles_of
from scripts.experiments.report_writer import LICENCE, REPORTS, met, output_option, paragraph, write_report
from scripts.one_line_errors import one_line_errors

REPORT = REPORTS / "link_vertices.md"
SCENES = (
    *("sphere:690", "torus:288", "torus:1152", "icosphere:4", "sphere:159x159"),
    *("examples/part.stl", "examples/pawn.obj"),
)
TARGETS = {"gouraud": 24, "quadratic": 24}
SPHERE_TARGETS = {"gouraud": 12, "quadratic": 21}
CLOCKS_A_BYTE = 10 * 100 / 3
"""Of the line: ten bits of a byte at 3 Mbaud and 100 MHz."""

REPEATS = 40
"""Of what is timed: other work on the machine makes most of them slower."""


def seconds_of(what: object) -> float:
    """Processor seconds of a call, the best of some after one."""
    assert callable(what)
    what()
    taken = []
    for _ in range(REPEATS):
        begin = time.process_time()
        what()
        taken.append(time.process_time() - begin)
    return min(taken)


def measure(scene: str, shading: str) -> dict:
    """A row: what a triangle takes on the line both ways, how long it is decoded, how long it is packed."""
    mesh = load_scene(scene)
    projected = project(mesh, parse_camera(CAMERAS["perspective"], mesh), WIDTH, HEIGHT)
    triangles, formats = triangles_of(projected, shading)
    triangles = ordered_for_vertices(triangles, formats)
    primitives = setup_triangles(triangles, formats, limit=MAX_ERROR)
    drawn = len(np.unique(primitives.triangle))
    plain = pack_primitives(primitives, formats)
    words = pack_vertices(primitives, triangles, formats).words
    chosen = choose_vertices(primitives, triangles, formats, PACK_ERROR)
    assert chosen is not None
    sizes = line_bytes(plain.words) / drawn, line_bytes(words) / drawn
    seconds = seconds_of(lambda: pack_vertices(primitives, triangles, formats))
    return {
        "scene": scene,
        "shading": shading,
        "triangles": drawn,
        "sent": int(np.count_nonzero(chosen.sent)),
        "fields": round(sizes[0], 2),
        "vertices": round(sizes[1], 2),
        "clocks": round(unpacking_clocks(unpacking_of(words, formats, True)) / drawn),
        "line": round(sizes[1] * CLOCKS_A_BYTE),
        "rate": round(drawn / seconds / 1000),
    }


def target_of(row: dict) -> str:
    """The cell of a row's target."""
    targets = SPHERE_TARGETS if row["scene"] == "sphere:690" else TARGETS
    return met(row["vertices"], targets[row["shading"]], most=True)


def report(rows: list[dict]) -> str:
    """The report's text, from nothing but the numbers."""
    head = (
        *("scene", "shading", "triangles", "as vertices", "bytes, fields", "bytes, vertices", "target"),
        *("clocks, decoding", "clocks, line", "packed, thousands a second"),
    )
    cells = [
        (
            *(row["scene"], row["shading"], str(row["triangles"]), str(row["sent"]), str(row["fields"])),
            *(str(row["vertices"]), target_of(row), str(row["clocks"]), str(row["line"]), str(row["rate"])),
        )
        for row in rows
    ]
    slower = [f"{row['scene']}, {row['shading']}" for row in rows if row["clocks"] > row["line"]]
    speed = f"Slower than the line: {'; '.join(slower)}." if slower else "No scene is slower than the line."
    first = paragraph(
        f"""
        Written by `make linkbytes`; {WIDTH}x{HEIGHT}, in perspective, with depth, packed to {PACK_ERROR:g}
        grey levels. [vertices.md](../reference/vertices.md) is the format. Everything counts for a drawn
        triangle: mean bytes on the line with COBS, header and CRC; clocks of `vertex_unpacker`, and those of
        its bytes on a line of 3 Mbaud at 100 MHz; triangles packed in a second of one core, loops warm.
        """
    )
    last = paragraph(
        f"""
        {speed} part.stl's file goes from feature to feature, and its corners at a crease have colours of
        their own: it is sent in another order, from neighbour to neighbour, and such a corner names the place
        and sends colours alone.
        """
    )
    return f"""\
{LICENCE}
# Vertices on the line

{first}

{markdown_table(head, cells)}

{last}
"""


@click.command(help=__doc__)
@click.option("--scene", "scenes", multiple=True, default=SCENES, show_default=True, help="Repeatable.")
@output_option(REPORT)
@one_line_errors(REPORT.stem)
def main(scenes: tuple[str, ...], output: Path) -> None:
    rows = [measure(scene, shading) for scene in scenes for shading in TARGETS]
    write_report(output, report(rows))
    click.echo(report(rows), nl=False)


if __name__ == "__main__":
    main()
