# SPDX-License-Identifier: Apache-2.0
"""What tests feed the core with: triangles of every awkward kind, and packets that no host would send."""

from __future__ import annotations

import numpy as np

from quadshade.contract.formats import DIFFERENCES_OF_ORDER, EDGES, QUADRATIC, SETUP_WORD_BITS, Formats
from quadshade.contract.triangles import ScreenTriangles
from quadshade.golden.core.edge_dda import EdgeDda, signed
from quadshade.golden.core.setup_loader import built_order
from quadshade.setup.packet import pack
from quadshade.setup.triangle_setup import setup_triangles

SCREEN = 48
WILD_COORD_BITS = 6
"""Up to this many coordinate bits a span of any length is short enough to simulate."""


def _vertices(kind: str, width: int, height: int, rng: np.random.Generator) -> np.ndarray:
    """(3, 2) vertices in pixels."""
    screen = np.array([width, height])
    at = rng.uniform(0, 1, 2) * screen
    if kind == "one_pixel":
        return np.floor(at) + 0.5 + np.array([[-0.4, -0.3], [0.4, -0.2], [0.1, 0.5]])
    if kind == "tiny":
        return at + rng.uniform(-1.5, 1.5, (3, 2))
    if kind == "needle":
        # Steep and thinner than a pixel: most scanlines are empty.
        tall = np.array([rng.uniform(-0.2, 0.2), 0.8]) * height
        return np.array([at * 0.2, at * 0.2 + tall, at * 0.2 + tall / 2 + [0.6, 0.0]])
    if kind == "sliver":
        along = rng.uniform(-0.8, 0.8, 2) * screen
        return np.array([at, at + along, at + along / 3 + rng.uniform(-0.1, 0.1, 2)])
    if kind == "grid":
        return np.rint((at + rng.uniform(-0.3, 0.3, (3, 2)) * screen) * 2) / 2
    if kind == "crossing":
        return at + rng.uniform(-0.9, 0.9, (3, 2)) * screen
    return at + rng.uniform(-0.25, 0.25, (3, 2)) * screen


KINDS = ("one_pixel", "tiny", "needle", "sliver", "grid", "crossing", "random")


def triangles_of(
    formats: Formats, rng: np.random.Generator, count: int, size: int = SCREEN
) -> ScreenTriangles:
    """Triangles of all kinds in turn, every channel of a random order, on a small screen."""
    size = min(size, 1 << formats.coord_bits)
    low, high = formats.guard_band
    pixels = np.array([_vertices(KINDS[i % len(KINDS)], size, size - 1, rng) for i in range(count)])
    vertices = np.clip(np.rint(pixels * (1 << formats.subpixel_bits)), low, high).astype(np.int64)
    channels = formats.num_channels
    top = (1 << formats.value_bits) - 1
    depth = rng.uniform(0, (1 << formats.depth_bits) - 1, (count, 3)) if formats.with_depth else None
    samples = rng.uniform(0, top, (count, channels, 6))
    # Full swings overshoot, so that the clamp has work on both sides.
    samples[::3] = np.where(samples[::3] > top / 2, top, 0)
    orders = rng.integers(0, formats.max_order + 1, (count, channels))
    return ScreenTriangles(size, size - 1, vertices, samples, orders, depth, tuple("abcdefgh"[:channels]))


def triangle_words(formats: Formats, rng: np.random.Generator, count: int, size: int = SCREEN) -> np.ndarray:
    """(m,) uint32 set-up words of triangles, the last third with colour stepped at the fractional edge."""
    plain = setup_triangles(triangles_of(formats, rng, count - count // 3, size), formats)
    fractional = setup_triangles(triangles_of(formats, rng, count // 3, size), formats, fractional=True)
    return np.concatenate([pack(plain, formats), pack(fractional, formats)])


def _edge_of_some_size(formats: Formats, rng: np.random.Generator) -> dict[str, int]:
    """
    Error, increment and decrement of so many bits that every one of them decides on a carry.

    Of words of all bits the lowest matter in one scanline of millions.
    """
    bits = int(rng.integers(1, formats.edge_bits + 1))
    size = 1 << bits
    error, increment, decrement = rng.integers(0, size, 3).tolist()
    mask = (1 << formats.error_bits) - 1
    return {"error": (error - size // 2) & mask, "increment": increment, "decrement": -(decrement + 1) & mask}


def random_fields(formats: Formats, rng: np.random.Generator, sized: float = 0) -> dict[str, int]:
    """
    Raw packet fields with no sense in them but that the walk stays short.

    Parameters
    ----------
    formats : Formats
    rng : numpy Generator
    sized : float
      Share of the edges whose remainders have a random number of bits, not all.
    """
    layout = formats.section("edge") | formats.section("second")
    fields = {
        name: int.from_bytes(rng.bytes(8), "little") & ((1 << width) - 1)
        for name, (_, width) in layout.items()
    }
    for edge in EDGES:
        if sized and rng.random() < sized:
            small = _edge_of_some_size(formats, rng)
            fields |= {f"{edge}_{name}": word for name, word in small.items()}
    mask = (1 << formats.column_bits) - 1
    for name in ("rows_first", "rows_second"):
        fields[name] = int(rng.integers(-3, 6)) & mask
    if formats.coord_bits <= WILD_COORD_BITS and rng.random() < 0.25:
        return fields
    for edge in EDGES:
        fields[f"{edge}_step"] = int(rng.integers(-2, 2)) & mask
    major = EdgeDda(fields, "major", formats)
    fields["minor_column"] = (major.column + int(rng.integers(-2, 9))) & mask
    for _ in range(max(signed(fields["rows_first"], formats.column_bits) + 2, 1)):
        major.step()
    fields["second_column"] = (major.column + int(rng.integers(-2, 9))) & mask
    return fields


def section_words(
    section: str, fields: dict[str, int], formats: Formats, rng: np.random.Generator
) -> list[int]:
    """Set-up words of a section; its padding is random."""
    used = formats.section_bits(section)
    count = formats.section_beats(section) * formats.beat_words
    bits = int.from_bytes(rng.bytes(count * SETUP_WORD_BITS // 8), "little") >> used << used
    for name, (offset, _) in formats.section(section).items():
        bits |= fields[name] << offset
    return [(bits >> (SETUP_WORD_BITS * index)) & 0xFFFFFFFF for index in range(count)]


def malformed_packet(formats: Formats, rng: np.random.Generator) -> list[int]:
    """Set-up words of one packet of nonsense, as long as its header says."""
    fields = random_fields(formats, rng)
    words = section_words("edge", fields, formats, rng)
    if fields["has_second"]:
        words += section_words("second", fields, formats, rng)
    for group in formats.channel_groups:
        sent = max(min((fields["orders"] >> (2 * channel)) & 3, QUADRATIC) for channel in group)
        differences = DIFFERENCES_OF_ORDER[min(sent, built_order(group, formats))]
        count = differences * formats.difference_beats * formats.beat_words
        words += rng.integers(0, 1 << SETUP_WORD_BITS, count).tolist()
    return words


def malformed_words(formats: Formats, rng: np.random.Generator, count: int) -> np.ndarray:
    """(m,) uint32 set-up words of packets of nonsense."""
    return np.array([word for _ in range(count) for word in malformed_packet(formats, rng)], dtype=np.uint32)
