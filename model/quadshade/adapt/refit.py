# SPDX-License-Identifier: Apache-2.0
"""A cheaper plan for a limit: every part fitted anew at its own pixels, and what holds the limit is drawn."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property

import numpy as np

from quadshade.adapt.choose import Goal, choose_orders, divide
from quadshade.adapt.phong_pixels import PartErrors
from quadshade.adapt.plan import Plan, Planner
from quadshade.adapt.shader import OUTPUT_ROUNDING, Options, Surface
from quadshade.contract.arrays import Bools, Floats, Ints
from quadshade.contract.formats import CONSTANT
from quadshade.scene.project import Projected
from quadshade.setup.coverage import mesh_rows, pixels_of
from quadshade.setup.edges import cut_triangles
from quadshade.shading.reference import barycentric

MOST_PIXELS = 64
"""Of a part's outline, and of its inside, at which it is fitted; the drawing is compared at all."""
ROUNDS = 10
"""Divisions, at most."""
TRIALS = 8
"""Combinations of orders that are drawn for a part, at most."""
LOOSER = (1.3, 2.0)
"""Times the limit: surfaces that were divided for these are tried, they have fewer parts."""


class RefitPlan(Plan):
    """A plan with samples of its own: what the planner remembers of a part's orders is of other samples."""

    fit = "minimax"

    @cached_property
    def drawn(self) -> PartErrors:
        """How far the golden model's pixels are off."""
        errors = self.planner.phong.errors(self.triangles, self.surface.root, self.planner.shader.formats)
        return PartErrors(*errors.T)


class Choices:
    """
    What is drawn for each part of a surface, and whether that keeps the limit.

    Parameters
    ----------
    orders : (n, channels) int64
    samples : (n, channels, 6) float64
    kept : (n,) bool
    """

    def __init__(self, orders: Ints, samples: Floats, kept: Bools) -> None:
        self.orders, self.samples, self.kept = orders, samples, kept

    def put(self, rows: Ints, orders: Ints, samples: Floats) -> None:
        """What keeps the limit for some parts."""
        self.orders[rows], self.samples[rows], self.kept[rows] = orders, samples, True


