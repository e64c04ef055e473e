# SPDX-License-Identifier: Apache-2.0
"""
Compiled loops that are stale.

Numba keeps a loop's machine code beside its module and compiles it anew where that file has changed. But the
code has the loops that it calls in it, and constants, which are other modules'.
"""

from __future__ import annotations

import os
import re
from contextlib import suppress
from pathlib import Path

_IMPORTS = re.compile(r"^\s*(?:from|import) (quadshade[\w.]*)", re.MULTILINE)


def drop_stale_loops(package: Path) -> None:
    """
    Forget kept loops of every module that imports one that has changed since, itself or by others.

    Parameters
    ----------
    package : Path
      Folder of ``quadshade``. What cannot be read or removed there stays.
    """
    with suppress(OSError):
        kept: dict[Path, list[Path]] = {}
        for index in package.glob("**/__pycache__/*.nbi"):
            source = index.parent.parent / f"{index.name.partition('.')[0]}.py"
            kept.setdefault(source, []).append(index)
        changed = {path: path.stat().st_mtime_ns for path in package.rglob("*.py")}
        indices = [index for group in kept.values() for index in group]
        if not indices or max(changed.values()) < min(index.stat().st_mtime_ns for index in indices):
            return
        imports: dict[Path, list[Path]] = {}
        for source, group in kept.items():
            newest = max((changed[path] for path in _used_by(source, package, imports)), default=0)
            for index in group:
                if index.stat().st_mtime_ns < newest or source not in changed:
                    index.unlink(missing_ok=True)
                else:
                    # Looked at: until the next change there is nothing to do.
                    os.utime(index)


def _used_by(source: Path, package: Path, imports: dict[Path, list[Path]]) -> set[Path]:
    """A module and all of the package that it imports, and that those do; ``imports`` keeps who does."""
    found: set[Path] = set()
    waiting = [source] if source.is_file() else []
    while waiting:
        path = waiting.pop()
        if path in found:
            continue
        found.add(path)
        if path not in imports:
            imports[path] = [file for name in _names(path) for file in _files(name, package)]
        waiting += imports[path]
    return found


def _names(source: Path) -> set[str]:
    """Modules and folders of the package that a module names."""
    return set(_IMPORTS.findall(source.read_text()))


def _files(name: str, package: Path) -> list[Path]:
    """The module of a name; of a folder all of it, but of the package nothing, which imports when asked."""
    path = package.parent.joinpath(*name.split("."))
    if path == package:
        return []
    return list(path.glob("*.py")) if path.is_dir() else [path.with_suffix(".py")]
