# SPDX-License-Identifier: Apache-2.0
"""What a mesh is shaded with while orders are chosen: colours as polynomials; what words cost."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from quadshade.adapt.costs import shade_bytes
from quadshade.adapt.part_memory import WHOLE, Assessed, PartMemory
from quadshade.adapt.polynomial_fit import ORDERS, POINTS
from quadshade.adapt.small_triangles import PixelCentres, pixel_centres
from quadshade.choices import MAX_ERROR
from quadshade.contract.formats import CONSTANT, DIFFERENCES_OF_ORDER, LINEAR, POWER_MANTISSA_BITS, Formats
from quadshade.contract.shade_state import ShadeState
from quadshade.contract.triangles import ScreenTriangles
from quadshade.scene.project import Projected
from quadshade.scene.subdivide import Edges, shared_edges
from quadshade.setup.triangle_setup import has_constant_depth, setup_triangles
from quadshade.shading.lights import Light, default_lights
from quadshade.shading.material import Material
from quadshade.shading.phong_loops import LitMesh, lit_mesh
from quadshade.shading.point_sets import PointSets, shade_sets, shared_points
from quadshade.shading.sample import CHANNELS, full_scale, reflected

MARGIN = 1.08
"""The largest difference anywhere on a triangle, over that at the grid's points: measured, not a bound."""
OUTPUT_ROUNDING = 0.5
"""Output units that rounding to whole ones costs."""
POINTS_AT_A_TIME = 1 << 16
NUM_DIFFERENCES = np.array(DIFFERENCES_OF_ORDER)
MORE_LINEAR = NUM_DIFFERENCES[LINEAR] - NUM_DIFFERENCES[CONSTANT]


@dataclass(eq=False)
class Surface:
    """
    A mesh, divided or not, and how well each order would do on every triangle.

    Attributes
    ----------
    projected : Projected
    root : (n,) int64
      Triangle of the undivided mesh.
    assessed : Assessed
      What is found out for each triangle by itself.
    part : (n,) int64
      A number for each triangle: no two different ones that a shader has met have the same.
    last : ((edges,) bool, Surface) or None
      Edges that were split last, and what that made: plans for limits close together ask for the same ones.
    words : float or None
      Of its packets beside their channels' differences, once :meth:`Shader.stream_words` was asked.
    """

    projected: Projected
    root: np.ndarray
    assessed: Assessed
    part: np.ndarray
    last: tuple[np.ndarray, Surface] | None = None

    words: float | None = None

    @cached_property
    def edges(self) -> Edges:
        """Its edges, found when they are first asked for."""
        return shared_edges(self.projected.vertices)


@dataclass(frozen=True)
class Choice:
    """
    Orders for triangles, or for halves of them, over any leading axes.

    Attributes
    ----------
    orders : (..., channels) int64
    error : (...) float64
      Largest difference (``max``) or mean square, summed over the colours (``rms``).
    words : (...) float64
    """

    orders: np.ndarray
    error: np.ndarray
    words: np.ndarray

    def take(self, rows: np.ndarray) -> Choice:
        """Some of the triangles, by (m,) int rows."""
        return Choice(self.orders[rows], self.error[rows], self.words[rows])


@dataclass(frozen=True)
class Options:
    """
    Combinations of orders for triangles, each with polynomials of its own.

    Attributes
    ----------
    orders : (n, k, channels) int64
    samples : (n, k, channels, 6) float64
    errors : (n, k) float64
      The largest difference at the points that were looked at, before the output is rounded.
    """

    orders: np.ndarray
    samples: np.ndarray
    errors: np.ndarray


