# SPDX-License-Identifier: Apache-2.0
"""
Primitives and their triangles to words for boards with ``vertex_unpacker`` (``docs/reference/vertices.md``).

A triangle goes as its vertices if the board's own set-up of them, in integers, has the same edges bit for bit
and words whose error stays in what packing may add. Those that do not, and the parts of triangles that cross
the border, are runs of packed words between.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numba import njit

from quadshade.choices import PACK_ERROR
from quadshade.contract.arrays import Bools, Floats, Ints
from quadshade.contract.formats import QUADRATIC, SETUP_WORD_BITS, Formats
from quadshade.contract.triangles import ScreenTriangles
from quadshade.contract.vertex_program import LARGEST_RUN, SAMPLE_FRAC, takes_formats
from quadshade.errors import QuadshadeError
from quadshade.golden.link.vertex_unpacker import VertexUnpacker
from quadshade.packing.pack import Packed, pack_primitives
from quadshade.packing.vertex_code import Tokens, code_parameters, run_head, write_tokens
from quadshade.packing.vertex_points import points_of
from quadshade.packing.vertex_set_up import COVER_WIDTH, EDGE, EDGES, HEADER, board_of, set_up, usual_order
from quadshade.packing.vertices import MOST_TOKENS, Points, tokens_of
from quadshade.setup.packet import Primitives
from quadshade.setup.quantise import largest_error
from quadshade.setup.short_words import Regions, primitive_regions

HAS_SECOND = HEADER.index("has_second")

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


class _Line(NamedTuple):
    """What the line carries, how many tokens, and the corners in the order in which the board keeps them."""

    tokens: Tokens
    num_tokens: int
    settled: Ints


def _line_of(points: Points) -> _Line:
    """The tokens of the primitives that are sent, with runs of the others."""
    room = MOST_TOKENS * len(points.sent) + 1
    tokens = Tokens(np.empty(room, np.int8), np.empty(room, np.int64), np.empty(room, np.int8))
    settled = np.zeros((len(points.sent), 3), np.int64)
    return _Line(tokens, tokens_of(points, tokens, settled), settled)


def _encode(line: _Line, parameters: np.ndarray, packed: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """(m,) uint32 words of everything; the first four parameters are written."""
    tokens, count = line.tokens, line.num_tokens
    code_parameters(tokens, count, parameters)
    # No token has more bits than the longest residual; runs begin at whole words.
    out = np.zeros(count * 2 + 2 * len(packed) + 8, np.uint32)
    bits = write_tokens(tokens, count, parameters, packed, ends, out)
    return out[: -(-bits // SETUP_WORD_BITS)].copy()


@njit(cache=True)
def _added(words: Ints, drawn: Ints, regions: Regions, todo: Bools, out: Floats) -> None:
    """Most that words of some primitives, ``drawn``, are off ``words``, in units of the last place."""
    off = np.zeros(6)
    for p in range(len(todo)):
        if not todo[p]:
            continue
        for channel in range(words.shape[1]):
            for difference in range(6):
                off[difference] = drawn[p, channel, difference] - words[p, channel, difference]
            out[p, channel] = largest_error(regions.corners[p], regions.num_corners[p], off)


def covers_of(primitives: Primitives) -> Ints:
    """(n, COVER_WIDTH) int64: header and edges of primitives, as :func:`set_up` gives them."""
    columns = [primitives.header[name] for name in HEADER]
    columns += [primitives.edges[edge][name] for edge in EDGES for name in EDGE]
    return np.stack(columns, axis=1).astype(np.int64, copy=False)


@njit(cache=True)
def _keep(drawn: Ints, covers: Ints, added: Floats, budgets: Floats, todo: Bools, sent: Bools) -> None:
    """Some are only sent if header and edges are right in every bit, and no channel is off by too much."""
    for p in range(len(todo)):
        if not todo[p]:
            continue
        columns = COVER_WIDTH if covers[p, HAS_SECOND] else COVER_WIDTH - len(EDGE)
        for column in range(columns):
            sent[p] &= drawn[p, column] == covers[p, column]
        for channel in range(len(budgets)):
            sent[p] &= added[p, channel] <= budgets[channel]


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

    def __init__(self, points: Points, line: _Line, parameters: np.ndarray, primitives: Primitives) -> None:
        self._points, self._line, self._parameters = points, line, parameters
        self.primitives = primitives
        self.sent: Bools = points.sent

    def tokens(self) -> Tokens:
        """What the line carries of those that are sent and between them, in its order; numbers uncoded."""
        return Tokens(*(column[: self._line.num_tokens] for column in self._line.tokens))

    def words(self, packed: np.ndarray, ends: np.ndarray) -> np.ndarray:
        """(m,) uint32 for the line, with runs of packed words of the others between."""
        return _encode(self._line, self._parameters, packed, ends)


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
    covers = covers_of(primitives)
    points = points_of(primitives, triangles, covers, formats, bits)
    if not points.sent.any():
        return None
    regions = primitive_regions(primitives)
    parameters = np.array([0, 0, 0, 0, bits - SAMPLE_FRAC, shift_depth])
    board = board_of(formats, bits - SAMPLE_FRAC, shift_depth)
    drawn = np.zeros_like(covers)
    words = np.zeros_like(primitives.words)
    added = np.zeros((len(primitives), formats.carried_channels))
    budgets = np.full(formats.carried_channels, error)
    budgets[formats.num_channels :] = DEPTH_ERROR
    budgets *= 2.0 ** np.array(formats.channel_frac_bits)
    order, todo = usual_order(points), points.sent.copy()
    line: _Line | None = None
    while True:
        before = np.count_nonzero(points.sent)
        set_up(points, order, todo, board, drawn, words)
        _added(primitives.words, words, regions, todo, added)
        _keep(drawn, covers, added, budgets, todo, points.sent)
        if line is not None and np.count_nonzero(points.sent) == before:
            break
        line = _line_of(points)
        # Where corners have the same y, their order is that in which the triangle before was sent.
        todo = points.sent & (line.settled != order).any(axis=1)
        order = line.settled
    kept = points.sent
    added[~kept] = 0.0
    orders = primitives.orders.copy()
    orders[:, : formats.num_channels] = np.where(
        kept[:, None], 1 + points.quadratic[:, None], orders[:, : formats.num_channels]
    )
    orders[kept, formats.num_channels :] = 1
    drawn_primitives = replace(
        primitives,
        edges={edge: dict(fields) for edge, fields in primitives.edges.items()},
        words=np.where(kept[:, None, None], words, primitives.words),
        bound=primitives.bound + added / 2.0 ** np.array(formats.channel_frac_bits),
        orders=orders,
    )
    return VertexPacked(points, line, parameters, drawn_primitives)


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


def pack_run(primitives: Primitives, formats: Formats, error: float) -> Packed:
    """As :func:`pack_vertices`, none of them as vertices."""
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
        return pack_run(primitives, formats, error)
    plain = None
    sent = int(np.count_nonzero(chosen.sent))
    if 2 * sent < len(primitives):
        plain = pack_run(primitives, formats, error)
    rows, drawn = np.flatnonzero(~chosen.sent), chosen.primitives
    packed, starts, ends = np.zeros(0, np.uint32), np.zeros(1, np.int64), np.zeros(0, np.int64)
    if len(rows):
        # A run of packed words begins where the primitive before it is none of them.
        aligned = np.diff(rows, prepend=-2) != 1
        rest = pack_primitives(_part(primitives, rows), formats, error, aligned=aligned)
        packed, starts = rest.words, rest.starts
        begins = starts[:-1][aligned] // SETUP_WORD_BITS
        ends = np.append(begins[1:], len(packed)).astype(np.int64)
        _put_part(drawn, rows, rest.primitives)
    words = chosen.words(packed, ends)
    if plain is not None and len(plain.words) <= len(words):
        return plain
    added = (drawn.bound - primitives.bound)[:, : formats.num_channels]
    return Packed(words, drawn, starts, float(added.max(initial=0.0)), True, sent)


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
