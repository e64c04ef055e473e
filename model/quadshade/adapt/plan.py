# SPDX-License-Identifier: Apache-2.0
"""A plan for one limit: per triangle the cheapest orders whose drawing keeps it, or division."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import cached_property

import numpy as np

from quadshade.adapt.choose import Decision, Goal, choose_orders, divide, settle
from quadshade.adapt.costs import core_clocks, stream_bytes
from quadshade.adapt.pair_numbers import PairNumbers
from quadshade.adapt.phong_pixels import COLOURS, PartErrors, PhongPixels
from quadshade.adapt.result import Adapted
from quadshade.adapt.shader import OUTPUT_ROUNDING, Shader, Surface, Table, chosen_samples
from quadshade.contract.formats import CONSTANT, ORDER_NAMES, Formats
from quadshade.contract.triangles import ScreenTriangles
from quadshade.golden.shade.render_core import first_entry
from quadshade.packing.line import picture_line_bytes
from quadshade.scene.project import Projected

LineCount = Callable[[ScreenTriangles, Formats], int]
"""Bytes on the serial line, of triangles for a core."""

MUCH = 1.05
"""Triangles, over those of the undivided mesh."""
LOOSE, OTHER_LOOSE, DIVIDED_LOOSE = 1.6, 1.4, 1.2
"""Of what is allowed, as most estimates are too high: what orders may have that are drawn first."""
AGREE, OTHER_AGREE = 0.1, 0.2
"""See :class:`.choose.Goal`."""
NEXT = 1 - 1e-9
"""Of an estimate: other orders have to be better than what was drawn."""
ROUNDS = 16
"""Drawings after which a limit is given up."""


class Planner:
    """
    One mesh and one kind of channels, planned for one goal after another.

    Parameters
    ----------
    projected : Projected
    shader : Shader
    phong : PhongPixels, optional
      Of the mesh, where planners share it.
    count_line : callable
      Bytes on the serial line, of triangles for a core.
    """

    def __init__(
        self,
        projected: Projected,
        shader: Shader,
        phong: PhongPixels | None = None,
        count_line: LineCount = picture_line_bytes,
    ) -> None:
        self.shader, self.measure, self.count_line = shader, shader.measure, count_line
        if phong is None:
            phong = PhongPixels(projected, shader.lights, shader.material, shader.formats)
        self.projected, self.phong = projected, phong
        self._whole_decisions: dict[float, Decision] = {}
        self._numbers, self._drawn = PairNumbers(), np.empty((0, 4))

    @cached_property
    def whole(self) -> Surface:
        """The undivided mesh, shaded and fitted when it is first asked for."""
        return self.shader.surface(self.projected)

    def settled(
        self,
        allowed: np.ndarray,
        price: float = 0.0,
        surface: Surface | None = None,
        agree: float = 0.0,
        table: Table | None = None,
    ) -> Plan:
        """
        Orders chosen and triangles divided, as far as estimates go.

        Parameters
        ----------
        allowed : (roots,) float64
          See :class:`Goal`.
        price, agree : float
          See :class:`Goal`.
        surface : Surface, optional
          Where to start; by default at the undivided mesh.
        table : Table, optional
          By default the finest.
        """
        surface, table = self.whole if surface is None else surface, table or self.shader.table()
        return Plan(self, *settle(surface, self.shader, Goal(allowed, price, agree)), table)

    def undivided(self, max_error: float) -> Decision:
        """Orders of the undivided mesh that are drawn first for a largest error, chosen once."""
        if max_error not in self._whole_decisions:
            goal = Goal(LOOSE * self.allowed(max_error, self.shader.table(max_error)), agree=AGREE)
            self._whole_decisions[max_error] = choose_orders(self.whole, self.shader, goal)
        return self._whole_decisions[max_error]

    def allowed(self, max_error: float, table: Table) -> np.ndarray:
        """(roots,) float64: what is allowed of every triangle of the undivided mesh, for a largest error."""
        return np.full(len(self.projected), max_error - OUTPUT_ROUNDING - table.error)

    def estimated_for_limit(self, max_error: float) -> Plan:
        """The plan for a largest error as far as estimates go."""
        table = self.shader.table(max_error)
        return self.settled(self.allowed(max_error, table), table=table)

    def least_bytes(self, max_error: float) -> int:
        """What the plan for a largest error takes at least: what has to be divided takes another packet."""
        decision, shader = self.undivided(max_error), self.shader
        packet = shader.words(np.full(len(shader.place), CONSTANT)) - shader.second_words - shader.depth_words
        table = self._coarsest(max_error)
        known = self.bytes_of(self.whole, decision.orders, table, table.least_read)
        return 0 if known is None else known + 4 * int(packet) * int(decision.wanting.sum())

    def _coarsest(self, max_error: float) -> Table:
        """What pictures for an error may be drawn with instead of their table."""
        table = self.shader.table(max_error)
        return self.shader.coarser(table) or table

    def least_possible(self, max_error: float) -> int:
        """
        What a verified picture for a largest error takes at least, whatever its polynomials, without fitting.

        Where the light varies by more than twice the error over a triangle's pixels, no constant colour is
        good enough: it takes a channel of a higher order, or another packet.
        """
        heads, shader = self.phong.cut.heads, self.shader
        flat = float(shader.words(np.full(len(shader.place), CONSTANT)))
        words = len(heads) * flat - shader.second_words * int((heads["rows_second"] == 0).sum())
        more = shader.least_more(self.phong.ranges > 2 * max_error)
        words += np.minimum(more, flat - shader.second_words).sum()
        words -= shader.depth_words * shader.constant_depth(self.projected)[heads["triangle"]].sum()
        return 4 * int(words) + shader.table(max_error).bytes()

    def least_beside(self, other: Planner, max_error: float) -> int:
        """
        As :meth:`least_bytes`, from what is known of another kind of cosines; 0 where that is too little.

        Where highlights are level both kinds draw the same. The others are fitted, and not remembered.
        """
        surface, table = other.whole, self._coarsest(max_error)
        rows = np.flatnonzero(~other.shader.level_highlights(surface.assessed))
        if 2 * len(rows) > len(surface.root):
            return 0
        goal = Goal(LOOSE * self.allowed(max_error, self.shader.table(max_error)))
        orders = choose_orders(surface, other.shader, goal).orders
        part = surface.projected.ordered(rows)
        mine = Surface(part, rows, self.shader.assess(part, rows), rows)
        orders[rows] = choose_orders(mine, self.shader, goal).orders
        return self.bytes_of(surface, orders, table) or 0

    def divides_much(self, max_error: float) -> bool:
        """Whether no order is good enough for many of the undivided triangles."""
        wanting = self.undivided(max_error).wanting
        return bool(wanting.sum() > (MUCH - 1) * len(wanting))

    def bytes_of(
        self, surface: Surface, orders: np.ndarray, table: Table, first: int | None = None
    ) -> int | None:
        """
        What (n, channels) orders take on a surface, from what is known of its parts' packets.

        Power tables are counted from their entry ``first`` on; by default what they take at least, about.

        None where a part's words may be so coarse that the set-up divides it.
        """
        if (surface.assessed.packets < 0).any():
            return None
        return 4 * self.shader.stream_words(surface, orders) + table.bytes(first)

    def for_limit(self, max_error: float) -> Plan:
        """
        The verified plan for a largest error; no pixel is off by more, if that can be had.

        A coarser table takes fewer bytes, and now and then so does the picture that is drawn with it.
        """
        best = self._drawn_within(max_error, self._first(max_error))
        while not best.much_divided and (table := self.shader.coarser(best.table)) is not None:
            decision = choose_orders(
                self.whole, self.shader, Goal(LOOSE * self.allowed(max_error, table), agree=AGREE)
            )
            plan = self._drawn_within(max_error, Plan(self, self.whole, decision, table))
            if plan.bytes >= best.bytes or plan.error(verify=True) > max_error:
                break
            best = plan
        return best

    def draw_first(self, limits: Iterable[float]) -> None:
        """Draw at once what pictures for some limits begin with, if they have the first one's table."""
        plans = [self._first(limit) for limit in limits]
        self.draw(plan for plan in plans if plan.table is plans[0].table)

    def other_ways(self, max_error: float) -> list[Plan]:
        """
        The same from other beginnings, one of them divided by estimates.

        Planning is greedy: where much is divided they now and then take fewer bytes.
        """
        table = self.shader.table(max_error)
        allowed = self.allowed(max_error, table)
        divided = self.settled(DIVIDED_LOOSE * allowed, agree=AGREE, table=table)
        decision = choose_orders(self.whole, self.shader, Goal(OTHER_LOOSE * allowed, agree=OTHER_AGREE))
        whole = Plan(self, self.whole, decision, table)
        return [
            self._drawn_within(max_error, divided, LOOSE),
            self._drawn_within(max_error, whole, OTHER_LOOSE),
        ]

    def _first(self, max_error: float) -> Plan:
        """What is drawn first for a largest error."""
        return Plan(self, self.whole, self.undivided(max_error), self.shader.table(max_error))

    def _drawn_within(self, max_error: float, plan: Plan, loose: float = LOOSE) -> Plan:
        """
        Draw a plan, then other orders where they do not keep a limit, until all do.

        What is drawn says how much an estimate is off, and so which orders may be next. A triangle is divided
        where none is good enough.
        """
        table, agree = plan.table, plan.decision.agree
        allowed = loose * self.allowed(max_error, table)
        for _ in range(ROUNDS):
            off, root, estimate = plan.drawn.largest, plan.surface.root, plan.decision.largest
            kept = off <= max_error
            if kept.all():
                break
            np.maximum.at(allowed, root[kept], estimate[kept])
            over = np.flatnonzero(~kept)
            share = (max_error - OUTPUT_ROUNDING) / (off[over] - OUTPUT_ROUNDING)
            enough = np.minimum(share, NEXT) * estimate[over]
            lower = allowed.copy()
            np.minimum.at(lower, root[over], enough)
            wanting = choose_orders(plan.surface, self.shader, Goal(lower)).wanting & ~kept
            np.minimum.at(allowed, root[over], np.where(wanting[over], np.inf, enough))
            surface = divide(plan.surface, replace(plan.decision, wanting=wanting), self.shader)
            plan = self.settled(allowed, surface=surface, agree=agree, table=table)
        return plan

    def for_price(self, price: float) -> Plan:
        """The plan that spends a word where it takes away at least so much squared error."""
        return self.settled(np.full(len(self.whole.root), np.inf), price)

    def number(self, plan: Plan) -> np.ndarray:
        """(n,) int64 a number for each part with its orders and table, asked for when they are drawn."""
        digits = len(ORDER_NAMES) ** np.arange(plan.decision.orders.shape[1] + 1)
        return self._numbers.numbers(
            plan.surface.part, plan.decision.orders @ digits[:-1] + plan.table.number * digits[-1]
        )

    def draw(self, plans: Iterable[Plan]) -> None:
        """Draw plans of one table with the golden model, at once, and compare what was not drawn before."""
        known, new, roots = len(self._numbers), [], []
        for plan in plans:
            before = len(self._numbers)
            number = plan.number
            if len(self._numbers) > before:
                # In the order of the new numbers.
                some = np.flatnonzero(number >= before)
                rows = some[np.unique(number[some], return_index=True)[1]]
                new.append(plan.triangles.ordered(rows))
                roots.append(plan.surface.root[rows])
        if not new:
            return
        joined = new[0].followed_by(new[1:])
        errors = self.phong.errors(joined, np.concatenate(roots), self.shader.formats)
        if len(self._drawn) < len(self._numbers):
            self._drawn = np.concatenate([self._drawn, np.empty((2 * len(self._numbers), 4))])
        self._drawn[known : len(self._numbers)] = errors

    def drawn(self, plan: Plan) -> PartErrors:
        """What the golden model draws, and how far its pixels are off: each part once with each orders."""
        self.draw([plan])
        return PartErrors(*self._drawn[plan.number].T)


