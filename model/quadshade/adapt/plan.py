# SPDX-License-Identifier: Apache-2.0
"""A mesh for an allowed error or a budget: per triangle the cheapest order of each channel, or division."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from quadshade.adapt.choose import OUTPUT_ROUNDING, Decision, Goal, divide, settle
from quadshade.adapt.cosine_shader import CosineShader, LightShader
from quadshade.adapt.costs import core_clocks, error_figures, pixel_errors, state_bytes, stream_bytes
from quadshade.adapt.shader import ColourShader, Shader, Surface
from quadshade.choices import MEASURES, UNITS
from quadshade.contract.formats import ORDER_NAMES, Formats
from quadshade.contract.triangles import Pixels, ScreenTriangles
from quadshade.engine import draw
from quadshade.errors import QuadshadeError
from quadshade.scene.project import Projected
from quadshade.shading.lights import Light
from quadshade.shading.material import Material
from quadshade.shading.specular import specular_formats

SHADERS = {kind.shading: kind for kind in (ColourShader, CosineShader, LightShader)}
SHADINGS = (*SHADERS, "auto")
COLOURS = 3
FITTED = ("num_channels", "with_shade", "num_specular")
"""Generics that are fitted to the lights where the core has no shade unit."""
BISECTIONS = 16
CLOSE = 0.985
"""A budget is used up where this share of it is."""
VERIFY_ROUNDS = 8
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
    shading : str
      ``quadratic`` (red, green, blue), ``quadratic-specular`` (diffuse and specular cosines) or
      ``quadratic-lights`` (diffuse and specular parts).
    formats : Formats
      Of the core that draws it.
    rival : dict or None
      Where others were tried, what is known of the next best: ``shading``, and ``bytes`` and
      ``estimated_error``, or the ``reason`` why it is none.
    """

    triangles: ScreenTriangles
    projected: Projected
    root: np.ndarray
    roots: int
    measure: str
    estimated: float
    shading: str
    formats: Formats
    rival: dict | None = None

    def mix(self) -> dict:
        """Counts for reports: shading, triangles sent, divided ones, and triangles and channels by order."""
        orders, names = self.triangles.orders, self.triangles.channels
        highest = np.bincount(orders.max(axis=1, initial=0), minlength=len(ORDER_NAMES))
        channels = np.bincount(orders.ravel(), minlength=len(ORDER_NAMES))
        specular = orders[:, [name.startswith("s") for name in names]]
        powers = np.bincount(specular.ravel(), minlength=len(ORDER_NAMES))
        return {
            "adaptive_shading": self.shading,
            "rival": self.rival,
            "state_bytes": state_bytes(self.triangles),
            "specular_by_order": dict(zip(ORDER_NAMES, map(int, powers), strict=True)),
            "triangles_of_mesh": self.roots,
            "divided": int((np.bincount(self.root, minlength=self.roots) > 1).sum()),
            "triangles": len(self.root),
            "triangles_by_order": dict(zip(ORDER_NAMES, map(int, highest), strict=True)),
            "channels_by_order": dict(zip(ORDER_NAMES, map(int, channels), strict=True)),
            "error_measure": self.measure,
            "estimated_error": self.estimated,
        }


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

    def verified(self, max_error: float) -> tuple[Plan, bool]:
        """
        The plan for a largest error: drawn, and stricter where a pixel is off by more, until none is.

        Returns
        -------
        plan : Plan
        kept : bool
          Whether no pixel is off by more.
        """
        allowed = self.everywhere(max_error - OUTPUT_ROUNDING)
        plan = self.settled(allowed, 0.0)
        for attempt in range(VERIFY_ROUNDS):
            pixels, errors = plan.drawn()
            over = np.unique(pixels.triangle[(errors > max_error).any(axis=1)])
            if not len(over):
                return plan, True
            allowed[np.unique(plan.surface.root[over])] *= TIGHTEN
            surface = plan.surface
            if attempt:
                # No sample saw it: what is halved is sampled anew, and by its pixels where it has few.
                wanting = np.zeros(len(surface.root), dtype=bool)
                wanting[over] = surface.found["pixels"][over] > 1
                surface = divide(surface, replace(plan.decision, wanting=wanting, forced=True), self.shader)
            plan = self.settled(allowed, 0.0, surface)
        return plan, not (plan.drawn()[1] > max_error).any()


