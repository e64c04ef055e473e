# SPDX-License-Identifier: Apache-2.0
"""A point of a sweep: what is chosen, and the generics that this asks of the core."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from quadshade.errors import QuadshadeError
from quadshade.formats import ORDER_NAMES, Formats
from quadshade.shading import SHADING_ORDERS
from quadshade.trade.subdivision import check_subdivision

HEADROOM_BITS = 2
"""Bits of a word above the value: the sign, and one for the overshoot of a quadratic."""

SHADINGS = tuple(SHADING_ORDERS)
FRACTIONS = (8, 10, 12, 16, 22)
SUBDIVISIONS = ("none", "all:1", "all:2", "highlights:128", "centre:2")


@dataclass(frozen=True)
class Point:
    """
    One choice.

    Attributes
    ----------
    shading : str
      One of ``SHADINGS``: what is interpolated, and in which order.
    fraction : int
      Fraction bits of a colour word; the word is as wide as it has to be for them.
    subdivision : str
      See :mod:`quadshade.trade.subdivision`.
    """

    shading: str
    fraction: int
    subdivision: str

    @property
    def name(self) -> str:
        """A name for files."""
        return f"{self.shading}-{self.fraction}-{self.subdivision.replace(':', '')}"

    @property
    def order(self) -> str:
        """Order of the colour channels."""
        return ORDER_NAMES[SHADING_ORDERS[self.shading]]

    def formats(self, base: Formats) -> Formats:
        """
        The smallest core for this point.

        Parameters
        ----------
        base : Formats
          All other generics.

        Returns
        -------
        Formats
          ``max_order`` is what the shading needs, ``word_width`` what the fraction and the value need.

        Raises
        ------
        QuadshadeError
          The fraction is out of range.
        """
        return base.with_generics(
            {
                "max_order": SHADING_ORDERS[self.shading],
                "frac_bits": self.fraction,
                "word_width": self.fraction + base.value_bits + HEADROOM_BITS,
            }
        )


@dataclass(frozen=True)
class Grid:
    """
    All points of a sweep: every combination of three axes.

    Attributes
    ----------
    fractions : tuple of int
    shadings, subdivisions : tuple of str

    Raises
    ------
    QuadshadeError
      An axis without values, or with a value twice, or with one that there is not.
    """

    fractions: tuple[int, ...] = FRACTIONS
    shadings: tuple[str, ...] = SHADINGS
    subdivisions: tuple[str, ...] = SUBDIVISIONS

    def __post_init__(self) -> None:
        for name in ("fractions", "shadings", "subdivisions"):
            values = getattr(self, name)
            if not values or len(set(values)) != len(values):
                raise QuadshadeError(f"the {name} are {values}", "give at least one, and each once")
        for shading in self.shadings:
            if shading not in SHADINGS:
                raise QuadshadeError(f"the shading is {shading!r}", f"give some of {', '.join(SHADINGS)}")
        for subdivision in self.subdivisions:
            check_subdivision(subdivision)

    def __iter__(self) -> Iterator[Point]:
        for subdivision in self.subdivisions:
            for shading in self.shadings:
                for fraction in self.fractions:
                    yield Point(shading, fraction, subdivision)

    def __len__(self) -> int:
        return len(self.fractions) * len(self.shadings) * len(self.subdivisions)
