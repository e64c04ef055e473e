# SPDX-License-Identifier: Apache-2.0
"""A frame time as a budget: pictures and films that a board has in time, and what they are made of."""

from __future__ import annotations

import csv
import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

import quadshade
from quadshade.animation import Motion
from quadshade.board import Board, BoardSettings
from quadshade.board.fallbacks import sent_triangles
from quadshade.board.frame_time import LEAST_COUNTED, BoardClock, picture_clocks, soonest_picture
from quadshade.choices import PACK_ERROR
from quadshade.cli.main import main
from quadshade.contract.formats import Formats
from quadshade.errors import QuadshadeError
from quadshade.rendering.in_time import SHORTER, USED
from quadshade.rendering.settings import Reports
from quadshade.rendering.timing import Pace

SIZE = (64, 48)
QUIET = Reports(notice=lambda _: None)


def run(*arguments: object) -> Result:
    return CliRunner().invoke(main, list(map(str, arguments)))


def test_a_picture_spends_its_time_and_no_more() -> None:
    """Starved, it gives up triangles; what it takes is counted anew from what it draws."""
    picture = quadshade.render("torus:288", size=SIZE, engine="model", frame_time=10, reports=QUIET)
    timing = picture.stats.timing
    formats = Formats(**picture.stats.generics)
    clock = BoardClock(100_000_000, 1_000_000, *SIZE)
    sent = sent_triangles(picture.triangles, formats)
    clocks = picture_clocks(sent, formats, clock, timing["pack_error"])
    assert clocks.whole == timing["clocks_whole"] <= timing["deadline"] == 1_000_000
    assert clocks.whole > 0.95 * timing["deadline"] and clocks.line_bytes == timing["line_bytes"]
    assert picture.stats.faces <= timing["faces"] < 288
    assert "time       at most" in picture.summary
    error = timing["pack_error"]
    assert error in SHORTER and f"; words packed to {error:g} grey levels" in picture.summary
    # With more time every triangle is drawn, and with much no word is shortened.
    more = quadshade.render("torus:288", size=SIZE, engine="model", frame_time=25, reports=QUIET)
    assert more.stats.timing["faces"] == 288 and more.stats.timing["pack_error"] <= error
    assert more.error_to("phong").rms < picture.error_to("phong").rms
    rich = quadshade.render("sphere:24", size=SIZE, engine="model", frame_time=500, reports=QUIET)
    assert rich.stats.timing["pack_error"] == PACK_ERROR
    asked = {"pack_error": 0.25, "frame_time": 25, "size": SIZE, "engine": "model", "reports": QUIET}
    assert quadshade.render("torus:288", **asked).stats.timing["pack_error"] == 0.25


def test_frames_keep_their_level_and_spend_their_time() -> None:
    animation = quadshade.turn(
        "torus:288", frames=60, degrees=36, size=SIZE, frame_time=25, errors=False, reports=QUIET
    )
    pace = animation.pace()
    levers, shares = set(), []
    for frame in range(6):
        picture = animation.frame(frame, pace)
        timing = picture.stats.timing
        levers.add((timing["faces"], timing["shading"]))
        shares.append(timing["clocks_whole"] / timing["deadline"])
    assert len(levers) == 1 and max(shares) <= 1 and min(shares) > 0.95
    # Words stay as short as they are, where longer ones would be in time as well.
    shortest = Pace(levers=pace.levers._replace(pack_error=SHORTER[-1]), error=math.inf)
    assert animation.frame(5, shortest).stats.timing["pack_error"] == SHORTER[-1] > pace.levers.pack_error
    # A frame starts where the one before ended, and stays there as long as that spends the time.
    kept = animation.frame(5, Pace(levers=pace.levers)).stats.timing
    assert kept["step"] == pace.levers.step and kept["clocks_whole"] >= 0.95 * USED * kept["deadline"]


def test_a_time_that_only_a_few_coarse_triangles_meet_is_kept() -> None:
    """Also where no level is in time with the channels that tell levels apart best."""
    turning = quadshade.turn(
        "torus:288", frames=2, size=SIZE, frame_time=3, errors=False, engine="model", reports=QUIET
    )
    timing = turning.frame(0, turning.pace()).stats.timing
    assert timing["shading"] == "quadratic" and 0 < timing["clocks_whole"] <= timing["deadline"]


def test_a_board_has_every_frame_in_time(tmp_path: Path) -> None:
    words = ("torus:288", "-o", tmp_path / "t.gif", "--frames", 3, "--turn", 20, "--size", "64x48")
    result = run("turn", *words, "--fps", 30, "--frame-time", "auto", "--port", "sim", "--engine", "model")
    assert result.exit_code == 0, result.output
    assert "0 frames late" in result.output
    with (tmp_path / "t.csv").open() as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        assert int(row["board_clocks"]) <= int(row["deadline_clocks"]) == 5_000_000 // 30
        assert int(row["board_clocks"]) > 0.95 * int(row["deadline_clocks"]) and row["late"] == "0"
        assert 0 < int(row["line_bytes"]) < 1_000_000 // 300
    assert len({row["faces"] for row in rows}) == len({row["shading"] for row in rows}) == 1


