#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""
How fast the simulated board draws, UART pins included, and how full its line is while set-ups stream.

Writes docs/reports/boardspeed.md and boardspeed.json.
"""

from __future__ import annotations

import time
from pathlib import Path

import click

from quadshade.board import Board, BoardSettings
from quadshade.files.markdown import markdown_table
from quadshade.scene import fit_camera, load_scene, project
from quadshade.shading.sample import sample
from scripts.experiments.report_writer import (
    LICENCE,
    REPORTS,
    command_line,
    output_option,
    write_report,
)
from scripts.one_line_errors import one_line_errors

REPORT = REPORTS / "boardspeed.md"
WANTED_RATE, WANTED_SHARE = 100, 0.95
BITS_OF_A_BYTE = 10
SHADE = {"with_shade": 1, "num_channels": 2, "num_specular": 1}


def measure(scene: str, size: tuple[int, int], rounds: int, clocks_per_bit: int) -> dict:
    """
    Draw a scene some times, all of its triangles, and ask for the picture's CRC.

    Parameters
    ----------
    scene : str
    size : two ints
    rounds : int
    clocks_per_bit : int
      Of the simulated board.

    Returns
    -------
    dict
      Of the round with the fewest seconds, and the line's clocks over all of them.
    """
    baud = 1_000_000
    settings = BoardSettings(
        screen_width=size[0], screen_height=size[1], clk_frequency_hz=clocks_per_bit * baud, baud=baud
    )
    with Board("sim", settings=settings, engine="verilator") as board:
        engine = board.simulated.engine
        mesh = load_scene(scene)
        projected = project(mesh, fit_camera(mesh), *size, board.host_formats, cull=False)
        triangles = sample(projected, "quadratic", formats=board.host_formats)
        board.draw(triangles)
        seconds, clocks, busy, sent = [], 0, 0, 0
        for _ in range(rounds):
            board.clear()
            board.session.flush()
            before, bytes_before = engine.counters(), board.session.statistics["bytes_sent"]
            start = time.perf_counter()
            board.draw(triangles)
            after = engine.counters()
            board.verify()
            seconds.append(time.perf_counter() - start)
            clocks += after["clocks"] - before["clocks"]
            busy += after["sending"] - before["sending"]
            sent += board.session.statistics["bytes_sent"] - bytes_before
        status = board.status()
    return {
        "scene": scene,
        "screen": list(size),
        "clocks_per_bit": clocks_per_bit,
        "triangles": len(triangles),
        "triangles_a_second": len(triangles) / min(seconds),
        "bytes_a_triangle": sent / rounds / len(triangles),
        "line_clocks": clocks,
        "line_busy_clocks": busy,
        "line_share": busy / clocks,
        "damaged": sum(status[name] for name in ("bad_cobs", "bad_crc", "overruns", "gaps")),
    }


def report(results: dict) -> str:
    """The report's text, from nothing but the numbers of the JSON file."""
    header = (
        "scene",
        "screen",
        "clocks a bit",
        "triangles",
        "a second",
        "bytes a triangle",
        "line busy",
        "met",
    )
    rate, share = f"≥ {WANTED_RATE} a second", f"≥ {100 * WANTED_SHARE:.0f} %"
    rows = []
    for row in results["rows"]:
        fast, full = row["triangles_a_second"] >= WANTED_RATE, row["line_share"] >= WANTED_SHARE
        rows.append(
            (
                row["scene"],
                f"{row['screen'][0]}x{row['screen'][1]}",
                row["clocks_per_bit"],
                row["triangles"],
                f"{row['triangles_a_second']:.0f}",
                f"{row['bytes_a_triangle']:.1f}",
                f"{100 * row['line_share']:.1f} %",
                f"{rate} {'met' if fast else 'MISSED'}, {share} {'met' if full else 'MISSED'}",
            )
        )
    return f"""\
{LICENCE}
# The simulated board's speed, and its line

Written by `{results["command"]}` (`make boardspeed`). The whole board in Verilator,
UART pins included, with the host's own program at the other end; all triangles, those seen from
behind too, and the CRC of the picture, which is the golden model's. *The line is busy* in the
clocks in which a byte is on its way to the board, from the first set-up word to the last
acknowledgement: drawing hides behind it.

{markdown_table(header, rows)}
"""


@click.command(help=__doc__)
@click.option("--scene", default="sphere:690", show_default=True)
@click.option("--rounds", default=3, show_default=True, type=click.IntRange(1, 100))
@output_option(REPORT)
@one_line_errors(REPORT.stem)
def main(scene: str, rounds: int, output: Path) -> None:
    rows = [measure(scene, (160, 120), rounds, clocks) for clocks in (5, 8)]
    results = {"command": command_line("board_speed", scene=scene, rounds=rounds), "rows": rows}
    write_report(output, report(results), results)
    click.echo(report(results))


if __name__ == "__main__":
    main()
