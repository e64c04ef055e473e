# SPDX-License-Identifier: Apache-2.0
"""A packed picture as text."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from itertools import islice

from quadshade.contract.formats import DIFFERENCES, DIFFERENCES_OF_ORDER, EDGES, ORDER_NAMES, Formats
from quadshade.contract.packed_format import (
    CHANNEL_KINDS,
    FIELD_KINDS,
    FIELD_WIDTHS,
    KIND_WIDTHS,
    packed_fields,
)
from quadshade.golden.core.setup_loader import Packet, load_packets
from quadshade.golden.link.vertex_unpacker import VertexUnpacker
from quadshade.golden.link.word_unpacker import WordUnpacker
from quadshade.packing.frame_file import FrameFile


def summary_lines(frame: FrameFile, name: str) -> Iterator[str]:
    """What holds for the whole picture."""
    drawn, line = max(1, frame.triangles), frame.line_bytes()
    yield f"{name}: {frame.width}x{frame.height}, {frame.triangles} triangles in {frame.packets} packets"
    yield (
        f"packed: {4 * len(frame.words)} bytes, {line} on the line, {line / drawn:.1f} a triangle;"
        f" as set-up words {4 * len(frame.set_up_words())}"
    )
    yield f"definition: {frame.definition:08x}"
    yield "generics: " + " ".join(f"{name}={value}" for name, value in frame.formats.generics().items())
    yield f"clear: {frame.clear_colour:08x}"
    yield f"crc: picture {frame.crc:08x}" + (
        f", depth {frame.depth_crc:08x}" if frame.formats.with_depth else ""
    )
    for address, words in frame.state:
        yield f"state: {len(words)} words from address {address} on"


def _signed(value: int, bits: int) -> int:
    """Two's complement."""
    return value - (1 << bits) if value >> (bits - 1) else value


def _field_text(packet: Packet, formats: Formats) -> Iterator[str]:
    """The fields of a packet, in a line for each edge."""
    fields = packet.fields
    bits = {name: (width, fill) for name, width, _, fill in packed_fields(formats)}
    numbers = {
        name: fields[name] if fill == "zero" else _signed(fields[name], width)
        for name, (width, fill) in bits.items()
    }
    rows = [numbers["rows_first"] + 2] + [numbers["rows_second"] + 2] * fields["has_second"]
    flags = [name for name in ("mirror", "fractional") if fields[name]]
    yield ", ".join([f"  y {numbers['y']}", f"rows {' + '.join(map(str, rows))}", *flags])
    parts = [kind for kind, _ in FIELD_KINDS if f"major_{kind}" in numbers]
    for edge in EDGES[: 2 + fields["has_second"]]:
        yield f"  {edge}: " + ", ".join(f"{part} {numbers[f'{edge}_{part}']}" for part in parts)


def _word_text(packet: Packet, formats: Formats) -> Iterator[str]:
    """The words of a packet, in a line for each channel, in output units."""
    for channel, (words, frac_bits, most) in enumerate(
        zip(packet.words, formats.channel_frac_bits, formats.channel_max_order, strict=True)
    ):
        order = min(packet.fields["orders"] >> 2 * channel & 3, most)
        name = "depth" if channel == formats.num_channels else f"channel {channel}"
        differences = zip(DIFFERENCES[: DIFFERENCES_OF_ORDER[order]], words, strict=False)
        values = (
            (difference, _signed(word, formats.word_width) / 2**frac_bits) for difference, word in differences
        )
        yield f"  {name}, {ORDER_NAMES[order]}: " + ", ".join(
            f"{difference} {value:g}" for difference, value in values
        )


def _width_names() -> dict[int, str]:
    """What the width at each address is of."""
    differences = {
        KIND_WIDTHS * index + 2 * difference + top: f"{kind} {name} {('below', 'top')[top]}"
        for index, kind in enumerate(CHANNEL_KINDS)
        for difference, name in enumerate(DIFFERENCES)
        for top in (0, 1)
    }
    return differences | {FIELD_WIDTHS + index: name for index, (name, _) in enumerate(FIELD_KINDS)}


def packet_lines(frame: FrameFile, most: int | None = None) -> Iterator[str]:
    """
    Every packet: where it is, which widths it changes, its fields and words.

    Parameters
    ----------
    frame : FrameFile
    most : int, optional
      Show no more packets.
    """
    formats = frame.formats
    vertices = VertexUnpacker(formats) if frame.vertices else None
    plain = vertices.plain if vertices else WordUnpacker(formats)
    names = _width_names()
    held = plain.widths
    shown = None if most is None else min(most, sys.maxsize)
    packets = (vertices or plain).packets(frame.words)
    for index, (start, end, setup_words) in enumerate(islice(packets, shown)):
        widths = plain.widths
        changed = [
            f"{names[address]} {new}"
            for address, (old, new) in enumerate(zip(held, widths, strict=True))
            if old != new
        ]
        held = widths
        unpacked_bits = 32 * len(setup_words)
        yield f"packet {index}: bits {start} to {end - 1}, {end - start} bits, {unpacked_bits} unpacked"
        if changed:
            yield f"  widths: {', '.join(changed)}"
        # A run of packed words among vertices may have several.
        for packet in load_packets(setup_words.tolist(), formats):
            yield from _field_text(packet, formats)
            yield from _word_text(packet, formats)
