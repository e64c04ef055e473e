# SPDX-License-Identifier: Apache-2.0
"""
Error against cost: one curve of pictures, in which an allowed error and a budget are both looked up.

The pictures are those planned and drawn for a fixed row of limits (or of prices, for the root mean
square), the loosest first. Planning is greedy, so that a stricter limit now and then costs less than a looser
one. Therefore an error takes the cheapest picture among several limits around its own, and a budget the best
among several around the one where it ends: more bytes never give more error, a larger allowed error never
costs more bytes, and each is the inverse of the other.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from quadshade.adapt.plan import Plan, Planner
from quadshade.adapt.shader import OUTPUT_ROUNDING

STRICTER, LOOSER = 8, 4
"""Neighbours that are tried: limits up to a third apart from the one that is looked for."""
DEARER = 1.3
"""What takes so many times as much ends the search for a stricter limit that takes less,"""
MISSES = 2
"""where so many in a row do; and so does what exceeds the error end the search for a looser one."""
HIGHEST_PRICE, LOWEST_PRICE, PRICE_STEPS = 1e8, 1e-6, 360
_MANTISSAS = (
    (0.5, 1.0, 0.025),
    (1.0, 2.0, 0.05),
    (2.0, 5.0, 0.1),
    (5.0, 10.0, 0.25),
)
"""From, to below, and by."""


@lru_cache
def error_limits(full: float) -> np.ndarray:
    """
    Largest errors that pictures are planned for, falling, two to five per cent apart.

    Parameters
    ----------
    full : float
      Largest value of the output; the first limit allows every picture.

    Returns
    -------
    (k,) float64
      Output units, round numbers but for the first; the last is a little more than the output's rounding.
      Remembered, so not to be written.
    """
    rising: list[float] = []
    scale = 1.0
    while scale < full:
        for low, high, step in _MANTISSAS[bool(rising) :]:
            rising += [scale * (low + index * step) for index in range(round((high - low) / step))]
        scale *= 10
    useful = [round(limit, 6) for limit in rising if OUTPUT_ROUNDING < limit < full + OUTPUT_ROUNDING]
    limits = np.array([full + OUTPUT_ROUNDING, *reversed(useful)])
    limits.setflags(write=False)
    return limits


class Picture(NamedTuple):
    """A plan and how far it is off, by the measure of its planner."""

    plan: Plan
    error: float

    def cost(self, unit: str) -> int:
        """What it takes, in ``bytes``, ``clocks`` or bytes on the ``line``."""
        return self.plan.cost(unit)


class Curve:
    """
    The pictures of one kind of channels, each planned when it is first asked for.

    Parameters
    ----------
    planner : Planner
    verify : bool
      Errors are those of the golden model's pixels; else estimates.
    """

    def __init__(self, planner: Planner, verify: bool) -> None:
        self.planner, self.verify = planner, verify
        self.shading = planner.shader.shading
        if planner.measure == "max":
            self.steps = error_limits(planner.shader.full)
        else:
            self.steps = np.geomspace(HIGHEST_PRICE, LOWEST_PRICE, PRICE_STEPS)
        self._known: dict[int, Picture] = {}
        self._others: dict[int, list[Picture]] = {}
        self._least: dict[int, int] = {}

    def __len__(self) -> int:
        return len(self.steps)

    def least_bytes(self, index: int) -> int:
        """What the picture for a limit takes at least; 0 for a price."""
        if self.planner.measure != "max":
            return 0
        if index not in self._least:
            self._least[index] = self.planner.least_bytes(float(self.steps[index]))
        return self._least[index]

    def floor(self, first: int) -> int:
        """Bytes that :meth:`cheapest` takes at least from an index: what takes more is passed over there."""
        return min(self.least_bytes(index) for index in range(max(first - MISSES, 0), first + 1))

    def draw_around(self, index: int) -> None:
        """Draw at once what pictures for a limit and those beside it begin with: most of it is the same."""
        if self._drawn and index not in self._known:
            near = self.steps[max(index - MISSES, 0) : index + MISSES + 1]
            self.planner.draw_first([float(self.steps[index]), *near.tolist()])

    @property
    def _drawn(self) -> bool:
        """Whether pictures are planned by what is drawn."""
        return self.verify and self.planner.measure == "max"

    def picture(self, index: int) -> Picture:
        """The picture for a limit or a price, the loosest first."""
        if index not in self._known:
            step, planner = float(self.steps[index]), self.planner
            if planner.measure != "max":
                plan = planner.for_price(step)
            else:
                plan = planner.for_limit(step) if self.verify else planner.estimated_for_limit(step)
            self._known[index] = Picture(plan, plan.error(self.verify))
        return self._known[index]

    def pictures(self, index: int) -> list[Picture]:
        """The picture for a limit, and where much is divided others, planned in other ways."""
        picture = self.picture(index)
        if not (self._drawn and picture.plan.much_divided):
            return [picture]
        if index not in self._others:
            plans = self.planner.other_ways(float(self.steps[index]))
            self._others[index] = [Picture(plan, plan.error(True)) for plan in plans]
        return [picture, *self._others[index]]

    def _first(self, good: Callable[[Picture], bool]) -> int:
        """By bisection: the loosest picture that is good, if all that are stricter are; else the last."""
        low, high = 0, len(self) - 1
        while low < high:
            middle = (low + high) // 2
            if good(self.picture(middle)):
                high = middle
            else:
                low = middle + 1
        return low

    def first_within(self, error: float) -> int:
        """Where to look for an error: pictures from this index on keep it, the last where none does."""
        if self.planner.measure == "max":
            return min(int((self.steps > error).sum()), len(self) - 1)
        return self._first(lambda picture: picture.error <= error)

    def _stricter(self, first: int, unit: str, enough: float) -> list[Picture]:
        """Pictures from an index on, up to some in a row that take more than enough."""
        tried: list[Picture] = []
        dear = 0
        for index in range(first, min(first + STRICTER, len(self) - 1) + 1):
            new = self.pictures(index)
            tried += new
            dear = dear + 1 if new[0].cost(unit) > enough else 0
            if dear == MISSES:
                break
        return tried

    def cheapest(self, error: float, unit: str, most: float = np.inf) -> Picture:
        """
        The picture that takes least of those that keep an error.

        Where there is none, the one whose error is least of those for the strictest limits. A plan that takes
        more than a picture that is known is not drawn: mending seldom makes it cheaper.

        Parameters
        ----------
        error : float
        unit : str
        most : float
          What a picture takes that keeps the error and is known already; dearer ones than that are of no
          interest, but for the first.
        """
        first = self.first_within(error)
        tried: list[Picture] = []

        def draw(index: int) -> bool:
            """Whether a picture is drawn, and keeps the error."""
            nonlocal most
            if tried and unit == "bytes" and self.least_bytes(index) > most:
                return False
            new = self.pictures(index)
            tried.extend(new)
            costs = [picture.cost(unit) for picture in new if picture.error <= error]
            most = min([most, *costs])
            return bool(costs)

        self.draw_around(first)
        draw(first)
        plan, missed, dear = tried[0].plan, 0, 0
        enough = DEARER * plan.cost(unit)
        for index in range(first - 1, -1, -1):
            missed = 0 if draw(index) else missed + 1
            if missed == MISSES:
                break
        # Where little is divided each triangle has what is cheapest for it, and no stricter limit takes less.
        several = plan.much_divided or not self._drawn
        for index in range(first + 1, min(first + STRICTER, len(self) - 1) + 1) if several else ():
            if unit == "bytes" and self.least_bytes(index) > min(most, enough):
                break
            draw(index)
            dear = dear + 1 if self.picture(index).cost(unit) > enough else 0
            if dear == MISSES:
                break
        kept = [picture for picture in tried if picture.error <= error]
        if not kept and self.planner.measure == "max":
            # Less than the strictest limit in the row.
            plan = self.planner.for_limit(error) if self.verify else self.planner.estimated_for_limit(error)
            tried.append(Picture(plan, plan.error(self.verify)))
            kept = [picture for picture in tried[-1:] if picture.error <= error]
        if not kept:
            return min(tried, key=lambda picture: (picture.error, picture.cost(unit)))
        return min(kept, key=lambda picture: (picture.cost(unit), picture.error))

    def best(self, budget: int, unit: str) -> Picture | None:
        """The picture with the least error that a budget pays for, None where it pays for none."""
        beyond = self._first(lambda picture: picture.cost(unit) > budget)
        looser = sorted({0, *range(max(beyond - LOOSER, 0), beyond)})
        tried = [picture for index in looser for picture in self.pictures(index)]
        tried += self._stricter(beyond, unit, DEARER * budget)
        paid = [picture for picture in tried if picture.cost(unit) <= budget]
        return min(paid, key=lambda picture: (picture.error, picture.cost(unit))) if paid else None
