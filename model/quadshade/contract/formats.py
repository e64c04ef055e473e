# SPDX-License-Identifier: Apache-2.0
"""
Every number format and the set-up packet's layout: the one source.

``scripts/generate_vhdl`` writes ``rtl/generated/quadshade_pkg.vhd`` from this module. A width is given as an
expression over the names of :class:`Formats`, written so that it means the same in Python and in VHDL.
The words used here are defined in ``docs/reference/glossary.md``.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, fields, replace
from functools import cached_property, lru_cache
from numbers import Integral
from typing import NamedTuple

from quadshade.contract.width_expressions import DerivedWidth, evaluate
from quadshade.errors import QuadshadeError

SETUP_WORD_BITS = 32
"""The set-up stream is a row of 32-bit set-up words; a beat carries ``stream_width / 32`` of them."""

CONSTANT, LINEAR, QUADRATIC = 0, 1, 2
ORDER_NAMES = ("constant", "linear", "quadratic")

DIFFERENCES = ("value", "d_row", "d_col", "dd_row", "dd_mixed", "dd_col")
"""
What is sent for a channel, in this order: its value and the forward differences of it on the pixel grid,
where a *row* step goes one scanline down and ``major.step`` pixels along. Each is a word of ``word_width``
bits:

``value``     I at the first pixel
``d_row``     I(u + s, y + 1) - I(u, y)
``d_col``     I(u, y) - I(u - 1, y), the step that *led to* the first pixel
``dd_row``    second difference, row-row
``dd_mixed``  second difference, row-column
``dd_col``    second difference, column-column
"""

DIFFERENCES_OF_ORDER = (1, 3, 6)
"""How many of :data:`DIFFERENCES` a channel of order constant, linear, quadratic needs."""

FACTOR_BITS = 18
"""Operands of the shade unit's multipliers, those of the FPGAs' own: a lane's value, a coefficient."""

COEFFICIENT_FRAC_BITS = 16
"""Fraction of a coefficient of the shade unit, of its products once cut, and of the ambient colour."""

POWER_BITS = 16
"""A value in a power table; two of them make a word of the table, 32 bits."""

POWER_MANTISSA_BITS = 5
"""Bits of a power table's index below the leading one."""

POWER_STAGES = 8
"""Stages from a cosine to its power."""

TABLE_WORDS = 1 << (POWER_MANTISSA_BITS + 4)
"""Words of a power table, a block RAM: 32 for each octave of 18 bits, and those that are left."""

STATE_REGISTERS = 8 * TABLE_WORDS
"""Address of the shade unit's first register; the power tables are below (``setup/shade_state.py``)."""

AMBIENT_ROW = 8
"""Row of four registers that holds the ambient colour and the masks; those before are the channels'."""

SHADED_COLOURS = 3


class BitField(NamedTuple):
    """A bit field of the set-up packet; its width is an expression over the names of :class:`Formats`."""

    name: str
    width: str
    meaning: str


HEADER_FIELDS = (
    BitField("has_second", "1", "the minor side changes its edge at the middle vertex"),
    BitField("mirror", "1", "the major edge is on the right: x is the bitwise NOT of u"),
    BitField(
        "fractional",
        "1",
        "colour steps at the fractional edge (Abbas et al., section 5), not at pixel centres",
    ),
    BitField("orders", "2 * carried_channels", "order of each channel, two bits each, channel 0 lowest"),
    BitField("y", "coord_bits", "first scanline"),
    BitField("rows_first", "column_bits", "scanlines along the first minor edge, minus 2, two's complement"),
    BitField("rows_second", "column_bits", "scanlines along the second minor edge, minus 2"),
)

EDGE_FIELDS = (
    BitField("column", "column_bits", "u at the first scanline"),
    BitField("error", "error_bits", "e + increment - height at the first scanline: its sign says no carry"),
    BitField("step", "column_bits", "dx div height: whole pixels a scanline"),
    BitField("increment", "edge_bits", "dx mod height"),
    BitField("decrement", "error_bits", "increment - height"),
)

EDGES = ("major", "minor", "second")

