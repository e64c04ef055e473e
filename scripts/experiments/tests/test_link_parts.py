# SPDX-License-Identifier: Apache-2.0
"""Bytes by part: they add up to what is sent, and points are shared by the triangles that have them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from quadshade.contract.formats import Formats
from quadshade.contract.triangles import ScreenTriangles
from quadshade.packing.pack import pack_primitives
from quadshade.packing.pack_vertices import choose_vertices
from quadshade.setup.triangle_setup import setup_triangles
from scripts.experiments.link_parts import PARTS, packed_costs, part_rows, vertex_costs
from scripts.experiments.shared_points import EDGES, LEVEL, Costs, rice_bits, shared_costs


def fan(count: int, order: int) -> ScreenTriangles:
    """Triangles round a corner, each with an edge in common with the one before it."""
    turns = np.arange(count + 1) / count * 3
    rim = np.rint(np.stack([32 + 30 * np.cos(turns), 32 + 30 * np.sin(turns)], axis=1) * 256).astype(np.int64)
    corners = np.stack([np.full((count, 2), 32 * 256), rim[:-1], rim[1:]], axis=1)
    of = np.stack([np.full(count, 200.0), 90 + 10 * turns[:-1], 90 + 10 * turns[1:]], axis=1)
    middles = np.stack([(of[:, one] + of[:, two]) / 2 + 3 for one, two in EDGES], axis=1)
    samples = np.concatenate([of, middles], axis=1)[:, None].repeat(3, axis=1)
    return ScreenTriangles(64, 64, corners, samples, np.full((count, 3), order), of * 100, ("r", "g", "b"))


@pytest.mark.parametrize("order", [1, 2])
def test_parts_are_all_that_is_sent(order: int) -> None:
    formats, triangles = Formats(), fan(9, order)
    batch = pack_primitives(setup_triangles(triangles, formats), formats)
    costs = packed_costs(batch, formats)
    assert sum(costs.bits.values()) == batch.starts[-1]
    assert set(costs.bits) == set(PARTS)
    rows = {row["way"]: row for row in part_rows(batch, formats, triangles, None)}
    assert list(rows)[::2] == ["packed", "points", "points, fixed widths", "limit"]
    # 11 corners, 9 spokes and 10 more middles: 2 bits, 2 x 15, 16, 3 x 13.
    curved = 19 * 39 if order == 2 else 0
    assert rows["points, fixed widths"]["all"] == pytest.approx(
        (9 * 2 + 11 * (30 + 16 + 39) + curved) / 8 / 9, abs=0.01
    )
    # Half a corner, and one and a half middles.
    owned = (2 + 85 / 2 + (39 * 3 / 2 if order == 2 else 0)) / 8
    assert rows["limit, fixed widths"]["all"] == pytest.approx(owned, abs=0.01)
    assert rows["points"]["all"] < rows["packed"]["all"] / 2
    for row in rows.values():
        assert row["all"] == pytest.approx(sum(row[part] for part in PARTS), abs=0.03)
        assert row["above"] == pytest.approx(row["all"] - rows["limit"]["all"], abs=0.02)


@pytest.mark.parametrize("order", [1, 2])
def test_parts_of_vertices_are_all_that_is_sent(order: int) -> None:
    formats, triangles = Formats(), fan(9, order)
    chosen = choose_vertices(setup_triangles(triangles, formats), triangles, formats, 0.25)
    assert chosen is not None and chosen.sent.all()
    costs = vertex_costs(chosen.tokens())
    words = chosen.words(np.zeros(0, np.uint32), np.zeros(0, np.int64))
    # Beside parameters, and zeros up to the end of the last word.
    bits = 3 + 6 * 5 + sum(costs.bits.values())
    assert set(costs.bits) == set(PARTS) and 0 <= 32 * len(words) - bits < 32


def test_a_fan_sends_a_corner_and_two_middles_a_triangle() -> None:
    triangles = fan(9, 2)
    costs = shared_costs(triangles, np.arange(9))
    positions, middles = costs.values["position", "residual"], costs.values["colour", "residual of a middle"]
    assert len(positions) == 2 * (3 + 8)
    assert len(middles) == 3 * (3 + 2 * 8)
    # Grey: channels behind the first have nothing left, and the first is 3 levels above the mean.
    assert middles[1::3] == middles[2::3] == [0] * (3 + 2 * 8)
    assert set(middles[::3]) <= {3 * LEVEL, 3 * LEVEL + 1}


def test_triangles_that_share_nothing_are_sent_whole() -> None:
    triangles = fan(4, 1)
    apart = triangles.vertices + np.arange(4)[:, None, None]
    costs = shared_costs(replace(triangles, vertices=apart), np.arange(4))
    assert len(costs.values["position", "residual"]) == 2 * 3 * 4


def test_rice_codes_and_entropies() -> None:
    assert rice_bits(np.zeros(5, np.int64)) == 5
    # -1, 1, -2, 2 are folded to 1, 2, 3, 4: best with a bit of their own each, or two.
    assert rice_bits(np.array([-1, 1, -2, 2])) == 12
    assert rice_bits(np.array([1 << 22])) == 15 + 24
    costs = Costs()
    for value in (0, 0, 1, 1):
        costs.add("colour", "one", value, 3)
    costs.add("colour", "another", 7, 1)
    assert costs.entropies() == {"colour": 4.0} and costs.bits == {"colour": 13}
