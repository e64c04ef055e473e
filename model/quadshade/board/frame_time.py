# SPDX-License-Identifier: Apache-2.0
"""
How long a picture takes on a board, in the board's own clocks: the one place that says so.

A picture is begun with the first bit of its CLEAR on the line and complete when its last pixel is written.
Until then the line carries frames, a frame's words count from its end on, they are unpacked and drawn one
after the other, and a clear fills the screen. ``make frametime`` compares it with the board in simulation.
"""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from quadshade.choices import MAX_ERROR, PACK_ERROR
from quadshade.contract.formats import Formats
from quadshade.contract.protocol import MAX_PAYLOAD, WORD_BYTES, Opcode
from quadshade.contract.shade_state import ShadeState, colour_state
from quadshade.contract.triangles import ScreenTriangles
from quadshade.errors import QuadshadeError
from quadshade.golden.clocks import count_board_clocks
from quadshade.golden.compiled import draw_fast
from quadshade.golden.compiled_packets import decode_packets
from quadshade.golden.line_clocks import Line
from quadshade.golden.screen.depth_test import empty_depths, kept_pixels
from quadshade.golden.unpacker_clocks import unpacking_of
from quadshade.link.session import Session
from quadshade.packing.frame_file import state_runs
from quadshade.packing.line import frame_bytes, frames_bytes
from quadshade.packing.neighbours import ordered_for_vertices
from quadshade.packing.pack import Packed, pack_primitives, packed_writes
from quadshade.packing.pack_vertices import pack_run, pack_vertices
from quadshade.setup.packet import Primitives, pack
from quadshade.setup.triangle_setup import setup_triangles

BITS_A_BYTE = 10
"""On the line: start, eight, stop."""

BITS_TO_SAMPLE = 9 + 5 / 8
"""From a byte's start to the sample of its stop bit, with which it is there (``uart_rx.vhd``)."""

JUDGE_CLOCKS = 8
"""From then on until a frame's words count."""

LEAST_COUNTED = 512
"""Words of a FIFO that has room for the next frame while one is drawn: twice what a frame has."""

DEPTH_CLOCKS, PICTURE_CLOCKS = 8, 2
"""From a pixel's leaving the core to the framebuffer (``depth_test.vhd``), and there until it is written."""


@dataclass(frozen=True)
class BoardClock:
    """
    What a picture's time depends on beside the picture.

    Attributes
    ----------
    clk_frequency_hz, baud : int
    width, height : int
      Of the screen.
    single_buffer : bool
      A packet waits until none is drawn; HELLO says so.
    takes_vertices : bool
      HELLO says so.
    fifo_words : int
    """

    clk_frequency_hz: int
    baud: int
    width: int
    height: int
    single_buffer: bool = False
    takes_vertices: bool = False
    fifo_words: int = 1024

    def clocks_of_bytes(self, count: float) -> float:
        """Clocks that so many bytes take on the line."""
        return count * BITS_A_BYTE * self.clk_frequency_hz / self.baud


@dataclass(frozen=True)
class PictureClocks:
    """
    What a picture takes.

    Attributes
    ----------
    line_bytes : int
    line : int
      Clocks in which the line is busy.
    whole : int
      Clocks until it is drawn.
    busy : int
      Those in which the board is not idle, as STATUS counts them.
    waiting : int
      Words in the board's FIFO at most, if that has room for them.
    """

    line_bytes: int
    line: int
    whole: int
    busy: int
    waiting: int


def commands_of(words: np.ndarray, state: ShadeState | None, formats: Formats) -> list[tuple[Opcode, int]]:
    """Frames that draw packed words, in order: opcode and words of payload."""
    commands = [(Opcode.CLEAR, 1)]
    if formats.with_shade:
        writes = packed_writes(words, colour_state(formats) if state is None else state, formats)
        most = MAX_PAYLOAD // WORD_BYTES - 1
        for _, run in state_runs(writes):
            commands += [(Opcode.STATE, 1 + min(most, len(run) - at)) for at in range(0, len(run), most)]
    most = MAX_PAYLOAD // WORD_BYTES
    commands += [(Opcode.TRIANGLES, min(most, len(words) - at)) for at in range(0, len(words), most)]
    return commands


