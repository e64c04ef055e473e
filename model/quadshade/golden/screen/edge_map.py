# SPDX-License-Identifier: Apache-2.0
"""
The edge map of a G-buffer (``rtl/screen/edge_map.vhd``) after Nienhaus and Döllner, 4.1.2.

Around a pixel X stand A B C (above), D E (beside), F G H (below); outside the frame stands the nearest pixel
of its border. Everything is integer: a normal's component v is 2v − 255, a depth difference of
2**depth_bits − 1 is 1, a factor 1 − ½d has 17 bits of fraction.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from quadshade.errors import QuadshadeError

DIAGONAL, EIGHT = 0, 1
"""Variants of the depth operator: the diagonal neighbours, or all eight."""

FACTOR_BITS = 17
MIN_WIDTH = 3
DEPTH_BITS = range(8, 17)


def normal_intensity(dots: int) -> int:
    """½((A·H) + (C·F)) in 255ths from the sum of both products in units of 1/255²; 1/510 is 257/2**17."""
    return min((dots * 257 + (1 << 16)) >> 17, 255) if dots > 0 else 0


def factor(difference: int, depth_bits: int) -> int:
    """1 − ½d, the difference widened to 16 bits by its own top bits."""
    fraction = difference << (16 - depth_bits)
    if depth_bits < 16:
        fraction |= difference >> (2 * depth_bits - 16)
    return (1 << FACTOR_BITS) - fraction


def diagonal_intensity(fall: int, rise: int, depth_bits: int) -> int:
    """(1 − ½|A−H|)²(1 − ½|C−F|)² in 255ths; both products are cut off to 17 bits of fraction."""
    product = factor(fall, depth_bits) * factor(rise, depth_bits) >> FACTOR_BITS
    square = product * product >> FACTOR_BITS
    return (square * 255 + (1 << 16)) >> FACTOR_BITS


def eight_intensity(total: int, depth_bits: int) -> int:
    """⅛ of the weighted sum of eight differences in 255ths, at most 255; 1/257 is 255/2**16."""
    wide = total << (16 - depth_bits)
    if depth_bits < 16:
        wide += total >> (2 * depth_bits - 16)
    return min((wide - (wide >> 8) + (1 << 10)) >> 11, 255)


def edge_pixel(window: Sequence[Sequence[int]], depth_bits: int, variant: int) -> tuple[int, int]:
    """
    Edge intensities of one pixel.

    Parameters
    ----------
    window : nine of (nx, ny, nz, depth)
      A B C D X E F G H.
    depth_bits : int
    variant : int
      ``DIAGONAL`` or ``EIGHT``.

    Returns
    -------
    normal, depth : int
      0 .. 255.
    """
    a, b, c, d, x, e, f, g, h = window

    def dot(one: Sequence[int], other: Sequence[int]) -> int:
        return sum((2 * v - 255) * (2 * w - 255) for v, w in zip(one[:3], other[:3], strict=True))

    normal = normal_intensity(dot(a, h) + dot(c, f))
    if variant == DIAGONAL:
        return normal, diagonal_intensity(abs(a[3] - h[3]), abs(c[3] - f[3]), depth_bits)
    corners = sum(abs(pixel[3] - x[3]) for pixel in (a, c, f, h))
    sides = sum(abs(pixel[3] - x[3]) for pixel in (b, d, e, g))
    return normal, eight_intensity(corners + 2 * sides, depth_bits)


def edge_map_scalar(
    pixels: Sequence[Sequence[int]], width: int, height: int, depth_bits: int, variant: int
) -> list[tuple[int, int]]:
    """
    The edge map, one pixel at a time.

    Parameters
    ----------
    pixels : sequence of (nx, ny, nz, depth)
      In scanline order.
    width, height : int
    depth_bits, variant : int

    Returns
    -------
    list of (normal, depth)
    """

    def at(x: int, y: int) -> Sequence[int]:
        return pixels[min(max(y, 0), height - 1) * width + min(max(x, 0), width - 1)]

    return [
        edge_pixel([at(x + i, y + j) for j in (-1, 0, 1) for i in (-1, 0, 1)], depth_bits, variant)
        for y in range(height)
        for x in range(width)
    ]


def shifted(picture: np.ndarray) -> list[np.ndarray]:
    """Nine pictures whose pixels are A B C D X E F G H of each pixel, borders repeated."""
    height, width = picture.shape[:2]
    padded = np.pad(picture, [(1, 1), (1, 1)] + [(0, 0)] * (picture.ndim - 2), mode="edge")
    return [padded[j : j + height, i : i + width] for j in range(3) for i in range(3)]


def edge_map(
    normal: np.ndarray, depth: np.ndarray, depth_bits: int = 8, variant: int = DIAGONAL
) -> tuple[np.ndarray, np.ndarray]:
    """
    The edge map of a G-buffer, in NumPy: the same integers as :func:`edge_map_scalar`.

    Parameters
    ----------
    normal : (h, w, 3) uint8
      Component c of a unit normal as 255 (c + 1) / 2.
    depth : (h, w) int
      0 .. 2**depth_bits − 1, linear in view distance.
    depth_bits : int
      8 .. 16.
    variant : int
      ``DIAGONAL`` (intensity 1 where there is no edge) or ``EIGHT`` (0 where there is none).

    Returns
    -------
    normal, depth : (h, w) uint8
      Intensities in 255ths. Variants differ in the second only.

    Raises
    ------
    QuadshadeError
      Shapes, depth_bits or variant out of range, or a frame narrower than three pixels.
    """
    if normal.shape != (*depth.shape, 3) or depth.ndim != 2 or depth.shape[1] < MIN_WIDTH or not len(depth):
        raise QuadshadeError(
            f"no G-buffer: normals of shape {normal.shape}, depth of {depth.shape}",
            "give (h, w, 3) and (h, w), w at least 3",
        )
    if depth_bits not in DEPTH_BITS or variant not in (DIAGONAL, EIGHT):
        raise QuadshadeError(
            f"depth_bits {depth_bits}, variant {variant}", "depth_bits is 8 to 16, variant 0 or 1"
        )
    if depth.min() < 0 or depth.max() >= 1 << depth_bits:
        raise QuadshadeError(
            f"a depth does not fit in {depth_bits} bits", "scale it to 0 .. 2**depth_bits - 1"
        )
    a, _, c, _, _, _, f, _, h = shifted(2 * normal.astype(np.int64) - 255)
    dots = (a * h).sum(axis=2) + (c * f).sum(axis=2)
    intensity = np.clip((np.maximum(dots, 0) * 257 + (1 << 16)) >> 17, 0, 255)
    a, b, c, d, x, e, f, g, h = shifted(depth.astype(np.int64))
    if variant == EIGHT:
        corners = sum(abs(z - x) for z in (a, c, f, h))
        total = corners + 2 * sum(abs(z - x) for z in (b, d, e, g))
        wide = total << (16 - depth_bits)
        if depth_bits < 16:
            wide += total >> (2 * depth_bits - 16)
        jump = np.minimum((wide - (wide >> 8) + (1 << 10)) >> 11, 255)
    else:
        products = []
        for difference in (abs(a - h), abs(c - f)):
            fraction = difference << (16 - depth_bits)
            if depth_bits < 16:
                fraction |= difference >> (2 * depth_bits - 16)
            products.append((1 << FACTOR_BITS) - fraction)
        product = products[0] * products[1] >> FACTOR_BITS
        jump = ((product * product >> FACTOR_BITS) * 255 + (1 << 16)) >> FACTOR_BITS
    return intensity.astype(np.uint8), jump.astype(np.uint8)
