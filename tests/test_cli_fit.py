# SPDX-License-Identifier: Apache-2.0
"""``--fit`` and pictures with nothing on them, from the command line and from Python."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

import quadshade
from quadshade.choices import FITS, SPECULAR_FITS
from quadshade.cli.main import main
from quadshade.image import read_picture


def run(*arguments: object) -> Result:
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def test_fits_are_nearer_to_phong(tmp_path: Path) -> None:
    words = ["render", "torus:288", "--size", "160x160", "--exponent", "50"]
    pictures = {}
    for fit in (*FITS, "phong"):
        path = tmp_path / f"{fit}.png"
        more = ["--shading", "phong"] if fit == "phong" else ["--fit", fit]
        result = run(*words, "-o", path, *more)
        assert result.exit_code == 0, result.output
        pictures[fit] = read_picture(path).astype(int)
    error = {fit: pictures[fit] - pictures["phong"] for fit in FITS}
    square = {fit: (error[fit] ** 2).mean() for fit in FITS}
    assert square["least-squares"] < 0.7 * square["six-point"]
    assert np.abs(error["minimax"]).max() < 0.8 * np.abs(error["six-point"]).max()
    face = quadshade.render("torus:288", size=(160, 160), exponent=50, fit="least-squares", engine="model")
    assert (face.array == pictures["least-squares"]).all()
    assert (
        face.error_to("phong").psnr
        > quadshade.render("torus:288", size=(160, 160), exponent=50, engine="model").error_to("phong").psnr
    )


FAN = [(0.0, 0.0, 0.3), *((np.cos(turn), np.sin(turn), 0.0) for turn in np.arange(200) * np.pi / 100)]
BAD = {
    "fan": (FAN, [(0, 1 + edge, 1 + (edge + 1) % 200) for edge in range(200)]),
    "one": ([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)]),
    "apart": (
        [(0, 0, 0), (1, 0, 0), (0, 1, 0), (5, 5, 0), (6, 5, 0), (5, 6, 0)],
        [(0, 1, 2), (3, 4, 5)],
    ),
    "twice": ([(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0.3)], [(0, 1, 2), (0, 1, 2), (1, 3, 2), (1, 3, 2)]),
    "no area": ([(0, 0, 0), (1, 0, 0), (2, 0, 0)], [(0, 1, 2), (0, 0, 1)]),
    "slivers": (
        [(0, 0, 0), (1, 0, 0), (0.5, 1e-9, 0), (0.5, -0.8, 0.2), (0.5, 0.4, 0)],
        [(0, 1, 2), (0, 3, 1), (1, 0, 4)],
    ),
    "vast": ([(0, 0, 0), (1e30, 0, 0), (0, 1e30, 0), (1e30, 1e30, 1e29)], [(0, 1, 2), (1, 3, 2)]),
}
"""Vertices and faces that no one models and many files have."""


@pytest.mark.parametrize("name", BAD)
def test_bad_meshes_are_drawn_by_every_fit_with_one_notice_at_most(tmp_path: Path, name: str) -> None:
    mesh, picture = tmp_path / "bad.obj", tmp_path / "out.png"
    vertices, faces = BAD[name]
    lines = ["v " + " ".join(str(float(number)) for number in vertex) for vertex in vertices]
    lines += ["f " + " ".join(str(corner + 1) for corner in face) for face in faces]
    mesh.write_text("\n".join(lines) + "\n")
    ways = [(fit, "quadratic") for fit in FITS] + [(fit, "quadratic-specular") for fit in SPECULAR_FITS]
    for fit, shading in ways:
        picture.unlink(missing_ok=True)
        words = ["render", mesh, "-o", picture, "--size", "40x30", "--no-cull", "--exponent", "50"]
        result = run(*words, "--fit", fit, "--shading", shading, "--engine", "model")
        assert result.exit_code == 0, result.output
        assert picture.exists() and result.output.count("notice: fit:") <= 1


@pytest.mark.parametrize("fit", ["least-squares", "c1"])
def test_a_fit_goes_to_a_board_and_into_a_packed_picture(tmp_path: Path, fit: str) -> None:
    settings = {"size": (32, 24), "fit": fit}
    model = quadshade.render("torus:288", engine="model", **settings)
    with quadshade.Board("sim", engine="model") as board:
        drawn = quadshade.render("torus:288", port=board, pack_error=0.0, **settings)
    assert (drawn.array == model.array).all()
    six, fitted = tmp_path / "six.qs", tmp_path / "fitted.qs"
    assert run("pack", "torus:288", "-o", six, "--size", "64x48").exit_code == 0
    assert run("pack", "torus:288", "-o", fitted, "--size", "64x48", "--fit", fit).exit_code == 0
    assert six.read_bytes() != fitted.read_bytes()


def test_parts_are_drawn_by_the_vhdl_as_by_the_model() -> None:
    pictures = [
        quadshade.render("sphere:30", size=(40, 32), exponent=50, fit="c1", jump=0.1, engine=engine)
        for engine in ("model", "ghdl")
    ]
    assert len(pictures[0].triangles) > 30
    assert (pictures[0].array == pictures[1].array).all()
    assert pictures[0].stats.clocks == pictures[1].stats.clocks
    assert (pictures[0].depth == pictures[1].depth).all()


def test_parts_of_supersampled_pictures_cover_what_their_triangles_do() -> None:
    settings = {"size": (96, 72), "supersample": 4, "material": "colour=1,1,1,d=1", "engine": "model"}
    six, parts = (quadshade.render("cube:2", fit=fit, **settings).array for fit in ("six-point", "c1"))
    # Where a part would let the ground through, or hide another one, it would be a step of many levels.
    assert np.abs(six.astype(int) - parts).max() <= 3


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--fit", "minimax", "--shading", "gouraud"), "--fit minimax with the shading gouraud"),
        (("--fit", "smooth", "--setup", "abbas"), "--fit smooth with --setup abbas"),
        (("--fit", "auto"), "--fit auto without --max-error or --budget"),
        (("--fit", "smooth", "--max-error", "2"), "--fit smooth with --max-error or --budget"),
        (("--fit", "c1", "--shading", "quadratic-specular"), "--fit c1 with the shading quadratic-specular"),
        (("--fit", "minimax", "--shading", "quadratic-specular", "--toon", "3"), "with steps of a cartoon"),
        (("--smoothness", "3"), "a smoothness with the fit six-point"),
        (("--jump", "3"), "a jump with the fit six-point"),
        (("--fit", "c1", "--jump", "-3"), "jump is -3"),
        (("--fit", "smooth", "--smoothness", "-3"), "smoothness is -3"),
        (("--supersample", "3"), "'3' is not one of"),
    ],
)
def test_what_excludes_itself_is_one_line(tmp_path: Path, arguments: tuple[str, ...], message: str) -> None:
    output = tmp_path / "out.png"
    result = run("render", "torus:288", "--size", "32x32", "-o", output, *arguments)
    assert result.exit_code == 2 and not output.exists()
    assert message in result.output and len(result.output.strip().splitlines()) == 1


@pytest.mark.parametrize(
    ("camera", "reason"),
    [
        ("eye=0,0,0.1", "all faces in view look away from the camera; give --no-cull"),
        ("eye=0,0,5,target=0,0,9", "everything lies behind the camera"),
        ("eye=0,0,5,target=5,0,5", "everything lies outside of the view"),
        ("ortho=400", "no triangle covers a pixel's centre"),
    ],
)
@pytest.mark.parametrize("port", [False, True])
def test_an_empty_picture_says_why(tmp_path: Path, camera: str, reason: str, port: bool) -> None:
    words = ["render", "sphere:168", "--size", "32x24", "-o", tmp_path / "out.png", "--camera", camera]
    result = run(*words, *(["--port", "sim", "--engine", "model"] if port else []))
    assert result.exit_code == 0
    assert f"notice: the picture is empty: {reason}" in result.output


def test_a_board_says_what_packing_may_change(tmp_path: Path) -> None:
    words = ["render", "sphere:168", "--size", "32x24", "-o", tmp_path / "out.png", "--port", "sim"]
    assert "(--pack-error 0: none)" in run(*words, "--engine", "model").output
    assert "packed to" not in run(*words, "--engine", "model", "--pack-error", "0").output
