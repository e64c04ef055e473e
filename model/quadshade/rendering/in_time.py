# SPDX-License-Identifier: Apache-2.0
"""
A frame time as a budget: the best picture that a board has complete when it is over.

What a picture takes is what :mod:`quadshade.board.frame_time` says, in bytes that the line could have carried
until then. The level of detail and the kind of channels are chosen once, for all frames that are looked at
ahead; each frame then spends what is left of its time on orders and division. A frame starts from the levers
of the one before and moves only where they no longer fit, so that nothing pops.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from quadshade.adapt import Adapted, ErrorCurve
from quadshade.adapt.adapted import SHADERS
from quadshade.adapt.curve import Curve, Picture
from quadshade.board.fallbacks import sent_triangles
from quadshade.board.frame_time import BoardClock, PictureClocks, soonest_picture
from quadshade.choices import ADAPTIVE_SHADINGS, parse_pack_error
from quadshade.contract.formats import Formats
from quadshade.contract.triangles import ScreenTriangles
from quadshade.errors import QuadshadeError
from quadshade.link.transport import DEFAULT_BAUD
from quadshade.rendering.levels import phong_picture
from quadshade.rendering.sent_picture import SentPicture
from quadshade.rendering.settings import RenderSettings, Reports
from quadshade.rendering.shade import ShownScene, at_level, show_scene
from quadshade.rendering.shown_triangles import shown_triangles
from quadshade.rendering.timing import Levers, Pace, Timing, deadline_clocks
from quadshade.scene.decimate import LEAST
from quadshade.shading import UnsuitedError, specular_formats

ASSUMED_HZ = 100_000_000
FINER = 0.88
"""Triangles of a level that is looked at, over those of the one before."""
WORSE = 2
"""So many levels in a row that are worse than one with more triangles end the search."""
USED = 0.97
"""Of the time: what is spent at least, or the next frame moves on along the curve."""
SURE = 0.97
"""Of the time: what the cheapest picture of a level may take at most in the frames that are looked at."""
ENOUGH = {"max": 0.55, "rms": 0.3}
"""Grey levels: where nearly all of the error is the output's rounding, nothing more is spent."""
WIDTH = 32
"""First step along a curve on which nothing is known."""
COARSER = 0.9
"""Of a finer level's error, which a coarser one must be under: other triangles have other outlines, and
those flicker."""
SHORTER = (1 / 8, 1 / 2, 1.0, 2.0, 3.0)
"""Grey levels that words may be packed to; beyond, what they add is more than what they leave room for."""
COMPARED = 4
"""Of the frames that are looked at, those whose pictures are compared; all must be in time."""
TOO_FAR = 2.0
"""Times the error of when the levers were chosen: from then on they are chosen anew,"""
BETTER = 0.8
"""and changed where that leaves less than this share of it."""


