# SPDX-License-Identifier: Apache-2.0
"""Tiles that are drawn already, in a folder, so that a picture that was broken off goes on."""

from __future__ import annotations

import hashlib
import shutil
import zipfile
import zlib
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from quadshade.errors import QuadshadeError
from quadshade.files.atomic import write_atomically, write_json
from quadshade.files.code_digest import code_digest
from quadshade.setup.tile import Rectangle

ABOUT = "tiles.json"


class TileStore:
    """
    A folder with the pixels of each tile that is drawn.

    Parameters
    ----------
    folder : Path
      Made when the first tile is kept; it may have tiles of several pictures, each of its own content.
    is_new : bool
      Tiles from before are removed when the first picture begins: what is refused until then removes nothing.

    Raises
    ------
    QuadshadeError
      The folder is there, and holds something else.
    """

    def __init__(self, folder: Path, is_new: bool = False) -> None:
        self.folder = self._tiles = folder
        self._is_new = is_new
        if folder.exists() and not (folder / ABOUT).is_file():
            raise QuadshadeError(f"{folder} is there and holds no tiles", "move it away")

    def __fspath__(self) -> str:
        """Its folder, for who takes a path."""
        return str(self.folder)

    def begin(self, content: Iterable[bytes], planes: Sequence[str]) -> None:
        """The tiles that follow are those of a picture, said by all that it follows from."""
        if self._is_new:
            self.remove()
            self._is_new = False
        digest = hashlib.sha256(repr((planes, code_digest())).encode())
        for part in content:
            digest.update(part)
        self._tiles = self.folder / digest.hexdigest()[:32]

    def tiles(self) -> list[tuple[Rectangle, dict[str, np.ndarray]]]:
        """The tiles that are there, with their planes; one that cannot be read counts as missing."""
        found = []
        for path in sorted(self._tiles.glob("*.npz")):
            try:
                left, top, width, height = map(int, path.stem.split("_"))
                with np.load(path, allow_pickle=False) as planes:
                    found.append(
                        (Rectangle(left, top, width, height), {name: planes[name] for name in planes})
                    )
            except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile, zlib.error):
                continue
        return found

    def add(self, tile: Rectangle, planes: dict[str, np.ndarray]) -> None:
        """
        Keep a tile.

        Raises
        ------
        QuadshadeError
          It cannot be written.
        """
        try:
            self.folder.mkdir(exist_ok=True)
            if not (self.folder / ABOUT).is_file():
                write_json(self.folder / ABOUT, {"about": "tiles of a picture that is not whole yet"})
            self._tiles.mkdir(exist_ok=True)
        except OSError as error:
            raise QuadshadeError(f"cannot write {self.folder}: {error.strerror or error}") from None
        path = self._tiles / f"{'_'.join(map(str, tile))}.npz"
        write_atomically(path, lambda made: np.savez(made, allow_pickle=False, **planes))

    def remove(self) -> None:
        """Forget the tiles: the picture is written."""
        shutil.rmtree(self.folder, ignore_errors=True)
