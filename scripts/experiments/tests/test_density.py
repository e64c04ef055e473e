# SPDX-License-Identifier: Apache-2.0
"""Mesh density against order: what is measured, what is cheapest, and that the report says it."""

from __future__ import annotations

import json

import pytest

from quadshade.trade.grid import ALL
from quadshade.trade.view import View
from scripts.experiments import density
from scripts.experiments.report_writer import REPORTS


def test_the_report_is_what_its_numbers_say() -> None:
    results = json.loads((REPORTS / "density.json").read_text())
    assert density.report(results) == (REPORTS / "density.md").read_text()
    assert {row["scene"] for row in results["rows"]} == set(density.SCENES)


def test_levels_halve(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(density, "LEAST_TRIANGLES", 100)
    assert density.lods(View("sphere:690", 32, 32)) == [ALL, "345", "172"]


def test_a_level_is_compared_with_the_finest(monkeypatch: pytest.MonkeyPatch) -> None:
    ways = (("gouraud", "six-point"), ("quadratic", "six-point"), ("quadratic", "least-squares"))
    monkeypatch.setattr(density, "WAYS", ways)
    fine, coarse = (density.level_rows("torus:1152", 64, lod) for lod in (ALL, "300"))
    for rows in (fine, coarse):
        assert [(row["shading"], row["fit"]) for row in rows] == [("phong", ""), *ways]
    assert fine[0]["outside"] == 0 and fine[0]["rms"] == fine[0]["inner"] == 0
    assert coarse[0]["outside"] > 0 and coarse[0]["rms"] > coarse[0]["inner"] > 0
    for one, other in zip(fine[1:], coarse[1:], strict=True):
        assert one["line"] > other["line"] and one["inner"] < other["inner"] and one["host"] > 0
    # Nothing is nearer to the fine mesh than Phong shading of the coarse one by much.
    assert min(row["inner"] for row in coarse[1:]) > 0.9 * coarse[0]["inner"]


def test_the_cheapest_keeps_the_error() -> None:
    rows = [
        {"inner": 4.0, "line": 10, "clocks": 9},
        {"inner": 1.0, "line": 30, "clocks": 8},
        {"inner": 0.5, "line": 20, "clocks": 9},
    ]
    assert density.cheapest(rows, "inner", 4.0, "line") == rows[0]
    assert density.cheapest(rows, "inner", 3.9, "line") == rows[2]
    assert density.cheapest(rows, "inner", 3.9, "clocks") == rows[1]
    assert density.cheapest(rows, "inner", 0.4, "line") is None
    assert density.cheapest(rows, "inner", 4.0, "host") is None