def small_board(**more: object) -> Board:
    settings = BoardSettings(screen_width=64, screen_height=48)
    return Board("sim", settings=settings, engine="model", notice=lambda _: None, **more)


def test_a_deadline_shortens_words_or_sends_nothing() -> None:
    said: list[str] = []
    settings = BoardSettings(screen_width=64, screen_height=48)
    with Board("sim", settings=settings, engine="model", notice=said.append) as board:
        triangles = quadshade.render("sphere:168", size=SIZE, engine="model").triangles
        whole = picture_clocks(triangles, board.formats, board.clock).whole / 5e6
        board.draw(triangles, deadline=whole)
        assert board.late == 0 and not said
        board.clear()
        board.draw(triangles, deadline=0.95 * whole)
        board.verify()
        assert board.late == 0 and said == ["words packed to 0.125 grey levels, to be in time"]
        board.clear()
        before = board.statistics["bytes_sent"]
        least = picture_clocks(triangles, board.formats, board.clock, 0.5).whole / 5e6
        with pytest.raises(QuadshadeError, match=f"it takes {math.ceil(1e5 * least) / 100:g} ms"):
            board.draw(triangles, deadline=0.5 * whole)
        assert board.statistics["bytes_sent"] == before


def vertex_board(
    megahertz: int, with_vertices: int = 1, size: tuple[int, int] = SIZE, **more: object
) -> Board:
    """A board that takes vertices, on a line of 3 Mbaud, or a fifth of its clock."""
    hertz = 1_000_000 * megahertz
    rate = {"clk_frequency_hz": hertz, "baud": min(3_000_000, hertz // 5), "with_vertices": with_vertices}
    settings = BoardSettings(Formats(), *size, **rate)
    return Board("sim", settings=settings, engine="model", **more)


def test_a_deadline_that_fields_miss_is_met_by_vertices() -> None:
    """A fast board has decoded them before it would have got the fields, and sends what was counted."""
    said: list[str] = []
    triangles = quadshade.render("sphere:168", size=SIZE, engine="model").triangles
    with vertex_board(100, notice=said.append) as board:
        plain = replace(board.clock, takes_vertices=False)
        least = picture_clocks(triangles, board.formats, plain, 0.5).whole
        clocks = picture_clocks(triangles, board.formats, board.clock)
        assert clocks.whole < 0.7 * least
        before = board.statistics["bytes_sent"]
        board.draw(triangles, deadline=clocks.whole / 1e8)
        sent = board.statistics["bytes_sent"] - before
        board.verify()
        assert board.late == 0 and not said
        # The clear went before; how many zeros a frame has is not known.
        assert 0 <= clocks.line_bytes - 15 - sent <= 4 * math.ceil(clocks.waiting / 255)
        with pytest.raises(QuadshadeError, match="give more, or draw less"):
            board.draw(triangles, deadline=0.5 * clocks.whole / 1e8)


def test_a_deadline_takes_fields_where_they_are_complete_sooner() -> None:
    """A slow board decodes vertices for longer than the fields come; one whose FIFO would fill up, too."""
    triangles = quadshade.render("sphere:168", size=SIZE, engine="model").triangles
    with vertex_board(5, notice=lambda _: None) as board:
        clock, formats = board.clock, board.formats
        packed, clocks = soonest_picture(triangles, formats, clock)
        assert packed.vertices and packed.sent_vertices == 0
        board.draw(triangles, deadline=clocks.whole / 5e6)
        board.verify()
        assert board.late == 0
    fast = replace(clock, clk_frequency_hz=100_000_000, baud=3_000_000)
    packed, clocks = soonest_picture(triangles, formats, fast)
    assert packed.sent_vertices > 0
    tight = clocks.waiting + LEAST_COUNTED // 2
    for words, same in ((tight, True), (tight - 1, False)):
        small = soonest_picture(triangles, formats, replace(fast, fifo_words=words))[0]
        assert (small.sent_vertices == packed.sent_vertices) == same


def test_a_frame_time_is_planned_with_vertices() -> None:
    """Plan, summary and board agree, and the picture is nearer to Phong shading than what fields allow."""
    errors, size = [], (96, 64)
    for takes_vertices in (0, 1):
        with vertex_board(100, takes_vertices, size, notice=lambda _: None) as board:
            picture = quadshade.render("torus:288", size=size, frame_time=12, port=board, reports=QUIET)
            timing = picture.stats.timing
            assert board.late == 0 and timing["clocks_whole"] <= timing["deadline"] == 1_200_000
            assert (timing["vertices"] > 0) == bool(takes_vertices)
            said = f"; {timing['vertices']} triangles as vertices" in picture.summary
            assert said == bool(takes_vertices)
            errors.append(picture.error_to("phong").rms)
    assert errors[1] < errors[0]


@pytest.mark.parametrize(
    ("generics", "said"),
    [
        ({}, None),
        ({"fifo_words": 256}, "a FIFO of 256 words makes the line pause"),
        ({"single_buffer": 1}, None),
    ],
)
def test_what_the_model_of_time_does_not_count_is_said(generics: dict[str, int], said: str | None) -> None:
    told: list[str] = []
    settings = BoardSettings(screen_width=64, screen_height=48).with_generics(generics)
    triangles = quadshade.render("sphere:24", size=SIZE, engine="model").triangles
    with Board("sim", settings=settings, engine="model", notice=told.append) as board:
        board.draw(triangles)
        assert told == []
        board.draw(triangles, deadline=10.0)
    assert [text.startswith("a picture may be late: ") for text in told] == ([] if said is None else [True])
    assert said is None or said in told[0]


def test_a_bad_line_makes_late_frames_and_no_wrong_ones() -> None:
    triangles = quadshade.render("sphere:168", size=SIZE, engine="model").triangles
    with small_board(faults=(2e-3, 5), answer_seconds=0.05) as board:
        whole = picture_clocks(triangles, board.formats, board.clock).whole / 5e6
        for _ in range(6):
            board.clear()
            board.draw(triangles, deadline=whole)
            board.verify()
        assert board.statistics["resent"] > 0 and 0 < board.late <= 6


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--frame-time", 0.1), "the coarsest picture takes"),
        (("--frame-time", "nan"), "the frame time is 'nan'"),
        (("--frame-time", -5), "the frame time is"),
        (("--fps", 0), "the fps are"),
        (("--fps", "nan"), "the fps are"),
        (("--fps", 10, "--frame-time", 20), "give one of them"),
        (("--frame-time", 20, "--budget", "9000line"), "give one of them"),
        (("--frame-time", 20, "--supersample", 2), "--supersample with a frame time"),
        (("--frame-time", 20, "--shading", "gouraud"), "the shading is gouraud"),
        (("--baud", 9600), "--baud is for a board"),
        (("--frame-time", 20, "--dask", "tcp://127.0.0.1:1"), "is for one board; leave out --dask, or it"),
        (("--fps", 20, "--port", "sim:2"), "is for one board; leave out all but one --port, or it"),
    ],
)
def test_bad_frame_times_are_one_line(tmp_path: Path, monkeypatch, words: tuple, said: str) -> None:
    monkeypatch.chdir(tmp_path)
    result = run("render", "sphere:168", "-o", "p.png", "--size", "48x32", "--engine", "model", *words)
    assert result.exit_code == 2 and said in result.output, result.output
    lines = [line for line in result.output.strip().splitlines() if not line.endswith("...")]
    assert len(lines) == 1 and not list(tmp_path.iterdir())


