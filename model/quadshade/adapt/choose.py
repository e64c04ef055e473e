# SPDX-License-Identifier: Apache-2.0
"""The order of every channel of every triangle, and which edges to split where no order is good enough."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from quadshade.adapt.fit import ORDERS, POINTS, fit, split_errors
from quadshade.adapt.subdivide import shared_edges, split_edges
from quadshade.errors import QuadshadeError
from quadshade.formats import LINEAR, PLANES_OF_ORDER, Formats
from quadshade.scene.project import Projected, doubled_area
from quadshade.setup.triangle_setup import setup_triangles
from quadshade.shading.lights import Light, default_lights
from quadshade.shading.material import Material
from quadshade.shading.sample import CHANNELS, CHUNK, full_scale, reflected
from quadshade.triangles import ScreenTriangles

MARGIN = 1.08
"""The largest difference anywhere on a triangle, over that at the grid's points: measured, not a bound."""
SMALLEST_AREA = 1.0
"""Pixels; smaller triangles are not divided."""
FUTILE_AREA = 64.0
"""Pixels; a smaller triangle whose halves would be as bad as the whole is not divided: it lies on a jump."""
FUTILE = 0.9
SHORT = 0.12
"""Of a triangle's longest edge; shorter ones are not split for its sake."""
MAX_PASSES = 24
OUTPUT_ROUNDING = 0.5
MEASURES = ("max", "rms")


@dataclass(frozen=True)
class Goal:
    """
    What is traded for what.

    Attributes
    ----------
    allowed : (roots,) float64
      For each triangle of the undivided mesh its largest error before the output is rounded (measure
      ``max``).
    price : float
      Squared output units, summed over pixels and channels, that one word is worth (measure ``rms``).
    """

    allowed: np.ndarray
    price: float = 0.0


@dataclass(frozen=True)
class Surface:
    """
    A mesh, divided or not, and how well each order would do on every triangle.

    Attributes
    ----------
    projected : Projected
    root : (n,) int64
      Triangle of the undivided mesh.
    samples : (n, 3, orders, 6) float64
      The best polynomial of each channel and order.
    largest : (n, 3, orders) float64
      Its largest difference from the true shading, estimated from 28 points.
    square : (n, 3, orders) float64
      Its mean square.
    halves : (n, 3, 2, 3, orders) float64
      The same, by the measure in use, for the halves if edge 0-1, 1-2 or 2-0 is split.
    bound : (n,) float64
      What rounding the words of the highest order costs at most, from the set-up.
    """

    projected: Projected
    root: np.ndarray
    samples: np.ndarray
    largest: np.ndarray
    square: np.ndarray
    halves: np.ndarray
    bound: np.ndarray

    def pixels(self, formats: Formats) -> np.ndarray:
        """(n,) float64 areas in pixels."""
        return abs(doubled_area(self.projected.vertices)) / 2 / 4.0**formats.subpixel_bits


ASSESSED = ("samples", "largest", "square", "halves", "bound")
"""What is found out for each triangle by itself, once."""


