# SPDX-License-Identifier: Apache-2.0
"""The order of every channel of every triangle, and which edges to split where no order is good enough."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numba import njit

from quadshade.adapt.shader import Choice, Shader, Surface
from quadshade.contract.arrays import Bools, Floats, Int, Ints
from quadshade.scene.subdivide import CHILDREN, Edges, children, possible_splits, split_edges

SHORT = 0.12
"""Of a triangle's longest edge; shorter ones are not split for its sake."""
LEFT = 0.7
"""Of the mean square of a whole: what halves have left of it at most."""
MAX_PASSES = 24


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
    samples : (n, channels, 6) float64 or None
      None: those that were assessed for the orders.
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
    samples: np.ndarray | None
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
    forced = shader.measure == "max"
    return Decision(chosen.orders, None, largest, square, gain, wanting, forced, goal.agree)


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


@njit(cache=True)
def _near(index: Ints, wanting: Bools, edges: int) -> Ints:
    """Rows of triangles that may be divided, and of their neighbours, from (n, 3) edges of triangles."""
    asked, near = np.zeros(edges, np.bool_), np.zeros(len(index), np.bool_)
    for row in range(len(index)):
        for side in range(3):
            if wanting[row]:
                asked[index[row, side]] = True
    for row in range(len(index)):
        near[row] = asked[index[row, 0]] or asked[index[row, 1]] or asked[index[row, 2]]
    return np.flatnonzero(near)


@njit(cache=True, error_model="numpy")
def _best_edges(
    index: Ints, ends: Ints, rows: Ints, gain: Floats, wanting: Bools, forced: bool, agree: float
) -> Bools:
    """Which edges to split: of each triangle that may be divided the one that saves most, if it saves."""
    total, asked, marks = np.zeros(len(ends)), np.zeros(len(ends)), np.zeros(len(ends), np.bool_)
    longest = 0.0
    for number in range(len(rows)):
        for side in range(3):
            edge = index[rows[number], side]
            total[edge] += gain[number, side]
            asked[edge] += wanting[rows[number]]
    if agree:
        for edge in range(len(ends)):
            longest = max(longest, _length(ends, edge))
    length, value = np.empty(3), np.empty(3)
    for number in range(len(rows)):
        mine = index[rows[number]]
        if not wanting[rows[number]]:
            continue
        for side in range(3):
            length[side] = _length(ends, mine[side])
            # What the neighbour loses counts; what it wins is its own reason to ask for the edge.
            value[side] = gain[number, side] + min(total[mine[side]] - gain[number, side], 0.0)
        # Short edges stay, so that parts do not become slivers.
        value[length < SHORT * length.max()] = -np.inf
        best, most = int(value.argmax()), value.max()
        if agree:
            liked = -np.inf
            for side in range(3):
                as_good = value[side] >= most - agree * max(abs(most), 1.0)
                like = asked[mine[side]] * 4 * longest + length[side] if as_good else -1.0
                if like > liked:
                    best, liked = side, like
        if forced or value[best] > 0:
            marks[mine[best]] = True
    return marks


@njit(cache=True, error_model="numpy", forceinline=True)
def _length(ends: Ints, edge: Int) -> float:
    """Length of an edge in sub-pixels."""
    x, y = float(ends[edge, 1, 0] - ends[edge, 0, 0]), float(ends[edge, 1, 1] - ends[edge, 0, 1])
    return np.sqrt(x * x + y * y)


def _marks(surface: Surface, decision: Decision) -> tuple[Edges, np.ndarray]:
    """Edges of the surface, and which of them to split: for each triangle the one that saves most."""
    edges = surface.edges
    # Asked are those that may be divided, and their neighbours.
    rows = _near(edges.index, decision.wanting, len(edges))
    gain = decision.gain(rows)
    return edges, _best_edges(
        edges.index, edges.ends, rows, gain, decision.wanting, decision.forced, decision.agree
    )


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
    if surface.last is None or not np.array_equal(surface.last[0], wanted):
        surface.last = wanted, _parts(surface, edges, wanted, shader)
    return surface.last[1]


def _parts(surface: Surface, edges: Edges, wanted: np.ndarray, shader: Shader) -> Surface:
    """Split those of (edges,) bool wanted edges that can be, and shade what is new."""
    marks = possible_splits(surface.projected, edges, wanted)
    if not marks.any():
        return surface
    projected, parent = split_edges(surface.projected, edges, marks)
    fresh = np.flatnonzero((np.bincount(parent) > 1)[parent])
    root = surface.root[parent]
    number, splits = children(parent), edges.splits(marks)[parent]
    mine = surface.part[parent[fresh]], len(CHILDREN) * number[fresh] + splits[fresh]
    new = shader.parts(projected.ordered(fresh), root[fresh], *mine)
    assessed, part = surface.assessed.take(parent), surface.part[parent]
    assessed.put(fresh, new.assessed)
    part[fresh] = new.part
    return Surface(projected, root, assessed, part)


def settle(
    surface: Surface, shader: Shader, goal: Goal, decision: Decision | None = None
) -> tuple[Surface, Decision]:
    """
    Choose orders and divide until nothing more is to be divided.

    Parameters
    ----------
    surface : Surface
    shader : Shader
    goal : Goal
    decision : Decision, optional
      What :func:`choose_orders` says of the surface, where it is known.

    Returns
    -------
    surface : Surface
    decision : Decision
    """
    decision = choose_orders(surface, shader, goal) if decision is None else decision
    for _ in range(MAX_PASSES):
        divided = divide(surface, decision, shader)
        if divided is surface:
            break
        surface = divided
        decision = choose_orders(surface, shader, goal)
    return surface, decision
