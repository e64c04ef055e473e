# SPDX-License-Identifier: Apache-2.0
"""
Clock prediction: the control registers of the RTL, cycle by cycle, without the data.

Stream always valid, sink ready but for one clock in ``stall_period``. Every name is that of
the RTL signal it stands for.
"""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from quadshade.contract.arrays import Ints
from quadshade.contract.formats import Formats
from quadshade.golden.line_clocks import PLACE, BoardPlace, Line, board_clock, is_done, no_line, pause
from quadshade.golden.unpacker_clocks import begin

WALK_STAGES = 7
"""Generic ``walk_stages`` of ``rtl/core/edge_walker.vhd``."""

COUNTED_STAGE = 3
"""The stage of ``rtl/core/edge_walker.vhd`` that knows how many pixels a span has."""

EMPTY = -1
"""A stage that holds nothing."""


class _Pipeline(NamedTuple):
    """
    What a drawing's clocks depend on beside the packets; see :func:`count_clocks`.

    From beat ``words_beat`` on a packet writes differences. With ``single_buffer`` a packet waits until none
    is walked.
    """

    words_beat: int
    span_depth: int
    stall_period: int
    stages_behind: int
    single_buffer: int


@numba.njit(cache=True)
def _walks(stages: Ints, head: int) -> bool:
    """Whether the edge walker is busy; a span without pixels is not kept beyond ``COUNTED_STAGE``."""
    for place in range(WALK_STAGES):
        if stages[place] >= 0:
            stage = (place - head) % WALK_STAGES
            if stage > 0 and (stages[place] > 0 or stage <= COUNTED_STAGE):
                return True
    return False


@numba.njit(cache=True)
def _count_clocks(
    beats: Ints, first_rows: Ints, row_pixels: Ints, pipeline: _Pipeline, line: Line, board: BoardPlace
) -> int:
    """
    Cycles from the first beat accepted to the last pixel out, both included; 0 where none comes out.

    Behind a line from its first byte on until everything is done, also where no pixel comes out.
    """
    words_beat, span_depth, stall_period, stages_behind, single_buffer = pipeline
    has_line = len(line.commands) > 0
    packets = len(beats)
    remaining_pixels = row_pixels.sum()
    if remaining_pixels == 0 and not has_line:
        return 0
    # setup_loader
    packet = 0
    beat = 0
    full = False
    # edge_walker
    valid_0 = False
    first_0 = False
    first_1 = False
    row = 0
    end_row = 0
    taken = 0
    # A ring of stages 1 .. WALK_STAGES - 1; an entry is the span's pixels, EMPTY where there is none.
    stages = np.full(WALK_STAGES, EMPTY, np.int64)
    head = 0
    held = np.full(span_depth, EMPTY, np.int64)
    in_chain = 0
    left = 0  # pixels of the span in the span walker, the one shown included
    clamped = False
    # skid_buffer
    front = False
    spare = False
    # shade: a ring of stages, and its skid_buffer, with which all of them move
    behind = np.zeros(max(stages_behind, 1), np.bool_)
    oldest = 0
    shown = False
    shown_spare = False
    cycle = 0
    while True:
        cycle += 1
        # What the sink sees in this cycle.
        sink_ready = board.closed == 0 and (stall_period == 0 or cycle % stall_period != 0)
        pixel_out = (shown if stages_behind else front) and sink_ready
        if pixel_out:
            remaining_pixels -= 1
            if remaining_pixels == 0 and not has_line:
                return cycle
        pixel_ready = not shown_spare if stages_behind else sink_ready
        # Combinational.
        wanted = left <= 1
        advance = not spare
        chain_moves = wanted and advance
        span_taken = chain_moves and held[span_depth - 1] != EMPTY
        chain_ready = chain_moves or in_chain < span_depth
        last_stage = stages[(head + WALK_STAGES - 1) % WALK_STAGES]
        walk = chain_ready or last_stage <= 0
        last_0 = valid_0 and row == end_row - 1
        take = walk and full and (not valid_0 or last_0) and not first_0 and not first_1
        ready = packet < packets and not full and not (beat >= words_beat and first_0)
        if single_buffer and ready:
            ready = not valid_0 and not _walks(stages, head)
        if has_line:
            moves = full or valid_0 or in_chain > 0 or left > 0 or clamped or front or spare or shown
            moves = moves or shown_spare or (stages_behind > 0 and bool(behind.any())) or _walks(stages, head)
            busy = moves or beat > 0
            if is_done(line, board, busy):
                return cycle
            if not moves:
                cycle += pause(line, board, cycle, busy)
                if not (board.full or first_0 or first_1):
                    # The core stands still; the unpacker may not.
                    board_clock(line, board, cycle, False, False, busy)
                    continue
            offered_beat = board.full == 1
            board_clock(line, board, cycle, ready, pixel_out, busy)
            ready = ready and offered_beat

        # Clock edge, downstream first.
        if stages_behind:
            offered = behind[oldest]
            if not shown_spare:
                behind[oldest] = front
                oldest = (oldest + 1) % stages_behind
            if not shown or sink_ready:
                shown = offered or shown_spare
                shown_spare = False
            elif offered:
                shown_spare = True
        if not front or pixel_ready:
            front = clamped or spare
            spare = False
        elif clamped:
            spare = True
        if advance:
            clamped = left > 0
            if span_taken:
                left = held[span_depth - 1]
                held[span_depth - 1] = EMPTY
                in_chain -= 1
            elif left > 0:
                left -= 1
        moves = chain_moves
        for index in range(span_depth - 1, -1, -1):
            moves = moves or held[index] == EMPTY
            if moves and index > 0:
                held[index] = held[index - 1]
                held[index - 1] = EMPTY
        if walk:
            if last_stage > 0:
                held[0] = last_stage
                in_chain += 1
            # The ring turns: the last stage's place becomes stage 0's, stage 0 moves to 1 with its span.
            head = (head + WALK_STAGES - 1) % WALK_STAGES
            stages[(head + 1) % WALK_STAGES] = row_pixels[row] if valid_0 else EMPTY
            stages[head] = EMPTY
            first_1 = first_0
            first_0 = take
            if take:
                valid_0 = True
                row = first_rows[taken]
                end_row = first_rows[taken + 1]
                taken += 1
                full = False
            elif last_0:
                valid_0 = False
            elif valid_0:
                row += 1
        if ready:
            beat += 1
            if beat == beats[packet]:
                beat = 0
                packet += 1
                full = True


