# SPDX-License-Identifier: Apache-2.0
"""
Where a picture is cut into tiles, so that as few bytes as possible go over the line.

Bands of scanlines are cut first, then each band by itself, as the part of it that has pixels is its own. A
cut costs the packets that it cuts, which are sent twice; a tile the pixels that are read of it. So tiles are
smaller than the screen where that saves more pixels than it costs. One without pixels is neither drawn nor
read.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from quadshade.contract.arrays import Ints
from quadshade.setup.tile import Rectangle

PACKET_BYTES = 40
"""What a packet takes on the line, about: a plan only compares."""

TILE_BYTES = 1000
"""What every tile takes beside pixels and packets: a clear, questions and answers, and waiting for these."""

SHIFTS = 5
"""Places tried for the first cut."""

LEAST_SIDE = 16
"""Tiles for several boards get no smaller than this, in pixels."""

TILES_A_BOARD = 4
"""So many tiles at least for each of several boards, that all are done at about the same time."""


@dataclass(frozen=True)
class Cost:
    """A tile, and about how many bytes it takes on the line."""

    tile: Rectangle
    bytes: int


def plan_tiles(
    extents: Ints,
    size: tuple[int, int],
    most: tuple[int, int],
    pixel_bytes: float,
    boards: int = 1,
) -> list[Cost]:
    """
    Tiles that have all pixels, the dearest one first.

    Parameters
    ----------
    extents : (n, 4) int64
      Left, top, right and bottom of every packet's pixels (:attr:`quadshade.setup.tile.Cuttable.extents`).
    size : tuple of int
      Width and height of the picture.
    most : tuple of int
      Width and height of a tile at most.
    pixel_bytes : float
      Read of every pixel.
    boards : int
      Boards that draw at the same time.

    Returns
    -------
    list of Cost
      Tiles do not overlap.
    """
    extents = np.clip(extents, 0, [*size, *size])
    extents = extents[(extents[:, 2] > extents[:, 0]) & (extents[:, 3] > extents[:, 1])]
    if not len(extents):
        return []
    width, height = min(most[0], size[0]), min(most[1], size[1])
    best = _best_bands(extents, width, height, pixel_bytes)
    while max(width, height) >= 2 * LEAST_SIDE:
        # Smaller tiles lie closer around what is drawn, and more boards have some to do.
        across = (-(-width // 2), height) if width >= height else (width, -(-height // 2))
        down = (width, -(-height // 2)) if width >= height else (-(-width // 2), height)
        tried = [
            (plan, shape) for shape in (across, down) if (plan := _best_bands(extents, *shape, pixel_bytes))
        ]
        plan, shape = min(tried, key=lambda one: _total(one[0]))
        if _total(plan) >= _total(best) and (boards == 1 or len(best) >= TILES_A_BOARD * boards):
            break
        best, (width, height) = plan, shape
    return sorted(best, key=lambda cost: -cost.bytes)


def _cuts(low: int, high: int, most: int) -> Iterator[list[int]]:
    """Ways to cut low .. high into the fewest pieces of at most a length: where pieces begin, and the end."""
    count = -(-(high - low) // most)
    even = np.linspace(low, high, count + 1).astype(int).tolist()
    yield even
    slack = count * most - (high - low)
    for shift in range(SHIFTS if count > 1 and slack else min(1, count - 1)):
        first = most - slack * shift // (SHIFTS - 1)
        yield [low, *range(low + first, high, most), high] if first > 0 else even


def _best_bands(extents: Ints, width: int, height: int, pixel_bytes: float) -> list[Cost]:
    """The cheapest of several ways to cut into bands, each of them cut best."""
    top, bottom = int(extents[:, 1].min()), int(extents[:, 3].max())
    plans = []
    for cuts in _cuts(top, bottom, height):
        tiles: list[Cost] = []
        for first, last in pairwise(cuts):
            within = extents[(extents[:, 1] < last) & (extents[:, 3] > first)]
            if len(within):
                tiles += _best_columns(
                    np.clip(within, [0, first] * 2, [1 << 30, last] * 2), width, pixel_bytes
                )
        plans.append(tiles)
    return min(plans, key=_total)


def _total(tiles: Sequence[Cost]) -> int:
    return sum(cost.bytes for cost in tiles)


def _best_columns(extents: Ints, width: int, pixel_bytes: float) -> list[Cost]:
    """One band, cut where that is cheapest; each tile is as large as what is drawn on it."""
    left, right = int(extents[:, 0].min()), int(extents[:, 2].max())
    plans = []
    for cuts in _cuts(left, right, width):
        tiles = []
        for first, last in pairwise(cuts):
            within = extents[(extents[:, 0] < last) & (extents[:, 2] > first)]
            if len(within):
                near = np.clip(within, [first, 0] * 2, [last, 1 << 30] * 2)
                (x, y), (end_x, end_y) = near[:, :2].min(axis=0), near[:, 2:].max(axis=0)
                tile = Rectangle(int(x), int(y), int(end_x - x), int(end_y - y))
                area = tile.width * tile.height
                tiles.append(Cost(tile, round(area * pixel_bytes) + len(within) * PACKET_BYTES + TILE_BYTES))
        plans.append(tiles)
    return min(plans, key=_total)
