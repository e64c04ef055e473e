# SPDX-License-Identifier: Apache-2.0
"""``quadshade render`` as a user sees it."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys

import numpy as np
import pytest
import trimesh
from click.testing import CliRunner

from quadshade.cli.main import main
from quadshade.contract.formats import parse_generics
from quadshade.errors import QuadshadeError
from quadshade.files import atomic
from quadshade.image import read_picture
from quadshade.image.compare import psnr


def render(*arguments: str):
    return CliRunner().invoke(main, ["render", *(str(argument) for argument in arguments)])


def picture_of(path, *arguments: str) -> np.ndarray:
    result = render(*arguments, "-o", path)
    assert result.exit_code == 0, result.output
    return read_picture(path)


@pytest.mark.parametrize("shading", ["flat", "gouraud", "quadratic", "phong"])
def test_a_sphere_is_drawn_in_every_shading(tmp_path, shading):
    picture = picture_of(tmp_path / "a.png", "sphere:168", "--size", "90x70", "--shading", shading)
    assert picture.shape == (70, 90, 3)
    assert picture[0, 0].tolist() == [0, 0, 0]
    assert picture[35, 45].min() > 20
    assert picture[25, 40].mean() > picture[50, 50].mean()


def test_quadratic_is_nearer_to_phong_than_gouraud(tmp_path):
    shaded = {
        shading: picture_of(tmp_path / "a.png", "sphere:374", "--shading", shading, "--size", "128x128")
        for shading in ("gouraud", "quadratic", "phong")
    }
    assert psnr(shaded["quadratic"], shaded["phong"]) > psnr(shaded["gouraud"], shaded["phong"]) + 6


def test_phong_takes_coverage_from_every_engine(tmp_path):
    arguments = ("sphere:168", "--shading", "phong", "--size", "40x30")
    expected = picture_of(tmp_path / "model.png", *arguments)
    for engine in ("ghdl", "verilator"):
        drawn = picture_of(tmp_path / f"{engine}.png", *arguments, "--engine", engine)
        assert (drawn == expected).all()


def test_stats_hold_what_was_drawn(tmp_path):
    stats = tmp_path / "stats.json"
    result = render(
        "torus:288",
        "-o",
        tmp_path / "a.png",
        "--stats",
        stats,
        "--generic",
        "stream_width=64",
        "--size",
        "64x64",
    )
    assert result.exit_code == 0
    numbers = json.loads(stats.read_text())
    assert numbers["engine"] == "model" and numbers["scene"] == "torus:288" and numbers["faces"] == 288
    assert numbers["clocks"] >= numbers["pixels"] >= numbers["visible_pixels"] > 500
    assert numbers["generics"]["stream_width"] == 64
    assert numbers["words"] % 2 == 0
    assert not [path for path in tmp_path.iterdir() if path.name.startswith(".")]
    render("torus:288", "-o", tmp_path / "a.png", "--stats", stats, "--shading", "phong", "--size", "64x64")
    assert json.loads(stats.read_text())["clocks"] is None


def test_without_depth_the_painters_order_gives_the_same_picture(tmp_path):
    arguments = ("torus:288", "--camera", "from=1,1,2", "--size", "80x80")
    deep = picture_of(tmp_path / "deep.png", *arguments)
    flat = picture_of(tmp_path / "flat.png", *arguments, "--generic", "with_depth=0")
    assert (deep != flat).any(axis=-1).mean() < 0.01


def test_options_change_the_picture(tmp_path):
    plain = picture_of(tmp_path / "a.png", "sphere:168", "--size", "48x48")
    (tmp_path / "brdf.py").write_text(
        "def red(point, normal, to_light, to_viewer):\n    return 0 * normal + (0.5, 0, 0)\n"
    )
    red = picture_of(
        tmp_path / "a.png",
        "sphere:168",
        "--size",
        "48x48",
        "--reflectance",
        f"{tmp_path}/brdf.py:red",
        "--light",
        "dir=0,0,1",
    )
    assert red[24, 24].tolist() == [128, 0, 0]
    for change in (
        ["--light", "dir=1,0,0"],
        ["--material", "colour=1,0,0,model=phong"],
        ["--exponent", "3"],
        ["--camera", "from=1,1,1"],
        ["--background", "0.2,0.4,0.6"],
        ["--crease", "1"],
        ["--generic", "value_bits=3"],
    ):
        assert (picture_of(tmp_path / "a.png", "sphere:168", "--size", "48x48", *change) != plain).any(), (
            change
        )


def test_an_open_mesh_shows_its_inside_without_culling(tmp_path):
    path = tmp_path / "back.obj"
    path.write_text("v -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 3 2\n")
    assert not picture_of(tmp_path / "a.png", path, "--size", "32x32").any()
    assert picture_of(tmp_path / "a.png", path, "--size", "32x32", "--no-cull").any()


@pytest.mark.parametrize("suffix", ["obj", "ply", "stl", "glb"])
def test_every_mesh_file_gives_the_same_picture(tmp_path, suffix):
    shape = trimesh.creation.icosphere(subdivisions=2)
    shape.export(tmp_path / f"ball.{suffix}")
    got = picture_of(
        tmp_path / "a.png", tmp_path / f"ball.{suffix}", "--crease", "180", "--size", "64x64", "--no-cull"
    )
    exact = picture_of(tmp_path / "b.png", "icosphere:2", "--crease", "180", "--size", "64x64")
    assert psnr(got, exact) > 45


@pytest.mark.skipif(shutil.which("ghdl") is None, reason="no ghdl")
def test_the_vhdl_draws_the_models_picture_to_the_byte(tmp_path):
    path = tmp_path / "part.stl"
    trimesh.creation.annulus(0.4, 1.0, 0.7, sections=12).export(path)
    files = {}
    for engine in ("model", "ghdl"):
        files[engine] = tmp_path / f"{engine}.png", tmp_path / f"{engine}.json"
        picture, stats = files[engine]
        result = render(
            path,
            "-o",
            picture,
            "--stats",
            stats,
            "--engine",
            engine,
            "--size",
            "40x40",
            "--camera",
            "from=1,2,3",
        )
        assert result.exit_code == 0, result.output
    assert files["model"][0].read_bytes() == files["ghdl"][0].read_bytes()
    model, ghdl = (json.loads(files[engine][1].read_text()) for engine in ("model", "ghdl"))
    assert model | {"engine": "ghdl"} == ghdl


BAD_FILES = {
    "malformed.obj": b"v 1 2\nf 1 2 3\n",
    "malformed.glb": b"glTF nonsense",
    "nan.obj": b"v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
    "infinite.obj": b"v inf 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
    "empty.obj": b"",
}


@pytest.mark.parametrize(
    "arguments",
    [
        ["missing.obj"],
        ["sphere:167"],
        ["sphere:99999999"],
        ["cone:3"],
        *([name] for name in BAD_FILES),
        ["sphere:168", "--shading", "cartoon"],
        ["sphere:168", "--engine", "verilog"],
        ["sphere:168", "--size", "512"],
        ["sphere:168", "--size", "0x5"],
        ["sphere:168", "--size", "4097x4"],
        ["sphere:168", "--size", "99999999x9"],
        ["sphere:168", "--size", "40x40", "--generic", "coord_bits=5"],
        ["sphere:168", "--light", "1,1,1"],
        ["sphere:168", "--light", "dir=0,0,0"],
        ["sphere:168", "--material", "colour=red"],
        ["sphere:168", "--exponent", "-1"],
        ["sphere:168", "--exponent", "many"],
        ["sphere:168", "--exponent", "nan"],
        ["sphere:168", "--camera", "eye=1"],
        ["sphere:168", "--crease", "200"],
        ["sphere:168", "--background", "2"],
        ["sphere:168", "--reflectance", "no_such_module:f"],
        ["sphere:168", "--generic", "colour=3"],
        ["sphere:168", "--generic", "stream_width=48"],
        ["sphere:168", "--generic", "stream_width=wide"],
        ["sphere:168", "--generic", "stream_width"],
        ["sphere:168", "--generic", "num_channels=2"],
        ["sphere:168", "--generic", "max_order=1"],
        ["sphere:168", "--waves", "a.ghw"],
        *(["sphere:168", *given] for given in (["--baud", "9600"], ["--trace"], ["--pack-error", "0"])),
        ["sphere:168", "--strict", "--divide", "0.5"],
        ["sphere:168", "--style", "cartoon", "--toon", "0"],
        ["sphere:168", "--stats", "no/such/folder.json"],
        ["sphere:168", "-o", "a.jpg"],
        ["sphere:168", "-o", "no/such/folder.png"],
        ["sphere:168", "--no-such-option"],
        [],
    ],
    ids=" ".join,
)
def test_bad_input_is_one_line_and_exit_code_two(tmp_path, monkeypatch, arguments):
    monkeypatch.chdir(tmp_path)
    for name, content in BAD_FILES.items():
        (tmp_path / name).write_bytes(content)
    before = sorted(tmp_path.iterdir())
    result = render(*arguments, *([] if "-o" in arguments else ["-o", "a.png"]))
    assert result.exit_code == 2
    assert result.stderr.startswith("quadshade: error: ") and result.stderr.count("\n") == 1
    assert result.stdout == "" and "Traceback" not in result.stderr
    assert sorted(tmp_path.iterdir()) == before


def test_the_program_itself_exits_with_two_and_no_traceback():
    program = [
        sys.executable,
        "-c",
        "from quadshade.cli.main import main; main()",
        "render",
        "no.obj",
        "-o",
        "a.png",
    ]
    done = subprocess.run(program, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("quadshade: error: ") and done.stderr.count("\n") == 1


def test_help_and_version_are_there():
    for command in ([], ["render"], ["compare"], ["raster"]):
        result = CliRunner().invoke(main, [*command, "--help"])
        assert result.exit_code == 0 and "Usage:" in result.output
    assert CliRunner().invoke(main, ["--version"]).exit_code == 0
    assert CliRunner().invoke(main, ["paint"]).exit_code == 2


def test_generics_are_read():
    assert parse_generics(["stream_width=128", "FRAC_BITS= 20"]) == {
        "stream_width": 128,
        "frac_bits": 20,
    }
    for bad in (["a"], ["=3"], ["a=1", "a=2"], ["a=1.5"]):
        with pytest.raises(QuadshadeError):
            parse_generics(bad)


def test_a_failed_write_leaves_the_old_file(tmp_path):
    path = tmp_path / "kept.json"
    path.write_text("old")

    def fail(temporary):
        temporary.write_text("half")
        raise OSError(28, "No space left on device")

    with pytest.raises(QuadshadeError, match="No space left"):
        atomic.write_atomically(path, fail)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]
