# SPDX-License-Identifier: Apache-2.0
"""
What a board's unpackers do, clock by clock: ``word_unpacker``, and ``vertex_unpacker`` before it.

Both share the set-up word that is put together and waits for the core: never do both have one.
Every name is that of what it stands for. The loops are inlined: a call a clock takes longer than they do.
"""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from quadshade.contract.arrays import Ints, record_dtype
from quadshade.contract.formats import SETUP_WORD_BITS, Formats
from quadshade.golden.link.vertex_machine import ALIGN, BITS, PUT, RUN, START, WORD
from quadshade.golden.link.vertex_unpacker import VertexUnpacker
from quadshade.golden.link.word_unpacker import GIVES, RESTS, TAKES, WordUnpacker


class Unpacking(NamedTuple):
    """
    What unpackers do with the words of TRIANGLES.

    ``steps`` are those of packed words (:meth:`WordUnpacker.clocks`), ``events`` (k, 3) what vertices need
    of line and core (:meth:`VertexUnpacker.events`); none on a board that takes no vertices.
    """

    steps: Ints
    events: Ints


class UnpackerPlace:
    """
    Columns of where unpackers are, once they have begun (:func:`begin`).

    Of ``steps`` ``step`` is next, which is ``what``; ``bit`` is that of the packed word, ``given`` those of
    the set-up word, which is ``full``. Of ``events`` ``event`` is next, of ``kind``, ``count`` and ``wait``;
    ``waited`` of these clocks are over, and ``done`` of its bits or words, one clock ago ``known``. ``held``
    is whether a word of the line is there, of which ``held_bit`` is next; ``leaving`` bits go out, and zeros
    behind them where ``pads``; ``filling`` is a word of zeros that was begun.
    """

    step: int
    what: int
    bit: int
    given: int
    full: int
    event: int
    kind: int
    count: int
    wait: int
    waited: int
    done: int
    known: int
    held: int
    held_bit: int
    leaving: int
    pads: int
    filling: int


OVER = 8
"""Nothing more comes: beside ``TAKES`` and ``RESTS``, and for a kind of event."""


def unpacking_of(words: np.ndarray, formats: Formats, vertices: bool) -> Unpacking:
    """What unpackers do with words after a reset, whole packets; whether they are those for vertices."""
    events = np.zeros((0, 3), np.int64)
    if vertices:
        events, words = VertexUnpacker(formats).events(words)
    return Unpacking(WordUnpacker(formats).clocks(words), events)


@numba.njit(cache=True, inline="always")
def _to_step(steps: Ints, place: UnpackerPlace, step: int) -> None:
    """``word_unpacker`` goes on."""
    place.step = step
    place.what = steps[step] if step < len(steps) else TAKES | RESTS | OVER


@numba.njit(cache=True, inline="always")
def _to_event(events: Ints, place: UnpackerPlace, event: int) -> None:
    """The program goes on."""
    place.event = event
    place.waited = place.done = place.known = place.wait = 0
    place.kind = OVER
    if event < len(events):
        place.kind, place.count, place.wait = events[event, 0], events[event, 1], events[event, 2]


@numba.njit(cache=True, inline="always")
def begin(steps: Ints, events: Ints, place: UnpackerPlace) -> None:
    """Wait for the first word."""
    _to_step(steps, place, 0)
    _to_event(events, place, 0)


@numba.njit(cache=True, inline="always")
def is_busy(place: UnpackerPlace) -> bool:
    """Whether a packet is begun, or a set-up word waits."""
    if place.full or not place.what & RESTS:
        return True
    return place.kind != OVER and (place.kind != START or place.held != 0 or place.waited < place.wait)


@numba.njit(cache=True, inline="always")
def has_unpacked(place: UnpackerPlace) -> bool:
    """Whether nothing is left."""
    return place.what & OVER != 0 and place.kind == OVER and not place.full


@numba.njit(cache=True, inline="always")
def still_clocks(place: UnpackerPlace) -> int:
    """Clocks in which nothing changes here but ``waited``; -1: until a word comes."""
    if place.full or place.leaving or place.pads:
        return 0
    starved = place.what & TAKES != 0
    if place.kind == OVER:
        return -1 if starved else 0
    if place.waited < place.wait:
        return place.wait - place.waited if place.held else 0
    if place.held:
        return 0
    if place.kind in (START, BITS):
        return -1
    # Of a run, whose words are counted a clock later.
    runs = place.kind == RUN and place.known == place.done and place.done < place.count
    return -1 if runs and starved else 0


