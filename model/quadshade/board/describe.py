# SPDX-License-Identifier: Apache-2.0
"""Who is at a port: what a board says of itself and has counted, without changing it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from quadshade.board.ports import Port
from quadshade.contract.formats import GENERIC_HELP
from quadshade.contract.protocol import BOARD_FIELDS, COUNTERS, FEATURES, PHASE_BITS
from quadshade.contract.releases import release_of
from quadshade.link.session import Session
from quadshade.link.transport import FaultyTransport, Transport

Row = tuple[str, str, str]


@dataclass(frozen=True)
class BoardDescription:
    """
    What a board says of itself.

    Attributes
    ----------
    name : str
      Of the line that it is at.
    identity : dict of str to int
      All that HELLO says.
    counters : dict of str to int
      Counted since the last reset.
    """

    name: str
    identity: dict[str, int]
    counters: dict[str, int]

    @property
    def version(self) -> int:
        """Version of the protocol."""
        return self.identity["version"]

    @property
    def features(self) -> tuple[str, ...]:
        """What it was built with."""
        return tuple(name for bit, name in enumerate(FEATURES) if self.identity["features"] >> bit & 1)

    @property
    def baud(self) -> int:
        """Rate after power-up."""
        clock, step = self.identity["clk_frequency_hz"], self.identity["default_phase_step"]
        return round(step * clock / (1 << PHASE_BITS))

    def tables(self) -> list[list[Row]]:
        """Board, generics and counters: rows of name, value and meaning."""
        identity = self.identity
        board = [
            ("definition", f"{identity['definition']:08x}", f"of {release_of(identity['definition'])}"),
            ("session", f"{identity['session']:08x}", "number of the last host's, 0 after power-up"),
            ("baud", str(self.baud), "rate after power-up"),
            ("has", ", ".join(self.features) or "nothing more", "features"),
            *((name, str(identity[name]), text) for name, _, text in BOARD_FIELDS if name != "features"),
        ]
        generics = [
            (name, str(identity[name]), text) for name, text in GENERIC_HELP.items() if name in identity
        ]
        counters = [(name, str(self.counters[name]), text) for name, _, text in COUNTERS]
        return [board, generics, counters]


def describe_board(
    port: Any = None,
    baud: int | None = None,
    faults: tuple[float, int] | None = None,
    answer_seconds: float | None = None,
    trace: Callable[[str], None] | None = None,
) -> BoardDescription:
    """
    Ask the board at a port who it is; neither its picture nor its session changes.

    Parameters
    ----------
    port, baud, faults, answer_seconds, trace
      As for :class:`quadshade.Board`.

    Returns
    -------
    BoardDescription

    Raises
    ------
    QuadshadeError
      No board answers there.
    """
    place = Port(port, baud)
    try:
        line = place.open()
        try:
            damaged: Transport = line if faults is None else FaultyTransport(line, *faults)
            session = Session(damaged, answer_seconds or place.answer_seconds, trace=trace)
            identity = session.connect(reset=False)
            return BoardDescription(line.name, identity, session.status())
        finally:
            line.close()
    finally:
        place.close()
