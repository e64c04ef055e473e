# SPDX-License-Identifier: Apache-2.0
"""The report on vertices: its rows, and what it says of targets and of speed."""

from __future__ import annotations

from scripts.experiments.link_vertices import measure, report


def test_a_row_is_of_the_packets_themselves() -> None:
    row = measure("sphere:168", "gouraud")
    assert row["triangles"] == row["sent"] == 68
    assert 3 * row["vertices"] < row["fields"] and 1000 < row["clocks"] < row["line"]
    text = report([row, row | {"clocks": row["line"] + 1, "vertices": 24.5}])
    assert "≤ 24 met" in text and "≤ 24 MISSED" in text
    assert "Slower than the line: sphere:168, gouraud." in " ".join(text.split())
    assert "No scene is slower than the line." in report([row])
