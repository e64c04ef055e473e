# SPDX-License-Identifier: Apache-2.0
"""
Triangles whose error bound is too large, drawn in parts: windows of the screen, each with words of its own.

Words lose with the square of the steps that follow them, so a window of half the side loses a quarter. Only
the drawing region is divided: every part keeps the triangle's edges, which are exact from any scanline on,
and its polynomial, so the parts together cover the same pixels, once each, and meet without a seam but for
the bound.
"""

from __future__ import annotations

from typing import NoReturn

import numpy as np
from numba import njit

from quadshade.contract.arrays import Floats, Ints, Records
from quadshade.errors import QuadshadeError
from quadshade.setup.colour_words import Colours, colour_words
from quadshade.setup.edges import MAX_PRIMITIVES, Cut, cut_one, empty_cut
from quadshade.setup.quantise import reach, region
from quadshade.setup.sides import Sides, Window, empty_sides

BARELY = 1.0 + 2.0**-20
"""A bound is computed a little too large; a constant channel without fraction bits is half a level off."""

CHUNK = 4096
"""Windows cut at a time."""

LEFT, TOP, RIGHT, BOTTOM = range(4)


@njit(cache=True)
def _cut_windows(
    vertices: Ints, owners: Ints, windows: Ints, bits: int, sides: Sides, out: Cut, window_of: Ints
) -> int:
    """Cut triangle ``owners[k]`` by ``windows[k]``, for all k; returns the number of primitives."""
    corners = np.zeros((3, 2), np.int64)
    count = 0
    for k in range(len(owners)):
        x, y = windows[k, LEFT], windows[k, TOP]
        corners[:, 0] = vertices[owners[k], :, 0] - (x << bits)
        corners[:, 1] = vertices[owners[k], :, 1] - (y << bits)
        first = count
        window = Window(windows[k, RIGHT] - x, windows[k, BOTTOM] - y, bits)
        count = cut_one(owners[k], corners, window, sides, out, count)
        for p in range(first, count):
            window_of[p] = k
            head, edges = out.heads[p], out.edges[p]
            head.y += y
            # Mirrored, the hardware's column is u = -1 - x.
            shift = -x if head.mirror else x
            edges[0].column += shift
            edges[1].column += shift
            if head.rows_second > 0:
                edges[2].column += shift
    return count


@njit(cache=True)
def _extent(cut: Cut) -> Floats:
    """(n, 2) scanlines, and columns from the major edge's lattice, of every primitive."""
    corners = np.zeros((8, 2))
    out = np.zeros((len(cut.heads), 2))
    for p in range(len(cut.heads)):
        head = cut.heads[p]
        out[p, 1] = reach(corners, region(head, cut.edges[p], False, corners))[1]
        out[p, 0] = head.rows_first + head.rows_second
    return out


def _halves(windows: np.ndarray, across: np.ndarray) -> np.ndarray:
    """(2 n, 4): each window in two, side by side where ``across``, else one above the other."""
    low, high = np.where(across, LEFT, TOP), np.where(across, RIGHT, BOTTOM)
    row = np.arange(len(windows))
    middle = (windows[row, low] + windows[row, high]) // 2
    pairs = np.repeat(windows, 2, axis=0)
    pairs[2 * row, high], pairs[2 * row + 1, low] = middle, middle
    return pairs


def _first_windows(vertices: np.ndarray, width: int, height: int, bits: int) -> np.ndarray:
    """(n, 4) the part of the screen round each triangle."""
    low, high = vertices.min(axis=1) >> bits, (vertices.max(axis=1) >> bits) + 1
    size = np.array([width, height])
    return np.concatenate([np.clip(low, 0, size - 1), np.clip(high, 1, size)], axis=1)


def beyond(bounds: np.ndarray, channels: int, limit: float) -> np.ndarray:
    """(n, channels) bool: colour channels whose bound exceeds a limit."""
    return bounds[:, :channels] > limit * BARELY


