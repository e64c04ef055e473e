# SPDX-License-Identifier: Apache-2.0
"""What all experiments share: a row a line in JSON, the command that repeats a run, errors in one line."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from quadshade.errors import QuadshadeError
from quadshade.files.markdown import markdown_table
from scripts.experiments import board_speed, report_writer, throughput
from scripts.experiments.report_writer import command_line, rows_as_json, write_report
from scripts.one_line_errors import Failure, one_line_errors

VALUES = [
    {},
    [],
    [{"a": 1, "b": None}, {"a": 0.1, "b": "µ\n"}],
    {"command": "x", "rows": [{"area": {"lut4": 3}, "runs": [1, 2]}], "empty": {}, "deep": [[[1], []], 2]},
    3.5,
]


@pytest.mark.parametrize("value", VALUES)
def test_json_with_a_row_a_line_is_the_same_json(value) -> None:
    assert json.loads(rows_as_json(value)) == value


def test_a_row_is_a_line() -> None:
    text = rows_as_json({"command": "x", "rows": [{"a": 1}, {"a": 2}]})
    assert text == '{\n "command": "x",\n "rows": [\n  {"a": 1},\n  {"a": 2}\n ]\n}'


def test_the_command_line_has_every_option() -> None:
    command = command_line("some.report", frame_size=64, degrees=0.25, exponent=50.0, mesh=["a.ply", "b.ply"])
    assert command == (
        "python -m scripts.experiments.some.report --frame-size 64 --degrees 0.25 --exponent 50"
        " --mesh a.ply --mesh b.ply"
    )


def test_a_report_and_its_numbers_stand_side_by_side(tmp_path: Path) -> None:
    write_report(tmp_path / "new" / "some.md", "text\n", {"rows": [1]})
    assert (tmp_path / "new" / "some.md").read_text() == "text\n"
    assert json.loads((tmp_path / "new" / "some.json").read_text()) == {"rows": [1]}
    assert len(list((tmp_path / "new").iterdir())) == 2


@pytest.mark.parametrize(
    ("problem", "code", "said"),
    [
        (QuadshadeError("no such mesh", "give another"), 2, "adapt: error: no such mesh; give another\n"),
        (FileNotFoundError(2, "gone", "x"), 2, "adapt: error: [Errno 2] gone: 'x'\n"),
        (Failure("too slow"), 1, "adapt: failed: too slow\n"),
    ],
    ids=["bad input", "a file", "a check"],
)
def test_an_error_is_one_line(
    problem: Exception, code: int, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    @one_line_errors("adapt")
    def experiment() -> None:
        raise problem

    with pytest.raises(SystemExit) as left:
        experiment()
    assert left.value.code == code
    assert capsys.readouterr().err == said


def test_a_table_has_a_cell_a_column() -> None:
    assert markdown_table(("a", "b"), [(1, "x")], right={"a"}) == "| a | b |\n| ---: | --- |\n| 1 | x |"
    with pytest.raises(ValueError, match="a row of 1 cells in a table of 2 columns"):
        markdown_table(("a", "b"), [("x",)])


@pytest.mark.parametrize("experiment", [board_speed, throughput])
def test_published_report_is_that_of_its_numbers(experiment) -> None:
    numbers = json.loads(experiment.REPORT.with_suffix(".json").read_text())
    assert experiment.REPORT.read_text() == experiment.report(numbers)


def test_numbers_that_nothing_reads_are_not_tracked() -> None:
    """Every ignored file of numbers belongs to a report that is there."""
    ignored = (report_writer.ROOT / ".gitignore").read_text().splitlines()
    stems = [Path(line).stem for line in ignored if line.startswith("/docs/reports/")]
    assert stems and all((report_writer.REPORTS / f"{stem}.md").is_file() for stem in stems)
