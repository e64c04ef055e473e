# SPDX-License-Identifier: Apache-2.0
"""
Turning scenes in a frame time, at 1 Mbaud and 10 frames a second and at 3 Mbaud and 30, in a board's clocks.

Each frame is planned for the stricter of the two times and counted at both; some frames go bit by bit through
the board's VHDL, whose counters must agree with the count. Goes on where it was stopped. Writes
docs/reports/frame_time.md, .json and .png.
"""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Callable, Sequence
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

import click
import numpy as np

from quadshade.board import BoardSettings
from quadshade.board.frame_time import BITS_A_BYTE, packed_clocks
from quadshade.files.atomic import write_json
from quadshade.files.markdown import markdown_table
from quadshade.golden.board import BoardModel
from quadshade.link.session import Session
from quadshade.link.transport import FaultyTransport, MemoryTransport
from quadshade.packing.frame_file import state_runs
from quadshade.packing.pack import packed_writes
from quadshade.rendering.sent_picture import SentPicture
from scripts.experiments.frame_time.series import CLOCK_HZ, RATES, SIZE, Fixed, Series, board_clock
from scripts.experiments.frame_time.simulated import counted, picture_frames
from scripts.experiments.report_writer import (
    LICENCE,
    REPORTS,
    ROOT,
    command_line,
    output_option,
    paragraph,
    write_report,
)
from scripts.one_line_errors import one_line_errors

REPORT = REPORTS / "frame_time.md"
SCENES = ("sphere:690", "torus:1152", "examples/knot.glb")
KEPT = ROOT / "build" / "frame_time"
EVERY = 60
"""Frames, of which one goes through the VHDL."""
FAULTS = 1e-4
ENOUGH_ERROR = 0.3
"""Grey levels of the plan: what is left is the output's rounding, and the scene needs no more of the line."""


def drawn(series: Series, kept: Path, count: int) -> list[dict[str, Any]]:
    """Numbers of the first frames; those that are kept are not drawn again."""
    rows = [json.loads(line) for line in kept.read_text().splitlines()] if kept.is_file() else []
    if len(rows) < count:
        fixed = Fixed(*rows[0]["fixed"]) if rows else series.best_fixed()
        kept.parent.mkdir(parents=True, exist_ok=True)
        with kept.open("a") as file:
            for row in series.rows(fixed, tuple(rows)):
                rows.append(row)
                file.write(f"{json.dumps(row)}\n")
                file.flush()
                if len(rows) % 20 == 0:
                    click.echo(f"{series.scene}: {len(rows)} of {count} frames")
                if len(rows) >= count:
                    break
    return rows[:count]


def through_vhdl(pictures: Sequence[SentPicture], rate: tuple[int, int]) -> list[dict[str, Any]]:
    """What the board's VHDL counts at the deadlines of pictures of one kind of channels."""
    formats, clock = pictures[0].formats, board_clock(rate[0])
    settings = BoardSettings(formats, *SIZE, clk_frequency_hz=CLOCK_HZ, baud=rate[0])
    jobs, said, number = [], [], 0
    for packed, state, _ in pictures:
        job = partial(picture_frames, packed.words, state, formats)
        sizes = [len(frame) for frame in job(number)]
        number += len(sizes)
        jobs.append(job)
        said.append((packed_clocks(packed, state, formats, clock, sizes), len(packed.primitives)))
    period = rate[0] // BITS_A_BYTE // rate[1]
    return [
        {
            "baud": rate[0],
            "said": clocks.busy,
            "counted": counters["clocks_busy"],
            "primitives_missing": primitives - counters["primitives"],
            "damaged": sum(counters[name] for name in ("bad_cobs", "bad_crc", "overruns", "gaps")),
        }
        for (clocks, primitives), counters in zip(said, counted(settings, jobs, period), strict=True)
    ]


