# SPDX-License-Identifier: Apache-2.0
"""The report on what frames cost the host: its numbers come from the measurement alone."""

from __future__ import annotations

from scripts.experiments.turn_speed import report


def results(turn: float, view: float) -> dict:
    seconds = {"turn": turn, "turn, no errors": turn / 2, "vtk": 0.01, "view": view, "vtk, square": 0.02}
    return {
        "command": "x",
        "scene": "sphere:690",
        "frames": 60,
        "size": [640, 480],
        "vtk": "9",
        "renderer": "software",
        "covered": [0.5, 0.5],
        "seconds": {name: [one] * 60 for name, one in seconds.items()},
    }


def test_the_report_tells_met_from_missed() -> None:
    text = report(results(0.025, 0.02))
    assert "| `turn` | 640x480 | 25.0 ms | 10.0 ms | 2.50 |" in text
    assert "| `view` | 512x512 | 20.0 ms | 20.0 ms | 1.00 |" in text
    assert "| 1.50 s | ≤ 3 s met |" in text and "| 50 | ≥ 30 met |" in text
    slow = report(results(0.06, 0.05))
    assert "| 3.60 s | ≤ 3 s MISSED |" in slow and "| 20 | ≥ 30 MISSED |" in slow
