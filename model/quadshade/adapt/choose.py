# SPDX-License-Identifier: Apache-2.0
"""The order of every channel of every triangle, and which edges to split where no order is good enough."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from quadshade.adapt.shader import Choice, Shader, Surface, chosen_samples
from quadshade.scene.subdivide import CHILDREN, Edges, children, possible_splits, shared_edges, split_edges

SHORT = 0.12
"""Of a triangle's longest edge; shorter ones are not split for its sake."""
LEFT = 0.7
"""Of the mean square of a whole: what halves have left of it at most."""
MAX_PASSES = 24
OUTPUT_ROUNDING = 0.5


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
    agree : float
      An edge that saves less than another by no more than this share is split instead where more of its
      triangles have to be divided. 0: always the edge that saves most.
    """

    allowed: np.ndarray
    price: float = 0.0
    agree: float = 0.0


@dataclass(frozen=True)
class Decision:
    """
    The choice for a surface as it is.

    Attributes
    ----------
    orders : (n, channels) int64
    samples : (n, channels, 6) float64
    largest : (n,) float64
      Estimated largest difference before the output is rounded, set-up's rounding bound included (``max``).
    square : (n,) float64
      Estimated mean square of the differences, summed over the colours (``rms``).
    gain : function
      Asked for only where something is divided: of (m,) int rows (m, 3) float64, words (or their price) saved
      if edge 0-1, 1-2 or 2-0 is split.
    wanting : (n,) bool
      Triangles that may be divided.
    forced : bool
      They have to be, whatever it costs.
    agree : float
      See :class:`Goal`.
    """

    orders: np.ndarray
    samples: np.ndarray
    largest: np.ndarray
    square: np.ndarray
    gain: Callable[[np.ndarray], np.ndarray]
    wanting: np.ndarray
    forced: bool
    agree: float = 0.0


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
    assessed = surface.assessed
    pixels, bound, nothing = assessed.pixels, assessed.bound, np.zeros(len(surface.root))
    # What covers one pixel at most is as good as it can be: no order of a part would be better.
    several = pixels > 1
    if shader.measure == "max":
        allowed = goal.allowed[surface.root] - bound
        chosen = shader.choose(assessed, allowed)
        wanting, largest, square = (chosen.error > allowed) & several, chosen.error + bound, nothing

        def gain(rows: np.ndarray) -> np.ndarray:
            halves = shader.choose_halves(surface, allowed[rows], rows)
            return _gain_max(chosen.take(rows), halves, allowed[rows], shader.orders[-1])

    else:
        price = goal.price / np.maximum(pixels, 1e-9)
        chosen = shader.choose(assessed, price)

        def gain(rows: np.ndarray) -> np.ndarray:
            halves = shader.choose_halves(surface, 2 * price[rows], rows)
            return _gain_rms(chosen.take(rows), halves, pixels[rows], goal.price)

        wanting, largest, square = several, nothing, chosen.error
    samples = chosen_samples(assessed, chosen.orders)
    forced = shader.measure == "max"
    return Decision(chosen.orders, samples, largest, square, gain, wanting, forced, goal.agree)


def _foreseen(choice: Choice, allowed: np.ndarray, order: int) -> np.ndarray:
    """
    Words for a triangle that will have to be divided until the highest order is good enough.

    A quadratic's error falls with the third power of a triangle's size, a plane's with the second; the number
    of triangles grows with the second.
    """
    return choice.words * np.maximum(choice.error / np.maximum(allowed, 1e-3), 1) ** (2 / (order + 1))


def _gain_max(chosen: Choice, halves: Choice, allowed: np.ndarray, order: int) -> np.ndarray:
    """(n, 3) words saved by halving, with what is foreseen for halves that are not good enough."""
    now = _foreseen(chosen, allowed, order)
    return now[:, None] - _foreseen(halves, allowed[:, None, None], order).sum(axis=2)


def _gain_rms(chosen: Choice, halves: Choice, pixels: np.ndarray, price: float) -> np.ndarray:
    """(n, 3) price saved by halving: squares of the differences and words, together."""
    now = chosen.error * pixels + price * chosen.words
    # What the grid foresees for halves on a jump is too much: the jump will be in fewer pixels of each.
    left = np.minimum(halves.error, LEFT * chosen.error[:, None, None])
    return now[:, None] - (left * (pixels / 2)[:, None, None] + price * halves.words).sum(axis=2)


def _marks(surface: Surface, decision: Decision) -> tuple[Edges, np.ndarray]:
    """Edges of the surface, and which of them to split: for each triangle the one that saves most."""
    edges = shared_edges(surface.projected.vertices)
    # Asked are those that may be divided, and their neighbours.
    near = edges.marked(np.repeat(decision.wanting[:, None], 3, axis=1))[edges.index].any(axis=1)
    rows, gain = np.flatnonzero(near), np.zeros(edges.index.shape)
    gain[rows] = decision.gain(rows)
    total = np.bincount(edges.index.ravel(), gain.ravel(), minlength=len(edges))
    # What the neighbour loses counts; what it wins is its own reason to ask for the edge.
    value = gain + np.minimum(total[edges.index] - gain, 0)
    # Short edges stay, so that parts do not become slivers.
    length = np.linalg.norm(edges.ends[:, 1] - edges.ends[:, 0], axis=1)[edges.index]
    value[length < SHORT * length.max(axis=1, keepdims=True)] = -np.inf
    best = value.argmax(axis=1)
    if decision.agree:
        most = value.max(axis=1, keepdims=True)
        asked = np.bincount(edges.index[decision.wanting].ravel(), minlength=len(edges))[edges.index]
        as_good = value >= most - decision.agree * np.maximum(abs(most), 1)
        best = np.where(as_good, asked * 4 * length.max(initial=0) + length, -1).argmax(axis=1)
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
    if not decision.wanting.any():
        return surface
    edges, wanted = _marks(surface, decision)
    marks = possible_splits(surface.projected, edges, wanted)
    projected, parent = split_edges(surface.projected, edges, marks)
    if len(projected) == len(surface.root):
        return surface
    fresh = np.flatnonzero((np.bincount(parent) > 1)[parent])
    root = surface.root[parent]
    number, splits = children(parent), edges.splits(marks)[parent]
    mine = surface.part[parent[fresh]], len(CHILDREN) * number[fresh] + splits[fresh]
    new = shader.parts(projected.ordered(fresh), root[fresh], *mine)
    assessed, part = surface.assessed.take(parent), surface.part[parent]
    assessed.put(fresh, new.assessed)
    part[fresh] = new.part
    return Surface(projected, root, assessed, part)


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
