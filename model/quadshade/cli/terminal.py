# SPDX-License-Identifier: Apache-2.0
"""What the command line says on stderr: notices, frames, statistics, and what is being done now."""

from __future__ import annotations

import sys
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from rich.console import Console
    from rich.progress import TaskID

    from quadshade.rendering.settings import Reports

QUIET_SECONDS = 2.0
"""A step that takes longer is said where there is no terminal."""

FRAMES, TILES = "drawing frames", "drawing tiles"
UNITS = {"drawing": "triangles/s", "reading": "pixels/s", FRAMES: "frames/s", TILES: "tiles/s"}


def notice(text: str) -> None:
    """Say what is not as asked."""
    click.echo(f"quadshade: notice: {text}", err=True)


def say_trace(text: str) -> None:
    """A frame, on stderr."""
    click.echo(text, err=True)


def say_statistics(figures: Mapping[str, float]) -> None:
    """What a board's line did (:attr:`quadshade.Board.statistics`), in a line."""
    seconds = max(figures["seconds"], 1e-9)
    rates = f"{figures['seconds']:.2f} s"
    if figures["triangles"]:
        rates += f", {figures['triangles'] / seconds:.0f} triangles/s"
    click.echo(
        f"quadshade: {figures['bytes_sent']} bytes sent, {figures['bytes_received']} received, "
        f"{figures['sent']} frames, {figures['resent']} resent, {figures['timeouts']} time-outs, "
        f"{figures['reconnects']} reconnects, {figures['redraws']} redraws; {rates}",
        err=True,
    )


@contextmanager
def reporting() -> Iterator[Reports]:
    """
    Reports to stderr: notices, and what is being done.

    On a terminal that is a spinner, then a bar while a board draws; elsewhere a line for a step that takes
    longer than ``QUIET_SECONDS``.
    """
    from rich.console import Console

    from quadshade.rendering.settings import Reports

    console = Console(stderr=True)
    if not console.is_terminal:
        lines = _Lines()
        try:
            yield Reports(notice, lines.step, lines.progress)
        finally:
            lines.stop()
        return
    live = _Live(console)
    try:
        yield Reports(notice, live.step, live.progress)
    finally:
        live.stop()


class _Lines:
    """A line for a step that takes long, where a spinner would fill a log."""

    def __init__(self) -> None:
        self._timer: threading.Timer | None = None
        self._text = ""

    def step(self, text: str) -> None:
        self.stop()
        self._text = text
        self._timer = threading.Timer(QUIET_SECONDS, self._say, [text])
        self._timer.daemon = True
        self._timer.start()

    def progress(self, what: str, done: float, total: float, sent: int) -> None:
        text = what if what in (FRAMES, TILES) else f"{what} on the board"
        if text != self._text:
            self.step(text)

    def stop(self) -> None:
        if self._timer is not None:
            self._timer.cancel()

    @staticmethod
    def _say(text: str) -> None:
        # Not click.echo: a timer's thread has no context of click.
        print(f"quadshade: {text} ...", file=sys.stderr, flush=True)


class _Live:
    """A spinner until a board draws, then a bar with triangles or pixels, and bytes, a second."""

    def __init__(self, console: Console) -> None:
        from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

        self._status = console.status("")
        self._bar = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            TextColumn("{task.fields[rate]}"),
            TimeElapsedColumn(),
            TimeRemainingColumn(),
            console=console,
            transient=True,
        )
        self._tasks: dict[tuple[str, float], TaskID] = {}
        self._begun: dict[TaskID, int] = {}

    def step(self, text: str) -> None:
        if not self._tasks:
            self._status.update(text)
            self._status.start()

    def progress(self, what: str, done: float, total: float, sent: int) -> None:
        self._status.stop()
        self._bar.start()
        if (what, total) not in self._tasks:
            task = self._bar.add_task(what, total=total, rate="")
            self._tasks[what, total], self._begun[task] = task, sent
        task = self._tasks[what, total]
        elapsed = max(self._bar.tasks[self._bar.task_ids.index(task)].elapsed or 0, 1e-3)
        rate = f"{done / elapsed:,.0f} {UNITS[what]}"
        if sent:
            rate += f", {(sent - self._begun[task]) / elapsed:,.0f} bytes/s"
        self._bar.update(task, completed=done, rate=rate)

    def stop(self) -> None:
        self._status.stop()
        self._bar.stop()
