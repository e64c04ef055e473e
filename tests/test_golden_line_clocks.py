# SPDX-License-Identifier: Apache-2.0
"""The clocks of a board's line and screen: those that the VHDL was seen to take, and sums known before."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from quadshade.board import BoardSettings
from quadshade.board.frame_time import BoardClock, packed_clocks
from quadshade.contract.formats import DIFFERENCES_OF_ORDER, SETUP_WORD_BITS, Formats
from quadshade.contract.packed_format import KIND_WIDTHS
from quadshade.contract.protocol import Opcode
from quadshade.golden.clocks import count_board_clocks
from quadshade.golden.line_clocks import FIFO_CLOCKS, PLACE, Line, is_done, pause
from quadshade.golden.link.word_unpacker import GIVES, NUM_RAW, RESTS, TAKES, WordUnpacker
from quadshade.golden.unpacker_clocks import BITS, START, begin
from quadshade.packing import pack_primitives
from quadshade.packing.pack import Packed
from quadshade.packing.pack_vertices import pack_vertices
from quadshade.setup import setup_triangles
from tests.support.golden_stimuli import triangles_of

SIZE = (24, 20)
SHADE = Formats(with_shade=1, num_channels=2, num_specular=1)
BOARDS = {
    "default": BoardSettings(Formats(), *SIZE),
    "slow_line": BoardSettings(Formats(), *SIZE, clk_frequency_hz=40_000_000),
    "no_depth": BoardSettings(Formats(with_depth=0), *SIZE),
    "shaded": BoardSettings(SHADE, *SIZE, clk_frequency_hz=8_000_000),
    "vertices": BoardSettings(Formats(), *SIZE, with_vertices=1),
    "vertices_slow_line": BoardSettings(Formats(), *SIZE, with_vertices=1, clk_frequency_hz=40_000_000),
}
RECORDED = {
    ("default", 1): ((15, 59), 4919, 1683),
    ("default", 7): ((15, 287), 21597, 6961),
    ("slow_line", 7): ((15, 287), 127283, 6961),
    ("no_depth", 7): ((15, 219), 17187, 5949),
    ("shaded", 1): ((15, 27, 27, 31, 59), 13735, 1481),
    ("shaded", 7): ((15, 27, 27, 31, 275), 35948, 6414),
    ("vertices", 1): ((15, 63), 9782, 6346),
    ("vertices", 7): ((15, 307), 34638, 19001),
    ("vertices", 14): ((15, 487), 55915, 31279),
    ("vertices_slow_line", 7): ((15, 307), 147324, 19001),
}
"""Board and triangles: bytes of each frame, clocks, and those in which the VHDL, in Verilator, is busy."""


@cache
def packed(name: str, count: int) -> Packed:
    """Triangles of every awkward kind, for a board."""
    formats = BOARDS[name].formats
    triangles = triangles_of(formats, np.random.default_rng(1), count, SIZE[1])
    if BOARDS[name].with_vertices:
        chosen = pack_vertices(setup_triangles(triangles, formats), triangles, formats, 0.25)
        # Runs of packed words are between.
        assert chosen.sent_vertices == {1: 1, 7: 4, 14: 7}[count]
        return chosen
    return pack_primitives(setup_triangles(triangles, formats), formats)


@pytest.mark.parametrize(("name", "count"), RECORDED)
def test_clocks_are_those_recorded(name: str, count: int) -> None:
    settings, (sizes, whole, busy) = BOARDS[name], RECORDED[name, count]
    clock = BoardClock(settings.clk_frequency_hz, settings.baud, *SIZE)
    times = packed_clocks(packed(name, count), None, settings.formats, clock, sizes)
    assert (times.line_bytes, times.whole, times.busy) == (sum(sizes), whole, busy)


UNPACKED = {
    "default": Formats(),
    "linear": Formats(max_order=1, num_channels=2, with_depth=0, word_width=20, frac_bits=10),
    "wide": Formats(num_channels=8, word_width=40, frac_bits=24, coord_bits=13),
}


def stops(flags: int, orders: int, formats: Formats, unpacker: WordUnpacker) -> int:
    """Clocks of a packet in which no bit moves, but for widths that are stored: by its flags and orders."""
    layout = unpacker._layout
    fields = len(layout.fields) + 1 if flags & 1 else layout.second_at
    built = [min(orders >> 2 * index & 3, 2, most) for index, most in enumerate(formats.channel_max_order)]
    return fields + 1 + 3 * sum(DIFFERENCES_OF_ORDER[order] for order in built)


@pytest.mark.parametrize("name", UNPACKED)
def test_each_bit_is_taken_and_given_once(name: str) -> None:
    """Packet by packet, against the packets themselves; a stop for every field, three for a difference."""
    formats = UNPACKED[name]
    triangles = triangles_of(formats, np.random.default_rng(2), 14, 30)
    words = pack_primitives(setup_triangles(triangles, formats), formats).words
    unpacker = WordUnpacker(formats)
    steps = unpacker.clocks(words)
    assert set(steps.tolist()) <= {0, TAKES, GIVES, TAKES | GIVES, TAKES | RESTS}
    taken = np.cumsum(steps & TAKES != 0)
    assert taken[-1] == SETUP_WORD_BITS * len(words)
    at, lone, change = 0, 0, 1 + unpacker._layout.address_bits + unpacker._layout.width_bits
    for start, end, setup_words in unpacker.packets(words):
        until = int(np.searchsorted(taken, end)) + 1
        # What moves no bit behind the packet's last one belongs to it: its end, and zeros that fill a word.
        while until < len(steps) and not steps[until] & TAKES:
            until += 1
        piece = steps[at:until]
        # Zeros, then the start bit, for which it rests; nowhere else.
        resting = np.flatnonzero(piece & RESTS)
        assert resting.tolist() == list(range(len(resting))) and len(resting) >= 1
        assert taken[at] == start + 1 and taken[until - 1] == end
        assert np.count_nonzero(piece & GIVES) == SETUP_WORD_BITS * len(setup_words)
        flags = int(setup_words[0])
        orders = flags >> NUM_RAW
        idle = np.count_nonzero(piece == 0)
        changes = idle - stops(flags, orders, formats, unpacker)
        own = end - start - len(resting) - np.count_nonzero(piece == (TAKES | GIVES))
        # What is taken and not given: each change, the bit that ends them, that of the same orders.
        assert own == change * changes + (changes < len(unpacker.widths)) + 1
        at, lone = until, lone + changes
    assert set(steps[at:].tolist()) <= {TAKES | RESTS} and lone > KIND_WIDTHS


NONE, NO_EVENTS = np.zeros(0, np.int64), np.zeros((0, 3), np.int64)


def line_of(*commands: tuple[Opcode, int, int], clear_clocks: int = 40) -> Line:
    """A line that carries no triangles."""
    table = np.array(commands, np.int64).reshape(-1, 3)
    return Line(table, NONE, NO_EVENTS, clear_clocks, np.zeros(1, np.int64))


def without_core(line: Line) -> tuple[int, int]:
    """Clocks in all and busy ones, where nothing is drawn."""
    return count_board_clocks(NONE, np.zeros(1, np.int64), NONE, Formats(), line)[:2]


@pytest.mark.parametrize("clear_clocks", [1, 40, 700])
@pytest.mark.parametrize("judged", [1, 90, 10**12])
def test_a_clear_takes_its_words_and_its_pixels(judged: int, clear_clocks: int) -> None:
    """Header and colour, a FIFO's latency apart, two clocks to settle; as many for a pause of any length."""
    whole, busy = without_core(line_of((Opcode.CLEAR, 1, judged), clear_clocks=clear_clocks))
    assert whole == judged + FIFO_CLOCKS + 5 + clear_clocks
    assert busy == clear_clocks


