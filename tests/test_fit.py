# SPDX-License-Identifier: Apache-2.0
"""Fits over the whole mesh: nearer to Phong than six points, watertight, and no worse for bad meshes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from quadshade.choices import FITS
from quadshade.contract.formats import Formats
from quadshade.engine import draw
from quadshade.errors import QuadshadeError
from quadshade.fit import fit_colours, fit_scene, fits, solve
from quadshade.fit.elements import ENDS, shared_elements
from quadshade.fit.jumps import jump_penalty, jumps_of
from quadshade.fit.places import Places, held_beyond, places_of
from quadshade.fit.solve import HOLD
from quadshade.fit.weighting import Weighted
from quadshade.scene import Projected, build_mesh, fit_camera, load_scene, parse_camera, project
from quadshade.shading import Material, default_lights, sample, sample_specular, specular_formats
from quadshade.shading.reference import barycentric, phong, quadratic_shape
from quadshade.shading.sample import reflected

FORMATS = Formats()
SHARP = Material(exponent=50)


def seen(scene: str = "sphere:168", size: int = 200, camera: str = "from=0,0.4,1"):
    mesh = load_scene(scene)
    projected = project(mesh, parse_camera(camera, mesh), size, size)
    return projected, sample(projected, material=SHARP)


def errors(projected, triangles) -> np.ndarray:
    """Deviation of what the golden model draws from Phong shading, at every pixel drawn."""
    pixels = draw(triangles, FORMATS, "model").pixels
    exact = phong(projected, pixels.triangle, pixels.x, pixels.y, material=SHARP)
    return pixels.value - exact


@pytest.mark.parametrize("scene", ["sphere:168", "sphere:374", "torus:288", "icosphere:2"])
@pytest.mark.parametrize("places", ["pixels", "points"])
def test_least_squares_is_nearer_to_phong(scene: str, places: str) -> None:
    projected, six = seen(scene)
    best = fit_colours(projected, six, "least-squares", material=SHARP, places=places)
    before, after = errors(projected, six), errors(projected, best)
    # One decibel at least; two and more at the places that are drawn.
    assert (after**2).mean() < 0.85 * (before**2).mean()
    if scene != "icosphere:2":
        assert np.abs(after).max() <= np.abs(before).max() + 1


def test_the_pixels_are_those_of_the_core() -> None:
    """Clipped at the screen's border, from behind and without area: the same pixels, at the same places."""
    mesh = load_scene("torus:288")
    projected = project(mesh, parse_camera("from=0.3,0.2,1,ortho=0.7", mesh), 97, 61, cull=False)
    here = places_of("pixels", projected, FORMATS)
    drawn = draw(sample(projected), FORMATS, "model").pixels
    exact = barycentric(projected.vertices, drawn.triangle, drawn.x, drawn.y, FORMATS.subpixel_bits)
    order, other = (
        np.lexsort((weights[:, 2], weights[:, 1], owner))
        for owner, weights in ((here.triangle, here.weights), (drawn.triangle, exact))
    )
    assert len(drawn) > 1000
    assert (here.triangle[order] == drawn.triangle[other]).all()
    assert (here.weights[order] == exact[other]).all()


def test_at_the_pixels_nothing_else_is_better() -> None:
    """The gradient of the squared error over all shared unknowns is zero, up to the hold on six points."""
    projected, six = seen()
    here = places_of("pixels", projected, FORMATS)
    light = reflected(projected, here.triangle, here.weights[:, None], default_lights(projected.axes), SHARP)
    exact = 255 * np.clip(light[:, 0], 0, 1)
    elements, beyond = shared_elements(six), held_beyond(projected, FORMATS)
    values = Weighted(elements, here, exact, beyond, 0, 255).solve(here.area, tolerance=1e-6).values
    index, shape = elements.index, quadratic_shape(here.weights)
    residual = np.einsum("ps,psc->pc", shape, values[index[here.triangle]]) - exact
    gradient = HOLD * (values - elements.start)
    np.add.at(gradient, index, beyond[:, None, None] * (values - elements.start)[index])
    np.add.at(gradient, index[here.triangle], (here.area[:, None] * shape)[:, :, None] * residual[:, None, :])
    inside = (values > 0) & (values < 255)
    assert inside.mean() > 0.95
    assert np.abs(gradient[inside]).max() < 0.01
    # What is held at a border would only go beyond it.
    assert (gradient[values == 0] > -0.01).all() and (gradient[values == 255] < 0.01).all()
    # What is drawn has lower peaks for at most a quarter of a percent more of the squared error.
    best = fit_colours(projected, six, "least-squares", material=SHARP)
    drawn = np.einsum("ps,psc->pc", shape, best.samples.transpose(0, 2, 1)[here.triangle]) - exact
    largest = [np.abs(error).max(axis=1) for error in (residual, drawn)]
    assert (largest[1] ** 2).sum() < 1.003 * (largest[0] ** 2).sum()
    assert largest[1].max() < largest[0].max()


