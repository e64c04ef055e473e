# SPDX-License-Identifier: Apache-2.0
"""A picture of the page, by Chromium without a window."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from pathlib import Path

from PIL import Image

from quadshade.engine.tool_runner import run_to_end
from quadshade.errors import QuadshadeError
from quadshade.files.atomic import write_atomically

CHROMIUM = ("chromium", "chromium-browser", "google-chrome")
WIDTH, HEIGHT = 1160, 1780
TIMEOUT_SECONDS = 120


def find_chromium() -> str:
    """
    Where Chromium is: the environment's ``CHROMIUM``, or on the path.

    Raises
    ------
    QuadshadeError
      It is nowhere.
    """
    names = (os.environ["CHROMIUM"],) if os.environ.get("CHROMIUM") else CHROMIUM
    for name in names:
        found = shutil.which(name)
        if found:
            return found
    raise QuadshadeError("chromium is not installed", "run `make setup`")


def take_screenshot(page: Path, picture: Path) -> None:
    """
    Draw the top of a page into a PNG.

    Parameters
    ----------
    page : Path
      An HTML file.
    picture : Path

    Raises
    ------
    QuadshadeError
      Chromium is missing, or draws nothing.
    """
    with tempfile.TemporaryDirectory() as scratch:
        shot = Path(scratch) / "shot.png"
        command = [find_chromium(), "--headless=new", "--hide-scrollbars", "--disable-gpu"]
        # Chromium refuses to run as root in its sandbox.
        command += ["--no-sandbox"] * (os.geteuid() == 0)
        command += [f"--user-data-dir={scratch}/profile", f"--window-size={WIDTH},{HEIGHT}"]
        command += ["--virtual-time-budget=4000", f"--screenshot={shot}", page.resolve().as_uri()]
        try:
            done = run_to_end(command, Path(scratch), seconds=TIMEOUT_SECONDS)
        except subprocess.TimeoutExpired:
            raise QuadshadeError(f"chromium did not end within {TIMEOUT_SECONDS} s") from None
        if not shot.is_file():
            last = (done.stderr.strip().splitlines() or [f"exit code {done.returncode}"])[-1]
            raise QuadshadeError(f"chromium drew nothing: {last}")
        with Image.open(shot) as image:
            drawn = image.convert("RGB")
        write_atomically(picture, lambda temporary: drawn.save(temporary, format="PNG", optimize=True))
