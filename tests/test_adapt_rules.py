# SPDX-License-Identifier: Apache-2.0
"""Small rules of adaptive pictures, each by itself: edges of parts, bounds, defaults, cores that will do."""

from __future__ import annotations

import numpy as np
import pytest

from quadshade.adapt import ColourShader, centre_error
from quadshade.adapt.polynomial_fit import bend
from quadshade.adapt.polynomial_loops import raise_order
from quadshade.contract.formats import Formats
from quadshade.errors import QuadshadeError
from quadshade.scene import Projected, load_scene, parse_camera, project
from quadshade.scene.subdivide import shared_edges


def looked_at() -> Projected:
    mesh = load_scene("icosphere:0")
    return project(mesh, parse_camera("from=1,2,3", mesh), 12, 10)


@pytest.mark.parametrize("turned", range(8))
def test_two_triangles_share_an_edge_in_any_direction(turned: int) -> None:
    """Level, upright and slanting ones, an end with a small number and one with a large one."""
    towards = [(6, 0), (6, 6), (0, 6), (-6, 6), (-6, 0), (-6, -6), (0, -6), (6, -6)][turned]
    beside = np.array([-towards[1], towards[0]])
    first, second = np.zeros(2, np.int64), np.array(towards)
    vertices = np.array([[first, second, beside], [second, first, -beside]]) + 100
    edges = shared_edges(vertices)
    assert len(edges) == 5
    assert edges.index[0, 0] == edges.index[1, 0] and edges.reversed[0, 0] != edges.reversed[1, 0]


def test_a_bend_is_that_of_each_polynomial() -> None:
    samples = np.random.default_rng(1).normal(size=(2, 4, 6))
    bends = bend(samples)
    assert bends.shape == (2, 4)
    for place in np.ndindex(2, 4):
        a, b, c, *middles = samples[place]
        off = np.array(middles) - [(a + b) / 2, (a + c) / 2, (b + c) / 2]
        assert bends[place] == pytest.approx(4 / 3 * np.abs(off).max())


def test_a_polynomial_of_a_lower_order_is_the_same_one() -> None:
    out = np.empty(6)
    raise_order(np.array([1.0, 5.0, 9.0, 0.0, 0.0, 0.0]), 2, out)
    assert out.tolist() == [1, 5, 9, 3, 5, 7]
    raise_order(np.array([4.0, 5.0, 9.0, 0.0, 0.0, 0.0]), 1, out)
    assert out[:3].tolist() == [4, 4, 4]


def test_errors_at_centres_are_in_the_outputs_units() -> None:
    whole = looked_at()
    usual, fine = centre_error(whole), centre_error(whole, formats=Formats(value_bits=12, frac_bits=16))
    assert usual.max() > 1 and fine == pytest.approx(usual * 4095 / 255)
    assert centre_error(whole, formats=Formats()) == pytest.approx(usual)


def test_colours_take_a_core_of_three_channels_or_one_with_a_shade_unit() -> None:
    whole = looked_at()
    for core in (Formats(), Formats(num_channels=5, num_specular=2, with_shade=1)):
        assert ColourShader(None, None, core, whole).place.tolist() == [0, 1, 2]
    for channels in (2, 4):
        with pytest.raises(QuadshadeError, match=f"num_channels is {channels}"):
            ColourShader(None, None, Formats(num_channels=channels), whole)
