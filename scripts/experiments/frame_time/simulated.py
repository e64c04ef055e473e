# SPDX-License-Identifier: Apache-2.0
"""
Pictures through the board's VHDL, UART pins included, at times that only the board's own clock tells.

Zeros between frames are nothing to a board, so they fill the line up to a picture's deadline; the STATUS
whose last bit is the deadline then says what was drawn until then. No clock of this machine has a part in it.
"""

from __future__ import annotations

import select
from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np

from quadshade.board import BoardSettings
from quadshade.board.engines import start_engine
from quadshade.board.frame_time import commands_of
from quadshade.contract.formats import Formats
from quadshade.contract.protocol import (
    MAX_PAYLOAD,
    SEQUENCES,
    WORD_BYTES,
    Opcode,
    pack_payload,
    unpack_payload,
)
from quadshade.contract.shade_state import ShadeState, colour_state
from quadshade.link.frames import Frame, FrameParser
from quadshade.packing.frame_file import state_runs
from quadshade.packing.pack import packed_writes

QUIET_BYTES = 128
"""Behind a deadline: STATUS's answer is out before the next picture begins."""

SILENT_SECONDS = 600.0


def picture_frames(
    words: np.ndarray, state: ShadeState | None, formats: Formats, first: int = 0
) -> list[bytes]:
    """Frames of a picture as a board's session sends them, from the number ``first`` on."""
    payloads = [pack_payload(Opcode.CLEAR, {"colour": 0})]
    if formats.with_shade:
        most = MAX_PAYLOAD - WORD_BYTES
        for address, run in state_runs(
            packed_writes(words, colour_state(formats) if state is None else state, formats)
        ):
            data = np.asarray(run, "<u4").tobytes()
            payloads += [
                pack_payload(Opcode.STATE, {"address": address + at // WORD_BYTES}, data[at : at + most])
                for at in range(0, len(data), most)
            ]
    data = words.astype("<u4").tobytes()
    payloads += [data[at : at + MAX_PAYLOAD] for at in range(0, len(data), MAX_PAYLOAD)]
    opcodes = [opcode for opcode, _ in commands_of(words, state, formats)]
    return [
        Frame(opcode, (first + number) % SEQUENCES, payload).encode()
        for number, (opcode, payload) in enumerate(zip(opcodes, payloads, strict=True))
    ]


def counted(
    settings: BoardSettings,
    pictures: Sequence[Callable[[int], list[bytes]]],
    period: int,
    engine: str = "verilator",
) -> list[dict[str, int]]:
    """
    What the board has counted at each picture's deadline, since the one before.

    Parameters
    ----------
    settings : BoardSettings
    pictures : sequence of callable
      The frames of a picture, from a number on.
    period : int
      Bytes from a picture's first bit to its deadline.
    engine : str

    Returns
    -------
    list of dict of str to int
      Fields of STATUS, of counters how much they grew.
    """
    answers: list[dict[str, int]] = []
    status = Frame(Opcode.STATUS, 0).encode()
    quiet = bytes(QUIET_BYTES)
    # After power-up the screen is cleared first, of which a picture is no part.
    clearing = settings.screen_width * settings.screen_height * settings.baud // settings.clk_frequency_hz
    reset = Frame(Opcode.RESET, 0, pack_payload(Opcode.RESET, {"session": 1})).encode()
    stream = bytes(clearing // 8) + reset + quiet + status + quiet
    number = 0
    for picture in pictures:
        frames = picture(number)
        number += len(frames)
        data = b"".join(frames)
        if len(data) + len(status) > period:
            raise AssertionError(f"a picture of {len(data)} bytes in {period}")
        stream += data + bytes(period - len(data) - len(status)) + status + quiet
    parser = FrameParser()
    board = start_engine(engine, settings)
    try:
        board.feed(stream)
        while len(answers) <= len(pictures):
            writers = [] if board.writer() is None else [board.writer()]
            ready, writable, _ = select.select([board.reader()], writers, [], SILENT_SECONDS)
            if not ready and not writable:
                raise AssertionError("the simulated board says nothing")
            board.push()
            if ready:
                heard = parser.feed(board.take())
                answers += [
                    unpack_payload(frame.opcode, frame.payload)[0]
                    for frame in heard
                    if frame.opcode is Opcode.STATUS_ANSWER
                ]
    finally:
        board.close()
    state = ("expected", "reason", "free")
    return [
        {name: after[name] - (0 if name in state else before[name]) for name in after}
        for before, after in pairwise(answers)
    ]
