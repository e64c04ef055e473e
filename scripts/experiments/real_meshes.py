# SPDX-License-Identifier: Apache-2.0
"""Real meshes for measurements: those of the package pyvista, which pip fetches at run time."""

from __future__ import annotations

import sys
import zipfile
from pathlib import Path

from quadshade.engine.tool_runner import run_to_end

PACKAGE = "pyvista"
REAL = ("airplane.ply", "ant.ply", "nut.ply")


def real_meshes(folder: Path) -> list[Path]:
    """Meshes out of the wheel that pip downloads; empty where it cannot."""
    command = [sys.executable, "-m", "pip", "download", "-q", "--no-deps", "-d", str(folder), PACKAGE]
    done = run_to_end(command, folder)
    wheels = list(folder.glob(f"{PACKAGE}-*.whl"))
    if done.returncode or not wheels:
        return []
    found = []
    with zipfile.ZipFile(wheels[0]) as wheel:
        for name in wheel.namelist():
            if Path(name).name in REAL:
                found.append(Path(wheel.extract(name, folder)))
    return sorted(found)
