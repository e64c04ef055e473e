# SPDX-License-Identifier: Apache-2.0
"""The tutorial's design around the core: its page's commands, and its picture against the golden model."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from quadshade.contract.formats import Formats
from quadshade.contract.triangles import ScreenTriangles
from quadshade.engine import draw
from quadshade.files.triangle_file import open_triangles
from quadshade.setup.packet import pack
from quadshade.setup.triangle_setup import setup_triangles

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "tutorial" / "own_design" / "README.md"
SHOWN = ROOT / "docs" / "images" / "own_design.png"
ENLARGED = 8
GENERICS = {"coord_bits": 7, "subpixel_bits": 4, "word_width": 28, "frac_bits": 18}


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """The folder that the page's commands fill, and what they say."""
    folder = tmp_path_factory.mktemp("own_design")
    for name in ("rtl", "docs"):
        (folder / name).symlink_to(ROOT / name)
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    environment = os.environ | {"PATH": path, "PYTHONPATH": f"{ROOT / 'model'}{os.pathsep}{ROOT}"}
    blocks = re.findall(r"^```sh\n(.*?)^```", PAGE.read_text(), re.MULTILINE | re.DOTALL)
    said = ""
    for block in blocks:
        if "gtkwave" not in block:
            done = subprocess.run(
                ["/bin/bash", "-e", "-c", block],
                cwd=folder,
                env=environment,
                capture_output=True,
                text=True,
                check=False,
            )
            assert done.returncode == 0, f"{block}\n{done.stdout}{done.stderr}"
            said += done.stdout + done.stderr
    return folder / "build" / "own_design", said


def test_the_design_paints_what_the_model_draws(run: tuple[Path, str]) -> None:
    with Image.open(run[0] / "picture.ppm") as opened:
        painted = np.asarray(opened.convert("RGB"))
    triangles, formats = open_triangles(PAGE.parent / "picture.json", GENERICS)
    pixels = draw(triangles, formats, "model").pixels
    expected = np.zeros((triangles.height, triangles.width, 3), dtype=int)
    for x, y, value in zip(pixels.x, pixels.y, pixels.value, strict=True):
        expected[y, x] = value
    assert len(pixels) > 1000
    assert (painted == expected).all()
    with Image.open(SHOWN) as shown:
        enlarged = painted.repeat(ENLARGED, axis=0).repeat(ENLARGED, axis=1)
        assert (np.asarray(shown.convert("RGB")) == enlarged).all()


def test_the_page_says_what_the_commands_say(run: tuple[Path, str]) -> None:
    page, said = PAGE.read_text(), run[1]
    (words,) = re.findall(r": (\d+) words of", said)
    (cycles,) = re.findall(r"painted in (\d+) cycles", said)
    assert f"`{words} words of 2 packets for 2 triangles, 1791 pixels`" in " ".join(page.split())
    assert all(f"--generic {name}={value}" in page for name, value in GENERICS.items())
    assert f"`painted in {cycles} cycles`" in page
    triangles, formats = open_triangles(PAGE.parent / "picture.json", GENERICS)
    pixels = draw(triangles, formats, "model").pixels
    assert f"for {len(pixels)} clocks: a pixel a clock" in " ".join(page.split())
    assert f"first packet, {len_of_first_packet(triangles, formats)} words" in page


def len_of_first_packet(triangles: ScreenTriangles, formats: Formats) -> int:
    """Set-up words of the first triangle alone."""
    first = replace(
        triangles,
        vertices=triangles.vertices[:1],
        samples=triangles.samples[:1],
        orders=triangles.orders[:1],
    )
    return len(pack(setup_triangles(first, formats), formats))


def test_the_design_synthesises(run: tuple[Path, str]) -> None:
    netlist = (run[0] / "painter.v").read_text()
    assert "module painter" in netlist
    assert "raster_core" in netlist