def divide(
    cut: Cut,
    words: np.ndarray,
    bounds: np.ndarray,
    limit: float,
    colours: Colours,
    width: int,
    height: int,
) -> tuple[Cut, np.ndarray, np.ndarray]:
    """
    Draw triangles in as many parts as it takes for the bound of every colour channel to hold.

    Parameters
    ----------
    cut : Cut
    words, bounds : (n, c, 6) int64, (n, c) float64
      From :func:`~quadshade.setup.colour_words.colour_words`.
    limit : float
      Grey levels.
    colours : Colours
    width, height : int
      Of the screen, in pixels.

    Returns
    -------
    cut, words, bounds
      As given, where the bounds hold; other triangles have more primitives, window by window.

    Raises
    ------
    QuadshadeError
      The bound is not met at a single pixel: the format's fraction is too short.
    """
    formats = colours.formats
    over = np.unique(cut.heads["triangle"][beyond(bounds, formats.num_channels, limit).any(axis=1)])
    if not len(over):
        return cut, words, bounds
    if limit <= 0.5 * 2.0**-formats.frac_bits:
        _refuse(over[0], limit, formats.frac_bits)
    kept = ~np.isin(cut.heads["triangle"], over)
    done = [(cut.heads[kept], cut.edges[kept], words[kept], bounds[kept])]
    owners, windows = over, _first_windows(colours.vertices[over], width, height, formats.subpixel_bits)
    while len(owners):
        # The last ones first: what waits is then at most a few windows for each halving.
        parts, more_owners, more_windows = _try(owners[-CHUNK:], windows[-CHUNK:], limit, colours)
        done.append(parts)
        owners = np.concatenate([owners[:-CHUNK], more_owners])
        windows = np.concatenate([windows[:-CHUNK], more_windows])
    heads, edges, words, bounds = (np.concatenate(column) for column in zip(*done, strict=True))
    order = np.lexsort((heads["y"], heads["triangle"]))
    return Cut(heads[order], edges[order]), words[order], bounds[order]


def _try(
    owners: np.ndarray, windows: np.ndarray, limit: float, colours: Colours
) -> tuple[tuple[Records, Records, Ints, Floats], Ints, Ints]:
    """Primitives of the windows that hold the limit, and the halves of the others with their triangles."""
    formats = colours.formats
    room = len(owners) * MAX_PRIMITIVES
    cut, window_of = empty_cut(room), np.empty(room, np.int64)
    bits, sides = formats.subpixel_bits, empty_sides()
    count = _cut_windows(colours.vertices, owners, windows, bits, sides, cut, window_of)
    cut, window_of = Cut(cut.heads[:count], cut.edges[:count]), window_of[:count]
    words, bounds = colour_words(cut, colours)
    again = np.zeros(len(owners), dtype=bool)
    again[window_of[beyond(bounds, formats.num_channels, limit).any(axis=1)]] = True
    sizes = windows[:, [RIGHT, BOTTOM]] - windows[:, [LEFT, TOP]]
    single = again & (sizes == 1).all(axis=1)
    if single.any():
        _refuse(owners[np.argmax(single)], limit, formats.frac_bits)
    extent = np.zeros((len(owners), 2))
    np.maximum.at(extent, window_of, _extent(cut))
    across = (extent[:, 1] > extent[:, 0]) & (sizes[:, 0] > 1) | (sizes[:, 1] == 1)
    good = ~again[window_of]
    parts = cut.heads[good], cut.edges[good], words[good], bounds[good]
    return parts, np.repeat(owners[again], 2), _halves(windows[again], across[again])


def _refuse(triangle: int, limit: float, frac_bits: int) -> NoReturn:
    """A limit that no division meets."""
    raise QuadshadeError(
        f"triangle {triangle}: no part of it is within {limit:g} grey levels of exact with {frac_bits}"
        " fraction bits",
        "raise generic frac_bits or the limit (--divide)",
    )
