# SPDX-License-Identifier: Apache-2.0
"""Folders that are made once: whole or not at all, by one process of several, named by all their parts."""

from __future__ import annotations

import threading
import time
from pathlib import Path

import pytest

from quadshade.engine.build_cache import build_key, build_once
from quadshade.errors import QuadshadeError


def folders(path: Path) -> list[str]:
    """What is there beside the locks."""
    return sorted(entry.name for entry in path.iterdir() if entry.suffix != ".lock")


def test_is_made_once_and_a_failure_leaves_nothing(tmp_path: Path) -> None:
    made = []

    def make(folder: Path) -> None:
        made.append(folder)
        (folder / "out").write_text("done")

    for _ in range(2):
        assert (build_once(tmp_path, "name", make) / "out").read_text() == "done"
    assert len(made) == 1

    def fail(folder: Path) -> None:
        (folder / "out").write_text("half")
        raise QuadshadeError("no")

    with pytest.raises(QuadshadeError):
        build_once(tmp_path, "other", fail)
    assert folders(tmp_path) == ["name"]
    assert build_once(tmp_path, "other", make).is_dir()


def test_who_comes_second_waits(tmp_path: Path) -> None:
    made = []

    def make(folder: Path) -> None:
        made.append(folder)
        time.sleep(0.1)

    threads = [threading.Thread(target=build_once, args=(tmp_path, "name", make)) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(made) == 1 and folders(tmp_path) == ["name"]


def test_a_key_is_of_every_part(tmp_path: Path) -> None:
    source = tmp_path / "source"
    source.write_text("b")
    lists = [("a", "b"), ("ab",), ("a", "b", ""), ("b", "a"), ("a",), ("a", "c")]
    assert len({build_key(*parts) for parts in lists}) == len(lists)
    assert build_key("a", source) == build_key("a", "b")
    source.write_text("c")
    assert build_key("a", source) == build_key("a", "c")
