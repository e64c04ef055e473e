# SPDX-License-Identifier: Apache-2.0
"""Triangles for what a board is built with: its channels, its orders, with or without depth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from operator import index

import numpy as np

from quadshade.contract.formats import LINEAR, ORDER_NAMES, QUADRATIC, Formats
from quadshade.contract.triangles import Pixels, ScreenTriangles
from quadshade.errors import QuadshadeError
from quadshade.image.visible import visible
from quadshade.shading.sample import widened

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
"""Shares of red, green and blue in grey (ITU-R BT.709)."""

COLOURS = 3


def host_formats(formats: Formats) -> Formats:
    """
    Formats for which the host shades, whatever the board can: colour, depth, all orders.

    Parameters
    ----------
    formats : Formats
      The board's.

    Returns
    -------
    Formats
    """
    channels = formats.num_channels if formats.with_shade else COLOURS
    # What a board without depth gives for its bits says nothing of the order that the host draws in.
    wanted = formats.depth_bits if formats.with_depth else Formats.depth_bits
    depth_bits = min(wanted, formats.word_width - 2)
    return replace(formats, num_channels=channels, max_order=QUADRATIC, with_depth=1, depth_bits=depth_bits)


def grey(picture: np.ndarray) -> np.ndarray:
    """(..., 1) float64 luminance of (..., 3) colours."""
    return picture @ LUMINANCE[:, None]


def clear_word(colour: Sequence[int], formats: Formats) -> int:
    """
    The word of CLEAR for a colour.

    Parameters
    ----------
    colour : 3 ints
      0 .. 255; a board of one channel gets its luminance.
    formats : Formats

    Raises
    ------
    QuadshadeError
      Other than three whole numbers in range.
    """
    try:
        levels = [index(level) for level in colour]
    except TypeError:
        levels = []
    if len(levels) != COLOURS or not all(0 <= level <= 255 for level in levels):
        raise QuadshadeError(f"the colour is {colour!r}", "give three whole numbers from 0 to 255")
    if formats.emitted_channels == 1:
        levels = np.rint(grey(np.array(levels, float))).astype(int).tolist()
    return sum(level << 8 * place for place, level in enumerate(levels))


def matched_channels(triangles: ScreenTriangles, formats: Formats) -> tuple[ScreenTriangles, list[str]]:
    """
    The triangles with the board's channels and orders.

    Parameters
    ----------
    triangles : ScreenTriangles
    formats : Formats
      The board's.

    Returns
    -------
    ScreenTriangles
    list of str
      What the user should know.

    Raises
    ------
    QuadshadeError
      No triangles, or channels that cannot be made the board's.
    """
    if not isinstance(triangles, ScreenTriangles):
        raise QuadshadeError(f"the triangles are of type {type(triangles).__name__}", "give ScreenTriangles")
    notices = []
    got, wanted = len(triangles.channels), formats.num_channels
    if triangles.shade is not None and (got != wanted or not formats.with_shade):
        raise QuadshadeError(
            f"the triangles have {got} channels for a shade unit, the board"
            f" {f'{wanted}' if formats.with_shade else 'has none'}",
            "use a --shading of colours",
        )
    if got == COLOURS and wanted == 1:
        triangles = replace(
            triangles,
            samples=np.einsum("c,ncs->ns", LUMINANCE, triangles.samples)[:, None],
            orders=triangles.orders.max(axis=1, keepdims=True),
            channels=("grey",),
        )
        notices.append("drawn in grey: the board has one channel")
    elif got == 1 and wanted >= COLOURS:
        triangles = replace(
            triangles,
            samples=np.repeat(triangles.samples, COLOURS, axis=1),
            orders=np.repeat(triangles.orders, COLOURS, axis=1),
            channels=("r", "g", "b"),
        )
    if len(triangles.channels) < wanted and len(triangles.channels) >= COLOURS:
        triangles = widened(triangles, wanted)
    if len(triangles.channels) != wanted:
        raise QuadshadeError(f"the triangles have {got} channels, the board {wanted}", "give as many")
    if len(triangles) and triangles.orders.max() > formats.max_order:
        triangles = _lowered(triangles, formats.max_order)
        notices.append(f"drawn {ORDER_NAMES[formats.max_order]}: the board's channels are no more")
    return triangles, notices


def _lowered(triangles: ScreenTriangles, order: int) -> ScreenTriangles:
    """The same triangles with no channel of a higher order; a constant one has the corners' mean."""
    samples = triangles.samples
    if order < LINEAR:
        samples = samples.copy()
        higher = triangles.orders > order
        samples[..., 0] = np.where(higher, samples[..., :3].mean(axis=-1), samples[..., 0])
    return replace(triangles, samples=samples, orders=np.minimum(triangles.orders, order))


def sent_triangles(triangles: ScreenTriangles, formats: Formats) -> ScreenTriangles:
    """What :meth:`quadshade.Board.draw` sets up for a board of some formats, in the order it is sent."""
    matched, _ = matched_channels(triangles, formats)
    if formats.with_depth or matched.depth is None:
        return matched
    return replace(painters_order(matched), depth=None)


def painters_order(triangles: ScreenTriangles) -> ScreenTriangles:
    """The same triangles, farthest centre first; depth is kept."""
    if triangles.depth is None:
        raise QuadshadeError("triangles without depth have no painter's order", "give their depth")
    order = np.argsort(-triangles.depth.sum(axis=1), kind="stable")
    return replace(
        triangles,
        vertices=triangles.vertices[order],
        samples=triangles.samples[order],
        orders=triangles.orders[order],
        depth=triangles.depth[order],
    )


def painters_formats(formats: Formats) -> Formats:
    """Formats of a model that draws depth too, beside the channels of a board that has none."""
    widest = replace(host_formats(formats), num_channels=formats.num_channels)
    return replace(widest, max_order=max(formats.max_order, LINEAR))


def painters_notice(drawn: Sequence[Pixels], width: int, height: int) -> str:
    """
    Say how many pixels of a picture in painter's order are not those that a z-buffer would show.

    Parameters
    ----------
    drawn : sequence of Pixels
      With depth, in the order of drawing.
    width, height : int
      Of the screen.

    Returns
    -------
    str
    """
    names = ("triangle", "x", "y", "value", "depth")
    columns = (np.concatenate([getattr(one, name) for one in drawn]) for name in names)
    pixels = Pixels(*columns)
    nearest = visible(pixels, width, height)
    last = visible(replace(pixels, depth=None), width, height)
    shown = nearest >= 0
    differ = (pixels.value[nearest[shown]] != pixels.value[last[shown]]).any(axis=1)
    count = int(np.count_nonzero(differ))
    text = f"{count} of {int(shown.sum())} pixels differ from the z-buffer's picture"
    return f"drawn in painter's order, as the board has no depth: {text}"
