# SPDX-License-Identifier: Apache-2.0
"""Figures in sentences of README and pages, which no script writes there, are measured again."""

from __future__ import annotations

import re
from itertools import product
from math import log10
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import quadshade
from quadshade.adapt import ErrorCurve, adapt, error_figures, pixel_errors
from quadshade.adapt.curve import error_limits
from quadshade.cli.main import main
from quadshade.contract.formats import LINEAR, QUADRATIC, Formats
from quadshade.contract.triangles import ScreenTriangles
from quadshade.engine import draw
from quadshade.image.compare import psnr
from quadshade.scene import fit_camera, load_scene, project
from quadshade.setup.packet import pack
from quadshade.setup.triangle_setup import setup_triangles
from quadshade.shading import Material
from tests.support.pages import ROOT


def says(page: str, sentence: str) -> bool:
    """Whether a page holds a sentence, however its lines are broken."""
    return " ".join(sentence.split()) in " ".join((ROOT / page).read_text().split())


def beats(order: int, width: int, vertices: list[list[int]]) -> int:
    """Clocks that the stream takes for one triangle of three channels and depth."""
    formats = Formats(stream_width=width)
    triangles = ScreenTriangles(
        64,
        64,
        np.array([vertices]) * 256,
        np.random.default_rng(1).uniform(0, 255, (1, 3, 6)),
        np.full((1, 3), order),
        np.array([[1000.0, 1100.0, 1050.0]]),
        ("r", "g", "b"),
    )
    return len(pack(setup_triangles(triangles, formats), formats)) // formats.beat_words


def test_clocks_of_a_packet() -> None:
    any_triangle, horizontal = [[0, 0], [30, 10], [0, 30]], [[0, 0], [30, 0], [0, 30]]
    clocks = [
        [beats(order, width, vertices) for width in (32, 64, 128)]
        for vertices, order in product((any_triangle, horizontal), (QUADRATIC, LINEAR))
    ]
    assert clocks == [[32, 18, 9], [23, 12, 6], [29, 16, 8], [20, 10, 5]]
    assert says(
        "docs/explanation/numbers.md",
        "takes 32, 18 or 9 clocks, of three linear ones 23, 12 or 6; with a horizontal side 29, 16 or 8, and"
        " 20, 10 or 5",
    )
    assert says("rtl/core/README.md", "at most 32 beats of 32 bits, 18 of 64, or 9 of 128")


def test_small_triangles_wait_for_the_stream() -> None:
    narrow, wide = (
        quadshade.render("icosphere:6", engine="model", generics={"stream_width": width}).stats
        for width in (32, 128)
    )
    pixels = f"{narrow.pixels / narrow.triangles:.1f}"
    clocks = [f"{stats.clocks / stats.pixels:.1f}" for stats in (narrow, wide)]
    assert (pixels, clocks) == ("5.5", ["5.3", "1.7"])
    assert says(
        "README.md",
        f"{pixels} pixels a triangle, takes {clocks[0]} clocks a pixel, and {clocks[1]} with",
    )
    page = "docs/explanation/numbers.md"
    assert says(page, f"covers {pixels} pixels a triangle")
    assert says(page, f"# {clocks[0]} clocks a pixel, then {clocks[1]}")


def test_quadratic_shading_is_so_much_nearer_than_gouraud() -> None:
    phong = quadshade.render("sphere:168", shading="phong", engine="model").array
    gouraud, quadratic = (
        psnr(quadshade.render("sphere:168", shading=shading, engine="model").array, phong)
        for shading in ("gouraud", "quadratic")
    )
    assert round(quadratic - gouraud) == 13
    assert says(
        "docs/tutorial/first_picture.md", "is about 13 dB nearer to Phong shading than the Gouraud one"
    )


def test_the_shade_unit_is_so_much_nearer_than_colours() -> None:
    page = (ROOT / "docs" / "explanation" / "shade.md").read_text()
    table = page.partition("<!-- shade begin -->\n")[2].partition("<!-- shade end -->")[0]
    header, _, *rows = [
        [cell.strip(" *") for cell in line.strip("|").split("|")] for line in table.splitlines()
    ]
    colours, cosines = header.index("quadratic"), header.index("quadratic-specular")
    most = max(float(row[cosines]) - float(row[colours]) for row in rows)
    assert says("README.md", f"is up to {most:.0f} dB nearer to Phong shading than `quadratic`")


def test_rounding_in_decibels() -> None:
    once, twice = (10 * log10(255**2 / (count / 12)) for count in (1, 2))
    assert says("docs/explanation/shade.md", f"A picture is {once:.1f} dB from what it was before")
    assert says("docs/explanation/shade.md", f"roundings are independent are {twice:.1f} dB apart")


def test_a_stricter_limit_may_cost_less() -> None:
    mesh = load_scene("torus:288")
    projected = project(mesh, fit_camera(mesh), 256, 256)
    curve = ErrorCurve(projected, None, Material(exponent=50), shading="quadratic-lights").curves[0]
    dear, cheap = (curve.picture(int(np.flatnonzero(curve.steps == limit)[0])) for limit in (4.9, 4.8))
    assert {4.9, 4.8} <= set(error_limits(255.0))
    assert says(
        "docs/guide/adapt.md",
        f"{dear.cost('bytes'):,} bytes for {dear.error:.2f} grey levels, {cheap.cost('bytes'):,} for"
        f" {cheap.error:.2f}",
    )
    assert dear.cost("bytes") > cheap.cost("bytes") and dear.error > cheap.error


@pytest.mark.parametrize(("scene", "share", "largest"), [("torus:288", 2e-3, 2.2), ("sphere:690", 0.0, 0.9)])
def test_an_estimate_is_no_bound(scene: str, share: float, largest: float) -> None:
    mesh = load_scene(scene)
    projected = project(mesh, fit_camera(mesh), 512, 512)
    adapted = adapt(projected, max_error=1.0, shading="auto", verify=False)
    pixels = draw(adapted.triangles, adapted.formats, engine="model").pixels
    figures = error_figures(pixel_errors(pixels, adapted.root, projected), 1.0)
    assert float(f"{figures.exceeding:.0e}") == share
    assert round(figures.largest, 1) == largest
    assert says(
        "docs/guide/adapt.md",
        "with `--no-verify` two pixels in a thousand of torus:288 at 512² exceed a limit of 1 grey level,"
        " by up to 1.2, and of sphere:690 none",
    )


def test_bytes_of_a_triangle_on_the_line(tmp_path: Path) -> None:
    options = ["pack", "sphere:690", "-o", str(tmp_path / "frame.qs"), "--size", "160x120"]
    said = CliRunner().invoke(main, options).output
    size = float(re.search(r"([\d.]+) bytes a triangle", said)[1])
    assert says("docs/tutorial/first_board.md", f"The host sent {size:.0f} bytes")


def test_bytes_and_quality_are_those_of_the_report() -> None:
    report = (ROOT / "docs" / "reports" / "link_bytes.md").read_text()
    header = next(line for line in report.splitlines() if line.startswith("| scene |"))
    chosen = [cell.strip() for cell in header.split("|")].index("0.03125")
    whole = chosen - 2
    lines = [line for line in report.splitlines() if "| sphere:690 | perspective | quadratic |" in line]
    size, quality = ([cell.strip() for cell in line.split("|")] for line in lines)
    lost = float(quality[whole]) - float(quality[chosen])
    assert says(
        "docs/reference/packing.md",
        f"{float(size[chosen]):.0f} bytes a triangle for the sphere of 690 triangles with all frames, and"
        f" {lost:.2f} dB less quality",
    )
