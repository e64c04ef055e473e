# SPDX-License-Identifier: Apache-2.0
"""Diffuse and specular cosines while orders are chosen: the power is taken at the pixel."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import product

import numpy as np

from quadshade.adapt.cosine_fit import DARK, Diffuse, Specular
from quadshade.adapt.cosine_loops import FAINT, CosineKind, joint_errors
from quadshade.adapt.joint_loops import fit_together
from quadshade.adapt.part_memory import Assessed
from quadshade.adapt.polynomial_fit import NODES, POINTS, Fit, shape_functions
from quadshade.adapt.shader import NUM_DIFFERENCES, Choice, Options, Shader
from quadshade.adapt.small_triangles import PixelCentres
from quadshade.contract.formats import Formats
from quadshade.scene.project import Projected
from quadshade.shading.lights import Light, default_lights
from quadshade.shading.material import Material
from quadshade.shading.sample import CHUNK
from quadshade.shading.specular import ambient_colour, cosines, light_colours, specular_lights, specular_state

MOST_OPTIONS = 81
"""All combinations of orders are tried up to so many; else those that treat all channels alike."""
LEVELS = 11
"""Errors, each half of the one before, down to which channels are treated alike."""
FARTHEST = 6
"""Times what is wanted: combinations that are off by more when fitted apart are not fitted together."""
STEPS = 16
"""Of fitting together."""
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
        self.strength = cosines(projected, self.pointed, self.material, POINTS)[2]
        self.state = specular_state(formats, self.lights, self.material, self.strength, power=self.power)
        # Output units that a channel's full value adds, (lights, 3), and the exponent.
        colours = light_colours(self.pointed, self.material, self.strength)
        self.diffuse, self.specular = (self.full * colour for colour in colours)
        self.ambient = self.full * ambient_colour(self.lights, self.material)
        self.exponent = self.material.exponent if self.power else 1.0
        all_orders = len(self.orders) ** (2 * count)
        combinations = product(range(len(self.orders)), repeat=2 * count)
        self.combinations = np.array(list(combinations)) if all_orders <= MOST_OPTIONS else None

    def fit(self, projected: Projected, centres: PixelCentres, root: np.ndarray) -> Assessed:
        """See :meth:`Shader.fit`; errors are (n, k) of (n, k, channels) options."""
        count = len(projected)
        found = self._chunks(projected, slice(None), lambda part, _: self._steepest(part))
        num_options = LEVELS if self.combinations is None else len(self.combinations)
        # Of a triangle without a pixel everything stays 0.
        found["samples"] = np.zeros((count, len(self.place), len(self.orders), 6))
        found["options"] = np.zeros((count, num_options, len(self.place)), dtype=np.int64)
        found["errors"] = np.zeros((count, num_options))
        large = np.ones(count, dtype=bool)
        large[centres.rows], large[centres.pixels == 0] = False, False
        everywhere = np.ones((1, len(POINTS)), dtype=bool)

        def put(rows: np.ndarray, fitted: dict[str, np.ndarray]) -> None:
            for key, values in fitted.items():
                found[key][rows] = values

        rows = np.flatnonzero(large)
        put(
            rows,
            self._chunks(
                projected, rows, lambda part, _: self._fitted(part, POINTS, POINTS, everywhere, NODES)
            ),
        )
        for rows, *arrays in centres.groups():

            def at_pixels(
                part: Projected, chunk: slice, arrays: list[np.ndarray] = arrays
            ) -> dict[str, np.ndarray]:
                points, whole, used = (values[chunk] for values in arrays)
                return self._fitted(part, whole, points, used)

            put(rows, self._chunks(self.whole.ordered(root), rows, at_pixels))
        bounds, packets = self.set_up(projected, found["samples"][:, :, -1])
        diffuse, specular = self.diffuse.max(axis=1), self.specular.max(axis=1)
        bounds[:, : len(diffuse)] *= diffuse
        bounds[:, len(diffuse) :] *= specular * found.pop("steepest")
        bound = (bounds.sum(axis=1) + TABLE_ERROR * specular.sum()) / self.full
        return Assessed(centres.pixels, bound, packets, found["samples"], found["errors"], found["options"])

    def _chunks(
        self,
        projected: Projected,
        rows: np.ndarray | slice,
        work: Callable[[Projected, slice], dict[str, np.ndarray]],
    ) -> dict[str, np.ndarray]:
        """What a function finds out for some triangles at a time; it gets them, and which of the rows."""
        parts, rows = [], np.arange(len(projected))[rows]
        for start in range(0, max(len(rows), 1), CHUNK):
            chunk = slice(start, start + CHUNK)
            parts.append(work(projected.ordered(rows[chunk]), chunk))
        return {key: np.concatenate([part[key] for part in parts]) for key in parts[0]}

    def _steepest(self, projected: Projected) -> dict[str, np.ndarray]:
        channels = self._channels(projected, POINTS, np.ones((1, len(POINTS)), dtype=bool))
        return {"steepest": channels[1].slope.max(axis=-1)}

    def halves(self, projected: Projected, options: np.ndarray) -> np.ndarray:
        """See :meth:`Shader.halves`; (n, 3, 2, k) sums over the channels."""
        half = self._chunks(projected, slice(None), lambda part, _: self._halves(part))["half"]
        errors = np.zeros((*half.shape[:3], options.shape[1]))
        for channel in range(len(self.place)):
            errors += np.take_along_axis(half[..., channel, :], options[:, None, None, :, channel], axis=-1)
        return errors

    def _halves(self, projected: Projected) -> dict[str, np.ndarray]:
        """``half`` (n, 3, 2, channels, orders): what each channel would leave."""
        channels = self._channels(projected, POINTS, np.ones((1, len(POINTS)), dtype=bool))
        half = [np.stack([one.halves(order, self.measure) for order in self.orders], -1) for one in channels]
        return {"half": np.concatenate(half, axis=3) * self.margin}

    def _channels(
        self, projected: Projected, points: np.ndarray, used: np.ndarray
    ) -> tuple[Diffuse, Specular]:
        """The cosines at points of triangles."""
        facing, towards, _ = cosines(projected, self.pointed, self.material, points, self.strength)
        facing, towards = facing.transpose(1, 0, 2), towards.transpose(1, 0, 2)
        if not self.power:
            towards = np.clip(towards, 0, 1) ** self.material.exponent
        norm = np.max if self.measure == "max" else np.linalg.norm
        scales = [norm(colours, axis=1)[:, None] for colours in (self.diffuse, self.specular)]
        shine = np.clip(towards, 0, 1) ** self.exponent
        lit = (facing > 0) & ((towards > 0) | (not self.power))
        slope = lit * self.exponent * np.clip(towards, 0, 1) ** (self.exponent - 1)
        counts = np.broadcast_to(used[:, None], facing.shape)
        return (
            Diffuse(facing, counts * np.where(facing > 0, 1, DARK), counts, scales[0], shine * scales[1]),
            Specular(
                towards, counts * (slope / self.exponent + FAINT), counts, scales[1], lit, self.exponent
            ),
        )

    def _fitted(
        self,
        projected: Projected,
        barycentric: np.ndarray,
        points: np.ndarray,
        used: np.ndarray,
        nodes: list[list[int]] | None = None,
    ) -> dict[str, np.ndarray]:
        """
        The best polynomials at points of triangles, and how far colours are off with each option.

        Parameters
        ----------
        projected : Projected
          What is lit: these triangles, or those of which they are parts.
        barycentric : (p, 3) or (n, p, 3) float
          Where in it.
        points : (p, 3) or (n, p, 3) float
          The same points in the triangles themselves.
        used : (1 or n, p) bool
        nodes : list, optional
          For the grid: its points that a polynomial of each order may go through.
        """
        channels = self._channels(projected, barycentric, used)
        shapes = [
            shape_functions(points, order).reshape(-1, points.shape[-2], NUM_DIFFERENCES[order])
            for order in self.orders
        ]
        fits: list[list[Fit]] = []
        for channel in channels:
            fits.append([])
            for order, shape in zip(self.orders, shapes, strict=True):
                through = None if nodes is None else channel.value[..., nodes[order]]
                fits[-1].append(channel.best(shape, through, self.measure))
        samples = np.concatenate([np.stack([one.samples for one in part], axis=2) for part in fits], axis=1)
        own = np.concatenate([np.stack([one.largest for one in part], axis=2) for part in fits], axis=1)
        options = self._options(own)
        drawn = [
            np.stack(
                [
                    one.samples[..., : shape.shape[-1]] @ np.swapaxes(shape, 1, 2)
                    for one, shape in zip(part, shapes, strict=True)
                ],
                axis=2,
            )
            for part in fits
        ]
        errors = self._joint_errors(
            drawn, options, self.shade(projected, barycentric).transpose(0, 2, 1), used
        )
        if nodes is not None:
            errors *= self.margin
        return {"samples": samples * self.full, "options": options, "errors": errors}

    def options_at(
        self, lit: Projected, whole: np.ndarray, points: np.ndarray, used: np.ndarray, wanted: float
    ) -> Options:
        """See :meth:`Shader.options_at`; channels are fitted together, for the colour that they make."""
        found = self._chunks(
            lit,
            slice(None),
            lambda part, chunk: self._fitted(part, whole[chunk], points[chunk], used[chunk]),
        )
        orders, errors = found["options"], found["errors"]
        picked = orders[..., None, None]
        samples = np.take_along_axis(found["samples"][:, None], picked, axis=3)[:, :, :, 0] / self.full
        true, words = self.shade(lit, whole).transpose(0, 2, 1), self.words(orders)
        known = np.where(errors <= wanted, words, np.inf).min(axis=1)
        hopeful = (words < known[:, None]) & (errors > wanted) & (errors <= FARTHEST * (wanted + 1))
        for option in np.flatnonzero(hopeful.any(axis=0)).tolist():
            rows = np.flatnonzero(hopeful[:, option])
            own = np.ascontiguousarray(samples[rows, option])
            errors[rows, option] = fit_together(
                self._kind,
                np.ascontiguousarray(points[rows]),
                used[rows],
                np.ascontiguousarray(orders[rows, option]),
                own,
                np.ascontiguousarray(true[rows]),
                self.ambient,
                self.diffuse,
                self.specular,
                self.full,
                STEPS,
            )
            samples[rows, option] = own
        return Options(orders, samples * self.full, errors)

    @property
    def _kind(self) -> CosineKind:
        """How loops measure the colour."""
        whole = int(self.exponent) if self.exponent == int(self.exponent) else -1
        return CosineKind(True, float(self.exponent), whole, self.measure == "max", 0, 0)

    def _options(self, errors: np.ndarray) -> np.ndarray:
        """(n, k, channels) orders to choose from, given (n, channels, orders) errors of each channel."""
        count, channels = errors.shape[:2]
        if self.combinations is not None:
            return np.broadcast_to(self.free_orders(self.combinations), (count, *self.combinations.shape))
        else:
            levels = self.full * 0.5 ** np.arange(LEVELS)
            good = errors[:, None] <= levels[:, None, None]
            good[..., -1] = True
            options = good.argmax(axis=-1)
        return self.free_orders(options.reshape(-1, channels)).reshape(options.shape)

    def _joint_errors(
        self, drawn: list[np.ndarray], options: np.ndarray, true: np.ndarray, used: np.ndarray
    ) -> np.ndarray:
        """(n, k) errors of colours; ``drawn`` are both kinds' cosines (n, lights, orders, p)."""
        facing, towards = (np.ascontiguousarray(values) for values in drawn)
        return joint_errors(
            self._kind, facing, towards, np.ascontiguousarray(options), np.ascontiguousarray(true), used,
            self.ambient, self.diffuse, self.specular, self.full,
        )  # fmt: skip

    def choose_from(self, errors: np.ndarray, options: np.ndarray, goal: np.ndarray) -> Choice:
        """See :meth:`Shader.choose_from`."""
        words = self.words(options)
        if self.measure == "max":
            # Of as many words the better; where none is good, the best.
            good = errors <= goal[..., None]
            score = np.where(good, words + errors * 1e-6, 1e6 * (1 + errors))
        else:
            score = errors + goal[..., None] * words
        best = score.argmin(axis=-1)[..., None]
        words = np.broadcast_to(words, errors.shape)
        options = np.broadcast_to(options, (*errors.shape, len(self.place)))
        orders = np.take_along_axis(options, best[..., None], axis=-2)[..., 0, :]
        left, spent = (np.take_along_axis(values, best, axis=-1)[..., 0] for values in (errors, words))
        return Choice(orders, left, spent)

    def choose(self, assessed: Assessed, goal: np.ndarray) -> Choice:
        """See :meth:`Shader.choose`."""
        return self.choose_from(assessed.errors, assessed.options, goal)


class LightShader(CosineShader):
    """For each light its diffuse and its specular part: two channels where colours are three."""

    shading = "quadratic-lights"
    power = False
