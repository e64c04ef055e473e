# SPDX-License-Identifier: Apache-2.0
"""Camera, clipping, rounding, culling and depth."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from quadshade.contract.formats import Formats
from quadshade.engine import draw
from quadshade.errors import QuadshadeError
from quadshade.scene import Camera, build_mesh, fit_camera, load_scene, parse_camera, project
from quadshade.scene.clip import clip_triangles
from quadshade.scene.project import doubled_area
from quadshade.shading import sample

FORMATS = Formats()
FRONT = {"target": np.zeros(3), "up": np.array([0.0, 1.0, 0.0])}


def triangle_mesh(*corners):
    return build_mesh(np.array(corners, dtype=float), np.arange(len(corners)).reshape(-1, 3))


def orthographic(half: float = 1.0, near: float | None = None) -> Camera:
    return Camera(np.array([0.0, 0.0, 5.0]), fov=None, ortho=half, near=near, **FRONT)


def area(corners: np.ndarray) -> float:
    return (
        np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum()
        / 2
    )


def test_viewport_puts_the_middle_and_the_border_where_they_belong():
    mesh = triangle_mesh((-1, -1, 0), (1, -1, 0), (0, 1, 0))
    placed = project(mesh, orthographic(), 64, 32)
    assert placed.vertices[0].tolist() == [[16 * 256, 32 * 256], [48 * 256, 32 * 256], [32 * 256, 0]]


def test_perspective_divides_by_the_distance():
    mesh = triangle_mesh((0, 0, 0), (1, 0, -5), (0, 1, 5 - 1.25))
    camera = Camera(np.array([0.0, 0.0, 5.0]), fov=90.0, near=0.5, **FRONT)
    placed = project(mesh, camera, 100, 100)
    expected = np.array([[50, 50], [50 + 50 * 1 / 10, 50], [50, 50 - 50 / 1.25]]) * 256
    assert np.array_equal(placed.vertices[0], np.rint(expected))
    assert placed.weight[0] == pytest.approx([1 / 5, 1 / 10, 1 / 1.25])
    # The near plane's depth is 0, the farthest vertex's the largest, and 1 / distance is linear between.
    expected_depth = (1 / 0.5 - np.array([1 / 5, 1 / 10, 1 / 1.25])) / (1 / 0.5 - 1 / 10) * 65535
    assert placed.depth[0] == pytest.approx(expected_depth)


@pytest.mark.parametrize(("bits", "step"), [(8, 256), (0, 1), (4, 16)])
def test_vertices_round_to_nearest_ties_to_even(bits, step):
    """In a view of 8 pixels for 8 units, a coordinate of k + 1/2 sub-pixels must go to the even neighbour."""
    ties = (np.arange(-3, 3) * 2 + 1) / 2 / step
    mesh = build_mesh(
        np.array([[x, y, 0] for x in ties for y in (-2.0, 2.0)] + [[3.0, 0.0, 0.0]]),
        np.array([[2 * k + 1, 2 * k, 12] for k in range(6)]),
    )
    placed = project(mesh, orthographic(4.0), 8, 8, Formats(subpixel_bits=bits))
    assert placed.vertices[:, 0, 0].tolist() == [4 * step + k for k in (-2, -2, 0, 0, 2, 2)]


def test_culling_drops_what_is_seen_from_behind():
    front, back = ((-1, -1, 0), (1, -1, 0), (0, 1, 0)), ((-1, -1, 0), (0, 1, 0), (1, -1, 0))
    mesh = triangle_mesh(*front, *back, (0, 0, 0), (1, 1, 0), (0.5, 0.5, 0))
    placed = project(mesh, orthographic(), 32, 32)
    assert placed.source.tolist() == [0]
    both = project(mesh, orthographic(), 32, 32, cull=False)
    assert both.source.tolist() == [0, 1]
    assert np.allclose(both.normal, (0, 0, 1))


@pytest.mark.parametrize(
    "camera", ["", "from=1,1,1", "from=1,1,1,ortho=1.5", "from=0,1,0", "from=0,-1,0,fov=60", "fov=5"]
)
@pytest.mark.parametrize("scene", ["sphere:168", "torus:288"])
def test_the_fitted_camera_shows_the_whole_scene(scene, camera):
    mesh = load_scene(scene)
    placed = project(mesh, parse_camera(camera, mesh), 90, 60, cull=False)
    shown = len(np.unique(placed.source))
    assert shown >= len(mesh) - 2 * 24  # edge-on triangles may round to nothing
    assert placed.vertices.min() >= 0
    assert (placed.vertices.max(axis=(0, 1)) <= np.array([90, 60]) * 256).all()
    assert placed.depth.min() >= 0 and placed.depth.max() <= 65535
    assert np.ptp(placed.vertices[..., 0]) > 0.6 * 60 * 256


def test_depth_is_nearer_in_front():
    mesh = triangle_mesh((-1, -1, 0), (1, -1, 0), (0, 1, 0), (-1, -1, 1), (1, -1, 1), (0, 1, 1))
    for camera in (orthographic(), parse_camera("from=0,0,1", mesh)):
        placed = project(mesh, camera, 32, 32)
        assert (placed.depth[0] > placed.depth[1]).all()
        assert placed.back_to_front().source.tolist() == [0, 1]
        assert placed.ordered(np.array([1, 0])).back_to_front().source.tolist() == [0, 1]


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=50, deadline=None)
def test_clipping_conserves_the_area_on_both_sides(seed):
    rng = np.random.default_rng(seed)
    corners = rng.normal(size=(20, 3, 5))
    plane = np.append(rng.normal(size=3), rng.normal() / 2)
    inner, inner_source = clip_triangles(corners, plane[None])
    outer, outer_source = clip_triangles(corners, -plane[None])
    assert (inner[..., :3] @ plane[:3] + plane[3] >= -1e-9).all()
    assert area(inner[..., :3]) + area(outer[..., :3]) == pytest.approx(area(corners[..., :3]))
    assert (np.diff(inner_source) >= 0).all() and (np.diff(outer_source) >= 0).all()
    for row, source in zip(inner, inner_source, strict=True):
        # Attributes stay the linear function of the position that they were on the triangle.
        weights = np.linalg.solve(corners[source][:, :3].T, row[0, :3])
        assert weights.sum() == pytest.approx(1)
        assert np.allclose(weights @ corners[source], row[0], atol=1e-6)


def test_clipping_a_triangle_that_contains_the_box_leaves_the_box():
    planes = np.array([[1, 0, 0, 1], [-1, 0, 0, 1], [0, 1, 0, 1], [0, -1, 0, 1]], dtype=float)
    corners = np.array([[[-50, -50, 0], [50, -50, 0], [0, 90, 0]]], dtype=float)
    clipped, source = clip_triangles(corners, planes)
    assert area(clipped) == pytest.approx(4)
    assert (source == 0).all()
    assert (np.cross(clipped[:, 1] - clipped[:, 0], clipped[:, 2] - clipped[:, 0])[:, 2] > 0).all()


@given(st.integers(0, 2**32 - 1), st.booleans(), st.sampled_from([3, 5, 12]), st.sampled_from([0, 4, 8]))
@settings(max_examples=60, deadline=None)
def test_no_vertex_leaves_the_guard_band(seed, perspective, coord_bits, subpixel_bits):
    rng = np.random.default_rng(seed)
    mesh = build_mesh(rng.normal(size=(30, 3)) * 10.0 ** rng.uniform(-2, 3), np.arange(30).reshape(-1, 3))
    formats = Formats(coord_bits=coord_bits, subpixel_bits=subpixel_bits)
    camera = Camera(
        np.array([0.0, 0.0, 1.0]),
        fov=60.0 if perspective else None,
        ortho=None if perspective else 1,
        **FRONT,
    )
    placed = project(mesh, camera, 8, 8, formats, cull=False)
    low, high = formats.guard_band
    assert placed.vertices.min(initial=0) >= low and placed.vertices.max(initial=0) <= high
    assert np.isfinite(placed.depth).all() and (placed.depth >= 0).all() and (placed.depth <= 65535).all()


def test_a_neighbour_of_a_clipped_triangle_shares_its_edge_to_the_last_sub_pixel():
    """A fan of triangles that reach far out of the guard band: every edge is used twice."""
    corners = np.array([[1e4, 1e4], [-1e4, 2e4], [-3e4, -1e4], [2e4, -3e4]]) @ np.array([[1, 0.3], [-0.2, 1]])
    vertices = np.concatenate([[[0.013, 0.021, 0]], np.column_stack([corners, np.full(4, -3.0)])])
    mesh = build_mesh(vertices, np.array([[0, k + 1, (k + 1) % 4 + 1] for k in range(4)]))
    placed = project(mesh, orthographic(), 64, 64)
    assert len(placed) > 4
    edges: dict = {}
    for polygon in placed.vertices.tolist():
        for one, other in zip(polygon, polygon[1:] + polygon[:1], strict=True):
            edges[tuple(one), tuple(other)] = edges.get((tuple(one), tuple(other)), 0) + 1
    low, high = FORMATS.guard_band[0] + 1, FORMATS.guard_band[1] - 1
    for one, other in edges:
        on_border = any(one[axis] == other[axis] and one[axis] in (low, high) for axis in range(2))
        assert on_border or edges.get((other, one)) == 1
    total = -doubled_area(placed.vertices).sum() / 2
    assert total == (high - low) ** 2


def test_the_near_plane_cuts_what_reaches_behind_the_eye():
    mesh = triangle_mesh((-1, -1, -4), (1, -1, -4), (0, -1, 30))
    camera = Camera(np.array([0.0, 0.0, 5.0]), fov=60.0, near=1.0, **FRONT)
    placed = project(mesh, camera, 64, 64, cull=False)
    assert len(placed) == 2
    assert placed.position[..., 2].max() == pytest.approx(4)
    assert (placed.weight <= 1 + 1e-12).all()
    assert (
        len(
            project(
                mesh, Camera(np.array([0.0, 0, -50]), target=np.array([0.0, 0, -60]), up=FRONT["up"]), 8, 8
            )
        )
        == 0
    )


def covered(mesh, camera, cull=True) -> set:
    """Pixels with the faces that cover them."""
    placed = project(mesh, camera, 32, 32, cull=cull)
    pixels = draw(sample(placed, "flat"), FORMATS).pixels
    return set(
        zip(pixels.x.tolist(), pixels.y.tolist(), placed.source[pixels.triangle].tolist(), strict=True)
    )


@pytest.mark.parametrize("cull", [True, False])
@pytest.mark.parametrize("seed", range(12))
def test_a_fitted_near_plane_hides_nothing(seed, cull):
    """The viewer is inside a scene with parts near and far, and sees what a near plane at the eye shows."""
    rng = np.random.default_rng(seed)
    size = 10.0 ** rng.uniform(-4, 3, size=(40, 1, 1))
    mesh = build_mesh((size * rng.normal(size=(40, 3, 3))).reshape(-1, 3), np.arange(120).reshape(-1, 3))
    eye = {"eye": np.zeros(3), "target": np.array([0, 0, -1.0]), "up": np.array([0, 1.0, 0]), "fov": 60.0}
    fitted, close = covered(mesh, Camera(**eye), cull), covered(mesh, Camera(**eye, near=1e-7), cull)
    assert len(close) > 100
    # Where a near plane cuts, the corners of the cut are rounded to sub-pixels.
    assert len(fitted ^ close) <= 0.01 * len(close)
    assert {face for *_, face in close} - {face for *_, face in fitted} == set()


def test_what_is_not_seen_does_not_move_the_near_plane():
    far = [(-50, -50, -1000), (50, -50, -1000), (0, 50, -1000)]
    beside, edge_on = [(5, 0, -0.1), (6, 0, -0.1), (5, 1, -0.1)], [(0, -1, 1), (0, 1, 1), (0, 0, -2)]
    behind = [(-1, -1, -0.5), (0, 1, -0.5), (1, -1, -0.5)]
    eye = {"eye": np.zeros(3), "target": np.array([0, 0, -1.0]), "up": np.array([0, 1.0, 0])}
    for hidden in (beside, edge_on, behind):
        placed = project(triangle_mesh(*far, *hidden), Camera(**eye), 32, 32)
        assert placed.source.tolist() == [0] and placed.depth.max() == 65535 and placed.notes == ()
        fixed = project(triangle_mesh(*far, *hidden), Camera(**eye, near=1.0), 32, 32)
        assert np.array_equal(placed.depth, fixed.depth) and np.array_equal(placed.vertices, fixed.vertices)
    (note,) = project(triangle_mesh(*far, *behind), Camera(**eye, near=0.01), 32, 32, cull=False).notes
    assert "near is 0.01" in note and "1e+03" in note and "16 bits" in note
    # One step at the far end, from its definition.
    step = 1000 - 1 / (1 / 1000 + (1 / 0.01 - 1 / 1000) / 65535)
    assert f"resolve only {step:.3g} there" in note


@pytest.mark.parametrize("exponent", [3, 6, 10, 13, 16, 99])
@pytest.mark.parametrize("near", [None, 1e-6, 0.01])
def test_what_reaches_very_far_out_is_clipped_and_closed(exponent, near):
    """A plane below the viewer, as a fan around a point near by, in a view that is turned."""
    rng = np.random.default_rng(exponent)
    angle = np.sort(rng.uniform(0, 2 * np.pi, 9))
    ring = 10.0**exponent * np.stack([np.cos(angle), np.sin(angle), np.zeros(9)], axis=1)
    vertices = np.concatenate([[[0.1, 0.3, 0.0]], ring])
    mesh = build_mesh(vertices, np.array([[0, k + 1, (k + 1) % 9 + 1] for k in range(9)]))
    camera = Camera(
        np.array([0.0, 0, 1]), np.array([0.3, 1.0, 0.8]), np.array([0.1, 0, 1.0]), fov=70.0, near=near
    )
    if exponent > 14:
        with pytest.raises(QuadshadeError, match="units away"):
            project(mesh, camera, 64, 64, cull=False)
        return
    placed = project(mesh, camera, 64, 64, cull=False)
    assert len(placed) and np.isfinite(placed.depth).all() and (placed.weight > 0).all()
    drawing = draw(sample(placed, "flat"), FORMATS).pixels
    # Every pixel once: no gap and no overlap; those are the pixels below the horizon.
    places = drawing.y * 64 + drawing.x
    assert len(np.unique(places)) == len(places)
    right, up, back = camera.axes
    x, y = np.meshgrid(np.arange(64) + 0.5 - 32, np.arange(64) + 0.5 - 32)
    reach = 32 / np.tan(np.radians(35))
    down = -(x * right[2] - y * up[2] - reach * back[2])
    hit = np.zeros(64 * 64, bool)
    hit[places] = True
    clear = np.abs(down) > 1.5 * (1 + reach * 10.0 ** (1 - exponent))
    assert np.array_equal(hit.reshape(64, 64)[clear], (down > 0)[clear])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("eye=0,0", "2 numbers"),
        ("eye=0,0,nan", "finite"),
        ("eye=a,b,c", "finite"),
        ("roll=3", "unknown key"),
        ("0,0,3", "key=value"),
        ("fov=20,fov=30", "twice"),
        ("fov=0", "fov is 0"),
        ("fov=180", "fov is 180"),
        ("fov=30,ortho=1", "either"),
        ("ortho=-1", "ortho"),
        ("near=0", "near"),
        ("eye=0,0,0,target=0,0,0", "one point"),
        ("from=0,0,0", "direction"),
        ("from=0,0,1,eye=0,0,1", "both"),
        ("from=0,0,1,up=0,0,1", "along the view"),
    ],
)
def test_a_bad_camera_is_refused(text, message):
    mesh = load_scene("sphere:168")
    with pytest.raises(QuadshadeError, match=message):
        project(mesh, parse_camera(text, mesh), 8, 8)


@pytest.mark.parametrize("size", [(0, 5), (5, 0), (4097, 5), (5, -1)])
def test_a_size_out_of_range_is_refused(size):
    mesh = load_scene("sphere:168")
    with pytest.raises(QuadshadeError, match="size"):
        project(mesh, fit_camera(mesh), *size)


def test_a_picture_is_seen_three_quarters_from_above():
    mesh = load_scene("cube:2")
    back = parse_camera("", mesh).axes[2]
    # Three faces of a cube are seen: from the right, from above and from the front, the front one most.
    assert back[2] > back[0] > back[1] > 0.3
    assert parse_camera("fov=30", mesh).axes[2] == pytest.approx(back)
    assert parse_camera("eye=0,0,9", mesh).axes[2] == pytest.approx([0, 0, 1])