@dataclass(frozen=True, eq=False)
class Table:
    """
    The shade unit's state for pictures with some error, and what channels carry for it.

    Attributes
    ----------
    number : int
      No two tables of a shader have the same.
    make : function
      Makes the state when it is first asked for: most tables are only judged by their error.
    gain : (channels,) float64
      What channels carry, over what is fitted.
    error : float
      Output units that its coarsest entries cost.
    first : int
      Of power tables, where there are any: pictures read little before this entry.
    """

    number: int
    make: Callable[[], ShadeState | None]
    gain: np.ndarray
    error: float = 0.0
    first: int = 0

    @cached_property
    def state(self) -> ShadeState | None:
        """The state, None where there is no shade unit."""
        return self.make()

    @property
    def least_read(self) -> int:
        """The first entry that a picture may do with: an octave later."""
        return self.first + (1 << POWER_MANTISSA_BITS) if self.first else 0

    @cached_property
    def _bytes(self) -> dict[int, int]:
        return {}

    def bytes(self, first: int | None = None) -> int:
        """Of the state, its power tables from an entry on; by default :attr:`first`."""
        first = self.first if first is None else first
        if first not in self._bytes:
            self._bytes[first] = shade_bytes(self.state, first)
        return self._bytes[first]


class Shader:
    """Scene, light, core and error measure: what is common to colours and cosines."""

    shading = ""
    names: tuple[str, ...] = ()

    def __init__(
        self,
        lights: Sequence[Light] | None,
        material: Material | None,
        formats: Formats | None,
        projected: Projected,
        measure: str,
        place: Sequence[int],
    ) -> None:
        self.measure, self.whole = measure, projected
        self.margin = MARGIN if measure == "max" else 1.0
        self.memory = PartMemory(self.assess)
        self.formats = Formats() if formats is None else formats
        self.material = Material() if material is None else material
        self.lights = default_lights(projected.axes) if lights is None else lights
        self.place = np.array(place)
        self.full = 2.0**self.formats.value_bits - 1
        self.orders = ORDERS[: self.formats.max_order + 1]
        words = self.formats.difference_beats * self.formats.beat_words
        share = np.array([words / len(group) for group in self.formats.channel_groups for _ in group])
        self.difference_words = share[self.place]
        beats = self.formats.section_beats("edge") + self.formats.section_beats("second")
        self.packet_words = beats * self.formats.beat_words
        self.second_words = self.formats.section_beats("second") * self.formats.beat_words
        unused = np.delete(share[: self.formats.num_channels], self.place)
        self.packet_words += NUM_DIFFERENCES[CONSTANT] * unused.sum()
        if self.formats.with_depth:
            self.packet_words += NUM_DIFFERENCES[LINEAR] * share[-1]
            self.depth_words = MORE_LINEAR * share[-1]

    depth_words = 0.0
    """What a packet with constant depth takes less, where there is depth."""

    @cached_property
    def _plain(self) -> Table:
        return Table(0, lambda: None, np.ones(len(self.place)))

    def table(self, max_error: float = 0.0) -> Table:
        """The coarsest table that is good enough for an error, in output units; for 0 the finest."""
        return self._plain

    def coarser(self, table: Table) -> Table | None:
        """The next table that takes fewer bytes, if there is one."""
        return None

    def surface(self, projected: Projected) -> Surface:
        """An undivided mesh, shaded and fitted."""
        root = np.arange(len(projected))
        return self.parts(projected, root, np.full(len(root), WHOLE), root)

    def parts(self, projected: Projected, root: np.ndarray, parent: np.ndarray, child: np.ndarray) -> Surface:
        """Parts of triangles, shaded and fitted; see :meth:`PartMemory.assessed`."""
        return Surface(projected, root, *self.memory.assessed(projected, root, parent, child))

    def assess(self, projected: Projected, root: np.ndarray) -> Assessed:
        """What each triangle's pixels and samples say about every order, not remembered."""
        centres = pixel_centres(projected, self.formats.subpixel_bits, self.whole, root)
        assessed = self.fit(projected, centres, root)
        for values in (assessed.errors, assessed.bound):
            values[centres.pixels == 0] = 0
        return assessed

    def fit(self, projected: Projected, centres: PixelCentres, root: np.ndarray) -> Assessed:
        """The best polynomials of every order, and what each leaves."""
        raise NotImplementedError

    def options_at(
        self, lit: np.ndarray, whole: np.ndarray, points: np.ndarray, count: np.ndarray, wanted: float
    ) -> Options:
        """
        Combinations of orders, fitted at points of triangles to a small largest difference.

        Parameters
        ----------
        lit : (n,) int64
          The triangles of the undivided mesh of which these are parts.
        whole, points : (m, 3) float64
          The points in these, and in the parts, one triangle after the other.
        count : (n,) int64
          How many points each has, at least one.
        wanted : float
          An error for which nothing better is looked for.
        """
        raise NotImplementedError

    def choose(self, assessed: Assessed, goal: np.ndarray) -> Choice:
        """
        The cheapest orders.

        Parameters
        ----------
        assessed : Assessed
          Of a surface.
        goal : (n,) float64
          The largest difference (``max``), or the price of a word over a triangle's pixels (``rms``).
        """
        return self.choose_from(assessed.errors, assessed.options, assessed.words, goal)

    def least_more(self, varied: np.ndarray) -> np.ndarray:
        """(n,) float64 words that triangles take beyond constants where (n, 3) colours are not constant."""
        raise NotImplementedError

    def level_highlights(self, assessed: Assessed) -> np.ndarray:
        """(n,) bool: triangles that are drawn as well with constant specular channels, if there are any."""
        return np.zeros(len(assessed.pixels), dtype=bool)

    def choose_halves(self, surface: Surface, goal: np.ndarray, rows: np.ndarray) -> Choice:
        """As :meth:`choose` for (m, 3, 2) halves of (m,) int rows, if edge 0-1, 1-2 or 2-0 is split."""
        halves = self.memory.halves(
            surface.part[rows],
            lambda new: self.halves(
                surface.projected.ordered(rows[new]), surface.assessed.options[rows[new]]
            ),
        )
        return self.choose_from(halves, surface.assessed.options[rows], surface.assessed.words[rows], goal)

    def halves(self, projected: Projected, options: np.ndarray) -> np.ndarray:
        """(n, 3, 2, ...) what ``Assessed.errors`` would be of halves, from samples of the whole."""
        raise NotImplementedError

    def choose_from(
        self, errors: np.ndarray, options: np.ndarray, words: np.ndarray, goal: np.ndarray
    ) -> Choice:
        """The cheapest orders of (n, ...) triangles or parts of them, by (n,) goals."""
        raise NotImplementedError

    @cached_property
    def _whole_lit(self) -> LitMesh | None:
        return lit_mesh(self.whole, self.lights, self.material, self.full)

    def lit(self, projected: Projected) -> LitMesh | None:
        """What the loops take to shade a mesh: see :func:`lit_mesh`."""
        if projected is self.whole:
            return self._whole_lit
        return lit_mesh(projected, self.lights, self.material, self.full)

    def shade(self, projected: Projected, triangle: np.ndarray, sets: PointSets) -> np.ndarray:
        """(3, m) float64 true shading at points of (n,) int64 triangles."""
        lit = self.lit(projected)
        if lit is not None:
            return shade_sets(lit, triangle, sets)
        owner = np.repeat(triangle, sets.number)
        # Shared points are repeated for every triangle, others stand in order.
        points = (
            sets.points if len(sets.points) == len(owner) else np.tile(sets.points, (len(sets.number), 1))
        )
        values = np.empty((len(CHANNELS), len(owner)))
        for start in range(0, len(owner), POINTS_AT_A_TIME):
            some = slice(start, start + POINTS_AT_A_TIME)
            light = reflected(projected, owner[some], points[some, None], self.lights, self.material)
            values[:, some] = full_scale(light[:, 0], self.formats).T
        return values

    def shade_grid(self, projected: Projected) -> np.ndarray:
        """(3, n * 28) float64 true shading at the points of the grid, of all triangles."""
        every = np.arange(len(projected))
        return self.shade(projected, every, shared_points(POINTS, every))

    def screen_triangles(
        self, projected: Projected, samples: np.ndarray, orders: np.ndarray, table: Table | None = None
    ) -> ScreenTriangles:
        """What the set-up takes, from (n, channels, 6) samples and (n, channels) orders; the finest table."""
        table = self.table() if table is None else table
        count, channels = len(projected), self.formats.num_channels
        all_samples, all_orders = np.zeros((count, channels, 6)), np.full((count, channels), CONSTANT)
        all_samples[:, self.place], all_orders[:, self.place] = samples * table.gain[:, None], orders
        names = [f"unused{index}" for index in range(channels)]
        for place, name in zip(self.place, self.names, strict=True):
            names[place] = name
        depth = projected.depth if self.formats.with_depth else None
        return ScreenTriangles(
            projected.width, projected.height, projected.vertices, all_samples, all_orders, depth,
            tuple(names), table.state,
        )  # fmt: skip

    def free_orders(self, orders: np.ndarray) -> np.ndarray:
        """(n, channels) orders raised to what the channel's group sends anyway (streams of 64, 128 bits)."""
        carried = np.full((len(orders), self.formats.carried_channels), CONSTANT)
        carried[:, self.place] = orders
        if self.formats.with_depth:
            carried[:, -1] = LINEAR
        for group in self.formats.channel_groups:
            carried[:, list(group)] = carried[:, list(group)].max(axis=1, keepdims=True)
        return np.minimum(carried[:, self.place], self.formats.max_order)

    def words(self, orders: np.ndarray) -> np.ndarray:
        """(...) float64 words of packets with a middle vertex, for (..., channels) orders."""
        return self.packet_words + NUM_DIFFERENCES[orders] @ self.difference_words

    def stream_words(self, surface: Surface, orders: np.ndarray) -> int:
        """Words of a surface's packets with (n, channels) orders."""
        packets = surface.assessed.packets
        if surface.words is None:
            flat = packets[self.constant_depth(surface.projected), 0].sum()
            all_packets, two_edged = packets.sum(axis=0)
            one_edge = self.second_words * (all_packets - two_edged)
            surface.words = self.packet_words * all_packets - one_edge - self.depth_words * flat
        differences = packets[:, 0] @ NUM_DIFFERENCES[orders] @ self.difference_words
        return int(np.rint(surface.words + differences))

    def constant_depth(self, projected: Projected) -> np.ndarray:
        """(n,) bool: triangles whose packets take :attr:`depth_words` less."""
        if not self.formats.with_depth:
            return np.zeros(len(projected), bool)
        return has_constant_depth(projected.depth, self.formats)

    def set_up(self, projected: Projected, samples: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """
        What the set-up says of the highest order.

        Returns
        -------
        (n, channels) float64
          Its own bound of what rounding the words costs.
        (n, 2) int64
          See :attr:`Assessed.packets`.
        """
        top = np.full(samples.shape[:2], self.orders[-1])
        primitives = setup_triangles(self.screen_triangles(projected, samples, top), self.formats)
        bounds = np.zeros(top.shape)
        np.maximum.at(bounds, primitives.triangle, primitives.bound[:, self.place])
        owner, second = primitives.triangle, primitives.header["has_second"]
        counts = [np.bincount(owner[rows], minlength=len(top)) for rows in (second >= 0, second > 0)]
        packets = np.stack(counts, axis=1)
        packets[(bounds > MAX_ERROR).any(axis=1)] = -1
        return bounds, packets


def chosen_samples(assessed: Assessed, orders: np.ndarray) -> np.ndarray:
    """(n, channels, 6) samples of the chosen (n, channels) orders."""
    count, channels = orders.shape
    return assessed.samples[np.arange(count)[:, None], np.arange(channels), orders]
