# SPDX-License-Identifier: Apache-2.0
"""A board that is simulated, behind a pseudo-terminal or a TCP port."""

from __future__ import annotations

import os
import select
import threading
from types import TracebackType
from typing import Self

from quadshade.board.endpoints import Line
from quadshade.board.engines import Engine
from quadshade.errors import QuadshadeError

JOIN_SECONDS = 10.0


class SimulatedBoard:
    """
    Joins a line and an engine.

    Parameters
    ----------
    line : Line
    engine : Engine

    Attributes
    ----------
    name : str
      What a host opens.
    problem : QuadshadeError or None
      Why it stopped by itself.
    """

    def __init__(self, line: Line, engine: Engine) -> None:
        self.line, self.engine = line, engine
        self.name = line.name
        self.problem: QuadshadeError | None = None
        self._rate: int | None = None
        self._woken, self._waker = os.pipe()
        self._thread: threading.Thread | None = None
        self._is_closed = False

    def run(self) -> None:
        """
        Pass bytes on until :meth:`stop`.

        Raises
        ------
        QuadshadeError
          The simulation has ended by itself.
        """
        engine, line = self.engine, self.line
        while True:
            waiting = [self._woken, engine.reader(), *([] if engine.is_full else line.readers())]
            writing = [engine.writer(), *line.writers()]
            ready, _, _ = select.select(
                [one for one in waiting if one is not None], [one for one in writing if one is not None], []
            )
            if self._woken in ready:
                return
            engine.push()
            if not engine.is_full:
                self._listen()
            if engine.reader() is None or engine.reader() in ready:
                line.give(engine.take())
            else:
                line.give()

    def _listen(self) -> None:
        """What has come from the host, at the host's rate."""
        data = self.line.take()
        rate = self.line.rate()
        # A host sets its rate before it sends: what is here now was sent at this one.
        if data and rate != self._rate and rate is not None:
            self._rate = rate
            self.engine.set_baud(rate)
        if data:
            self.engine.feed(data)

    def start(self) -> SimulatedBoard:
        """Run in a thread."""
        self._thread = threading.Thread(target=self._run_quietly, name="simulated board", daemon=True)
        self._thread.start()
        return self

    def _run_quietly(self) -> None:
        try:
            self.run()
        except QuadshadeError as problem:
            self.problem = problem
            # A host that waits for an answer sees the line go.
            self._close()
        except BaseException:
            self._close()
            raise

    def stop(self) -> None:
        """Let :meth:`run` return; may be called from a signal handler."""
        os.write(self._waker, b"x")

    def close(self) -> None:
        """Stop, if it runs, and give everything up."""
        if self._thread is not None:
            self.stop()
            self._thread.join(JOIN_SECONDS)
            self._thread = None
        self._close()
        for descriptor in (self._woken, self._waker):
            os.close(descriptor)

    def _close(self) -> None:
        if not self._is_closed:
            self._is_closed = True
            self.engine.close()
            self.line.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        problem: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()
