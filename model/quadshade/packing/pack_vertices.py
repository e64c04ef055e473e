# SPDX-License-Identifier: Apache-2.0
"""
Primitives and their triangles to words for boards with ``vertex_unpacker`` (``docs/reference/vertices.md``).

A triangle goes as its vertices if the board's own set-up of them, in integers, has the same edges bit for bit
and words whose error stays in what packing may add. Those that do not, and the parts of triangles that cross
the border, are runs of packed words between.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numba import njit

from quadshade.choices import PACK_ERROR
from quadshade.contract.arrays import Bools, Floats, Ints
from quadshade.contract.formats import CONSTANT, QUADRATIC, SETUP_WORD_BITS, Formats
from quadshade.contract.triangles import ScreenTriangles
from quadshade.contract.vertex_program import (
    LARGEST_RUN,
    LARGEST_SPAN,
    LARGEST_TRIM,
    SAMPLE_FRAC,
    takes_formats,
)
from quadshade.errors import QuadshadeError
from quadshade.golden.link.vertex_unpacker import VertexUnpacker
from quadshade.packing.pack import Packed, pack_primitives
from quadshade.packing.read_primitives import read_primitives
from quadshade.packing.vertex_code import Tokens, code_parameters, run_head, write_tokens
from quadshade.packing.vertices import MOST_TOKENS, Points, tokens_of
from quadshade.setup.packet import Primitives
from quadshade.setup.quantise import largest_error
from quadshade.setup.short_words import Regions, primitive_regions

FINEST = 6
"""Most fraction bits of a sample: the coefficients of its quadratic then fill their bits."""

AMPLIFIED = 5.0 / 3.0
"""Most that a quadratic grows between its six samples, of the largest of them (the Lebesgue constant)."""

SHARE = 0.9
"""Of the error, what rounding samples may take; the rest is for the board's ratios."""

DEPTH_ERROR = 0.625
"""Units by which depth may be off: its samples are whole ones."""


def sample_bits(primitives: Primitives, error: float) -> int | None:
    """Fraction bits of samples that keep an error, None if no board has that many."""
    grows = AMPLIFIED if (primitives.orders == QUADRATIC).any() else 1.0
    for bits in range(SAMPLE_FRAC, FINEST + 1):
        if grows * 0.5 ** (bits + 1) <= SHARE * error:
            return bits
    return None


def _points(primitives: Primitives, triangles: ScreenTriangles, formats: Formats, bits: int) -> Points:
    """The points of all primitives, and which of them may be sent as such."""
    owners = primitives.triangle
    vertices = np.ascontiguousarray(triangles.vertices[owners], np.int64)
    samples = np.rint(triangles.samples[owners] * 2.0**bits).astype(np.int64)
    orders = primitives.orders[:, : formats.num_channels]
    linear = samples.copy()
    # What a channel of a lower order leaves out of its samples.
    linear[:, :, 1:3] = np.where((orders == CONSTANT)[:, :, None], samples[:, :, :1], samples[:, :, 1:3])
    middles = (linear[:, :, (0, 0, 1)] + linear[:, :, (1, 2, 2)]) >> 1
    middles = np.where((orders == QUADRATIC)[:, :, None], samples[:, :, 3:], middles)
    columns = [vertices, np.swapaxes(linear[:, :, :3], 1, 2)]
    alone = np.bincount(owners, minlength=len(triangles))[owners] == 1
    sent = alone & (primitives.header["fractional"] == 0) & ~primitives.undefined
    if formats.with_depth:
        if triangles.depth is None:
            sent[:] = False
            columns.append(np.zeros((len(owners), 3, 1), np.int64))
        else:
            columns.append(np.rint(triangles.depth[owners]).astype(np.int64)[:, :, None])
    pixel, size = 1 << formats.subpixel_bits, 1 << (formats.coord_bits + formats.subpixel_bits)
    spans = vertices.max(axis=1) - vertices.min(axis=1)
    sent &= (vertices >= 0).all(axis=(1, 2)) & (vertices <= size).all(axis=(1, 2))
    sent &= (spans < 1 << LARGEST_SPAN).all(axis=1)
    first = (2 * vertices[:, :, 1] + pixel - 1) >> (formats.subpixel_bits + 1)
    head = primitives.header
    rows = head["y"] + head["rows_first"] + head["rows_second"]
    trims = np.stack([head["y"] - first.min(axis=1), first.max(axis=1) - rows], axis=1)
    sent &= ((trims >= 0) & (trims <= LARGEST_TRIM)).all(axis=1)
    return Points(
        np.ascontiguousarray(np.concatenate(columns, axis=2)),
        np.ascontiguousarray(np.swapaxes(middles, 1, 2)),
        (orders == QUADRATIC).any(axis=1),
        trims,
        sent,
    )


