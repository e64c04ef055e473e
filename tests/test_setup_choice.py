# SPDX-License-Identifier: Apache-2.0
"""The choice of the set-up: methods of the literature to words and pixels, X-shading, the options."""

from __future__ import annotations

import json
from fractions import Fraction

import numpy as np
import pytest
from click.testing import CliRunner

from quadshade.choices import SETUPS
from quadshade.cli.main import main
from quadshade.contract.formats import Formats
from quadshade.engine import draw
from quadshade.errors import QuadshadeError
from quadshade.files.triangle_file import write_triangles
from quadshade.image import read_picture
from quadshade.scene import fit_camera, load_scene, parse_camera, project
from quadshade.setup.literature.terms import fit_terms
from quadshade.setup.triangle_setup import setup_triangles
from quadshade.shading import sample, sample_specular
from quadshade.shading.lights import DirectionalLight, PointLight
from quadshade.shading.material import Material
from quadshade.shading.sample import SAMPLE_POINTS, middle_normals
from tests.support.setup_reference import exact_quadratic, screen_triangles

FORMATS = Formats(num_channels=1, with_depth=0)
FITTED = ("abbas", "general")


def run(*arguments: object):
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def mixed_triangles(rng: np.random.Generator, count: int = 60):
    """Triangles of all sizes on 100 x 100, a third of them needles, some with an edge along a scanline."""
    vertices = rng.integers(0, 100 * 256, (count, 3, 2))
    vertices[::3, 2] = (vertices[::3, 0] + vertices[::3, 1]) // 2 + rng.integers(
        -3, 4, (len(vertices[::3]), 2)
    )
    vertices[1::5, 1, 1] = vertices[1::5, 0, 1]
    return screen_triangles(vertices, FORMATS, 100, 100, rng.uniform(0, 255, (count, 1, 6)))


@pytest.mark.parametrize("fractional", [False, True], ids=["centre", "fractional"])
@pytest.mark.parametrize("method", SETUPS)
def test_bound_holds_whatever_the_method_lost(method, fractional, rng):
    """The bound compares a method's words with the default's: what floating point lost is in it."""
    triangles = mixed_triangles(rng)
    default = setup_triangles(triangles, FORMATS, fractional)
    found = setup_triangles(triangles, FORMATS, fractional, method=method)
    assert np.array_equal(found.orders, default.orders)
    if method not in FITTED:
        assert np.array_equal(found.words, default.words) and not found.undefined.any()
    if fractional:
        return
    drawn = draw(triangles, FORMATS, method=method, limit=None).pixels
    bound = np.zeros(len(triangles))
    bound[found.triangle] = found.bound[:, 0]
    top = Fraction(255)
    for index in range(0, len(drawn), 37):
        triangle = int(drawn.triangle[index])
        exact = exact_quadratic(triangles.vertices[triangle], triangles.samples[triangle, 0], 2)
        place = (Fraction(256 * (2 * int(axis[index]) + 1), 2) for axis in (drawn.x, drawn.y))
        want = min(max(exact(*place), Fraction(0)), top)
        assert abs(int(drawn.value[index, 0]) - want) <= Fraction(1, 2) + Fraction(bound[triangle])


@pytest.mark.parametrize("method", FITTED)
def test_methods_agree_where_they_are_sound(method, rng):
    vertices = np.array([[[2, 3], [90, 40], [30, 95]], [[5, 80], [50, 4], [97, 60]]]) * 256
    triangles = screen_triangles(vertices, FORMATS, 100, 100, rng.uniform(0, 255, (2, 1, 6)))
    for fractional in (False, True):
        unit = draw(triangles, FORMATS, fractional=fractional).pixels.value
        assert np.array_equal(
            draw(triangles, FORMATS, fractional=fractional, method=method).pixels.value, unit
        )


def test_terms_count_from_the_bottom_vertex_for_abbas_only(rng):
    """Whatever vertex is the origin, the polynomial goes through the six samples where they belong."""
    triangles = mixed_triangles(rng, 9)
    triangles.vertices[:] = np.array([[10, 10], [70, 30], [20, 90]]) * 256
    triangles.vertices[3:6] = triangles.vertices[3:6, [2, 0, 1]]
    triangles.vertices[6:] = triangles.vertices[6:, [1, 2, 0]]
    for method, origins in (("abbas", [2, 0, 1]), ("general", [0, 0, 0])):
        terms = fit_terms(method, triangles.vertices, triangles.samples, 8)
        assert terms.origins[::3].tolist() == origins
        corners = triangles.vertices / 256
        places = np.concatenate([corners, (corners[:, [0, 0, 1]] + corners[:, [1, 2, 2]]) / 2], axis=1)
        x, y = np.moveaxis(places - corners[np.arange(9), terms.origins][:, None], -1, 0)
        powers = np.stack([x**0, y, x, y * y, x * y, x * x], axis=-1)
        assert np.allclose(np.einsum("npk,nk->np", powers, terms.values[:, 0]), triangles.samples[:, 0])


