# SPDX-License-Identifier: Apache-2.0
"""A picture from ROM on a monitor: the page's commands with a smaller picture, against the golden model."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
from PIL import Image

import quadshade
from tests.support.pages import blocks

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "tutorial" / "rom_monitor.md"
SHOWN = ROOT / "docs" / "images" / "rom_monitor.png"
DESIGN = ROOT / "examples" / "rom_monitor" / "rom_monitor.vhd"
SIZE, SCALE = (28, 20), 2
"""Of the picture, and of its squares on the monitor."""


def background() -> tuple[int, ...]:
    """What the design clears to; its constant is blue, green, red."""
    (value,) = re.findall(r'background : .* := x"(\w{6})"', DESIGN.read_text())
    return tuple(bytes.fromhex(value)[::-1])


def on_monitor(pixels: np.ndarray, size: tuple[int, int], scale: int) -> np.ndarray:
    """Pixels, a row of x, y and colour each, over the background in squares."""
    picture = np.full((size[1], size[0], 3), background(), dtype=np.uint8)
    for x, y, *value in pixels:
        picture[y, x] = value
    return picture.repeat(scale, axis=0).repeat(scale, axis=1)


def test_the_monitor_shows_the_models_picture(tmp_path: Path) -> None:
    for name in ("rtl", "examples"):
        (tmp_path / name).symlink_to(ROOT / name)
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    environment = os.environ | {"PATH": path, "PYTHONPATH": f"{ROOT / 'model'}{os.pathsep}{ROOT}"}
    words, simulation = (block.code for block in blocks(PAGE)[:2])
    words = words.replace("--size 160x120", f"--size {SIZE[0]}x{SIZE[1]}")
    simulation = simulation.rstrip() + f" -gcolumns={SIZE[0] * SCALE} -glines={SIZE[1] * SCALE}\n"
    done = subprocess.run(
        ["/bin/bash", "-e", "-c", words + simulation],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    said = done.stdout + done.stderr
    assert done.returncode == 0, said
    assert f"a frame of {SIZE[0] * SIZE[1] * SCALE**2} pixels" in said
    folder = tmp_path / "build" / "rom_monitor"
    pixels = np.loadtxt(folder / "picture.pixels.csv", delimiter=",", skiprows=1, dtype=np.int64)
    with Image.open(folder / "monitor.ppm") as opened:
        shown = np.asarray(opened.convert("RGB"))
    assert len(pixels) > 200
    assert np.array_equal(shown, on_monitor(pixels[:, 1:6], SIZE, SCALE))


def test_the_page_shows_what_its_words_draw() -> None:
    """The picture was captured at full size: the model draws it, from as many words as the page says."""
    picture = quadshade.render(
        "torus:288",
        size=(160, 120),
        camera="from=1,1.2,2",
        material="colour=1,0.6,0.15",
        generics={"with_depth": 0},
        engine="model",
    )
    words = picture.setup_words()
    assert f"\n{len(words.words)} of 32 bits" in PAGE.read_text()
    columns = np.column_stack([words.pixels.x, words.pixels.y, words.pixels.value])
    with Image.open(SHOWN) as opened:
        shown = np.asarray(opened.convert("RGB")).astype(int)
    # A grey level is allowed, as for every page's picture: the host's floating point may round otherwise.
    assert abs(shown - on_monitor(columns, (160, 120), 4)).max() <= 1
