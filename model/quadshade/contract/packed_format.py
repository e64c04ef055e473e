# SPDX-License-Identifier: Apache-2.0
"""
Layout of packed packets: kinds of fields, kinds of channels, and the addresses of their widths.

The one source: ``scripts/generate_vhdl`` writes ``rtl/generated/packed_pkg.vhd`` from this module and
:mod:`quadshade.contract.formats`; ``docs/reference/packing.md`` explains it.
"""

from __future__ import annotations

from functools import lru_cache

from quadshade.contract.formats import HEADER_FIELDS, SECTIONS, Formats

FILLS = ("zero", "one", "sign")
"""What stands above the bits of a field that are sent: 0, 1, or the highest of them."""

RAW_FIELDS = tuple(name for name, _, _ in HEADER_FIELDS[:3])
"""Fields of one bit that begin a packet as they are."""

FIELD_KINDS = (
    ("y", "zero"),
    ("rows", "sign"),
    ("column", "sign"),
    ("error", "sign"),
    ("step", "sign"),
    ("increment", "zero"),
    ("decrement", "one"),
)
"""Kinds of fields, one width for each: name, fill. Both counts of rows, and all edges, share theirs."""

CHANNEL_KINDS = ("colour", "depth", "specular")
"""Kinds of channels, whose differences share widths: diffuse channels are colours."""

KIND_WIDTHS = 16
"""Addresses for a kind of channel: of difference d, 2 d the bits below, 2 d + 1 the highest bit sent."""

FIELD_WIDTHS = 24
"""Address of the first kind of fields' width, the highest bit sent: behind those of depth's three
differences."""

SIZES = (
    ("width_bits", "4 + difference_words", "of a width: the number of a bit, from 0"),
    ("width_address_bits", "5 + with_shade", "of the address of a width: specular channels' lie behind"),
)
"""Sizes that depend on the formats: name, expression over their names, why."""


@lru_cache
def size_of(name: str, formats: Formats) -> int:
    """One of :data:`SIZES`."""
    return formats.evaluate({size: expression for size, expression, _ in SIZES}[name])


def kind_of(field: str) -> str:
    """Kind of a packet's field: that of its edge's part, and one for both counts of rows."""
    return field.split("_")[0 if field.startswith("rows") else -1]


def field_bits() -> dict[str, str]:
    """Bits of a field of every kind, as expressions."""
    widths = {kind_of(name): width for _, section in SECTIONS for name, width, _ in section}
    return {kind: widths[kind] for kind, _ in FIELD_KINDS}


@lru_cache
def packed_fields(formats: Formats) -> tuple[tuple[str, int, int, str], ...]:
    """Fields of both sections from ``y`` on, in order: name, bits, address of its width, fill."""
    kinds = {kind: (FIELD_WIDTHS + index, fill) for index, (kind, fill) in enumerate(FIELD_KINDS)}
    return tuple(
        (name, width, *kinds[kind_of(name)])
        for section, _ in SECTIONS
        for name, (_, width) in formats.section(section).items()
        if kind_of(name) in kinds
    )


@lru_cache
def second_at(formats: Formats) -> int:
    """Index of the second section's first field among :func:`packed_fields`."""
    return len(packed_fields(formats)) - len(dict(SECTIONS)["second"])


@lru_cache
def channel_kinds(formats: Formats) -> tuple[int, ...]:
    """Index in :data:`CHANNEL_KINDS` of every carried channel (depth last)."""
    specular = formats.num_specular * formats.with_shade
    colours = (CHANNEL_KINDS.index("colour"),) * (formats.num_channels - specular)
    return (
        *colours,
        *(CHANNEL_KINDS.index("specular"),) * specular,
        *(CHANNEL_KINDS.index("depth"),) * formats.with_depth,
    )
