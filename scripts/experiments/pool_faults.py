#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""
Boards that share a picture while all lines are damaged and boards are killed at random.

Each run takes some boards of different screens, with faults on every line; some of them are pulled, hang, or
begin to show other bits, each at a moment of its own. A run ends with the model's picture, or, where every
board was killed, with an error. Writes docs/reports/faults_boards.md and faults_boards.json.
"""

from __future__ import annotations

import random
import time
from contextlib import ExitStack
from functools import cache
from pathlib import Path

import click
import numpy as np

import quadshade
from quadshade.board import Board, BoardSettings
from quadshade.board.engines import ModelEngine
from quadshade.errors import QuadshadeError
from quadshade.files.markdown import markdown_table
from quadshade.rendering import Reports
from scripts.experiments.report_writer import (
    LICENCE,
    REPORTS,
    command_line,
    output_option,
    paragraph,
    write_report,
)
from scripts.one_line_errors import one_line_errors

REPORT = REPORTS / "faults_boards.md"
SCENE, PICTURE = "torus:288", (70, 50)
SCREENS = ((24, 20), (16, 32), (40, 11), (70, 9))
RATES = (0.0, 3e-4, 1e-3)
DEATHS = ("pulled", "hangs", "other bits")
MOST_SECONDS = 120.0
"""A run that takes longer counts as one that hangs."""


def doom(board: Board, death: str, after: int) -> None:
    """
    Let a simulated board come to an end.

    Parameters
    ----------
    board : Board
      Simulated by its golden model.
    death : str
      One of ``DEATHS``.
    after : int
      Bytes of its answers.
    """
    if board.simulated is None or not isinstance(board.simulated.engine, ModelEngine):
        raise QuadshadeError("the board is not the golden model", "open one with engine='model'")
    engine, left = board.simulated.engine, after
    take = engine.take

    def dying_take() -> bytes:
        nonlocal left
        data = take()
        left -= len(data)
        if left > 0:
            return data
        if death == "pulled":
            raise QuadshadeError("the board was pulled")
        if death == "other bits":
            engine.board.drawing.colour[0] ^= 1
            return data
        return b""

    engine.take = dying_take  # type: ignore[method-assign]


@cache
def expected_picture() -> np.ndarray:
    """
    (h, w, 3) uint8: the golden model's picture.

    A board draws it too: all loops are compiled before a run, which would stop boards of the same process.
    """
    settings = BoardSettings(screen_width=SCREENS[0][0], screen_height=SCREENS[0][1])
    with Board("sim", settings=settings, engine="model") as board:
        quadshade.render(SCENE, port=board, size=PICTURE)
    return quadshade.render(SCENE, engine="model", size=PICTURE).array


def run_with_faults(seed: int) -> dict:
    """
    One picture by boards that die.

    Parameters
    ----------
    seed : int

    Returns
    -------
    dict
      ``boards``, ``killed`` (how many were to be), ``deaths``, ``lost`` and ``late`` (lines that said so),
      ``rate`` of faults, ``ended`` (``picture`` or ``error``), ``wrong`` pixels, ``resent`` frames and
      ``seconds``.
    """
    expected = expected_picture()
    draw = random.Random(f"boards {seed}")
    count, rate = draw.randint(2, 4), draw.choice(RATES)
    killed = draw.randint(0, count) if draw.random() < 0.3 else draw.randint(0, count - 1)
    told: list[str] = []
    start = time.monotonic()
    with ExitStack() as stack:
        boards, deaths = [], []
        for index in range(count):
            settings = BoardSettings(screen_width=(size := draw.choice(SCREENS))[0], screen_height=size[1])
            board = Board(
                "sim",
                settings=settings,
                engine="model",
                faults=(rate, f"{seed} {index}"),
                answer_seconds=0.2,
                reconnect_seconds=0.2,
                notice=told.append,
            )
            boards.append(stack.enter_context(board))
        for board in draw.sample(boards, killed):
            deaths.append(draw.choice(DEATHS))
            doom(board, deaths[-1], draw.randint(1, 6000))
        wrong, ended = 0, "picture"
        try:
            reports = Reports(notice=told.append)
            picture = quadshade.render(SCENE, port=boards, size=PICTURE, reports=reports).array
            wrong = int((picture != expected).any(axis=2).sum())
        except QuadshadeError as error:
            ended = "error" if "tiles are missing, as no board is left" in error.message else str(error)
        resent = sum(int(board.statistics["resent"]) for board in boards)
    return {
        "seed": seed,
        "boards": count,
        "killed": killed,
        "deaths": deaths,
        "lost": sum("is lost" in text for text in told),
        "late": sum("is late" in text for text in told),
        "rate": rate,
        "ended": ended,
        "wrong": wrong,
        "resent": resent,
        "seconds": round(time.monotonic() - start, 1),
    }


def report(results: dict) -> str:
    """The report's text, from nothing but the numbers of the JSON file."""
    runs = results["runs"]
    rows = []
    for killed in sorted({run["killed"] for run in runs}):
        those = [run for run in runs if run["killed"] == killed]
        rows.append(
            (
                killed,
                len(those),
                sum(run["ended"] == "picture" for run in those),
                sum(run["ended"] == "error" for run in those),
                sum(run["wrong"] > 0 for run in those),
                sum(run["seconds"] > MOST_SECONDS for run in those),
                sum(run["lost"] + run["late"] for run in those),
                sum(run["resent"] for run in those),
            )
        )
    deaths = [death for run in runs for death in run["deaths"]]
    kinds = ", ".join(f"{deaths.count(kind)} {kind}" for kind in DEATHS)
    header = (
        "boards killed",
        "runs",
        "the model's picture",
        "said what is missing",
        "wrong pictures",
        f"over {MOST_SECONDS:.0f} s",
        "lost or late",
        "frames resent",
    )
    about = f"""
        Written by `{results["command"]}` (`make faults-boards`). {len(runs)} runs of {SCENE} at
        {PICTURE[0]}x{PICTURE[1]} on 2 to 4 simulated boards of different screens, with up to
        {max(RATES):g} faults a byte on every line. Boards die at random moments ({kinds}). A run must end
        with the model's picture, byte for byte; only where all boards are killed it may end with a line that
        says how many tiles are missing.
    """
    return f"""\
{LICENCE}
# Boards that share a picture, killed at random

{paragraph(about)}

{markdown_table(header, rows)}
"""


@click.command(help=__doc__)
@click.option("--runs", default=200, show_default=True, type=click.IntRange(1, 100_000))
@click.option("--seed", default=1, show_default=True)
@output_option(REPORT)
@one_line_errors(REPORT.stem)
def main(runs: int, seed: int, output: Path) -> None:
    rows = []
    for number in range(seed, seed + runs):
        rows.append(run_with_faults(number))
        click.echo(" ".join(f"{name}={value}" for name, value in rows[-1].items()), err=True)
    results = {"command": command_line("pool_faults", runs=runs, seed=seed), "runs": rows}
    write_report(output, report(results), results)
    click.echo(report(results))
    if any(run["wrong"] or run["ended"] not in ("picture", "error") for run in rows):
        raise QuadshadeError("a run ended with a wrong picture or an unknown error", f"see {output}")


if __name__ == "__main__":
    main()
