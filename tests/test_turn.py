# SPDX-License-Identifier: Apache-2.0
"""``quadshade turn``: frames against single pictures of a scene that was moved by hand, and the files."""

from __future__ import annotations

import csv
import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result
from PIL import Image, ImageSequence
from scipy.spatial.transform import Rotation

import quadshade
from quadshade.animation import Motion, animate
from quadshade.animation.film import durations
from quadshade.cli.main import main
from quadshade.errors import QuadshadeError
from quadshade.image import compare, read_picture
from quadshade.scene import parse_camera
from quadshade.shading import DirectionalLight, default_lights

SMALL = {"size": (48, 40), "engine": "model"}


def run(*arguments: object) -> Result:
    return CliRunner().invoke(main, ["turn", *map(str, arguments)])


def frames_of(path: Path) -> list[np.ndarray]:
    with Image.open(path) as image:
        return [np.asarray(frame.convert("RGB")) for frame in ImageSequence.Iterator(image)]


@pytest.mark.parametrize(
    ("axis", "vector"), [("x", (1, 0, 0)), ("0,2,0", (0, 1, 0)), ((1, 1, -1), (1, 1, -1))]
)
def test_a_frame_is_the_picture_of_the_turned_mesh(axis, vector) -> None:
    animation = quadshade.turn("torus:288", frames=5, axis=axis, degrees=200, errors=False, **SMALL)
    mesh = quadshade.load_scene("torus:288")
    assert (animation[0].array == quadshade.render("torus:288", **SMALL).array).all()
    camera = parse_camera("", mesh)
    unit = np.array(vector) / np.linalg.norm(vector)
    for frame in (1, 4):
        by = Rotation.from_rotvec(unit * np.radians(40 * frame))
        centre = mesh.bounds[0]
        normals = by.apply(mesh.normals.reshape(-1, 3)).reshape(-1, 3, 3)
        turned = replace(mesh, vertices=by.apply(mesh.vertices - centre) + centre, normals=normals)
        expected = quadshade.render(turned, camera=camera, **SMALL)
        # SciPy's matrix differs in its last bits, which may move a vertex by a sub-pixel.
        assert compare(animation[frame].array, expected.array).psnr > 45
    assert compare(animation[0].array, animation[1].array).psnr < 40


def test_a_whole_turn_ends_where_it_began() -> None:
    animation = quadshade.turn("cube:1", frames=3, degrees=720, errors=False, **SMALL)
    still = quadshade.turn("cube:1", frames=3, degrees=0, errors=False, **SMALL)
    keys = [{"frame": 0, "turn": 0}, {"frame": 2, "turn": -720}]
    keyed = quadshade.turn("cube:1", frames=3, keyframes=keys, errors=False, **SMALL)
    first = animation[0].array
    assert all((still[frame].array == first).all() for frame in range(3))
    assert (keyed[2].array == first).all() and (keyed[1].array == first).all()
    assert not (animation[1].array == first).all()


def test_lights_orbit_while_the_object_stands() -> None:
    animation = quadshade.turn("sphere:168", frames=4, light_orbit=360, errors=False, **SMALL)
    mesh = quadshade.load_scene("sphere:168")
    ambient, light = default_lights(parse_camera("", mesh).axes)
    x, y, z = light.direction
    quarter = DirectionalLight((z, y, -x))
    expected = quadshade.render(mesh, lights=[ambient, quarter], **SMALL).array
    assert compare(animation[1].array, expected).psnr > 50
    point = quadshade.turn(
        "sphere:168", frames=2, light_orbit=360, lights="point=0,0,3", errors=False, **SMALL
    )
    behind = quadshade.render("sphere:168", lights="point=0,0,-3", **SMALL).array
    assert compare(point[1].array, behind).psnr > 50
    assert (animation[0].array == quadshade.render("sphere:168", **SMALL).array).all()


def test_key_frames_move_camera_and_exponent() -> None:
    keys = [
        {"frame": 0, "from": [0, 0, 1], "fov": 20, "exponent": 5},
        {"frame": 2, "from": [1, 0, 1], "fov": 40, "exponent": 25},
    ]
    looks = {"camera": "from=1,1,1,ortho=3"} | SMALL
    animation = quadshade.turn("sphere:168", frames=4, keyframes=keys, errors=False, **looks)
    for frame, camera, exponent in (
        (0, "0,0,1,fov=20", 5),
        (1, "0.5,0,1,fov=30", 15),
        (3, "1,0,1,fov=40", 25),
    ):
        expected = quadshade.render("sphere:168", camera=f"from={camera}", exponent=exponent, **SMALL)
        assert (animation[frame].array == expected.array).all()


