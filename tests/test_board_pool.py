# SPDX-License-Identifier: Apache-2.0
"""Several boards share a picture: whatever they are, and whatever becomes of them, it is the same."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import quadshade
from quadshade.board import Board, BoardSettings, pool
from quadshade.board.pool import BoardPool, Work, wait_until_free
from quadshade.choices import parse_ports
from quadshade.contract.formats import Formats
from quadshade.errors import QuadshadeError
from quadshade.rendering import Reports, open_board
from quadshade.rendering.groups import PortChoice
from scripts.experiments.pool_faults import PICTURE, doom, expected_picture, run_with_faults
from tests.test_board_api import run
from tests.test_setup_tile import ICEBREAKER

SCENE, SIZE = "torus:288", (61, 47)


@contextmanager
def boards(*settings: BoardSettings, **keywords: object) -> Iterator[list[Board]]:
    """Boards of the golden model."""
    with ExitStack() as stack:
        opened = [Board("sim", settings=one, engine="model", **keywords) for one in settings]
        yield [stack.enter_context(board) for board in opened]


def settings_of(width: int, height: int, formats: Formats | None = None, **more: int) -> BoardSettings:
    return BoardSettings(formats or Formats(), width, height, **more)


@pytest.fixture(scope="module")
def model() -> np.ndarray:
    return quadshade.render(SCENE, engine="model", size=SIZE).array


def test_boards_of_any_kind_draw_the_same(model: np.ndarray) -> None:
    """Other screens, clocks, fractions, sub-pixels, coordinates and channels."""
    mixed = (
        settings_of(24, 20),
        settings_of(61, 8, Formats(word_width=40, frac_bits=30), clk_frequency_hz=8_000_000),
        settings_of(9, 31, Formats(subpixel_bits=4, coord_bits=5, span_depth=7)),
        settings_of(17, 17, Formats(num_channels=4), most_counter_bits=8),
    )
    told: list[str] = []
    with boards(*mixed) as opened:
        for order in (opened, opened[::-1], opened[1:3]):
            drawn = quadshade.render(SCENE, port=order, size=SIZE, reports=Reports(notice=told.append))
            # Of the boards those that do not have eight bits below a pixel round vertices to fewer.
            fine = any(board.formats.subpixel_bits == 8 for board in order)
            assert fine and np.array_equal(drawn.array, model)
        assert all(board.statistics["triangles"] > 0 for board in opened)
    assert told == []


def test_a_board_that_is_left_out_is_not_named(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of three at the ports one does not answer, then two; the picture is of those that drew it."""
    told: list[str] = []
    silent: tuple[int, ...] = ()
    real = open_board._open

    def some_answer(port: PortChoice, number: int, *rest: Any) -> Board:
        if number in silent:
            raise QuadshadeError("no board answers")
        return real(port, number, *rest)

    monkeypatch.setattr(open_board, "_open", some_answer)
    # However slow this machine is, no board is late.
    monkeypatch.setattr(pool, "LATE_SECONDS", 1e6)
    settings = {"port": "sim:3", "engine": "model", "size": (24, 20), "reports": Reports(told.append)}
    for numbers, left in (((), 3), ((1,), 2), ((0, 2), 1)):
        silent = numbers
        drawn = quadshade.render("sphere:24", **settings)
        port = drawn.stats.port
        assert f"drawn by the board at {port}" in drawn.summary
        assert port == "sim:3" if left == 3 else len(port.split(", ")) == left
    assert told == ["the board at sim is left out: no board answers"] * 3


def test_a_mix_with_one_channel_and_no_depth_is_grey_in_painters_order() -> None:
    told: list[str] = []
    grey = settings_of(32, 20, ICEBREAKER)
    with boards(settings_of(24, 20), grey) as opened:
        drawn = quadshade.render(SCENE, port=opened, size=SIZE, reports=Reports(notice=told.append))
    assert told == [
        "drawn in grey: the board has one channel",
        "drawn in painter's order, as a board has no depth",
    ]
    # A board of one channel whose vertices are as fine draws it alone.
    fine = Formats(**ICEBREAKER.generics() | {"subpixel_bits": 8})
    with boards(settings_of(61, 47, fine)) as opened:
        alone = quadshade.render(
            SCENE, port=opened[0], size=SIZE, pack_error=0, reports=Reports(notice=told.append)
        )
    assert np.array_equal(drawn.array, alone.array)


def test_a_board_of_another_design_is_lost_with_a_line(model: np.ndarray) -> None:
    told: list[str] = []
    with boards(settings_of(24, 20), settings_of(24, 20, Formats(with_shade=1, num_channels=2))) as opened:
        drawn = quadshade.render(SCENE, port=opened, size=SIZE, reports=Reports(notice=told.append))
    assert np.array_equal(drawn.array, model)
    assert len(told) == 1 and "with_shade" in told[0] and "its work goes to the others" in told[0]
    assert drawn.stats.port == opened[0].session.name


@pytest.mark.parametrize("seed", range(4))
def test_boards_that_die_while_lines_are_damaged(seed: int) -> None:
    """Pulled, hanging, or showing other bits; the picture is right, or it is said what is missing."""
    result = run_with_faults(seed)
    assert result["wrong"] == 0
    assert result["ended"] in ("picture", "error")
    if result["killed"] < result["boards"]:
        assert result["ended"] == "picture"
    assert expected_picture().shape == (*PICTURE[::-1], 3)


