# SPDX-License-Identifier: Apache-2.0
"""The report on frame times with vertices: a row is of the board's own pictures."""

from __future__ import annotations

from scripts.experiments.frame_time.vertices import measure, report


def test_vertices_are_complete_sooner_and_keep_the_time() -> None:
    row = measure("torus:288", 12.0, (96, 64))
    fields, vertices = row["fields"], row["vertices"]
    assert vertices["whole"] < 0.6 * fields["whole"]
    assert fields["vertices"] == 0 < vertices["vertices"]
    assert max(fields["took"], vertices["took"]) <= 12.0 and vertices["error"] < fields["error"]
    text = report([row])
    assert f"| torus:288 | vertices | {vertices['whole']:g} | 12 | {vertices['took']:g} |" in text