def count_clocks(
    beats: np.ndarray,
    first_rows: np.ndarray,
    row_pixels: np.ndarray,
    formats: Formats,
    stall_period: int = 0,
    stages_behind: int = 0,
    single_buffer: bool = False,
) -> int:
    """
    Clocks that the core takes: first set-up word accepted to last pixel out, both included.

    Parameters
    ----------
    beats : (n,) int64
      Beats of each packet.
    first_rows : (n + 1,) int64
      Index of each packet's first scanline in ``row_pixels``; the last entry is their number.
    row_pixels : (r,) int64
      Pixels of every scanline, empty ones included.
    formats : Formats
    stall_period : int
      The sink is not ready in every n-th clock, counted from the first beat; 0: always ready.
    stages_behind : int
      Stages of the shade unit behind the core; 0: there is none.
    single_buffer : bool
      Generic of ``raster_core``.

    Returns
    -------
    int
      0 where no pixel comes out.
    """
    words_beat = formats.section_beats("edge") - 1
    pipeline = _Pipeline(words_beat, formats.span_depth, stall_period, stages_behind, int(single_buffer))
    line, board = no_line()
    return int(_count_clocks(beats, first_rows, row_pixels, pipeline, line, board[0]))


def count_board_clocks(
    beats: np.ndarray,
    first_rows: np.ndarray,
    row_pixels: np.ndarray,
    formats: Formats,
    line: Line,
    single_buffer: bool = False,
) -> tuple[int, int, int]:
    """
    Clocks that a board takes, which does nothing at first: from a picture's first bit until all is drawn.

    Parameters
    ----------
    beats, first_rows, row_pixels, formats
      As for :func:`count_clocks`, with the shade unit where the formats have one.
    line : Line
    single_buffer : bool
      Generic of ``board``.

    Returns
    -------
    clocks, clocks_busy, most_waiting : int
      The second as STATUS counts them; words in the FIFO at most.
    """
    words_beat = formats.core.section_beats("edge") - 1
    pipeline = _Pipeline(words_beat, formats.span_depth, 0, formats.shade_stages, int(single_buffer))
    board = np.zeros(1, PLACE)
    board["idle"] = 1
    begin(line.steps, line.events, board[0])
    clocks = _count_clocks(beats, first_rows, row_pixels, pipeline, line, board[0])
    # The register says a clock later that the board is idle.
    busy = int(board["clocks_busy"][0] + 1 - board["idle"][0])
    return int(clocks), busy, int(board["most_waiting"][0])
