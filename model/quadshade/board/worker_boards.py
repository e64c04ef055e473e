# SPDX-License-Identifier: Apache-2.0
"""Boards and engines of Dask workers: what runs there, and a pool of them that shares tiles."""

from __future__ import annotations

import threading
from collections import Counter
from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from quadshade.board.board import Board
from quadshade.board.fallbacks import clear_word
from quadshade.board.pool import Done, Job, Result, Work
from quadshade.board.settings import BoardSettings
from quadshade.cluster import stream, workers_of
from quadshade.contract.formats import Formats
from quadshade.contract.protocol import PLANES
from quadshade.contract.shade_state import ShadeState, colour_state
from quadshade.engine.draw import draw_words
from quadshade.errors import QuadshadeError
from quadshade.golden.screen.screen import Screen
from quadshade.packing.pack import unpack

ENGINE_SCREEN = 256
"""Pixels along each side of a tile that an engine draws."""

COUNTS = ("bytes_sent", "bytes_received", "sent", "received", "resent", "timeouts", "reconnects", "redraws")


class EngineScreen:
    """
    As much of :class:`quadshade.Board` as drawing a tile takes, drawn by an engine without a line.

    Parameters
    ----------
    settings : BoardSettings
    engine : str
      One of ``choices.ENGINES``.
    """

    colour_bits = 8

    def __init__(self, settings: BoardSettings, engine: str) -> None:
        self.formats, self._engine = settings.formats, engine
        self.width, self.height = settings.screen_width, settings.screen_height
        depth_bits = self.formats.depth_bits if self.formats.with_depth else None
        self._screen = Screen(self.width, self.height, self.formats.emitted_channels, depth_bits)
        self._state: ShadeState | None = colour_state(self.formats) if self.formats.with_shade else None
        self.statistics: dict[str, float] = dict.fromkeys(COUNTS, 0)

    def clear(self, colour: tuple[int, int, int]) -> None:
        """Begin a picture."""
        self._screen.clear(clear_word(colour, self.formats))

    def state(self, state: ShadeState) -> None:
        """Load the shade unit."""
        self._state = state

    def send(self, words: np.ndarray, _: int = 0) -> None:
        """Draw packed words."""
        pixels = draw_words(unpack(words, self.formats), self.formats, self._engine, state=self._state)
        channels = self.formats.emitted_channels
        depth = pixels.value[:, channels] if self.formats.with_depth else None
        self._screen.draw(pixels.x, pixels.y, pixels.value[:, :channels], depth)

    def read_plane(self, plane: str, width: int, height: int, _: bool | str = True) -> np.ndarray:
        """(height, width, bytes) uint8."""
        return self._screen.plane(PLANES.index(plane))[:height, :width].copy()

    def show(self) -> None:
        """Nothing: there is no monitor."""

    def has_plane(self, plane: str) -> bool:
        """Colour, and depth where the formats have it."""
        return plane == PLANES[0] or (plane == PLANES[1] and bool(self.formats.with_depth))


class Place(NamedTuple):
    """
    What a worker draws with.

    Attributes
    ----------
    port : str or None
      As the worker understands it: ``auto`` or ``sim``, or a port's name there; None: an engine.
    settings : BoardSettings
      Of a simulated board, or of the engine's screen.
    engine : str or None
    baud, faults, timeout
      As for :class:`quadshade.Board`.
    """

    port: str | None
    settings: BoardSettings
    engine: str | None
    baud: int | None = None
    faults: tuple[float, int] | None = None
    timeout: float | None = None


_opened: dict[Place, Board | EngineScreen] = {}
_opening = threading.Lock()


def board_here(place: Place) -> Any:
    """The board of this worker, which stays open as long as it is asked for in the same way."""
    with _opening:
        if place not in _opened:
            if place.port is None:
                return EngineScreen(place.settings, place.engine or "model")
            _opened[place] = Board(
                place.port,
                place.baud,
                settings=place.settings,
                engine=place.engine,
                faults=place.faults,
                answer_seconds=place.timeout,
                notice=lambda _: None,
            )
        return _opened[place]


