# SPDX-License-Identifier: Apache-2.0
"""
Folders that are made once: analysed libraries, netlists, compiled simulators, mapped and placed designs.

A folder's name is a hash of everything that its contents are made from, so that a change of the RTL, of an
option or of a tool makes another folder, and an old one is never out of date.
"""

from __future__ import annotations

import fcntl
import hashlib
import tempfile
from collections.abc import Callable
from pathlib import Path

DIGITS = 16
"""Of the hash that stand in a folder's name."""


def build_key(*parts: str | Path) -> str:
    """
    The name of a folder: a hash of all that it depends on.

    Parameters
    ----------
    parts : str or Path
      Text as it is; of a Path, what the file holds.

    Returns
    -------
    str
      16 hexadecimal digits.
    """
    digest = hashlib.sha256()
    for part in parts:
        content = part.read_bytes() if isinstance(part, Path) else part.encode()
        # With its length, so that no two lists of parts run together into the same bytes.
        digest.update(b"%d:" % len(content))
        digest.update(content)
    return digest.hexdigest()[:DIGITS]


def build_once(folder: Path, key: str, make: Callable[[Path], None]) -> Path:
    """
    A folder that is made once: beside its final place, and then moved there, so that none is ever half made.

    A second process that wants the same folder waits for the first one's.

    Parameters
    ----------
    folder : Path
      Where such folders are kept.
    key : str
      From :func:`build_key`.
    make : callable
      Fills the empty folder that it is given; what it raises leaves nothing behind.

    Returns
    -------
    Path
      ``folder / key``.
    """
    final = folder / key
    if final.is_dir():
        return final
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / f".{key}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not final.is_dir():
            with tempfile.TemporaryDirectory(dir=folder) as scratch:
                made = Path(scratch) / key
                made.mkdir()
                make(made)
                made.rename(final)
    return final
