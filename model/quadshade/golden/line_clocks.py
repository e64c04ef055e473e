# SPDX-License-Identifier: Apache-2.0
"""
What stands between a board's line and its core, clock by clock: command FIFO, executor, unpacker, clear.

A frame counts from the clock in which its end is judged; its words then leave the FIFO one after the other
(``rtl/link``), and those of TRIANGLES are unpacked bit by bit. Every name is that of what it stands for.
"""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from quadshade.contract.arrays import Ints, record_dtype
from quadshade.contract.formats import SETUP_WORD_BITS
from quadshade.contract.protocol import Opcode
from quadshade.golden.link.word_unpacker import GIVES, RESTS, TAKES

FIFO_CLOCKS = 4
"""From a word's taking to the next one's showing (``frame_fifo.vhd``)."""

_HEADER, _GATHER, _SETTLE, _CLEAR, _STATE, _TRIANGLES = range(6)
"""What ``command_executor.vhd`` waits for."""

CLEAR, STATE, TRIANGLES = int(Opcode.CLEAR), int(Opcode.STATE), int(Opcode.TRIANGLES)


class Line(NamedTuple):
    """
    What comes over the line.

    ``commands`` (k, 3) are opcode, words of payload and the clock in which a frame is judged; ``steps`` what
    the unpacker does with the words of TRIANGLES (:meth:`WordUnpacker.clocks`). A clear closes the screen for
    ``clear_clocks``; ``pixel_clocks`` has for every pixel how long it is on its way to the picture, or one
    entry for all.
    """

    commands: Ints
    steps: Ints
    clear_clocks: int
    pixel_clocks: Ints


class BoardPlace:
    """
    Columns of where a board is.

    ``arrived`` frames are judged, ``waiting`` of their words in the FIFO, whose word is shown when
    ``fetching`` is 0; ``command`` is executed, at ``place``, with ``words_left``; of ``steps`` ``step`` is
    next, ``bit`` the bit of the packed word, ``given`` those of the set-up word, which is ``full``;
    ``closed`` and ``flying`` are clocks until the screen is clear and the last of so many ``pixels``
    written; ``idle`` is a register; ``clocks_busy`` counts its zeros.
    """

    arrived: int
    waiting: int
    fetching: int
    command: int
    place: int
    words_left: int
    step: int
    bit: int
    given: int
    full: int
    closed: int
    flying: int
    pixels: int
    idle: int
    clocks_busy: int


PLACE = record_dtype(BoardPlace)


def no_line() -> tuple[Line, np.ndarray]:
    """What a core has whose set-up words are always there."""
    return Line(np.zeros((0, 3), np.int64), np.zeros(0, np.int64), 0, np.zeros(1, np.int64)), np.zeros(
        1, PLACE
    )


@numba.njit(cache=True)
def is_done(line: Line, board: BoardPlace, core_busy: bool) -> bool:
    """Whether every command is executed and everything drawn."""
    executed = board.command == len(line.commands) and board.step == len(line.steps)
    return executed and not core_busy and not board.full and board.closed == 0 and board.flying == 0


@numba.njit(cache=True)
def pause(line: Line, board: BoardPlace, cycle: int, core_busy: bool) -> int:
    """Clocks in which nothing changes, as everything waits for the next frame's end; they are counted."""
    starved = board.step == len(line.steps) or (line.steps[board.step] & TAKES) != 0
    still = starved and board.waiting == 0 and not board.full and board.closed == 0 and board.flying == 0
    resting = board.step == len(line.steps) or (line.steps[board.step] & RESTS) != 0
    settled = board.idle == int(not core_busy and resting)
    if not (still and settled) or board.place in (_SETTLE, _CLEAR) or board.arrived == len(line.commands):
        return 0
    clocks = max(line.commands[board.arrived, 2] - cycle - 1, 0)
    if not board.idle:
        board.clocks_busy += clocks
    return int(clocks)


@numba.njit(cache=True)
def board_clock(
    line: Line, board: BoardPlace, cycle: int, setup_ready: bool, pixel_out: bool, core_busy: bool
) -> None:
    """One clock edge of what stands before the core, and of the screen behind it."""
    commands, steps = line.commands, line.steps
    quiet = board.closed == 0 and board.flying == 0
    resting = board.step == len(steps) or (steps[board.step] & RESTS) != 0
    unpacking = board.full or not resting
    was_idle = board.idle
    if not was_idle:
        board.clocks_busy += 1
    board.idle = int(quiet and not core_busy and not unpacking)

    shown = board.waiting > 0 and board.fetching == 0
    taken = False
    # command_executor
    place = board.place
    if place == _HEADER and shown:
        taken = True
        opcode = commands[board.command, 0]
        board.words_left = commands[board.command, 1]
        board.place = _TRIANGLES if opcode == TRIANGLES else _GATHER
    elif place == _GATHER and shown:
        taken = True
        board.words_left -= 1
        if commands[board.command, 0] == STATE or board.words_left == 0:
            board.place = _SETTLE
    elif place == _SETTLE and was_idle:
        board.place = _STATE if commands[board.command, 0] == STATE else _CLEAR
    elif place == _CLEAR and quiet:
        board.closed = line.clear_clocks + 1
        board.place = _HEADER
        board.command += 1
    elif place == _STATE and shown and not core_busy:
        taken = True
    # word_unpacker
    gives = False
    if board.step < len(steps):
        what = steps[board.step]
        has_bit = shown and place == _TRIANGLES
        if not (what & GIVES and board.full) and not (what & TAKES and not has_bit):
            board.step += 1
            gives = what & GIVES != 0
            if what & TAKES:
                board.bit += 1
                if board.bit == SETUP_WORD_BITS:
                    board.bit = 0
                    taken = True
    if board.full and setup_ready:
        board.full = 0
    if gives:
        board.given += 1
        if board.given == SETUP_WORD_BITS:
            board.given = 0
            board.full = 1
    if taken and place in (_STATE, _TRIANGLES):
        board.words_left -= 1
        if board.words_left == 0:
            board.place = _HEADER
            board.command += 1
    # frame_fifo
    if taken:
        board.waiting -= 1
        board.fetching = FIFO_CLOCKS
    elif board.waiting > 0 and board.fetching > 0:
        board.fetching -= 1
    while board.arrived < len(commands) and commands[board.arrived, 2] <= cycle:
        board.waiting += commands[board.arrived, 1] + 1
        board.arrived += 1
    # screen
    if board.closed > 0:
        board.closed -= 1
    if board.flying > 0:
        board.flying -= 1
    if pixel_out:
        index = min(board.pixels, len(line.pixel_clocks) - 1)
        board.flying = max(board.flying, line.pixel_clocks[index])
        board.pixels += 1
