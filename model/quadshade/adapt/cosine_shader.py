# SPDX-License-Identifier: Apache-2.0
"""Diffuse and specular cosines while orders are chosen: the power is taken at the pixel."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from itertools import product
from math import prod

import numpy as np

from quadshade.adapt.cosine_loops import CosineKind, fit_cosines
from quadshade.adapt.joint_loops import fit_together
from quadshade.adapt.option_loops import choose_options, half_cosines, joint_errors
from quadshade.adapt.part_memory import Assessed
from quadshade.adapt.polynomial_fit import EQUALISING, HALF_COUNTS, HALF_POINTS, NODES, POINTS
from quadshade.adapt.shader import MORE_LINEAR, OUTPUT_ROUNDING, Choice, Options, Shader, Table
from quadshade.adapt.small_triangles import PixelCentres
from quadshade.contract.formats import CONSTANT, POWER_MANTISSA_BITS, Formats
from quadshade.golden.shade.render_core import first_entry
from quadshade.scene.project import Projected
from quadshade.shading.lights import Light, default_lights
from quadshade.shading.material import Material
from quadshade.shading.point_sets import PointSets, cosine_sets, own_points, shared_points
from quadshade.shading.specular import (
    ambient_colour,
    light_colours,
    light_strength,
    specular_lights,
    specular_state,
)

SECANTS = 2
"""Repetitions with the power's slope between the cosine and what it became."""
MOST_OPTIONS = 81
"""All combinations of orders are tried up to so many; else those that treat all channels alike."""
LEVELS = 11
"""Errors, each half of the one before, down to which channels are treated alike."""
FARTHEST = 6
"""Times what is wanted: combinations that are off by more when fitted apart are not fitted together."""
STEPS = 16
"""Of fitting together."""
LEVEL = 0.01
"""Output units that a specular channel of a higher order has to be better by."""
FINE = 0.02
"""Output units that no picture saves anything by: nothing better is looked for."""
FINE_SQUARE = 1e-8
"""The same of a mean square: these add up over a picture."""
ROUGH, LEAST_ROUGH = 0.04, 0.02
"""Of an error, and output units: what a table may cost where channels do not reach its finest entries."""
FEWEST_OCTAVES, MOST_OCTAVES = 3, 8
"""Of a table. With fewer, places far from 1 would be coarser too; with more, channels reach up to 1."""
TABLE_ERROR = 0.04
"""Of the output for a light of 1: the power table's and the lane's rounding (docs/explanation/shade.md)."""