class Shader:
    """Scene, light, core and error measure: shades surfaces, and knows what words cost."""

    def __init__(
        self,
        lights: Sequence[Light] | None,
        material: Material | None,
        formats: Formats | None,
        projected: Projected,
        measure: str = "max",
    ) -> None:
        self.measure = measure
        self.formats = Formats() if formats is None else formats
        self.material = Material() if material is None else material
        self.lights = default_lights(projected.axes) if lights is None else lights
        if self.formats.num_channels != len(CHANNELS):
            raise QuadshadeError(
                f"generic num_channels is {self.formats.num_channels}", f"a picture needs {len(CHANNELS)}"
            )
        self.full = 2.0**self.formats.value_bits - 1
        self.orders = ORDERS[: self.formats.max_order + 1]
        lanes = self.formats.plane_beats * self.formats.stream_lanes
        share = [lanes / len(group) for group in self.formats.channel_groups for _ in group]
        self.plane_words = np.array(share[: len(CHANNELS)])
        beats = self.formats.section_beats("edge") + self.formats.section_beats("second")
        self.packet_words = beats * self.formats.stream_lanes
        if self.formats.with_depth:
            self.packet_words += PLANES_OF_ORDER[LINEAR] * share[-1]

    def shade(self, projected: Projected) -> np.ndarray:
        """(n, 3, 28) float64 true shading at the grid's points."""
        values = np.empty((len(projected), len(CHANNELS), len(POINTS)))
        for start in range(0, len(projected), CHUNK):
            rows = np.arange(start, min(start + CHUNK, len(projected)))
            light = reflected(projected, rows, POINTS, self.lights, self.material)
            values[rows] = full_scale(light, self.formats).transpose(0, 2, 1)
        return values

    def surface(self, projected: Projected, root: np.ndarray | None = None) -> Surface:
        """A mesh, shaded and fitted; ``root`` is each triangle's own index where it is not given."""
        values = self.shade(projected)
        fits = [fit(values, order, self.full, self.measure) for order in self.orders]
        halves = [split_errors(values, order, self.measure) for order in self.orders]
        scale = MARGIN if self.measure == "max" else 1.0
        return Surface(
            projected,
            np.arange(len(projected)) if root is None else root,
            np.stack([one.samples for one in fits], axis=2),
            np.stack([one.largest for one in fits], axis=2) * MARGIN,
            np.stack([one.square for one in fits], axis=2),
            np.stack(halves, axis=-1) * scale,
            self.rounding_bound(projected, fits[-1].samples),
        )

    def screen_triangles(
        self, projected: Projected, samples: np.ndarray, orders: np.ndarray
    ) -> ScreenTriangles:
        """What the set-up takes."""
        depth = projected.depth if self.formats.with_depth else None
        return ScreenTriangles(
            projected.width, projected.height, projected.vertices, samples, orders, depth, CHANNELS
        )

    def free_orders(self, orders: np.ndarray) -> np.ndarray:
        """(n, 3) orders raised to what the channel's group sends anyway (streams of 64 and 128 bits)."""
        depth = np.full((len(orders), self.formats.with_depth), LINEAR)
        carried = np.concatenate([orders, depth], axis=1)
        for group in self.formats.channel_groups:
            carried[:, list(group)] = carried[:, list(group)].max(axis=1, keepdims=True)
        return np.minimum(carried[:, : orders.shape[1]], self.formats.max_order)

    def words(self, orders: np.ndarray) -> np.ndarray:
        """(n,) float64 words of packets with a middle vertex, for (n, 3) orders."""
        return self.packet_words + np.array(PLANES_OF_ORDER)[orders] @ self.plane_words

    def rounding_bound(self, projected: Projected, samples: np.ndarray) -> np.ndarray:
        """(n,) float64 the set-up's own bound of what rounding the words of the highest order costs."""
        top = np.full((len(projected), len(CHANNELS)), self.orders[-1])
        primitives = setup_triangles(self.screen_triangles(projected, samples, top), self.formats)
        bound = np.zeros(len(top))
        np.maximum.at(bound, primitives.triangle, primitives.bound[:, : len(CHANNELS)].max(axis=1, initial=0))
        return bound


@dataclass(frozen=True)
class Decision:
    """
    The choice for a surface as it is.

    Attributes
    ----------
    orders : (n, 3) int64
    samples : (n, 3, 6) float64
    largest : (n,) float64
      Estimated largest difference before the output is rounded, set-up's rounding bound included.
    square : (n,) float64
      Estimated mean square of the differences, summed over the channels.
    gain : (n, 3) float64
      Words (or their price) saved if edge 0-1, 1-2 or 2-0 is split.
    wanting : (n,) bool
      Triangles that may be divided.
    forced : bool
      They have to be, whatever it costs.
    """

    orders: np.ndarray
    samples: np.ndarray
    largest: np.ndarray
    square: np.ndarray
    gain: np.ndarray
    wanting: np.ndarray
    forced: bool


def choose_orders(surface: Surface, shader: Shader, goal: Goal) -> Decision:
    """
    Pick the cheapest order of every channel, and say where dividing is cheaper still.

    A packet's edges and depth cost more than the difference between a constant and a quadratic, so for the
    largest error a triangle is divided only where no order is good enough.

    Parameters
    ----------
    surface : Surface
    shader : Shader
    goal : Goal

    Returns
    -------
    Decision
    """
    largest, square, bound = surface.largest, surface.square, surface.bound
    pixels = surface.pixels(shader.formats)
    allowed = goal.allowed[surface.root] - bound
    if shader.measure == "max":
        good = largest <= allowed[:, None, None]
        good[..., -1] = True
        orders = good.argmax(axis=2)
    else:
        orders = _cheapest(square, pixels[:, None, None], shader, goal.price)[1]
    orders = shader.free_orders(orders)
    pick = orders[..., None]
    samples = np.take_along_axis(surface.samples, pick[..., None], axis=2)[:, :, 0]
    chosen = np.take_along_axis(largest, pick, axis=2)[..., 0].max(axis=1)
    mean = np.take_along_axis(square, pick, axis=2)[..., 0].sum(axis=1)
    large = pixels >= SMALLEST_AREA
    if shader.measure == "max":
        gain, left = _gain_max(surface, shader, chosen, allowed, orders)
        wanting = (chosen > allowed) & large & ((left < FUTILE * chosen) | (pixels >= FUTILE_AREA))
    else:
        gain = _gain_rms(surface, shader, pixels, mean, orders, goal.price)
        wanting = large
    return Decision(orders, samples, chosen + bound, mean, gain, wanting, shader.measure == "max")