def test_the_last_board_says_what_is_missing(tmp_path: Path, model: np.ndarray) -> None:
    told: list[str] = []
    with boards(settings_of(24, 20), settings_of(24, 20), reconnect_seconds=0.1) as opened:
        count = 0

        def die(what: str, done: float, total: float, sent: int) -> None:
            nonlocal count
            count += 1
            if count == 2:
                for board in opened:
                    doom(board, "pulled", 1)

        with pytest.raises(QuadshadeError, match=r"\d+ tiles are missing, as no board is left: .*--resume"):
            quadshade.render(
                SCENE,
                port=opened,
                size=SIZE,
                resume=tmp_path / "t",
                reports=Reports(told.append, progress=die),
            )
    assert sum("is lost" in text for text in told) == 2 and "no board is left" in told[-1]
    with boards(settings_of(30, 10)) as opened:
        drawn = quadshade.render(
            SCENE, port=opened[0], size=SIZE, resume=tmp_path / "t", reports=Reports(told.append)
        )
    assert "tiles were drawn before" in told[-1]
    assert np.array_equal(drawn.array, model)


class Idle:
    """As much of a board as a pool looks at."""

    def __init__(self, name: str) -> None:
        self.session = type("Session", (), {"name": name})


def test_jobs_of_a_board_that_hangs_are_done_by_another(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("quadshade.board.pool.LATE_SECONDS", 0.0)
    monkeypatch.setattr("quadshade.board.pool.WAIT_SECONDS", 0.01)
    hangs, told = threading.Event(), []
    first, second = Idle("first"), Idle("second")

    def do(board: Idle, job: int) -> int:
        if board is first:
            hangs.wait()
        return job * job

    work = Work(do, lambda _, job: (job, []), "squares", "try again")
    pool = BoardPool([first, second], told.append)  # type: ignore[list-item]
    done = list(pool.share(work, [(1.0, job) for job in range(20)]))  # type: ignore[arg-type]
    assert sorted((one.job, one.result) for one in done) == [(job, job * job) for job in range(20)]
    assert told == ["the board at first is late: another one did its work"]
    hangs.set()
    # It takes part again once it has come back.
    assert len(list(pool.share(work, [(1.0, job) for job in range(5)]))) == 5  # type: ignore[arg-type]


def test_a_board_never_has_two_jobs_at_once() -> None:
    """Whatever pool shared the first one, which was broken off."""
    board, running, most = Idle("one"), [], []

    def do(_: Idle, job: int) -> int:
        running.append(job)
        time.sleep(0.02)
        most.append(len(running))
        running.remove(job)
        return job

    work = Work(do, lambda _, job: (job, []), "numbers", "try again")
    for _ in range(3):
        pool = BoardPool([board], print)  # type: ignore[list-item]
        shared = pool.share(work, [(1.0, job) for job in range(9)])  # type: ignore[arg-type]
        next(shared)
        shared.close()
    wait_until_free(board)
    assert set(most) == {1} and len(most) < 9


def test_a_job_is_split_for_a_board_and_a_bug_is_no_lost_board() -> None:
    board = Idle("one")
    work = Work(lambda _, job: len(job), lambda _, job: (job[:2], [job[2:]] * bool(job[2:])), "rows", "")
    pool = BoardPool([board], print)  # type: ignore[list-item]
    done = list(pool.share(work, [(6.0, "abcdef"), (1.0, "g")]))  # type: ignore[arg-type]
    assert sorted(one.job for one in done) == ["ab", "cd", "ef", "g"]
    assert sum(one.cost for one in done) == pytest.approx(7.0)
    wrong = Work(lambda _, job: 1 // 0, lambda _, job: (job, []), "rows", "")
    with pytest.raises(ZeroDivisionError):
        list(pool.share(wrong, [(1.0, "a")]))  # type: ignore[arg-type]


def test_ports() -> None:
    assert parse_ports("sim:3") == ("sim",) * 3
    assert parse_ports(["sim", "sim:2", "/dev/a"]) == ("sim", "sim", "sim", "/dev/a")
    assert parse_ports(None) == ()
    for wrong in ("sim:0", "sim:9x", "sim:65", "sim:"):
        with pytest.raises(QuadshadeError, match="sim:1 to sim:64"):
            parse_ports(wrong)


def test_wrong_ports_are_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    device, link = tmp_path / "tty", tmp_path / "link"
    device.touch()
    link.symlink_to(device)
    base = ("render", "cube:1", "-o", tmp_path / "a.png")
    for words, said in (
        (("--port", device, "--port", link), "is given twice"),
        (("--port", "tty", "--port", device), "is given twice"),
        (("--port", "sim:0"), "sim:1 to sim:64"),
        # Before a simulation is compiled, or even begun.
        (("--port", "sim:2", "--engine", "verilator", "--port", tmp_path / "none"), "none"),
        (("--port", ""), "--port is empty"),
        (("--port", "sim", "--port", " "), "--port is empty"),
        (("--port", "sim", "--size", "9000x9000", "--engine", "model"), "8192x8192"),
        (("--port", "sim", "--size", "0x9"), "0x9"),
    ):
        code, output = run(*base, *words)
        assert code == 2 and said in output, output
        assert output.strip().count("\n") <= output.count("notice"), output
        assert not list(tmp_path.glob("*.png")) and not list(tmp_path.glob(".*"))
    code, output = run("info", "--port", "")
    assert code == 2 and "--port is empty" in output
    # An empty variable of the environment is none.
    monkeypatch.setenv("QUADSHADE_PORT", "")
    code, output = run(*base, "--size", "9x9", "--engine", "model")
    assert code == 0 and "9x9" in output
