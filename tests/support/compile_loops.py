# SPDX-License-Identifier: Apache-2.0
"""
Compile every loop, in two processes at once, before each of pytest's compiles nearly all of them for itself.

``python -m tests.support.compile_loops``; where numba's cache has them already it takes seconds.
"""

from __future__ import annotations

import multiprocessing
import tempfile
from pathlib import Path

from tests.support.interpreted import COMMANDS, compute, draw

PLANNED = tuple(name for name, words in COMMANDS.items() if "--max-error" in words or "--frame-time" in words)
"""Adaptive pictures have a good half of all loops, and few in common with the other commands."""


def planned(folder: Path) -> None:
    """Loops that choose what is sent."""
    draw(folder, PLANNED)


def others(folder: Path) -> None:
    """All but those."""
    draw(folder, [name for name in COMMANDS if name not in PLANNED])
    compute(folder)


def main() -> None:
    """Compile both parts; what fails is for the tests to say."""
    print("compiling the loops: a minute or two, once", flush=True)
    context = multiprocessing.get_context("spawn")
    with tempfile.TemporaryDirectory() as folder:
        parts = [context.Process(target=part, args=(Path(folder),)) for part in (planned, others)]
        for part in parts:
            part.start()
        for part in parts:
            part.join()


if __name__ == "__main__":
    main()
