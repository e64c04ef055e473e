# SPDX-License-Identifier: Apache-2.0
"""Primitives (what one set-up packet says) and their packing into the words of the set-up stream."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numba import njit

from quadshade.contract.arrays import Ints, Words32
from quadshade.contract.formats import DIFFERENCES_OF_ORDER, EDGES, SETUP_WORD_BITS, Formats
from quadshade.errors import QuadshadeError
from quadshade.setup.edges import Cut, empty_cut

BLOCK = 4096
"""Packets written at a time: field by field, they stay in the cache."""


@dataclass
class Primitives:
    """
    What the hardware draws: rows of pixels between a major and a minor edge, one entry a packet.

    A triangle inside the screen is one primitive; one that crosses the screen's border is cut at whole
    scanlines into several. All arrays hold exact integers (int64), raw words two's complement.

    Attributes
    ----------
    triangle : (n,) int64
      Index of the triangle that the primitive draws a part of.
    header : dict of (n,) int64
      ``y``, ``rows_first``, ``rows_second`` (true counts: at least 1; ``rows_second`` 0 where there is no
      second edge), ``has_second``, ``mirror``, ``fractional``.
    edges : dict of dict of (n,) int64
      ``major``, ``minor``, ``second``, each with ``column``, ``error``, ``step``, ``increment``,
      ``decrement``.
    orders : (n, c) int64
      0 constant, 1 linear, 2 quadratic for every carried channel (depth last).
    words : (n, c, 6) int64
      Differences in the order of ``formats.DIFFERENCES``; differences above a channel's order are zero.
    bound : (n, c) float64
      Upper bound of |value - exact quadratic| at any covered pixel before output rounding, in output units.
    undefined : (n,) bool
      A channel is drawn as 0, because its coefficients, by a method of the literature, are not finite or off
      by more than half of full scale.
    """

    triangle: np.ndarray
    header: dict[str, np.ndarray]
    edges: dict[str, dict[str, np.ndarray]]
    orders: np.ndarray
    words: np.ndarray
    bound: np.ndarray = field(default_factory=lambda: np.zeros((0, 0)))
    undefined: np.ndarray = field(default_factory=lambda: np.zeros(0, dtype=np.bool_))

    def __len__(self) -> int:
        return len(self.triangle)


def cut_of(primitives: Primitives) -> Cut:
    """What covers which pixels, as the loops take it; which vertices the major edge ends at is not known."""
    size = len(primitives)
    cut = empty_cut(size)
    cut.heads["triangle"] = np.arange(size)
    for name in ("y", "rows_first", "rows_second", "mirror"):
        cut.heads[name] = primitives.header[name]
    for index, edge in enumerate(primitives.edges.values()):
        state = cut.edges[:, index]
        state["column"], state["step"] = edge["column"], edge["step"]
        state["remainder"] = edge["error"] - edge["decrement"]
        state["increment"] = edge["increment"]
        state["height"] = edge["increment"] - edge["decrement"]
    return cut


def header_of(cut: Cut, fractional: np.ndarray) -> dict[str, np.ndarray]:
    """The header of primitives, ``fractional`` (n,) int64."""
    heads = cut.heads
    return {
        "y": heads["y"],
        "rows_first": heads["rows_first"],
        "rows_second": heads["rows_second"],
        "has_second": (heads["rows_second"] > 0).astype(np.int64),
        "mirror": heads["mirror"],
        "fractional": fractional,
    }


def edges_of(cut: Cut) -> dict[str, dict[str, np.ndarray]]:
    """The edges of primitives, with the DDA's numbers as a packet has them."""
    edges = {}
    for index, name in enumerate(EDGES):
        state = cut.edges[:, index]
        edges[name] = {
            "column": state["column"],
            "error": state["remainder"] + state["increment"] - state["height"],
            "step": state["step"],
            "increment": state["increment"],
            "decrement": state["increment"] - state["height"],
        }
    return edges


def field_values(primitives: Primitives, name: str, formats: Formats) -> np.ndarray:
    """Raw value of a packet field for every primitive."""
    if name == "orders":
        shifts = 2 * np.arange(formats.carried_channels)
        return (primitives.orders.astype(np.int64) << shifts).sum(axis=1)
    if name in ("rows_first", "rows_second"):
        return primitives.header[name] - 2
    edge, _, part = name.partition("_")
    if edge in EDGES and part in primitives.edges[edge]:
        return primitives.edges[edge][part]
    return primitives.header[name]


