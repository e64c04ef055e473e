# SPDX-License-Identifier: Apache-2.0
"""What a mesh is shaded with while orders are chosen: colours as polynomials; what words cost."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np

from quadshade.adapt.costs import shade_bytes
from quadshade.adapt.part_memory import WHOLE, Assessed, PartMemory
from quadshade.adapt.polynomial_fit import ORDERS, POINTS, Fit, better_fit, fit, fit_at, split_errors
from quadshade.adapt.small_triangles import PixelCentres, pixel_centres
from quadshade.choices import MAX_ERROR
from quadshade.contract.formats import CONSTANT, DIFFERENCES_OF_ORDER, LINEAR, Formats
from quadshade.contract.shade_state import ShadeState
from quadshade.contract.triangles import ScreenTriangles
from quadshade.errors import QuadshadeError
from quadshade.scene.project import Projected
from quadshade.setup.triangle_setup import setup_triangles
from quadshade.shading.lights import Light, default_lights
from quadshade.shading.material import Material
from quadshade.shading.phong_loops import lit_mesh, shade_places
from quadshade.shading.sample import CHANNELS, CHUNK, full_scale, reflected

MARGIN = 1.08
"""The largest difference anywhere on a triangle, over that at the grid's points: measured, not a bound."""
NUM_DIFFERENCES = np.array(DIFFERENCES_OF_ORDER)


