# SPDX-License-Identifier: Apache-2.0
"""The model's clocks and pixels are those of the VHDL in GHDL, through the engines, on a larger scene."""

from __future__ import annotations

import numpy as np
import pytest

from quadshade.contract.formats import Formats
from quadshade.engine import draw, draw_words
from tests.support.golden_stimuli import triangle_words, triangles_of

SCENES = {
    "default": (Formats(), 180, 96),
    "wide": (Formats(stream_width=128, span_depth=4), 180, 96),
    "starved": (Formats(num_channels=8, with_depth=0), 70, 40),
    "one_span": (Formats(num_channels=1, with_depth=0, max_order=1, stream_width=128, span_depth=1), 250, 64),
}


@pytest.mark.parametrize("name", SCENES)
def test_clocks_are_those_of_the_vhdl(name: str, rng: np.random.Generator) -> None:
    formats, triangles, size = SCENES[name]
    words = triangle_words(formats, rng, triangles, size)
    model = draw_words(words, formats)
    vhdl = draw_words(words, formats, engine="ghdl")
    assert len(model.x) > 2000
    assert vhdl.clocks == model.clocks
    for field in ("packet", "x", "y", "value"):
        np.testing.assert_array_equal(getattr(vhdl, field), getattr(model, field), err_msg=field)


@pytest.mark.parametrize("fractional", [False, True], ids=["centres", "fractional"])
def test_engines_draw_the_same(fractional: bool, rng: np.random.Generator) -> None:
    formats = Formats(stream_width=64)
    triangles = triangles_of(formats, rng, 40)
    model = draw(triangles, formats, "model", fractional=fractional)
    vhdl = draw(triangles, formats, "ghdl", fractional=fractional)
    for field in ("triangle", "x", "y", "value", "depth"):
        np.testing.assert_array_equal(
            getattr(vhdl.pixels, field), getattr(model.pixels, field), err_msg=field
        )
    assert {**vhdl.stats, "engine": "model"} == model.stats
    assert len(model.pixels) > 500
