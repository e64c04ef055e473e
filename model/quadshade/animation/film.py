# SPDX-License-Identifier: Apache-2.0
"""From frames to a file that a browser plays, or a folder of numbered pictures, through Pillow."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from quadshade.errors import QuadshadeError
from quadshade.files.atomic import write_atomically
from quadshade.image import write_png

FORMATS = {".gif": "GIF", ".webp": "WEBP", ".png": "PNG", ".apng": "PNG"}
"""Suffixes of animated files, and Pillow's name of their format."""

TICKS = {"GIF": 100, "WEBP": 1000, "PNG": 1000}
"""How finely each format tells the time of a frame, a second."""

COLOURS = 256


def is_folder(path: Path) -> bool:
    """Whether an output is a folder of numbered pictures; raises :class:`QuadshadeError` for other files."""
    if path.is_dir() or not path.suffix:
        return True
    if path.suffix.lower() not in FORMATS:
        raise QuadshadeError(
            f"the output is {str(path)!r}", f"give a name in {', '.join(FORMATS)}, or a folder"
        )
    return False


def durations(frames: int, fps: float, ticks: int) -> list[int]:
    """
    Time of every frame in milliseconds, in whole ticks, so that none of them adds up.

    Parameters
    ----------
    frames : int
    fps : float
    ticks : int
      A second.
    """
    ends = [round(number * ticks / fps) for number in range(frames + 1)]
    return [max(end - start, 1) * 1000 // ticks for start, end in pairwise(ends)]


def _images(arrays: Iterable[np.ndarray], kind: str) -> Iterator[Image.Image]:
    """Frames as Pillow wants them; a GIF has a palette for each."""
    for array in arrays:
        image = Image.fromarray(array)
        if kind == "GIF":
            image = image.quantize(COLOURS, Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
        yield image


def write_film(path: Path, arrays: Iterable[np.ndarray], frames: int, fps: float) -> None:
    """
    Write an animated file, whole or not at all; it is played again and again.

    Parameters
    ----------
    path : Path
      .gif, .webp, .png or .apng.
    arrays : iterable of (height, width, 3) uint8
    frames : int
      How many there are.
    fps : float
    """
    kind = FORMATS[path.suffix.lower()]
    first, *others = _images(arrays, kind)
    options: dict[str, Any] = {"duration": durations(frames, fps, TICKS[kind]), "loop": 0}
    if kind == "WEBP":
        options |= {"lossless": True, "method": 0}
    if kind == "GIF":
        options |= {"disposal": 1, "optimize": False}
    write_atomically(
        path, lambda made: first.save(made, kind, save_all=True, append_images=others, **options)
    )


def numbered(folder: Path, frame: int, frames: int) -> Path:
    """Path of a numbered picture; names sort as the frames do."""
    return folder / f"{frame:0{max(4, len(str(frames - 1)))}d}.png"


def write_pictures(folder: Path, arrays: Iterable[np.ndarray], frames: int) -> None:
    """Write numbered PNG files into a folder that exists."""
    for number, array in enumerate(arrays):

        def write(made: Path, picture: np.ndarray = array) -> None:
            write_png(made, picture)

        write_atomically(numbered(folder, number, frames), write)
