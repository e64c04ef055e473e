# SPDX-License-Identifier: Apache-2.0
"""A folder for the loops that Numba compiles: without one it does not even import them."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import click

VARIABLE = "NUMBA_CACHE_DIR"
NOTICE = f"compiled loops are not kept, as no folder for them can be written; set {VARIABLE} to one"


def usual_folders() -> list[Path]:
    """Where Numba looks for a folder to write to, in its order: the user's, beside the module, at home."""
    own = os.environ.get(VARIABLE)
    home = Path(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"))
    return [*([Path(own)] if own else []), Path(__file__).parent / "__pycache__", home / "numba"]


@contextmanager
def somewhere_for_compiled_loops() -> Iterator[None]:
    """Within the block Numba has a folder that can be written; where none of its own can, one of this run."""
    if any(_is_writable(folder) for folder in usual_folders()):
        yield
        return
    before = os.environ.get(VARIABLE)
    with tempfile.TemporaryDirectory(prefix="quadshade-") as scratch:
        os.environ[VARIABLE] = scratch
        try:
            yield
            if any(Path(scratch).iterdir()):
                click.echo(f"quadshade: notice: {NOTICE}", err=True)
        finally:
            del os.environ[VARIABLE]
            if before is not None:
                os.environ[VARIABLE] = before


def _is_writable(folder: Path) -> bool:
    """Whether a file can be made there."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False
