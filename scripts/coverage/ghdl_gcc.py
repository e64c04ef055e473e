# SPDX-License-Identifier: Apache-2.0
"""
GHDL with gcc's code generator, the only one that counts: Debian's package, unpacked below build/.

It is not installed, because Debian's ``ghdl`` would then prefer it to the faster LLVM one everywhere.
"""

from __future__ import annotations

import os
from pathlib import Path

from quadshade.engine.build_cache import build_key, build_once
from quadshade.engine.tool_runner import announce, run_tool, tool_version
from quadshade.errors import QuadshadeError

PACKAGE = "ghdl-gcc"
COMMON = Path("/usr/lib/ghdl/src")
"""Sources of the standard packages, which all of Debian's code generators share."""


def counting_environment(root: Path) -> dict[str, str]:
    """
    This process's environment with that GHDL in front of all others.

    Parameters
    ----------
    root : Path
      Checkout of Quadshade.

    Raises
    ------
    QuadshadeError
      There is no apt-get, or it cannot fetch the package.
    """

    def make(folder: Path) -> None:
        announce(f"fetching Debian's {PACKAGE} (11 MB) and unpacking it below build/")
        try:
            run_tool(["apt-get", "download", PACKAGE], folder)
        except QuadshadeError as problem:
            raise QuadshadeError(
                f"{PACKAGE} cannot be fetched: {problem.message}", "run `apt-get update`, or use Debian 12"
            ) from None
        (archive,) = folder.glob("*.deb")
        run_tool(["dpkg-deb", "-x", archive, "."], folder)
        archive.unlink()
        (folder / "usr" / "bin" / "ghdl").symlink_to("ghdl-gcc")
        (folder / "usr" / "lib" / "ghdl" / "src").symlink_to(COMMON)

    folder = build_once(root / "build" / PACKAGE, build_key(tool_version(("ghdl",)), Path(__file__)), make)
    (compiler,) = folder.rglob("ghdl1")
    path = f"{folder / 'usr' / 'bin'}:{compiler.parent}:{os.environ['PATH']}"
    return {**os.environ, "PATH": path, "GHDL_BACKEND": "gcc"}