def test_minimax_has_a_smaller_largest_error() -> None:
    projected, six = seen("torus:288")
    squares = fit_colours(projected, six, "least-squares", material=SHARP)
    least = fit_colours(projected, six, "minimax", material=SHARP)
    six_error, square_error, least_error = (
        np.abs(errors(projected, triangles)).max() for triangles in (six, squares, least)
    )
    assert least_error < 0.9 * square_error < 0.9 * six_error


def test_smooth_trades_error_for_jumps() -> None:
    projected, six = seen("sphere:374")
    elements = shared_elements(six)
    penalty = jump_penalty(elements, projected.vertices, FORMATS)

    def jump(triangles) -> float:
        values = np.empty_like(elements.start)
        values[elements.index.reshape(-1)] = triangles.samples.transpose(0, 2, 1).reshape(-1, 3)
        return float(np.einsum("mc,mc->", values, penalty @ values))

    steps = [fit_colours(projected, six, "smooth", material=SHARP, smoothness=s) for s in (0, 30, 1000)]
    jumps = [jump(triangles) for triangles in steps]
    square = [(errors(projected, triangles) ** 2).mean() for triangles in steps]
    assert jumps[0] > 1.1 * jumps[1] > 1.1 * 1.1 * jumps[2]
    assert square[0] < square[1] < square[2]


def test_the_jump_of_one_quadratic_is_zero_and_of_a_kink_its_angle() -> None:
    """Two triangles side by side: x**2 + xy has no jump; |x - 10| jumps by 2 across its vertical edge."""
    vertices = np.array([[[0, 0], [10, 0], [10, 10]], [[10, 0], [20, 5], [10, 10]]]) * 256
    _, two = seen()
    place = np.concatenate(
        [vertices / 256, (vertices[:, ENDS[:, 0]] + vertices[:, ENDS[:, 1]]) / 512], axis=1
    )
    x, y = place[..., 0], place[..., 1]
    for value, expected in ((x**2 + x * y, 0.0), (np.abs(x - 10), 4 * 10.0)):
        triangles = replace(
            two,
            vertices=vertices,
            samples=np.repeat(value[:, None, :], 3, axis=1),
            orders=np.full((2, 3), 2),
            depth=None,
        )
        elements = shared_elements(triangles)
        assert len(elements.start) == 4 + 5
        penalty = jump_penalty(elements, vertices, FORMATS)
        one = elements.start[:, 0]
        assert one @ (penalty @ one) == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("scene", ["sphere:168", "torus:288"])
@pytest.mark.parametrize("jump", [0.0, 0.1])
def test_c1_has_no_jump_and_covers_the_same_pixels(scene: str, jump: float) -> None:
    projected, six = seen(scene)
    fitted = fit_scene(projected, six, "c1", material=SHARP, jump=jump)
    assert not fitted.notes
    assert len(fitted.triangles) > (5.5 if jump == 0 else 3) * len(projected)
    elements = shared_elements(fitted.triangles)
    values = np.empty_like(elements.start)
    values[elements.index.reshape(-1)] = fitted.triangles.samples.transpose(0, 2, 1).reshape(-1, 3)
    # All six samples of an edge's both sides are one: no crack in colour.
    assert np.abs(elements.samples(values) - fitted.triangles.samples).max() < 1e-9
    jumps = jumps_of(elements, fitted.projected.vertices, FORMATS)
    size = jumps.of_edges(values)
    assert len(size) > 1.3 * len(fitted.triangles)
    # Points on the lattice are not quite where they should be: slopes on both sides are not quite the same.
    assert np.sqrt(np.average(size**2, weights=jumps.length)) < (0.02 if jump == 0 else jump)
    assert np.percentile(size, 90) < jump + 0.01
    # Every pixel belongs to a part of the triangle that it belonged to.
    before, after = draw(six, FORMATS, "model").pixels, draw(fitted.triangles, FORMATS, "model").pixels
    places = (
        np.stack([owner, pixels.y, pixels.x], axis=1)
        for owner, pixels in ((before.triangle, before), (fitted.parent[after.triangle], after))
    )
    one, two = (place[np.lexsort(place.T)] for place in places)
    assert len(one) > 10000 and (one == two).all()


