# SPDX-License-Identifier: Apache-2.0
"""The model's clocks and pixels are those of the VHDL in GHDL, through the engines, on a larger scene."""

from __future__ import annotations

import numpy as np
import pytest

from quadshade.contract.formats import Formats
from quadshade.engine import draw, draw_words
from quadshade.golden.clocks import count_clocks
from quadshade.golden.compiled import draw_fast
from tests.support.golden_stimuli import triangle_words, triangles_of

SCENES = {
    "default": (Formats(), 180, 96),
    "wide": (Formats(stream_width=128, span_depth=4), 180, 96),
    "starved": (Formats(num_channels=8, with_depth=0), 70, 40),
    "one_span": (Formats(num_channels=1, with_depth=0, max_order=1, stream_width=128, span_depth=1), 250, 64),
}

RECORDED = {
    "default": (Formats(), 0, 0, 263),
    "stalled": (Formats(span_depth=2), 5, 0, 292),
    "shaded": (Formats(stream_width=64), 0, 9, 242),
    "shaded_stalled": (Formats(stream_width=128), 3, 9, 278),
    "wide": (Formats(stream_width=128, span_depth=4), 0, 0, 209),
    "starved": (Formats(num_channels=8, with_depth=0), 0, 0, 302),
    "one_span": (
        Formats(num_channels=1, with_depth=0, max_order=1, stream_width=128, span_depth=1),
        2,
        1,
        319,
    ),
}
"""Formats, stall period, stages behind, clocks of a small scene: the VHDL's where nothing stalls."""


@pytest.mark.parametrize("name", RECORDED)
def test_clocks_are_those_recorded(name: str) -> None:
    formats, stall_period, stages_behind, clocks = RECORDED[name]
    words = triangle_words(formats, np.random.default_rng(1), 7, 64)
    assert draw_fast(words, formats, stall_period, stages_behind).clocks == clocks


def test_nothing_drawn_takes_no_clock() -> None:
    nothing = np.zeros(1, dtype=np.int64)
    assert count_clocks(nothing[:0], nothing, nothing[:0], Formats()) == 0


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
