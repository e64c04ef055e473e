# SPDX-License-Identifier: Apache-2.0
"""Compiled loops are forgotten where anything that they are made of has changed."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from quadshade.stale_loops import drop_stale_loops

SOURCES = {
    "__init__.py": "",
    "caller.py": "from quadshade.called import loop\n",
    "far.py": "def f():\n    from quadshade.caller import loop\n",
    "called.py": "from quadshade.constants import ONE\n",
    "alone.py": "import numpy\n",
    "constants/__init__.py": "from quadshade.constants.numbers import ONE\n",
    "constants/numbers.py": "ONE = 1\n",
}
LOOPS = ("caller", "far", "called", "alone")


def kept(package: Path) -> set[str]:
    return {path.name.partition(".")[0] for path in (package / "__pycache__").iterdir()}


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """Sources of second 100, loops compiled in second 200."""
    folder = tmp_path / "quadshade"
    for name, text in SOURCES.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
        os.utime(folder / name, (100, 100))
    (folder / "__pycache__").mkdir()
    for name in LOOPS:
        index = folder / "__pycache__" / f"{name}.loop-7.py311.nbi"
        index.touch()
        os.utime(index, (200, 200))
    return folder


def test_nothing_changed(package: Path) -> None:
    drop_stale_loops(package)
    assert kept(package) == set(LOOPS)


@pytest.mark.parametrize(
    ("changed", "stay"),
    [
        ("alone.py", {"caller", "far", "called"}),
        ("called.py", {"alone"}),
        ("caller.py", {"called", "alone"}),
        ("constants/numbers.py", {"alone"}),
        ("__init__.py", set(LOOPS)),
    ],
)
def test_what_uses_a_changed_module_goes(package: Path, changed: str, stay: set[str]) -> None:
    os.utime(package / changed, (300, 300))
    drop_stale_loops(package)
    assert kept(package) == stay
    # The others are of today: they are not asked again for the same change.
    assert all(path.stat().st_mtime > 300 for path in (package / "__pycache__").iterdir())


def test_a_module_that_is_gone_leaves_no_loops(package: Path) -> None:
    (package / "alone.py").unlink()
    os.utime(package / "far.py", (300, 300))
    drop_stale_loops(package)
    assert kept(package) == {"caller", "called"}


def test_a_folder_that_cannot_be_read_is_left(tmp_path: Path) -> None:
    drop_stale_loops(tmp_path / "nowhere")
