# SPDX-License-Identifier: Apache-2.0
"""Tables of the papers that Quadshade follows, and what it measures itself, side by side."""

from __future__ import annotations

from typing import Any

from quadshade.contract.formats import Formats

SETUPS = 100_000_000
"""Set-ups that Barrera's Table 1 times."""

BARRERA = (
    ("Lee and Jen", 40.6, None),
    ("Abbas et al.", 42.0, "abbas"),
    ("Seiler", 49.4, None),
    ("Hast et al.", 40.3, "unit_triangle"),
    ("X-shading", 12.7, "x_shading"),
)
"""Barrera, Hast, Bengtsson, Table 1: method, seconds on a Pentium 4 of 1.8 GHz, our method of that idea."""

ABBAS_NS = 50.0
"""Abbas et al., section 6: nanoseconds a pixel on an XCV300-6."""
ABBAS_FRAME = 1_000_000
"""Pixels of the frame that they redraw 16 times a second."""

CHO_TIMES = (
    ("Gouraud", 480, 110, 957, 183),
    ("Highlight subdivision", 881, 366, 1408, 450),
    ("Regular subdivision", 664, 177, 1632, 387),
    ("Gouraud + Phong", 1104, None, 3436, None),
    ("Phong", 3763, None, 14630, None),
)
"""Cho, Neumann, Woo, Table 1: ms in software and with hardware, at 256 and at 512 pixels."""

CHO_TRIANGLES = (
    ("Gouraud", 896.0, None, 896.0, None),
    ("Highlight subdivision", 1538.0, 74.5, 1538.0, 74.5),
    ("Regular subdivision", 1075.5, 288.4, 1955.6, 288.4),
)
"""The same, Table 2: final triangles and subdivided ones, at 256 and at 512 pixels."""


def barrera_table(hostspeed: dict[str, Any] | None) -> list[dict[str, Any]]:
    """
    Barrera's Table 1 beside our seconds for as many set-ups.

    Parameters
    ----------
    hostspeed : dict or None
      What ``make hostspeed`` measured: ``setups``, set-ups a second on one core.
    """
    rates = (hostspeed or {}).get("setups", {})
    return [
        {
            "method": method,
            "paper_seconds": seconds,
            "ours": ours,
            "our_seconds": SETUPS / rates[ours] if ours in rates else None,
        }
        for method, seconds, ours in BARRERA
    ]


def abbas_table(resources: dict[str, Any] | None) -> list[dict[str, Any]]:
    """
    Abbas's pixel time beside that of our core at its clock after place-and-route.

    Parameters
    ----------
    resources : dict or None
      ``synth/resources.json``.
    """
    rows: list[dict[str, Any]] = [
        {"what": "Abbas et al.", "device": "XCV300-6", "mhz": 1000 / ABBAS_NS, "ns_per_pixel": ABBAS_NS}
    ]
    rows += [
        {
            "what": f"{row['name']}, {Formats().with_generics(row['generics']).stream_width}-bit stream",
            "device": row["device"],
            "mhz": row["fmax_mhz"],
            "ns_per_pixel": 1000 / row["fmax_mhz"],
        }
        for row in (resources or {}).get("rows", [])
        if row.get("fmax_mhz")
    ]
    for row in rows:
        row["frames_per_second"] = 1e9 / row["ns_per_pixel"] / ABBAS_FRAME
    return rows


def cho_tables() -> dict[str, list[dict[str, Any]]]:
    """Cho's Tables 1 and 2."""
    times = ("method", "software_256_ms", "hardware_256_ms", "software_512_ms", "hardware_512_ms")
    counts = ("method", "final_256", "subdivided_256", "final_512", "subdivided_512")
    return {
        "table_1": [dict(zip(times, row, strict=True)) for row in CHO_TIMES],
        "table_2": [dict(zip(counts, row, strict=True)) for row in CHO_TRIANGLES],
    }


def paper_tables(hostspeed: dict[str, Any] | None, resources: dict[str, Any] | None) -> dict[str, Any]:
    """All tables, for ``data/papers.json``."""
    return {"barrera": barrera_table(hostspeed), "abbas": abbas_table(resources), "cho": cho_tables()}
