# SPDX-License-Identifier: Apache-2.0
"""A point of a sweep: what is chosen, and the generics that this asks of the core."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

from quadshade.choices import (
    DEFAULT_SHADING,
    FITS,
    SHADING_ORDERS,
    SPECULAR_ORDERS,
    check_word,
    parse_lod,
)
from quadshade.contract.formats import ORDER_NAMES, QUADRATIC, Formats
from quadshade.errors import QuadshadeError
from quadshade.trade.subdivision import WHOLE, check_subdivision

HEADROOM_BITS = 2
"""Bits of a word above the value: the sign, and one for the overshoot of a quadratic."""

ORDERS = SHADING_ORDERS | SPECULAR_ORDERS
SHADINGS = tuple(ORDERS)
ADAPTIVE = "adaptive"
ALL = "all"
"""The level of detail with all triangles."""
ADAPTIVE_RANGE = (0.3, 100.0)
"""Grey levels of rms error that may be allowed; the rounding of the output alone is 0.29."""
USUAL_SHADINGS = (*SHADING_ORDERS, "quadratic-specular")
DEFAULT_SHADINGS = (*USUAL_SHADINGS, "adaptive:1", "adaptive:0.5")
FRACTIONS = (8, 10, 12, 16, 22)
SUBDIVISIONS = ("none", "all:1", "all:2", "highlights:128", "centre:2")


@dataclass(frozen=True)
class Point:
    """
    One choice.

    Attributes
    ----------
    shading : str
      One of ``SHADINGS``: what is interpolated, and in which order. Or ``adaptive:E``: for every triangle the
      cheapest order, or division, so that the rms error is at most E grey levels (:mod:`quadshade.adapt`).
    fraction : int
      Fraction bits of a colour word; the word is as wide as it has to be for them.
    subdivision : str
      See :mod:`quadshade.trade.subdivision`.
    lod : str
      ``all`` triangles of the mesh, or a number of them at most (:mod:`quadshade.scene.detail`).
    fit : str
      Of quadratic colours (:mod:`quadshade.fit`).
    """

    shading: str
    fraction: int
    subdivision: str
    lod: str = ALL
    fit: str = FITS[0]

    @property
    def name(self) -> str:
        """A name for files."""
        parts = [self.shading, str(self.fraction), self.subdivision]
        parts += [f"lod{self.lod}"] * (self.lod != ALL) + [self.fit] * (self.fit != FITS[0])
        return "-".join(parts).replace(":", "")

    @property
    def stage(self) -> tuple[str, str]:
        """What its triangles depend on."""
        return self.subdivision, self.lod

    @property
    def allowed(self) -> float | None:
        """The error that an adaptive point is allowed; None for others."""
        name, _, number = self.shading.partition(":")
        return float(number) if name == ADAPTIVE else None

    @property
    def order(self) -> str:
        """Highest order of the colour channels."""
        return ORDER_NAMES[self.max_order]

    @property
    def max_order(self) -> int:
        """The same as a number, the generic of the core."""
        return ORDERS.get(self.shading, QUADRATIC)

    @property
    def specular(self) -> bool:
        """Cosines are interpolated, and the shade unit makes a colour of them at every pixel."""
        return self.shading in SPECULAR_ORDERS

    def formats(self, base: Formats, lights: int = 1) -> Formats:
        """
        The smallest core for this point.

        Parameters
        ----------
        base : Formats
          All other generics.
        lights : int
          How many that have a place or a direction: a pair of channels each where the shading is a specular
          one.

        Returns
        -------
        Formats
          ``max_order`` is what the shading needs, ``word_width`` what the fraction and the value need.

        Raises
        ------
        QuadshadeError
          The fraction is out of range.
        """
        generics = {
            "max_order": self.max_order,
            "frac_bits": self.fraction,
            "word_width": self.fraction + base.value_bits + HEADROOM_BITS,
        }
        if self.specular:
            generics |= {"with_shade": 1, "num_channels": 2 * lights, "num_specular": lights}
            # A guard bit is one of the fraction.
            generics["shade_guard_bits"] = min(base.shade_guard_bits, self.fraction)
        return base.with_generics(generics)


@dataclass(frozen=True)
class Grid:
    """
    All points of a sweep: every combination of five axes; what is adaptive divides by itself.

    Attributes
    ----------
    fractions : tuple of int
    shadings, subdivisions, lods, fits : tuple of str
      What is fitted are quadratic colours; other shadings are drawn once, as they are.

    Raises
    ------
    QuadshadeError
      An axis without values, or with a value twice, or with one that there is not.
    """

    fractions: tuple[int, ...] = FRACTIONS
    shadings: tuple[str, ...] = DEFAULT_SHADINGS
    subdivisions: tuple[str, ...] = SUBDIVISIONS
    lods: tuple[str, ...] = (ALL,)
    fits: tuple[str, ...] = (FITS[0],)

    def __post_init__(self) -> None:
        for name in ("fractions", "shadings", "subdivisions", "lods", "fits"):
            values = getattr(self, name)
            if not values or len(set(values)) != len(values):
                raise QuadshadeError(f"the {name} are {values}", "give at least one, and each once")
        for subdivision in self.subdivisions:
            check_subdivision(subdivision)
        for lod in self.lods:
            if lod != ALL and not isinstance(parse_lod(lod), int):
                raise QuadshadeError(
                    f"the level of detail is {lod!r}", f"give {ALL}, or numbers of triangles"
                )
        for fit in self.fits:
            check_word("fit", fit, FITS)
        for shading in self.shadings:
            _check_shading(shading)
            if shading not in SHADINGS and WHOLE not in self.subdivisions:
                raise QuadshadeError(
                    f"the shading {shading} divides by itself", "give the subdivision none too"
                )

    def __iter__(self) -> Iterator[Point]:
        for subdivision in self.subdivisions:
            for shading in self.shadings:
                if shading in SHADINGS or subdivision == WHOLE:
                    fits = self.fits if shading == DEFAULT_SHADING else FITS[:1]
                    for fraction, lod, fit in product(self.fractions, self.lods, fits):
                        yield Point(shading, fraction, subdivision, lod, fit)

    def __len__(self) -> int:
        return sum(1 for _ in self)


def _check_shading(shading: str) -> None:
    """Raise :class:`QuadshadeError` for a shading that there is not."""
    name, _, number = shading.partition(":")
    lowest, highest = ADAPTIVE_RANGE
    try:
        known = shading in SHADINGS or (name == ADAPTIVE and lowest <= float(number) <= highest)
    except ValueError:
        known = False
    if not known:
        choices = ", ".join((*SHADINGS, f"adaptive:E with E from {lowest:g} to {highest:g}"))
        raise QuadshadeError(f"the shading is {shading!r}", f"give some of {choices}")
