# SPDX-License-Identifier: Apache-2.0
"""Bars of a sweep's progress, for the programs that sweep."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Event, Thread

from rich.console import Console
from rich.progress import MofNCompleteColumn, Progress, TaskID, TimeElapsedColumn, TimeRemainingColumn

FIRST_SECONDS = 2.0
"""Without a terminal a line says how far the work is once it has taken so long ..."""
LINE_SECONDS = 10.0
"""... and then again after so long, if it is further."""


@contextmanager
def _lines() -> Iterator[Callable[[str, int, int], None]]:
    """Lines on stderr instead of bars, for logs."""
    ended = Event()
    now = [""]

    def tell(kind: str, done: int, total: int) -> None:
        now[0] = f"quadshade: {done} of {total} {kind} measured ..." if done < total else ""

    def say() -> None:
        said, seconds = "", FIRST_SECONDS
        while not ended.wait(seconds):
            if now[0] and now[0] != said:
                said, seconds = now[0], LINE_SECONDS
                print(said, file=sys.stderr, flush=True)

    thread = Thread(target=say, daemon=True)
    thread.start()
    try:
        yield tell
    finally:
        ended.set()
        thread.join()


@contextmanager
def progress_bars() -> Iterator[Callable[[str, int, int], None]]:
    """A bar on stderr for each kind of work where that is a terminal, else a line now and then."""
    console = Console(stderr=True)
    if not console.is_terminal:
        with _lines() as tell_lines:
            yield tell_lines
        return
    columns = (
        *Progress.get_default_columns()[:2],
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=console) as bars:
        tasks: dict[str, TaskID] = {}

        def tell(kind: str, done: int, total: int) -> None:
            if kind not in tasks:
                tasks[kind] = bars.add_task(kind)
            bars.update(tasks[kind], completed=done, total=total)

        yield tell