def on_a_bad_line(pictures: Sequence[SentPicture], rate: tuple[int, int]) -> dict[str, Any]:
    """Pictures over a line with faults to the golden model of the board: how many late, how many wrong."""
    formats, clock = pictures[0].formats, board_clock(rate[0])
    crcs, late, took = [], 0, []
    for rate_of_faults in (0.0, FAULTS):
        board = BoardModel(*SIZE, formats, CLOCK_HZ, rate[0])
        session = Session(FaultyTransport(MemoryTransport(board.feed), rate_of_faults))
        session.connect()
        found = []
        for packed, state, _ in pictures:
            clocks = packed_clocks(packed, state, formats, clock)
            before = session.statistics["bytes_sent"]
            session.clear()
            if state is not None:
                for address, run in state_runs(packed_writes(packed.words, state, formats)):
                    session.state(address, run)
            session.triangles(packed.words)
            session.flush()
            sent = session.statistics["bytes_sent"] - before
            tail = clocks.whole - clocks.line
            took.append(clock.clocks_of_bytes(sent) + tail)
            found.append(session.frame_crc())
        crcs.append(found)
    deadline = CLOCK_HZ // rate[1]
    late = sum(clocks > deadline for clocks in took[len(pictures) :])
    wrong = sum(one != other for one, other in zip(*crcs, strict=True))
    return {"frames": len(pictures), "late": late, "wrong": wrong, "resent": session.statistics["resent"]}


def on_boards(series: Series, rows: Sequence[dict[str, Any]], sample: int, faulty: int) -> dict[str, Any]:
    """A scene's frames through the VHDL, one in ``EVERY``, and the first ones on a bad line, at each rate."""
    alike = [row for row in rows if row["shading"] == rows[0]["shading"]]
    chosen = alike[::EVERY][:sample]
    vhdl, faults = [], []
    if chosen:
        sent = [series.sent(series.again(row)) for row in chosen]
        for rate in RATES:
            click.echo(f"{series.scene}: {len(sent)} frames through the VHDL at {rate[0]} baud")
            found = through_vhdl(sent, rate)
            frames = [{"scene": series.scene, "frame": row["frame"]} for row in chosen]
            vhdl += [frame | one for frame, one in zip(frames, found, strict=True)]
    if faulty:
        sent = [series.sent(series.again(row)) for row in alike[:faulty]]
        for rate in RATES:
            click.echo(f"{series.scene}: {len(sent)} frames on a bad line at {rate[0]} baud")
            faults.append({"scene": series.scene, "baud": rate[0], **on_a_bad_line(sent, rate)})
    return {"vhdl": vhdl, "faults": faults}


def kept_json(path: Path, make: Callable[[], dict[str, Any]]) -> dict[str, Any]:
    """What was measured before, else now."""
    if not path.is_file():
        path.parent.mkdir(parents=True, exist_ok=True)
        write_json(path, make())
    found: dict[str, Any] = json.loads(path.read_text())
    return found


def mean(rows: Sequence[dict[str, Any]], name: str) -> float:
    """Mean of what is known."""
    return float(np.mean([row[name] for row in rows if row[name] is not None]))


