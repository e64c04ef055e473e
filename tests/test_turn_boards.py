# SPDX-License-Identifier: Apache-2.0
"""Films on several boards: whole frames go to boards that are free, and what is left is drawn in tiles."""

from __future__ import annotations

import threading
from pathlib import Path

import numpy as np
import pytest

import quadshade
from quadshade.animation import animate
from quadshade.board import Board
from quadshade.contract.formats import Formats
from quadshade.errors import QuadshadeError
from quadshade.image import read_picture
from quadshade.rendering import Reports
from scripts.experiments.pool_faults import doom
from tests.test_board_pool import boards, settings_of
from tests.test_setup_tile import ICEBREAKER

FRAMES = 5
FILM = {"frames": FRAMES, "degrees": 90, "size": (61, 47), "errors": False}
MIXED = (
    settings_of(61, 47),
    settings_of(24, 20, Formats(word_width=40, frac_bits=30), clk_frequency_hz=8_000_000),
)


def pictures(folder: Path) -> list[np.ndarray]:
    """The frames that a film wrote."""
    return [read_picture(folder / f"{number:04d}.png") for number in range(FRAMES)]


def film(folder: Path, reports: Reports | None = None, **port: object) -> list[animate.FrameRow]:
    return quadshade.turn("torus:72", reports=reports or Reports(str), **FILM, **port).save(folder)


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> list[np.ndarray]:
    folder = tmp_path_factory.mktemp("model")
    film(folder, engine="model")
    return pictures(folder)


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> list[tuple[Board, ...]]:
    """The boards of each frame that is begun; the first two are begun at the same time."""
    begun: list[tuple[Board, ...]] = []
    whole, both = animate.Animation._on_one, threading.Barrier(2)

    def seen(self: animate.Animation, board: object, number: int, pace: object) -> animate.Drawn:
        begun.append(board.pool.everyone)
        if len(begun) <= 2:
            both.wait()
        return whole(self, board, number, pace)

    monkeypatch.setattr(animate.Animation, "_on_one", seen)
    return begun


def test_whole_frames_go_to_boards_that_are_free(
    tmp_path: Path, model: list[np.ndarray], drawn: list[tuple[Board, ...]]
) -> None:
    """Of five frames on two boards four are dealt, and the last one is shared in tiles."""
    with boards(*MIXED) as opened:
        before = [board.statistics for board in opened]
        rows = film(tmp_path, port=opened)
        after = [board.statistics for board in opened]
    sent = [now["bytes_sent"] - then["bytes_sent"] for now, then in zip(after, before, strict=True)]
    assert [len(by) for by in drawn] == [1, 1, 1, 1, 2]
    assert {by[0] for by in drawn} == set(opened)
    assert min(sent) > 0 and sum(row.bytes for row in rows) == sum(sent)
    assert all(map(np.array_equal, pictures(tmp_path), model))


def test_a_film_on_boards_of_all_kinds_is_that_of_the_least(tmp_path: Path) -> None:
    """Grey, in painter's order, whichever board draws a frame; and it is said once."""
    told: list[str] = []
    with boards(settings_of(24, 20), settings_of(61, 47, ICEBREAKER)) as opened:
        film(tmp_path / "mixed", Reports(told.append), port=opened)
        film(tmp_path / "tiles", port=[opened[1], opened[0]])
    assert told.count("drawn in grey: the board has one channel") == 1
    shown = pictures(tmp_path / "mixed")
    assert all((picture == picture[..., :1]).all() and picture.any() for picture in shown)
    assert all(map(np.array_equal, shown, pictures(tmp_path / "tiles")))


@pytest.mark.parametrize("death", ["pulled", "other bits"])
def test_a_lost_board_leaves_its_frames_to_the_others(
    tmp_path: Path, model: list[np.ndarray], drawn: list[tuple[Board, ...]], death: str
) -> None:
    told: list[str] = []
    with boards(*MIXED, reconnect_seconds=0.1) as opened:
        doom(opened[0], death, 200)
        film(tmp_path, Reports(told.append), port=opened)
    [said] = [text for text in told if "is lost" in text]
    assert said.endswith("; its work goes to the others") and "no board is left" not in said
    assert all(map(np.array_equal, pictures(tmp_path), model))


def test_the_last_board_says_how_many_frames_are_missing(tmp_path: Path, model: list[np.ndarray]) -> None:
    told: list[str] = []
    with boards(*MIXED, reconnect_seconds=0.1) as opened:
        for board in opened:
            doom(board, "pulled", 3000)
        with pytest.raises(
            QuadshadeError, match=r"\d frames are missing, as no board is left: .*start it again"
        ):
            film(tmp_path, Reports(told.append), port=opened)
    assert sum("is lost" in text for text in told) == 2
    # What is done is kept, and a run with other boards goes on.
    with boards(*MIXED[::-1]) as opened:
        film(tmp_path, port=opened)
    assert all(map(np.array_equal, pictures(tmp_path), model))


def test_a_film_may_be_larger_than_a_cores_usual_coordinates() -> None:
    asked = {"frames": 2, "size": (5000, 3), "errors": False, "engine": "model"}
    film = quadshade.turn("cube:2", port="sim", **asked)
    assert np.array_equal(
        film[1].array, quadshade.turn("cube:2", generics={"coord_bits": 13}, **asked)[1].array
    )
    assert film[1].array.any()
    with pytest.raises(QuadshadeError, match="9000x3 pixels; give 1x1 to 8192x8192"):
        quadshade.turn("cube:2", port="sim", **asked | {"size": (9000, 3)})[1]


def test_no_board_is_lost_of_a_frame_that_cannot_be_drawn(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> None:
        raise QuadshadeError("there is nothing to draw", "draw something")

    monkeypatch.setattr(animate, "draw_frame", refuse)
    told: list[str] = []
    with boards(*MIXED) as opened:
        with pytest.raises(QuadshadeError, match="^there is nothing to draw; draw something$"):
            film(tmp_path, Reports(told.append), port=opened)
        assert told == []
        monkeypatch.undo()
        film(tmp_path, port=opened)
