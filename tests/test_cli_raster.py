# SPDX-License-Identifier: Apache-2.0
"""The command ``quadshade raster``: what it writes, and one line with exit code 2 for whatever is wrong."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from quadshade.cli.main import main
from quadshade.contract.formats import Formats
from quadshade.files.triangle_file import read_triangles
from tests.support.setup_reference import exact_quadratic, half_plane_pixels

CONTENT = {
    "width": 40,
    "height": 30,
    "channels": ["r", "g", "b"],
    "triangles": [
        {
            "vertices": [[2.25, 1.5], [35, 8.125], [12, 27.75]],
            "samples": {"r": [0, 255, 100, 20, 30, 40], "g": [10, 200, 30], "b": [7]},
            "depth": [100, 2000.5, 65535],
        },
        {
            "vertices": [[-20, 40], [50, -3], [60.5, 70]],
            "samples": {"r": [5], "g": [255, 255, 0, 0, 255, 0], "b": [0, 100, 200]},
            "depth": [0, 0, 0],
        },
    ],
}


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "triangles.json"
    path.write_text(json.dumps(CONTENT))
    return path


def quadshade(*arguments: object) -> Result:
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def raster(file: Path, *arguments: object) -> dict[str, np.ndarray]:
    output = file.with_suffix(".npz")
    result = quadshade("raster", file, "-o", output, *arguments)
    assert result.exit_code == 0, result.output
    with np.load(output) as pixels:
        return dict(pixels)


def test_pixels(file: Path) -> None:
    """The file's triangles, pixel by pixel: exact coverage, colour within half and the bound of exact."""
    pixels = raster(file)
    assert {key: value.dtype for key, value in pixels.items()} == dict.fromkeys(
        ("triangle", "x", "y", "value", "depth"), np.dtype(np.int32)
    )
    triangles = read_triangles(file, Formats())
    got = np.stack([pixels["triangle"], pixels["x"], pixels["y"]], axis=1)
    want = half_plane_pixels(triangles.vertices, 40, 30, 8)
    assert sorted(map(tuple, got.tolist())) == sorted(map(tuple, want.tolist()))
    assert pixels["value"].shape == (len(want), 3)
    for place, (triangle, x, y) in enumerate(got.tolist()):
        vertices = triangles.vertices[triangle]
        for channel in range(3):
            order = triangles.orders[triangle, channel]
            exact = exact_quadratic(vertices, triangles.samples[triangle, channel], order)
            value = min(max(float(exact(256 * x + 128, 256 * y + 128)), 0), 255)
            assert abs(pixels["value"][place, channel] - value) <= 0.5 + 1e-3
        depth = float(exact_quadratic(vertices, triangles.depth[triangle], 1)(256 * x + 128, 256 * y + 128))
        assert abs(pixels["depth"][place] - depth) <= 0.5 + 1e-1


def test_stats(file: Path, tmp_path: Path) -> None:
    pixels = raster(file, "--stats", tmp_path / "stats.json", "--generic", "stream_width=128")
    stats = json.loads((tmp_path / "stats.json").read_text())
    assert stats["engine"] == "model"
    assert stats["pixels"] == len(pixels["x"])
    assert stats["triangles"] == 2
    assert stats["words"] % 4 == 0
    assert stats["clocks"] > stats["pixels"]


def test_generics_change_clocks_not_pixels(file: Path, tmp_path: Path) -> None:
    one = raster(file, "--stats", tmp_path / "one.json")
    other = raster(file, "--stats", tmp_path / "other.json", "--generic", "stream_width=128")
    assert all(np.array_equal(one[key], other[key]) for key in one)
    clocks = [json.loads((tmp_path / name).read_text())["clocks"] for name in ("one.json", "other.json")]
    assert clocks[0] > clocks[1]


