# SPDX-License-Identifier: Apache-2.0
"""A board from Python: whatever the line does, the picture is right, or there is an error."""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable
from dataclasses import replace
from typing import Any, Self

import numpy as np

from quadshade.board import fallbacks
from quadshade.board.frame_time import Watch, uncounted
from quadshade.board.ports import RECONNECT_SECONDS, Port
from quadshade.board.readback import BoardReader
from quadshade.board.settings import BoardSettings
from quadshade.board.simulated import SimulatedBoard
from quadshade.choices import MAX_ERROR, PACK_ERROR
from quadshade.contract.formats import Formats
from quadshade.contract.identity import has_feature, knows
from quadshade.contract.protocol import BoardResetError, LinkError, Opcode
from quadshade.contract.shade_state import ShadeState
from quadshade.contract.triangles import Pixels, ScreenTriangles
from quadshade.engine.draw import draw as draw_model
from quadshade.errors import QuadshadeError
from quadshade.golden.board import DrawnScreen
from quadshade.link.session import MAX_WORDS, Session
from quadshade.link.transport import FaultyTransport, Transport
from quadshade.packing.frame_file import FrameFile
from quadshade.packing.neighbours import ordered_for_vertices
from quadshade.packing.pack import packed_writes
from quadshade.packing.pack_vertices import as_run
from quadshade.setup.triangle_setup import setup_triangles

REDRAWS = 5
"""How often a picture is begun anew because the board was reset."""

Progress = Callable[[str, float, float, int], None]
"""Called with what is done (``drawing``, ``reading``), how much, of how much, and bytes so far."""


def _warn(text: str) -> None:
    warnings.warn(text, stacklevel=3)


