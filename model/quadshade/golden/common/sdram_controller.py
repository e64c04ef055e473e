# SPDX-License-Identifier: Apache-2.0
"""Words in an SDRAM, in runs, cycle by cycle (``rtl/common/sdram_controller.vhd``)."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Any, NamedTuple

from quadshade.golden.common.sdram_chip import ALL_BANKS, IDLE_PINS, Command

INIT_REFRESHES = 8


@dataclass(frozen=True)
class SdramGenerics:
    """Generics of ``sdram_controller``: the chip's organisation, the longest run, times in clocks."""

    data_bits: int = 16
    bank_bits: int = 2
    row_bits: int = 13
    column_bits: int = 9
    run_words: int = 64
    cas_clocks: int = 3
    rcd_clocks: int = 3
    rp_clocks: int = 3
    ras_clocks: int = 5
    rc_clocks: int = 7
    rfc_clocks: int = 7
    mrd_clocks: int = 2
    wr_clocks: int = 2
    refresh_clocks: int = 780
    power_up_refreshes: int = 26

    def close_clocks(self, write: bool) -> int:
        """Clocks from a run's last word to closing its row."""
        read = max(1, self.ras_clocks - self.rcd_clocks)
        return max(self.wr_clocks, read) if write else read

    def run_clocks(self, words: int, write: bool) -> int:
        """Clocks from the acceptance of a run to that of the next."""
        return self.rcd_clocks + words + self.close_clocks(write) + self.rp_clocks - 1

    def latency(self) -> int:
        """Clocks from the acceptance of a read run to its first word."""
        return self.rcd_clocks + self.cas_clocks + 2


class Run(NamedTuple):
    """
    A request.

    Attributes
    ----------
    address : int
      Row, bank, column.
    more : int
      Words beside the first.
    write : bool
    """

    address: int
    more: int
    write: bool = False


class SdramController:
    """
    Two ports that ask for runs, and the chip's pins.

    Parameters
    ----------
    generics : SdramGenerics

    Attributes
    ----------
    pins : Pins
      What the chip sees at the end of this cycle.
    coming : deque of int or None
      By the cycle in which it arrives, this one first: the port, 0 or 1, of a word that was asked for.
    read_data : int or None
      Register of what the chip gives; None where that is undefined.
    """

    def __init__(self, generics: SdramGenerics) -> None:
        self.generics = generics
        self.read_data: int | None = None
        self.reset()

    def reset(self) -> None:
        """Begin as after power-up."""
        self.state, self.pause, self.due, self.tick = "rests", 0, False, False
        self.left = self.generics.power_up_refreshes - 1
        self.interval = self.generics.refresh_clocks - 1
        self.run, self.port, self.column = Run(0, 0), 0, 0
        self.pins = IDLE_PINS
        self.coming: deque[int | None] = deque([None] * (self.generics.cas_clocks + 2))

    @property
    def free(self) -> bool:
        """Whether a run can begin: the first port's, or else the second's."""
        return self.state == "waits" and self.pause == 0 and not self.due

    @property
    def write_next(self) -> bool:
        """Whether a word is taken in this cycle."""
        return self.state == "moves" and self.pause == 0 and self.run.write

    def clock(
        self,
        first: Run | None,
        second: Run | None,
        write_data: int,
        data_in: int | None,
        write_keep: bool = False,
    ) -> None:
        """
        One clock edge.

        Parameters
        ----------
        first, second : Run or None
          What each port asks for; the first one only reads.
        write_data : int
          Taken if ``write_next``.
        data_in : int or None
          What the chip gives.
        write_keep : bool
          The chip keeps its word, and ``write_data`` is forgotten.
        """
        self._keep = write_keep
        self.read_data = data_in
        self.coming.popleft()
        self.coming.append(None)
        tick = self.interval == 0
        self.pins = self.pins._replace(command=Command.NOTHING, drive=False, data=write_data)
        if self.pause:
            self.pause -= 1
        else:
            self._begin(first, second)
        self.interval = self.generics.refresh_clocks - 1 if tick else self.interval - 1
        self.tick, self.due = tick, self.due or tick

    def _begin(self, first: Run | None, second: Run | None) -> None:
        """What comes where nothing has to be waited for."""
        generics = self.generics
        if self.state == "rests":
            if self.tick:
                self.left -= 1
            if self.left < 0:
                self.left, self.state = INIT_REFRESHES, "closes"
        elif self.state == "closes":
            self._say(Command.PRECHARGE, generics.rp_clocks, "refreshes", address=ALL_BANKS)
        elif self.state == "refreshes":
            self.left -= 1
            self._say(Command.REFRESH, generics.rfc_clocks, "refreshes" if self.left else "sets")
        elif self.state == "sets":
            mode = generics.cas_clocks << 4
            self._say(Command.MODE, generics.mrd_clocks, "waits", bank=0, address=mode, mask=False)
        elif self.state == "waits":
            self._open(first, second)
        elif self.state == "moves":
            self._move()
        else:
            self._say(Command.PRECHARGE, generics.rp_clocks, "waits", address=ALL_BANKS, mask=False)

    def _open(self, first: Run | None, second: Run | None) -> None:
        """Refresh, or open the row of a run; while nothing is asked for the address pins are free."""
        generics, run = self.generics, first or second
        if self.due:
            self.due = False
            self._say(Command.REFRESH, generics.rfc_clocks, "waits")
        elif run is not None:
            self.run, self.port, self.left = run, int(first is None), run.more
            page, self.column = divmod(run.address, 1 << generics.column_bits)
            row, bank = divmod(page, 1 << generics.bank_bits)
            self._say(Command.ACTIVE, generics.rcd_clocks, "moves", bank=bank, address=row)

    def _move(self) -> None:
        """A word of the run."""
        generics, write = self.generics, self.run.write
        command = Command.WRITE if write else Command.READ
        self._say(command, 1, "moves", address=self.column, drive=write)
        if write:
            self.pins = self.pins._replace(mask=self._keep)
        else:
            self.coming[-1] = self.port
        self.column = (self.column + 1) % (1 << generics.column_bits)
        if self.left == 0:
            self.state, self.pause = "ends", generics.close_clocks(write) - 1
        self.left -= 1

    def _say(self, command: Command, clocks: int, state: str, **pins: Any) -> None:
        """Give the chip a command, after which so many clocks go by until the next."""
        self.pins = self.pins._replace(command=command, **pins)
        self.pause, self.state = clocks - 1, state
