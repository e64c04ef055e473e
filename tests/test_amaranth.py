# SPDX-License-Identifier: Apache-2.0
"""The core in a design of Amaranth: the guide's commands, from ROM words to pixels that are the model's."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from tests.support.pages import blocks

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "guide" / "own_design.md"
PIXELS = 1112


def test_a_design_of_amaranth_draws_the_models_pixels(tmp_path: Path) -> None:
    for name in ("rtl", "examples"):
        (tmp_path / name).symlink_to(ROOT / name)
    (block,) = (block for block in blocks(PAGE) if "painter.py" in block.code)
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    environment = os.environ | {"PATH": path, "PYTHONPATH": f"{ROOT / 'model'}{os.pathsep}{ROOT}"}
    done = subprocess.run(
        ["/bin/bash", "-e", "-o", "pipefail", "-c", block.code],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    drawn = (tmp_path / "build" / "amaranth" / "painter.csv").read_text().splitlines()
    assert len(drawn) == 1 + PIXELS
