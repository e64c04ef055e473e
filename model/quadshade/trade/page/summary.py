# SPDX-License-Identifier: Apache-2.0
"""The first screen's numbers: which points stand there, and what one step more buys."""

from __future__ import annotations

from typing import Any

STEPS = (
    ("flat", "none", "Flat"),
    ("gouraud", "none", "Gouraud"),
    ("gouraud", "all:1", "Gouraud, mesh in fours"),
    ("gouraud", "all:2", "Gouraud, mesh in sixteens"),
    ("quadratic", "none", "Quadratic"),
    ("adaptive:1", "none", "Adaptive: an rms error of one level"),
    ("adaptive:0.5", "none", "Adaptive: an rms error of half a level"),
    ("quadratic-specular", "none", "Quadratic, highlight's power a pixel"),
    ("quadratic", "all:1", "Quadratic, mesh in fours"),
    ("quadratic-specular", "all:1", "Quadratic, power a pixel, mesh in fours"),
)
"""Rows of the first table: shading, subdivision, name."""


def summary(trade: dict[str, Any]) -> dict[str, Any]:
    """
    Rows of the first table and the headline of a scene.

    Parameters
    ----------
    trade : dict
      Content of a ``trade.json``.

    Returns
    -------
    dict
      ``fraction``, the most bits of the sweep; ``rows``, each with the index of its point; ``steps``,
      from Gouraud to quadratic: ``psnr`` (dB), ``bytes_per_triangle``, ``lut4`` and ``clocks_per_pixel``, as
      differences, None where a part is not known.
    """
    points = trade["points"]
    fraction = max(point["fraction"] for point in points)
    place = {
        (point["shading"], point["subdivision"]): index
        for index, point in enumerate(points)
        if point["fraction"] == fraction
    }
    rows = [
        {"name": name, "point": place[shading, subdivision]}
        for shading, subdivision, name in STEPS
        if (shading, subdivision) in place
    ]
    one, other = (place.get((shading, "none")) for shading in ("gouraud", "quadratic"))
    steps = {}
    for name in ("psnr", "bytes_per_triangle", "lut4", "clocks_per_pixel"):
        values = [None if index is None else points[index][name] for index in (one, other)]
        gouraud, quadratic = values
        steps[name] = None if gouraud is None or quadratic is None else quadratic - gouraud
    return {"fraction": fraction, "rows": rows, "steps": steps}