class Plan:
    """A surface with its decision."""

    def __init__(self, planner: Planner, surface: Surface, decision: Decision) -> None:
        self.planner, self.surface, self.decision = planner, surface, decision
        self.triangles = planner.shader.screen_triangles(surface.projected, decision.samples, decision.orders)

    def estimated(self) -> float:
        """The error by the plan's measure, the output's rounding included."""
        if self.planner.measure == "max":
            return float(self.decision.largest.max(initial=0)) + OUTPUT_ROUNDING
        pixels = self.surface.found["pixels"]
        square = (self.decision.square * pixels).sum() / max(COLOURS * pixels.sum(), 1e-9)
        return float(np.sqrt(square + OUTPUT_ROUNDING**2 / 3))

    def drawn(self) -> tuple[Pixels, np.ndarray]:
        """What the golden model draws, and how far its pixels are off (m, 3)."""
        shader, whole = self.planner.shader, self.planner.whole.projected
        pixels = draw(self.triangles, shader.formats).pixels
        root = self.surface.root
        return pixels, pixel_errors(pixels, root, whole, shader.lights, shader.material, shader.formats)

    def adapted(self) -> Adapted:
        return Adapted(
            self.triangles,
            self.surface.projected,
            self.surface.root,
            len(self.planner.whole.root),
            self.planner.measure,
            self.estimated(),
            self.planner.shader.shading,
            self.planner.shader.formats,
        )


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
    shading: str = "quadratic",
    specular: Formats | None = None,
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
      triangles that exceed the limit. Without, the estimate from 28 points of each triangle decides. With
      a budget: which shading is better is measured, not estimated.
    shading : str
      ``quadratic``: red, green and blue. ``quadratic-specular``: diffuse and specular cosines, the power at
      every pixel. ``quadratic-lights``: each light's diffuse and specular part. ``auto``: all are tried, and
      the one is taken that keeps the error in fewest bytes, or whose error is least for the budget.
    specular : Formats, optional
      Of the core that draws cosines; by default ``formats``, fitted to the lights.

    Returns
    -------
    Adapted

    Raises
    ------
    QuadshadeError
      Neither or both of error and budget, an error that the output's rounding alone exceeds, a budget that
      the cheapest picture exceeds, an unknown unit, measure or shading, a core without three channels; with
      ``quadratic-specular`` :class:`quadshade.shading.specular.UnsuitedError` for a scene without cosines.
    """
    if (max_error is None) == (budget is None):
        raise QuadshadeError(
            "an adaptive picture needs a limit", "give a largest error or a budget, not both"
        )
    for name, value, known in (("error measure", measure, MEASURES), ("budget's unit", unit, UNITS)):
        if value not in known:
            raise QuadshadeError(f"the {name} is {value!r}", f"give {' or '.join(known)}")
    if shading not in SHADINGS:
        raise QuadshadeError(f"the shading is {shading!r}", f"give one of {', '.join(SHADINGS)}")
    least = OUTPUT_ROUNDING if measure == "max" else float(np.sqrt(OUTPUT_ROUNDING**2 / 3))
    if budget is None and not max_error > least:
        raise QuadshadeError(
            f"the allowed error is {max_error:g}", f"rounding the output costs {least:.3g} alone: give more"
        )
    if budget is None and max_error == math.inf:
        raise QuadshadeError("the allowed error is infinite", "give a number of grey levels")
    scene = projected, lights, material
    tried, reasons = [], {}
    for kind in SHADERS if shading == "auto" else (shading,):
        try:
            shader = _shader(kind, scene, formats, specular, measure)
            planner = Planner(projected, shader)
            if budget is None:
                tried.append(_for_error(planner, max_error, verify))
            else:
                tried.append(_for_budget(planner, budget, unit, verify))
        except QuadshadeError as reason:
            reasons[kind] = reason
    if not tried:
        raise next(iter(reasons.values()))
    tried.sort(key=lambda one: one[0])
    best = tried[0][1].adapted()
    if len(tried) > 1:
        other = tried[1][1]
        size = stream_bytes(other.triangles, other.planner.shader.formats)
        rival = {"shading": other.planner.shader.shading, "bytes": size, "estimated_error": other.estimated()}
        return replace(best, rival=rival)
    for kind, reason in reasons.items():
        return replace(best, rival={"shading": kind, "reason": str(reason)})
    return best


def _shader(
    kind: str, scene: tuple, formats: Formats | None, specular: Formats | None, measure: str
) -> Shader:
    """What shades for one choice of channels."""
    projected, lights, material = scene
    if kind == ColourShader.shading:
        return ColourShader(lights, material, formats, projected, measure)
    if specular is None:
        given = {} if formats is None else formats.generics()
        if not given.get("with_shade"):
            given = {name: value for name, value in given.items() if name not in FITTED}
        specular = specular_formats(given, projected, lights, material)
    return SHADERS[kind](lights, material, specular, projected, measure)


def _for_error(planner: Planner, max_error: float, verify: bool) -> tuple[tuple, Plan]:
    """The cheapest plan for an error, and what it is sorted by: whether the error is kept, then bytes."""
    shader = planner.shader
    if planner.measure == "rms":
        plan = _cheapest_below(planner, max_error)
        kept = plan.estimated() <= max_error
    else:
        plan, kept = planner.settled(planner.everywhere(max_error - OUTPUT_ROUNDING), 0.0), True
        if verify:
            plan, kept = planner.verified(max_error)
    return (not kept, stream_bytes(plan.triangles, shader.formats)), plan


def _for_budget(planner: Planner, budget: int, unit: str, verify: bool) -> tuple[tuple, Plan]:
    """The best plan for a budget, and what it is sorted by: its error."""
    shader = planner.shader
    count = stream_bytes if unit == "bytes" else core_clocks
    plan = _dearest_within(planner, lambda triangles: count(triangles, shader.formats), budget, unit)
    if not verify:
        return (plan.estimated(),), plan
    figures = error_figures(plan.drawn()[1])
    return (figures.largest if planner.measure == "max" else figures.rms,), plan
