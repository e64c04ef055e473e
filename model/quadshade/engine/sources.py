# SPDX-License-Identifier: Apache-2.0
"""Where the RTL is: the checkout of Quadshade, and its list of files."""

from __future__ import annotations

import os
from pathlib import Path

from quadshade.errors import QuadshadeError


def repository_root() -> Path:
    """
    The checkout that holds ``rtl`` and ``sim``.

    Raises
    ------
    QuadshadeError
      The package was installed without its repository.
    """
    root = Path(os.environ.get("QUADSHADE_ROOT", Path(__file__).resolve().parents[3]))
    if not (root / "rtl" / "files.f").is_file():
        raise QuadshadeError(f"no rtl/files.f below {root}", "set QUADSHADE_ROOT to a checkout of Quadshade")
    return root


def rtl_files(root: Path) -> list[Path]:
    """Every RTL file, bottom-up, from ``rtl/files.f``."""
    lines = (root / "rtl" / "files.f").read_text().splitlines()
    return [root / line.strip() for line in lines if line.strip() and not line.startswith("#")]
