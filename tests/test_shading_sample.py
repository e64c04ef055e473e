# SPDX-License-Identifier: Apache-2.0
"""Six-point sampling and the float references."""

from __future__ import annotations

import numpy as np
import pytest

from quadshade.contract.formats import Formats
from quadshade.contract.triangles import ScreenTriangles
from quadshade.engine import draw
from quadshade.errors import QuadshadeError
from quadshade.image import paint, visible
from quadshade.image.compare import psnr
from quadshade.scene import build_mesh, fit_camera, load_scene, parse_camera, project
from quadshade.shading import DEFAULT_LIGHTS, AmbientLight, DirectionalLight, Material, PointLight, sample
from quadshade.shading.reference import barycentric, interpolated, phong

FORMATS = Formats()


def sphere(camera: str = "from=0,0,1", scene: str = "sphere:168", size: int = 64):
    mesh = load_scene(scene)
    return project(mesh, parse_camera(camera, mesh), size, size)


def covered(projected):
    """Pixels of triangles by half-plane arithmetic in integers, borders included: triangle, x, y."""
    rows = []
    grid = np.stack(
        np.meshgrid(np.arange(projected.width), np.arange(projected.height), indexing="xy"), axis=-1
    )
    centres = 256 * grid + 128
    for index, corners in enumerate(projected.vertices):
        inside = np.ones(centres.shape[:2], dtype=bool)
        for one, other in zip(corners, np.roll(corners, -1, axis=0), strict=True):
            edge, offset = other - one, centres - one
            inside &= edge[0] * offset[..., 1] - edge[1] * offset[..., 0] <= 0
        y, x = np.nonzero(inside)
        rows.append(np.stack([np.full(len(x), index), x, y]))
    return np.concatenate(rows, axis=1)


@pytest.mark.parametrize(
    ("shading", "order", "points"), [("flat", 0, 1), ("gouraud", 1, 3), ("quadratic", 2, 6)]
)
def test_each_shading_takes_the_points_of_its_order(shading, order, points):
    triangles = sample(sphere(), shading)
    assert (triangles.orders == order).all()
    assert triangles.channels == ("r", "g", "b")
    assert (triangles.samples[..., :points] > 0).any(axis=(0, 1)).all()
    assert not triangles.samples[..., points:].any()
    assert triangles.samples.min() >= 0 and triangles.samples.max() <= 255
    assert triangles.depth is not None
    assert sample(sphere(), shading, formats=Formats(with_depth=0)).depth is None
    assert sample(sphere(), shading, formats=Formats(value_bits=4)).samples.max() <= 15


def test_vertices_are_shaded_with_their_normals():
    projected = sphere("from=0,0,1,ortho=1.2")
    got = sample(projected, "gouraud").samples[..., :3]
    for corner in range(3):
        normal = projected.normal[:, corner]
        expected = 255 * Material().reflect(DEFAULT_LIGHTS, normal, normal, np.array([0.0, 0, 1]))
        assert got[..., corner] == pytest.approx(expected)


def test_middles_are_taken_in_the_middle_of_the_edge_on_the_screen():
    """A floor that recedes: the middle of its edges on the screen is much nearer than in the scene."""
    mesh = build_mesh([[-1, -1, 0], [1, -1, 0], [0, -1, -30]], [[0, 1, 2]])
    camera = fit_camera(mesh, eye=np.array([0.0, 1, 3]), target=np.array([0.0, -1, -3]), fov=60)
    projected = project(mesh, camera, 256, 256)
    seen: list = []

    def watch(point, normal, to_light, to_viewer):
        seen.append(point.copy())
        assert np.allclose(np.linalg.norm(to_viewer, axis=1), 1)
        return 0 * point

    sample(projected, "quadratic", [DirectionalLight((0, 1, 0))], Material(reflectance=watch))
    points = seen[0].reshape(6, 3)
    screen = [camera.axes @ (point - camera.eye) for point in points]
    screen = np.array([[x / -z, y / -z] for x, y, z in screen])
    assert screen[3:] == pytest.approx(
        np.array([screen[0] + screen[1], screen[0] + screen[2], screen[1] + screen[2]]) / 2
    )
    assert abs(points[4, 2]) < 4 or abs(points[5, 2]) < 4


def test_neighbours_agree_on_the_colour_of_their_edge():
    projected = sphere("fov=40")
    samples = sample(projected).samples
    middles: dict = {}
    for triangle, colours in zip(projected.vertices, samples, strict=True):
        for index, (one, other) in enumerate(((0, 1), (0, 2), (1, 2))):
            edge = frozenset((tuple(triangle[one]), tuple(triangle[other])))
            middles.setdefault(edge, []).append(colours[:, 3 + index])
    shared = [values for values in middles.values() if len(values) == 2]
    assert len(shared) > 50
    assert np.allclose(*np.array(shared).transpose(1, 0, 2), atol=1e-9)


def test_the_default_light_goes_with_the_viewer():
    front, behind = (sample(sphere(camera)).samples for camera in ("from=0,0,1", "from=0,0,-1"))
    assert front.mean() == pytest.approx(behind.mean(), rel=0.05)


def test_colours_of_the_mesh_replace_the_materials():
    mesh = load_scene("icosphere:1")
    colours = np.zeros((len(mesh), 3, 3))
    colours[..., 0] = 0.25
    red = build_mesh(mesh.vertices, mesh.faces, mesh.normals, colours=colours)
    projected = project(red, fit_camera(red), 32, 32)
    surface = Material(ambient=(1.0,) * 3)
    assert np.allclose(
        sample(projected, "gouraud", [AmbientLight()], surface).samples[..., :3].max(axis=(0, 2)),
        (63.75, 0, 0),
    )


