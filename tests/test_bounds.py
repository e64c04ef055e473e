# SPDX-License-Identifier: Apache-2.0
"""Compiled loops do not check an index: the same commands with all loops interpreted, where numpy does."""

from __future__ import annotations

import ast
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tests.support.interpreted import COMMANDS, COMPUTED, FUSED, compute, draw

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="module")
def interpreted(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What a process of its own wrote, which compiles nothing."""
    folder = tmp_path_factory.mktemp("interpreted")
    command = [sys.executable, "-m", "tests.support.interpreted", folder]
    result = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    return folder


def test_no_index_is_out_of_bounds_and_nothing_changes(interpreted: Path, tmp_path: Path) -> None:
    draw(tmp_path)
    wrong = [name for name in COMMANDS if (tmp_path / name).read_bytes() != (interpreted / name).read_bytes()]
    assert not wrong
    compute(tmp_path)
    with np.load(tmp_path / COMPUTED) as compiled, np.load(interpreted / COMPUTED) as expected:
        assert list(compiled) == list(expected)
        for name in compiled:
            if name.startswith(FUSED):
                np.testing.assert_allclose(compiled[name], expected[name], rtol=1e-9, err_msg=name)
            else:
                np.testing.assert_array_equal(compiled[name], expected[name], err_msg=name)


def test_every_loop_was_called(interpreted: Path) -> None:
    uncalled = json.loads((interpreted / "loops.json").read_text())["uncalled"]
    assert not uncalled, "call these in tests/support/interpreted.py"


def test_an_array_one_element_short_is_noticed(interpreted: Path) -> None:
    said = json.loads((interpreted / "loops.json").read_text())["short"]
    assert "index 3 is out of bounds" in said


def test_no_compiled_loop_makes_a_record() -> None:
    """Numba frees an array while a record of it is still used: records come from outside, as arguments."""
    found, loops = [], 0
    for path in sorted((ROOT / "model").rglob("*.py")):
        for function in ast.walk(ast.parse(path.read_text())):
            if not isinstance(function, ast.FunctionDef):
                continue
            if not any("njit" in ast.unparse(decorator) for decorator in function.decorator_list):
                continue
            loops += 1
            for call in ast.walk(function):
                made = isinstance(call, ast.Call) and ast.unparse(call.func) in ("np.zeros", "np.empty")
                if made and any(isinstance(dtype, ast.Name) for dtype in call.args[1:]):
                    found.append(f"{path.name}: {function.name}: {ast.unparse(call)}")
    assert loops > 100 and not found
