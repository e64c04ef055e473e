# SPDX-License-Identifier: Apache-2.0
"""The lattice that words are stepped on, against where the pixels are, in exact rationals."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from quadshade.contract.formats import Formats
from quadshade.setup.coefficients import lattice_frame, lattice_ratios
from quadshade.setup.colour_words import Colours, colour_words, words_by_terms
from quadshade.setup.edges import cut_triangles
from quadshade.setup.literature.terms import Terms, lattice_steps
from quadshade.setup.triangle_setup import setup_triangles
from tests.support.setup_reference import screen_triangles, walk

SIDE = 40
FORMATS = (Formats(num_channels=1, with_depth=0), Formats(num_channels=1, with_depth=0, subpixel_bits=1))


def some_vertices(rng: np.random.Generator, pixel: int, count: int) -> np.ndarray:
    """Small and large, across every border, of either winding; a few with an edge along a scanline."""
    vertices = rng.integers(-SIDE * pixel // 2, SIDE * pixel * 3 // 2, (count, 3, 2))
    vertices[::3] = vertices[::3, :1] + rng.integers(-3 * pixel, 3 * pixel + 1, (len(vertices[::3]), 3, 2))
    vertices[1::7, 1, 1] = vertices[1::7, 0, 1]
    return vertices


def unit_place(corners: list[list[int]], x: Fraction, y: Fraction) -> tuple[Fraction, Fraction]:
    """(u, v) of a place: its shares of the second and the third vertex."""
    (x1, y1), (x2, y2), (x3, y3) = corners
    area = (x2 - x1) * (y3 - y1) - (x3 - x1) * (y2 - y1)
    return ((x - x1) * (y3 - y1) - (y - y1) * (x3 - x1)) / area, (
        (x2 - x1) * (y - y1) - (y2 - y1) * (x - x1)
    ) / area


@pytest.mark.parametrize("fractional", [False, True], ids=["centre", "fractional"])
@pytest.mark.parametrize("formats", FORMATS, ids=["256", "2"])
def test_steps_lead_to_every_pixel(formats: Formats, fractional: bool, rng: np.random.Generator) -> None:
    """m row steps and N column steps from the first pixel, in (u, v) and in pixels from each vertex."""
    pixel = 1 << formats.subpixel_bits
    vertices = some_vertices(rng, pixel, 60)
    primitives = setup_triangles(screen_triangles(vertices, formats, SIDE, SIDE), formats, fractional)
    cut = cut_triangles(vertices, SIDE, SIDE, formats.subpixel_bits)
    pixels = walk(primitives, formats)
    step_by = "n" if fractional else "n_lattice"
    on_edge = 0
    for p in range(len(cut.heads)):
        head, major = cut.heads[p], cut.edges[p, 0]
        corners = vertices[head["triangle"]]
        frame = lattice_frame(corners, head, major, pixel, fractional)
        assert lattice_ratios(frame) == (
            frame.u0 / frame.den0, frame.v0 / frame.den0, frame.pu / frame.denp, frame.pv / frame.denp,
            frame.qu / frame.denq, frame.qv / frame.denq,
        )  # fmt: skip
        (u0, v0, den0), (pu, pv, denp), (qu, qv, denq) = (map(int, frame[at : at + 3]) for at in (0, 3, 6))
        steps = [lattice_steps(corners, vertex, head, major, pixel, fractional) for vertex in range(3)]
        of_primitive = np.flatnonzero(pixels["primitive"] == p)
        for index in of_primitive[[0, -1, *range(1, len(of_primitive) - 1, 11)]]:
            m, n = int(pixels["m"][index]), int(pixels[step_by][index])
            y = Fraction(pixel * (2 * int(pixels["y"][index]) + 1), 2)
            x = Fraction(pixel * (2 * int(pixels["x"][index]) + 1), 2)
            if fractional and head["major_top"] >= 0:
                on_edge += 1
                (xa, ya), (xb, yb) = (corners[head[end]].tolist() for end in ("major_top", "major_bottom"))
                x = xa + (y - ya) * Fraction(xb - xa, yb - ya)
                x += pixel * (-n if head["mirror"] else n)
            u, v = unit_place(corners.tolist(), x, y)
            assert Fraction(u0, den0) + m * Fraction(pu, denp) + n * Fraction(qu, denq) == u
            assert Fraction(v0, den0) + m * Fraction(pv, denp) + n * Fraction(qv, denq) == v
            for (x1, y1), step in zip(corners.tolist(), steps, strict=True):
                assert step.y + m == float((y - y1) / pixel)
                away = step.x + m * step.row_x + n * step.column_x - float((x - x1) / pixel)
                assert abs(away) < 1e-9 if fractional else away == 0.0
    assert on_edge > 100 or not fractional


def test_there_is_a_second_edge_only_where_there_are_rows_of_it(rng: np.random.Generator) -> None:
    cut = cut_triangles(some_vertices(rng, 2, 400), SIDE, SIDE, 1)
    has_second = cut.heads["rows_second"] > 0
    assert has_second.sum() > 50 < (~has_second).sum()
    for name in cut.edges.dtype.names:
        assert not cut.edges[name][~has_second, 2].any()
    assert (cut.edges["height"][has_second, 2] > 0).all()


def constant_terms(colours: Colours, level: float) -> Terms:
    """Coefficients of one level everywhere, for each triangle."""
    values = np.zeros((*colours.samples.shape[:2], 6))
    values[..., 0] = level
    return Terms(np.zeros(len(values), np.int64), values)


def test_what_is_off_by_half_of_full_scale_is_undefined(rng: np.random.Generator) -> None:
    """A method that is off by a known level: its bound is that level, and from 128 on it is undefined."""
    formats = FORMATS[0]
    vertices = some_vertices(rng, 256, 30)
    samples = np.full((30, 1, 6), 100.0)
    colours = Colours(vertices, samples, np.full((30, 1), 2), formats, False, True)
    cut = cut_triangles(vertices, SIDE, SIDE, 8)
    for off in (0.0, 3.0, 127.9, 128.1, 200.0):
        words, bounds = colour_words(cut, colours)
        own = bounds.copy()
        undefined = words_by_terms(cut, colours, constant_terms(colours, 100.0 + off), words, bounds)
        assert undefined.shape == bounds.shape and undefined.all() == undefined.any() == (off > 128)
        if off > 128:
            assert not words.any() and not bounds.any()
        else:
            assert np.allclose(bounds, own + off, atol=1e-6)
            assert (words[:, 0, 0] == round((100.5 + off) * 2**formats.frac_bits)).all()
            assert not words[:, 0, 1:].any()


@pytest.mark.parametrize("method", ["abbas", "general"])
def test_one_column_has_no_column_steps(method: str) -> None:
    """One pixel wide, many high: no word steps along a column, and the bound is the default's."""
    formats = FORMATS[0]
    corners = np.array([[[2600, 300], [2720, 300], [2650, 9000]], [[620, 9000], [600, 400], [700, 9100]]])
    samples = np.array([[[10.0, 200.0, 90.0, 40.0, 120.0, 30.0]], [[50.0, 90.0, 20.0, 220.0, 10.0, 70.0]]])
    triangles = screen_triangles(corners, formats, SIDE, SIDE, samples)
    default, found = (
        setup_triangles(triangles, formats, rounding="independent", method=name) for name in ("unit", method)
    )
    pixels = walk(found, formats)
    assert len(pixels["n_lattice"]) > 30 and not pixels["n_lattice"].any()
    assert not found.words[:, 0, [2, 4, 5]].any() and not default.words[:, 0, [2, 4, 5]].any()
    assert np.allclose(found.bound, default.bound, atol=1e-3)