def _pixel_clocks(setup_words: np.ndarray, formats: Formats, clock: BoardClock) -> np.ndarray:
    """(pixels,) int64 clocks from a pixel's leaving the core to its place in the picture, or to its end."""
    emitted = draw_fast(setup_words, formats.core)
    if not formats.with_depth:
        return np.full(max(len(emitted.x), 1), PICTURE_CLOCKS)
    stored = empty_depths(clock.width, clock.height, formats.depth_bits)
    kept = kept_pixels(emitted.x, emitted.y, emitted.value[:, -1], stored)
    clocks = np.where(kept, DEPTH_CLOCKS + PICTURE_CLOCKS, DEPTH_CLOCKS - 1)
    return clocks if len(clocks) else np.zeros(1, np.int64)


def picture_clocks(
    triangles: ScreenTriangles,
    formats: Formats,
    clock: BoardClock,
    error: float = PACK_ERROR,
    limit: float | None = MAX_ERROR,
    sizes: Sequence[int] | None = None,
    **setup: Any,
) -> PictureClocks:
    """
    The clocks of a picture on a board that is idle, over an undamaged line that never pauses.

    Parameters
    ----------
    triangles : ScreenTriangles
      As the board gets them (:func:`quadshade.board.fallbacks.sent_triangles`).
    formats : Formats
      Of the board.
    clock : BoardClock
    error, limit, **setup
      As for :func:`quadshade.packing.line.picture_line_bytes`.
    sizes
      As for :func:`packed_clocks`.

    Returns
    -------
    PictureClocks
    """
    packed, clocks = soonest_picture(triangles, formats, clock, error, limit, **setup)
    return clocks if sizes is None else packed_clocks(packed, triangles.shade, formats, clock, sizes)


def soonest_picture(
    triangles: ScreenTriangles,
    formats: Formats,
    clock: BoardClock,
    error: float = PACK_ERROR,
    limit: float | None = MAX_ERROR,
    **setup: Any,
) -> tuple[Packed, PictureClocks]:
    """As :func:`soonest_packed`, of triangles as for :func:`picture_clocks`, which this sets up."""
    if clock.takes_vertices:
        triangles = ordered_for_vertices(triangles, formats)
    primitives = setup_triangles(triangles, formats, limit=limit, **setup)
    return soonest_packed(primitives, triangles, formats, clock, error)


def soonest_packed(
    primitives: Primitives, triangles: ScreenTriangles, formats: Formats, clock: BoardClock, error: float
) -> tuple[Packed, PictureClocks]:
    """
    Primitives packed so that a picture of them is complete as soon as it can be, and what it takes.

    Parameters
    ----------
    primitives : Primitives
    triangles : ScreenTriangles
      Those that they were set up from. They go as vertices where the board takes them, fields are not
      complete sooner, and the FIFO is never full: then the line would pause, which is not counted.
    formats : Formats
      Of the board.
    clock : BoardClock
    error : float
      Grey levels that packing may add.

    Returns
    -------
    Packed
    PictureClocks
    """
    state = triangles.shade
    if not clock.takes_vertices:
        packed = pack_primitives(primitives, formats, error, state)
        return packed, packed_clocks(packed, state, formats, clock)
    fields, vertices = pack_run(primitives, formats, error), None
    packed = pack_vertices(primitives, triangles, formats, error)
    if packed.sent_vertices:
        clocks = packed_clocks(packed, state, formats, clock)
        if clocks.waiting <= clock.fifo_words - LEAST_COUNTED // 2:
            vertices = packed, clocks
            # No picture is complete before the line has carried it, which is known at once.
            if clocks.whole <= clock.clocks_of_bytes(frames_bytes(len(fields.words))):
                return vertices
    clocks = packed_clocks(fields, state, formats, clock)
    return vertices if vertices is not None and vertices[1].whole <= clocks.whole else (fields, clocks)