@njit(cache=True)
def _put_fields(out: Words32, at: Ints, rows: Ints, raws: Ints, offsets: Ints, widths: Ints) -> None:
    """
    Write the raw values (fields, n) of bit fields into the zeroed packets of some rows, from words ``at`` on.

    No field has more than 32 bits, so it lies in two words at most.
    """
    for index in range(len(raws)):
        offset, width = offsets[index], widths[index]
        first, shift = offset // SETUP_WORD_BITS, np.uint64(offset % SETUP_WORD_BITS)
        mask = np.uint64((1 << width) - 1)
        goes_on = offset % SETUP_WORD_BITS + width > SETUP_WORD_BITS
        for row in rows:
            value = np.uint64(raws[index, row]) & mask
            place = at[row] + first
            out[place] |= np.uint32(value << shift)
            if goes_on:
                out[place + 1] |= np.uint32(value >> (np.uint64(SETUP_WORD_BITS) - shift))


class _Layout(NamedTuple):
    """
    How differences lie in a packet: the channel behind each group's last one; set-up words of a group's and
    of one channel's difference; the bits of a word.
    """

    group_ends: Ints
    group_words: int
    difference_words: int
    word_mask: int


@njit(cache=True)
def _put_differences(out: Words32, at: Ints, rows: Ints, words: Ints, levels: Ints, layout: _Layout) -> None:
    """Write the differences of some rows from set-up words ``at`` on; ``levels`` are the groups' orders."""
    mask = np.uint64(layout.word_mask)
    for row in rows:
        begin, first = at[row], 0
        for group in range(len(layout.group_ends)):
            for difference in range(DIFFERENCES_OF_ORDER[levels[row, group]]):
                for channel in range(first, layout.group_ends[group]):
                    raw = np.uint64(words[row, channel, difference]) & mask
                    place = begin + (channel - first) * layout.difference_words
                    for part in range(layout.difference_words):
                        out[place + part] = np.uint32(raw >> np.uint64(SETUP_WORD_BITS * part))
                begin += layout.group_words
            first = layout.group_ends[group]


def group_orders(orders: np.ndarray, formats: Formats) -> np.ndarray:
    """(n, groups) highest order of each channel group: how many of its differences are sent."""
    return np.stack([orders[:, list(group)].max(axis=1) for group in formats.channel_groups], axis=1)


def packet_words(orders: np.ndarray, has_second: np.ndarray, formats: Formats) -> np.ndarray:
    """(n,) set-up words that each primitive's packet takes, padding included."""
    differences = np.array(DIFFERENCES_OF_ORDER)[group_orders(orders, formats)].sum(axis=1)
    beats = (
        formats.section_beats("edge")
        + has_second * formats.section_beats("second")
        + differences * formats.difference_beats
    )
    return beats * formats.beat_words


def pack(primitives: Primitives, formats: Formats) -> np.ndarray:
    """
    The words of the set-up stream.

    Parameters
    ----------
    primitives : Primitives
    formats : Formats

    Returns
    -------
    (m,) uint32
      Set-up words in stream order; a beat of ``stream_width`` bits holds ``beat_words`` of them, the first
      one lowest.

    Raises
    ------
    QuadshadeError
      A channel's order is above what the core is built for.
    """
    if len(primitives) == 0:
        return np.zeros(0, dtype=np.uint32)
    if (primitives.orders > np.array(formats.channel_max_order)).any():
        raise QuadshadeError(
            "a channel's order is above the core's generic max_order", "raise max_order or lower it"
        )
    lengths = packet_words(primitives.orders, primitives.header["has_second"], formats)
    ends = np.cumsum(lengths)
    out = np.zeros(ends[-1], dtype=np.uint32)
    levels = group_orders(primitives.orders, formats)
    layout = _Layout(
        np.array([group[-1] + 1 for group in formats.channel_groups]),
        formats.difference_beats * formats.beat_words,
        formats.difference_words,
        (1 << formats.word_width) - 1,
    )
    sections = []
    for name in ("edge", "second"):
        fields = formats.section(name)
        raws = np.stack([field_values(primitives, part, formats) for part in fields])
        places = np.array([*fields.values()])
        sections.append((formats.section_beats(name) * formats.beat_words, raws, places))
    at = ends - lengths
    for start in range(0, len(primitives), BLOCK):
        rows = np.arange(start, min(start + BLOCK, len(primitives)))
        present = rows
        for section_words, raws, places in sections:
            _put_fields(out, at, present, raws, places[:, 0], places[:, 1])
            at[present] += section_words
            present = rows[primitives.header["has_second"][rows] != 0]
        _put_differences(out, at, rows, primitives.words, levels, layout)
    return out