def test_division_by_zero_is_drawn_as_0_and_told(rng, tmp_path):
    """Y2 = 0: Abbas's formulas have no T3. The triangle is black, counted, and refused with strict."""
    flat = np.array([[[10, 90], [80, 90], [40, 10]], [[10, 10], [80, 20], [40, 90]]]) * 256
    triangles = screen_triangles(flat, FORMATS, 100, 100, rng.uniform(50, 255, (2, 1, 6)))
    drawing = draw(triangles, FORMATS, method="abbas")
    assert drawing.stats["triangles_undefined"] == 1 and drawing.stats["bound"] > 255
    black = drawing.pixels.value[:, 0][drawing.pixels.triangle == 0]
    assert len(black) > 2000 and (black == 0).all()
    unit = draw(triangles, FORMATS)
    other = unit.pixels.triangle == 1
    assert np.array_equal(drawing.pixels.value[other], unit.pixels.value[other])
    assert draw(triangles, FORMATS, method="general", strict=True).stats["triangles_undefined"] == 0
    with pytest.raises(QuadshadeError, match="triangle 0: channel r may be"):
        draw(triangles, FORMATS, method="abbas", strict=True)

    path, stats = tmp_path / "flat.json", tmp_path / "stats.json"
    write_triangles(path, triangles, FORMATS)
    told = run("raster", path, "-o", tmp_path / "a.npz", "--setup", "abbas", "--stats", stats)
    assert told.exit_code == 0 and "1 triangles undefined by abbas" in told.output
    assert json.loads(stats.read_text())["triangles_undefined"] == 1
    refused = run("raster", path, "-o", tmp_path / "a.npz", "--setup", "abbas", "--strict")
    assert refused.exit_code == 2 and len(refused.output.splitlines()) == 1


def test_middle_normals_are_equation_27(rng):
    corners = rng.normal(size=(20, 3, 3))
    normals = middle_normals(corners)
    ones = corners / np.linalg.norm(corners, axis=-1, keepdims=True)
    assert np.allclose(normals[:, :3], ones)
    for place, (i, j) in enumerate(((0, 1), (0, 2), (1, 2)), start=3):
        share = (5 - (ones[:, i] * ones[:, j]).sum(axis=-1)) / 8
        assert np.allclose(normals[:, place], (ones[:, i] + ones[:, j]) * share[:, None])


@pytest.mark.parametrize("kind", ["directional", "point"])
def test_x_shading_samples_are_those_of_the_paper(kind):
    """L . N alone, unclamped: equations 29-31, and 33 with the light seen from the middle of the edge."""
    mesh = load_scene("sphere:690")
    projected = project(mesh, fit_camera(mesh), 256, 256)
    light = DirectionalLight((1, 2, 9)) if kind == "directional" else PointLight((0.5, 1.0, 4.0))
    material = Material(
        reflectance=lambda point, normal, to_light, to_viewer: np.repeat(
            (normal * to_light).sum(axis=1, keepdims=True), 3, axis=1
        )
    )
    samples = sample(projected, "quadratic", [light], material, x_shading=True).samples[:, 0] / 255
    given = (samples[:, :3] > 0.05).all(axis=1)
    assert given.sum() > 50
    one, two = projected.normal[:, [0, 0, 1]], projected.normal[:, [1, 2, 2]]
    share = (5 - (one * two).sum(axis=-1)) / 8
    if kind == "directional":
        expected = (samples[:, [0, 0, 1]] + samples[:, [1, 2, 2]]) * share
    else:
        # The middle on the screen, in the scene: weighted with the perspective of both ends.
        weight = projected.weight[:, [0, 0, 1]], projected.weight[:, [1, 2, 2]]
        ends = projected.position[:, [0, 0, 1]], projected.position[:, [1, 2, 2]]
        middle = (ends[0] * weight[0][..., None] + ends[1] * weight[1][..., None]) / (weight[0] + weight[1])[
            ..., None
        ]
        towards = np.array(light.position) - middle
        towards /= np.linalg.norm(towards, axis=-1, keepdims=True)
        expected = (towards * (one + two)).sum(axis=-1) * share
    assert np.allclose(samples[given, 3:], np.clip(expected[given], 0, 1), atol=1e-9)


