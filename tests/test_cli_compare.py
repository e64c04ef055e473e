# SPDX-License-Identifier: Apache-2.0
"""``quadshade compare`` as a user sees it."""

from __future__ import annotations

import json

import numpy as np
import pytest
from click.testing import CliRunner
from PIL import Image

from quadshade.cli.main import main
from quadshade.image import write_png


@pytest.fixture
def pictures(tmp_path):
    one = np.full((16, 16, 3), 100, dtype=np.uint8)
    other = one.copy()
    other[2, 5] = (100, 90, 101)
    write_png(tmp_path / "one.png", one)
    write_png(tmp_path / "other.png", other)
    return str(tmp_path / "one.png"), str(tmp_path / "other.png")


def test_the_numbers_are_printed(pictures):
    result = CliRunner().invoke(main, ["compare", *pictures])
    assert result.exit_code == 0
    assert "PSNR           56.94 dB" in result.output
    assert "largest error  10 of 255 at 5,2" in result.output
    assert "pixels         1 of 256 differ" in result.output
    assert "identical" in CliRunner().invoke(main, ["compare", pictures[0], pictures[0]]).output


def test_json_is_valid_even_for_identical_pictures(pictures):
    numbers = json.loads(CliRunner().invoke(main, ["compare", "--json", *pictures]).output)
    assert numbers["largest_error"] == 10 and numbers["psnr"] == pytest.approx(56.94, abs=0.01)
    same = json.loads(CliRunner().invoke(main, ["compare", "--json", pictures[0], pictures[0]]).output)
    assert same["psnr"] is None and same["ssim"] == pytest.approx(1)


def test_the_heat_map_is_written(pictures, tmp_path):
    heat = tmp_path / "heat.png"
    assert CliRunner().invoke(main, ["compare", *pictures, "--heatmap", str(heat)]).exit_code == 0
    with Image.open(heat) as image:
        assert min(image.size) > 500


def test_bad_input_is_one_line_and_exit_code_two(pictures, tmp_path):
    (tmp_path / "text.png").write_text("no picture")
    (tmp_path / "cut.png").write_bytes((tmp_path / "one.png").read_bytes()[:60])
    write_png(tmp_path / "small.png", np.zeros((4, 4, 3), dtype=np.uint8))
    Image.fromarray(np.full((16, 16), 40000, dtype=np.uint16)).save(tmp_path / "deep.png")
    for arguments in (
        [pictures[0]],
        [pictures[0], "missing.png"],
        [pictures[0], str(tmp_path)],
        [pictures[0], str(tmp_path / "text.png")],
        [pictures[0], str(tmp_path / "cut.png")],
        [pictures[0], str(tmp_path / "small.png")],
        [pictures[0], str(tmp_path / "deep.png")],
        [*pictures, "--heatmap", str(tmp_path / "no" / "heat.png")],
        [*pictures, "--heatmap", str(tmp_path)],
        [*pictures, "--colour"],
    ):
        result = CliRunner().invoke(main, ["compare", *arguments])
        assert result.exit_code == 2, arguments
        assert result.stdout == ""
        assert result.stderr.startswith("quadshade: error: ") and result.stderr.count("\n") == 1
