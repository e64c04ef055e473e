# SPDX-License-Identifier: Apache-2.0
"""
What stands between a board's line and its core, clock by clock: command FIFO, executor, unpackers, clear.

A frame counts from the clock in which its end is judged; its words then leave the FIFO one after the other
(``rtl/link``), and those of TRIANGLES are unpacked bit by bit. Every name is that of what it stands for.
"""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from quadshade.contract.arrays import Ints, record_dtype
from quadshade.contract.protocol import Opcode
from quadshade.golden.unpacker_clocks import (
    OVER,
    UnpackerPlace,
    has_unpacked,
    is_busy,
    still_clocks,
    vertex_clock,
    word_clock,
)

FIFO_CLOCKS = 4
"""From a word's taking to the next one's showing (``frame_fifo.vhd``)."""

_HEADER, _GATHER, _SETTLE, _CLEAR, _STATE, _TRIANGLES = range(6)
"""What ``command_executor.vhd`` waits for."""

CLEAR, STATE, TRIANGLES = int(Opcode.CLEAR), int(Opcode.STATE), int(Opcode.TRIANGLES)


class Line(NamedTuple):
    """
    What comes over the line.

    ``commands`` (k, 3) are opcode, words of payload and the clock in which a frame is judged; ``steps`` and
    ``events`` what becomes of the words of TRIANGLES (:class:`Unpacking`). A clear closes the screen for
    ``clear_clocks``; ``pixel_clocks`` has for every pixel how long it is on its way to the picture, or one
    entry for all.
    """

    commands: Ints
    steps: Ints
    events: Ints
    clear_clocks: int
    pixel_clocks: Ints


class BoardPlace(UnpackerPlace):
    """
    Columns of where a board is.

    ``arrived`` frames are judged, ``waiting`` of their words in the FIFO, ``most_waiting`` at most, whose
    word is shown when ``fetching`` is 0; ``command`` is executed, at ``place``, with ``words_left``;
    ``closed`` and ``flying`` are clocks until the screen is clear and the last of so many ``pixels``
    written; ``idle`` is a register; ``clocks_busy`` counts its zeros.
    """

    arrived: int
    waiting: int
    most_waiting: int
    fetching: int
    command: int
    place: int
    words_left: int
    closed: int
    flying: int
    pixels: int
    idle: int
    clocks_busy: int


PLACE = record_dtype(BoardPlace)


def no_line() -> tuple[Line, np.ndarray]:
    """What a core has whose set-up words are always there."""
    none = np.zeros((0, 3), np.int64)
    return Line(none, np.zeros(0, np.int64), none, 0, np.zeros(1, np.int64)), np.zeros(1, PLACE)


@numba.njit(cache=True, inline="always")
def is_done(line: Line, board: BoardPlace, core_busy: bool) -> bool:
    """Whether every command is executed and everything drawn."""
    executed = board.command == len(line.commands) and has_unpacked(board)
    return executed and not core_busy and board.closed == 0 and board.flying == 0


@numba.njit(cache=True, inline="always")
def pause(line: Line, board: BoardPlace, cycle: int, core_busy: bool) -> int:
    """Clocks to leave out: all wait for the next frame's end, or for the unpacker of vertices to compute."""
    computing = still_clocks(board)
    if computing == 0 or board.place in (_SETTLE, _CLEAR) or board.closed or board.flying:
        return 0
    if board.waiting and (computing < 0 or board.fetching or board.place != _TRIANGLES):
        return 0
    if board.idle != int(not core_busy and not is_busy(board)):
        return 0
    clocks = computing
    if board.arrived < len(line.commands):
        ahead = max(line.commands[board.arrived, 2] - cycle - 1, 0)
        clocks = ahead if computing < 0 else min(computing, ahead)
    clocks = max(clocks, 0)
    if computing > 0:
        board.waited += clocks
    if not board.idle:
        board.clocks_busy += clocks
    return int(clocks)


@numba.njit(cache=True, inline="always")
def board_clock(
    line: Line, board: BoardPlace, cycle: int, setup_ready: bool, pixel_out: bool, core_busy: bool
) -> None:
    """One clock edge of what stands before the core, and of the screen behind it."""
    commands = line.commands
    quiet = board.closed == 0 and board.flying == 0
    unpacking = is_busy(board)
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
    # word_unpacker, vertex_unpacker
    has_word = shown and place == _TRIANGLES
    if board.kind == OVER:
        unpacked = word_clock(line.steps, board, has_word, setup_ready)
    else:
        unpacked = vertex_clock(line.steps, line.events, board, has_word, setup_ready)
    taken = taken or unpacked
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
        board.most_waiting = max(board.most_waiting, board.waiting)
    # screen
    if board.closed > 0:
        board.closed -= 1
    if board.flying > 0:
        board.flying -= 1
    if pixel_out:
        index = min(board.pixels, len(line.pixel_clocks) - 1)
        board.flying = max(board.flying, line.pixel_clocks[index])
        board.pixels += 1
