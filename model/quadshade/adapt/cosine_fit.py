# SPDX-License-Identifier: Apache-2.0
"""Polynomials nearest to cosines, by what they leave in the colour."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from quadshade.adapt.cosine_loops import CosineKind, best_cosines, half_cosines
from quadshade.adapt.polynomial_fit import EQUALISING, HALF_COUNTS, HALF_POINTS, SHAPES, Fit

DARK = 0.02
"""Weight of a point in the dark, where a diffuse cosine only has to be negative."""
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

    @property
    def extra(self) -> np.ndarray:
        """(n, lights, p) see :func:`quadshade.adapt.cosine_loops.best_cosines`."""
        raise NotImplementedError

    def kind(self, measure: str) -> CosineKind:
        """How the loops measure it."""
        return CosineKind(False, 1.0, 1, measure == "max", SECANTS, EQUALISING)

    def levels(self, measure: str) -> np.ndarray | None:
        """(n, lights, 1) the best constant, where it is not the nearest one."""
        return None

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
        others = [through, self.levels(measure) if shape.shape[-1] == 1 else None]
        given = [samples for samples in others if samples is not None]
        tried = np.stack(given) if given else np.empty((0, *self.value.shape[:2], shape.shape[-1]))
        arrays = self.value, self.weight, self.used, self.extra
        value, weight, used, extra = (np.ascontiguousarray(values) for values in arrays)
        fitted = best_cosines(
            self.kind(measure), np.ascontiguousarray(shape), value, weight, used,
            extra.astype(np.float64), np.ascontiguousarray(self.scale[:, 0]), tried,
        )  # fmt: skip
        return Fit(*fitted)

    def halves(self, order: int, measure: str) -> np.ndarray:
        """(n, 3, 2, lights) what polynomials nearest by the weights leave of the grid's halves."""
        arrays = self.value, self.weight, self.used, self.extra
        value, weight, used, extra = (np.ascontiguousarray(values) for values in arrays)
        left = half_cosines(
            self.kind(measure), SHAPES[order], value, weight, used, extra.astype(np.float64),
            np.ascontiguousarray(self.scale[:, 0]), HALF_POINTS, HALF_COUNTS,
        )  # fmt: skip
        return left[measure != "max"].reshape(len(value), 3, 2, -1)


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

    @property
    def extra(self) -> np.ndarray:
        """See :attr:`CosineChannel.extra`."""
        return self.shine


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

    @property
    def extra(self) -> np.ndarray:
        """See :attr:`CosineChannel.extra`."""
        return self.lit

    def kind(self, measure: str) -> CosineKind:
        """See :meth:`CosineChannel.kind`."""
        whole = int(self.exponent) if self.exponent == int(self.exponent) else -1
        return CosineKind(True, self.exponent, whole, measure == "max", SECANTS, EQUALISING)

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