def _encode(points: Points, parameters: np.ndarray, packed: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """(m,) uint32 words of everything; the first four parameters are written."""
    room = MOST_TOKENS * len(points.sent) + 1
    tokens = Tokens(np.zeros(room, np.int8), np.zeros(room, np.int64), np.zeros(room, np.int8))
    count = tokens_of(points, tokens)
    code_parameters(tokens, count, parameters)
    # No token has more bits than the longest residual; runs begin at whole words.
    out = np.zeros(count * 2 + 2 * len(packed) + 8, np.uint32)
    bits = write_tokens(tokens, count, parameters, packed, ends, out)
    return out[: -(-bits // SETUP_WORD_BITS)].copy()


@njit(cache=True)
def _added(words: Ints, drawn: Ints, regions: Regions, rows: Ints, out: Floats) -> None:
    """Most that words of some primitives, ``drawn``, are off ``words``, in units of the last place."""
    off = np.zeros(6)
    for index, p in enumerate(rows):
        for channel in range(words.shape[1]):
            for difference in range(6):
                off[difference] = drawn[index, channel, difference] - words[p, channel, difference]
            out[index, channel] = largest_error(regions.corners[p], regions.num_corners[p], off)


def _same_cover(drawn: Primitives, primitives: Primitives, rows: np.ndarray) -> np.ndarray:
    """(k,) bool: header and edges are those of some primitives, in every bit."""
    same = np.ones(len(rows), bool)
    for name, values in primitives.header.items():
        same &= drawn.header[name] == values[rows]
    for edge, fields in primitives.edges.items():
        there = primitives.header["has_second"][rows] != 0 if edge == "second" else True
        for name, values in fields.items():
            same &= (drawn.edges[edge][name] == values[rows]) | ~np.asarray(there)
    return same


class VertexPacked:
    """
    What :func:`choose_vertices` makes.

    Attributes
    ----------
    sent : (n,) bool
      Primitives that go as vertices.
    primitives : Primitives
      With the board's words where sent, and bounds that hold for them.
    """

    def __init__(
        self, points: Points, parameters: np.ndarray, primitives: Primitives, whole: np.ndarray
    ) -> None:
        self._points, self._parameters, self.primitives = points, parameters, primitives
        self._whole = whole
        self.sent: Bools = points.sent

    def words(self, packed: np.ndarray, ends: np.ndarray) -> np.ndarray:
        """(m,) uint32 for the line, with runs of packed words of the others between."""
        if self.sent.all():
            return self._whole
        return _encode(self._points, self._parameters, packed, ends)


def choose_vertices(
    primitives: Primitives, triangles: ScreenTriangles, formats: Formats, error: float
) -> VertexPacked | None:
    """
    Choose the primitives that go as vertices.

    Parameters
    ----------
    primitives : Primitives
      As set up.
    triangles : ScreenTriangles
      Those that they were set up from.
    formats : Formats
    error : float
      Grey levels that may be added to the error of a colour at any pixel. Depth may be off by
      :data:`DEPTH_ERROR` units.

    Returns
    -------
    VertexPacked or None
      None: no board with these formats takes them, or not with this error.
    """
    bits = sample_bits(primitives, error) if len(primitives) and takes_formats(formats) else None
    if bits is None:
        return None
    shift_depth = formats.frac_bits - SAMPLE_FRAC - formats.depth_frac_bits if formats.with_depth else 0
    if shift_depth < 0:
        return None
    points = _points(primitives, triangles, formats, bits)
    parameters = np.array([0, 0, 0, 0, bits - SAMPLE_FRAC, shift_depth])
    rows = np.flatnonzero(points.sent)
    if not len(rows):
        return None
    alone = Points(
        points.corners[rows],
        points.middles[rows],
        points.quadratic[rows],
        points.trims[rows],
        points.sent[rows],
    )
    words = _encode(alone, parameters, np.zeros(0, np.uint32), np.zeros(0, np.int64))
    drawn = read_primitives(VertexUnpacker(formats).feed(words), formats)
    added = np.zeros((len(rows), formats.carried_channels))
    _added(primitives.words, drawn.words, primitive_regions(primitives), rows, added)
    added /= 2.0 ** np.array(formats.channel_frac_bits)
    budgets = np.full(formats.carried_channels, error)
    budgets[formats.num_channels :] = DEPTH_ERROR
    kept = _same_cover(drawn, primitives, rows) & (added <= budgets).all(axis=1)
    points.sent[rows[~kept]] = False
    board_words, bound = primitives.words.copy(), primitives.bound.copy()
    orders = primitives.orders.copy()
    board_words[rows[kept]], orders[rows[kept]] = drawn.words[kept], drawn.orders[kept]
    bound[rows[kept]] += added[kept]
    return VertexPacked(
        points, parameters, replace(primitives, words=board_words, bound=bound, orders=orders), words
    )


def as_run(words: np.ndarray) -> np.ndarray:
    """
    Packed words for a board with ``vertex_unpacker``, which passes them.

    Raises
    ------
    QuadshadeError
      More words than a run may have.
    """
    if not len(words):
        return words
    if len(words) > LARGEST_RUN:
        raise QuadshadeError(f"{len(words)} packed words at once", f"send at most {LARGEST_RUN}")
    return np.concatenate([run_head(len(words)), words])


def _part(primitives: Primitives, rows: np.ndarray) -> Primitives:
    """Some of the primitives."""
    return Primitives(
        primitives.triangle[rows],
        {name: values[rows] for name, values in primitives.header.items()},
        {
            edge: {name: values[rows] for name, values in fields.items()}
            for edge, fields in primitives.edges.items()
        },
        primitives.orders[rows],
        primitives.words[rows],
        primitives.bound[rows],
        primitives.undefined[rows],
    )


def _put_part(primitives: Primitives, rows: np.ndarray, part: Primitives) -> None:
    """Write some of the primitives."""
    for edge, fields in primitives.edges.items():
        for name, values in part.edges[edge].items():
            fields[name] = fields[name].copy()
            fields[name][rows] = values
    primitives.words[rows], primitives.bound[rows] = part.words, part.bound


def _all_packed(primitives: Primitives, formats: Formats, error: float) -> Packed:
    """None of them as vertices."""
    plain = pack_primitives(primitives, formats, error)
    return replace(plain, words=as_run(plain.words), vertices=True)


def pack_vertices(
    primitives: Primitives, triangles: ScreenTriangles, formats: Formats, error: float = PACK_ERROR
) -> Packed:
    """
    Pack primitives for a board with ``vertex_unpacker``: as vertices where that takes fewer bytes.

    Parameters
    ----------
    primitives, triangles, formats
      As for :func:`choose_vertices`.
    error : float
      As for :func:`quadshade.packing.pack.pack_primitives`; with 0 all of them are packed words.

    Returns
    -------
    Packed
      Its starts are those of runs alone.

    Raises
    ------
    QuadshadeError
      As that function does.
    """
    chosen = choose_vertices(primitives, triangles, formats, error)
    if chosen is None:
        return _all_packed(primitives, formats, error)
    plain = None
    if 2 * np.count_nonzero(chosen.sent) < len(primitives):
        plain = _all_packed(primitives, formats, error)
    rows = np.flatnonzero(~chosen.sent)
    # A run of packed words begins where the primitive before it is none of them.
    aligned = np.diff(rows, prepend=-2) != 1
    rest = pack_primitives(_part(primitives, rows), formats, error, aligned=aligned)
    starts = rest.starts[:-1][aligned] // SETUP_WORD_BITS
    ends = np.append(starts[1:], len(rest.words)).astype(np.int64) if len(rows) else np.zeros(0, np.int64)
    words = chosen.words(rest.words, ends)
    if plain is not None and len(plain.words) <= len(words):
        return plain
    drawn = chosen.primitives
    _put_part(drawn, rows, rest.primitives)
    added = (drawn.bound - primitives.bound)[:, : formats.num_channels]
    return Packed(words, drawn, rest.starts, float(added.max(initial=0.0)), True)


def unpack_vertices(words: np.ndarray, formats: Formats) -> np.ndarray:
    """
    The set-up words of whole packets: the inverse of :func:`pack_vertices`.

    Parameters
    ----------
    words : (m,) uint32
    formats : Formats

    Returns
    -------
    (k,) uint32

    Raises
    ------
    QuadshadeError
      The words end within a packet, or no board unpacks them with these formats.
    """
    unpacker = VertexUnpacker(formats)
    setup_words = unpacker.feed(words)
    if unpacker.within:
        raise QuadshadeError("the packed words end within a packet", "send whole packets")
    return setup_words
