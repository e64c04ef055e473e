# SPDX-License-Identifier: Apache-2.0
"""Set-up words of a few triangles, bit for bit those that were recorded: no change of one goes unseen."""

from __future__ import annotations

import zlib

import numpy as np
import pytest

from quadshade.contract.formats import Formats
from quadshade.contract.triangles import ScreenTriangles
from quadshade.packing.pack import pack_primitives
from quadshade.setup.packet import pack
from quadshade.setup.triangle_setup import setup_triangles
from tests.support.recorded import assert_recorded
from tests.support.setup_reference import screen_triangles

CASES = {
    "plain": (Formats(num_channels=1), {}),
    "fractional": (Formats(num_channels=1), {"fractional": True}),
    "independent": (Formats(num_channels=1), {"rounding": "independent"}),
    "abbas": (Formats(num_channels=1, frac_bits=12), {"method": "abbas"}),
    "general": (Formats(num_channels=1, frac_bits=14), {"method": "general"}),
    "divided": (Formats(num_channels=1, frac_bits=10), {"limit": 0.01}),
    "wide": (Formats(num_channels=2, word_width=60, frac_bits=44, value_bits=12, depth_bits=24), {}),
    "narrow": (Formats(num_channels=1, word_width=20, frac_bits=8, depth_bits=10), {"fractional": True}),
    "whole_pixels": (Formats(num_channels=1, subpixel_bits=0, coord_bits=8, max_order=1), {}),
}


def some_triangles(formats: Formats, count: int = 60, side: int = 60) -> ScreenTriangles:
    """Needles, small and large ones, over the screen's borders, of every order."""
    rng = np.random.default_rng(5)
    pixel = 1 << formats.subpixel_bits
    reach = np.exp(rng.uniform(np.log(2 * pixel), np.log(side * pixel), (count, 3, 1))).astype(np.int64) + 1
    vertices = rng.integers(0, side * pixel, (count, 1, 2)) + rng.integers(-reach, reach + 1, (count, 3, 2))
    vertices[::4, 2] = (vertices[::4, 0] + vertices[::4, 1]) // 2 + rng.integers(-2, 3, (count // 4, 2))
    # Abbas et al. divide by zero here.
    vertices[1::6, 1, 1] = vertices[1::6, 0, 1]
    top = (1 << formats.value_bits) - 1
    samples = rng.uniform(0, top, (count, formats.num_channels, 6))
    samples[::5] = rng.integers(0, 2, samples[::5].shape) * top
    triangles = screen_triangles(vertices, formats, side, side - 7, samples)
    triangles.orders = np.minimum(rng.choice([0, 1, 2, 2], triangles.orders.shape), formats.max_order)
    triangles.depth = rng.uniform(0, (1 << formats.depth_bits) - 1, (count, 3))
    return triangles


def computed(name: str) -> dict[str, object]:
    """Numbers of a case: its primitives' triangles, a sum of its words, bounds, and packets."""
    formats, settings = CASES[name]
    primitives = setup_triangles(some_triangles(formats), formats, **settings)
    short = pack_primitives(primitives, formats)
    return {
        "triangle": primitives.triangle.tolist(),
        "words": primitives.words.reshape(len(primitives.triangle), -1).sum(axis=1).tolist(),
        "bound": primitives.bound.ravel().tolist(),
        "undefined": int(primitives.undefined.sum()),
        "packets": zlib.crc32(pack(primitives, formats).tobytes()),
        "short": zlib.crc32(short.words.tobytes()),
        "added": short.added,
    }


@pytest.mark.parametrize("name", CASES)
def test_words_and_bounds_are_those_recorded(name: str) -> None:
    assert_recorded("setup", name, computed(name))
