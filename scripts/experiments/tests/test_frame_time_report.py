# SPDX-License-Identifier: Apache-2.0
"""The report on frame times: a short series of frames, a bad line, and a text that says what was missed."""

from __future__ import annotations

from pathlib import Path

import pytest

from scripts.experiments.frame_time.report import drawn, mean, on_a_bad_line, plot, report, summary
from scripts.experiments.frame_time.series import CLOCK_HZ, RATES, Series

FRAMES = 6


@pytest.fixture(scope="module")
def series() -> Series:
    """More triangles than the line carries in time, by tenths of a degree."""
    return Series("torus:1152", 3600, ahead=3)


@pytest.fixture(scope="module")
def rows(series: Series, tmp_path_factory: pytest.TempPathFactory) -> list[dict]:
    kept = tmp_path_factory.mktemp("frames") / "rows.jsonl"
    first = drawn(series, kept, FRAMES - 2)
    # A run that was stopped goes on with the levers that it had.
    every = drawn(series, kept, FRAMES)
    assert every[: FRAMES - 2] == first and [row["frame"] for row in every] == list(range(FRAMES))
    return every


def test_every_frame_is_in_time_and_spends_it(rows: list[dict]) -> None:
    for row in rows:
        for baud, fps in RATES:
            assert row[f"whole_{baud}"] <= CLOCK_HZ // fps
            assert row[f"line_{baud}"] >= 0.95 * CLOCK_HZ / fps
        assert row["frame_time_error"] < row["fixed_error"]
    assert len({(row["faces"], row["shading"]) for row in rows}) == 1


def test_a_frame_time_flickers_no_more_than_a_fixed_choice(rows: list[dict]) -> None:
    assert mean(rows, "frame_time_flicker") <= mean(rows, "fixed_flicker")


def test_a_bad_line_makes_no_wrong_picture(series: Series, rows: list[dict]) -> None:
    pictures = [series.again(row) for row in rows[:4]]
    assert [picture.stats.timing["line_bytes"] for picture in pictures] == [
        row["line_bytes"] for row in rows[:4]
    ]
    found = on_a_bad_line([series.sent(picture) for picture in pictures], RATES[0])
    assert found["wrong"] == 0 and 0 <= found["late"] <= 4


def test_the_report_says_what_was_late(rows: list[dict], tmp_path: Path) -> None:
    late = [dict(row) for row in rows]
    late[3]["whole_1000000"] = CLOCK_HZ
    results = {
        "command": "x",
        "whole": 3600,
        "scenes": [summary(late)],
        "vhdl": [],
        "faults": [{"scene": "torus:1152", "baud": 1, "frames": 4, "late": 2, "wrong": 0, "resent": 3}],
    }
    text = report(results)
    assert f"| torus:1152 | {FRAMES} | 1000000, 10 | 1 | 1000.00% |" in text
    assert f"| torus:1152 | {FRAMES} | 3000000, 30 | 0 |" in text and f"{FRAMES} of {FRAMES}" in text
    plot(tmp_path / "plot.png", {"torus:1152": rows})
    assert (tmp_path / "plot.png").stat().st_size > 10_000
