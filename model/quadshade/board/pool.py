# SPDX-License-Identifier: Apache-2.0
"""Several boards share work: a job goes to whichever is free, and from one that is lost to the others."""

from __future__ import annotations

import heapq
import threading
import time
import weakref
from collections.abc import Callable, Generator, Sequence
from typing import Any, Generic, NamedTuple, TypeVar

from quadshade.board.board import Board
from quadshade.errors import QuadshadeError

Job = TypeVar("Job")
Result = TypeVar("Result")

WAIT_SECONDS = 0.1
"""How often whoever waits looks up: Ctrl-C gets through, and a job that is late is noticed."""

LATE_SECONDS = 2.0
LATE_FACTOR = 4.0
"""A job that takes longer than both, the second times the mean, is also given to a board that is idle."""

_servers: weakref.WeakKeyDictionary[Any, threading.Thread] = weakref.WeakKeyDictionary()
"""Of every board the thread that drew on it last, for whatever pool."""


def wait_until_free(board: Any) -> None:
    """Wait for a job that a board still does, of work that was broken off or was too late."""
    server = _servers.get(board)
    if server is not None and server is not threading.current_thread():
        server.join()


class BoardPool:
    """
    Open boards, until they are lost.

    Parameters
    ----------
    boards : sequence of Board
    notice : callable
      Called with a line for every board that is lost.

    Attributes
    ----------
    boards : list of Board
      Those that are left.
    everyone : tuple of Board
      Those that are lost too.
    reason : str
      Why the last one that is lost was lost.
    """

    def __init__(self, boards: Sequence[Board], notice: Callable[[str], None]) -> None:
        self.boards, self.everyone = list(boards), tuple(boards)
        self.reason = "there was none"
        self._notice = notice

    def lose(self, board: Board, reason: str) -> None:
        """Do without a board from now on."""
        if board not in self.boards:
            return
        self.boards.remove(board)
        self.reason = reason
        # Of the only one the error says it.
        if len(self.everyone) > 1:
            then = "its work goes to the others" if self.boards else "no board is left"
            self._notice(f"the board at {board.session.name} is lost: {reason}; {then}")

    def share(
        self, work: Work[Job, Result], jobs: Sequence[tuple[float, Job]]
    ) -> Generator[Done[Job, Result], None, None]:
        """
        Have jobs done.

        Parameters
        ----------
        work : Work
        jobs : sequence of (float, object)
          What each costs, about, and the job; the dearest ones are begun first.

        Yields
        ------
        Done
          As they get ready. Together they are all jobs, once each.

        Raises
        ------
        QuadshadeError
          No board is left: how many jobs are missing, and why the last board was lost.
        """
        desk = _Desk(work, jobs)
        for board in self.boards:
            before = _servers.get(board)
            # A frame's thread shares its tiles with its own board, and goes on with it.
            is_its_own = before is threading.current_thread()
            arguments = (board, None if is_its_own else before)
            thread = threading.Thread(target=desk.serve, args=arguments, name="board", daemon=True)
            if not is_its_own:
                _servers[board] = thread
            thread.start()
        try:
            while True:
                done, lost, missing = desk.news()
                for board, reason in lost:
                    self.lose(board, reason)
                yield from done
                if not missing:
                    break
                if not self.boards:
                    raise QuadshadeError(
                        f"{missing} {work.what} are missing, as no board is left: {self.reason}", work.hint
                    )
        finally:
            desk.stop()
        for board in desk.late:
            self._notice(f"the board at {board.session.name} is late: another one did its work")


class Work(NamedTuple, Generic[Job, Result]):
    """
    What is done with jobs.

    Attributes
    ----------
    do : callable
      A job on a board; raises :class:`QuadshadeError` where the board fails. It can be pickled.
    split : callable
      The part of a job that a board can do at once, and what is left of it.
    what, hint : str
      What jobs are called, and what to do where some are missing.
    """

    do: Callable[[Any, Job], Result]
    split: Callable[[Any, Job], tuple[Job, list[Job]]]
    what: str
    hint: str


class Done(NamedTuple, Generic[Job, Result]):
    """A job, what came of it, and how much of it is done, of all jobs."""

    job: Job
    result: Result
    cost: float


class _Running(NamedTuple, Generic[Job]):
    """A job that some board does."""

    cost: float
    job: Job
    since: float