def _cheapest(
    square: np.ndarray, pixels: np.ndarray, shader: Shader, price: float
) -> tuple[np.ndarray, np.ndarray]:
    """Least cost (...) and its order (...) of squares (..., channels, orders)."""
    planes = np.array(PLANES_OF_ORDER)[list(shader.orders)]
    cost = square * pixels + price * planes * shader.plane_words[:, None]
    order = cost.argmin(axis=-1)
    return np.take_along_axis(cost, order[..., None], axis=-1)[..., 0], order


def _foreseen(largest: np.ndarray, allowed: np.ndarray, words: np.ndarray, order: int) -> np.ndarray:
    """
    Words for a triangle that will have to be divided until the highest order is good enough.

    A quadratic's error falls with the third power of a triangle's size, a plane's with the second; the number
    of triangles grows with the second.
    """
    return words * np.maximum(largest / np.maximum(allowed, 1e-3), 1) ** (2 / (order + 1))


def _gain_max(
    surface: Surface, shader: Shader, chosen: np.ndarray, allowed: np.ndarray, orders: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """
    (n, 3) words saved by halving, with what is foreseen for halves that are not good enough, and (n,) the
    largest difference left by the best halving.
    """
    now = _foreseen(chosen, allowed, shader.words(orders), shader.orders[-1])
    limit = allowed[:, None, None]
    errors = surface.halves
    good = errors <= limit[..., None, None]
    good[..., -1] = True
    order = good.argmax(axis=-1)
    left = np.take_along_axis(errors, order[..., None], axis=-1)[..., 0].max(axis=-1)
    halves = _foreseen(left, limit, shader.words(order), shader.orders[-1]).sum(axis=2)
    return now[:, None] - halves, left.max(axis=2).min(axis=1)


def _gain_rms(
    surface: Surface, shader: Shader, pixels: np.ndarray, mean: np.ndarray, orders: np.ndarray, price: float
) -> np.ndarray:
    """(n, 3) price saved by halving: squares of the differences and words, together."""
    now = mean * pixels + price * shader.words(orders)
    errors = surface.halves
    area = (pixels / 2)[:, None, None, None, None]
    cost = _cheapest(errors, area, shader, price)[0].sum(axis=3) + price * shader.packet_words
    return now[:, None] - cost.sum(axis=2)


def _marks(surface: Surface, decision: Decision) -> tuple:
    """Edges of the surface, and which of them to split: for each triangle the one that saves most."""
    edges = shared_edges(surface.projected.vertices)
    total = np.bincount(edges.index.ravel(), decision.gain.ravel(), minlength=len(edges))
    # What the neighbour loses counts; what it wins is its own reason to ask for the edge.
    value = decision.gain + np.minimum(total[edges.index] - decision.gain, 0)
    # Short edges stay, so that parts do not become slivers.
    length = np.linalg.norm(edges.ends[:, 1] - edges.ends[:, 0], axis=1)[edges.index]
    value[length < SHORT * length.max(axis=1, keepdims=True)] = -np.inf
    best = value.argmax(axis=1)
    rows = np.arange(len(best))
    marks = np.zeros(len(edges), dtype=bool)
    marks[edges.index[rows, best][decision.wanting & (decision.forced | (value[rows, best] > 0))]] = True
    return edges, marks


def divide(surface: Surface, decision: Decision, shader: Shader) -> Surface:
    """
    Split the edges that a decision asks for, and shade what is new.

    Parameters
    ----------
    surface : Surface
    decision : Decision
    shader : Shader

    Returns
    -------
    Surface
      The same object where nothing was divided.
    """
    edges, marks = _marks(surface, decision)
    projected, parent = split_edges(surface.projected, edges, marks)
    if len(projected) == len(surface.root):
        return surface
    fresh = np.flatnonzero((np.bincount(parent) > 1)[parent])
    root = surface.root[parent]
    new = shader.surface(projected.ordered(fresh), root[fresh])
    assessed = {}
    for name in ASSESSED:
        assessed[name] = getattr(surface, name)[parent]
        assessed[name][fresh] = getattr(new, name)
    return Surface(projected, root, **assessed)


def settle(surface: Surface, shader: Shader, goal: Goal) -> tuple[Surface, Decision]:
    """
    Choose orders and divide until nothing more is to be divided.

    Parameters
    ----------
    surface : Surface
    shader : Shader
    goal : Goal

    Returns
    -------
    surface : Surface
    decision : Decision
    """
    for _ in range(MAX_PASSES):
        decision = choose_orders(surface, shader, goal)
        divided = divide(surface, decision, shader)
        if divided is surface:
            return surface, decision
        surface = divided
    return surface, choose_orders(surface, shader, goal)
