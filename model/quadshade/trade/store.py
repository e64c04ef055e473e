# SPDX-License-Identifier: Apache-2.0
"""Points that were measured before, by a hash of all that they depend on."""

from __future__ import annotations

import hashlib
import json
import re
import shutil
import tempfile
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from quadshade.contract.formats import Formats
from quadshade.files.code_digest import code_digest
from quadshade.trade.grid import Point
from quadshade.trade.measure import Measured
from quadshade.trade.view import Stage, View

RECORD = "record.json"
PICTURES = ("picture.png", "error.png")
SCRATCH = ".half-"
KEY = re.compile(r"[\w.+-]+-[0-9a-f]{12}")
"""What :func:`point_key` gives."""

UNUSED = ("animation", "cli", "synthesis", "trade/page")
"""Folders of the package whose code no point depends on."""


def stage_digest(stage: Stage) -> str:
    """Hash of the triangles that are drawn and of their reference, wherever they came from."""
    digest = hashlib.sha256(stage.reference.tobytes())
    for values in vars(stage.projected).values():
        if isinstance(values, np.ndarray):
            digest.update(values.tobytes())
    return digest.hexdigest()


def point_key(point: Point, view: View, stage: str, base: Formats, engine: str) -> str:
    """
    Name of a point's folder: its name, and a hash of all that its results depend on.

    Parameters
    ----------
    point : Point
    view : View
      Its lights and material; the mesh and the camera are in the stage.
    stage : str
      From :func:`stage_digest`.
    base : Formats
    engine : str

    Returns
    -------
    str
    """
    parts = {
        "point": asdict(point),
        "view": view.settings(),
        "stage": stage,
        "generics": base.generics(),
        "engine": engine,
        "code": code_digest(UNUSED),
    }
    digest = hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()
    return f"{point.name}-{digest[:12]}"


def store(folder: Path, key: str, measured: Measured) -> None:
    """Write a point's record and pictures into a folder of its own, which appears when it is whole."""
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=folder, prefix=SCRATCH) as scratch:
        made = Path(scratch) / key
        made.mkdir()
        for name, content in measured.files.items():
            (made / name).write_bytes(content)
        (made / RECORD).write_text(json.dumps(measured.record, indent=1) + "\n")
        if stored(folder, key) is None:
            # What is there is damaged.
            shutil.rmtree(folder / key, ignore_errors=True)
            made.rename(folder / key)


def stored(folder: Path, key: str) -> dict[str, Any] | None:
    """The record of a point that was measured before, or None; one that is damaged counts as none."""
    try:
        record = json.loads((folder / key / RECORD).read_text())
        drawn = record["refused"] is None
    except (OSError, ValueError, TypeError, KeyError):
        return None
    return record if not drawn or all((folder / key / name).is_file() for name in PICTURES) else None


def forget_others(folder: Path, keys: set[str]) -> None:
    """
    Remove the folders of points that are not of this sweep, and what a killed run left half-written.

    What has no such name is somebody else's, and stays.
    """
    for path in folder.iterdir():
        ours = path.name.startswith(SCRATCH) or KEY.fullmatch(path.name)
        if ours and path.is_dir() and path.name not in keys:
            shutil.rmtree(path, ignore_errors=True)