class _Desk(Generic[Job, Result]):
    """Where boards' threads fetch jobs and leave results."""

    def __init__(self, work: Work[Job, Result], jobs: Sequence[tuple[float, Job]]) -> None:
        self._work = work
        # The number decides between equals, and says which one a result is of.
        self._queue = [(-cost, number, job) for number, (cost, job) in enumerate(jobs)]
        heapq.heapify(self._queue)
        self._next = len(self._queue)
        self._running: dict[int, _Running[Job]] = {}
        self._again: set[int] = set()
        self._done: list[Done[Job, Result]] = []
        self._lost: list[tuple[Board, str]] = []
        self._problem: BaseException | None = None
        self._seconds, self._finished = 0.0, 0
        self._is_over = False
        self._busy: set[Board] = set()
        self._changed = threading.Condition()

    def news(self) -> tuple[list[Done[Job, Result]], list[tuple[Board, str]], int]:
        """Wait for what is done and which boards are lost; and how many jobs are not done."""
        with self._changed:
            if not (self._done or self._lost or self._problem) and self._missing():
                self._changed.wait(WAIT_SECONDS)
            if self._problem is not None:
                raise self._problem
            done, self._done = self._done, []
            lost, self._lost = self._lost, []
            return done, lost, self._missing()

    def _missing(self) -> int:
        return len(self._queue) + len(self._running)

    def stop(self) -> None:
        """Begin no other job."""
        with self._changed:
            self._is_over = True
            self._changed.notify_all()

    @property
    def late(self) -> list[Board]:
        """Boards that still do what another one has done."""
        with self._changed:
            return list(self._busy)

    def serve(self, board: Board, before: threading.Thread | None = None) -> None:
        """Do jobs on a board until there are none, or the board is lost; once another thread has left it."""
        if before is not None:
            before.join()
        while (taken := self._take(board)) is not None:
            number, running = taken
            try:
                result = self._work.do(board, running.job)
            except QuadshadeError as reason:
                self._give_back(number, board, reason.message)
                return
            except BaseException as problem:  # noqa: BLE001 - raised again where results are waited for
                with self._changed:
                    self._problem = problem
                    self._changed.notify_all()
                return
            self._finish(number, running, board, result)

    def _take(self, board: Board) -> tuple[int, _Running[Job]] | None:
        """The next job, or one that is late elsewhere; waits while there may be another."""
        with self._changed:
            while not self._is_over and self._missing():
                if self._queue:
                    cost, number, job = heapq.heappop(self._queue)
                    part, rest = self._work.split(board, job)
                    for one in rest:
                        heapq.heappush(self._queue, (cost / (1 + len(rest)), self._next, one))
                        self._next += 1
                    running = _Running(-cost / (1 + len(rest)), part, time.monotonic())
                    self._running[number] = running
                    self._busy.add(board)
                    return number, running
                late = self._late(board)
                if late is not None:
                    self._busy.add(board)
                    return late
                self._changed.wait(WAIT_SECONDS)
            return None

    def _late(self, board: Board) -> tuple[int, _Running[Job]] | None:
        """A job that another board takes too long for, and that this board can do at once."""
        mean = self._seconds / self._finished if self._finished else 0.0
        limit = time.monotonic() - max(LATE_SECONDS, LATE_FACTOR * mean)
        for number, running in self._running.items():
            is_late = running.since < limit and number not in self._again
            if is_late and not self._work.split(board, running.job)[1]:
                self._again.add(number)
                return number, running
        return None

    def _finish(self, number: int, running: _Running[Job], board: Board, result: Result) -> None:
        """Keep a result, unless another board was faster."""
        with self._changed:
            self._busy.discard(board)
            if self._running.pop(number, None) is not None:
                self._done.append(Done(running.job, result, running.cost))
                self._seconds += time.monotonic() - running.since
                self._finished += 1
            self._changed.notify_all()

    def _give_back(self, number: int, board: Board, reason: str) -> None:
        """A board is lost, and its job waits again, unless another board has it too."""
        with self._changed:
            self._busy.discard(board)
            if number in self._again:
                self._again.remove(number)
            elif number in self._running:
                running = self._running.pop(number)
                heapq.heappush(self._queue, (-running.cost, number, running.job))
            self._lost.append((board, reason))
            self._changed.notify_all()