class FrameTime:
    """
    Pictures in time, of one scene for one board.

    Parameters
    ----------
    settings : RenderSettings
    formats : Formats
      From :meth:`RenderSettings.checked`.
    clock : BoardClock
    reports : Reports
    board : Formats, optional
      Of a board that is open; by default one that is the core.
    """

    def __init__(
        self,
        settings: RenderSettings,
        formats: Formats,
        clock: BoardClock,
        reports: Reports,
        board: Formats | None = None,
    ) -> None:
        given = settings.adapt.frame_time
        assert given is not None
        self.milliseconds = float(given)
        self.formats, self.clock, self.board = formats, clock, board
        self._settings, self._reports = settings, reports
        least = parse_pack_error(settings.port.added_error)
        shorter = SHORTER if settings.port.pack_error is None else ()
        self._errors = (least, *(error for error in shorter if error > least))
        self._sent: tuple[ScreenTriangles, float, SentPicture, PictureClocks] | None = None
        self._a_byte = clock.clocks_of_bytes(1)
        self.budget = math.floor(deadline_clocks(self.milliseconds, clock) / self._a_byte)

    def sent(
        self, triangles: ScreenTriangles, core: Formats, error: float
    ) -> tuple[SentPicture, PictureClocks]:
        """A picture of words packed to an error, and what it takes; of the same one again it is known."""
        if self._sent is None or self._sent[0] is not triangles or self._sent[1] != error:
            matched, formats = triangles, replace(core, stream_width=32)
            if self.board is not None:
                matched, formats = sent_triangles(triangles, self.board), self.board
            setup = self._settings.setup.arguments()
            packed, clocks = soonest_picture(matched, formats, self.clock, error, **setup)
            self._sent = triangles, error, SentPicture(packed, matched.shade, formats), clocks
        return self._sent[2:]

    def curve(self, settings: RenderSettings, shown: ShownScene, shading: str, error: float) -> Curve | None:
        """
        Pictures of one kind of channels, or None where the scene or the board has no such channels.

        They cost the bytes that the line could have carried until a picture is complete.
        """

        projected, lights, surface = shown.projected, shown.lights, shown.surface
        specular = None

        def cost(triangles: ScreenTriangles, core: Formats) -> int:
            return math.ceil(self.sent(triangles, core, error)[1].whole / self._a_byte)

        if shading != ADAPTIVE_SHADINGS[0]:
            try:
                specular = specular_formats(settings.scene.set_generics, projected, lights, surface)
            except UnsuitedError:
                return None
        try:
            curves = ErrorCurve(
                projected, lights, surface, self.formats,
                measure=settings.adapt.measure, verify=settings.adapt.is_verified, shading=shading,
                specular=specular, count_line=cost,
            )  # fmt: skip
        except UnsuitedError:
            return None
        return curves.curves[0]

    def shadings(self) -> tuple[str, ...]:
        """Kinds of channels that may be taken."""
        asked = self._settings.scene.shading
        if asked is None:
            return tuple(SHADERS)
        return (asked,) if asked == ADAPTIVE_SHADINGS[0] else tuple(SHADERS)[1:]

    def near(self, curve: Curve, start: int | None) -> tuple[Picture, int] | None:
        """
        The picture that spends the time, looked for from a place of the curve on; None where none is in time.

        A place that still spends it is kept.
        """
        if start is not None and USED * self.budget <= curve.picture(start).cost("line") <= self.budget:
            return curve.picture(start), start
        low, high = -1, len(curve)
        at, width = (len(curve) // 2, WIDTH) if start is None else (start, 1)
        while high - low > 1:
            picture = curve.picture(at)
            low, high = (at, high) if picture.cost("line") <= self.budget else (low, at)
            if low == at and picture.error <= ENOUGH[curve.planner.measure]:
                break
            if high == len(curve):
                at = min(low + width, high - 1)
            else:
                at = max(high - width, 0) if low < 0 else (low + high) // 2
            width *= 2
        return None if low < 0 else (curve.picture(low), low)

    def _counts(self, faces: int) -> list[int]:
        """Triangles of the levels, falling."""
        if self._settings.scene.level is not None:
            return [faces]
        steps = int(math.log(max(faces, LEAST) / LEAST) / -math.log(FINER))
        return [faces, *dict.fromkeys(round(faces * FINER**step) for step in range(1, steps + 1))]

    def _least(self, settings: RenderSettings, shown: ShownScene) -> int:
        """What the cheapest picture of colours takes, in bytes; 0 of a scene that is not seen."""
        if not len(shown.projected):
            return 0
        curve = self.curve(settings, shown, ADAPTIVE_SHADINGS[0], self._errors[-1])
        return 0 if curve is None else curve.picture(0).cost("line")

    def _level(self, settings: RenderSettings, shown: ShownScene, count: int) -> ShownScene | None:
        """What is seen of the scene at a level, None where there is no such one."""
        if count < shown.faces:
            try:
                shown = at_level(shown, count, settings.scene, self.formats)
            except QuadshadeError:
                return None
        seen = shown_triangles(shown.projected, self.formats, settings.style.needs_gbuffer)
        return replace(shown, projected=seen)

    def choose(self, frames: Sequence[tuple[RenderSettings, ShownScene]]) -> Levers:
        """
        The level and the channels with the least error from Phong shading of all triangles, over some frames.

        Raises
        ------
        QuadshadeError
          No picture is in time.
        """
        counts = self._counts(frames[0][1].faces)
        best, least = None, math.inf
        compared = frames[:: max(len(frames) // COMPARED, 1)]
        references = [phong_picture(each, one, self.formats) for each, one in compared]
        first = self._first_in_time(frames, counts)
        for error in self._errors:
            found, square = self._best(compared, references, counts[first:], error)
            if best is None or square < least:
                best, least = found, square
            elif not self.clock.takes_vertices:
                # Vertices hardly get shorter; fields may be the better ones in the end.
                break
        if best is None:
            raise self._refusal(counts, frames)
        return best

    def _best(
        self,
        frames: Sequence[tuple[RenderSettings, ShownScene]],
        references: Sequence[np.ndarray],
        counts: Sequence[int],
        error: float,
    ) -> tuple[Levers | None, float]:
        """Level and channels with the least mean square error, of words packed to an error; None: no one."""
        # The last one tells levels apart best; where it takes too much of each, the first one does.
        for search in reversed(self.shadings()):
            best, least, worse = None, math.inf, 0
            for count in counts:
                self._reports.step(f"planning {count} triangles")
                levels = [self._level(each, one, count) for each, one in frames]
                if any(level is None for level in levels):
                    break
                square = self._mean_square(frames, levels, references, Levers(count, search, -1, error))
                if square < (COARSER**2 * least if best else least):
                    best, least, worse = (count, levels), square, 0
                else:
                    worse += best is not None
                if worse == WORSE or (best is None and count < counts[0] * FINER**WORSE):
                    break
            if best is not None:
                break
        else:
            return None, math.inf
        count, levels = best
        kinds = {
            shading: least
            if shading == search
            else self._mean_square(frames, levels, references, Levers(count, shading, -1, error))
            for shading in self.shadings()
        }
        shading = min(kinds, key=lambda shading: kinds[shading])
        return Levers(count, shading, -1, error), kinds[shading]

    def _first_in_time(self, frames: Sequence[tuple[RenderSettings, ShownScene]], counts: list[int]) -> int:
        """By bisection: the finest level of which the cheapest picture is surely in time in all frames."""
        sure = self.budget if len(frames) == 1 else int(SURE * self.budget)

        def fits(index: int) -> bool:
            levels = [(settings, self._level(settings, shown, counts[index])) for settings, shown in frames]
            return all(level is None or self._least(settings, level) <= sure for settings, level in levels)

        low, high = 0, len(counts) - 1
        if not fits(high):
            raise self._refusal(counts, frames)
        while low < high:
            middle = (low + high) // 2
            low, high = (low, middle) if fits(middle) else (middle + 1, high)
        return low

    def _refusal(
        self, counts: Sequence[int], frames: Sequence[tuple[RenderSettings, ShownScene]]
    ) -> QuadshadeError:
        """The error for a frame time that nothing meets, with what the coarsest level takes that there is."""
        least = 0
        for count in reversed(counts):
            levels = [(settings, self._level(settings, shown, count)) for settings, shown in frames]
            taken = [self._least(settings, level) for settings, level in levels if level is not None]
            if taken:
                least = max(taken)
                break
        milliseconds = least * self._a_byte * 1000 / self.clock.clk_frequency_hz
        return QuadshadeError(
            f"the frame time is {self.milliseconds:g} ms, at {self.clock.baud} baud",
            f"the coarsest picture takes {math.ceil(100 * milliseconds) / 100:g} ms: give more",
        )

    def _mean_square(
        self,
        frames: Sequence[tuple[RenderSettings, ShownScene]],
        levels: Sequence[ShownScene | None],
        references: Sequence[np.ndarray],
        levers: Levers,
    ) -> float:
        """Mean square from Phong shading of all triangles; infinite where a frame is not in time."""
        total = 0.0
        for (settings, _), level, reference in zip(frames, levels, references, strict=True):
            if level is None or not len(level.projected):
                continue
            found = self._planned_at(settings, level, levers)
            if found is None:
                return math.inf
            sent, _ = self.sent(found.adapted.triangles, found.adapted.formats, found.levers.pack_error)
            drawn = sent.shown((level.projected.width, level.projected.height), level.ground)
            total += float(np.square(drawn - reference).mean())
        return total / len(frames)

    def picture(self, settings: RenderSettings, shown: ShownScene, pace: Pace) -> tuple[ShownScene, Timing]:
        """
        The scene of a frame as it is drawn in time, and how it keeps it; the pace goes on from there.

        Raises
        ------
        QuadshadeError
          No picture is in time.
        """
        found = None if pace.levers is None else self._keep(settings, shown, pace.levers)
        if found is None or found.error > TOO_FAR * pace.error:
            chosen = self._choose_anew(settings, shown, pace)
            if found is None or chosen.error < BETTER * found.error:
                if pace.levers is not None:
                    self._reports.notice(f"now {chosen.levers.faces} triangles, {chosen.levers.shading}")
                found = chosen
            pace.error = found.error
        pace.levers = found.levers
        adapted = found.adapted
        sent, clocks = self.sent(adapted.triangles, adapted.formats, found.levers.pack_error)
        adapted = replace(adapted, line_bytes=clocks.line_bytes)
        timing = Timing(self.milliseconds, self.clock, clocks, found.levers, sent.packed.sent_vertices)
        return replace(found.scene, adapted=adapted), timing

    def _choose_anew(self, settings: RenderSettings, shown: ShownScene, pace: Pace) -> Found:
        """Level and channels for this frame, and at first for those ahead."""
        frames = [(settings, shown)]
        if pace.levers is None and pace.ahead is not None:
            same = {"generics": self._settings.scene.generics, "size": self._settings.scene.size}
            others = [one.styled().of_scene(**same) for one in pace.ahead()]
            quiet = replace(self._reports, notice=lambda _: None)
            frames += [(one, show_scene(one, self.formats, quiet)) for one in others]
        levers = self.choose(frames)
        found = self._keep(settings, shown, levers)
        if found is None:
            raise self._refusal([levers.faces], frames[:1])
        return found

    def _keep(self, settings: RenderSettings, shown: ShownScene, levers: Levers) -> Found | None:
        """The frame with level and channels as they are; None where that is not in time."""
        level = self._level(settings, shown, levers.faces)
        return None if level is None else self._planned(settings, level, levers)

    def _planned(self, settings: RenderSettings, level: ShownScene, levers: Levers) -> Found | None:
        """A level with such channels; words are as short as it takes, None where that is not in time."""
        # They stay as short, so that nothing pops.
        for error in (one for one in self._errors if one >= min(levers.pack_error, self._errors[-1])):
            found = self._planned_at(settings, level, levers._replace(pack_error=error))
            if found is not None:
                return found
        return None

    def _planned_at(self, settings: RenderSettings, level: ShownScene, levers: Levers) -> Found | None:
        """The same of words that are no shorter than these levers say."""
        curve = self.curve(settings, level, levers.shading, levers.pack_error)
        near = None if curve is None else self.near(curve, None if levers.step < 0 else levers.step)
        if near is None:
            return None
        picture, step = near
        adapted = picture.plan.adapted(settings.adapt.is_verified)
        return Found(level, adapted, levers._replace(step=step), picture.error)


def assumed_clock(settings: RenderSettings) -> BoardClock:
    """Of a board that is not there: by default the clock of a ULX3S; a screen as large as the picture."""
    clock = settings.adapt.clock
    hertz = ASSUMED_HZ if clock is None else round(1e6 * clock)
    return BoardClock(hertz, settings.port.baud or DEFAULT_BAUD, *settings.scene.pixels)


def in_time(
    settings: RenderSettings,
    shown: ShownScene,
    formats: Formats,
    clock: BoardClock,
    reports: Reports,
    pace: Pace,
    board: Formats | None = None,
) -> tuple[ShownScene, Timing]:
    """:meth:`FrameTime.picture` of settings with a frame time."""
    return FrameTime(settings, formats, clock, reports, board).picture(settings, shown, pace)


class Found(NamedTuple):
    """A frame's scene, its plan, the levers that gave it, and its error by the curve's measure."""

    scene: ShownScene
    adapted: Adapted
    levers: Levers
    error: float
