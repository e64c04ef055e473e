# SPDX-License-Identifier: Apache-2.0
"""
Pictures in a frame time on a board that takes vertices, beside the same board without: 100 MHz, 3 Mbaud.

Both are drawn by the golden model of the board, from the bytes of its line. Writes
docs/reports/frame_time_vertices.md.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

import quadshade
from quadshade.board import Board, BoardSettings
from quadshade.board.frame_time import picture_clocks
from quadshade.contract.formats import Formats
from quadshade.files.markdown import markdown_table
from quadshade.rendering.settings import Reports
from scripts.experiments.report_writer import LICENCE, REPORTS, output_option, paragraph, write_report
from scripts.one_line_errors import one_line_errors

REPORT = REPORTS / "frame_time_vertices.md"
CLOCK_HZ, BAUD, SIZE = 100_000_000, 3_000_000, (320, 240)
SCENES = ("sphere:690", "torus:288", "examples/knot.glb")
TIMES = (12.0, 1000 / 30)
QUIET = Reports(notice=lambda _: None)


def measure(scene: str, milliseconds: float, size: tuple[int, int] = SIZE) -> dict[str, Any]:
    """A scene by fields and by vertices: when all of it is complete, and its error in a frame time."""
    row: dict[str, Any] = {"scene": scene, "milliseconds": milliseconds}
    whole = quadshade.render(scene, size=size, shading="quadratic", engine="model", reports=QUIET).triangles
    for name, with_vertices in (("fields", 0), ("vertices", 1)):
        rate = {"clk_frequency_hz": CLOCK_HZ, "baud": BAUD}
        settings = BoardSettings(Formats(), *size, with_vertices=with_vertices, **rate)
        with Board("sim", settings=settings, engine="model", notice=QUIET.notice) as board:
            clocks = picture_clocks(whole, board.formats, board.clock)
            drawn = {"frame_time": milliseconds, "port": board, "reports": QUIET}
            picture = quadshade.render(scene, size=size, **drawn)
            timing = picture.stats.timing
            assert timing is not None and board.late == 0
        row[name] = {
            "whole": round(1000 * clocks.whole / CLOCK_HZ, 1),
            "faces": timing["faces"],
            "vertices": timing["vertices"],
            "words": timing["pack_error"],
            "took": round(1000 * timing["clocks_whole"] / CLOCK_HZ, 1),
            "error": round(picture.error_to("phong").rms, 3),
        }
    return row


def report(rows: list[dict[str, Any]]) -> str:
    """The report's text, from nothing but the numbers."""
    head = (
        *("scene", "packets", "all of it, ms", "frame time, ms", "takes, ms", "triangles of the level"),
        *("as vertices", "words", "error"),
    )
    cells = [
        (
            *(row["scene"], name, f"{one['whole']:g}", f"{row['milliseconds']:.3g}", f"{one['took']:g}"),
            *(str(one["faces"]), str(one["vertices"]), f"{one['words']:g}", f"{one['error']:.3f}"),
        )
        for row in rows
        for name, one in ((name, row[name]) for name in ("fields", "vertices"))
    ]
    text = f"""
        Written by `make frametime-vertices`; {SIZE[0]}x{SIZE[1]}, a board of
        {CLOCK_HZ / 1e6:g} MHz on a line of {BAUD / 1e6:g} Mbaud, without and with `vertex_unpacker`.
        *All of it*: milliseconds until every triangle in quadratic colours is drawn, words packed to 1/32
        grey level. The others are of the picture that is planned for the frame time: parts of triangles that
        go as vertices, grey levels that words are packed to, and the root mean square from Phong shading of
        all triangles, in grey levels.
        """
    last = """
        A plan gains less than the whole picture does: it fits each triangle's colours by itself, so a corner
        has other colours in each of its triangles and is sent with them, and triangles that it divides go as
        packed words. The search for a level ends where two more are worse, so a plan may also end with a
        larger error than that of fields.
        """
    return f"""\
{LICENCE}
# A frame time with vertices

{paragraph(text)}

{markdown_table(head, cells)}

{paragraph(last)}
"""


@click.command(help=__doc__)
@click.option("--scene", "scenes", multiple=True, default=SCENES, show_default=True, help="Repeatable.")
@output_option(REPORT)
@one_line_errors(REPORT.stem)
def main(scenes: tuple[str, ...], output: Path) -> None:
    rows = [measure(scene, milliseconds) for scene in scenes for milliseconds in TIMES]
    write_report(output, report(rows))
    click.echo(report(rows), nl=False)


if __name__ == "__main__":
    main()
