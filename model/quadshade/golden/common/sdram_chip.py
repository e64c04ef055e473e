# SPDX-License-Identifier: Apache-2.0
"""
An SDRAM of one data rate, as a chip: it holds words, and refuses what its data sheet does.

Every command is checked against every time of the data sheet, in clocks upwards of nanoseconds; the order
after power-up too. Bursts are of one word, as ``sdram_controller`` sets them.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from enum import IntEnum
from math import ceil
from typing import NamedTuple

from quadshade.errors import QuadshadeError

ALL_BANKS = 1 << 10
"""The address bit by which PRECHARGE is of all banks, and a read or a write closes its row."""

POWER_UP_NS = 200_000
"""Rest after power-up: 100 us in some data sheets, 200 us in others."""
INIT_REFRESHES = 2
"""At least so many between power-up and the mode; eight in some data sheets."""


class Command(IntEnum):
    """RAS, CAS and WE of the chip, all low active, while it is selected."""

    MODE = 0b000
    REFRESH = 0b001
    PRECHARGE = 0b010
    ACTIVE = 0b011
    WRITE = 0b100
    READ = 0b101
    STOP = 0b110
    NOTHING = 0b111


class Pins(NamedTuple):
    """
    What the chip sees in a clock.

    ``data`` is what stands on its pins where ``drive`` is set; with ``mask`` a write changes nothing.
    """

    command: Command
    bank: int = 0
    address: int = 0
    mask: bool = True
    drive: bool = False
    data: int = 0


IDLE_PINS = Pins(Command.NOTHING)


@dataclass(frozen=True)
class SdramTiming:
    """
    Times of a data sheet in nanoseconds, under the data sheet's names.

    Attributes
    ----------
    t_mrd : float
      From the mode to any command; where the data sheet has clocks instead, 0: it is never less than two.
    t_ras_max : float
      A row is open at most so long.
    t_ref : float
      In which every row is refreshed once.
    t_ck2 : float
      Shortest clock for a CAS latency of two.
    t_ac, t_oh, t_is, t_ih : float
      From a clock edge to the word of a CAS latency of three, and how long that stays; set-up and hold of
      every input.
    """

    source: str
    t_rcd: float
    t_rp: float
    t_ras: float
    t_rc: float
    t_rfc: float
    t_rrd: float
    t_wr: float
    t_mrd: float
    t_ck2: float
    t_ac: float
    t_oh: float
    t_is: float = 1.5
    t_ih: float = 0.8
    t_ras_max: float = 120_000.0
    t_ref: float = 64e6
    rows: int = 8192
    columns: int = 512
    banks: int = 4
    data_bits: int = 16

    def clocks(self, name: str, frequency_hz: float) -> int:
        """A time in whole clocks, upwards."""
        least = 2 if name == "t_mrd" else 1
        # A whole number of clocks is not more because it is a float.
        return max(least, ceil(getattr(self, name) * frequency_hz / 1e9 - 1e-9))


CHIPS = {
    "MT48LC16M16A2-75": SdramTiming(
        source="Micron 256Mb: x4, x8, x16 SDRAM, table 12",
        t_rcd=20,
        t_rp=20,
        t_ras=44,
        t_rc=66,
        t_rfc=66,
        t_rrd=15,
        t_wr=15,
        t_mrd=0,
        t_ck2=10,
        t_ac=5.4,
        t_oh=3,
    ),
    "AS4C16M16SA-7": SdramTiming(
        source="Alliance AS4C16M16SA-C&I, rev. 3.0, table 16",
        t_rcd=21,
        t_rp=21,
        t_ras=42,
        t_rc=63,
        t_rfc=63,
        t_rrd=14,
        t_wr=14,
        t_mrd=14,
        t_ck2=10,
        t_ac=5.4,
        t_oh=2.5,
    ),
}
"""256 Mbit in 16 bits, as boards carry them; by their data sheets."""


class SdramFault(QuadshadeError):
    """A command that the data sheet does not allow there."""


class SdramChip:
    """
    The chip.

    Parameters
    ----------
    timing : SdramTiming
    frequency_hz : float
    power_up_ns : float
      Shorter for tests; the data sheet's if left out.

    Attributes
    ----------
    words : dict of int
      By (bank, row, column); what was never written is not there.
    open_rows : dict of int
      By bank.
    data : int or None
      What stands on the pins at the end of this cycle; None where nothing does, or an undefined word.
    reads, writes, refreshes : int
      So far.
    """

    def __init__(
        self, timing: SdramTiming, frequency_hz: float = 100e6, power_up_ns: float = POWER_UP_NS
    ) -> None:
        self.timing, self.frequency_hz = timing, frequency_hz
        self.power_up = ceil(power_up_ns * frequency_hz / 1e9)
        self.words: dict[tuple[int, int, int], int] = {}
        self.open_rows: dict[int, int] = {}
        self.cas: int | None = None
        self.now = 0
        self.reads = self.writes = self.refreshes = 0
        self._opened: dict[int, int] = {}
        self._closed: dict[int, int] = {}
        self._written: dict[int, int] = {}
        self._any_opened = self._refreshed = self._set = -(10**9)
        self._refreshed_at: deque[int] = deque(maxlen=timing.rows)
        self._coming: deque[int | None] = deque([None] * 4)
        self._masked = False
        # In the clock before this one, in this one, in the next ones.
        self._driven: deque[bool] = deque([False] * 5)

    @property
    def data(self) -> int | None:
        """What stands on the pins at the end of this cycle."""
        return self._coming[0]

    def clock(self, pins: Pins) -> None:
        """
        One clock edge.

        Raises
        ------
        SdramFault
          A time is too short or too long, a row is not open, or not closed; two drive the pins.
        """
        self._coming.popleft()
        self._coming.append(None)
        # A mask is of the word that comes two clocks after it.
        if self._masked:
            self._coming[0] = None
        self._masked = pins.mask
        if pins.drive and (self._driven[0] or self._driven[1]):
            raise self._fault("the pins are driven while a word is read, or in the clock after it")
        self._driven.popleft()
        self._driven.append(False)
        self._limits()
        command = pins.command
        if command not in (Command.NOTHING, Command.STOP):
            if self.now < self.power_up:
                raise self._fault(f"{command.name} {self.now} clocks after power-up, not {self.power_up}")
            self._since(self._refreshed, "t_rfc", f"{command.name} after REFRESH")
            self._since(self._set, "t_mrd", f"{command.name} after MODE")
        if command == Command.MODE:
            self._mode(pins)
        elif command == Command.REFRESH:
            self._refresh()
        elif command == Command.PRECHARGE:
            for bank in range(self.timing.banks) if pins.address & ALL_BANKS else (pins.bank,):
                self._close(bank)
        elif command == Command.ACTIVE:
            self._open(pins.bank, pins.address)
        elif command in (Command.READ, Command.WRITE):
            self._access(pins)
        self.now += 1

    def _fault(self, what: str) -> SdramFault:
        """A fault in this clock."""
        return SdramFault(f"SDRAM, clock {self.now}: {what}", self.timing.source)

    def _since(self, then: int | None, name: str, what: str) -> None:
        """Raise unless a time has gone by since then."""
        least = self.timing.clocks(name, self.frequency_hz)
        if then is not None and self.now - then < least:
            raise self._fault(f"{what}: {self.now - then} clocks, {name} is {least}")

    def _limits(self) -> None:
        """Raise where a row is open, or one was not refreshed, for too long."""
        most = int(self.timing.t_ras_max * self.frequency_hz / 1e9)
        for bank in self.open_rows:
            if self.now - self._opened[bank] > most:
                raise self._fault(f"bank {bank} is open for more than {most} clocks")
        longest = int(self.timing.t_ref * self.frequency_hz / 1e9)
        refreshed = self._refreshed_at
        since = refreshed[0] if len(refreshed) == self.timing.rows else self._set
        if self.cas is not None and self.now - since > longest:
            raise self._fault(f"a row was not refreshed for {longest} clocks")

    def _mode(self, pins: Pins) -> None:
        """Set latency and burst."""
        self._all_closed("MODE")
        if self.refreshes < INIT_REFRESHES:
            raise self._fault(f"MODE after {self.refreshes} refreshes, {INIT_REFRESHES} are needed")
        latency, burst = pins.address >> 4 & 7, pins.address & 0xF
        if pins.bank or pins.address >> 7 or burst or latency not in (2, 3):
            raise self._fault(f"a mode of {pins.address:#x}: bursts of one word and 2 or 3 clocks are known")
        if latency == 2 and self.timing.t_ck2 * self.frequency_hz > 1e9:
            raise self._fault("a CAS latency of 2 at this clock")
        self.cas, self._set = latency, self.now

    def _refresh(self) -> None:
        """Refresh the next row of each bank."""
        self._all_closed("REFRESH")
        self.refreshes += 1
        self._refreshed = self.now
        self._refreshed_at.append(self.now)

    def _all_closed(self, what: str) -> None:
        """Raise unless every bank was closed, for long enough."""
        if self.open_rows:
            raise self._fault(f"{what} while bank {min(self.open_rows)} is open")
        if len(self._closed) < self.timing.banks:
            raise self._fault(f"{what} before the banks were closed")
        self._since(max(self._closed.values()), "t_rp", f"{what} after PRECHARGE")

    def _close(self, bank: int) -> None:
        """Close a bank's row, if one is open."""
        if bank in self.open_rows:
            self._since(self._opened[bank], "t_ras", "PRECHARGE after ACTIVE")
            self._since(self._written.get(bank), "t_wr", "PRECHARGE after WRITE")
            del self.open_rows[bank]
            self._closed[bank] = self.now
        self._closed.setdefault(bank, self.now)

    def _open(self, bank: int, row: int) -> None:
        """Open a row."""
        if self.cas is None:
            raise self._fault("ACTIVE before MODE")
        if bank in self.open_rows:
            raise self._fault(f"ACTIVE while bank {bank} is open")
        if row >= self.timing.rows:
            raise self._fault(f"row {row} of {self.timing.rows}")
        self._since(self._closed[bank], "t_rp", "ACTIVE after PRECHARGE")
        self._since(self._opened.get(bank), "t_rc", "ACTIVE after ACTIVE")
        self._since(self._any_opened, "t_rrd", "ACTIVE after ACTIVE of another bank")
        self.open_rows[bank] = row
        self._opened[bank] = self._any_opened = self.now

    def _access(self, pins: Pins) -> None:
        """Read or write a word."""
        name = pins.command.name
        if pins.bank not in self.open_rows or self.cas is None:
            raise self._fault(f"{name} in bank {pins.bank}, which is not open")
        if pins.address & ALL_BANKS:
            raise self._fault(f"{name} that closes its row is not known here")
        if pins.address >= self.timing.columns:
            raise self._fault(f"column {pins.address} of {self.timing.columns}")
        if pins.mask and pins.command == Command.READ:
            raise self._fault("READ while the mask is set")
        if pins.drive != (pins.command == Command.WRITE):
            raise self._fault(f"{name} {'with' if pins.drive else 'without'} a word on the pins")
        self._since(self._opened[pins.bank], "t_rcd", f"{name} after ACTIVE")
        place = (pins.bank, self.open_rows[pins.bank], pins.address)
        if pins.command == Command.READ:
            # Its word stands on the pins before the edge that is so many clocks from this one.
            self._coming[self.cas - 1] = self.words.get(place)
            self._driven[self.cas] = True
            self.reads += 1
        else:
            if not pins.mask:
                self.words[place] = pins.data
            self._written[pins.bank] = self.now
            self.writes += 1