@pytest.mark.parametrize("words", [2, 3, 30])
@pytest.mark.parametrize("before", [False, True])
def test_state_waits_for_a_clear_and_takes_its_words(words: int, before: bool) -> None:
    commands = [(Opcode.CLEAR, 1, 5)] * before + [(Opcode.STATE, words, 6)]
    whole, busy = without_core(line_of(*commands))
    if before:
        # Its header and first word are taken while the screen is cleared.
        assert whole == without_core(line_of(commands[0]))[0] + (FIFO_CLOCKS + 1) * (words - 1) - 2
    else:
        assert whole == 6 + 2 + (FIFO_CLOCKS + 1) * words
    assert busy == 40 * before


def place_of(steps: tuple[int, ...] = (), events: tuple[tuple[int, ...], ...] = (), **fields: int) -> np.void:
    """Where a board is, for the compiled loops; what is not given is 0."""
    place = np.zeros(1, PLACE)[0]
    begin(np.array(steps, np.int64), np.array(events, np.int64).reshape(-1, 3), place)
    for name, value in fields.items():
        place[name] = value
    return place


def test_a_pause_ends_with_the_next_frame_and_counts_what_is_busy() -> None:
    """Nowhere else are clocks left out: not while a word waits, or anything is on its way."""
    line = line_of((Opcode.STATE, 2, 100))
    for idle, busy in ((1, False), (0, True)):
        place = place_of(idle=idle, clocks_busy=7)
        assert pause(line, place, 60, busy) == 39
        assert place["clocks_busy"] == (7 if idle else 46)
        assert pause(line, place, 100, busy) == pause(line, place, 99, busy) == 0
        assert pause(line, place, 60, not busy) == 0
    for name, value in [
        ("arrived", 1),
        ("waiting", 1),
        ("full", 1),
        ("closed", 1),
        ("flying", 1),
        ("place", 2),
    ]:
        assert pause(line, place_of(**{"idle": 1, name: value}), 60, False) == 0, name
    for step, clocks in ((GIVES, 0), (0, 0), (TAKES | RESTS, 39), (TAKES, 0)):
        assert pause(line, place_of((step,), idle=1), 60, False) == clocks, step
    assert pause(line, place_of((TAKES,)), 60, False) == 39