def test_render_offers_every_choice(tmp_path):
    pictures = {}
    for name, options in {
        "unit": [],
        "general": ["--setup", "general"],
        "xshading": ["--setup", "xshading"],
        "taylor": ["--setup", "taylor"],
        "fractional": ["--stepping", "fractional"],
        "independent": ["--rounding", "independent", "--generic", "frac_bits=12", "--divide", "100"],
    }.items():
        path = tmp_path / f"{name}.png"
        result = run("render", "sphere:168", "-o", path, "--size", "120x120", *options)
        assert result.exit_code == 0, result.output
        pictures[name] = read_picture(path).astype(int)
    assert np.array_equal(pictures["general"], pictures["unit"])
    for name in ("xshading", "taylor", "fractional", "independent"):
        off = np.abs(pictures[name] - pictures["unit"]).max()
        assert 0 < off < 40, name


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (("--setup", "abbas", "--shading", "gouraud"), "--setup abbas is for quadratic channels"),
        (("--strict=0",), "is not a number of grey levels above 0"),
        (("--divide", "many"), "is not a number of grey levels above 0"),
        (("--setup", "seiler"), "seiler"),
    ],
)
def test_wrong_choices_are_one_line(options, told, tmp_path):
    result = run("render", "sphere:168", "-o", tmp_path / "a.png", "--size", "40x40", *options)
    assert result.exit_code == 2 and told in result.output and len(result.output.splitlines()) == 1


@pytest.mark.parametrize("method", ["xshading", "taylor"])
def test_raster_has_no_normals_for_own_samples(tmp_path, rng, method):
    path = tmp_path / "a.json"
    write_triangles(path, mixed_triangles(rng, 3), FORMATS)
    result = run("raster", path, "-o", tmp_path / "a.npz", "--setup", method)
    assert result.exit_code == 2 and method in result.output


def bishop_and_weimer(normals, light):
    """
    T0 .. T5 of L . N / |N| about the origin, N = N1 x + N2 y + N3, as Fast Phong Shading prints them.

    Of x², its coefficient, the printed text that is at hand drops the factor c.
    """
    n1, n2, n3 = normals
    a, b, c = (light @ n for n in normals)
    d, e, f, g, h, i = n1 @ n1, 2 * n1 @ n2, n2 @ n2, 2 * n1 @ n3, 2 * n2 @ n3, n3 @ n3
    root = np.sqrt(i)
    return (
        c / root,
        (2 * b * i - c * h) / (2 * i * root),
        (2 * a * i - c * g) / (2 * i * root),
        (3 * c * h**2 - 4 * c * f * i - 4 * b * h * i) / (8 * i**2 * root),
        (3 * c * g * h - 2 * c * e * i - 2 * b * g * i - 2 * a * h * i) / (4 * i**2 * root),
        (3 * c * g**2 - 4 * c * d * i - 4 * a * g * i) / (8 * i**2 * root),
    )


def test_taylors_quadratic_is_that_of_bishop_and_weimer():
    """Without perspective, light and viewer far away: the same polynomial of every cosine, at six points."""
    mesh = load_scene("sphere:168")
    projected = project(mesh, parse_camera("from=0,0,1,ortho=1.05", mesh), 256, 256)
    light = np.array([1.0, 2.0, 9.0]) / np.linalg.norm([1, 2, 9])
    triangles = sample_specular(
        projected, "quadratic-specular", [DirectionalLight((1, 2, 9))], Material(model="blinn"), taylor=True
    )
    half = light + projected.axes[2]
    half /= np.linalg.norm(half)
    corners = projected.vertices / 256.0
    middle = corners.mean(axis=1)
    places = np.einsum("pk,nki->npi", SAMPLE_POINTS, corners - middle[:, None])
    worst = 0.0
    for row in range(len(projected)):
        system = np.column_stack([corners[row] - middle[row], np.ones(3)])
        normals = np.linalg.solve(system, projected.normal[row])
        x, y = places[row].T
        for channel, vector in ((0, light), (1, half)):
            t0, t1, t2, t3, t4, t5 = bishop_and_weimer(normals, vector)
            printed = t5 * x**2 + t4 * x * y + t3 * y**2 + t2 * x + t1 * y + t0
            off = triangles.samples[row, channel] / 255 - np.clip(printed, -1, 1)
            worst = max(worst, np.abs(off).max())
    assert worst < 1e-4


def test_taylors_quadratic_is_best_at_the_middle():
    mesh = load_scene("sphere:168")
    projected = project(mesh, parse_camera("from=0,0,1,ortho=1.05", mesh), 256, 256)
    exact = sample(projected, "flat").samples[:, :, 0]
    shares = np.array([-1, -1, -1, 4, 4, 4]) / 9
    six, expanded = sample(projected).samples, sample(projected, taylor=True).samples
    # A sample that is held in the output's range is not Taylor's any more.
    whole = ((expanded > 0) & (expanded < 255)).all(axis=2)
    assert whole.sum() > 50
    off = [np.abs(samples @ shares - exact)[whole].max() for samples in (six, expanded)]
    assert off[1] < 1e-6 < off[0]


def test_unknown_method_is_refused(rng):
    with pytest.raises(QuadshadeError, match="no set-up 'seiler'"):
        setup_triangles(mixed_triangles(rng, 1), FORMATS, method="seiler")