def forget_board(place: Place) -> None:
    """Close a board that has failed."""
    with _opening:
        board = _opened.pop(place, None)
    if isinstance(board, Board):
        board.close()


def _describe(place: Place, _: object = None) -> tuple[Formats, int, int, tuple[str, ...], int]:
    """Formats, screen, planes and bits of a colour of the worker's board."""
    board = board_here(place)
    planes = tuple(filter(board.has_plane, PLANES))
    return board.formats, board.width, board.height, planes, board.colour_bits


def _do(place: Place, do: Callable[[Any, Any], Any], job: Any) -> tuple[Any, dict[str, float]]:
    """Do a job with the worker's board, and count what its line did."""
    board = board_here(place)
    before = dict(board.statistics)
    try:
        result = do(board, job)
    except QuadshadeError:
        forget_board(place)
        raise
    return result, {name: board.statistics[name] - before[name] for name in COUNTS}


class _Named(NamedTuple):
    """What is asked for a board's name."""

    name: str


@dataclass(eq=False)
class WorkerBoard:
    """What a client knows of the board of a worker; attributes are those of :class:`quadshade.Board`."""

    session: _Named
    formats: Formats
    width: int
    height: int
    planes: tuple[str, ...]
    colour_bits: int
    counts: Counter[str] = field(default_factory=Counter)
    progress: None = None

    @property
    def statistics(self) -> dict[str, float]:
        """What its line did for this client."""
        return {name: self.counts[name] for name in COUNTS}

    def has_plane(self, plane: str) -> bool:
        """Whether it can read a plane."""
        return plane in self.planes

    def close(self) -> None:
        """Nothing: the board stays the worker's."""


class WorkerPool:
    """
    The boards or engines of Dask workers; what :class:`quadshade.board.pool.BoardPool` is for boards here.

    Parameters
    ----------
    client : distributed.Client
    place : Place
      What workers draw with.
    notice : callable

    Attributes
    ----------
    boards, everyone
      As of :class:`quadshade.board.pool.BoardPool`; of engines there is one that stands for all.

    Raises
    ------
    QuadshadeError
      Boards are asked for, and no worker has one; or none of them answers.
    """

    def __init__(self, client: Any, place: Place, notice: Callable[[str], None]) -> None:
        self._client, self._place, self._notice = client, place, notice
        self._needs_board = place.port is not None
        workers = workers_of(client, self._needs_board)
        if not workers:
            raise QuadshadeError(
                "no worker has a board", "start those that do with `--resources board=1 --nthreads 1`"
            )
        self.boards: list[WorkerBoard] = []
        if self._needs_board:
            found = stream(client, partial(_describe, place), [None], "boards", self._lose, needs_board=True)
            described = [result for _, result in found]
        else:
            described = [_describe(place)]
        name = _Named(f"{len(workers)} workers")
        self.boards += [WorkerBoard(name, *about) for about in described]
        self.everyone = tuple(self.boards)

    def _lose(self, worker: str, reason: str) -> None:
        self._notice(f"the worker {worker} is lost: {reason}; its work goes to the others")

    def lose(self, board: WorkerBoard, reason: str) -> None:
        """Do without a kind of board."""
        self.boards.remove(board)
        raise QuadshadeError(f"the workers' boards do not draw it: {reason}", "use other boards")

    def share(
        self, work: Work[Job, Result], jobs: Sequence[tuple[float, Job]]
    ) -> Generator[Done[Job, Result], None, None]:
        """As :meth:`quadshade.board.pool.BoardPool.share`."""
        costs: dict[Job, float] = {}
        [board] = self.boards
        queue = list(jobs)
        while queue:
            cost, job = queue.pop(0)
            # A worker's board is one of these, as far as is known here.
            part, rest = work.split(board, job)
            costs[part] = cost / (1 + len(rest))
            queue += [(costs[part], one) for one in rest]
        done = stream(
            self._client,
            partial(_do, self._place, work.do),
            list(costs),
            work.what,
            self._lose,
            self._needs_board,
        )
        for job, (result, counts) in done:
            board.counts.update(counts)
            yield Done(job, result, costs[job])
