# SPDX-License-Identifier: Apache-2.0
"""
Film ``quadshade view`` in headless Chromium, as a hand would use it: docs/images/view.gif and view.png.

It needs chromium and chromedriver, which ``make setup`` installs.
"""

from __future__ import annotations

import io
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from PIL import Image
from selenium import webdriver
from selenium.webdriver.support.wait import WebDriverWait

from quadshade.animation.film import write_film
from quadshade.files.atomic import write_atomically
from quadshade.image import write_png
from tests.support.chromium import open_chromium

IMAGES = Path(__file__).resolve().parents[1] / "docs" / "images"
SCENE = "torus:288"
WINDOW = (1180, 640)
SHRINK = 0.6
FPS = 8.0

STEPS: list[dict[str, object]] = [
    *({"yaw": 35 - 10 * step, "pitch": 28 + 3 * step} for step in range(7)),
    *({"zoom": 1 + 0.08 * step} for step in range(1, 4)),
    *({"light": True, "light_x": -0.8 + 0.25 * step, "light_y": 0.5} for step in range(7)),
    *({"exponent": exponent} for exponent in (40, 60, 90)),
    *[{"map": "error"}] * 5,
    *[{"fit": "least-squares"}] * 5,
    *[{"fit": "six-point", "max_error": 4, "map": "orders"}] * 6,
    *[{"map": "wireframe"}] * 5,
]
"""What the hand changes from frame to frame; the last ones stay for a while."""


@contextmanager
def served() -> Iterator[str]:
    """The link of a running ``quadshade view``."""
    words = [sys.executable, "-m", "quadshade", "view", SCENE, "--no-open", "--size", "320x320"]
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            yield process.stdout.readline().split()[1]
        finally:
            process.terminate()


def shot(browser: webdriver.Chrome) -> np.ndarray:
    """(h, w, 3) uint8 of the window, once the state is drawn and measured."""

    def settled(_: webdriver.Chrome) -> bool:
        asked = (
            "return document.body.dataset.drawn === JSON.stringify(state) && document.body.dataset.measured"
        )
        return browser.execute_script(asked) == "true"

    WebDriverWait(browser, 60, 0.05).until(settled)
    return np.asarray(Image.open(io.BytesIO(browser.get_screenshot_as_png())).convert("RGB"))


def main() -> None:
    """Take the pictures."""
    frames = []
    still = None
    with served() as link, open_chromium() as browser:
        browser.set_window_size(WINDOW[0], WINDOW[1] + 140)
        browser.get(link)
        shot(browser)
        for number, changes in enumerate(STEPS, 1):
            browser.execute_script("change(arguments[0])", changes)
            frame = shot(browser)[: WINDOW[1]]
            if changes.get("map") == "orders":
                still = frame
            image = Image.fromarray(frame)
            size = (round(image.width * SHRINK), round(image.height * SHRINK))
            frames.append(np.asarray(image.resize(size, Image.Resampling.LANCZOS)))
            print(f"view film: {number} of {len(STEPS)} frames", flush=True)
    assert still is not None
    write_film(IMAGES / "view.gif", frames, len(frames), FPS)
    write_atomically(IMAGES / "view.png", lambda made: write_png(made, still))
    print(f"{IMAGES / 'view.gif'}: {(IMAGES / 'view.gif').stat().st_size / 1e6:.1f} MB")


if __name__ == "__main__":
    main()
