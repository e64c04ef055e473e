# SPDX-License-Identifier: Apache-2.0
"""What runs behind a simulated board's line: its golden model, or the board's VHDL in a simulator."""

from __future__ import annotations

import contextlib
import os
import subprocess
import tempfile
from collections import deque
from collections.abc import Callable

import numpy as np

from quadshade.board.programs import ghdl_board, verilator_board
from quadshade.board.settings import BoardSettings
from quadshade.choices import BOARD_ENGINES
from quadshade.contract.protocol import PHASE_BITS
from quadshade.engine.draw import default_engine
from quadshade.errors import QuadshadeError
from quadshade.golden.board import BoardModel

ANSWER_SECONDS = {"verilator": 4.0, "ghdl": 60.0, "model": 2.0}
"""How long a host waits for an answer of a board that is so simulated, on a machine that has more to do."""

SAME_RATE = 0.05
"""Rates further apart than this share are garbage to each other."""

BREAK_RATE = 9 / 20
"""A 00 at less than this share of a board's rate is a break to it."""

MAX_QUEUE = 1 << 16
"""Bytes for a simulator that wait here; then the line is not read any more."""

RECORD_BYTES = 255
QUIET_LINES = 20_000
"""A board in GHDL that says nothing for so many characters stands still until it is asked."""

END_SECONDS = 5.0
"""How long a simulator may take to end by itself."""


Monitor = Callable[[np.ndarray], None]
"""What a monitor's picture is given to."""


class Engine:
    """A board's pins, as bytes."""

    def feed(self, data: bytes) -> None:
        """Bytes for the board's rx."""
        raise NotImplementedError

    def take(self) -> bytes:
        """Bytes of the board's tx, without waiting."""
        raise NotImplementedError

    def set_baud(self, baud: int) -> None:
        """The rate of the bytes that come, and of those that are understood."""

    def reader(self) -> int | None:
        """A descriptor that is readable where :meth:`take` has something to do."""
        return None

    def writer(self) -> int | None:
        """A descriptor that is writable where :meth:`push` can go on."""
        return None

    def push(self) -> None:
        """Go on with what :meth:`feed` could not pass."""

    @property
    def is_full(self) -> bool:
        """Whether to feed nothing for now."""
        return False

    def close(self) -> None:
        """Stop."""


class ModelEngine(Engine):
    """
    The golden models of link, core and z-buffer.

    Parameters
    ----------
    settings : BoardSettings
    monitor : callable, optional
      Called with (height, width, channels) uint8, what a monitor shows, at first and whenever that changes.
    """

    def __init__(self, settings: BoardSettings, monitor: Monitor | None = None) -> None:
        self.board = BoardModel(
            settings.screen_width,
            settings.screen_height,
            settings.formats,
            settings.clk_frequency_hz,
            settings.baud,
            settings.fifo_words,
            bool(settings.with_edge_map),
            bool(settings.with_video),
            settings.most_counter_bits,
            settings.buffers,
            settings.colour_bits,
            bool(settings.with_packed_read),
            bool(settings.with_vertices),
            bool(settings.single_buffer),
        )
        self._baud = settings.baud
        self._answers = bytearray()
        self._screen, self._buffers = self.board.screen, settings.buffers
        self._monitor = monitor
        self._last: np.ndarray | None = None
        self._show()

    def set_baud(self, baud: int) -> None:
        self._baud = baud

    def feed(self, data: bytes) -> None:
        board = self.board
        clock = board.identity["clk_frequency_hz"]
        ratio = self._baud / (board.phase_step * clock / (1 << PHASE_BITS))
        if abs(ratio - 1) <= SAME_RATE:
            self._answers += board.feed(data)
            self._show()
        elif ratio < BREAK_RATE and 0 in data:
            board.phase_step = board.identity["default_phase_step"]

    def _show(self) -> None:
        """Tell the monitor, if there is one, what has changed."""
        if self._monitor is None:
            return
        shown = self._screen.shown if self._buffers == 2 else self._screen.plane(0)
        if self._last is None or not np.array_equal(shown, self._last):
            self._last = shown.copy()
            self._monitor(self._last)

    def take(self) -> bytes:
        data = bytes(self._answers)
        self._answers.clear()
        return data