def summary(rows: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """A scene in numbers."""
    found: dict[str, Any] = {
        "scene": rows[0]["scene"],
        "frames": len(rows),
        "levers": sorted({(row["faces"], row["shading"]) for row in rows}),
        "fixed": rows[0]["fixed"],
        "changes": sum(
            (one["faces"], one["shading"]) != (two["faces"], two["shading"]) for one, two in pairwise(rows)
        ),
        "dominated": sum(row["frame_time_error"] <= row["fixed_error"] for row in rows),
    }
    found["fixed_late"] = sum(row["fixed_whole"] > CLOCK_HZ // RATES[-1][1] for row in rows)
    found["pack_errors"] = Counter(row["pack_error"] for row in rows).most_common()
    for baud, fps in RATES:
        deadline = CLOCK_HZ // fps
        found[str(baud)] = {
            "late": sum(row[f"whole_{baud}"] > deadline for row in rows),
            "most": max(row[f"whole_{baud}"] for row in rows) / deadline,
            "line": mean(rows, f"line_{baud}") / deadline,
            "line_least": min(row[f"line_{baud}"] for row in rows) / deadline,
        }
    for name in ("frame_time", "fixed", "unbudgeted"):
        found[f"{name}_error"] = mean(rows, f"{name}_error")
        found[f"{name}_flicker"] = mean(rows, f"{name}_flicker")
        found[f"{name}_flicker_most"] = max(row[f"{name}_flicker"] or 0 for row in rows)
    return found


def through(rows: Sequence[dict[str, Any]]) -> list[str]:
    """What the VHDL has counted, or who compares the model with it where no frame went through it."""
    if not rows:
        return [
            paragraph(
                """No frame of this run went through the VHDL (`--sample 0`): all times are the model's.
                `make test T=frame_time` compares its busy clocks with those that the board's VHDL counts, of
                other pictures, for equality."""
            )
        ]
    said = """Of these frames every bit goes through the board's VHDL (Verilator), UART pins included. Its
        counters are read at the deadline; *said* and *counted* are its busy clocks, by the model and by
        STATUS, and primitives that are not drawn by then are missing. For all other frames stands the
        model alone."""
    table = [
        (row["scene"], row["frame"], row["baud"], row["said"], row["counted"], row["primitives_missing"])
        for row in rows
    ]
    return [paragraph(said), markdown_table(("scene", "frame", "baud", "said", "counted", "missing"), table)]


def report(results: dict[str, Any]) -> str:
    """The report's text, from nothing but the numbers of the JSON file."""
    scenes = results["scenes"]
    times = [
        (
            row["scene"], row["frames"], f"{baud}, {fps}", row[str(baud)]["late"],
            f"{row[str(baud)]['most']:.2%}", f"{row[str(baud)]['line']:.1%}",
            f"{row[str(baud)]['line_least']:.1%}",
        )
        for row in scenes for baud, fps in RATES
    ]  # fmt: skip
    errors = [
        (
            row["scene"], "; ".join(f"{faces} triangles, {shading}" for faces, shading in row["levers"]),
            ", ".join(f"{error:g}: {count}" for error, count in row["pack_errors"]),
            f"{row['frame_time_error']:.3f}", f"{row['fixed'][0]}, {row['fixed'][1]} triangles",
            f"{row['fixed_error']:.3f}", f"{row['dominated']} of {row['frames']}",
        )
        for row in scenes
    ]  # fmt: skip
    flicker = [
        (row["scene"], *(f"{row[f'{name}_flicker']:.2f} / {row[f'{name}_flicker_most']:.2f}"
         for name in ("frame_time", "unbudgeted", "fixed")), row["changes"])
        for row in scenes
    ]  # fmt: skip
    bad = [
        (row["scene"], row["baud"], row["frames"], row["late"], row["wrong"], row["resent"])
        for row in results["faults"]
    ]
    return "\n\n".join(
        [
            LICENCE + "\n# A picture in every frame time",
            paragraph(
                f"""Written by `{results["command"]}` (`make frametime`). {results["whole"]} frames are a
                whole turn; {SIZE[0]} x {SIZE[1]} pixels, a board of {CLOCK_HZ / 1e6:g} MHz. Ten thousand
                bytes fit
                on the line in either frame time, less what the board draws on behind it; frames are planned
                for the stricter one. Times are clocks of the board, by the model in
                `model/quadshade/board/frame_time.py`; none is of the machine that wrote this."""
            ),
            "![Time, error and flicker of every frame](frame_time.png)",
            "## In time",
            paragraph(
                f"""*Longest*: from a frame's first bit until its last pixel is written, of the frame time.
                *Line*: how much of the frame time it is busy, in the mean and at least. A scene that is
                within {ENOUGH_ERROR:g} grey levels (root mean square), which is nearly all the output's
                rounding,
                needs no more of it."""
            ),
            markdown_table(
                ("scene", "frames", "baud, frames a second", "late", "longest", "line", "least"), times
            ),
            "## Through the VHDL",
            *through(results["vhdl"]),
            "## Error",
            paragraph(
                """Root mean square over the whole picture, as a board shows it, against Phong shading of all
                triangles, outlines included, in grey levels; the mean over the frames. *Words*: grey levels
                that they are packed to, and in how many frames. The fixed choice is the best shading and
                level of detail for all frames that keeps the same times in the frames that are looked at
                before; triangles that are hidden and all depth are sent, as `render` does without a frame
                time. *Better*: frames in which the fixed choice's error is not less."""
            ),
            markdown_table(
                (
                    "scene",
                    "levers of the frame time",
                    "words",
                    "error",
                    "best fixed choice",
                    "error",
                    "better",
                ),
                errors,
            ),
            "## Flicker",
            paragraph(
                """The second difference in time of every pixel's error against Phong shading, root mean
                square, mean / largest over the frames: in a frame time, without one (all triangles,
                quadratic), and with the fixed choice. As in [continuity](continuity.md), but all pixels
                count, outlines too: a level of detail with fewer triangles has other ones, which differ by
                whole pixels and move as the scene turns. Where a frame time keeps all triangles its outlines
                are those of the reference, and what flickers is that most of them have few orders; *changes*
                are frames with another level or other channels than the one before, which would pop."""
            ),
            markdown_table(("scene", "frame time", "unbudgeted", "fixed", "changes"), flicker),
            "## A bad line",
            paragraph(
                f"""Faults at {FAULTS:g} a byte both ways, to the golden model of the board. A damaged frame
                is sent again, with those behind it, so that a picture which fills its time is late; the host
                counts it, and every picture has the CRC of the undamaged line's."""
            ),
            markdown_table(("scene", "baud", "frames", "late", "wrong", "link frames sent again"), bad)
            + "\n",
        ]
    )


def plot(path: Path, rows: dict[str, list[dict[str, Any]]]) -> None:
    """Time used, error and flicker over the frames."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 8), dpi=90, layout="constrained")
    panels = figure.subplots(3, len(rows), sharex=True, squeeze=False)
    for column, (scene, own) in enumerate(rows.items()):
        numbers = [row["frame"] for row in own]
        panels[0][column].set_title(scene)
        for baud, fps in RATES:
            share = [100 * row[f"whole_{baud}"] * fps / CLOCK_HZ for row in own]
            panels[0][column].plot(numbers, share, label=f"{baud} baud, {fps} a second")
        for name in ("frame_time", "fixed", "unbudgeted"):
            label = name.replace("_", " ")
            panels[1][column].plot(numbers, [row[f"{name}_error"] for row in own], label=label)
            shaken = [math.nan if row[f"{name}_flicker"] is None else row[f"{name}_flicker"] for row in own]
            panels[2][column].plot(numbers, shaken, label=label)
        panels[2][column].set_xlabel("frame")
        for row_of in range(3):
            panels[row_of][column].grid(alpha=0.3)
            panels[row_of][column].set_ylim(bottom=0)
    for label, axes in zip(
        ("per cent of the frame time", "error (grey levels)", "flicker"), panels[:, 0], strict=True
    ):
        axes.set_ylabel(label)
        axes.legend(fontsize=8)
    figure.savefig(path, metadata={"Software": None})


@click.command(help=__doc__)
@click.option(
    "--frames", default=600, show_default=True, type=click.IntRange(3), help="Frames that are drawn."
)
@click.option(
    "--whole", default=600, show_default=True, type=click.IntRange(3), help="Frames of a whole turn."
)
@click.option(
    "--sample", default=3, show_default=True, help="Frames of a scene through the VHDL, at each rate."
)
@click.option("--faulty", default=20, show_default=True, help="Frames of a scene on a bad line.")
@click.option("--scene", "scenes", multiple=True, default=SCENES, show_default=True)
@output_option(REPORT)
@one_line_errors(REPORT.stem)
def main(frames: int, whole: int, sample: int, faulty: int, scenes: Sequence[str], output: Path) -> None:
    rows: dict[str, list[dict[str, Any]]] = {}
    boards = []
    for scene in scenes:
        series = Series(scene, whole, ahead=6)
        name = f"{scene.replace('/', '_').replace(':', '_')}_{whole}"
        rows[scene] = drawn(series, KEPT / f"{name}.jsonl", frames)
        own = KEPT / f"{name}_boards_{sample}_{faulty}.json"
        boards.append(kept_json(own, partial(on_boards, series, rows[scene], sample, faulty)))
    results = {
        "command": command_line(
            "frame_time.report", frames=frames, whole=whole, sample=sample, faulty=faulty, scene=list(scenes)
        ),
        "whole": whole,
        "scenes": [summary(rows[scene]) for scene in scenes],
        "vhdl": [row for one in boards for row in one["vhdl"]],
        "faults": [row for one in boards for row in one["faults"]],
    }
    write_report(output, report(results), results)
    plot(output.with_suffix(".png"), rows)


if __name__ == "__main__":
    main()
