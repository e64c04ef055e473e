# SPDX-License-Identifier: Apache-2.0
"""How to a board: a port by name or URL, one that is searched for, or a simulated board of one's own."""

from __future__ import annotations

import os
import time
from dataclasses import dataclass
from typing import Any

from serial.tools import list_ports

from quadshade.board.endpoints import PtyLine
from quadshade.board.engines import ANSWER_SECONDS as SIMULATED_SECONDS
from quadshade.board.engines import board_engine, start_engine
from quadshade.board.settings import BoardSettings, board_settings
from quadshade.board.simulated import SimulatedBoard
from quadshade.choices import SIM, parse_ports, simulated_board
from quadshade.contract.protocol import LinkError
from quadshade.errors import QuadshadeError
from quadshade.link.exchange import ANSWER_SECONDS, Exchange
from quadshade.link.session import Session
from quadshade.link.transport import DEFAULT_BAUD, SerialTransport, baud_of, open_transport

AUTO = "auto"

SEARCH_SECONDS = 0.3
SEARCH_RETRIES = 3
"""Time-out and number of HELLOs for each port that is searched."""

RECONNECT_SECONDS = 30.0
"""So long a line that vanished is waited for."""

POLL_SECONDS = 0.1

LEAST_SECONDS, MOST_SECONDS = 0.001, 1e6
"""Range of the time-out of an answer."""


def candidates() -> list[str]:
    """Serial ports of this machine, those of USB bridges first."""
    ports = sorted(list_ports.comports(), key=lambda port: (port.vid is None, port.device))
    return [port.device for port in ports]


def find_board() -> str:
    """
    The port at which a board answers HELLO.

    Raises
    ------
    LinkError
      None does, with what is wrong at each port; or several do.
    """
    found, problems = [], []
    for port in candidates():
        try:
            line = open_transport(port, DEFAULT_BAUD)
        except LinkError as problem:
            problems.append(problem.message)
            continue
        try:
            Exchange(line, SEARCH_SECONDS, SEARCH_RETRIES).hello()
            found.append(port)
        except LinkError as problem:
            problems.append(problem.message)
        finally:
            line.close()
    if len(found) > 1:
        raise LinkError(f"{len(found)} boards answer: {', '.join(found)}", "give one of them as --port")
    if not found:
        said = "; ".join(problems) if problems else "there is no serial port"
        raise LinkError(f"no board was found: {said}", "plug one in, or use --port sim")
    return found[0]


@dataclass
class Port:
    """
    A way to a board that can be opened again.

    Attributes
    ----------
    name : str or serial object
      ``sim``, ``sim:BOARD``, ``auto``, a port's name, a URL; or an object that is open already.
    baud : int or None
      Rate to agree on; None: that of ``QUADSHADE_BAUD``, or the board's own.
    settings : BoardSettings or None
      Of a simulated board; of one that ``sim:BOARD`` names they are that board's.
    engine : str or None
      What simulates it.
    simulated : SimulatedBoard or None
      The simulated board, once it runs.

    Raises
    ------
    QuadshadeError
      ``sim:BOARD`` with no such board, with several, or with settings as well.
    """

    name: Any = None
    baud: int | None = None
    settings: BoardSettings | None = None
    engine: str | None = None
    simulated: SimulatedBoard | None = None

    def __post_init__(self) -> None:
        self.name = self.name or os.environ.get("QUADSHADE_PORT")
        self.baud = baud_of(self.baud)
        if simulated_board(self.name) is None:
            return
        ports = parse_ports(self.name)
        if len(ports) > 1:
            raise QuadshadeError(
                f"the port {self.name} is {len(ports)} boards", "open each by itself, as sim"
            )
        if named := simulated_board(ports[0]):
            if self.settings is not None:
                raise QuadshadeError(f"settings are given, and the port {self.name} has its own", "give one")
            self.settings = board_settings(named, None, {})
        self.name = SIM

    @property
    def is_simulated(self) -> bool:
        """Whether the board is one's own simulation."""
        return self.name == SIM

    @property
    def answer_seconds(self) -> float:
        """Time-out of an answer."""
        return SIMULATED_SECONDS[board_engine(self.engine)] if self.is_simulated else ANSWER_SECONDS

    def seconds_of(self, given: float | None) -> float:
        """
        The time-out of an answer, given or that of the port.

        Raises
        ------
        QuadshadeError
          It is out of range.
        """
        seconds = self.answer_seconds if given is None else given
        if not isinstance(seconds, int | float) or not LEAST_SECONDS <= seconds <= MOST_SECONDS:
            raise QuadshadeError(
                f"the time-out of an answer is {seconds!r}",
                f"give {LEAST_SECONDS:g} to {MOST_SECONDS:g} seconds",
            )
        return seconds

    def open(self) -> SerialTransport:
        """
        Open the line; a simulated board is started for it.

        Raises
        ------
        QuadshadeError
          The port is missing, busy or may not be opened; no board is found; a simulator is missing.
        """
        if self.is_simulated:
            settings = self.settings or BoardSettings()
            if self.simulated is None:
                engine = start_engine(board_engine(self.engine), settings)
                self.simulated = SimulatedBoard(PtyLine(baud=settings.baud), engine).start()
            return open_transport(self.simulated.name, settings.baud)
        return open_transport(find_board() if self.name == AUTO else self.name, DEFAULT_BAUD)

    def agree(self, session: Session) -> None:
        """
        Begin a session, at the rate that is asked for.

        Raises
        ------
        LinkError
          Nobody answers, or not at that rate.
        """
        asked = self.baud
        if asked is None or session.transport.fixed_rate:
            session.connect()
            return
        retries, session.retries = session.retries, SEARCH_RETRIES
        try:
            session.hello()
        except LinkError:
            # Left at another rate by a host before; or built with this one.
            session.transport.send_break()
            try:
                session.hello()
            except LinkError:
                session.transport.set_baud(asked)
        session.retries = retries
        session.connect()
        if session.default_baud != asked:
            session.set_baud(asked)

    def reopen(self, seconds: float = RECONNECT_SECONDS) -> SerialTransport:
        """
        Open a line that vanished, once it is there again.

        Raises
        ------
        LinkError
          It does not come back in time.
        """
        if self.simulated is not None and self.simulated.problem is not None:
            raise LinkError(str(self.simulated.problem), "start again")
        if not isinstance(self.name, str):
            raise LinkError("the line is gone, and was opened elsewhere", "open it anew")
        end = time.monotonic() + seconds
        while True:
            try:
                return self.open()
            except QuadshadeError as problem:
                if time.monotonic() > end:
                    raise LinkError(
                        f"the line did not come back within {seconds:g} s: {problem.message}",
                        "plug the board in and start again",
                    ) from None
            time.sleep(POLL_SECONDS)

    def close(self) -> None:
        """Stop a simulated board."""
        if self.simulated is not None:
            self.simulated.close()
            self.simulated = None