@numba.njit(cache=True, inline="always")
def word_clock(steps: Ints, place: UnpackerPlace, has_bit: bool, setup_ready: bool) -> bool:
    """One clock edge of ``word_unpacker``, with a bit or not, the core ready or not; if a word is taken."""
    taken = gives = False
    what = place.what
    if not (what & OVER) and not (what & GIVES and place.full) and not (what & TAKES and not has_bit):
        _to_step(steps, place, place.step + 1)
        gives = what & GIVES != 0
        if what & TAKES:
            place.bit += 1
            if place.bit == SETUP_WORD_BITS:
                place.bit = 0
                taken = True
    if place.full and setup_ready:
        place.full = 0
    if gives:
        place.given += 1
        if place.given == SETUP_WORD_BITS:
            place.given = 0
            place.full = 1
    return taken


@numba.njit(cache=True, inline="always")
def _run_clock(steps: Ints, place: UnpackerPlace, setup_ready: bool) -> bool:
    """One clock edge while packed words pass, and zeros until the last packet is out; whether it is."""
    passes = fills = over = False
    drops = not place.filling and place.held_bit != 0
    if place.filling:
        fills = True
    elif not drops and place.known < place.count:
        passes = place.held != 0 and not place.full
    elif not drops:
        fills = place.full != 0 or not place.what & RESTS
        over = not fills
    place.known = place.done
    place.filling = int(fills)
    if fills and place.what & RESTS:
        place.bit += 1
        if place.bit == SETUP_WORD_BITS:
            place.bit = place.filling = 0
    taken = word_clock(steps, place, passes, setup_ready)
    if taken:
        place.done += 1
    if taken or drops:
        place.held = place.held_bit = 0
    return over


@numba.njit(cache=True, inline="always")
def _core_clock(place: UnpackerPlace, setup_ready: bool) -> None:
    """One clock edge of what goes out of ``vertex_unpacker``: two bits of the set-up word, or one."""
    was_full = place.full
    if setup_ready:
        place.full = 0
    if not was_full and (place.leaving or (place.pads and place.given)):
        bits = 1 if place.given == SETUP_WORD_BITS - 1 or place.leaving == 1 else 2
        place.given += bits
        place.leaving = max(place.leaving - bits, 0)
        if place.given == SETUP_WORD_BITS:
            place.given = 0
            place.full = 1
    elif not place.leaving and not place.given:
        place.pads = 0


@numba.njit(cache=True, inline="always")
def vertex_clock(steps: Ints, events: Ints, place: UnpackerPlace, has_word: bool, setup_ready: bool) -> bool:
    """One clock edge of both, whether there is a word and the core is ready; if the word is taken."""
    taken = has_word and not place.held
    goes_on = False
    if place.waited < place.wait:
        place.waited += 1
        _core_clock(place, setup_ready)
    elif place.kind == RUN:
        goes_on = _run_clock(steps, place, setup_ready)
    else:
        gone, full = not place.leaving and not place.pads, place.full
        _core_clock(place, setup_ready)
        if place.kind == PUT and gone:
            place.leaving, goes_on = place.count, True
        elif place.kind == ALIGN:
            place.pads, goes_on = 1, True
        elif place.kind == WORD and gone and not full:
            place.full, goes_on = 1, True
        elif place.kind in (START, BITS):
            if place.held:
                place.done += 1
                place.held_bit += 1
                if place.held_bit == SETUP_WORD_BITS:
                    place.held = place.held_bit = 0
            goes_on = place.done == place.count
    if goes_on:
        _to_event(events, place, place.event + 1)
    if taken:
        place.held = 1
    return taken


@numba.njit(cache=True, inline="always")
def _all_clocks(steps: Ints, events: Ints, place: UnpackerPlace) -> int:
    begin(steps, events, place)
    clocks = 0
    while not has_unpacked(place):
        vertex_clock(steps, events, place, True, True)
        clocks += 1
    return clocks


def unpacking_clocks(unpacking: Unpacking) -> int:
    """Clocks for vertices where a word of the line is always there, and the core takes each set-up word."""
    return int(_all_clocks(*unpacking, np.zeros(1, record_dtype(UnpackerPlace))[0]))
