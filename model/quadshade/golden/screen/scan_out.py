# SPDX-License-Identifier: Apache-2.0
"""The picture on a monitor (``rtl/screen/scan_out.vhd``): words of the three TMDS data channels."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from quadshade.errors import QuadshadeError
from quadshade.golden.screen.tmds_encoder import TmdsEncoder


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
      Of TMDS data channels 0 (blue, with both pulses), 1 (green) and 2 (red).

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
