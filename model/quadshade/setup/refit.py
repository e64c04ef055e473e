# SPDX-License-Identifier: Apache-2.0
"""
Primitives for a core of other formats: the same pixels with the same bits, or a reason why it has none.

A word with more fraction bits holds the same number further up, and what a lane emits of it is the same. It
must wrap at the same number too, so the bits above the fraction have to be as many. Edges are integers of
their own, and those of few scanlines need few bits, whatever the sub-pixels were.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from quadshade.contract.formats import CONSTANT, Formats
from quadshade.errors import QuadshadeError
from quadshade.setup.packet import Primitives
from quadshade.setup.short_edges import MOST_TRIES, short_edges

COLOURS = 3
MOST_COORD_BITS = 13


def picture_formats(boards: Sequence[Formats], width: int, height: int) -> Formats:
    """
    Formats of a picture that boards draw together, bit for bit the same: what all of them have.

    Parameters
    ----------
    boards : sequence of Formats
      At least one.
    width, height : int
      Pixels of the picture, which may be more than a board's coordinates can say.

    Returns
    -------
    Formats
      Of one board those of the board, but for the coordinates.

    Raises
    ------
    QuadshadeError
      A size that no core can address.
    """
    largest = 1 << MOST_COORD_BITS
    if not (1 <= width <= largest and 1 <= height <= largest):
        raise QuadshadeError(
            f"the picture has {width}x{height} pixels",
            f"give 1x1 to {largest}x{largest} (generic coord_bits)",
        )
    shortest = min(boards, key=lambda formats: formats.frac_bits)
    return replace(
        shortest,
        num_channels=min(formats.num_channels for formats in boards),
        max_order=min(formats.max_order for formats in boards),
        with_depth=min(formats.with_depth for formats in boards),
        subpixel_bits=max(formats.subpixel_bits for formats in boards),
        coord_bits=max(shortest.coord_bits, (max(width, height) - 1).bit_length()),
    )


def why_unfit(picture: Formats, board: Formats) -> str:
    """Why a board does not draw a picture of some formats bit for bit; empty where it does."""
    shade = ("with_shade", "num_specular", "shade_guard_bits", "num_channels") if picture.with_shade else ()
    for name in ("with_shade", "value_bits", *shade):
        if getattr(board, name) != getattr(picture, name):
            return f"its {name} is {getattr(board, name)}, the picture's {getattr(picture, name)}"
    if board.num_channels != picture.num_channels and not (
        board.num_channels >= COLOURS and picture.num_channels in (1, COLOURS)
    ):
        plural = "s" * (board.num_channels != 1)
        return f"it has {board.num_channels} channel{plural}, the picture {picture.num_channels}"
    if board.max_order < picture.max_order:
        return f"its max_order is {board.max_order}, the picture's {picture.max_order}"
    above = picture.word_width - picture.frac_bits
    if board.frac_bits < picture.frac_bits or board.word_width - board.frac_bits != above:
        return (
            f"its words have {board.word_width} bits, {board.frac_bits} of them fraction, the picture's"
            f" {picture.word_width} and {picture.frac_bits}"
        )
    if picture.with_depth and (board.with_depth, board.depth_bits) != (1, picture.depth_bits):
        have = f"{board.depth_bits} bits of depth" if board.with_depth else "no depth"
        return f"it has {have}, the picture {picture.depth_bits} bits"
    return ""


def refit(primitives: Primitives, picture: Formats, board: Formats) -> Primitives:
    """
    Primitives of a picture for a board that is fit (:func:`why_unfit`), with edges in few bits.

    Parameters
    ----------
    primitives : Primitives
      Cut to the board's screen.
    picture, board : Formats

    Returns
    -------
    Primitives
      Without depth in the picture, a board that has it gets depth 0 and the packets in reverse: of equally
      near pixels the first one stays, where the picture has the last one.

    Raises
    ------
    QuadshadeError
      An edge that the board's fields do not hold.
    """
    # A channel that the picture does not have is constant 0.
    spare = ((0, 0), (0, 1))
    channels = _channels(picture, board)
    shifts = np.array(board.channel_frac_bits) - np.array([*picture.channel_frac_bits, 0])[channels]
    words = np.pad(primitives.words, (*spare, (0, 0)))[:, channels] << np.maximum(shifts, 0)[:, None]
    orders = np.pad(primitives.orders, spare, constant_values=CONSTANT)[:, channels]
    bound = np.pad(primitives.bound, spare)[:, channels]
    rows = primitives.header["rows_first"] + primitives.header["rows_second"]
    edges = short_edges(primitives, max(MOST_TRIES, 1 + int(rows.max(initial=0))))
    for name, edge in edges.items():
        size = 1 << board.edge_bits
        low, high = (-size, size - 1)
        if not ((edge["error"] >= low) & (edge["error"] <= high) & (edge["decrement"] >= low)).all():
            raise QuadshadeError(
                f"a {name} edge does not fit in {board.edge_bits} bits", "build boards with more coord_bits"
            )
    made = replace(primitives, words=words, orders=orders, bound=bound, edges=edges)
    return _reversed(made) if board.with_depth and not picture.with_depth else made


def _channels(picture: Formats, board: Formats) -> list[int]:
    """For each of a board's channels the picture's, -1 for none: grey in all three colours, depth last."""
    colours = list(range(picture.num_channels))
    if picture.num_channels == 1 and board.num_channels >= COLOURS:
        colours = [0] * COLOURS
    colours += [-1] * (board.num_channels - len(colours))
    depth = picture.num_channels if picture.with_depth else -1
    return colours + [depth] * board.with_depth


def _reversed(primitives: Primitives) -> Primitives:
    """The same primitives, last one first."""

    def back(columns: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        return {name: column[::-1] for name, column in columns.items()}

    return Primitives(
        primitives.triangle[::-1],
        back(primitives.header),
        {name: back(edge) for name, edge in primitives.edges.items()},
        primitives.orders[::-1],
        primitives.words[::-1],
        primitives.bound[::-1],
        primitives.undefined[::-1],
    )
