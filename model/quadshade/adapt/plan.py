# SPDX-License-Identifier: Apache-2.0
"""A mesh for an allowed error or a budget: per triangle the cheapest order of each channel, or division."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from quadshade.adapt.choose import MEASURES, OUTPUT_ROUNDING, Decision, Goal, Shader, Surface, settle
from quadshade.engine import draw
from quadshade.errors import QuadshadeError
from quadshade.formats import ORDER_NAMES, Formats
from quadshade.scene.project import Projected
from quadshade.setup.packet import packet_lanes
from quadshade.setup.triangle_setup import MAX_ERROR, setup_triangles
from quadshade.shading.lights import Light
from quadshade.shading.material import Material
from quadshade.shading.reference import phong
from quadshade.triangles import Pixels, ScreenTriangles

UNITS = ("bytes", "clocks")
BISECTIONS = 16
CLOSE = 0.985
"""A budget is used up where this share of it is."""
VERIFY_ROUNDS = 5
TIGHTEN = 0.75
HIGHEST_PRICE, LOWEST_PRICE = 1e8, 1e-6
NOTHING_LEFT = 0.03
"""Output units; where less is left before the output's rounding, no budget buys anything visible."""


@dataclass(frozen=True)
class Adapted:
    """
    What is to be drawn, and what it is made of.

    Attributes
    ----------
    triangles : ScreenTriangles
    projected : Projected
      The same triangles in the scene.
    root : (n,) int64
      Triangle of the undivided mesh that each is a part of.
    roots : int
    measure : str
      ``max`` or ``rms``.
    estimated : float
      Error in output units against Phong shading, by that measure, the output's rounding included.
    """

    triangles: ScreenTriangles
    projected: Projected
    root: np.ndarray
    roots: int
    measure: str
    estimated: float

    def mix(self) -> dict:
        """Counts for reports: triangles sent, undivided ones, and triangles and channels by order."""
        orders = self.triangles.orders
        highest = np.bincount(orders.max(axis=1, initial=0), minlength=len(ORDER_NAMES))
        channels = np.bincount(orders.ravel(), minlength=len(ORDER_NAMES))
        return {
            "triangles_of_mesh": self.roots,
            "divided": int((np.bincount(self.root, minlength=self.roots) > 1).sum()),
            "triangles": len(self.root),
            "triangles_by_order": dict(zip(ORDER_NAMES, map(int, highest), strict=True)),
            "channels_by_order": dict(zip(ORDER_NAMES, map(int, channels), strict=True)),
            "error_measure": self.measure,
            "estimated_error": self.estimated,
        }


@dataclass(frozen=True)
class ErrorFigures:
    """
    Drawn pixels against Phong shading of the undivided mesh, over every pixel drawn and all channels.

    Attributes
    ----------
    largest, rms : float
      Output units.
    exceeding : float
      Share of the pixels in which any channel is off by more than was allowed.
    """

    largest: float
    rms: float
    exceeding: float


def pixel_errors(
    pixels: Pixels,
    root: np.ndarray,
    projected: Projected,
    lights: Sequence[Light] | None = None,
    material: Material | None = None,
    formats: Formats | None = None,
) -> np.ndarray:
    """
    How far drawn pixels are from Phong shading.

    Parameters
    ----------
    pixels : Pixels
    root : (n,) int
      For each drawn triangle, the one of ``projected`` that it is a part of.
    projected : Projected
      The undivided mesh.
    lights, material, formats
      As for :func:`adapt`.

    Returns
    -------
    (m, 3) float64
      Differences without sign, in output units; the reference is not rounded.
    """
    true = phong(projected, root[pixels.triangle], pixels.x, pixels.y, lights, material, formats)
    return abs(pixels.value - true)


