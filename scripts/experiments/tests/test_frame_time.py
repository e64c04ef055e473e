# SPDX-License-Identifier: Apache-2.0
"""The time of a picture on a board: what the model says is what the board's VHDL counts, clock for clock."""

from __future__ import annotations

from functools import partial

import pytest

from quadshade.board import BoardSettings
from quadshade.board.frame_time import BoardClock, picture_clocks
from quadshade.packing import pack_primitives
from quadshade.scene import fit_camera, load_scene, project
from quadshade.setup import setup_triangles
from quadshade.shading.sample import sample
from scripts.experiments.frame_time.simulated import counted, picture_frames

SMALL = BoardSettings(screen_width=48, screen_height=32)
SCENES = (("sphere:168", "flat"), ("torus:288", "gouraud"), ("sphere:690", "quadratic"))
"""Little and much on the line, and pictures whose clear takes longer than a frame of their words."""


@pytest.fixture(scope="module")
def pictures() -> list:
    """Triangles and packed words of every scene."""
    made = []
    for scene, shading in SCENES:
        mesh = load_scene(scene)
        projected = project(mesh, fit_camera(mesh), 48, 32, SMALL.formats)
        triangles = sample(projected, shading, formats=SMALL.formats)
        packed = pack_primitives(setup_triangles(triangles, SMALL.formats), SMALL.formats)
        made.append((triangles, packed))
    return made


def test_the_model_counts_the_clocks_of_the_vhdl(pictures: list) -> None:
    clock = BoardClock(SMALL.clk_frequency_hz, SMALL.baud, 48, 32)
    jobs, expected, number = [], [], 0
    for triangles, packed in pictures:
        job = partial(picture_frames, packed.words, None, SMALL.formats)
        sizes = [len(frame) for frame in job(number)]
        number += len(sizes)
        jobs.append(job)
        expected.append(picture_clocks(triangles, SMALL.formats, clock, sizes=sizes))
        bound = picture_clocks(triangles, SMALL.formats, clock)
        assert expected[-1].whole <= bound.whole <= 1.01 * expected[-1].whole
    period = max(one.whole for one in expected) // 50 + 60
    found = counted(SMALL, jobs, period)
    for (_, packed), times, counters in zip(pictures, expected, found, strict=True):
        assert counters["clocks_busy"] == times.busy
        # Counted at the deadline.
        assert counters["primitives"] == len(packed.primitives)
        assert counters["bad_crc"] == counters["bad_cobs"] == counters["overruns"] == 0
        assert times.line < times.whole < 50 * period