def packed_clocks(
    packed: Packed,
    state: ShadeState | None,
    formats: Formats,
    clock: BoardClock,
    sizes: Sequence[int] | None = None,
) -> PictureClocks:
    """
    As :func:`picture_clocks`, of what is packed already.

    Parameters
    ----------
    packed : Packed
    state : ShadeState or None
    formats : Formats
    clock : BoardClock
    sizes : sequence of int, optional
      Bytes of each frame, for the exact clocks; by default the most that they can have, and that every pixel
      is kept, which is up to some clocks more.

    Returns
    -------
    PictureClocks
    """
    commands = commands_of(packed.words, state, formats)
    given = [frame_bytes(WORD_BYTES * count) for _, count in commands] if sizes is None else sizes
    last_byte = math.ceil(BITS_TO_SAMPLE * clock.clk_frequency_hz / clock.baud) + JUDGE_CLOCKS
    ends = [math.ceil(clock.clocks_of_bytes(total - 1)) + last_byte for total in np.cumsum(given).tolist()]
    table = np.array([(*command, end) for command, end in zip(commands, ends, strict=True)], np.int64)
    setup_words = pack(packed.primitives, formats)
    line = Line(
        table.reshape(-1, 3),
        *unpacking_of(packed.words, formats, packed.vertices),
        clock.width * clock.height + 1 + formats.with_depth,
        np.array([PICTURE_CLOCKS + DEPTH_CLOCKS * formats.with_depth])
        if sizes is None
        else _pixel_clocks(setup_words, formats, clock),
    )
    starts, _, _, scanlines, _ = decode_packets(setup_words, formats.core)
    beats = np.diff(starts) // formats.beat_words
    rows = (scanlines.first_rows, scanlines.pixels)
    whole, busy, waiting = count_board_clocks(beats, *rows, formats, line, clock.single_buffer)
    return PictureClocks(sum(given), math.ceil(clock.clocks_of_bytes(sum(given))), whole, busy, waiting)


SHORTER = (1 / 8, 1 / 2)
"""Grey levels that words may be packed to where a picture is late otherwise."""


def uncounted(identity: Mapping[str, int]) -> list[str]:
    """Why a picture may take longer than is counted here, by HELLO's fields; for who has a deadline."""
    words = identity["fifo_words"]
    if words >= LEAST_COUNTED:
        return []
    return [f"a picture may be late: a FIFO of {words} words makes the line pause, which is not counted"]


class Watch:
    """
    Whether a picture is in time.

    Parameters
    ----------
    session : Session
    clock : BoardClock
    has_time : bool
      The seconds of this machine count, too; for a simulated board they mean nothing.
    deadline : float or None
      Seconds; None: any time will do.

    Attributes
    ----------
    notices : list of str
      What was done for it.
    """

    def __init__(self, session: Session, clock: BoardClock, has_time: bool, deadline: float | None) -> None:
        self._session, self._clock, self._has_time, self._deadline = session, clock, has_time, deadline
        self.notices: list[str] = []
        self._tail = 0.0

    def packed(
        self, primitives: Primitives, triangles: ScreenTriangles, formats: Formats, error: float
    ) -> Packed:
        """
        Primitives packed so that a picture of them is complete in time, which runs from then on.

        Parameters
        ----------
        primitives : Primitives
        triangles : ScreenTriangles
          Those that they were set up from. They go as vertices, if the board takes them; with a deadline
          only where fields are not complete sooner.
        formats : Formats
        error : float
          Grey levels that packing may add; more where that is too slow.

        Returns
        -------
        Packed

        Raises
        ------
        QuadshadeError
          It would be late, however short its words are.
        """
        if self._deadline is None and self._clock.takes_vertices:
            return pack_vertices(primitives, triangles, formats, error)
        if self._deadline is None:
            return pack_primitives(primitives, formats, error, triangles.shade)
        least = math.inf
        for allowed in (error, *(one for one in SHORTER if one > error)):
            packed, clocks = soonest_packed(primitives, triangles, formats, self._clock, allowed)
            needed = clocks.whole / self._clock.clk_frequency_hz
            least = min(least, needed)
            if needed <= self._deadline:
                if allowed != error:
                    self.notices.append(f"words packed to {allowed:g} grey levels, to be in time")
                # The clear went before, and the board draws on when the line has carried everything.
                clear = self._clock.clocks_of_bytes(frame_bytes(WORD_BYTES))
                self._tail = (clocks.whole - clocks.line + clear) / self._clock.clk_frequency_hz
                self._start, self._before = time.monotonic(), self._line()
                return packed
        raise QuadshadeError(
            f"the picture cannot be drawn in {1000 * self._deadline:g} ms, at {self._clock.baud} baud",
            f"it takes {math.ceil(1e5 * least) / 100:g} ms: give more, or draw less",
        )

    def _line(self) -> float:
        """Seconds of all bytes sent so far, again or not, and of answers that were waited for in vain."""
        statistics = self._session.statistics
        sent = self._clock.clocks_of_bytes(statistics["bytes_sent"]) / self._clock.clk_frequency_hz
        return sent + statistics["timeouts"] * self._session.answer_seconds

    def is_late(self) -> bool:
        """Whether the picture has taken more than its time, once everything is accepted."""
        if self._deadline is None:
            return False
        spent = self._line() - self._before
        if self._has_time:
            spent = max(spent, time.monotonic() - self._start)
        return spent + self._tail > self._deadline
