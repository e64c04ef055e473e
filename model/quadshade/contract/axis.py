# SPDX-License-Identifier: Apache-2.0
"""
The AXI ports of ``quadshade_axis``: a pixel's fields in ``tdata``, and the registers behind AXI4-Lite.

``scripts/generate_vhdl`` writes ``rtl/generated/axis_pkg.vhd`` and the tables of ``docs/reference/axis.md``
from this module.
"""

from __future__ import annotations

from dataclasses import fields
from typing import NamedTuple

from quadshade.contract.formats import BitField, Formats

AXI_DATA_BITS = 32
"""Of AXI4-Lite; a register is a word."""

AXI_ADDRESS_BITS = 16

REGISTERS_FIRST = 1 << (AXI_ADDRESS_BITS - 1)
"""Byte address of the first register. Below it lies the shade unit: byte address 4 a writes its word a."""

IDENTITY = int.from_bytes(b"QSHD", "little")

PIXEL_FIELDS = (
    BitField("x", "16", "column, 0 on the left"),
    BitField("y", "16", "scanline, 0 at the top"),
    BitField("depth", "(depth_bits + 7) / 8 * 8", "0 is near; 0 where the core has no depth"),
    BitField(
        "value",
        "emitted_channels * ((value_bits + 7) / 8 * 8)",
        "the channels, 0 or red lowest, each in whole bytes",
    ),
)
"""Fields of ``m_axis_pixel_tdata``, the lowest first, each in whole bytes, zeros above its value."""


class Register(NamedTuple):
    """A register of 32 bits that is read; ``offset`` is in bytes from ``REGISTERS_FIRST``."""

    name: str
    offset: int
    meaning: str


GENERICS_FIRST = 64

REGISTERS = (
    Register("identity", 0, 'the bytes "QSHD"'),
    Register(
        "status", 4, "bit 0: idle, as the core's port; a packet that is begun and not whole is not idle"
    ),
    Register("primitives", 8, "primitives whose last pixel was taken since reset, modulo 2**32"),
    Register("pixels", 12, "pixels taken since reset, modulo 2**32"),
    Register("cut_packets", 16, "packets dropped since reset, amid which `tlast` came, modulo 2**32"),
    *(
        Register(f"generic_{one.name}", GENERICS_FIRST + 4 * index, f"the core's generic `{one.name}`")
        for index, one in enumerate(fields(Formats))
    ),
)


def pixel_places(formats: Formats) -> dict[str, tuple[int, int]]:
    """First bit and bits of every field of a pixel's ``tdata``."""
    places, low = {}, 0
    for name, width, _ in PIXEL_FIELDS:
        places[name] = (low, formats.evaluate(width))
        low += places[name][1]
    return places


def pixel_bytes(formats: Formats) -> int:
    """Bytes of ``tdata`` that hold fields: those whose ``tkeep`` is 1."""
    return sum(bits for _, bits in pixel_places(formats).values()) // 8


def pixel_data_bytes(formats: Formats) -> int:
    """Bytes of ``tdata``: the next power of two, which width converters and DMA units take."""
    return 1 << (pixel_bytes(formats) - 1).bit_length()