def test_c1_keeps_creases_and_splits_nothing_that_is_flat() -> None:
    mesh = load_scene("cube:2")
    projected = project(mesh, parse_camera("from=1,0.8,1.2", mesh), 96, 96)
    six = sample(projected)
    fitted = fit_scene(projected, six, "c1", jump=0.02)
    assert len(fitted.triangles) < 6 * len(projected)
    before, after = draw(six, FORMATS, "model").pixels, draw(fitted.triangles, FORMATS, "model").pixels
    assert len(before) == len(after)
    step = before.value[np.lexsort((before.x, before.y))] - after.value[np.lexsort((after.x, after.y))]
    assert np.abs(step).max() <= 2


@pytest.mark.parametrize("fit", ["least-squares", "minimax"])
def test_cosines_are_fitted_for_the_final_colour(fit: str) -> None:
    projected, _ = seen("torus:288")
    formats = specular_formats({}, projected, None, SHARP)
    cosines = sample_specular(projected, material=SHARP, formats=formats)
    fitted = fit_colours(projected, cosines, fit, material=SHARP, formats=formats)
    errors = []
    for triangles in (cosines, fitted):
        pixels = draw(triangles, formats, "model").pixels
        errors.append(pixels.value - phong(projected, pixels.triangle, pixels.x, pixels.y, material=SHARP))
    square = [(error**2).mean() for error in errors]
    # Two decibels, in spite of 8-bit rounding.
    assert square[1] < 0.63 * square[0]
    assert np.abs(errors[1]).max() < np.abs(errors[0]).max()
    with pytest.raises(QuadshadeError, match="the fit smooth of cosines"):
        fit_colours(projected, cosines, "smooth", material=SHARP, formats=formats)


def test_colours_that_are_no_numbers_count_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    projected, six = seen()
    exact = fits.phong_at

    def holed(projected, triangle, *rest):
        colour = exact(projected, triangle, *rest)
        colour[triangle == 3] = np.nan
        return colour

    monkeypatch.setattr(fits, "phong_at", holed)
    for fit in FITS[1:]:
        fitted = fit_scene(projected, six, fit, material=SHARP)
        assert np.isfinite(fitted.triangles.samples).all()
        assert sum("colours that are no numbers" in note for note in fitted.notes) == 1


@pytest.mark.parametrize("fit", FITS[1:])
def test_a_reflectance_without_colours_is_drawn_through_six_points(fit: str) -> None:
    projected, _ = seen()

    def holed(point, normal, to_light, to_viewer):
        # No vertex and no middle of an edge lies there.
        here = (point[:, 0] > 0.31) & (point[:, 0] < 0.33)
        return np.where(here[:, None], np.nan, np.clip(normal[:, [2, 2, 2]], 0, 1))

    material = Material(reflectance=holed)
    six = sample(projected, material=material)
    fitted = fit_scene(projected, six, fit, material=material)
    assert (fitted.triangles.samples == six.samples).all()
    assert len(fitted.notes) == 1 and "not finite" in fitted.notes[0]


@pytest.mark.parametrize("fit", [fit for fit in FITS if fit != "c1"])
def test_neighbours_meet_in_value(fit: str) -> None:
    projected, six = seen("torus:288")
    fitted = fit_colours(projected, six, fit, material=SHARP)
    index = shared_elements(six).index
    values = np.full((index.max() + 1, 3), np.nan)
    values[index.reshape(-1)] = fitted.samples.transpose(0, 2, 1).reshape(-1, 3)
    assert (values[index].transpose(0, 2, 1) == fitted.samples).all()
    assert len(values) < 0.7 * index.size
    assert fitted.samples.min() >= 0 and fitted.samples.max() <= 255


