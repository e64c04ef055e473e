# SPDX-License-Identifier: Apache-2.0
"""Computed bytes are those of a session, boards take tiles as they get free, and targets are met."""

from __future__ import annotations

import json

import pytest

from quadshade.board import Board, BoardSettings
from scripts.experiments import scale
from scripts.experiments.tile_costs import CRC, PACKED, WHOLE, Taken, picture_of, schedule, take


@pytest.mark.parametrize("way", [WHOLE, PACKED, CRC])
def test_computed_bytes_are_those_of_a_session(way: str) -> None:
    settings = BoardSettings(screen_width=40, screen_height=30, with_packed_read=int(way != WHOLE))
    picture = picture_of("torus:288", (80, 60), settings.formats)
    with Board("sim", settings=settings, engine="model") as board:
        for cost in picture.plan((40, 30), ("colour",)):
            before = board.statistics
            picture.draw_tile(board, cost.tile, ("colour",), "crc" if way == CRC else "picture")
            after = board.statistics
            computed = take(picture, settings, cost.tile)[way]
            for name, count in (("bytes_sent", computed.sent), ("bytes_received", computed.received)):
                assert abs(after[name] - before[name] - count) < 0.04 * count + 60, name
            assert computed.core > 40 * 30 and computed.more >= 3 * 40 * 30


def test_boards_take_tiles_as_they_get_free() -> None:
    assert schedule([5.0, 3.0, 2.0, 2.0], 1) == 12
    assert schedule([5.0, 3.0, 2.0, 2.0], 2) == 7
    assert schedule([5.0, 3.0, 2.0, 2.0], 9) == 5
    # While it is sent to, a board draws; then it is read.
    assert Taken(10, 20, 5).clocks(1_000_000, 1_000_000) == 300
    assert Taken(10, 20, 500).clocks(1_000_000, 1_000_000) == 700
    assert Taken(10, 20, 500, 7).clocks(1_000_000, 1_000_000) == 707


def test_a_picture_far_beyond_the_screen_is_compared() -> None:
    row = scale.large("icosphere:0", 400)
    assert row["tiles"] > 4 and row["differing"] == 0 and row["crc"] == row["model_crc"]


def test_the_report_is_that_of_its_numbers() -> None:
    committed = json.loads(scale.REPORT.with_suffix(".json").read_text())
    assert scale.report(committed) == scale.REPORT.read_text()
    assert [(row["scene"], *row["size"]) for row in committed["tiled"][::2]] == list(scale.TILED)
    four = {
        (row["scene"], row["board"], row["baud"], row["read"]): row["speed_up"][scale.COUNTS.index(4)]
        for row in committed["shared"]
    }
    assert len(four) == 2 * len(scale.BOARDS) * len(scale.BAUDS) * len(scale.SHARED)
    # A tile takes an iCEBreaker its screen's CRC besides, and four have three times as many tiles as one.
    slow = {key for key, speed in four.items() if speed < scale.WANTED_SPEED}
    assert slow == {("bunny.obj", "iCEBreaker", 3_000_000, read) for read in (WHOLE, CRC)}
    assert min(four.values()) > 3.2
    for row in committed["tiled"]:
        one, tiles = row["one"], row["tiles"]
        assert tiles["tiles"] >= 4
        assert tiles["sent"] + tiles["received"] <= scale.WANTED_BYTES * (one["sent"] + one["received"])
        assert tiles["core"] <= scale.WANTED_BYTES * one["core"]
    far = committed["large"]
    assert far["size"] == [4096, 4096] and far["differing"] == 0 and far["crc"] == far["model_crc"]