def test_fractional_stepping(file: Path) -> None:
    """Same pixels, colour off by up to a pixel's gradient."""
    centre, fractional = raster(file), raster(file, "--stepping", "fractional")
    for key in ("triangle", "x", "y"):
        assert np.array_equal(centre[key], fractional[key])
    assert (centre["value"] != fractional["value"]).any()
    assert np.abs(centre["value"] - fractional["value"]).max() < 60


def test_no_depth_no_triangles(file: Path) -> None:
    for triangles in ([], [{k: v for k, v in t.items() if k != "depth"} for t in CONTENT["triangles"]]):
        file.write_text(json.dumps(CONTENT | {"triangles": triangles}))
        pixels = raster(file)
        assert set(pixels) == {"triangle", "x", "y", "value"}
        assert pixels["value"].shape == (len(pixels["x"]), 3)


@pytest.mark.skipif(shutil.which("ghdl") is None, reason="needs GHDL")
def test_both_engines_agree(file: Path, tmp_path: Path) -> None:
    model = raster(file, "--stats", tmp_path / "model.json")
    ghdl = raster(file, "--stats", tmp_path / "ghdl.json", "--engine", "ghdl")
    assert set(model) == set(ghdl)
    assert all(np.array_equal(model[key], ghdl[key]) for key in model)
    model, ghdl = (json.loads((tmp_path / name).read_text()) for name in ("model.json", "ghdl.json"))
    assert model | {"engine": ""} == ghdl | {"engine": ""}


@pytest.mark.parametrize(
    "arguments, message",
    (
        (("nowhere.json",), "cannot read nowhere.json"),
        ((), "Missing argument"),
        (("FILE", "--engine", "gpu"), "'gpu' is not one of"),
        (("FILE", "--stepping", "half"), "'half' is not one of"),
        (("FILE", "--generic", "stream_width"), "is not name=value"),
        (("FILE", "--generic", "stream_width=33"), "generic stream_width is 33"),
        (("FILE", "--generic", "stream_width=x"), "generic stream_width is 'x'"),
        (("FILE", "--generic", "colour=1"), "no generic 'colour'"),
        (("FILE", "--generic", "num_channels=1"), "has 3 channels"),
        (("FILE", "--waves", "waves.ghw"), "waves"),
        (("FILE", "-o", "picture.png"), "give a name that ends in .npz, or --port"),
        (("FILE", "-o", "no/such/folder/pixels.npz"), "cannot write no/such/folder/pixels.npz"),
    ),
    ids=lambda v: "_".join(v) if isinstance(v, tuple) else "",
)
def test_one_line_and_exit_code_2(
    file: Path, arguments: tuple[str, ...], message: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(file.parent)
    output = () if "-o" in arguments else ("-o", "pixels.npz")
    result = quadshade("raster", *(file.name if a == "FILE" else a for a in arguments), *output)
    assert result.exit_code == 2
    assert result.stderr.startswith("quadshade: error: ")
    assert message in result.stderr
    assert result.stderr.count("\n") == 1
    assert not Path("pixels.npz").exists() and not Path("picture.png").exists()


@pytest.mark.parametrize("content", ("{", '{"width": 4}', "[]", "NaN"))
def test_bad_files(file: Path, content: str) -> None:
    file.write_text(content)
    result = quadshade("raster", file, "-o", file.with_suffix(".npz"))
    assert result.exit_code == 2
    assert result.stderr.startswith(f"quadshade: error: {file}: ")
    assert result.stderr.count("\n") == 1


def test_more_pixels_than_memory(file: Path) -> None:
    """A small file can ask for terabytes of pixels."""
    triangle = {"vertices": [[-4096, -4096], [8191, -4096], [-4096, 8191]], "samples": {"r": [1]}}
    content = {"width": 4096, "height": 4096, "channels": ["r"], "triangles": [triangle] * 2000}
    file.write_text(json.dumps(content))
    result = quadshade("raster", file, "-o", file.with_suffix(".npz"))
    assert result.exit_code == 2
    assert "too many for this machine's memory" in result.stderr
    assert result.stderr.count("\n") == 1