@dataclass(frozen=True)
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
    """

    projected: Projected
    root: np.ndarray
    assessed: Assessed
    part: np.ndarray


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


class Shader:
    """Scene, light, core and error measure: what is common to colours and cosines."""

    shading = ""
    names: tuple[str, ...] = ()
    state: ShadeState | None = None

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

    @cached_property
    def state_bytes(self) -> int:
        """Of the shade unit's state."""
        return shade_bytes(self.state)

    def surface(self, projected: Projected) -> Surface:
        """An undivided mesh, shaded and fitted."""
        root = np.arange(len(projected))
        return self.parts(projected, root, np.full(len(root), WHOLE), root)

    def parts(self, projected: Projected, root: np.ndarray, parent: np.ndarray, child: np.ndarray) -> Surface:
        """Parts of triangles, shaded and fitted; see :meth:`PartMemory.assessed`."""
        return Surface(projected, root, *self.memory.assessed(projected, root, parent, child))

    def assess(self, projected: Projected, root: np.ndarray) -> Assessed:
        """What each triangle's pixels and samples say about every order, not remembered."""
        centres = pixel_centres(projected, self.formats, self.whole, root)
        assessed = self.fit(projected, centres, root)
        for values in (assessed.errors, assessed.bound):
            values[centres.pixels == 0] = 0
        return assessed

    def fit(self, projected: Projected, centres: PixelCentres, root: np.ndarray) -> Assessed:
        """The best polynomials of every order, and what each leaves."""
        raise NotImplementedError

    def options_at(
        self, lit: Projected, whole: np.ndarray, points: np.ndarray, used: np.ndarray, wanted: float
    ) -> Options:
        """
        Combinations of orders, fitted at points of triangles to a small largest difference.

        Parameters
        ----------
        lit : Projected
          The triangles of the undivided mesh of which these are parts.
        whole, points : (n, p, 3) float64
          The points in these, and in the parts.
        used : (n, p) bool
          Which of them count, at least one.
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
        raise NotImplementedError

    def choose_halves(self, surface: Surface, goal: np.ndarray, rows: np.ndarray) -> Choice:
        """As :meth:`choose` for (m, 3, 2) halves of (m,) int rows, if edge 0-1, 1-2 or 2-0 is split."""
        halves = self.memory.halves(
            surface.part[rows],
            lambda new: self.halves(
                surface.projected.ordered(rows[new]), surface.assessed.options[rows[new]]
            ),
        )
        return self.choose_from(halves, surface.assessed.options[rows, None, None], goal[:, None, None])

    def halves(self, projected: Projected, options: np.ndarray) -> np.ndarray:
        """(n, 3, 2, ...) what ``Assessed.errors`` would be of halves, from samples of the whole."""
        raise NotImplementedError

    def choose_from(self, errors: np.ndarray, options: np.ndarray, goal: np.ndarray) -> Choice:
        """The cheapest orders over any leading axes, those of the goal (1 where it is the same)."""
        raise NotImplementedError

    def shade(self, projected: Projected, points: np.ndarray) -> np.ndarray:
        """(n, 3, p) float64 true shading at (p, 3) or (n, p, 3) points."""
        lit = lit_mesh(projected, self.lights, self.material, self.full)
        if lit is not None:
            places = np.ascontiguousarray(points if points.ndim == 3 else points[None], dtype=np.float64)
            return shade_places(lit, np.arange(len(projected)), places).transpose(0, 2, 1)
        values = np.empty((len(projected), len(CHANNELS), points.shape[-2]))
        for start in range(0, len(projected), CHUNK):
            rows = np.arange(start, min(start + CHUNK, len(projected)))
            barycentric = points if points.ndim == 2 else points[rows]
            light = reflected(projected, rows, barycentric, self.lights, self.material)
            values[rows] = full_scale(light, self.formats).transpose(0, 2, 1)
        return values

    def screen_triangles(
        self, projected: Projected, samples: np.ndarray, orders: np.ndarray
    ) -> ScreenTriangles:
        """What the set-up takes, from (n, channels, 6) samples and (n, channels) orders."""
        count, channels = len(projected), self.formats.num_channels
        all_samples, all_orders = np.zeros((count, channels, 6)), np.full((count, channels), CONSTANT)
        all_samples[:, self.place], all_orders[:, self.place] = samples, orders
        names = [f"unused{index}" for index in range(channels)]
        for place, name in zip(self.place, self.names, strict=True):
            names[place] = name
        depth = projected.depth if self.formats.with_depth else None
        return ScreenTriangles(
            projected.width, projected.height, projected.vertices, all_samples, all_orders, depth,
            tuple(names), self.state,
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
        second = primitives.header["has_second"]
        packets = np.stack(
            [
                np.bincount(primitives.triangle[rows], minlength=len(top))
                for rows in (second >= 0, second > 0)
            ],
            axis=1,
        )
        packets[(bounds > MAX_ERROR).any(axis=1)] = -1
        return bounds, packets


class ColourShader(Shader):
    """
    Red, green and blue, each of an order of its own: channels need not know of each other.

    With ``even`` polynomials of large triangles are tried whose differences Lawson's iteration evens out at
    the grid's points. Between them such a polynomial is off by more, so drawings have to be verified.
    """

    shading = "quadratic"
    names = CHANNELS

    def __init__(
        self,
        lights: Sequence[Light] | None,
        material: Material | None,
        formats: Formats | None,
        projected: Projected,
        measure: str = "max",
        even: bool = True,
    ) -> None:
        self.even = even
        formats = Formats() if formats is None else formats
        got = formats.num_channels
        if got < len(CHANNELS) or (got > len(CHANNELS) and not formats.with_shade):
            raise QuadshadeError(f"generic num_channels is {got}", f"a picture needs {len(CHANNELS)}")
        super().__init__(lights, material, formats, projected, measure, range(len(CHANNELS)))

    def fit(self, projected: Projected, centres: PixelCentres, root: np.ndarray) -> Assessed:
        """See :meth:`Shader.fit`; errors are (n, 3, orders)."""
        values = self.shade(projected, POINTS)
        fits = [self._fitted(values, order) for order in self.orders]
        samples = np.stack([one.samples for one in fits], axis=2)
        errors = np.stack([one.by(self.measure) for one in fits], axis=2) * self.margin
        for rows, points, whole, used in centres.groups():
            values = self.shade(self.whole.ordered(root[rows]), whole)
            for index, order in enumerate(self.orders):
                one = fit_at(points, used, values, order, self.full, self.measure)
                samples[rows, :, index], errors[rows, :, index] = one.samples, one.by(self.measure)
        bounds, packets = self.set_up(projected, samples[:, :, -1])
        no_options = np.zeros((len(projected), 0, len(CHANNELS)), dtype=np.int64)
        return Assessed(centres.pixels, bounds.max(axis=1, initial=0), packets, samples, errors, no_options)

    def _fitted(self, values: np.ndarray, order: int) -> Fit:
        """The best polynomial at the grid's points."""
        best = fit(values, order, self.full, self.measure)
        if self.even and self.measure == "max" and order != CONSTANT:
            everywhere = np.ones((1, len(POINTS)), dtype=bool)
            even = fit_at(POINTS[None], everywhere, values, order, self.full, self.measure)
            best = better_fit(best, even, self.measure)
        return best

    def options_at(
        self, lit: Projected, whole: np.ndarray, points: np.ndarray, used: np.ndarray, wanted: float
    ) -> Options:
        """See :meth:`Shader.options_at`."""
        values = self.shade(lit, whole)
        fits = [fit_at(points, used, values, order, self.full, self.measure) for order in self.orders]
        samples = np.stack([one.samples for one in fits], axis=2)
        errors = np.stack([one.largest for one in fits], axis=2)
        every = np.array(list(product(range(len(self.orders)), repeat=len(CHANNELS))))
        orders = np.unique(self.free_orders(every), axis=0)
        channel = np.arange(len(CHANNELS))
        return Options(
            np.broadcast_to(orders, (len(values), *orders.shape)),
            samples[:, channel, orders],
            errors[:, channel, orders].max(axis=2),
        )

    def halves(self, projected: Projected, options: np.ndarray) -> np.ndarray:
        """See :meth:`Shader.halves`; (n, 3, 2, 3, orders)."""
        values = self.shade(projected, POINTS)
        errors = [split_errors(values, order, self.measure) for order in self.orders]
        return np.stack(errors, axis=-1) * self.margin

    def choose_from(self, errors: np.ndarray, options: np.ndarray, goal: np.ndarray) -> Choice:
        """See :meth:`Shader.choose_from`."""
        if self.measure == "max":
            good = errors <= goal[..., None, None]
            good[..., -1] = True
            orders = good.argmax(axis=-1)
        else:
            differences = NUM_DIFFERENCES[list(self.orders)] * self.difference_words[:, None]
            orders = (errors + goal[..., None, None] * differences).argmin(axis=-1)
        return self._of(orders, errors)

    def _of(self, orders: np.ndarray, errors: np.ndarray) -> Choice:
        left = np.take_along_axis(errors, orders[..., None], axis=-1)[..., 0]
        left = left.max(axis=-1) if self.measure == "max" else left.sum(axis=-1)
        return Choice(orders, left, self.words(orders))

    def choose(self, assessed: Assessed, goal: np.ndarray) -> Choice:
        """See :meth:`Shader.choose`."""
        errors = assessed.errors
        return self._of(self.free_orders(self.choose_from(errors, assessed.options, goal).orders), errors)


def chosen_samples(assessed: Assessed, orders: np.ndarray) -> np.ndarray:
    """(n, channels, 6) samples of the chosen (n, channels) orders."""
    return np.take_along_axis(assessed.samples, orders[..., None, None], axis=2)[:, :, 0]
