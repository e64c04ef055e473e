# SPDX-License-Identifier: Apache-2.0
"""``quadshade trade --max-error``: one point, why it, and a line that draws it."""

from __future__ import annotations

import json
import shlex
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from quadshade.choices import COSTS
from quadshade.cli.main import main
from quadshade.contract.formats import Formats
from quadshade.errors import QuadshadeError
from quadshade.image import read_picture
from quadshade.trade import View
from quadshade.trade.recommend import COLUMNS, command, recommend, table

VIEW = View("torus:288", 96, 64, exponent=50, lights=("dir=0,0,1", "dir=1,0,1"))


def point(
    shading: str, error: int | None, size: int, clocks: int, cells: int | None, fraction: int = 22
) -> dict:
    record = {"name": f"{shading}-{fraction}-none", "shading": shading, "fraction": fraction}
    record |= {
        "subdivision": "none",
        "lod": "all",
        "fit": "six-point",
        "line": size // 2,
        "max_error": error,
        "rms": error,
        "bytes": size,
        "clocks": clocks,
    }
    refused = None if error is not None else "the screen is too large"
    return record | {"lut4": cells, "dsp": 7, "bram": 1, "refused": refused}


RECORDS = [
    point("flat", 40, 100, 900, 500),
    point("gouraud", 3, 200, 800, 700),
    point("quadratic", 1, 300, 700, 1000),
    point("linear-specular", 2, 250, 600, 1200),
    point("quadratic-specular", None, 1, 1, 1),
]


@pytest.mark.parametrize(
    ("allowed", "minimise", "shading"),
    [
        (2.0, "bytes", "linear-specular"),
        (2.0, "clocks", "linear-specular"),
        (2.0, "lut4", "quadratic"),
        (3.0, "bytes", "gouraud"),
        (2.999, "lut4", "quadratic"),
        (255.0, "bytes", "flat"),
    ],
)
def test_the_cheapest_that_keeps_the_error(allowed: float, minimise: str, shading: str) -> None:
    found = recommend(RECORDS, allowed, minimise, VIEW, Formats())
    assert found.record["shading"] == shading
    assert f"of {allowed:g} grey levels" in found.reason
    kept = [record for record in RECORDS if record["refused"] is None and record["max_error"] <= allowed]
    assert found.record[minimise] == min(record[minimise] for record in kept)


def test_the_reason_names_what_was_passed_over() -> None:
    reason = recommend(RECORDS, 2.0, "lut4", VIEW, Formats()).reason
    assert "2 of 4 points keep it, and this one takes the fewest LUT4 of the core, 1000" in reason
    assert "the next, linear-specular-22-none, takes 1200" in reason
    assert "of those that take less gouraud-22-none errs least, by 3" in reason
    assert reason.endswith("its core takes 1000 LUT4, 7 multipliers, 1 block RAM")
    assert "no other point keeps it" in recommend(RECORDS, 1.0, "bytes", VIEW, Formats()).reason
    assert "1 of 1 grey level;" in recommend(RECORDS, 1.0, "bytes", VIEW, Formats()).reason


def test_of_equal_costs_the_other_costs_decide() -> None:
    same = [point("quadratic", 1, 300, 700, 1000, 22), point("quadratic", 2, 300, 700, 900, 16)]
    assert recommend(same, 2.0, "bytes", VIEW, Formats()).record["fraction"] == 16
    for record in same:
        record["lut4"] = None
    assert recommend(same, 2.0, "bytes", VIEW, Formats()).record["fraction"] == 22


@pytest.mark.parametrize(
    ("records", "minimise", "message"),
    [
        (
            RECORDS,
            "bytes",
            r"no point of the sweep has a largest error of 0.5.*the least is 1 \(quadratic-22-none",
        ),
        (RECORDS[-1:], "bytes", "no point of the sweep was drawn"),
        ([point("flat", 0, 1, 1, None)], "lut4", "LUT4 of the core were not counted"),
    ],
)
def test_refusals(records: list[dict], minimise: str, message: str) -> None:
    with pytest.raises(QuadshadeError) as refusal:
        recommend(records, 0.5, minimise, VIEW, Formats())
    assert refusal.match(message)


@pytest.mark.parametrize("shading", ["gouraud", "quadratic-specular", "adaptive:1"])
def test_the_command_draws_the_point(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, shading: str) -> None:
    """The recommended line, run as it stands, gives the very picture that was measured."""
    monkeypatch.chdir(tmp_path)
    scene = (
        "torus:288",
        "--size",
        "96x64",
        "--exponent",
        "50",
        "--light",
        "dir=0,0,1",
        "--light",
        "dir=1,0,1",
    )
    sweep = ("--shadings", shading, "--fractions", "8", "--subdivisions", "none", "--no-area", "--jobs", "1")
    run = CliRunner().invoke(main, ["trade", *scene, *sweep, "--max-error", "200"])
    assert run.exit_code == 0, run.output
    line = run.output.splitlines()[-1].removeprefix("draw it: ")
    words = shlex.split(line)
    assert words[:2] == ["quadshade", "render"]
    drawn = CliRunner().invoke(main, words[1:])
    assert drawn.exit_code == 0, drawn.output
    (record,) = json.loads((tmp_path / "trade" / "trade.json").read_text())["points"]
    ours, theirs = (
        read_picture(path) for path in (tmp_path / "recommended.png", tmp_path / "trade" / record["picture"])
    )
    assert np.array_equal(ours, theirs)


def test_a_divided_point_is_drawn_by_a_sweep_of_one() -> None:
    record = point("quadratic", 1, 300, 700, 1000) | {"subdivision": "all:1"}
    line = command(record, View("my part.stl", 64, 64, cull=False), Formats(stream_width=64))
    assert line.startswith("quadshade trade 'my part.stl' --size 64x64 --no-cull --shadings quadratic")
    assert line.endswith("--fractions 22 --subdivisions all:1 --generic stream_width=64 -o recommended")


def test_columns_are_labelled_and_aligned() -> None:
    lines = table([*RECORDS[:2], point("flat", 7, 12_345_678, 1, None, 8)])
    assert [name for name in COLUMNS if name in lines[0]] == list(COLUMNS)
    assert len(lines) == 4 and "–" in lines[3]
    for name in ("bytes", "clocks", "LUT4"):
        end = lines[0].index(f" {name}") + len(name) + 1
        assert all(line[end - 1] not in " " and line[end : end + 1] in ("", " ") for line in lines)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--minimise", "bytes"), "--minimise is given without an error; give --max-error too"),
        (("--max-error", "nan"), "the allowed error is nan; give a number of grey levels from 0"),
        (("--max-error", "-1"), "the allowed error is -1; give"),
        (("--max-error", "2", "--minimise", "lut4", "--no-area"), "--minimise lut4 is given with --no-area"),
    ],
)
def test_bad_input_is_one_line(tmp_path: Path, arguments: tuple[str, ...], said: str) -> None:
    run = CliRunner().invoke(main, ["trade", "sphere:168", "-o", str(tmp_path / "out"), *arguments])
    assert run.exit_code == 2
    assert run.output.startswith(f"quadshade: error: {said}"), run.output
    assert not (tmp_path / "out").exists()
    assert set(COSTS) == {"bytes", "clocks", "lut4", "line"}
