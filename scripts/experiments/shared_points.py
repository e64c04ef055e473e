# SPDX-License-Identifier: Apache-2.0
"""A line that would send corners and edge middles, each once for its triangles, in a Rice code."""

from __future__ import annotations

from collections import defaultdict

import numpy as np

from quadshade.contract.formats import LINEAR
from quadshade.contract.triangles import ScreenTriangles

LEVEL = 32
"""Units of a grey level in which points' colours are sent: as much off as packing may add."""

TABLE = 64
"""Corners, and middles, that can be named again: the last ones."""

PREFIX, LONG = 15, 24
"""A Rice code with so many ones before it is sent whole, in so many bits."""

MOST_PARAMETER = 16
STARTS = 2 + 3
"""Bits of a triangle of points that are no number: its start and kind, orders, which corner it drops."""

TRIMS = 2
"""And how many scanlines without a pixel it has at both ends, about."""

EDGES = ((0, 1), (0, 2), (1, 2))


class Costs:
    """
    Bits by part, and the values that they stand for by kind.

    Attributes
    ----------
    bits : dict of str to float
    values : dict of (str, str) to list of int
      By part and kind.
    """

    def __init__(self) -> None:
        self.bits: dict[str, float] = defaultdict(float)
        self.values: dict[tuple[str, str], list[int]] = defaultdict(list)

    def add(self, part: str, kind: str, value: int, bits: float) -> None:
        """A value that takes some bits."""
        self.bits[part] += bits
        self.values[part, kind].append(int(value))

    def entropies(self) -> dict[str, float]:
        """Bits by part, if every value took what it tells among those of its kind."""
        out: dict[str, float] = defaultdict(float)
        for (part, _), values in self.values.items():
            _, counts = np.unique(values, return_counts=True)
            out[part] += float(counts @ np.log2(len(values) / counts))
        return out

    def rice(self) -> None:
        """Give every residual the bits of a Rice code, with the best parameter of its kind."""
        for (part, kind), values in self.values.items():
            if kind.startswith("residual"):
                self.bits[part] += rice_bits(np.array(values))


def rice_bits(values: np.ndarray) -> int:
    """Bits of (n,) residuals in the Rice code with the best parameter."""
    folded = np.where(values >= 0, 2 * values, -2 * values - 1)
    sums = []
    for parameter in range(MOST_PARAMETER):
        ones = folded >> parameter
        sums.append(int(np.where(ones < PREFIX, ones + 1 + parameter, PREFIX + LONG).sum()))
    return min(sums)


class SharedPoints:
    """Triangles as points: what was sent last, and the costs so far."""

    def __init__(self, triangles: ScreenTriangles) -> None:
        assert triangles.depth is not None
        colours = np.swapaxes(np.rint(triangles.samples * LEVEL).astype(np.int64), 1, 2)
        depth = np.rint(triangles.depth).astype(np.int64)[:, :, None]
        self._corners = np.concatenate([triangles.vertices, depth, colours[:, :3]], axis=2)
        self._middles = colours[:, 3:]
        self._quadratic = triangles.orders.max(axis=1) > LINEAR
        self._tables: tuple[list[tuple], list[tuple]] = ([], [])
        self._last: tuple[list[tuple], dict[frozenset[int], tuple], bool] | None = None
        self.costs = Costs()

    def distinct(self, drawn: np.ndarray) -> tuple[int, int]:
        """How many corners, and middles of curved triangles, some triangles (n,) have in all."""
        corners = {tuple(point) for index in drawn.tolist() for point in self._corners[index].tolist()}
        middles = {
            (frozenset((tuple(self._corners[index, one]), tuple(self._corners[index, two]))), *middle)
            for index in drawn[self._quadratic[drawn]].tolist()
            for (one, two), middle in zip(EDGES, self._middles[index].tolist(), strict=True)
        }
        return len(corners), len(middles)

    def _is_known(self, point: tuple, table: list[tuple]) -> bool:
        """Name a point of a table; else put it there, to be sent."""
        known = point in table
        self.costs.add("connectivity", "named", int(known), 1)
        if known:
            place = len(table) - 1 - table.index(point)
            self.costs.add("connectivity", "place", place, TABLE.bit_length() - 1)
        else:
            table.append(point)
            del table[:-TABLE]
        return known

    def _colours(self, kind: str, left: np.ndarray) -> None:
        """What is left of colours; of all but the first, what is left of that again."""
        for value in np.diff(left, prepend=0):
            self.costs.add("colour", f"residual of a {kind}", value, 0)

    def _corner(self, point: tuple, base: np.ndarray) -> None:
        if not self._is_known(point, self._tables[0]):
            left = np.array(point) - base
            for value in left[:2]:
                self.costs.add("position", "residual", value, 0)
            self.costs.add("depth", "residual", left[2], 0)
            self._colours("corner", left[3:])

    def _middle(self, point: tuple, first: tuple, second: tuple) -> None:
        if not self._is_known(point, self._tables[1]):
            self._colours("middle", np.array(point) - ((np.array(first) + np.array(second))[3:] >> 1))

    def _order(self, corners: list[tuple], middles: dict[frozenset[int], tuple], curved: bool) -> tuple:
        """Which corner of the last triangle this one drops, 3 for no edge in common; its corners' order."""
        for drop in range(3) if self._last and (self._last[2] or not curved) else ():
            before, middles_before, _ = self._last
            kept = [before[corner] for corner in range(3) if corner != drop]
            if not all(point in corners for point in kept):
                continue
            one, two = (corners.index(point) for point in kept)
            pair = frozenset(corner for corner in range(3) if corner != drop)
            if one != two and (not curved or middles_before[pair] == middles[frozenset((one, two))]):
                return drop, [one, two, 3 - one - two]
        return 3, [0, 1, 2]

    def send(self, index: int) -> None:
        """A triangle."""
        corners = [tuple(point) for point in self._corners[index].tolist()]
        middles = {
            frozenset(edge): tuple(self._middles[index, place].tolist()) for place, edge in enumerate(EDGES)
        }
        curved = bool(self._quadratic[index])
        self.costs.bits["connectivity"] += STARTS + TRIMS
        drop, order = self._order(corners, middles, curved)
        sorted_corners = [corners[corner] for corner in order]
        one, two, three = sorted_corners
        if drop == 3:
            base = np.array(self._last[0][2] if self._last else np.zeros(len(one), np.int64))
            self._corner(one, base)
            self._corner(two, np.array(one))
            base = np.array(two)
        else:
            base = np.array(one) + np.array(two) - np.array(self._last[0][drop])
        self._corner(three, base)
        placed = {frozenset(edge): middles[frozenset(order[corner] for corner in edge)] for edge in EDGES}
        for edge in EDGES if curved else ():
            if drop == 3 or edge != (0, 1):
                self._middle(placed[frozenset(edge)], sorted_corners[edge[0]], sorted_corners[edge[1]])
        self._last = sorted_corners, placed, curved


def shared_costs(triangles: ScreenTriangles, drawn: np.ndarray) -> Costs:
    """What the triangles of some indices (n,) would take as points, part by part."""
    points = SharedPoints(triangles)
    for index in drawn.tolist():
        points.send(index)
    points.costs.rice()
    return points.costs
