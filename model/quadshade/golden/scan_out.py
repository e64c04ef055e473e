# SPDX-License-Identifier: Apache-2.0
"""The picture on a monitor (``rtl/scan_out.vhd``, ``rtl/tmds_encoder.vhd``): words of three TMDS lanes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from quadshade.errors import QuadshadeError

CONTROL_WORDS = (0b1101010100, 0b0010101011, 0b0101010100, 0b1010101011)
"""By the two control bits, bit 0 goes first (Digital Visual Interface 1.0, 3.3.3)."""


@dataclass(frozen=True)
class Timing:
    """
    Columns and lines of a frame: what is shown, a rest, the pulse, a rest. 640 x 480 at 60 Hz if left out.
    """

    columns: int = 640
    column_front: int = 16
    column_sync: int = 96
    column_back: int = 48
    lines: int = 480
    line_front: int = 10
    line_sync: int = 2
    line_back: int = 33

    @property
    def all_columns(self) -> int:
        """Pixels of a line."""
        return self.columns + self.column_front + self.column_sync + self.column_back

    @property
    def all_lines(self) -> int:
        """Lines of a frame."""
        return self.lines + self.line_front + self.line_sync + self.line_back


class TmdsEncoder:
    """
    One lane's encoder (Digital Visual Interface 1.0, figure 3-5), a word at a time.

    Attributes
    ----------
    disparity : int
      Ones minus zeros since the lane was last inactive.
    """

    def __init__(self) -> None:
        self.disparity = 0

    def encode(self, value: int | None, control: int = 0) -> int:
        """
        The word of a byte, or of two control bits.

        Parameters
        ----------
        value : int or None
          0 .. 255; None while nothing is shown.
        control : int
          0 .. 3.

        Returns
        -------
        int
          Ten bits, bit 0 goes first.
        """
        if value is None:
            self.disparity = 0
            return CONTROL_WORDS[control]
        ones = value.bit_count()
        equal = ones > 4 or (ones == 4 and not value & 1)
        word = value & 1
        for index in range(1, 8):
            bit = (word >> (index - 1) ^ value >> index) & 1
            word |= (bit ^ equal) << index
        excess = 2 * word.bit_count() - 8
        if self.disparity == 0 or excess == 0:
            inverts = equal
            self.disparity += -excess if inverts else excess
        elif (self.disparity > 0) == (excess > 0):
            inverts = True
            self.disparity += 2 * (not equal) - excess
        else:
            inverts = False
            self.disparity += excess - 2 * equal
        return inverts << 9 | (not equal) << 8 | (word ^ 0xFF if inverts else word)


def decode(word: int) -> int:
    """The byte of a word that is no control word."""
    bits = word & 0xFF ^ (0xFF if word >> 9 else 0)
    moved = bits ^ bits << 1 & 0xFF
    return moved if word >> 8 & 1 else moved ^ 0xFE


def frame_words(picture: np.ndarray, timing: Timing = Timing()) -> Iterator[tuple[int, int, int]]:
    """
    Words of a frame: the pixels of every line, from the top left one.

    Parameters
    ----------
    picture : (height, width, 1 or 3) uint8
      Its pixels become squares that fill what is shown.
    timing : Timing

    Yields
    ------
    (int, int, int)
      Of lanes 0 (blue, with both pulses), 1 (green) and 2 (red).

    Raises
    ------
    QuadshadeError
      Whole squares do not fill what is shown.
    """
    height, width, _ = picture.shape
    scale = timing.columns // width
    if scale == 0 or (scale * width, scale * height) != (timing.columns, timing.lines):
        raise QuadshadeError(
            f"{width} x {height} pixels do not fill {timing.columns} x {timing.lines} as squares",
            "give a screen that does, 320 x 240 or 160 x 120",
        )
    rgb = np.broadcast_to(picture, (height, width, 3)).repeat(scale, axis=0).repeat(scale, axis=1).tolist()
    encoders = [TmdsEncoder() for _ in range(3)]
    column_pulse = range(timing.columns + timing.column_front, timing.all_columns - timing.column_back)
    line_pulse = range(timing.lines + timing.line_front, timing.all_lines - timing.line_back)
    for line in range(timing.all_lines):
        for column in range(timing.all_columns):
            control = (line not in line_pulse) << 1 | (column not in column_pulse)
            shown = line < timing.lines and column < timing.columns
            red, green, blue = rgb[line][column] if shown else (None, None, None)
            yield (
                encoders[0].encode(blue, control),
                encoders[1].encode(green),
                encoders[2].encode(red),
            )
