# SPDX-License-Identifier: Apache-2.0
"""Every frame of an animation, drawn by an engine in several processes or by one board."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from functools import cached_property, partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from quadshade.animation.film import write_film, write_pictures
from quadshade.animation.motion import Motion, Pose
from quadshade.animation.outputs import Outputs
from quadshade.animation.posed import Stage
from quadshade.animation.record import FrameRow, write_plot, write_table
from quadshade.animation.store import FrameStore, animation_key
from quadshade.board import Board
from quadshade.board.pool import BoardPool
from quadshade.board.tiled_screen import TiledScreen
from quadshade.board.worker_boards import Place, board_here, forget_board
from quadshade.choices import PHONG, STYLES
from quadshade.errors import QuadshadeError, Terminated, interrupt_of
from quadshade.files.atomic import check_writable
from quadshade.image import largest_and_rms
from quadshade.rendering.draw import render_picture
from quadshade.rendering.groups import EngineChoice, PortChoice
from quadshade.rendering.picture import Picture
from quadshade.rendering.settings import RenderSettings, Reports
from quadshade.rendering.shade import choice_mesh
from quadshade.rendering.timing import Levers, Pace
from quadshade.scene import Mesh

LOOKED_AT = 24
"""Frames of an animation for which the levers of a frame time are chosen."""

QUIET = Reports(notice=lambda _: None)


class Drawn(NamedTuple):
    """A frame: its figures, its pixels, and what is not as it was asked for."""

    row: FrameRow
    array: np.ndarray
    notes: tuple[str, ...]


class Animation:
    """
    A scene that moves; its frames are drawn when they are asked for.

    Parameters
    ----------
    settings : RenderSettings
      Of the scene as it stands.
    motion : Motion
    errors : bool
      Measure each frame against Phong shading.
    jobs : int
      Processes; a board draws one frame after the other.
    reports : Reports, optional
    """

    def __init__(
        self,
        settings: RenderSettings,
        motion: Motion,
        errors: bool = True,
        jobs: int = 1,
        reports: Reports | None = None,
    ) -> None:
        if settings.style.gbuffer is not None:
            raise QuadshadeError("--gbuffer is for one picture", "use `quadshade render`")
        if settings.engine.waves is not None:
            raise QuadshadeError("--waves is for one picture", "use `quadshade render`")
        if settings.port.is_given and jobs != 1:
            raise QuadshadeError("a board draws one frame after the other", "leave --jobs out")
        if settings.adapt.frame_time is not None and (jobs != 1 or settings.port.dask is not None):
            raise QuadshadeError(
                "a frame in time begins where the one before ended", "leave --jobs or --dask out"
            )
        if settings.engine.engine is None and not settings.port.is_given:
            # Many pictures: the engine that starts soonest; all of them draw the same.
            settings = replace(settings, engine=EngineChoice("model"))
        self.settings, self.motion, self._jobs = settings, motion, jobs
        self._reports = reports or Reports()
        comparable = settings.style.style == STYLES[0] and not settings.style.kinds
        self._measures = errors and comparable and settings.scene.toon is None
        _ = self._stage

    def __len__(self) -> int:
        return self.motion.frames

    def __getitem__(self, frame: int) -> Picture:
        """The picture of a frame, drawn anew."""
        if not -len(self) <= frame < len(self):
            raise IndexError(f"there is no frame {frame} of {len(self)}")
        return self.frame(frame % len(self), self.pace())

    def __iter__(self) -> Iterator[Picture]:
        return (self[number] for number in range(len(self)))

    def pace(self, levers: Levers | None = None) -> Pace:
        """
        Where a row of frames in a frame time begins.

        Parameters
        ----------
        levers : Levers, optional
          Of the frame before; without them those that are best for frames from the whole animation.
        """
        every = max(len(self) // LOOKED_AT, 1)

        def ahead() -> list[RenderSettings]:
            return [self.frame_settings(frame) for frame in range(every, len(self), every)][: LOOKED_AT - 1]

        return Pace(ahead, levers)

    def frame(self, frame: int, pace: Pace) -> Picture:
        """The picture of a frame, counted from 0; in a frame time the pace goes on from it."""
        return render_picture(self.frame_settings(frame), self._reports, pace)

    def frame_settings(self, frame: int) -> RenderSettings:
        """What :func:`quadshade.render` would be asked for, for a frame counted from 0."""
        return self._stage.frame(frame)

    @cached_property
    def _stage(self) -> Stage:
        settings = self.settings.styled()
        settings.checked()
        scene = settings.of_scene(crease=None)
        name = self.settings.scene.scene
        return Stage(scene, self._mesh, self.motion, name if isinstance(name, str | Path) else None)

    @cached_property
    def _mesh(self) -> Mesh:
        return choice_mesh(self.settings.scene)

    def save(self, path: str | Path) -> list[FrameRow]:
        """
        Draw all frames, and write them with their table and plot.

        A frame that is drawn is kept beside the file until the file is written: a killed animation goes on
        where it stopped. After Ctrl-C the file holds the frames so far; `kill` does not wait for that.

        Parameters
        ----------
        path : str or Path
          .gif, .webp, .png or .apng, or a folder for numbered pictures, which is made.

        Returns
        -------
        list of FrameRow

        Raises
        ------
        QuadshadeError
          A file that cannot be written, or a frame that cannot be drawn.
        """
        path = Path(path)
        outputs = Outputs.of(path)
        inputs = [
            one for one in (self.settings.scene.scene, self.motion.keyframes) if isinstance(one, str | Path)
        ]
        files = (outputs.table, outputs.plot, None if outputs.is_folder else path)
        check_writable(*files, inputs=map(Path, inputs))
        key = animation_key(self.settings, self._mesh, self.motion, self._measures)
        store = FrameStore(outputs.frames, key)
        try:
            self._fill(store)
        except (KeyboardInterrupt, SystemError) as error:
            interrupt = interrupt_of(error)
            if interrupt is None:
                raise
            if not isinstance(interrupt, Terminated):
                self._write(store, outputs)
            raise interrupt from None
        except QuadshadeError:
            if len(store.missing(len(self))) == len(self):
                store.remove()
                outputs.forget()
            raise
        rows = self._write(store, outputs)
        store.remove()
        return rows

    def _fill(self, store: FrameStore) -> None:
        """Draw the frames that are missing."""
        missing = store.missing(len(self))
        done = len(self) - len(missing)
        if done:
            self._reports.notice(f"{done} of {len(self)} frames were drawn before")
        self._tell(done)
        before = store.row(missing[0] - 1) if missing and missing[0] else None
        pace = self.pace(None if before is None else before.levers)
        for drawn in self._draw(missing, pace):
            store.add(drawn.row, drawn.array)
            done += 1
            self._tell(done)

    def _tell(self, done: int) -> None:
        """How far the animation is."""
        if self._reports.progress is not None:
            self._reports.progress("drawing frames", done, len(self), 0)

    def _write(self, store: FrameStore, outputs: Outputs) -> list[FrameRow]:
        """The film, table and plot of the frames that are drawn, up to the first one that is not."""
        missing = store.missing(len(self))
        count = missing[0] if missing else len(self)
        rows = [row for row in map(store.row, range(count)) if row is not None]
        if not rows:
            return []
        self._reports.step(f"writing {outputs.film}")
        arrays = (store.picture(number) for number in range(count))
        if outputs.is_folder:
            write_pictures(outputs.film, arrays, len(self))
        else:
            write_film(outputs.film, arrays, count, self.motion.fps)
        write_table(outputs.table, rows)
        write_plot(outputs.plot, rows, self.settings.scene.name)
        return rows

    def _draw(self, frames: list[int], pace: Pace) -> Iterator[Drawn]:
        """Frames as they get ready; what one frame says of itself is said once."""
        said: set[str] = set()
        for drawn in self._run(frames, pace):
            for note in drawn.notes:
                if note not in said:
                    said.add(note)
                    self._reports.notice(f"frame {drawn.row.frame}: {note}")
            yield drawn

    def _run(self, frames: list[int], pace: Pace) -> Iterable[Drawn]:
        """Frames from a board, this process, or several."""
        if self.settings.port.dask is not None:
            return self._on_workers(frames)
        if self.settings.port.port is not None:
            return self._on_board(frames, pace)
        if self._jobs == 1 or len(frames) < 2:
            return (self._one(number, self.frame_settings(number), pace) for number in frames)
        from joblib import Parallel, delayed

        run = Parallel(n_jobs=min(self._jobs, len(frames)), return_as="generator_unordered")
        calls = (
            delayed(draw_frame)(number, self.motion.pose(number), self.frame_settings(number), self._measures)
            for number in frames
        )
        results: Iterator[Drawn] = run(calls)
        return results

    def _one(self, frame: int, settings: RenderSettings, pace: Pace) -> Drawn:
        return draw_frame(frame, self.motion.pose(frame), settings, self._measures, pace)

    def _on_board(self, frames: list[int], pace: Pace) -> Iterator[Drawn]:
        """Frames drawn by boards that stay open: one after the other, or whole ones by each of several."""
        from quadshade.animation.dealt_frames import dealt_frames
        from quadshade.rendering.board import board_for

        if not frames:
            return
        said: set[str] = set()

        def once(text: str) -> None:
            if text not in said:
                said.add(text)
                self._reports.notice(text)

        def draw(board: Board | TiledScreen, number: int) -> Drawn:
            return self._on_one(board, number, pace)

        reports = replace(self._reports, notice=once, progress=None)
        with board_for(self.frame_settings(frames[0]), reports) as board:
            if isinstance(board, TiledScreen) and isinstance(board.pool, BoardPool):
                count = len(board.pool.boards)
                whole = len(frames) // count * count * (count > 1)
                yield from dealt_frames(board, board.pool, frames[:whole], draw)
                # So few are left that all boards share each of them.
                frames = frames[whole:]
            yield from (draw(board, number) for number in frames)

    def _on_one(self, board: Board | TiledScreen, number: int, pace: Pace) -> Drawn:
        """A frame that a board draws, or several in tiles."""
        port = self.settings.port
        opened = PortChoice(board, pack_error=port.pack_error, verify=port.verify)
        before, late = board.statistics["bytes_sent"], getattr(board, "late", 0)
        placed = self.frame_settings(number).of_scene(generics=())
        drawn = self._one(number, replace(placed, port=opened, engine=EngineChoice()), pace)
        row = replace(drawn.row, bytes=int(board.statistics["bytes_sent"] - before))
        if self.settings.adapt.frame_time is not None:
            row = replace(row, late=getattr(board, "late", 0) - late)
        return drawn._replace(row=row)

    def _on_workers(self, frames: list[int]) -> Iterator[Drawn]:
        """Frames drawn by the workers of a Dask scheduler, as they get ready."""
        from quadshade.cluster import connect, stream
        from quadshade.rendering.simulated import worker_place

        if not frames:
            return
        port, notice = self.settings.port, self._reports.notice
        place = worker_place(self.frame_settings(frames[0]))
        draw = partial(draw_frame_there, self._stage, self.motion, self._measures, place)

        def lose(worker: str, reason: str) -> None:
            notice(f"the worker {worker} is lost: {reason}; its work goes to the others")

        with connect(str(port.dask)) as client:
            done = stream(client, draw, frames, "frames", lose, port.port is not None)
            yield from (drawn for _, drawn in done)


def draw_frame_there(stage: Stage, motion: Motion, measures: bool, place: Place, frame: int) -> Drawn:
    """
    Draw a frame on a Dask worker, with what it has.

    Parameters
    ----------
    stage : Stage
    motion : Motion
    measures : bool
      Whether to compare it with Phong shading.
    place : Place
      The worker's board, or an engine.
    frame : int

    Returns
    -------
    Drawn
    """
    settings, pose = stage.frame(frame), motion.pose(frame)
    port = replace(settings.port, port=None, dask=None, baud=None, faults=None, timeout=None, pack_error=None)
    if place.port is None:
        engine = EngineChoice(place.engine or "model")
        return draw_frame(frame, pose, replace(settings, port=port, engine=engine), measures)
    board = board_here(place)
    before = board.statistics["bytes_sent"]
    opened = replace(settings.port, port=board, dask=None, baud=None, faults=None, timeout=None)
    placed = replace(settings.of_scene(generics=()), port=opened, engine=EngineChoice())
    try:
        drawn = draw_frame(frame, pose, placed, measures)
    except QuadshadeError:
        forget_board(place)
        raise
    sent = int(board.statistics["bytes_sent"] - before)
    return drawn._replace(row=replace(drawn.row, bytes=sent))


def draw_frame(
    frame: int, pose: Pose, settings: RenderSettings, measures: bool, pace: Pace | None = None
) -> Drawn:
    """
    Draw a frame, and measure it.

    Parameters
    ----------
    frame : int
    pose : Pose
      What the settings were made from.
    settings : RenderSettings
      Of the frame.
    measures : bool
      Whether to compare it with Phong shading.
    pace : Pace, optional
      Of the frames before, where there is a frame time.

    Returns
    -------
    Drawn
    """
    picture = render_picture(settings, QUIET, pace)
    stats = picture.stats
    largest = rms = None
    if measures:
        reference = picture.array if stats.shading == PHONG else picture.phong_array()
        largest, rms = largest_and_rms(picture.array, reference)
        rms = round(rms, 4)
    size = None if stats.words is None else 4 * stats.words
    turned = (pose.turn, pose.light_orbit)
    row = FrameRow(frame, *turned, len(picture.triangles), size, stats.clocks, largest, rms)
    if (timing := stats.timing) is not None:
        names = ("faces", "shading", "step", "pack_error", "line_bytes")
        kept = {name: timing[name] for name in names} | {"board_clocks": timing["clocks_whole"]}
        row = replace(row, deadline_clocks=timing["deadline"], **kept)
    return Drawn(row, picture.array, picture.notes)
