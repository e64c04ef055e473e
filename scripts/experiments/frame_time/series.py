# SPDX-License-Identifier: Apache-2.0
"""Frames of a turning scene in a frame time: what each takes, how far it is off, and beside what."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

import quadshade
from quadshade.board.fallbacks import sent_triangles
from quadshade.board.frame_time import BoardClock
from quadshade.choices import PACK_ERROR
from quadshade.contract.formats import Formats
from quadshade.errors import QuadshadeError
from quadshade.rendering import Picture, RenderSettings, Reports, render_picture
from quadshade.rendering.sent_picture import SentPicture, sent_picture
from quadshade.rendering.timing import Levers, Pace

SIZE = (160, 120)
CLOCK_HZ = 100_000_000
RATES = ((1_000_000, 10), (3_000_000, 30))
"""Baud and frames a second: ten thousand bytes a frame both."""

FIXED = ("flat", "gouraud", "quadratic", "quadratic-specular")
LEVELS = 0.88
"""Triangles of a level of a fixed choice, over those of the next finer one."""

QUIET = Reports(notice=lambda _: None)


class Fixed(NamedTuple):
    """A choice for all frames: a shading, and a level of detail."""

    shading: str
    faces: int


def board_clock(baud: int) -> BoardClock:
    """Of a board whose screen is as large as the picture."""
    return BoardClock(CLOCK_HZ, baud, *SIZE)


class Errors:
    """Root mean square of a row of pictures against Phong shading, and of its second difference in time."""

    def __init__(self) -> None:
        self._off: deque[np.ndarray] = deque(maxlen=3)

    def add(self, picture: np.ndarray, reference: np.ndarray) -> tuple[float, float | None]:
        """Error and flicker in grey levels, of which the first two frames have none."""
        self._off.append(picture.astype(float) - reference)
        error = math.sqrt(float(np.square(self._off[-1]).mean()))
        if len(self._off) < 3:
            return error, None
        shaken = self._off[0] - 2 * self._off[1] + self._off[2]
        return error, math.sqrt(float(np.square(shaken).mean()))


class Series:
    """
    A scene that turns once.

    Parameters
    ----------
    scene : str
    frames : int
    ahead : int
      Frames that are looked at before the first is drawn.
    """

    def __init__(self, scene: str, frames: int, ahead: int) -> None:
        self.scene, self.frames, self.ahead = scene, frames, ahead
        # The shorter of both times, after what the core draws on behind the line.
        self.milliseconds = 1000 / RATES[-1][1]
        self.animation = quadshade.turn(
            scene, frames=frames, size=SIZE, engine="model", frame_time=self.milliseconds,
            baud=RATES[-1][0], errors=False, reports=QUIET,
        )  # fmt: skip

    def settings(self, frame: int, **changes: Any) -> RenderSettings:
        """Of a frame, without its time, with a fixed shading and level."""
        settings = self.animation.frame_settings(frame)
        plain = replace(settings, adapt=type(settings.adapt)(), port=type(settings.port)())
        return plain.of_scene(**changes)

    def fixed(self, frame: int, choice: Fixed) -> Picture:
        """A frame by a fixed choice."""
        lod = None if choice.faces >= self.faces else choice.faces
        return render_picture(self.settings(frame, shading=choice.shading, lod=lod), QUIET)

    @cached_property
    def faces(self) -> int:
        """Triangles of the scene."""
        return len(quadshade.load_scene(self.scene))

    def sent(self, picture: Picture) -> SentPicture:
        """What a board gets of a picture."""
        formats = replace(Formats(**picture.stats.generics), stream_width=32)
        triangles, timing = sent_triangles(picture.triangles, formats), picture.stats.timing
        error = PACK_ERROR if timing is None else timing["pack_error"]
        return sent_picture(triangles, formats, error)

    def in_time(self, picture: Picture) -> bool:
        """Whether a picture is complete in both frame times."""
        sent = self.sent(picture)
        return all(sent.clocks(board_clock(rate[0])).whole <= CLOCK_HZ // rate[1] for rate in RATES)

    def best_fixed(self) -> Fixed:
        """The fixed choice with the least mean error of those in time in every frame that is looked at."""
        looked = range(0, self.frames, max(self.frames // self.ahead, 1))
        phong = {frame: self.phong(frame) for frame in looked}
        best, least = None, math.inf
        for shading in FIXED:
            faces = float(self.faces)
            while faces >= 16:
                choice = Fixed(shading, round(faces))
                try:
                    error = self._error_in_time(choice, phong)
                except QuadshadeError:
                    break
                if error is not None:
                    best, least = (choice, error) if error < least else (best, least)
                    break
                faces *= LEVELS
        assert best is not None
        return best

    def _error_in_time(self, choice: Fixed, phong: dict[int, np.ndarray]) -> float | None:
        """Mean square error of a fixed choice over frames, or None where one of them is late."""
        total = 0.0
        for frame, reference in phong.items():
            picture = self.fixed(frame, choice)
            if not self.in_time(picture):
                return None
            total += float(np.square(picture.array - reference).mean())
        return total

    def phong(self, frame: int) -> np.ndarray:
        """Phong shading of all triangles."""
        return render_picture(self.settings(frame, shading="phong"), QUIET).array.astype(float)

    def _drawn(self, frame: int, fixed: Fixed, in_time: Picture) -> dict[str, Picture]:
        """A frame in all ways."""
        unbudgeted = self.fixed(frame, Fixed("quadratic", self.faces))
        return {"frame time": in_time, "fixed": self.fixed(frame, fixed), "unbudgeted": unbudgeted}

    def again(self, row: dict[str, Any]) -> Picture:
        """The picture of a frame whose numbers are known."""
        pace = Pace(levers=Levers(*(row[name] for name in Levers._fields)))
        return self.animation.frame(row["frame"], pace)

    def rows(self, fixed: Fixed, before: Sequence[dict[str, Any]] = ()) -> Iterator[dict[str, Any]]:
        """Every frame in numbers, behind those that are known."""
        pace = self.animation.pace()
        errors = {name: Errors() for name in ("frame time", "fixed", "unbudgeted")}
        for row in before[-2:]:
            # Flicker needs two frames before.
            reference = self.phong(row["frame"])
            for name, picture in self._drawn(row["frame"], fixed, self.again(row)).items():
                errors[name].add(self.sent(picture).shown(SIZE), reference)
            pace = self.animation.pace(Levers(*(row[name] for name in Levers._fields)))
            pace.error = row["pace_error"]
        for frame in range(len(before), self.frames):
            reference = self.phong(frame)
            drawn = self._drawn(frame, fixed, self.animation.frame(frame, pace))
            row: dict[str, Any] = {"scene": self.scene, "frame": frame, "fixed": list(fixed)}
            sent = {name: self.sent(picture) for name, picture in drawn.items()}
            for name, on_line in sent.items():
                key = name.replace(" ", "_")
                row[f"{key}_error"], row[f"{key}_flicker"] = errors[name].add(on_line.shown(SIZE), reference)
            timing = drawn["frame time"].stats.timing
            assert timing is not None
            row["pace_error"] = pace.error
            row |= {name: timing[name] for name in ("faces", "shading", "step", "pack_error", "line_bytes")}
            for rate in RATES:
                clocks = sent["frame time"].clocks(board_clock(rate[0]))
                row[f"line_{rate[0]}"], row[f"whole_{rate[0]}"] = clocks.line, clocks.whole
            row["fixed_whole"] = sent["fixed"].clocks(board_clock(RATES[-1][0])).whole
            yield row
