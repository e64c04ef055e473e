# SPDX-License-Identifier: Apache-2.0
"""What the measurement of planning and fits counts, and that its report is that of its numbers."""

from __future__ import annotations

import json
from pathlib import Path

from click.testing import CliRunner

from quadshade.choices import FITS, SPECULAR_FITS
from scripts.experiments import plan_speed


def test_every_fit_and_planning_have_a_row_beside_six_points(tmp_path: Path) -> None:
    report = tmp_path / "report.md"
    words = ["--scene", "sphere:168", "--no-large", "--repeats", "1", "--output", str(report)]
    result = CliRunner().invoke(plan_speed.main, words, catch_exceptions=False)
    assert result.exit_code == 0, result.output
    results = json.loads(report.with_suffix(".json").read_text())
    rows = {row["what"]: row for row in results["rows"]}
    assert len(rows) == len(FITS) + len(SPECULAR_FITS) + 1
    assert rows.keys() >= {*FITS[1:], *(f"cosines, {fit}" for fit in SPECULAR_FITS[1:]), plan_speed.PLAN}
    assert rows[plan_speed.PATH]["ratio"] == 1
    assert {row["triangles"] for row in rows.values()} == {68}
    assert report.read_text() == plan_speed.report(results)


def test_the_published_report_is_that_of_its_numbers() -> None:
    numbers = json.loads(plan_speed.REPORT.with_suffix(".json").read_text())
    assert plan_speed.REPORT.read_text() == plan_speed.report(numbers)
    assert {row["scene"] for row in numbers["rows"]} == {*plan_speed.TARGETS, plan_speed.LEAST_SQUARES}
    assert list(numbers["large"]) == list(plan_speed.LARGE_FITS)
