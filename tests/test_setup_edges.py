# SPDX-License-Identifier: Apache-2.0
"""Coverage is that of exact half-plane arithmetic, shared edges are watertight, and packets are few."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import Delaunay

from quadshade.contract.formats import Formats
from quadshade.setup.edges import cut_triangles
from quadshade.setup.triangle_setup import setup_triangles
from tests.support.setup_reference import half_plane_pixels, screen_triangles, walk

FORMATS = (
    Formats(),
    Formats(coord_bits=6),
    Formats(coord_bits=9, subpixel_bits=4),
    Formats(coord_bits=7, subpixel_bits=0),
    Formats(coord_bits=10, subpixel_bits=1),
    Formats(coord_bits=13, subpixel_bits=12),
)


def name(formats: Formats) -> str:
    return f"coord{formats.coord_bits}_subpixel{formats.subpixel_bits}"


def random_triangles(rng: np.random.Generator, pixel: int, screen: int) -> np.ndarray:
    """Any shape, on, across and off the screen."""
    return rng.integers(-screen * pixel // 2, screen * pixel * 3 // 2, (800, 3, 2))


def tiny_triangles(rng: np.random.Generator, pixel: int, screen: int) -> np.ndarray:
    """Under six pixels across, half of them under one."""
    centre = rng.integers(-pixel, (screen + 1) * pixel, (1600, 1, 2))
    reach = np.where(np.arange(1600) % 2, 3 * pixel, pixel // 2 + 1)[:, None, None]
    return centre + rng.integers(-reach, reach + 1, (1600, 3, 2))


def sliver_triangles(rng: np.random.Generator, pixel: int, screen: int) -> np.ndarray:
    """Down to one sub-pixel wide, up to hundreds of pixels long, in every direction."""
    start = rng.integers(0, screen * pixel, (800, 1, 2))
    reach = min(400, 2 * screen) * pixel
    end = start + rng.integers(-reach, reach + 1, (800, 1, 2))
    apart = np.where(np.arange(800) % 2, 2, max(pixel, 2))[:, None, None]
    vertices = np.concatenate([start, start + rng.integers(-apart, apart + 1, (800, 1, 2)), end], axis=1)
    vertices[::8, 2, 0] = vertices[::8, 0, 0]
    vertices[1::8, 2, 1] = vertices[1::8, 0, 1]
    return vertices


def grid_triangles(rng: np.random.Generator, pixel: int, screen: int) -> np.ndarray:
    """Vertices on pixel centres and corners: ties everywhere, horizontal and vertical edges, zero area."""
    half = max(pixel // 2, 1)
    vertices = rng.integers(-4, 24, (1600, 3, 2)) * half
    vertices[::4, 1, 1] = vertices[::4, 0, 1]
    vertices[1::4, 2, 0] = vertices[1::4, 0, 0]
    vertices[2::16, 2] = 2 * vertices[2::16, 1] - vertices[2::16, 0]
    vertices[3::32, 2] = vertices[3::32, 0]
    return vertices


FAMILIES = (random_triangles, tiny_triangles, sliver_triangles, grid_triangles)


def sorted_pixels(pixels: np.ndarray) -> np.ndarray:
    return pixels[np.lexsort((pixels[:, 1], pixels[:, 2], pixels[:, 0]))]


def drawn_pixels(vertices: np.ndarray, formats: Formats, width: int, height: int) -> np.ndarray:
    """(n, 3) triangle, x, y in the order of the walk."""
    primitives = setup_triangles(screen_triangles(vertices, formats, width, height, order=0), formats)
    pixels = walk(primitives, formats)
    return np.stack([primitives.triangle[pixels["primitive"]], pixels["x"], pixels["y"]], axis=1)


def check_coverage(vertices: np.ndarray, formats: Formats, width: int, height: int) -> int:
    """Pixels are those of the half-planes, in triangle order and top to bottom; returns their number."""
    drawn = drawn_pixels(vertices, formats, width, height)
    expected = half_plane_pixels(vertices, width, height, formats.subpixel_bits)
    assert (np.lexsort((drawn[:, 2], drawn[:, 0])) == np.arange(len(drawn))).all(), "not in drawing order"
    if not np.array_equal(sorted_pixels(drawn), sorted_pixels(expected)):
        for index in range(len(vertices)):
            got = {tuple(p) for p in drawn[drawn[:, 0] == index, 1:].tolist()}
            want = {tuple(p) for p in expected[expected[:, 0] == index, 1:].tolist()}
            assert got == want, f"triangle {index} {vertices[index].tolist()} of {name(formats)}"
        raise AssertionError("a pixel is drawn twice")
    return len(expected)


@pytest.mark.parametrize("family", FAMILIES, ids=lambda f: f.__name__)
@pytest.mark.parametrize("formats", FORMATS, ids=name)
def test_coverage(formats: Formats, family, rng: np.random.Generator) -> None:
    """Over all parameters 28,800 triangles."""
    width, height = (min(side, 1 << formats.coord_bits) for side in (90, 64))
    vertices = family(rng, 1 << formats.subpixel_bits, 64)
    low, high = formats.guard_band
    assert check_coverage(np.clip(vertices, low, high), formats, width, height) > 100


def test_coverage_of_all_tiny_triangles() -> None:
    """Every triangle with vertices on a lattice of half pixels about a screen of two by two pixels."""
    formats = Formats(coord_bits=3, subpixel_bits=1)
    side = np.arange(-1, 6)
    points = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    corners = np.stack(np.meshgrid(*3 * [np.arange(len(points))], indexing="ij"), axis=-1).reshape(-1, 3)
    corners = corners[(corners[:, 0] < corners[:, 1]) & (corners[:, 1] < corners[:, 2])]
    check_coverage(points[corners], formats, 2, 2)


@pytest.mark.parametrize("formats", FORMATS, ids=name)
def test_coverage_at_the_guard_band(formats: Formats, rng: np.random.Generator) -> None:
    """The largest coordinates: int64 holds every intermediate, fields hold every state."""
    low, high = formats.guard_band
    vertices = rng.choice([low, low + 1, 0, 1, high // 2, high - 1, high], (300, 3, 2))
    vertices[::3] = rng.integers(low, high + 1, (100, 3, 2))
    # A strip of the screen, so that the reference need not visit 64 million pixels a triangle.
    for width, height in ((3, 1 << min(formats.coord_bits, 9)), (1 << min(formats.coord_bits, 9), 3)):
        check_coverage(vertices, formats, width, height)


@settings(max_examples=300)
@given(
    st.lists(st.tuples(st.integers(-700, 1400), st.integers(-700, 1400)), min_size=3, max_size=3),
    st.integers(1, 40),
    st.integers(1, 40),
)
def test_coverage_of_any_triangle(corners: list[tuple[int, int]], width: int, height: int) -> None:
    check_coverage(np.array([corners]), Formats(coord_bits=6, subpixel_bits=4), width, height)


def test_winding_does_not_matter(rng: np.random.Generator) -> None:
    formats = Formats()
    vertices = random_triangles(rng, 256, 64)
    drawn = drawn_pixels(vertices, formats, 64, 64)
    for order in ([0, 2, 1], [1, 2, 0], [2, 1, 0]):
        assert np.array_equal(drawn, drawn_pixels(vertices[:, order], formats, 64, 64))


def counts(vertices: np.ndarray, formats: Formats, side: int) -> np.ndarray:
    """(side, side) how often each pixel is drawn."""
    drawn = drawn_pixels(vertices, formats, side, side)
    return np.bincount(drawn[:, 2] * side + drawn[:, 1], minlength=side * side).reshape(side, side)


@pytest.mark.parametrize("snap", (1, 128, 256), ids=("any", "half_pixels", "pixels"))
def test_mesh_is_watertight(snap: int, rng: np.random.Generator) -> None:
    """A triangulated square larger than the screen: 160,000 pixels, each drawn exactly once."""
    side = 400
    points = rng.integers(-20 * 256, (side + 20) * 256, (3000, 2)) // snap * snap
    frame = np.array([[-40, -40], [side + 40, -40], [-40, side + 40], [side + 40, side + 40]]) * 256
    points = np.unique(np.concatenate([points, frame]), axis=0)
    drawn = counts(points[Delaunay(points).simplices], Formats(), side)
    assert drawn.size == 160_000
    assert (drawn == 1).all(), f"y, x: {np.argwhere(drawn != 1)[:5].tolist()}"


@pytest.mark.parametrize("centre", ((50_000, 51_234), (51_200, 51_200), (51_328, 51_328)))
def test_fan_is_watertight(centre: tuple[int, int], rng: np.random.Generator) -> None:
    """Needles around one point, any place, pixel corner, pixel centre: 160,000 pixels, each exactly once."""
    side, spokes = 400, 1500
    angle = np.sort(rng.uniform(0, 2 * np.pi, spokes))
    angle = np.concatenate([angle, np.arange(8) * np.pi / 4])
    angle.sort()
    rim = np.rint(np.array(centre) + 600 * 256 * np.stack([np.cos(angle), np.sin(angle)], axis=1))
    rim = rim.astype(np.int64)
    middle = np.broadcast_to(np.array(centre), rim.shape)
    drawn = counts(np.stack([middle, rim, np.roll(rim, -1, axis=0)], axis=1), Formats(), side)
    assert (drawn == 1).all(), f"y, x: {np.argwhere(drawn != 1)[:5].tolist()}"


def test_one_packet_inside_the_screen(rng: np.random.Generator) -> None:
    vertices = rng.integers(0, 64 * 256 + 1, (2000, 3, 2))
    cut = cut_triangles(vertices, 64, 64, 8)
    assert np.bincount(cut.heads["triangle"]).max() == 1


def fewest_primitives(vertices: np.ndarray, side: int) -> int:
    """By search over all cuts into rows where one side has one edge or border, the other at most two."""
    pixels = half_plane_pixels(vertices[None], side, side, 0)
    rows = sorted(set(pixels[:, 2].tolist()))
    corners = vertices[np.argsort(vertices[:, 1], kind="stable")]
    spans = {row: pixels[pixels[:, 2] == row, 1] for row in rows}

    def runs(side_of, kept: list[int]) -> int:
        """How many straight runs a side has over some rows: edges and borders that follow each other."""
        names = [side_of(row) for row in kept]
        return 1 + sum(a != b for a, b in pairwise(names))

    (x0, y0), (x1, y1), (x2, y2) = corners.tolist()
    knee_right = (x1 - x0) * (y2 - y0) > (x2 - x0) * (y1 - y0)

    def edge(row: int, right: bool) -> str:
        if right and spans[row].max() == side - 1 or not right and spans[row].min() == 0:
            (xa, ya), (xb, yb) = ((x0, y0), (x2, y2))
            if right == knee_right:
                (xa, ya), (xb, yb) = ((x0, y0), (x1, y1)) if 2 * row + 1 < 2 * y1 else ((x1, y1), (x2, y2))
            column = -((-((2 * xa - 1) * (yb - ya) + (2 * row + 1 - 2 * ya) * (xb - xa))) // (2 * (yb - ya)))
            if right and column > side or not right and column < 0:
                return "border"
        return "long" if right != knee_right else ("first" if 2 * row + 1 < 2 * y1 else "second")

    best = [0] + [len(rows)] * len(rows)
    for end in range(1, len(rows) + 1):
        for start in range(end):
            kept = list(range(rows[start], rows[end - 1] + 1))
            if any(row not in spans for row in kept):
                kept = [row for row in kept if row in spans]
            left, right = (runs(lambda row, r=r: edge(row, r), kept) for r in (False, True))
            if min(left, right) == 1 and max(left, right) <= 2:
                best[end] = min(best[end], best[start] + 1)
    return best[len(rows)]


def test_fewest_packets(rng: np.random.Generator) -> None:
    """No cut of the triangle into runs of scanlines needs fewer packets."""
    vertices = rng.integers(-20, 32, (800, 3, 2))
    cut = cut_triangles(vertices, 12, 12, 0)
    got = np.bincount(cut.heads["triangle"], minlength=len(vertices))
    for index, corners in enumerate(vertices):
        assert got[index] <= fewest_primitives(corners, 12), corners.tolist()
    assert (got == 2).sum() > 50, "too few triangles across the border to say anything"