def test_creases_and_colour_seams_keep_their_own_values() -> None:
    mesh = load_scene("cube:1")
    projected = project(mesh, parse_camera("from=1,0.8,1.2", mesh), 64, 64)
    index = shared_elements(sample(projected)).index
    # Three faces of two triangles; the two of a face share four corners and an edge, and have four more.
    assert index.max() + 1 == 3 * (4 + 5)


@pytest.mark.parametrize("fit", FITS)
def test_bad_meshes_are_drawn_as_sampled_or_better(fit: str) -> None:
    """Three triangles at one edge, one without area, one turned over, one of no pixel, a huge one."""
    vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0.2], [0.5, 1, -1], [0.2, 0.2, 0], [0.2001, 0.2, 0]]
    vertices += [[0.2, 0.2001, 0], [-900, -900, -1], [900, -900, -1], [0, 900, -1]]
    faces = [[0, 1, 2], [1, 3, 2], [1, 4, 2], [0, 0, 1], [2, 1, 0], [5, 6, 7], [8, 9, 10]]
    mesh = build_mesh(np.array(vertices, float), np.array(faces))
    camera = fit_camera(mesh, eye=np.array([0.3, 0.4, 4.0]), target=np.array([0.4, 0.4, 0.0]), fov=30)
    projected = project(mesh, camera, 96, 96, cull=False)
    six = sample(projected, material=SHARP)
    scene = fit_scene(projected, six, fit, material=SHARP)
    fitted = scene.triangles
    assert np.isfinite(fitted.samples).all()
    before, after = draw(six, FORMATS, "model").pixels, draw(fitted, FORMATS, "model").pixels
    pixels = [
        np.sort((owner.astype(np.int64) * 96 + pixels.y) * 96 + pixels.x)
        for owner, pixels in ((before.triangle, before), (scene.parent[after.triangle], after))
    ]
    assert (pixels[0] == pixels[1]).all()
    assert len(scene.notes) <= 1
    if fit in ("six-point", "least-squares"):
        assert (errors(projected, fitted) ** 2).mean() <= (errors(projected, six) ** 2).mean() + 0.1


def test_c1_keeps_triangles_whole_at_an_edge_of_three() -> None:
    vertices = [[0, 0, 0], [0, 1, 0], [1, 0.5, 0.3], [-1, 0.5, 0.3], [-0.7, 0.4, 0.9], [2, 1.2, 0]]
    mesh = build_mesh(
        np.array(vertices, float), np.array([[0, 2, 1], [0, 1, 3], [0, 1, 4], [1, 2, 5]]), crease=180
    )
    projected = project(mesh, parse_camera("from=0,0,1", mesh), 96, 96, cull=False)
    six = sample(projected, material=SHARP)
    fitted = fit_scene(projected, six, "c1", material=SHARP, jump=0)
    assert len(fitted.notes) == 1 and "4 triangles" in fitted.notes[0]
    before, after = (draw(triangles, FORMATS, "model").pixels for triangles in (six, fitted.triangles))
    assert len(before) == len(after) > 1000


def test_nothing_to_draw_and_nothing_seen() -> None:
    mesh = load_scene("sphere:168")
    projected = project(mesh, parse_camera("eye=9,0,0,target=20,0,0", mesh), 32, 32)
    assert len(fit_colours(projected, sample(projected), "least-squares")) == 0
    tiny = project(mesh, parse_camera("from=0,0,1,ortho=4000", mesh), 32, 32)
    six = sample(tiny)
    fitted = fit_colours(tiny, six, "least-squares")
    assert fitted.samples == pytest.approx(six.samples, abs=60)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"fit": "cubic"}, "the fit is 'cubic'"),
        ({"places": "corners"}, "a fit at 'corners'"),
        ({"fit": "smooth", "smoothness": float("nan")}, "smoothness is nan"),
        ({"fit": "smooth", "smoothness": -1.0}, "smoothness is -1"),
        ({"fit": "c1", "jump": -1.0}, "jump is -1"),
    ],
)
def test_refused(settings: dict, message: str) -> None:
    projected, six = seen(size=32)
    with pytest.raises(QuadshadeError, match=message):
        fit_colours(projected, six, **settings)