class ProgramEngine(Engine):
    """
    A simulator in a process of its own, which ends when its standard input does.

    What goes in are records: a number n from 1 to 255 and n bytes for the line; or 0 and a baud rate of four
    bytes, lowest first, of which 0 asks for a line of counters on standard error. What comes out are the
    line's bytes.

    Parameters
    ----------
    command : list of str
    """

    def __init__(self, command: list[str]) -> None:
        self._scratch = tempfile.TemporaryDirectory(prefix="quadshade-")
        self._process = subprocess.Popen(
            command,
            cwd=self._scratch.name,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            bufsize=0,
            # Ctrl-C is for the program that started it.
            start_new_session=True,
        )
        if not (self._process.stdin and self._process.stdout and self._process.stderr):
            raise AssertionError("the program has no pipes")
        self._pipes = self._process.stdin, self._process.stdout, self._process.stderr
        self._input, self._output = self._pipes[0].fileno(), self._pipes[1].fileno()
        os.set_blocking(self._input, False)
        self._queue = bytearray()

    def reader(self) -> int:
        return self._output

    def writer(self) -> int | None:
        return self._input if self._queue else None

    @property
    def is_full(self) -> bool:
        return len(self._queue) > MAX_QUEUE

    def feed(self, data: bytes) -> None:
        for at in range(0, len(data), RECORD_BYTES):
            part = data[at : at + RECORD_BYTES]
            self._queue += bytes([len(part)]) + part
        self.push()

    def set_baud(self, baud: int) -> None:
        self._queue += b"\0" + baud.to_bytes(4, "little")
        self.push()

    def push(self) -> None:
        if not self._queue:
            return
        try:
            del self._queue[: os.write(self._input, self._queue)]
        except BlockingIOError:
            pass
        except OSError:
            raise self._ended() from None

    def take(self) -> bytes:
        data = os.read(self._output, MAX_QUEUE)
        if not data:
            raise self._ended()
        return data

    def counters(self) -> dict[str, int]:
        """Clocks since the start: all, those with a byte on its way to rx, and those with one from tx."""
        self.set_baud(0)
        words = self._pipes[2].readline().split()
        return {name.decode(): int(value) for name, value in zip(words[::2], words[1::2], strict=True)}

    def _ended(self) -> QuadshadeError:
        """The error for a simulator that stopped by itself."""
        self._process.wait(END_SECONDS)
        said = self._pipes[2].read().decode(errors="replace").strip().splitlines()
        return QuadshadeError(f"the simulation has ended: {said[0] if said else 'without a word'}")

    def close(self) -> None:
        self._pipes[0].close()
        try:
            self._process.wait(END_SECONDS)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        for stream in self._pipes[1:]:
            with contextlib.suppress(OSError):
                stream.close()
        self._scratch.cleanup()


class GhdlEngine(ProgramEngine):
    """
    GHDL in lock-step: for a line of what came from tx it gets a line of what goes to rx.

    Parameters
    ----------
    command : list of str
      ``sim/board_tb.vhd`` says what it reads and writes.
    """

    def __init__(self, command: list[str]) -> None:
        super().__init__(command)
        self._items: deque[str] = deque()
        self._said = bytearray()
        self._asked = False
        self._quiet = 0

    @property
    def is_full(self) -> bool:
        return len(self._items) > MAX_QUEUE

    def feed(self, data: bytes) -> None:
        self._items += [f"{byte:02x}" for byte in data]
        self._answer()

    def set_baud(self, baud: int) -> None:
        self._items.append(f"r{baud:08x}")
        self._answer()

    def take(self) -> bytes:
        self._said += super().take()
        *lines, rest = self._said.split(b"\n")
        self._said = bytearray(rest)
        heard = b""
        for line in lines:
            try:
                heard += bytes.fromhex(line.decode())
            except ValueError:
                # GHDL's errors come here too.
                raise QuadshadeError(f"the simulation says: {line.decode(errors='replace')}") from None
            self._asked = True
            self._quiet = 0 if line else self._quiet + 1
            self._answer()
        return heard

    def _answer(self) -> None:
        """Let it go on, unless there is nothing to do for a while."""
        if not self._asked:
            return
        if self._items:
            text = self._items.popleft()
            self._quiet = 0
        elif self._quiet < QUIET_LINES:
            text = ""
        else:
            return
        self._asked = False
        self._queue += f"{text}\n".encode()
        self.push()

    def counters(self) -> dict[str, int]:
        raise QuadshadeError("GHDL counts no clocks of the line", "use --engine verilator")


def board_engine(name: str | None) -> str:
    """The engine of a name, or by default the fastest that can run here: ``verilator``, else ``model``."""
    name = name or default_engine()
    if name not in BOARD_ENGINES:
        raise QuadshadeError(f"there is no engine {name!r}", f"the engines are {', '.join(BOARD_ENGINES)}")
    return name


def start_engine(name: str, settings: BoardSettings, monitor: Monitor | None = None) -> Engine:
    """
    A board that runs.

    Parameters
    ----------
    name : str
      One of ``BOARD_ENGINES``.
    settings : BoardSettings
    monitor : callable, optional
      As for :class:`ModelEngine`, and of it alone.

    Raises
    ------
    QuadshadeError
      An unknown engine, one without a monitor, a missing simulator, or generics that no board is built with.
    """
    name = board_engine(name)
    if name == "model":
        return ModelEngine(settings, monitor)
    if monitor is not None:
        raise QuadshadeError(f"the engine {name} shows no monitor", "use --engine model")
    try:
        if name == "verilator":
            return ProgramEngine(verilator_board(settings.generics()))
        return GhdlEngine(ghdl_board(settings.generics()))
    except OSError as problem:
        raise QuadshadeError(f"the simulator's files: {problem}", "use --engine model") from None
