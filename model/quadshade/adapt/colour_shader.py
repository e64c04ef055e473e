# SPDX-License-Identifier: Apache-2.0
"""Red, green and blue while orders are chosen, each for itself."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np

from quadshade.adapt.part_memory import Assessed
from quadshade.adapt.polynomial_fit import POINTS, Fit, better_fit, fit, fit_sets, split_errors
from quadshade.adapt.shader import MORE_LINEAR, NUM_DIFFERENCES, Choice, Options, Shader
from quadshade.adapt.small_triangles import PixelCentres
from quadshade.contract.formats import CONSTANT, Formats
from quadshade.errors import QuadshadeError
from quadshade.scene.project import Projected
from quadshade.shading.lights import Light
from quadshade.shading.material import Material
from quadshade.shading.point_sets import PointSets, own_points, shared_points
from quadshade.shading.sample import CHANNELS


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
        count = len(projected)
        # Of a triangle without a pixel everything stays 0.
        samples = np.zeros((count, len(CHANNELS), len(self.orders), 6))
        errors = np.zeros((count, len(CHANNELS), len(self.orders)))
        large = np.ones(count, dtype=bool)
        large[centres.rows], large[centres.pixels == 0] = False, False
        rows = np.flatnonzero(large)
        on_grid, at_pixels = (
            shared_points(POINTS, np.arange(len(rows))),
            own_points(centres.whole, centres.have),
        )
        values = self.shade(projected, rows, on_grid)
        true = self.shade(self.whole, root[centres.rows], at_pixels)
        for index, order in enumerate(self.orders):
            one = self._fitted(values, on_grid, order)
            samples[rows, :, index], errors[rows, :, index] = one.samples, one.by(self.measure) * self.margin
            sets = own_points(centres.points, centres.have)
            one = fit_sets(sets, true, order, self.full, self.measure)
            samples[centres.rows, :, index], errors[centres.rows, :, index] = (
                one.samples,
                one.by(self.measure),
            )
        bounds, packets = self.set_up(projected, samples[:, :, -1])
        none = np.zeros((count, 0, len(CHANNELS)), dtype=np.int64)
        bound = bounds.max(axis=1, initial=0)
        return Assessed(centres.pixels, bound, packets, samples, errors, none, np.zeros((count, 0)))

    def _fitted(self, values: np.ndarray, on_grid: PointSets, order: int) -> Fit:
        """The best polynomial at the grid's points."""
        best = fit(by_triangle(values), order, self.full, self.measure)
        if self.even and self.measure == "max" and order != CONSTANT:
            even = fit_sets(on_grid, values, order, self.full, self.measure)
            best = better_fit(best, even, self.measure)
        return best

    def options_at(
        self, lit: np.ndarray, whole: np.ndarray, points: np.ndarray, count: np.ndarray, wanted: float
    ) -> Options:
        """See :meth:`Shader.options_at`."""
        values = self.shade(self.whole, lit, own_points(whole, count))
        sets = own_points(points, count)
        fits = [fit_sets(sets, values, order, self.full, self.measure) for order in self.orders]
        samples = np.stack([one.samples for one in fits], axis=2)
        errors = np.stack([one.largest for one in fits], axis=2)
        every = np.array(list(product(range(len(self.orders)), repeat=len(CHANNELS))))
        orders = np.unique(self.free_orders(every), axis=0)
        channel = np.arange(len(CHANNELS))
        return Options(
            np.broadcast_to(orders, (len(count), *orders.shape)),
            samples[:, channel, orders],
            errors[:, channel, orders].max(axis=2),
        )

    def halves(self, projected: Projected, options: np.ndarray) -> np.ndarray:
        """See :meth:`Shader.halves`; (n, 3, 2, 3, orders)."""
        values = by_triangle(self.shade_grid(projected))
        errors = [split_errors(values, order, self.measure) for order in self.orders]
        return np.stack(errors, axis=-1) * self.margin

    def choose_from(
        self, errors: np.ndarray, options: np.ndarray, words: np.ndarray, goal: np.ndarray
    ) -> Choice:
        """See :meth:`Shader.choose_from`."""
        goal = goal.reshape(-1, *[1] * (errors.ndim - 1))
        if self.measure == "max":
            good = errors <= goal
            good[..., -1] = True
            orders = good.argmax(axis=-1)
        else:
            differences = NUM_DIFFERENCES[list(self.orders)] * self.difference_words[:, None]
            orders = (errors + goal * differences).argmin(axis=-1)
        return self._of(orders, errors)

    def least_more(self, varied: np.ndarray) -> np.ndarray:
        """See :meth:`Shader.least_more`."""
        return MORE_LINEAR * (varied @ self.difference_words)

    def _of(self, orders: np.ndarray, errors: np.ndarray) -> Choice:
        left = np.take_along_axis(errors, orders[..., None], axis=-1)[..., 0]
        left = left.max(axis=-1) if self.measure == "max" else left.sum(axis=-1)
        return Choice(orders, left, self.words(orders))

    def choose(self, assessed: Assessed, goal: np.ndarray) -> Choice:
        """See :meth:`Shader.choose`."""
        errors = assessed.errors
        return self._of(
            self.free_orders(self.choose_from(errors, assessed.options, assessed.words, goal).orders), errors
        )


def by_triangle(values: np.ndarray) -> np.ndarray:
    """(n, channels, 28) values at the grid's points, from (channels, n * 28)."""
    return values.reshape(len(values), -1, len(POINTS)).transpose(1, 0, 2)
