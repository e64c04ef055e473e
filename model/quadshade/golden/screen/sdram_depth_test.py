# SPDX-License-Identifier: Apache-2.0
"""A z-buffer and a picture in an SDRAM (``rtl/screen/sdram_depth_test.vhd``): what is in it in the end."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from quadshade.golden.common.sdram_controller import SdramGenerics

DEPTH_PLANE = 2
"""Beside the planes of values, 0 and 1."""


class Pixel(NamedTuple):
    """What is drawn."""

    x: int
    y: int
    value: int
    depth: int


def span_clocks(words: int, generics: SdramGenerics) -> int:
    """
    Clocks from the acceptance of a span's first run to that of the next span's, which waits.

    Parameters
    ----------
    words : int
      Pixels of the span, of which one at least is nearer.
    generics : SdramGenerics
      Of the controller, which nobody else asks.
    """
    write = generics.run_clocks(words, True)
    read = generics.rcd_clocks + generics.cas_clocks + words + 4
    return read + max(generics.rcd_clocks + words + 2, write) + max(generics.rcd_clocks + words + 3, write)


class SdramDepthTest:
    """
    Keeps the nearest pixel of every place; of equally near ones the first.

    Parameters
    ----------
    width, height : int
    depth_bits : int
      A word of a depth has one more, which is set where nothing was drawn.
    data_bits : int
      Of a word of the memory.
    run_words : int
      A run does not go over a multiple of it.

    Attributes
    ----------
    words : dict of int
      By (plane, y, x).
    plane : int
      Of values, that is drawn.
    """

    def __init__(
        self, width: int, height: int, depth_bits: int = 15, data_bits: int = 16, run_words: int = 64
    ) -> None:
        self.width, self.height, self.run_words = width, height, run_words
        self.depth_bits, self.data_bits = depth_bits, data_bits
        self.words: dict[tuple[int, int, int], int] = {}
        self.plane = 0

    def address(self, plane: int, y: int, x: int) -> int:
        """A word's address in the memory."""
        y_bits, x_bits = ((count - 1).bit_length() for count in (self.height, self.width))
        return (plane << y_bits | y) << x_bits | x

    def clear(self, value: int) -> None:
        """Fill the plane that is drawn, and that of depths."""
        for y in range(self.height):
            for x in range(self.width):
                self.words[self.plane, y, x] = value
                self.words[DEPTH_PLANE, y, x] = (1 << self.data_bits) - 1

    def draw(self, pixel: Pixel) -> None:
        """Draw a pixel; one outside the screen is dropped."""
        x, y, value, depth = pixel
        if x < self.width and y < self.height:
            far = 1 << self.depth_bits
            if depth < self.words[DEPTH_PLANE, y, x] % (2 * far):
                self.words[DEPTH_PLANE, y, x], self.words[self.plane, y, x] = depth, value

    def spans(self, pixels: list[Pixel]) -> Iterator[list[Pixel]]:
        """Pixels on the screen that are moved together, if each comes in the clock after the one before."""
        span: list[Pixel] = []
        for pixel in pixels:
            if pixel.x >= self.width or pixel.y >= self.height:
                continue
            if span and not self._joins(span, pixel):
                yield span
                span = []
            span.append(pixel)
        if span:
            yield span

    def _joins(self, span: list[Pixel], pixel: Pixel) -> bool:
        """Whether a pixel stands beside those of a span, between the same multiples of a run."""
        block = pixel.x // self.run_words == span[0].x // self.run_words
        columns = [one.x for one in span]
        return block and pixel.y == span[0].y and pixel.x in (min(columns) - 1, max(columns) + 1)
