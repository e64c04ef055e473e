# SPDX-License-Identifier: Apache-2.0
"""Computed bytes are those of a session, boards take tiles as they get free, and targets are met."""

from __future__ import annotations

import json

from quadshade.board import Board, BoardSettings
from scripts.experiments import scale


def test_computed_bytes_are_those_of_a_session() -> None:
    settings = BoardSettings(screen_width=40, screen_height=30, with_packed_read=0)
    picture = scale.picture_of("torus:288", (80, 60), settings.formats)
    with Board("sim", settings=settings, engine="model") as board:
        for cost in picture.plan((40, 30), ("colour",)):
            before = board.statistics
            picture.draw_tile(board, cost.tile, ("colour",), "picture")
            after = board.statistics
            computed = scale.take(picture, settings.formats, cost.tile)
            for name, count in (("bytes_sent", computed.sent), ("bytes_received", computed.received)):
                assert abs(after[name] - before[name] - count) < 0.04 * count + 60, name
            assert computed.core > 0


def test_boards_take_tiles_as_they_get_free() -> None:
    assert scale.schedule([5.0, 3.0, 2.0, 2.0], 1) == 12
    assert scale.schedule([5.0, 3.0, 2.0, 2.0], 2) == 7
    assert scale.schedule([5.0, 3.0, 2.0, 2.0], 9) == 5
    # While it is sent to, a board draws; then it is read.
    assert scale.Taken(10, 20, 5).clocks(1_000_000, 1_000_000) == 300
    assert scale.Taken(10, 20, 500).clocks(1_000_000, 1_000_000) == 700


def test_the_report_is_that_of_its_numbers() -> None:
    committed = json.loads(scale.REPORT.with_suffix(".json").read_text())
    assert scale.report(committed) == scale.REPORT.read_text()
    assert [(row["scene"], *row["size"]) for row in committed["tiled"]] == list(scale.TILED)
    four = [row["speed_up"] for row in committed["shared"] if row["boards"] == 4]
    assert len(four) == 2 * len(scale.BOARDS) * len(scale.BAUDS)
    assert min(four) >= scale.WANTED_SPEED
    for row in committed["tiled"]:
        one, tiles = row["one"], row["tiles"]
        assert tiles["tiles"] >= 4
        assert tiles["sent"] + tiles["received"] <= scale.WANTED_BYTES * (one["sent"] + one["received"])
        assert tiles["core"] <= scale.WANTED_BYTES * one["core"]