class Plan:
    """A surface with its decision, and the table that it is drawn with."""

    fit = "six-point"

    def __init__(self, planner: Planner, surface: Surface, decision: Decision, table: Table) -> None:
        self.planner, self.surface, self.decision, self.table = planner, surface, decision, table

    @cached_property
    def samples(self) -> np.ndarray:
        """(n, channels, 6) float64 what is drawn through."""
        given = self.decision.samples
        return chosen_samples(self.surface.assessed, self.decision.orders) if given is None else given

    @cached_property
    def triangles(self) -> ScreenTriangles:
        """What the set-up takes."""
        return self.planner.shader.screen_triangles(
            self.surface.projected, self.samples, self.decision.orders, self.table
        )

    @cached_property
    def number(self) -> np.ndarray:
        """See :meth:`Planner.number`."""
        return self.planner.number(self)

    @property
    def much_divided(self) -> bool:
        """Whether another way to divide may be worth its time."""
        return len(self.surface.root) > MUCH * len(self.planner.whole.root)

    def estimated(self) -> float:
        """The error by the plan's measure, the output's rounding included; from samples, so no bound."""
        if self.planner.measure == "max":
            return float(self.decision.largest.max(initial=0)) + OUTPUT_ROUNDING
        pixels = self.surface.assessed.pixels
        square = (self.decision.square * pixels).sum() / max(COLOURS * pixels.sum(), 1e-9)
        return float(np.sqrt(square + OUTPUT_ROUNDING**2 / 3))

    @cached_property
    def drawn(self) -> PartErrors:
        """How far the golden model's pixels are off."""
        return self.planner.drawn(self)

    def error(self, verify: bool) -> float:
        """The error by the plan's measure: drawn, or estimated."""
        return self.drawn.by(self.planner.measure) if verify else self.estimated()

    def cost(self, unit: str) -> int:
        """What it takes, in ``bytes``, ``clocks`` or bytes on the ``line``."""
        return int(getattr(self, unit))

    def least_cost(self, unit: str) -> int:
        """The same at least, of a plan that is not drawn for it."""
        return self.least_bytes if unit == "bytes" else self.cost(unit)

    @cached_property
    def first(self) -> int:
        """The first entry of power tables that it reads; it is drawn for that."""
        state = self.table.state
        if state is None or not state.tables.size:
            return 0
        highest = int(self.drawn.highest.max(initial=-1))
        return first_entry(highest, self.planner.shader.formats)

    @cached_property
    def least_bytes(self) -> int:
        """What it takes at least: power tables are counted without drawing."""
        return self.planner.bytes_of(self.surface, self.decision.orders, self.table) or 0

    @cached_property
    def bytes(self) -> int:
        """What the set-up stream and the shade unit's state take."""
        known = self.planner.bytes_of(self.surface, self.decision.orders, self.table, self.first)
        return stream_bytes(self.triangles, self.planner.shader.formats) if known is None else known

    @cached_property
    def line(self) -> int:
        """The most bytes that it takes on the serial line."""
        return self.planner.count_line(self.triangles, self.planner.shader.formats)

    @cached_property
    def clocks(self) -> int:
        """What the core takes."""
        return core_clocks(self.triangles, self.planner.shader.formats)

    def adapted(self, verify: bool) -> Adapted:
        """The same for those who draw it."""
        return Adapted(
            self.triangles,
            self.surface.projected,
            self.surface.root,
            len(self.planner.whole.root),
            self.planner.measure,
            self.error(verify),
            verify,
            self.planner.shader.shading,
            self.planner.shader.formats,
            fit=self.fit,
        )
