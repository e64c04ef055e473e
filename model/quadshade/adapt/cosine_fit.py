# SPDX-License-Identifier: Apache-2.0
"""Polynomials nearest to cosines, by what they leave in the colour."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from quadshade.adapt.polynomial_fit import EQUALISING, Fit, better_fit, equalised, weighted_fit

DARK = 0.02
"""Weight of a point in the dark, where a diffuse cosine only has to be negative."""
FAINT = 1e-4
"""Weight of a point without specular light."""
SECANTS = 2
"""Repetitions with the power's slope between the cosine and what it became."""


@dataclass(frozen=True)
class CosineChannel:
    """
    The cosines of some lights at points of triangles.

    Attributes
    ----------
    value, weight : (n, lights, p) float64
    used : (n, lights, p) bool
      Points that count.
    scale : (lights, 1) float64
      Output units for a full value.
    """

    value: np.ndarray
    weight: np.ndarray
    used: np.ndarray
    scale: np.ndarray

    def difference(self, drawn: np.ndarray) -> np.ndarray:
        """(n, lights, p) output units that drawn cosines are off by, at least 0."""
        raise NotImplementedError

    def at(self, points: np.ndarray) -> CosineChannel:
        """At some of the points."""
        return _at(self, points)

    def again(self, drawn: np.ndarray) -> np.ndarray:
        """Weights (n, lights, p) with which to fit again."""
        return self.weight

    def levels(self, measure: str) -> np.ndarray | None:
        """(n, lights, 1) the best constant, where it is not the nearest one."""
        return None

    def fit(self, samples: np.ndarray, shape: np.ndarray) -> Fit:
        """What (n, lights, m) samples are, once brought into the range that the core takes."""
        samples = np.clip(samples, -1, 1)
        rest = self.difference(samples @ np.swapaxes(shape, 1, 2)) * self.used
        padded = np.zeros((*samples.shape[:2], 6))
        padded[..., : samples.shape[2]] = samples
        return Fit(padded, rest.max(axis=-1), (rest**2).sum(axis=-1) / self.used.sum(axis=-1))

    def best(self, shape: np.ndarray, through: np.ndarray | None, measure: str) -> Fit:
        """
        The best of several polynomials of one order.

        Parameters
        ----------
        shape : (1 or n, p, m) float
        through : (n, lights, m) float or None
          Samples of the one that is not fitted.
        measure : str
        """
        first = weighted_fit(shape, self.value, self.used.astype(np.float64))
        best = self.fit(first, shape)
        for samples in (through, self.levels(measure) if shape.shape[-1] == 1 else None):
            if samples is not None:
                best = better_fit(best, self.fit(samples, shape), measure)
        weights = self.weight
        for step in range(1 + SECANTS):
            samples = np.clip(weighted_fit(shape, self.value, weights), -1, 1)
            best = better_fit(best, self.fit(samples, shape), measure)
            if step < SECANTS:
                weights = self.again(samples @ np.swapaxes(shape, 1, 2))
        if measure == "max" and shape.shape[-1] > 1:
            for _ in range(EQUALISING):
                rest = self.difference(samples @ np.swapaxes(shape, 1, 2)) * self.used
                weights = equalised(weights, rest)
                samples = np.clip(weighted_fit(shape, self.value, weights), -1, 1)
                best = better_fit(best, self.fit(samples, shape), measure)
        return best


@dataclass(frozen=True)
class Diffuse(CosineChannel):
    """
    Cosines that count where they are positive.

    Attributes
    ----------
    shine : (n, lights, p) float64
      Output units of the specular term, which appears or vanishes with the cosine's sign.
    """

    shine: np.ndarray

    def difference(self, drawn: np.ndarray) -> np.ndarray:
        """See :meth:`CosineChannel.difference`."""
        off = abs(np.maximum(drawn, 0) - np.maximum(self.value, 0)) * self.scale
        return off + ((drawn > 0) != (self.value > 0)) * self.shine

    def at(self, points: np.ndarray) -> Diffuse:
        """At some of the points."""
        return _at(replace(self, shine=self.shine[..., points]), points)


@dataclass(frozen=True)
class Specular(CosineChannel):
    """
    Cosines that are raised to a power.

    Attributes
    ----------
    lit : (n, lights, p) bool
    exponent : float
    """

    lit: np.ndarray
    exponent: float

    @property
    def slope(self) -> np.ndarray:
        """(n, lights, p) of the power, 0 where it does not count."""
        return self.lit * self.exponent * np.clip(self.value, 0, 1) ** (self.exponent - 1)

    def power(self, cosine: np.ndarray) -> np.ndarray:
        """What the table makes of a cosine."""
        return np.clip(cosine, 0, 1) ** self.exponent

    def difference(self, drawn: np.ndarray) -> np.ndarray:
        """See :meth:`CosineChannel.difference`."""
        return abs(self.power(drawn) - self.power(self.value)) * self.lit * self.scale

    def again(self, drawn: np.ndarray) -> np.ndarray:
        """See :meth:`CosineChannel.again`."""
        step = abs(drawn - self.value)
        rise = abs(self.power(drawn) - self.power(self.value))
        slope = np.where(step > 1e-9, rise / np.maximum(step, 1e-9), self.weight * self.exponent)
        return self.used * (self.lit * slope / self.exponent + FAINT)

    def levels(self, measure: str) -> np.ndarray:
        """See :meth:`CosineChannel.levels`."""
        shine, counts = self.power(self.value), self.lit & self.used
        if measure == "max":
            high = np.where(counts, shine, 0).max(axis=-1, keepdims=True)
            level = (high + np.minimum(np.where(counts, shine, 1).min(axis=-1, keepdims=True), high)) / 2
        else:
            total = counts.sum(axis=-1, keepdims=True)
            level = np.where(counts, shine, 0).sum(axis=-1, keepdims=True) / np.maximum(total, 1)
        return level ** (1 / self.exponent)

    def at(self, points: np.ndarray) -> Specular:
        """At some of the points."""
        return _at(replace(self, lit=self.lit[..., points]), points)


Channel = TypeVar("Channel", bound=CosineChannel)


def _at(channel: Channel, points: np.ndarray) -> Channel:
    return replace(
        channel,
        value=channel.value[..., points],
        weight=channel.weight[..., points],
        used=channel.used[..., points],
    )