def _places(owner: Ints, y: Ints, count: int) -> Bools:
    """Which pixels a part is fitted at: some of its outline and some within."""
    outline = np.zeros(len(owner), dtype=bool)
    ends = np.flatnonzero((np.diff(owner) != 0) | (np.diff(y) != 0))
    outline[[0, -1]] = outline[ends] = outline[ends + 1] = True
    group = 2 * owner + outline
    have = np.bincount(group, minlength=2 * count)
    stride = np.maximum(-(-have // MOST_PIXELS), 1)
    order = np.argsort(group, kind="stable")
    rank = np.arange(len(owner)) - (np.cumsum(have) - have)[group[order]]
    taken = np.zeros(len(owner), dtype=bool)
    taken[order] = rank % stride[group[order]] == 0
    return taken


class Refit:
    """
    Plans for one limit with polynomials that are fitted at the pixels of each part.

    Parameters
    ----------
    planner : Planner
      Its measure is the largest error.
    max_error : float
      Output units, the output's rounding included.
    """

    def __init__(self, planner: Planner, max_error: float) -> None:
        self.planner, self.shader, self.max_error = planner, planner.shader, max_error
        self._known: dict[int, tuple[Ints, Floats, bool]] = {}
        self._table = planner.shader.table(max_error)
        self._goal = Goal(planner.allowed(max_error, self._table))

    def cheapest(self, plan: Plan) -> Plan:
        """
        The cheapest plan that is found to keep the limit.

        Parameters
        ----------
        plan : Plan
          What there is without; returned where nothing is cheaper.
        """
        self._table = plan.table
        first = plan.drawn.largest <= self.max_error
        old = Choices(plan.decision.orders.copy(), plan.samples.copy(), first)
        best = plan
        surfaces: list[Surface | None] = [plan.surface]
        if len(plan.surface.root) > len(self.planner.whole.root):
            surfaces += [self._surface(looser) for looser in LOOSER]
        for number, surface in enumerate(surfaces):
            tried = None if surface is None else self._settled(surface, old if number == 0 else None)
            if tried is not None and (tried.bytes < best.bytes or not first.all()):
                best, first = tried, np.ones(1, dtype=bool)
        return best

    def _surface(self, looser: float) -> Surface:
        return self.planner.estimated_for_limit(looser * self.max_error).surface

    def _settled(self, surface: Surface, old: Choices | None) -> Plan | None:
        """Parts of which no order keeps the limit are halved until all do; None where that does not end."""
        planner = self.planner
        for _ in range(ROUNDS):
            choices = self._choices(surface, old)
            old = None
            decision = choose_orders(surface, self.shader, self._goal)
            decision = replace(decision, orders=choices.orders, samples=choices.samples)
            if choices.kept.all():
                plan = RefitPlan(planner, surface, decision, self._table)
                return plan if plan.drawn.largest.max(initial=0) <= self.max_error else None
            wanting = ~choices.kept & (surface.assessed.pixels > 1)
            divided = divide(surface, replace(decision, wanting=wanting, forced=True), self.shader)
            if divided is surface:
                return None
            surface = divided
        return None

    def _choices(self, surface: Surface, old: Choices | None) -> Choices:
        """Of each part the cheapest that keeps the limit, each part found out once."""
        parts = surface.part.tolist()
        new = np.array([row for row, part in enumerate(parts) if part not in self._known], dtype=np.int64)
        if len(new):
            assessed = surface.assessed.take(new)
            mine = Surface(surface.projected.ordered(new), surface.root[new], assessed, surface.part[new])
            choices = self._planned(mine)
            if old is not None:
                words = [self.shader.words(one.orders) for one in (old, choices)]
                rows = np.flatnonzero(old.kept[new] & (~choices.kept | (words[0][new] < words[1])))
                choices.put(rows, old.orders[new[rows]], old.samples[new[rows]])
            self._improve(mine, choices)
            for row, index in enumerate(new.tolist()):
                found = choices.orders[row], choices.samples[row], bool(choices.kept[row])
                self._known[parts[index]] = found
        orders, samples, kept = zip(*(self._known[part] for part in parts), strict=True)
        return Choices(np.array(orders), np.array(samples), np.array(kept))

    def _planned(self, surface: Surface) -> Choices:
        """What the planner would choose for the limit."""
        decision = choose_orders(surface, self.shader, self._goal)
        plan = Plan(self.planner, surface, decision, self._table)
        drawn = plan.drawn
        # Without a pixel nothing is cheaper than constants, and nothing is seen.
        orders = np.where(drawn.pixels[:, None] == 0, CONSTANT, decision.orders)
        return Choices(orders, plan.samples, drawn.largest <= self.max_error)

    def _improve(self, surface: Surface, choices: Choices) -> None:
        """Draw cheaper combinations of orders, the cheapest first, and keep what keeps the limit."""
        projected, root = surface.projected, surface.root
        screen = projected.width, projected.height, self.shader.formats.subpixel_bits
        owner, x, y = pixels_of(mesh_rows(cut_triangles(projected.vertices, *screen), len(projected)))
        if not len(owner):
            return
        taken = _places(owner, y, len(projected))
        owner, x, y = owner[taken], x[taken], y[taken]
        have = np.bincount(owner, minlength=len(projected))
        rows = np.flatnonzero(have)
        own, whole = (
            barycentric(corners, triangle, x, y, self.shader.formats.subpixel_bits)
            for corners, triangle in (
                (projected.vertices, owner),
                (self.planner.whole.projected.vertices, root[owner]),
            )
        )
        options = self.shader.options_at(root[rows], whole, own, have[rows], self.max_error - OUTPUT_ROUNDING)
        self._draw(projected, root, rows, options, choices)

    def _draw(self, projected: Projected, root: Ints, rows: Ints, options: Options, choices: Choices) -> None:
        """Draw the options of some parts until one keeps the limit or is no cheaper."""
        shader = self.shader
        words = shader.words(options.orders)
        now = np.where(choices.kept[rows], shader.words(choices.orders[rows]), np.inf)
        possible = (options.errors <= self.max_error + OUTPUT_ROUNDING) & (words < now[:, None])
        score = np.where(possible, words + 1e-6 * options.errors, np.inf)
        rank = score.argsort(axis=1, kind="stable")
        todo = np.arange(len(rows))
        for trial in range(min(TRIALS, rank.shape[1])):
            pick = rank[todo, trial]
            todo, pick = (values[np.isfinite(score[todo, pick])] for values in (todo, pick))
            if not len(todo):
                break
            orders, samples = options.orders[todo, pick], options.samples[todo, pick]
            drawn = rows[todo]
            triangles = shader.screen_triangles(projected.ordered(drawn), samples, orders, self._table)
            errors = self.planner.phong.errors(triangles, root[drawn], shader.formats)[:, 0]
            good = errors <= self.max_error
            choices.put(drawn[good], orders[good], samples[good])
            todo = todo[~good]