class CosineShader(Shader):
    """
    For each light a diffuse and a specular channel; their errors meet in the colour.

    With ``power`` the specular one is a cosine, and a table makes the power of it at the pixel. Without, it
    carries the power, and the shade unit's state is a few words.
    """

    shading = "quadratic-specular"
    power = True

    def __init__(
        self,
        lights: Sequence[Light] | None,
        material: Material | None,
        formats: Formats,
        projected: Projected,
        measure: str = "max",
    ) -> None:
        material = Material() if material is None else material
        lights = default_lights(projected.axes) if lights is None else lights
        self.pointed = specular_lights(projected, lights, material)
        count, first = len(self.pointed), formats.num_channels - formats.num_specular
        place = [*range(count), *range(first, first + count)]
        super().__init__(lights, material, formats, projected, measure, place)
        self.names = tuple(f"{kind}{index}" for kind in "ds" for index in range(count))
        self.strength = light_strength(projected, self.pointed, POINTS)
        # Output units that a channel's full value adds, (lights, 3), and the exponent.
        colours = light_colours(self.pointed, self.material, self.strength)
        self.diffuse, self.specular = (self.full * colour for colour in colours)
        self.table_error = TABLE_ERROR * self.specular.max(axis=1).sum() / self.full
        self._tables: dict[int, Table] = {}
        self._octaves: dict[float, int] = {}
        self.ambient = self.full * ambient_colour(self.lights, self.material)
        self.exponent = self.material.exponent if self.power else 1.0
        norm = np.max if measure == "max" else np.linalg.norm
        self.kind = CosineKind(
            float(self.exponent),
            int(self.exponent) if self.exponent == int(self.exponent) else -1,
            self.power,
            np.asarray(self.ambient, dtype=np.float64),
            self.diffuse,
            self.specular,
            np.concatenate([norm(self.diffuse, axis=1), norm(self.specular, axis=1)]),
            self.full,
            measure == "max",
            # Of powers as they are, secants are the first weights, but where a mean square is drawn below 0.
            SECANTS if self.exponent != 1 or measure != "max" else 0,
            EQUALISING,
            len(self.orders),
            FINE if measure == "max" else FINE_SQUARE,
        )
        all_orders = len(self.orders) ** (2 * count)
        self.combinations: tuple[np.ndarray, np.ndarray] | None = None
        if all_orders <= MOST_OPTIONS:
            every = np.array(list(product(range(len(self.orders)), repeat=2 * count)))
            orders = self.free_orders(every)
            self.combinations = orders, self.words(orders)

    def table(self, max_error: float = 0.0) -> Table:
        """
        See :meth:`Shader.table`.

        Below 1 - 2**-k a power table has k octaves. Between its places it is a chord of the power, off by an
        eighth of the second derivative times the square of their distance at most.
        """
        if max_error not in self._octaves:
            enough = max(ROUGH * (max_error - OUTPUT_ROUNDING), LEAST_ROUGH)
            octaves = FEWEST_OCTAVES
            while self.power and octaves < MOST_OCTAVES and self._of_octaves(octaves).error > enough:
                octaves += 1
            self._octaves[max_error] = octaves
        return self._of_octaves(self._octaves[max_error])

    def _of_octaves(self, octaves: int) -> Table:
        """The table with so many; with the most, channels reach up to 1."""
        if octaves not in self._tables:
            reach, rough, first = 1.0, 0.0, 0
            if self.power and octaves < MOST_OCTAVES:
                reach = 1 - 0.5**octaves
                step = 0.5**octaves / (1 << POWER_MANTISSA_BITS) / reach
                curved = self.exponent * (self.exponent - 1)
                rough = float(curved / 8 * step**2 * self.specular.sum(axis=0).max())
            given = self.formats, self.lights, self.material, self.strength, None, self.power, reach
            state = partial(specular_state, *given)
            if self.power:
                value = int(reach * ((1 << self.formats.lane_value_bits) - 1))
                first = first_entry(value, self.formats)
            gain = np.repeat([1.0, reach], len(self.pointed))
            self._tables[octaves] = Table(octaves, state, gain, rough, first)
        return self._tables[octaves]

    def coarser(self, table: Table) -> Table | None:
        """See :meth:`Shader.coarser`."""
        fewer = table.number > FEWEST_OCTAVES and self.power
        return self._of_octaves(table.number - 1) if fewer else None

    def fit(self, projected: Projected, centres: PixelCentres, root: np.ndarray) -> Assessed:
        """See :meth:`Shader.fit`; errors are (n, k) of (n, k, channels) options."""
        count, every = len(projected), np.arange(len(projected))
        grid = self._cosines(projected, every, shared_points(POINTS, every))
        large = np.ones(count, dtype=bool)
        large[centres.rows], large[centres.pixels == 0] = False, False
        large_rows, all_nodes = np.flatnonzero(large), np.array([(*nodes, *[0] * 6)[:6] for nodes in NODES])
        lit = self._cosines(self.whole, root[centres.rows], own_points(centres.whole, centres.have))
        # Of a triangle without a pixel everything stays 0.
        samples = np.zeros((count, len(self.place), len(self.orders), 6))
        own = np.zeros(samples.shape[:3])
        fitted = []
        for sets, cosine, nodes, rows in (
            (shared_points(POINTS, large_rows), grid, all_nodes, large_rows),
            (own_points(centres.points, centres.have), lit, all_nodes[:0], centres.rows),
        ):
            if len(rows):
                drawn = fit_cosines(self.kind, sets, *cosine, nodes, rows, samples, own)
                fitted.append((sets, cosine, drawn, rows))
        options, words = self._options(own)
        if not centres.pixels.all():
            options = np.where((centres.pixels == 0)[:, None, None], CONSTANT, options)
            words = self.words(options)
        errors = np.zeros(options.shape[:2])
        for sets, cosine, drawn, rows in fitted:
            joint_errors(self.kind, sets, *cosine, drawn, options, rows, errors)
        errors[large_rows] *= self.margin
        samples *= self.full
        bounds, packets = self.set_up(projected, samples[:, :, -1])
        diffuse, specular = self.diffuse.max(axis=1), self.specular.max(axis=1)
        bounds[:, : len(diffuse)] *= diffuse
        bounds[:, len(diffuse) :] *= specular * self._steepest(*grid) / self.table().gain[-1]
        bound = bounds.sum(axis=1) / self.full + self.table_error
        return Assessed(centres.pixels, bound, packets, samples, errors, options, words)

    def _steepest(self, facing: np.ndarray, towards: np.ndarray) -> np.ndarray:
        """(n, lights) the power's steepest slope at the grid's points, where it counts."""
        lit = (facing > 0) & ((towards > 0) | (not self.power))
        slope = lit * self.exponent * np.clip(towards, 0, 1) ** (self.exponent - 1)
        return slope.reshape(len(slope), -1, len(POINTS)).max(axis=-1).T

    def halves(self, projected: Projected, options: np.ndarray) -> np.ndarray:
        """See :meth:`Shader.halves`; (n, 3, 2, k) sums over the channels."""
        every = np.arange(len(projected))
        cosine = self._cosines(projected, every, shared_points(POINTS, every))
        left = half_cosines(self.kind, POINTS, *cosine, HALF_POINTS, HALF_COUNTS, options)
        return left.reshape(len(left), 3, 2, -1) * self.margin

    def _cosines(
        self, projected: Projected, triangle: np.ndarray, sets: PointSets
    ) -> tuple[np.ndarray, np.ndarray]:
        """(lights, m) diffuse and specular cosines at points of (n,) int64 triangles."""
        lit = self.lit(projected)
        assert lit is not None, "only colours can have a reflectance of the user's own"
        facing, towards = cosine_sets(lit, triangle, sets, self.strength)
        return facing, towards if self.power else np.clip(towards, 0, 1) ** self.material.exponent

    def options_at(
        self, lit: np.ndarray, whole: np.ndarray, points: np.ndarray, count: np.ndarray, wanted: float
    ) -> Options:
        """See :meth:`Shader.options_at`; channels are fitted together, for the colour that they make."""
        places, sets = own_points(whole, count), own_points(points, count)
        cosine, every = self._cosines(self.whole, lit, places), np.arange(len(count))
        own = np.zeros((len(count), len(self.place), len(self.orders)))
        fitted = np.zeros((*own.shape, 6))
        none = np.empty((0, 6), np.int64)
        drawn = fit_cosines(self.kind, sets, *cosine, none, every, fitted, own)
        orders, words = self._options(own)
        errors = np.empty(orders.shape[:2])
        joint_errors(self.kind, sets, *cosine, drawn, orders, every, errors)
        samples = np.take_along_axis(fitted[:, None], orders[..., None, None], axis=3)[:, :, :, 0]
        true = self.shade(self.whole, lit, places)
        known = np.where(errors <= wanted, words, np.inf).min(axis=1)
        hopeful = (words < known[:, None]) & (errors > wanted) & (errors <= FARTHEST * (wanted + 1))
        for option in np.flatnonzero(hopeful.any(axis=0)).tolist():
            rows = np.flatnonzero(hopeful[:, option])
            own = np.ascontiguousarray(samples[rows, option])
            mine = PointSets(sets.points, sets.begin[rows], sets.number[rows], sets.at[rows])
            picked = np.ascontiguousarray(orders[rows, option])
            errors[rows, option] = fit_together(self.kind, mine, picked, own, true, STEPS)
            samples[rows, option] = own
        return Options(orders, samples * self.full, errors)

    def _options(self, errors: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """
        Orders to choose from, (n, k, channels), and their (n, k) words.

        They may depend on (n, channels, orders) errors of each channel.
        """
        count, channels = errors.shape[:2]
        if self.combinations is not None:
            orders, words = self.combinations
            return np.repeat(orders[None], count, axis=0), np.repeat(words[None], count, axis=0)
        levels = self.full * 0.5 ** np.arange(LEVELS)
        good = errors[:, None] <= levels[:, None, None]
        good[..., -1] = True
        options = good.argmax(axis=-1)
        options = self.free_orders(options.reshape(-1, channels)).reshape(options.shape)
        return options, self.words(options)

    def level_highlights(self, assessed: Assessed) -> np.ndarray:
        """See :meth:`Shader.level_highlights`."""
        if self.combinations is None:
            return super().level_highlights(assessed)
        channels, top = len(self.place) // 2, len(self.orders) - 1
        level = self.combinations[0] == np.repeat([top, CONSTANT], channels)
        errors = assessed.errors[:, level.all(axis=1)]
        return np.asarray((errors <= assessed.errors[:, -1:] + LEVEL).any(axis=1))

    def least_more(self, varied: np.ndarray) -> np.ndarray:
        """See :meth:`Shader.least_more`: constant cosines make a constant colour."""
        return MORE_LINEAR * self.difference_words.min() * varied.any(axis=1)

    def choose_from(
        self, errors: np.ndarray, options: np.ndarray, words: np.ndarray, goal: np.ndarray
    ) -> Choice:
        """See :meth:`Shader.choose_from`."""
        shape, count = errors.shape[:-1], len(options)
        flat = errors.reshape(count, prod(shape[1:]), errors.shape[-1])
        largest = self.measure == "max"
        orders, left, spent = choose_options(flat, words, options, goal, largest)
        return Choice(orders.reshape(*shape, options.shape[-1]), left.reshape(shape), spent.reshape(shape))


class LightShader(CosineShader):
    """For each light its diffuse and its specular part: two channels where colours are three."""

    shading = "quadratic-lights"
    power = False