def error_figures(errors: np.ndarray, allowed: float = np.inf) -> ErrorFigures:
    """Figures of (m, 3) errors from :func:`pixel_errors`."""
    if not errors.size:
        return ErrorFigures(0.0, 0.0, 0.0)
    over = (errors > allowed).any(axis=1).mean()
    return ErrorFigures(float(errors.max()), float(np.sqrt((errors**2).mean())), float(over))


def stream_bytes(triangles: ScreenTriangles, formats: Formats) -> int:
    """Bytes of the set-up stream."""
    primitives = setup_triangles(triangles, formats, limit=MAX_ERROR)
    return 4 * int(packet_lanes(primitives.orders, primitives.header["has_second"], formats).sum())


def core_clocks(triangles: ScreenTriangles, formats: Formats) -> int:
    """Clocks that the core takes, from the golden model."""
    return draw(triangles, formats).stats["clocks"]


class Planner:
    """One mesh, settled for one goal after another; the undivided mesh is shaded once."""

    def __init__(self, projected: Projected, shader: Shader) -> None:
        self.shader, self.measure = shader, shader.measure
        self.whole = shader.surface(projected)

    def settled(self, allowed: np.ndarray, price: float, surface: Surface | None = None) -> Plan:
        surface = self.whole if surface is None else surface
        return Plan(self, *settle(surface, self.shader, Goal(allowed, price)))

    def everywhere(self, value: float) -> np.ndarray:
        return np.full(len(self.whole.root), value)

    def at(self, strictness: float) -> Plan:
        """A plan from the cheapest (0) to the best (1) that there is."""
        if self.measure == "max":
            return self.settled(self.everywhere(self.shader.full * 1e-4**strictness), 0.0)
        price = HIGHEST_PRICE * (LOWEST_PRICE / HIGHEST_PRICE) ** strictness
        return self.settled(self.everywhere(np.inf), price)


class Plan:
    """A surface with its decision."""

    def __init__(self, planner: Planner, surface: Surface, decision: Decision) -> None:
        self.planner, self.surface, self.decision = planner, surface, decision
        self.triangles = planner.shader.screen_triangles(surface.projected, decision.samples, decision.orders)

    def estimated(self) -> float:
        """The error by the plan's measure, the output's rounding included."""
        if self.planner.measure == "max":
            return float(self.decision.largest.max(initial=0)) + OUTPUT_ROUNDING
        pixels = self.surface.pixels(self.planner.shader.formats)
        channels = self.decision.orders.shape[1]
        square = (self.decision.square * pixels).sum() / max(channels * pixels.sum(), 1e-9)
        return float(np.sqrt(square + OUTPUT_ROUNDING**2 / 3))

    def adapted(self) -> Adapted:
        return Adapted(
            self.triangles,
            self.surface.projected,
            self.surface.root,
            len(self.planner.whole.root),
            self.planner.measure,
            self.estimated(),
        )


def _verified(planner: Planner, plan: Plan, max_error: float) -> Plan:
    """Draw, and be stricter with triangles in which a pixel is off by more, until none is."""
    shader = planner.shader
    allowed = planner.everywhere(max_error - OUTPUT_ROUNDING)
    for _ in range(VERIFY_ROUNDS):
        pixels = draw(plan.triangles, shader.formats).pixels
        root = plan.surface.root
        errors = pixel_errors(
            pixels, root, planner.whole.projected, shader.lights, shader.material, shader.formats
        )
        over = (errors > max_error).any(axis=1)
        if not over.any():
            break
        allowed[np.unique(root[pixels.triangle[over]])] *= TIGHTEN
        plan = planner.settled(allowed, 0.0, plan.surface)
    return plan


def _dearest_within(planner: Planner, cost: Callable[[ScreenTriangles], int], budget: int, unit: str) -> Plan:
    """The strictest plan that the budget pays for."""
    best = planner.at(0.0)
    least = cost(best.triangles)
    if least > budget:
        raise QuadshadeError(
            f"the budget is {budget} {unit}", f"the cheapest picture takes {least}: give more"
        )
    low, high = 0.0, 1.0
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        plan = planner.at(middle)
        spent = cost(plan.triangles)
        if spent > budget:
            high = middle
            continue
        low, best = middle, plan
        if spent >= CLOSE * budget or plan.estimated() < _floor(planner.measure):
            break
    return best