SECTIONS = (
    (
        "edge",
        HEADER_FIELDS
        + tuple(BitField(f"{e}_{n}", w, d) for e in ("major", "minor") for n, w, d in EDGE_FIELDS),
    ),
    ("second", tuple(BitField(f"second_{n}", w, d) for n, w, d in EDGE_FIELDS)),
)
"""Sections of bit fields, least significant bit first; each starts on a beat of its own."""

GENERIC_HELP = {
    "num_channels": "colour channels, 1 to 8",
    "max_order": "highest order the channels are built for: 0 constant, 1 linear, 2 quadratic",
    "with_depth": "1: a linear depth channel is built",
    "word_width": "bits of a channel's registers and words, 12 to 60",
    "frac_bits": "fraction bits of a colour word",
    "value_bits": "bits of an emitted colour value",
    "depth_bits": "bits of an emitted depth value",
    "subpixel_bits": "fraction bits of a vertex coordinate, 0 to 12",
    "coord_bits": "screen coordinates are 0 .. 2**coord_bits - 1",
    "stream_width": "bits of the set-up stream: 32, 64 or 128",
    "span_depth": "spans held between edge walker and span walker, 1 to 16",
    "with_shade": "1: diffuse and specular channels become a colour behind the core",
    "num_specular": "with shade: how many of the channels, the last ones, are raised to a power",
    "shade_guard_bits": "with shade: bits that channels carry below value_bits",
}

SHADE_GENERICS = ("with_shade", "num_specular", "shade_guard_bits")
"""Generics of what follows the rasteriser core; it has all others."""


class GenericRange(NamedTuple):
    """Allowed values of a generic, both included; the range holds where ``condition`` is not 0."""

    name: str
    lowest: str
    highest: str
    condition: str


GENERIC_RANGES = (
    GenericRange("num_channels", "1", "8", "1"),
    GenericRange("max_order", "0", "2", "1"),
    GenericRange("with_depth", "0", "1", "1"),
    GenericRange("word_width", "12", "60", "1"),
    GenericRange("value_bits", "1", "18", "1"),
    GenericRange("depth_bits", "1", "31", "1"),
    GenericRange("subpixel_bits", "0", "12", "1"),
    GenericRange("coord_bits", "3", "13", "1"),
    GenericRange("span_depth", "1", "16", "1"),
    # A quadratic through six values in [0, 1] stays within [-1/3, 4/3]: the sign and one more bit.
    GenericRange("frac_bits", "0", "word_width - value_bits - 2", "1"),
    GenericRange("depth_bits", "1", "word_width - 2", "with_depth"),
    GenericRange("with_shade", "0", "1", "1"),
    GenericRange("num_specular", "1", "num_channels", "with_shade"),
    GenericRange("value_bits", "4", "14", "with_shade"),
    # What a lane emits is an operand of a multiplier; a power table's index has 5 bits below its first.
    GenericRange("shade_guard_bits", "4", f"{FACTOR_BITS} - value_bits", "with_shade"),
    GenericRange("frac_bits", "shade_guard_bits", "word_width - value_bits - 2", "with_shade"),
)
"""Every range of every generic; all that hold have to be met."""

GENERIC_CHOICES = (("stream_width", (32, 64, 128)),)
"""Generics with a few allowed values: name and values."""


