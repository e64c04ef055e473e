#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""
Bytes on the line until the host has a board's picture, or knows its CRC; writes docs/reports/readback.md.

The golden model of a board draws every scene, and the line's bytes are counted both ways.
"""

from __future__ import annotations

from pathlib import Path

import click

import quadshade
from quadshade.board import Board, BoardSettings
from quadshade.choices import VERIFIES
from quadshade.files.markdown import markdown_table
from quadshade.rendering.settings import Reports
from scripts.experiments.report_writer import LICENCE, REPORTS, output_option, write_report
from scripts.one_line_errors import one_line_errors

REPORT = REPORTS / "readback.md"
WIDTH, HEIGHT = 320, 240
SCENES = ("sphere:690", "sphere:168", "torus:1152", "examples/part.stl", "examples/pawn.obj")
PLANES = ("colour", "depth", "edges_diagonal")
BITS_OF_A_BYTE, BAUD = 10, 1_000_000
WAYS = ("whole", "packed", "crc")
"""By a board that cannot pack, by one that can, and with ``--verify crc``."""

HEADER = ("scene", "plane", "the plane", *WAYS, "fewer, packed", *(f"{way}, ms" for way in WAYS))


def measure(scene: str, size: tuple[int, int] = (WIDTH, HEIGHT), colour_bits: int = 8) -> list[dict]:
    """
    Bytes of every plane of a scene on a board of that size: of its own, and on the line in every way.

    Of colours with fewer than eight bits, which are dithered, the picture alone.
    """
    reports = Reports(notice=lambda _: None)
    whole = colour_bits == 8
    planes = PLANES if whole else PLANES[:1]
    label = scene if whole else f"{scene}, {colour_bits} bits a colour"
    rows = {plane: {"scene": label, "plane": plane} for plane in planes}
    for way in WAYS:
        generics = {"with_edge_map": int(whole), "with_packed_read": int(way != "whole")}
        generics["colour_bits"] = colour_bits
        settings = BoardSettings(screen_width=size[0], screen_height=size[1]).with_generics(generics)
        verify = VERIFIES[way == "crc"]
        with Board("sim", settings=settings, engine="model", notice=reports.notice) as board:
            for edges in (None, "profile,inner") if whole else (None,):
                quadshade.render(scene, size=size, port=board, edges=edges, verify="crc", reports=reports)
                for plane in planes[2:] if edges else planes[:2]:
                    row, before = rows[plane], board.statistics
                    row["bytes"] = board.read_plane(plane, verify=verify).nbytes
                    after = board.statistics
                    both = [int(after[name] - before[name]) for name in ("bytes_sent", "bytes_received")]
                    row[way], row[f"{way}_ms"] = sum(both), 1000 * max(both) * BITS_OF_A_BYTE / BAUD
    return list(rows.values())


def report(rows: list[dict], size: tuple[int, int] = (WIDTH, HEIGHT)) -> str:
    """The report's text."""
    table = markdown_table(
        HEADER,
        [
            (
                row["scene"].rpartition("/")[2],
                row["plane"],
                row["bytes"],
                *(row[way] for way in WAYS),
                f"{row['whole'] / row['packed']:.1f} times",
                *(f"{row[f'{way}_ms']:.1f}" for way in WAYS),
            )
            for row in rows
        ],
    )
    return f"""\
{LICENCE}
# Bytes on the line of what is read back

Written by `make readback`; {size[0]}x{size[1]}. Each plane's own bytes; then everything on the line, both
ways: requests, answers, framing, and the STATUS that says that the board was not reset meanwhile; from a
board that sends the bytes *whole*, from one that sends them *packed* ([how](../reference/readback.md)), and
with `--verify crc`. *ms* is how long the direction with more bytes takes at 1 Mbaud.

{table}
"""


@click.command(help=__doc__)
@click.option("--scene", "scenes", multiple=True, default=SCENES, show_default=True, help="Repeatable.")
@output_option(REPORT)
@one_line_errors(REPORT.stem)
def main(scenes: tuple[str, ...], output: Path) -> None:
    rows = [row for scene in scenes for row in measure(scene)]
    text = report(rows + measure(SCENES[0], colour_bits=4))
    write_report(output, text)
    click.echo(text, nl=False)


if __name__ == "__main__":
    main()
