# SPDX-License-Identifier: Apache-2.0
"""
Numbers that were recorded, compared with those of now: ``python -m tests.support.recorded`` records anew.

Whoever does so on purpose says in the commit why they are others.
"""

from __future__ import annotations

import importlib
import json
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import pytest

DATA = Path(__file__).resolve().parents[1] / "data"
SUBJECTS = ("setup", "adapt")
"""Of ``tests/test_*_recorded.py``, which have ``CASES`` and ``computed``."""


ADDITIONS = 1e-13
"""What another order of a processor's additions makes of a number, relative."""


def assert_near(got: Any, wanted: Any) -> None:
    """Floats up to another order of a processor's additions, all else exactly."""
    if isinstance(wanted, dict):
        assert list(got) == list(wanted)
        for name, number in wanted.items():
            assert_near(got[name], number)
    elif isinstance(wanted, list):
        assert len(got) == len(wanted)
        for one, other in zip(got, wanted, strict=True):
            assert_near(one, other)
    elif isinstance(wanted, float):
        assert got == pytest.approx(wanted, rel=ADDITIONS, abs=0, nan_ok=True)
    else:
        assert got == wanted


def assert_recorded(subject: str, name: str, numbers: dict[str, Any]) -> None:
    """The numbers of a case are those in ``tests/data``."""
    assert_near(numbers, json.loads((DATA / f"{subject}_recorded.json").read_text())[name])


def record(subject: str, cases: Iterable[str], computed: Callable[[str], dict[str, Any]]) -> None:
    """Write the numbers of all cases, each in a line."""
    lines = [f"{json.dumps(name)}: {json.dumps(computed(name))}" for name in cases]
    (DATA / f"{subject}_recorded.json").write_text("{\n" + ",\n".join(lines) + "\n}\n")


if __name__ == "__main__":
    for subject in SUBJECTS:
        tests = importlib.import_module(f"tests.test_{subject}_recorded")
        record(subject, tests.CASES, tests.computed)