@dataclass(frozen=True)
class Formats:
    """
    The generics of the core, under their VHDL names, with their defaults, and what follows from them.

    Raises
    ------
    QuadshadeError
      From :meth:`check`, which every public entry point calls: a value outside its range.
    """

    num_channels: int = 3
    max_order: int = QUADRATIC
    with_depth: int = 1
    word_width: int = 32
    frac_bits: int = 22
    value_bits: int = 8
    depth_bits: int = 16
    subpixel_bits: int = 8
    coord_bits: int = 12
    stream_width: int = 32
    span_depth: int = 2
    with_shade: int = 0
    num_specular: int = 1
    shade_guard_bits: int = 10

    carried_channels = DerivedWidth("num_channels + with_depth", "colour channels and, last, depth")
    column_bits = DerivedWidth("coord_bits + 1", "a column is 0 .. 2**coord_bits, both included")
    edge_bits = DerivedWidth(
        "coord_bits + subpixel_bits + 2", "an edge's height: the guard band is 3 screens high"
    )
    error_bits = DerivedWidth("edge_bits + 1", "the DDA's error lies in -height .. height - 1")
    depth_frac_bits = DerivedWidth(
        "word_width - depth_bits - 2", "one bit of overshoot and the sign stay free"
    )
    beat_words = DerivedWidth("stream_width / 32", "set-up words of a beat")
    difference_words = DerivedWidth("(word_width + 31) / 32", "set-up words of one difference")
    lane_value_bits = DerivedWidth(
        "value_bits + with_shade * shade_guard_bits", "what a colour channel's lane emits"
    )
    lane_frac_bits = DerivedWidth(
        "frac_bits - with_shade * shade_guard_bits",
        "fraction below what a lane emits: the same word, cut lower",
    )
    emitted_channels = DerivedWidth(
        f"num_channels * (1 - with_shade) + {SHADED_COLOURS} * with_shade", "colours of a pixel"
    )
    sum_levels = DerivedWidth(
        "(num_channels + 6) / 8 + (num_channels + 5) / 8 + (num_channels + 3) / 8",
        "of the tree that adds up to 8 channels: the binary logarithm, rounded up",
    )
    shade_stages = DerivedWidth(
        f"({POWER_STAGES} + 4 + sum_levels) * with_shade",
        "power, operand, product, sums, ambient, clamp; the output's registers come behind",
    )

    def __post_init__(self) -> None:
        self.check()

    @cached_property
    def _hash(self) -> int:
        return hash(tuple(self.generics().values()))

    def __hash__(self) -> int:
        return self._hash

    def check(self) -> None:
        """Raise :class:`QuadshadeError` naming the first generic that is out of range."""
        for name, value in self.generics().items():
            if not isinstance(value, Integral):
                raise QuadshadeError(f"generic {name} is {value!r}", "give a whole number")
        _check_ranges(self)

    def evaluate(self, expression: str) -> int:
        """Value of a width expression over these names (:func:`.width_expressions.evaluate`)."""
        return evaluate(expression, self)

    def with_generics(self, settings: dict[str, int]) -> Formats:
        """
        A copy with some generics replaced.

        Raises
        ------
        QuadshadeError
          A name that is not a generic, or a value out of range.
        """
        return _with_generics(self, tuple(settings.items()))

    def generics(self) -> dict[str, int]:
        """All generics by VHDL name."""
        return {f.name: getattr(self, f.name) for f in fields(self)}

    @cached_property
    def core(self) -> Formats:
        """Formats of the rasteriser core within: with shade its lanes emit more bits of the same values."""
        plain = {name: getattr(Formats, name) for name in SHADE_GENERICS}
        return replace(self, value_bits=self.lane_value_bits, frac_bits=self.lane_frac_bits, **plain)

    def core_generics(self) -> dict[str, int]:
        """Generics of the rasteriser core alone by VHDL name."""
        return {name: value for name, value in self.generics().items() if name not in SHADE_GENERICS}

    def section(self, name: str) -> dict[str, tuple[int, int]]:
        """Bit offset and width of every field of a section."""
        return self._sections[name].copy()

    @cached_property
    def _sections(self) -> dict[str, dict[str, tuple[int, int]]]:
        """All of :meth:`section`, found out once."""
        tables: dict[str, dict[str, tuple[int, int]]] = {}
        for name, section in SECTIONS:
            offset, table = 0, tables.setdefault(name, {})
            for field, width, _ in section:
                table[field] = (offset, self.evaluate(width))
                offset += table[field][1]
        return tables

    def section_bits(self, name: str) -> int:
        """Bits of a section, without padding."""
        return sum(width for _, width in self._sections[name].values())

    def section_beats(self, name: str) -> int:
        """Beats of a section."""
        return -(-self.section_bits(name) // self.stream_width)

    @cached_property
    def channel_groups(self) -> tuple[tuple[int, ...], ...]:
        """
        Channels that share a beat, group by group; a group sends its differences in order, a beat each.

        A difference of more set-up words than a beat has makes a group of one channel, whose differences take
        several beats each.
        """
        per_beat = max(1, self.beat_words // self.difference_words)
        channels = range(self.carried_channels)
        return tuple(tuple(channels[i : i + per_beat]) for i in range(0, self.carried_channels, per_beat))

    @property
    def difference_beats(self) -> int:
        """Beats of one difference of one group."""
        return -(-self.difference_words // self.beat_words)

    @property
    def channel_frac_bits(self) -> tuple[int, ...]:
        """Fraction bits of every carried channel's differences (depth last)."""
        return (self.frac_bits,) * self.num_channels + (self.depth_frac_bits,) * self.with_depth

    @property
    def channel_value_bits(self) -> tuple[int, ...]:
        """Bits of a value of every carried channel (depth last), without those that shade keeps below."""
        return (self.value_bits,) * self.num_channels + (self.depth_bits,) * self.with_depth

    @property
    def channel_max_order(self) -> tuple[int, ...]:
        """Highest order of every carried channel (depth is at most linear)."""
        return (self.max_order,) * self.num_channels + (LINEAR,) * self.with_depth

    @property
    def guard_band(self) -> tuple[int, int]:
        """Lowest and highest vertex coordinate in sub-pixels, both allowed."""
        size = 1 << (self.coord_bits + self.subpixel_bits)
        return -size, 2 * size - 1


@lru_cache
def _check_ranges(formats: Formats) -> None:
    """See :meth:`Formats.check`: the same generics are in range the next time too."""
    for name, values in GENERIC_CHOICES:
        got = getattr(formats, name)
        if got not in values:
            raise QuadshadeError(f"generic {name} is {got}", f"give one of {', '.join(map(str, values))}")
    for name, lowest, highest, condition in GENERIC_RANGES:
        got, low, high = getattr(formats, name), formats.evaluate(lowest), formats.evaluate(highest)
        if formats.evaluate(condition) and not low <= got <= high:
            limit = highest if highest.isdecimal() else f"{highest} = {high}"
            raise QuadshadeError(f"generic {name} is {got}", f"give a value from {low} to {limit}")


@lru_cache
def _with_generics(formats: Formats, settings: tuple[tuple[str, int], ...]) -> Formats:
    """See :meth:`Formats.with_generics`: the same object for the same settings, which knows what follows."""
    known = [f.name for f in fields(formats)]
    for name, _ in settings:
        if name not in known:
            raise QuadshadeError(f"the core has no generic {name!r}", f"the generics are {', '.join(known)}")
    return replace(formats, **dict(settings))


DERIVED = tuple(
    (name, width.expression, width.meaning)
    for name, width in vars(Formats).items()
    if isinstance(width, DerivedWidth)
)
"""Derived widths, in the order of :class:`Formats`: name, expression, meaning."""


def parse_generics(values: Iterable[str]) -> dict[str, int]:
    """
    Values of ``--generic`` as a dictionary for :meth:`Formats.with_generics`.

    Parameters
    ----------
    values : iterable of str
      ``name=value``, the value a decimal integer.

    Returns
    -------
    dict of str to int

    Raises
    ------
    QuadshadeError
      No ``=``, a value that is no integer, or a name given twice. Whether the core has such a generic is
      checked by ``with_generics``.
    """
    settings: dict[str, int] = {}
    for text in values:
        name, equals, value = text.partition("=")
        name = name.strip().lower()
        if not equals or not name:
            raise QuadshadeError(
                f"--generic {text!r} is not name=value", "write for example stream_width=128"
            )
        if name in settings:
            raise QuadshadeError(f"generic {name} is given twice", "give it once")
        if not re.fullmatch(r"\s*[+-]?[0-9]{1,18}\s*", value):
            raise QuadshadeError(f"generic {name} is {value[:40]!r}", "give a whole number")
        settings[name] = int(value)
    return settings