@pytest.mark.parametrize(("frames", "said"), [(1, "1 frame at 30"), (2, "2 frames at 30")])
def test_a_film_says_how_much_of_the_time_it_takes(tmp_path: Path, frames: int, said: str) -> None:
    words = ("--frames", frames, "--turn", 0, "--size", "32x24", "--fps", 30, "--frame-time", "auto")
    result = run("turn", "sphere:24", "-o", tmp_path / "t.gif", *words, "--no-errors")
    assert result.exit_code == 0, result.output
    # Frames alike take alike, which is no span.
    assert said in result.output and re.search(r", \d+\.\d% of the frame time, 0 frames late", result.output)


def test_frames_in_time_follow_each_other() -> None:
    with pytest.raises(QuadshadeError, match="leave --jobs or --dask out"):
        quadshade.turn("sphere:168", frames=2, frame_time=20, jobs=2)


def test_a_lost_port_in_mid_animation_is_an_error_that_keeps_frames(tmp_path: Path) -> None:
    path = tmp_path / "t.png"
    options = {"frames": 3, "degrees": 60, "size": SIZE, "errors": False, "reports": QUIET}
    with small_board() as board:
        animation = quadshade.turn("sphere:168", port=board, **options)
        frames = animation._on_board

        def breaks(numbers: list[int], pace: Pace):
            yield next(iter(frames(numbers, pace)))
            raise QuadshadeError("the line did not come back")

        animation._on_board = breaks
        with pytest.raises(QuadshadeError, match="did not come back"):
            animation.save(path)
        assert not path.exists() and (tmp_path / ".t.png.frames" / "0.json").is_file()
        said: list[str] = []
        again = quadshade.turn("sphere:168", port=board, **options | {"reports": Reports(notice=said.append)})
        assert len(again.save(path)) == 3 and said == ["1 of 3 frames were drawn before"]


def test_levels_of_a_turned_scene_are_turned_levels() -> None:
    """A scene of its own tessellation at every count, and one that is decimated, once for all frames."""
    for scene in ("torus:288", quadshade.load_scene("torus:288")):
        animation = quadshade.turn(scene, frames=4, lod=200, size=SIZE, engine="model", errors=False)
        first = quadshade.render(scene, lod=200, size=SIZE, engine="model")
        assert (animation[0].array == first.array).all()
        assert len(animation[2].triangles) > 50 and animation[2].stats.faces == first.stats.faces
        assert not np.array_equal(animation[1].array, first.array)


def test_a_motion_needs_frames() -> None:
    with pytest.raises(QuadshadeError, match="number of frames is 0"):
        Motion(frames=0)
