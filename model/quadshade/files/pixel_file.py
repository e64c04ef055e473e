# SPDX-License-Identifier: Apache-2.0
"""Pixels and planes as NPZ files."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from quadshade.contract.triangles import Pixels
from quadshade.files.atomic import write_atomically


def write_arrays(path: Path, arrays: Mapping[str, np.ndarray]) -> None:
    """
    Write arrays by name as NPZ, whole or not at all.

    Raises
    ------
    QuadshadeError
      The file cannot be written.
    """

    def write(temporary: Path) -> None:
        # An open file: NumPy would append .npz to the name of another.
        with temporary.open("wb") as file:
            np.savez(file, allow_pickle=False, **arrays)

    write_atomically(path, write)


def write_pixels(path: Path, pixels: Pixels) -> None:
    """Write pixels as NPZ, all int32: ``triangle``, ``x``, ``y``, ``value``, and any ``depth``."""
    columns = {"triangle": pixels.triangle, "x": pixels.x, "y": pixels.y, "value": pixels.value}
    if pixels.depth is not None:
        columns["depth"] = pixels.depth
    write_arrays(path, {name: column.astype(np.int32) for name, column in columns.items()})
