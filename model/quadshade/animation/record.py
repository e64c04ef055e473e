# SPDX-License-Identifier: Apache-2.0
"""What every frame took and how far it is from Phong shading: a table and a plot beside the film."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path

from quadshade.files.atomic import write_atomically
from quadshade.rendering.timing import Levers


@dataclass(frozen=True)
class FrameRow:
    """
    One frame in numbers.

    Attributes
    ----------
    frame : int
    turn, light_orbit : float
      Degrees.
    triangles : int
      Sent to the core.
    bytes : int
      Of set-up words; on a board of everything sent on the line for the frame.
    clocks : int or None
      Of the core; None for a board.
    largest_error : int or None
      Grey levels against Phong shading; None where it was not measured.
    rms_error : float or None
    faces, shading, step, pack_error : int, str, int and float, or None
      Levers of a frame time: triangles of the level of detail, kind of channels, place on its curve, grey
      levels that words are packed to.
    line_bytes, board_clocks, deadline_clocks : int or None
      What a frame takes on the line, and on the board until it is drawn, at most; and what it may take.
    late : int or None
      1 where a board missed the deadline.
    """

    frame: int
    turn: float
    light_orbit: float
    triangles: int
    bytes: int | None
    clocks: int | None
    largest_error: int | None
    rms_error: float | None
    faces: int | None = None
    shading: str | None = None
    step: int | None = None
    pack_error: float | None = None
    line_bytes: int | None = None
    board_clocks: int | None = None
    deadline_clocks: int | None = None
    late: int | None = None

    @property
    def levers(self) -> Levers | None:
        """What the frame after it begins with, in a frame time."""
        if self.faces is None or self.shading is None or self.step is None or self.pack_error is None:
            return None
        return Levers(self.faces, self.shading, self.step, self.pack_error)


def write_table(path: Path, rows: Sequence[FrameRow]) -> None:
    """Write rows as CSV, whole or not at all; what was not measured is empty."""

    def write(made: Path) -> None:
        with made.open("w", newline="") as file:
            writer = csv.DictWriter(file, [one.name for one in fields(FrameRow)], lineterminator="\n")
            writer.writeheader()
            writer.writerows(asdict(row) for row in rows)

    write_atomically(path, write)


def write_plot(path: Path, rows: Sequence[FrameRow], title: str) -> None:
    """
    Draw bytes, clocks and error over the frames.

    Parameters
    ----------
    path : Path
      PNG file.
    rows : sequence of FrameRow
    title : str
    """
    from matplotlib.figure import Figure
    from matplotlib.ticker import MaxNLocator

    curves: list[tuple[str, list[tuple[str, Sequence[float | None]]]]] = [
        ("bytes a frame", [("", [row.bytes for row in rows])]),
        ("clocks a frame", [("", [row.clocks for row in rows])]),
        (
            "clocks of the board",
            [
                ("until it is drawn", [row.board_clocks for row in rows]),
                ("frame time", [row.deadline_clocks for row in rows]),
            ],
        ),
        (
            "error (grey levels)",
            [
                ("largest", [row.largest_error for row in rows]),
                ("root mean square", [row.rms_error for row in rows]),
            ],
        ),
    ]
    curves = [(label, lines) for label, lines in curves if any(v is not None for _, vs in lines for v in vs)]
    figure = Figure(figsize=(8, 2.2 * len(curves) + 0.6), dpi=110, layout="constrained")
    figure.suptitle(title)
    numbers = [row.frame for row in rows]
    panels = figure.subplots(len(curves), 1, sharex=True, squeeze=False)[:, 0]
    for axes, (label, lines) in zip(panels, curves, strict=True):
        for name, values in lines:
            known = [(n, v) for n, v in zip(numbers, values, strict=True) if v is not None]
            axes.plot(*zip(*known, strict=True), label=name or None, marker="." if len(known) < 100 else "")
        axes.set_ylabel(label)
        axes.set_ylim(0, 1.15 * max(v for _, vs in lines for v in vs if v is not None) or 1)
        axes.grid(alpha=0.3)
        if len(lines) > 1:
            axes.legend(loc="best")
    panels[-1].set_xlabel("frame")
    panels[-1].xaxis.set_major_locator(MaxNLocator(integer=True))
    write_atomically(path, lambda made: figure.savefig(made, format="png"))
