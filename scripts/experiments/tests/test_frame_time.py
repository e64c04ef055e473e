# SPDX-License-Identifier: Apache-2.0
"""The time of a picture on a board: what the model says is what the board's VHDL counts, clock for clock."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import pytest

from quadshade.board import BoardSettings
from quadshade.board.frame_time import BoardClock, picture_clocks, soonest_picture
from quadshade.scene import fit_camera, load_scene, project
from quadshade.shading.sample import sample
from scripts.experiments.frame_time.simulated import counted, picture_frames

SMALL = BoardSettings(screen_width=48, screen_height=32)
FAST = replace(SMALL, with_vertices=1, clk_frequency_hz=100_000_000, baud=2_500_000)
SCENES = (("sphere:168", "flat"), ("torus:288", "gouraud"), ("sphere:690", "quadratic"))
"""Little and much on the line, and pictures whose clear takes longer than a frame of their words."""


@pytest.fixture(scope="module")
def pictures() -> list:
    """Triangles of every scene."""
    made = []
    for scene, shading in SCENES:
        mesh = load_scene(scene)
        projected = project(mesh, fit_camera(mesh), 48, 32, SMALL.formats)
        made.append(sample(projected, shading, formats=SMALL.formats))
    return made


@pytest.mark.parametrize(
    ("settings", "as_vertices"), [(SMALL, False), (FAST, True)], ids=["fields", "vertices"]
)
def test_the_model_counts_the_clocks_of_the_vhdl(
    pictures: list, settings: BoardSettings, as_vertices: bool
) -> None:
    rate = settings.clk_frequency_hz, settings.baud
    clock = BoardClock(*rate, 48, 32, takes_vertices=bool(settings.with_vertices))
    jobs, expected, number, sent = [], [], 0, []
    for triangles in pictures:
        packed, bound = soonest_picture(triangles, settings.formats, clock)
        assert (packed.sent_vertices > len(packed.primitives) / 2) == as_vertices
        sent.append(packed)
        job = partial(picture_frames, packed.words, None, settings.formats)
        sizes = [len(frame) for frame in job(number)]
        number += len(sizes)
        jobs.append(job)
        expected.append(picture_clocks(triangles, settings.formats, clock, sizes=sizes))
        assert expected[-1].whole <= bound.whole <= 1.01 * expected[-1].whole
    a_byte = 10 * rate[0] // rate[1]
    period = max(one.whole for one in expected) // a_byte + 60
    found = counted(settings, jobs, period)
    for packed, times, counters in zip(sent, expected, found, strict=True):
        assert counters["clocks_busy"] == times.busy
        # Counted at the deadline.
        assert counters["primitives"] == len(packed.primitives)
        assert counters["bad_crc"] == counters["bad_cobs"] == counters["overruns"] == 0
        assert times.line < times.whole < a_byte * period
