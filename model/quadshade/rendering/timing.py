# SPDX-License-Identifier: Apache-2.0
"""How a picture keeps a frame time, for its statistics and its summary."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any, NamedTuple

from quadshade.board.frame_time import BoardClock, PictureClocks
from quadshade.choices import PACK_ERROR
from quadshade.rendering.settings import RenderSettings


class Levers(NamedTuple):
    """
    Triangles of the level of detail, kind of channels, where along its curve of pictures, and grey levels
    that words are packed to.
    """

    faces: int
    shading: str
    step: int
    pack_error: float = PACK_ERROR


@dataclass
class Pace:
    """
    What the frames so far were drawn with.

    Attributes
    ----------
    ahead : callable, optional
      Gives settings of other frames of the same scene, for which level and channels are to be chosen, too.
    levers : Levers, optional
      Of the frame before.
    error : float
      Root mean square, of when level and channels were chosen; by the curve's own measure.
    """

    ahead: Callable[[], Sequence[RenderSettings]] | None = None
    levers: Levers | None = None
    error: float = field(default=math.inf)


@dataclass(frozen=True)
class Timing:
    """
    How a picture keeps its time.

    Attributes
    ----------
    milliseconds : float
    clock : BoardClock
    clocks : PictureClocks
      At most, on an undamaged line.
    levers : Levers
    vertices : int
      Parts of triangles that go as vertices.
    """

    milliseconds: float
    clock: BoardClock
    clocks: PictureClocks
    levers: Levers
    vertices: int = 0

    @property
    def deadline(self) -> int:
        """Clocks until the frame time is over."""
        return deadline_clocks(self.milliseconds, self.clock)

    def as_dict(self) -> dict[str, Any]:
        """What ``--stats`` writes."""
        clocks = {f"clocks_{name}": value for name, value in asdict(self.clocks).items()}
        clocks["line_bytes"] = clocks.pop("clocks_line_bytes")
        board = {"milliseconds": self.milliseconds, "baud": self.clock.baud}
        board |= {"clk_frequency_hz": self.clock.clk_frequency_hz, "deadline": self.deadline}
        return board | clocks | self.levers._asdict() | {"vertices": self.vertices}

    def note(self) -> str:
        """A labelled line of the summary."""
        share = 1000 / self.clock.clk_frequency_hz
        whole, line = self.clocks.whole * share, self.clocks.line * share
        error = self.levers.pack_error
        packed = f"; words packed to {error:g} grey levels" if error > PACK_ERROR else ""
        if self.vertices:
            packed += f"; {self.vertices} triangles as vertices"
        return (
            f"\n  time       at most {whole:.2f} of {self.milliseconds:g} ms, the line {line:.2f}, at "
            f"{self.clock.baud} baud and {self.clock.clk_frequency_hz / 1e6:g} MHz{packed}"
        )


def deadline_clocks(milliseconds: float, clock: BoardClock) -> int:
    """Whole clocks of a frame time."""
    return math.floor(milliseconds * clock.clk_frequency_hz / 1000)
