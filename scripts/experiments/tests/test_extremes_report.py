# SPDX-License-Identifier: Apache-2.0
"""The report over size and fraction: what it draws is what it says, and its text is of its numbers."""

from __future__ import annotations

import json

import numpy as np
import pytest
from click.testing import CliRunner

from quadshade.contract.formats import Formats
from quadshade.setup.triangle_setup import setup_triangles
from scripts.experiments import error_extremes as extremes


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory):
    """Numbers and text of a small run."""
    report = tmp_path_factory.mktemp("extremes") / "report.md"
    arguments = ["--largest", "128", "--triangles", "4", "--output", str(report)]
    result = CliRunner().invoke(extremes.main, arguments, catch_exceptions=False)
    assert result.exit_code == 0
    assert report.with_suffix(".png").stat().st_size > 10_000
    return json.loads(report.with_suffix(".json").read_text()), report.read_text()


def test_finer_output_changes_no_word(rng):
    """Colour in 1/256 of a grey level has the words of 8-bit colour, but for the half that rounds it."""
    triangles = extremes.triangles_of(100, 8, rng)
    fine = setup_triangles(triangles, extremes.formats_of(12), rounding="independent")
    triangles.samples = triangles.samples / (1 << extremes.FINER)
    plain = Formats(num_channels=extremes.CHANNELS, with_depth=0, word_width=38, frac_bits=12)
    whole = setup_triangles(triangles, plain, rounding="independent")
    assert np.array_equal(fine.words[:, :, 1:], whole.words[:, :, 1:])
    half = (1 << 11) - (1 << 3)
    assert np.array_equal(fine.words[:, :, 0] + half, whole.words[:, :, 0])


def test_no_measurement_exceeds_its_bound(measured):
    rows = measured[0]["rows"]
    assert len(rows) > 5 * 2 * len(extremes.FRACTIONS)
    for row in rows:
        assert row["typical"] <= row["worst"] <= row["bound"] + extremes.FLOOR + 1e-9
        assert not row["divided"] or row["bound"] <= 0.5 * (1 + 2**-19)
    assert any(row["divided"] for row in rows)
    # Not slack either: at the coarsest fraction errors come near the bound.
    coarse = [row for row in rows if row["fraction"] == 8 and not row["divided"] and row["size"] >= 64]
    assert all(row["worst"] > 0.8 * row["bound"] for row in coarse)


def test_the_papers_rule_and_what_it_costs(measured):
    assert [extremes.paper_bits(size) for size in (64, 256, 1024, 4096)] == [8, 10, 12, 14]
    rows = measured[0]["rows"]
    assert extremes.error_at(rows, 64, 8, "worst", "independent") > 1
    for rounding in extremes.ROUNDINGS:
        measured_bits = extremes.needed(rows, 128, "worst", rounding)
        assert extremes.paper_bits(128) < measured_bits <= extremes.needed(rows, 128, "bound", rounding) + 0.1
    assert np.median(extremes.gains(rows, "bound")) > 1.5


def test_report_is_written_from_the_numbers(measured):
    results, text = measured
    assert text == extremes.report(results)


def test_published_report_is_that_of_its_numbers():
    numbers = json.loads(extremes.REPORT.with_suffix(".json").read_text())
    assert extremes.REPORT.read_text() == extremes.report(numbers)
    assert {row["size"] for row in numbers["rows"]} == {2**power for power in range(3, 13)}