def test_a_fit_that_does_not_end_says_so_and_is_no_worse(monkeypatch: pytest.MonkeyPatch) -> None:
    projected, six = seen()
    monkeypatch.setattr(solve, "MOST_STEPS", 3)
    fitted = fit_scene(projected, six, "least-squares", material=SHARP)
    assert len(fitted.notes) == 1 and "is drawn, not the best of all" in fitted.notes[0]
    assert (errors(projected, fitted.triangles) ** 2).mean() < (errors(projected, six) ** 2).mean()


def test_what_is_too_large_to_be_factorised_is_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Smooth needs the factors and is least squares without, c1 is solved by steps, to the same picture."""
    projected, six = seen()
    squares = fit_scene(projected, six, "least-squares", material=SHARP)
    parts = fit_scene(projected, six, "c1", material=SHARP)
    monkeypatch.setattr(solve, "MOST_FACTORISED", 10)
    smooth = fit_scene(projected, six, "smooth", material=SHARP)
    assert len(smooth.notes) == 1 and "too many for smooth" in smooth.notes[0]
    assert (smooth.triangles.samples == squares.triangles.samples).all()
    stepped = fit_scene(projected, six, "c1", material=SHARP)
    assert not stepped.notes and len(stepped.triangles) == len(parts.triangles)
    assert np.abs(stepped.triangles.samples - parts.triangles.samples).max() < 2
    before, after = (errors(projected, six), errors_of_parts(projected, stepped))
    assert (after**2).mean() < 1.6 * (before**2).mean()
    monkeypatch.setattr(fits, "MOST_SPLIT", 10)
    whole = fit_scene(projected, six, "c1", material=SHARP)
    assert len(whole.notes) == 1 and "too many for c1" in whole.notes[0]
    assert len(whole.triangles) == len(six)
    assert (errors(projected, whole.triangles) ** 2).mean() < (before**2).mean()


def errors_of_parts(projected, fitted) -> np.ndarray:
    """:func:`errors` of a fit that sends parts of triangles."""
    pixels = draw(fitted.triangles, FORMATS, "model").pixels
    return pixels.value - phong(projected, fitted.parent[pixels.triangle], pixels.x, pixels.y, material=SHARP)


def test_only_triangles_that_are_seen_are_split() -> None:
    """One pixel a triangle: a jump allowed is no reason to send six parts, none allowed is."""
    mesh = load_scene("sphere:690")
    projected = project(mesh, parse_camera("from=0,0.4,1", mesh), 24, 24)
    six = sample(projected, material=SHARP)
    allowed, none = (fit_scene(projected, six, "c1", material=SHARP, jump=jump) for jump in (0.02, 0.0))
    assert len(allowed.triangles) < 1.5 * len(projected) < len(none.triangles)
    assert not allowed.notes


def test_c1_of_a_mesh_too_fine_to_be_seen_is_fitted_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """A million faces took a minute: every triangle's places were looked for and solved for as if split."""
    projected, six = seen("sphere:80x80", 40)
    asked = []

    def counted(places: str, drawn: Projected, formats: Formats) -> Places:
        asked.append(len(drawn))
        return places_of(places, drawn, formats)

    monkeypatch.setattr(fits, "places_of", counted)
    monkeypatch.setattr(fits, "fit_c1", None)
    fitted = fit_scene(projected, six, "c1", material=SHARP)
    assert asked == [len(projected)] and len(projected) > 2000
    assert not fitted.notes and (fitted.triangles.vertices == six.vertices).all()
    assert (errors(projected, fitted.triangles) ** 2).mean() < 1.1 * (errors(projected, six) ** 2).mean()


def test_refuses_what_is_not_quadratic() -> None:
    projected, _ = seen(size=32)
    with pytest.raises(QuadshadeError, match="not quadratic colours"):
        fit_colours(projected, sample(projected, "gouraud"))
