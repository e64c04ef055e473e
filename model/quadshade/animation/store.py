# SPDX-License-Identifier: Apache-2.0
"""Frames that are drawn already, in a folder, so that a killed animation goes on where it stopped."""

from __future__ import annotations

import hashlib
import json
import pickle
import shutil
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from quadshade.animation.motion import Motion
from quadshade.animation.record import FrameRow
from quadshade.errors import QuadshadeError
from quadshade.files.atomic import write_json
from quadshade.files.code_digest import code_digest
from quadshade.rendering.settings import RenderSettings
from quadshade.scene import Mesh

ABOUT = "animation.json"


def animation_key(settings: RenderSettings, mesh: Mesh, motion: Motion, errors: bool) -> str:
    """Hash of all that the frames depend on; a board's port and line are not among it."""
    scene = settings.of_scene(scene=mesh)
    parts = (scene.scene, scene.setup, scene.adapt, scene.style, settings.engine.engine)
    # Workers' engines draw what an engine here does.
    board = (settings.port.port is not None, settings.port.added_error, settings.port.verify)
    line = None if settings.adapt.frame_time is None else settings.port.baud
    digest = hashlib.sha256(json.dumps([motion.content(), errors, board, line, code_digest()]).encode())
    try:
        digest.update(pickle.dumps(parts))
    except (pickle.PicklingError, AttributeError, TypeError):
        # A reflectance that is a function of its own has no name; then nothing is taken from before.
        digest.update(np.random.default_rng().bytes(16))
    return digest.hexdigest()


class FrameStore:
    """
    A folder with the pixels and the figures of each frame that is drawn.

    Parameters
    ----------
    folder : Path
      Made if need be; what another animation left in it is removed.
    key : str
      From :func:`animation_key`.
    """

    def __init__(self, folder: Path, key: str) -> None:
        self.folder = folder
        try:
            about: Any = json.loads((folder / ABOUT).read_text())
        except (OSError, ValueError):
            about = None
        if folder.exists() and (not isinstance(about, dict) or "key" not in about):
            raise QuadshadeError(f"{folder} is there and holds no frames", "move it away")
        if folder.exists() and about["key"] != key:
            shutil.rmtree(folder)
        try:
            folder.mkdir(exist_ok=True)
        except OSError as error:
            raise QuadshadeError(f"cannot write {folder}: {error.strerror or error}") from None
        if not (folder / ABOUT).is_file():
            write_json(folder / ABOUT, {"key": key})

    def missing(self, frames: int) -> list[int]:
        """Frames that are not drawn yet."""
        return [number for number in range(frames) if self.row(number) is None]

    def add(self, row: FrameRow, picture: np.ndarray) -> None:
        """Keep a frame; its row is written last, so that a frame with a row is whole."""
        np.save(self._path(row.frame, "npy"), picture)
        write_json(self._path(row.frame, "json"), asdict(row))

    def row(self, number: int) -> FrameRow | None:
        """The figures of a frame, or None where it is not drawn yet."""
        try:
            return FrameRow(**json.loads(self._path(number, "json").read_text()))
        except (OSError, ValueError, TypeError):
            return None

    def picture(self, number: int) -> np.ndarray:
        """(height, width, 3) uint8 of a frame that is drawn."""
        array: np.ndarray = np.load(self._path(number, "npy"))
        return array

    def remove(self) -> None:
        """Forget the frames: the film is written."""
        shutil.rmtree(self.folder, ignore_errors=True)

    def _path(self, number: int, suffix: str) -> Path:
        return self.folder / f"{number}.{suffix}"