class Board(BoardReader):
    """
    A board, real or simulated; a context manager.

    Parameters
    ----------
    port : str or serial object, optional
      ``sim``, ``sim:BOARD``, ``auto``, a name, a pyserial URL, or an open object; else ``QUADSHADE_PORT``.
    baud : int, optional
      ``QUADSHADE_BAUD`` or 1000000 if left out. Another rate is agreed on with the board.
    settings : BoardSettings, optional
      Of a simulated board.
    engine : str, optional
      What simulates it: ``verilator``, ``ghdl`` or ``model``; the first one where it can.
    faults : tuple of (float, int or str), optional
      Faults a byte that the line is given, both ways, and their seed.
    answer_seconds, reconnect_seconds : float, optional
      Time-outs of an answer, and of a line that vanished.
    trace, notice : callable, optional
      Called with a line of text for every frame; with what the board cannot do as asked (a warning if left
      out).
    progress : callable, optional
      See :data:`Progress`.

    Attributes
    ----------
    formats : Formats
      The board's generics.
    host_formats : Formats
      Those to shade for: colour and depth, whether the board has them or not.
    width, height : int
      Its screen.
    identity : dict of int
      All that HELLO says.
    session : Session
    late : int
      Pictures that missed their deadline.

    Raises
    ------
    QuadshadeError
      No board answers there, or one of another version or other formats.
    """

    def __init__(
        self,
        port: Any = None,
        baud: int | None = None,
        *,
        settings: BoardSettings | None = None,
        engine: str | None = None,
        faults: tuple[float, int | str] | None = None,
        answer_seconds: float | None = None,
        reconnect_seconds: float = RECONNECT_SECONDS,
        trace: Callable[[str], None] | None = None,
        notice: Callable[[str], None] | None = None,
        progress: Progress | None = None,
    ) -> None:
        self._port = Port(port, baud, settings, engine)
        self._notice, self.progress = notice or _warn, progress
        self._reconnect_seconds = reconnect_seconds
        self._faulty: FaultyTransport | None = None
        self._start, self._triangles = time.monotonic(), 0
        self._closed = False
        try:
            line: Transport = self._port.open()
            if faults is not None:
                line = self._faulty = FaultyTransport(line, *faults)
            seconds = self._port.seconds_of(answer_seconds)
            self.session = Session(line, seconds, trace=trace, reopen=self._reopen)
            self._port.agree(self.session)
            # A simulated board has been compiled by now, which is no part of a rate.
            self._start = time.monotonic()
            self.identity = self.session.identity
            self.formats = Formats(**{name: self.identity[name] for name in Formats().generics()})
            self.host_formats = fallbacks.host_formats(self.formats)
            self.width, self.height = self.identity["screen_width"], self.identity["screen_height"]
            size, has_edges = (self.width, self.height), has_feature(self.identity, "edge_map")
            self._vertices = has_feature(self.identity, "vertices")
            self._expected = DrawnScreen(*size, self.formats, has_edges, self.colour_bits, self._vertices)
            self._is_shown = False
            # What a board that was reset has to be told again, and what it knew before the picture was begun.
            self._journal: list[Callable[[], None]] = []
            self._registers: dict[int, int] = {}
            self._pixels: list[Pixels] = []
            self.late = 0
            self.clear()
        except BaseException:
            self.close()
            raise

    def _reopen(self) -> Transport:
        """The line anew, as damaged as before."""
        if self._closed:
            raise LinkError("the board is closed", "open another one")
        self.session.transport.close()
        line = self._port.reopen(self._reconnect_seconds)
        if self._port.baud is not None:
            # Whatever rate the board has, it is the default one then.
            line.send_break()
        if self._faulty is None:
            return line
        self._faulty.transport = line
        return self._faulty

    def close(self) -> None:
        """Give the line up, and stop a simulated board; nothing can be drawn or read after it."""
        self._closed = True
        if hasattr(self, "session"):
            self.session.transport.close()
        self._port.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *problem: object) -> None:
        self.close()

    # What happens when the board is reset.

    def _do(self, action: Callable[[], None]) -> None:
        """Do something that changes the picture; with all before it, where the board was reset meanwhile."""
        self._journal.append(action)
        try:
            action()
        except BoardResetError:
            self._redraw()

    def _ask(self, question: Callable[[], Any]) -> Any:
        """The answer about a picture that is whole."""
        for _ in range(REDRAWS):
            try:
                self.session.check()
                return question()
            except BoardResetError:
                self._redraw()
        raise LinkError(f"the board was reset {REDRAWS} times", "look at its supply and its reset")

    def _redraw(self) -> None:
        """Draw the picture anew, from its clear on."""
        for _ in range(REDRAWS):
            self.session.statistics["redraws"] += 1
            try:
                self.session.connect()
                for action in self._journal:
                    action()
                return
            except BoardResetError:
                continue
        raise LinkError(f"the board was reset {REDRAWS} times", "look at its supply and its reset")

    # What a user wants.

    def clear(self, colour: tuple[int, int, int] = (0, 0, 0)) -> None:
        """
        Begin a picture: fill the screen with a colour, 0 .. 255 each, and forget all depth.

        Parameters
        ----------
        colour : 3 ints

        Raises
        ------
        QuadshadeError
          Other than three whole numbers from 0 to 255.
        """
        self._begin(fallbacks.clear_word(colour, self.formats))

    def _begin(self, word: int) -> None:
        """CLEAR, and a journal that begins with it."""
        self._journal, self._pixels, self._is_shown = [], [], False
        if self._registers:
            known = dict(self._registers)
            self._journal.append(lambda: self._send_state(known))
        self._do(lambda: self.session.clear(word))
        self._expected.clear(word)

    def show(self) -> None:
        """
        Show what was drawn, whole, where there are two buffers; the next thing is a :meth:`clear`.

        A board with one buffer shows every pixel as it is drawn, and does nothing here.
        """
        if knows(self.identity, Opcode.SWAP) and not self._is_shown:
            self._do(self.session.swap)
            self._expected.swap()
            self._is_shown = True

    def state(self, state: ShadeState, words: np.ndarray | None = None) -> None:
        """Load the shade unit's registers and tables; of tables only what (m,) uint32 packed words read."""
        if not self.formats.with_shade:
            raise QuadshadeError("the board has no shade unit", "use a --shading of colours")
        writes = state.writes() if words is None else packed_writes(words, state, self.formats)
        self._write({int(address): int(word) for address, word in writes})

    def _write(self, written: dict[int, int]) -> None:
        """Registers of the shade unit, those that change."""
        changed = {at: word for at, word in written.items() if self._registers.get(at) != word}
        if changed:
            self._do(lambda: self._send_state(changed))
        # What was drawn before keeps the state that it was drawn with.
        self._expected.draw_words()
        for address, word in changed.items():
            self._expected.state(address, word)
        self._registers |= written

    def _send_state(self, registers: dict[int, int]) -> None:
        """Write registers, those of addresses in a row together."""
        addresses = np.array(sorted(registers))
        for run in np.split(addresses, np.flatnonzero(np.diff(addresses) != 1) + 1):
            self.session.state(int(run[0]), [registers[address] for address in run.tolist()])

    def draw(
        self,
        triangles: ScreenTriangles,
        pack_error: float = PACK_ERROR,
        limit: float | None = MAX_ERROR,
        deadline: float | None = None,
        **setup: Any,
    ) -> None:
        """
        Draw triangles; returns when the board has accepted them.

        Parameters
        ----------
        triangles : ScreenTriangles
          Made with :attr:`host_formats`. What the board does not have is replaced: colour by luminance, depth
          by painter's order; with a notice.
        pack_error : float
          As for :func:`quadshade.packing.pack.pack_primitives`.
        limit, **setup
          As for :func:`quadshade.setup.triangle_setup.setup_triangles`.
        deadline : float, optional
          Seconds that line and board may take for the picture, its :meth:`clear` included; words get shorter
          for it, to half a grey level. :attr:`late` counts what a bad line has delayed nevertheless.

        Raises
        ------
        QuadshadeError
          The picture is larger than the screen, the triangles have channels that the board cannot draw, or
          they would miss the deadline: then nothing is sent.
        """
        matched, notices = fallbacks.matched_channels(triangles, self.formats)
        self._check_size(matched.width, matched.height)
        if self.formats.with_depth == 0 and matched.depth is not None:
            matched = fallbacks.painters_order(matched)
            formats = fallbacks.painters_formats(self.formats)
            self._pixels.append(draw_model(matched, formats, "model", limit=limit, **setup).pixels)
            notices.append(fallbacks.painters_notice(self._pixels, self.width, self.height))
            matched = replace(matched, depth=None)
        if self._vertices:
            matched = ordered_for_vertices(matched, self.formats)
        primitives = setup_triangles(matched, self.formats, limit=limit, **setup)
        watch = Watch(self.session, self.clock, self.simulated is None, deadline)
        packed = watch.packed(primitives, matched, self.formats, pack_error)
        for text in (*notices, *(() if deadline is None else uncounted(self.identity)), *watch.notices):
            self._notice(text)
        if matched.shade is not None:
            self.state(matched.shade, packed.words)
        self.send(packed.words, len(triangles), packed.vertices)
        if watch.is_late():
            self.late += 1
            self._notice("late: the picture has missed its deadline")

    def send(self, words: np.ndarray, triangles: int = 0, vertices: bool = False) -> None:
        """
        Draw packed words: whole packets, as :func:`quadshade.packing.pack.pack_primitives` makes them.

        Parameters
        ----------
        words : (m,) uint32
        triangles : int
          How many they draw, for the progress.
        vertices : bool
          They are those of :func:`quadshade.packing.pack_vertices.pack_vertices`.

        Raises
        ------
        QuadshadeError
          Something else than an array of words, or words that the board cannot read.
        """
        if not isinstance(words, np.ndarray) or words.ndim != 1 or words.dtype != np.uint32:
            raise QuadshadeError("what is sent is no row of uint32 words", "send those of pack_primitives")
        if vertices and not self._vertices:
            raise QuadshadeError("the board takes no vertices", "pack without --vertices")
        if self._vertices and not vertices:
            words = as_run(words)
        self._check_drawn()
        self._do(lambda: self._stream(words, triangles))
        self._triangles += triangles
        self._expected.triangles(words.tolist())

    def _stream(self, words: np.ndarray, triangles: int) -> None:
        for at in range(0, len(words), MAX_WORDS):
            self.session.triangles(words[at : at + MAX_WORDS])
            self._report("drawing", triangles * min(1.0, (at + MAX_WORDS) / len(words)), triangles)
        self.session.flush()

    def _report(self, what: str, done: float, total: float) -> None:
        if self.progress:
            statistics = self.session.statistics
            self.progress(what, done, total, statistics["bytes_sent"] + statistics["bytes_received"])

    def replay(self, frame: FrameFile, verify: bool = True) -> None:
        """
        Draw a packed picture.

        Parameters
        ----------
        frame : FrameFile
          From :func:`quadshade.packing.frame_file.read_frame_file`.
        verify : bool
          The board's CRCs must be those of the file.

        Raises
        ------
        QuadshadeError
          The board has other generics or another screen, or takes no vertices; or a CRC differs.
        """
        frame.check_sendable(self.identity)
        self._begin(frame.clear_colour)
        for address, words in frame.state:
            self._write({address + index: int(word) for index, word in enumerate(words)})
        self.send(frame.words, frame.triangles, frame.vertices)
        crcs = {"colour": frame.crc} | ({"depth": frame.depth_crc} if self.formats.with_depth else {})
        for plane, crc in crcs.items() if verify else ():
            # The file's colours have eight bits; those of fewer are compared with the golden model alone.
            if self.verify(plane) != crc and (plane != "colour" or self.colour_bits == 8):
                raise QuadshadeError(
                    f"the file's CRC of the {plane} is not that of its words", "pack the picture again"
                )

    @property
    def simulated(self) -> SimulatedBoard | None:
        """What simulates it, if the port is ``sim``."""
        return self._port.simulated

    def notice(self, text: str) -> None:
        """Say what is not as asked, as the board itself does."""
        self._notice(text)

    def status(self) -> dict[str, int]:
        """The board's counters."""
        return self.session.status()

    @property
    def statistics(self) -> dict[str, float]:
        """What the line did since the board was opened: bytes, frames, what was lost; and seconds."""
        seconds = time.monotonic() - self._start
        names = ("bytes_sent", "bytes_received", "sent", "received", "resent", "timeouts", "reconnects")
        counts = {name: self.session.statistics[name] for name in (*names, "redraws")}
        return counts | {"triangles": self._triangles, "seconds": seconds}
