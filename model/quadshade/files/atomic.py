# SPDX-License-Identifier: Apache-2.0
"""Files are written whole or not at all: beside the old one first, then moved into its place."""

from __future__ import annotations

import json
import os
import re
import sys
import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from quadshade.errors import QuadshadeError

LINKS = 40
"""So many links does the system follow."""


def _is_device(path: Path) -> bool:
    """Whether a path is a device or a pipe: something to write to, not to replace."""
    return path.exists() and not path.is_file() and not path.is_dir()


def _descriptor(path: Path) -> int | None:
    """Which of this process's open files a path as ``/dev/stdout`` stands for; None for other paths."""
    steps = 0
    while path.is_symlink() and steps < LINKS:
        if re.fullmatch(rf"/proc/{os.getpid()}(/task/[0-9]+)?/fd", os.path.realpath(path.parent)):
            return int(path.name)
        path = path.parent / os.readlink(path)
        steps += 1
    return None


def _write_descriptor(number: int, content: bytes) -> None:
    """Write where an open file stands: what was redirected to a file is neither replaced nor cut."""
    for stream in (sys.stdout, sys.stderr):
        if stream is not None:
            stream.flush()
    with os.fdopen(os.dup(number), "wb") as file:
        file.write(content)


def _can_hold_files(folder: Path) -> bool:
    """Whether a file can be made in a folder; its permissions do not say so of ``/proc``."""
    try:
        tempfile.TemporaryFile(dir=folder).close()
    except OSError:
        return False
    return True


def check_writable(*paths: Path | None, inputs: Iterable[Path] = ()) -> None:
    """
    Fail before the work, not after it: raise :class:`QuadshadeError` where a file cannot be written.

    Parameters
    ----------
    *paths : Path or None
      Files that the command will write, all different.
    inputs : iterable of Path
      Files that it reads, which it must not overwrite.
    """
    taken = {os.path.realpath(path): "is read as well" for path in inputs}
    for path in paths:
        if path is None or _descriptor(path) is not None:
            continue
        if _is_device(path) and os.access(path, os.W_OK):
            continue
        folder = path.parent
        if not folder.is_dir():
            raise QuadshadeError(f"cannot write {path}: there is no folder {folder}", "make it first")
        place = os.path.realpath(path)
        # The file is made beside the old one, which it then takes the place of.
        needed = [Path(place).parent, *([path] if path.exists() else [])]
        if (
            path.is_dir()
            or not all(os.access(one, os.W_OK) for one in needed)
            or not _can_hold_files(needed[0])
        ):
            raise QuadshadeError(f"cannot write {path}", "choose another path")
        if place in taken:
            raise QuadshadeError(f"cannot write {path}: it {taken[place]}", "choose another path")
        taken[place] = "is given for two outputs"


def write_atomically(path: Path, write: Callable[[Path], object]) -> None:
    """
    Let ``write`` fill a temporary file beside ``path``, then move it there, so that no half file remains.

    A link stays one, and the file that it points to is replaced; a device, a pipe or what is open already
    (``/dev/stdout``) is written directly.

    Parameters
    ----------
    path : Path
    write : callable
      Gets the temporary path, which has the suffix of ``path``; what it returns is not used.

    Raises
    ------
    QuadshadeError
      The file cannot be written.
    """
    temporary = None
    try:
        number = _descriptor(path)
        if number is not None or _is_device(path):
            with tempfile.TemporaryDirectory() as folder:
                filled = Path(folder) / path.name
                write(filled)
                content = filled.read_bytes()
            if number is None:
                path.write_bytes(content)
            else:
                _write_descriptor(number, content)
            return
        path = Path(os.path.realpath(path))
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.stem}.", suffix=path.suffix)
        os.close(handle)
        temporary = Path(name)
        write(temporary)
        mask = os.umask(0)
        os.umask(mask)
        temporary.chmod(0o666 & ~mask)
        temporary.replace(path)
    except OSError as error:
        raise QuadshadeError(
            f"cannot write {path}: {error.strerror or error}", "choose another path"
        ) from None
    finally:
        if temporary is not None:
            temporary.unlink(missing_ok=True)


def write_text(path: Path, text: str) -> None:
    """Write UTF-8 text atomically; raises :class:`QuadshadeError` where it cannot."""

    def write(temporary: Path) -> None:
        temporary.write_text(text, encoding="utf-8")

    write_atomically(path, write)


def write_bytes(path: Path, content: bytes) -> None:
    """Write bytes atomically; raises :class:`QuadshadeError` where it cannot."""
    write_atomically(path, lambda temporary: temporary.write_bytes(content))


def write_json(path: Path, content: Mapping[str, Any] | Sequence[Any]) -> None:
    """Write ``content`` as indented JSON, atomically; raises :class:`QuadshadeError` where it cannot."""
    write_text(path, json.dumps(content, indent=2) + "\n")