@pytest.mark.parametrize("suffix", ["gif", "webp", "png", "apng"])
def test_files_hold_every_frame_for_its_time(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"turn.{suffix}"
    # Not by a third of a turn, after which this sphere is the same: APNG keeps equal frames as one.
    words = ("--frames", 3, "--fps", 30, "--size", "40x32", "--turn", 60)
    result = run("sphere:168", "-o", path, *words)
    assert result.exit_code == 0, result.output
    assert "3 frames at 30 a second" in result.output and "largest error" in result.output
    expected = quadshade.turn("sphere:168", frames=3, degrees=60, errors=False, size=(40, 32))
    shown = frames_of(path)
    assert len(shown) == 3
    for number, picture in enumerate(shown):
        if suffix == "gif":
            assert compare(picture, expected[number].array).psnr > 38
        else:
            assert (picture == expected[number].array).all()
    with Image.open(path) as image:
        assert image.info["loop"] == 0
    assert sorted(one.name for one in tmp_path.iterdir()) == sorted(["turn.csv", "turn_plot.png", path.name])
    with (tmp_path / "turn.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["turn"] for row in rows] == ["0.0", "20.0", "40.0"]
    for number, row in enumerate(rows):
        picture = expected[number]
        compared = picture.error_to("phong")
        assert int(row["largest_error"]) == compared.largest_error
        assert float(row["rms_error"]) == pytest.approx(compared.rms, abs=1e-4)
        assert int(row["bytes"]) == 4 * picture.stats.words and int(row["clocks"]) == picture.stats.clocks
    assert read_picture(tmp_path / "turn_plot.png").shape[0] > 300


def test_times_of_frames_do_not_add_up() -> None:
    assert durations(6, 30, 100) == [30, 40, 30, 30, 40, 30]
    assert sum(durations(3000, 29.97, 100)) == pytest.approx(3000 / 29.97 * 1000, abs=10)
    assert durations(2, 1000, 100) == [10, 10]


def test_processes_draw_the_same_into_a_folder(tmp_path: Path) -> None:
    base = ("torus:288", "--frames", 5, "--size", "40x32", "--no-errors", "--max-error", 8)
    result = run(*base, "-o", tmp_path / "frames", "--jobs", 2)
    assert result.exit_code == 0, result.output
    expected = quadshade.turn("torus:288", frames=5, max_error=8, size=(40, 32), errors=False)
    names = sorted(one.name for one in (tmp_path / "frames").iterdir())
    assert names == [*(f"{n:04}.png" for n in range(5)), "frames.csv", "plot.png"]
    for number, picture in enumerate(expected):
        assert (read_picture(tmp_path / "frames" / f"{number:04}.png") == picture.array).all()


def test_a_board_draws_every_frame(tmp_path: Path) -> None:
    words = ("--frames", 3, "--size", "48x32", "--port", "sim", "--engine", "model", "--pack-error", 0)
    result = run("sphere:168", "-o", tmp_path / "board", *words)
    assert result.exit_code == 0, result.output
    expected = quadshade.turn("sphere:168", frames=3, size=(48, 32), engine="model", errors=False)
    for number, picture in enumerate(expected):
        assert (read_picture(tmp_path / "board" / f"{number:04}.png") == picture.array).all()
    with (tmp_path / "board" / "frames.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert all(int(row["bytes"]) > 1000 and row["clocks"] == "" for row in rows)


def test_an_interrupted_run_leaves_its_frames_and_goes_on(tmp_path: Path) -> None:
    path = tmp_path / "turn.gif"
    # A job in the background may have been told to ignore Ctrl-C.
    words = ["env", "--default-signal=INT", sys.executable, "-m", "quadshade", "turn", "sphere:690"]
    words += ["-o", str(path), "--frames", "40", "--size", "320x240", "--engine", "model"]
    frames = tmp_path / ".turn.gif.frames"

    def ended_by(number: signal.Signals, frame: int) -> int:
        """Exit code of a run that gets a signal when a frame is there."""
        with subprocess.Popen(words, stderr=subprocess.PIPE, text=True) as process:
            while not (frames / f"{frame}.json").is_file():
                assert process.poll() is None
                time.sleep(0.02)
            process.send_signal(number)
            said = process.communicate()[1]
        assert said.splitlines()[-1] == "quadshade: interrupted"
        return int(process.returncode)

    # Who sends this does not wait: the frames are kept, and nothing is made of them.
    assert ended_by(signal.SIGTERM, 0) == 143 and not path.exists()
    assert ended_by(signal.SIGINT, 3) == 130
    before = len(frames_of(path))
    assert 4 <= before < 40 and (tmp_path / "turn.csv").is_file()
    # A frame counts from when its record is written, behind its picture.
    kept = [one for one in frames.glob("*.json") if one.stem.isdigit()]
    ended = subprocess.run(words, stderr=subprocess.PIPE, text=True, env=os.environ, check=False)
    assert ended.returncode == 0 and f"{len(kept)} of 40 frames were drawn before" in ended.stderr
    assert len(frames_of(path)) == 40 and not frames.exists()


def test_frames_of_another_animation_are_not_taken(tmp_path: Path) -> None:
    path = tmp_path / "turn.png"
    first = quadshade.turn("sphere:168", frames=2, degrees=80, errors=False, **SMALL)
    first.save(path)
    (tmp_path / ".turn.png.frames").mkdir()
    with pytest.raises(QuadshadeError, match="holds no frames"):
        first.save(path)
    (tmp_path / ".turn.png.frames" / "animation.json").write_text('{"key": "other"}')
    (tmp_path / ".turn.png.frames" / "0.json").write_text(json.dumps({"frame": 0}))
    assert len(first.save(path)) == 2
    assert (frames_of(path)[1] == first[1].array).all()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--frames", 0), "number of frames is 0"),
        (("--fps", "nan"), "fps are nan"),
        (("--fps", 0), "fps are 0"),
        (("--turn", "inf"), "--turn is inf"),
        (("--axis", "0,0,0"), "the axis is"),
        (("--axis", "w"), "the axis is"),
        (("--light-orbit", "nan"), "--light-orbit is nan"),
        (("--keyframes", "none.json"), "cannot read none.json"),
        (("-o", "turn.mp4"), "the output is"),
        (("-o", "none/turn.gif"), "there is no folder"),
        (("--port", "sim", "--jobs", 2), "leave --jobs out"),
        (("--shading", "gouraud", "--fit", "minimax"), "--fit minimax"),
        (("--camera", "eye=0,0,0,target=0,0,0"), "one point"),
    ],
)
def test_bad_input_is_one_line_and_nothing_is_written(tmp_path: Path, monkeypatch, words, said) -> None:
    monkeypatch.chdir(tmp_path)
    output = () if "-o" in words else ("-o", "turn.gif")
    result = run("sphere:168", *output, *words)
    assert result.exit_code == 2 and said in result.output
    assert len(result.output.strip().splitlines()) == 1 and not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("{", "is not JSON"),
        ("[]", "not a list of key frames"),
        ("3", "not a list of key frames"),
        ('{"keyframes": {}}', "not a list of key frames"),
        ("[1]", "is no object"),
        ('[{"turn": 1}]', "has the frame None"),
        ('[{"frame": 60}]', "rising whole numbers from 0 to 59"),
        ('[{"frame": 1}, {"frame": 1}]', "rising"),
        ('[{"frame": true}]', "has the frame True"),
        ('[{"frame": 0, "spin": 1}]', "unknown key 'spin'"),
        ('[{"frame": 0, "turn": "a"}]', "give 1 finite"),
        ('[{"frame": 0, "turn": NaN}]', "give 1 finite"),
        ('[{"frame": 0, "from": [1, 2]}]', "give 3 finite"),
        ('[{"frame": 0, "from": [1, 2, 3]}, {"frame": 1, "eye": [1, 2, 3]}]', "both eye and from"),
    ],
)
def test_key_frames_are_checked(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "keys.json"
    path.write_text(text)
    with pytest.raises(QuadshadeError, match=said):
        Motion(keyframes=path)


def test_an_option_and_key_frames_do_not_both_turn() -> None:
    with pytest.raises(QuadshadeError, match="key frames set turn"):
        Motion(degrees=90, keyframes=[{"frame": 0, "turn": 0}])


def test_an_interrupt_amid_a_compiled_loop_leaves_the_frames(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Numba makes a SystemError of it; one of its own is raised as it is, and nothing is written."""
    drawn = animate.draw_frame

    def broken(frame: int, *rest: object) -> object:
        if frame < 2:
            return drawn(frame, *rest)
        raise SystemError("returned a result with an exception set") from cause

    monkeypatch.setattr(animate, "draw_frame", broken)
    film = quadshade.turn("sphere:168", frames=4, errors=False, **SMALL)
    cause: BaseException | None = None
    with pytest.raises(SystemError):
        film.save(tmp_path / "a.gif")
    assert not (tmp_path / "a.gif").exists()
    cause = SystemError("within")
    cause.__cause__ = KeyboardInterrupt()
    with pytest.raises(KeyboardInterrupt):
        film.save(tmp_path / "a.gif")
    assert len(frames_of(tmp_path / "a.gif")) == 2