def test_clocks_are_left_out_while_vertices_are_computed() -> None:
    """As many as the program takes for itself, up to the next frame's end; none before a word is there."""
    line = line_of((Opcode.STATE, 2, 100))
    for wait, waited, cycle, clocks in ((30, 0, 60, 30), (30, 8, 60, 22), (30, 30, 60, 0), (90, 0, 60, 39)):
        place = place_of(events=((BITS, 1, wait),), held=1, waited=waited)
        assert pause(line, place, cycle, False) == clocks
        assert place["waited"] == waited + clocks and place["clocks_busy"] == clocks
    assert pause(line, place_of(events=((BITS, 1, 30),)), 60, False) == 0
    assert pause(line, place_of(events=((BITS, 1, 0),)), 60, False) == 39
    # Before a packet's start it is idle.
    assert pause(line, place_of(events=((START, 1, 0),), idle=1), 60, False) == 39
    for name in ("leaving", "pads", "full", "closed", "flying"):
        assert pause(line, place_of(events=((BITS, 1, 30),), held=1, **{name: 1}), 60, False) == 0, name
    for place, fetching, clocks in ((5, 0, 30), (5, 2, 0), (0, 0, 0)):
        waiting = {"waiting": 2, "place": place, "fetching": fetching}
        assert pause(line, place_of(events=((BITS, 1, 30),), held=1, **waiting), 60, False) == clocks


def test_a_board_is_done_when_nothing_is_left() -> None:
    line = line_of((Opcode.CLEAR, 1, 3))
    done = {"command": 1}
    assert is_done(line, place_of(**done), False)
    assert not is_done(line, place_of(**done), True)
    for name, value in (("command", 0), ("full", 1), ("closed", 1), ("flying", 1)):
        assert not is_done(line, place_of(**done | {name: value}), False), name
    assert not is_done(line, place_of((TAKES,), **done), False)
    assert not is_done(line, place_of(events=((START, 1, 0),), **done), False)