def _floor(measure: str) -> float:
    """The error below which nothing more can be seen."""
    if measure == "max":
        return OUTPUT_ROUNDING + NOTHING_LEFT
    return float(np.sqrt(OUTPUT_ROUNDING**2 / 3 + NOTHING_LEFT**2))


def _cheapest_below(planner: Planner, max_rms: float) -> Plan:
    """The least strict plan whose estimated root mean square is within the limit."""
    best = planner.at(0.0)
    low, high = 0.0, 1.0
    if best.estimated() <= max_rms:
        return best
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        plan = planner.at(middle)
        if plan.estimated() > max_rms:
            low = middle
            # Where no price is low enough, the last plan is the nearest to the limit.
            best = best if high < 1 else plan
            continue
        high, best = middle, plan
        if plan.estimated() > CLOSE * max_rms:
            break
    return best


def adapt(
    projected: Projected,
    lights: Sequence[Light] | None = None,
    material: Material | None = None,
    formats: Formats | None = None,
    *,
    max_error: float | None = None,
    budget: int | None = None,
    unit: str = "bytes",
    measure: str = "max",
    verify: bool = True,
) -> Adapted:
    """
    Pick for each triangle the cheapest orders, or divide it, for an allowed error or a budget.

    Errors are differences from Phong shading of the undivided mesh, in output units, the rounding of the
    output included, over every pixel drawn.

    Parameters
    ----------
    projected : Projected
    lights : sequence of lights, optional
      By default those that go with the viewer.
    material : Material, optional
    formats : Formats, optional
    max_error : float, optional
      The largest error of any pixel and channel (``max``) or the root mean square (``rms``). This or a
      budget.
    budget : int, optional
      What a picture may take, in ``unit``; the error is made as small as that allows.
    unit : str
      ``bytes`` of the set-up stream or ``clocks`` of the core.
    measure : str
      ``max`` or ``rms``.
    verify : bool
      With ``max_error`` and ``max``: draw with the golden model, compare every pixel, and be stricter with
      triangles that exceed the limit. Without, the estimate from 28 points of each triangle decides.

    Returns
    -------
    Adapted

    Raises
    ------
    QuadshadeError
      Neither or both of error and budget, an error that the output's rounding alone exceeds, a budget that
      the cheapest picture exceeds, an unknown unit or measure, a core without three channels.
    """
    if (max_error is None) == (budget is None):
        raise QuadshadeError(
            "an adaptive picture needs a limit", "give a largest error or a budget, not both"
        )
    if measure not in MEASURES:
        raise QuadshadeError(f"the error measure is {measure!r}", f"give {' or '.join(MEASURES)}")
    if unit not in UNITS:
        raise QuadshadeError(f"the budget's unit is {unit!r}", f"give {' or '.join(UNITS)}")
    shader = Shader(lights, material, formats, projected, measure)
    planner = Planner(projected, shader)
    if budget is not None:
        count = stream_bytes if unit == "bytes" else core_clocks
        return _dearest_within(planner, lambda t: count(t, shader.formats), budget, unit).adapted()
    least = OUTPUT_ROUNDING if measure == "max" else float(np.sqrt(OUTPUT_ROUNDING**2 / 3))
    if not max_error > least:
        raise QuadshadeError(
            f"the allowed error is {max_error:g}", f"rounding the output costs {least:.3g} alone: give more"
        )
    if measure == "rms":
        return _cheapest_below(planner, max_error).adapted()
    plan = planner.settled(planner.everywhere(max_error - OUTPUT_ROUNDING), 0.0)
    return (_verified(planner, plan, max_error) if verify else plan).adapted()