def test_an_unknown_shading_is_refused():
    with pytest.raises(QuadshadeError, match="cartoon"):
        sample(sphere(), "cartoon")


def test_barycentric_coordinates_are_those_of_the_centre(rng):
    vertices = rng.integers(-(2**20), 2**21, size=(200, 3, 2))
    x, y = rng.integers(0, 4096, size=(2, 200))
    got = barycentric(vertices, np.arange(200), x, y, 8)
    assert np.allclose(
        np.einsum("nk,nki->ni", got, vertices), 256 * np.stack([x, y], axis=1) + 128, atol=1e-3
    )
    assert got.sum(axis=1) == pytest.approx(1)


def test_interpolation_reproduces_polynomials_up_to_its_order(rng):
    vertices = rng.integers(0, 64 * 256, size=(40, 3, 2))
    places = np.concatenate([vertices, (vertices + np.roll(vertices, -1, axis=1)) / 2], axis=1)[
        :, [0, 1, 2, 3, 5, 4]
    ]
    px, py = places[..., 0] / 256 - 0.5, places[..., 1] / 256 - 0.5
    polynomials = [
        lambda x, y: 40 + 0 * x,
        lambda x, y: 30 + x + 2 * y,
        lambda x, y: 99 + x - y - 0.02 * x * x + 0.01 * x * y,
    ]
    samples = np.stack([polynomial(px, py) for polynomial in polynomials], axis=1)
    orders = np.tile([0, 1, 2], (40, 1))
    triangles = ScreenTriangles(64, 64, vertices, samples, orders, None, ("r", "g", "b"))
    triangle = np.repeat(np.arange(40), 30)
    x, y = rng.integers(0, 64, size=(2, 1200))
    inside = (barycentric(vertices, triangle, x, y, 8) >= 0).all(axis=1)
    assert inside.sum() > 30
    got = interpolated(triangles, triangle[inside], x[inside], y[inside])
    for channel, polynomial in enumerate(polynomials):
        assert got[:, channel] == pytest.approx(np.clip(polynomial(x[inside], y[inside]), 0, 255), abs=1e-6)


@pytest.mark.parametrize("camera", ["", "from=0,0,1,fov=90", "from=0,0,1,ortho=1.1"])
def test_phong_equals_casting_a_ray_through_every_pixel(camera):
    """Brute force that shares nothing with it: a ray hits the triangle's plane."""
    mesh = load_scene("sphere:168")
    view = parse_camera(camera, mesh)
    projected = project(mesh, view, 24, 24)
    lights, surface = (
        [AmbientLight(), DirectionalLight((-1, 1, 2)), PointLight((2, 2, 2))],
        Material(exponent=5.0),
    )
    triangle, x, y = covered(projected)
    got = phong(projected, triangle, x, y, lights, surface)
    scale = np.tan(np.radians(view.fov / 2)) if view.ortho is None else view.ortho
    for index in range(0, len(x), 7):
        across = np.array([(x[index] + 0.5) / 12 - 1, 1 - (y[index] + 0.5) / 12]) * scale
        ray = view.axes.T @ (np.append(across, -1) if view.ortho is None else np.array([0.0, 0, -1]))
        start = view.eye if view.ortho is None else view.eye + view.axes.T @ np.append(across, 0)
        face = projected.source[triangle[index]]
        corners, normals = mesh.corners[face], mesh.normals[face]
        one, other = corners[1] - corners[0], corners[2] - corners[0]
        _, u, v = np.linalg.solve(np.column_stack([-ray, one, other]), start - corners[0])
        point = corners[0] + u * one + v * other
        normal = normals[0] + u * (normals[1] - normals[0]) + v * (normals[2] - normals[0])
        normal /= np.linalg.norm(normal)
        to_viewer = -ray / np.linalg.norm(ray)
        expected = 255 * surface.reflect(lights, point[None], normal[None], to_viewer[None])[0]
        # The vertices were rounded to 1/256 pixel, a picture of 24 pixels turns that into up to half a level.
        assert got[index] == pytest.approx(np.clip(expected, 0, 255), abs=0.6)


@pytest.mark.parametrize("camera", ["from=0,0,1", "from=0,0,1,ortho=1.05"])
@pytest.mark.parametrize("count", [168, 374, 690])
@pytest.mark.parametrize("exponent", [5, 50])
def test_quadratic_shading_comes_as_near_to_phong_as_float_theory_allows(count, exponent, camera):
    """168 triangles: 48 dB at n = 5, 34 at n = 50; 690: 50 at n = 50; 8 dB above Gouraud always."""
    floor = {(168, 5): 48, (168, 50): 34, (690, 50): 50}.get((count, exponent), 34)
    projected = sphere(camera, f"sphere:{count}", 512)
    surface = Material(exponent=float(exponent))
    pictures = {}
    for shading in ("gouraud", "quadratic"):
        pixels = draw(sample(projected, shading, material=surface), FORMATS).pixels
        shown = visible(pixels, 512, 512)
        pictures[shading] = paint(shown, pixels.value, (0, 0, 0))
    reference = phong(projected, pixels.triangle, pixels.x, pixels.y, material=surface)
    target = paint(shown, reference, (0, 0, 0))
    quadratic, gouraud = psnr(pictures["quadratic"], target), psnr(pictures["gouraud"], target)
    assert quadratic >= floor
    assert quadratic >= gouraud + 8
