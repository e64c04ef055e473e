# SPDX-License-Identifier: Apache-2.0
"""The files of an animation: a film or a folder, and what stands beside it."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from quadshade.animation.film import is_folder
from quadshade.errors import QuadshadeError


class Outputs(NamedTuple):
    """What an animation writes, and where it keeps its frames meanwhile."""

    film: Path
    is_folder: bool
    table: Path
    plot: Path
    frames: Path

    @classmethod
    def of(cls, path: Path) -> Outputs:
        """
        The files of an output; a folder is made.

        Raises
        ------
        QuadshadeError
          A name that is of no kind, or a folder that cannot be made.
        """
        if not is_folder(path):
            stem, frames = path.stem, path.with_name(f".{path.name}.frames")
            return cls(path, False, path.with_name(f"{stem}.csv"), path.with_name(f"{stem}_plot.png"), frames)
        try:
            path.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise QuadshadeError(f"cannot write {path}: {error.strerror or error}") from None
        return cls(path, True, path / "frames.csv", path / "plot.png", path / ".frames")

    def forget(self) -> None:
        """Remove a folder in which nothing was written."""
        if self.is_folder and not any(self.film.iterdir()):
            self.film.rmdir()
