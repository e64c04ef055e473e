# SPDX-License-Identifier: Apache-2.0
"""
The program of ``contract/vertex_program.py``, run: what comes of its packets, and its own clocks.

Those are the clocks in which neither line nor core makes it wait. What it needs of them, and when, are its
events; ``unpacker_clocks.py`` runs these against a line and a core.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from quadshade.contract.arrays import Int, Ints, Words32, record_dtype
from quadshade.contract.formats import SETUP_WORD_BITS, Formats
from quadshade.contract.vertex_program import (
    IMMEDIATE,
    INDEXED,
    LARGEST_RUN,
    LONGEST_PREFIX,
    MEMORY_WORDS,
    OPERATIONS,
    RATIO_FRAC,
    SAMPLE_FRAC,
    WIDTH,
    ZERO_BITS,
    evaluated,
)
from quadshade.golden.link.vertex_alu import GUARD, cut, div, fold, mulf, muli, muli_steps, shift_clocks

_LD, _ADD, _SUB, _LDQ, _LDR, _MULI, _MULF, _DIV, _ST, _STQ, _LDP, _LDX, _LOOP = range(13)
_FOLD, _SHL, _SHR, _PUT, _GET, _TAKE, _ONES, _START, _RAW, _WORD, _ALIGN = range(13, 24)
_JMP, _JZ, _JNZ, _JN, _JNN, _CALL, _RET = range(24, len(OPERATIONS))

WHOLE, EMPTY, STARVED, RAW = range(4)
"""
How a packet ended: its set-up words are there, there was none, the line's words end within it, packed words
follow.
"""

JUMP_CLOCKS = 3
"""Of a jump that is taken, besides those of any instruction."""

START, BITS, PUT, ALIGN, WORD, RUN = range(6)
"""
What an event is: so many bits of the line, of which the last one starts a packet, or within one; so many that
go out; the set-up word is filled up, or given whole; so many packed words pass.
"""


class Machine:
    """
    Columns of the unit's state, but for its memory.

    ``bit`` is the line's next one; ``word`` is the set-up word that is begun, ``word_bits`` how many of its
    bits are there, ``count`` set-up words are whole; ``packets`` are, ``run`` packed words follow, ``begun``
    set-up words are there of a packet that starved; ``clocks`` are the program's own, ``ended`` in which of
    them the last event ended, ``events`` how many are noted.
    """

    bit: int
    word: int
    word_bits: int
    count: int
    packets: int
    run: int
    begun: int
    clocks: int
    ended: int
    events: int


MACHINE = record_dtype(Machine)


class Layout(NamedTuple):
    """
    The program, an entry an instruction, with clocks that do not depend on numbers; where in the accumulator
    a word begins, and its bits.
    """

    operations: Ints
    modes: Ints
    operands: Ints
    counts: Ints
    clocks: Ints
    word_low: int
    word_width: int


def layout_of(formats: Formats) -> Layout:
    """The program with formats' numbers."""
    operations, modes, operands, counts, clocks = np.ascontiguousarray(np.array(evaluated(formats)).T)
    return Layout(
        operations,
        modes,
        operands,
        counts,
        clocks,
        RATIO_FRAC + SAMPLE_FRAC - formats.frac_bits,
        formats.word_width,
    )


@njit(cache=True)
def _line(words: Words32, machine: Machine) -> Int:
    """The line's next bit, -1 if there is none."""
    if machine.bit >= SETUP_WORD_BITS * len(words):
        return np.int64(-1)
    bit = (np.int64(words[machine.bit // SETUP_WORD_BITS]) >> (machine.bit % SETUP_WORD_BITS)) & 1
    machine.bit += 1
    return bit


@njit(cache=True)
def _note(machine: Machine, events: Ints, what: int, count: int, clocks: int) -> None:
    """Add an event of so many clocks that is over now, and what the program took for itself before it."""
    if len(events):
        events[machine.events, 0], events[machine.events, 1] = what, count
        events[machine.events, 2] = machine.clocks - clocks - machine.ended
        machine.events += 1
    machine.ended = machine.clocks


@njit(cache=True)
def _give(machine: Machine, value: Int, bits: Int, out: Words32) -> None:
    """More bits of the set-up words."""
    while bits > 0:
        size = min(int(bits), SETUP_WORD_BITS - machine.word_bits)
        machine.word = int(machine.word | (value & ((1 << size) - 1)) << machine.word_bits)
        machine.word_bits += int(size)
        value >>= size
        bits -= size
        if machine.word_bits == SETUP_WORD_BITS:
            out[machine.count] = machine.word
            machine.count += 1
            machine.word = machine.word_bits = 0


@njit(cache=True)
def _run_packet(
    words: Words32, machine: Machine, memory: Ints, layout: Layout, out: Words32, events: Ints
) -> int:
    """
    Run from the start of a packet to that of the next one; how it ended.

    ``memory`` and ``out`` are written also by a packet that starves. A run's number of words is ``run``.
    """
    operations, modes, operands, counts = layout.operations, layout.modes, layout.operands, layout.counts
    acc: Int = np.int64(0)
    shifter: Int = np.int64(0)
    value: Int = np.int64(0)
    pointer: Int = 0
    index: Int = 0
    pc: Int = 0
    first: Int = 0
    second: Int = 0
    third: Int = 0
    before = machine.count
    while True:
        operation, mode, operand = operations[pc], modes[pc], operands[pc]
        pc += 1
        place = operand
        if mode == IMMEDIATE:
            value = operand
        else:
            if mode == INDEXED:
                place = (operand + pointer + index) & (MEMORY_WORDS - 1)
            value = memory[place]
        machine.clocks += layout.clocks[pc - 1]
        if operation == _LD:
            acc = value
        elif operation == _ST:
            memory[place] = cut(acc, WIDTH)
        elif operation == _ADD:
            acc = cut(acc + value, WIDTH)
        elif operation == _SUB:
            acc = cut(acc - value, WIDTH)
        elif operation == _LDQ:
            shifter = value
        elif operation == _LDR:
            acc = shifter
        elif operation == _MULI:
            acc = muli(acc, value, shifter, counts[pc - 1])
            machine.clocks += muli_steps(shifter, counts[pc - 1])
        elif operation == _MULF:
            acc = mulf(acc, value, shifter, counts[pc - 1])
        elif operation == _DIV:
            acc, shifter = div(acc, value, shifter, counts[pc - 1])
        elif operation == _STQ:
            memory[place] = shifter
        elif operation == _LDP:
            pointer = value & (MEMORY_WORDS - 1)
        elif operation == _LDX:
            index = value & 7
        elif operation == _SHL:
            acc = cut(acc << (value & 63), GUARD)
            machine.clocks += shift_clocks(value & 63) + (mode != IMMEDIATE)
        elif operation == _SHR:
            acc >>= value & 63
            machine.clocks += shift_clocks(value & 63) + (mode != IMMEDIATE)
        elif operation in (_GET, _TAKE):
            if operation == _TAKE:
                acc = np.int64(0)
            bits = int(value & 63)
            machine.clocks += max(bits, 1) + (mode != IMMEDIATE)
            for _ in range(bits):
                bit = _line(words, machine)
                if bit < 0:
                    return STARVED
                acc = cut(2 * acc + bit, GUARD)
            if bits:
                _note(machine, events, BITS, bits, bits)
        elif operation == _ONES:
            acc, bits = np.int64(0), 0
            while acc < LONGEST_PREFIX:
                bit = _line(words, machine)
                if bit < 0:
                    return STARVED
                bits += 1
                if bit == 0:
                    break
                acc += 1
            machine.clocks += bits
            _note(machine, events, BITS, bits, bits)
        elif operation == _FOLD:
            acc = fold(acc)
        elif operation == _START:
            if machine.count > before:
                # It is the next packet's.
                machine.clocks -= layout.clocks[0]
                return WHOLE
            bit, bits = np.int64(0), 0
            while bit == 0:
                bit = _line(words, machine)
                if bit >= 0:
                    bits += 1
                if bit != 0:
                    machine.clocks += bits
                    _note(machine, events, START, bits, bits)
                if bit < 0:
                    return EMPTY
        elif operation == _RAW:
            machine.bit += -machine.bit % SETUP_WORD_BITS
            machine.run = int(acc & LARGEST_RUN)
            _note(machine, events, RUN, machine.run, 0)
            # Then it jumps to the next packet.
            machine.clocks += 1 + JUMP_CLOCKS
            return RAW
        elif operation == _PUT:
            _note(machine, events, PUT, int(value), 1)
            _give(machine, acc, value, out)
        elif operation == _WORD:
            _note(machine, events, WORD, 0, 1)
            out[machine.count] = (acc >> layout.word_low) & ((np.int64(1) << layout.word_width) - 1)
            machine.count += 1
        elif operation == _ALIGN:
            _note(machine, events, ALIGN, 0, 1)
            _give(machine, np.int64(0), np.int64(-machine.word_bits % SETUP_WORD_BITS), out)
        else:
            if operation == _LOOP:
                index = (index + 1) & 7
                jumps = index < counts[pc - 1]
            elif operation in (_JZ, _JNZ):
                jumps = (cut(acc, ZERO_BITS) == 0) == (operation == _JZ)
            elif operation in (_JN, _JNN):
                jumps = (cut(acc, WIDTH) < 0) == (operation == _JN)
            else:
                jumps = True
            if operation == _CALL:
                # The last ones called; the program never has more.
                first, second, third = pc, first, second
            elif operation == _RET:
                operand, first, second = first, second, third
            if jumps:
                # What is behind it need not wait.
                machine.clocks += 1 + JUMP_CLOCKS - layout.clocks[pc - 1]
                pc = operand


@njit(cache=True)
def run_packets(
    words: Words32, machine: Machine, memory: Ints, layout: Layout, out: Words32, ends: Ints, events: Ints
) -> int:
    """
    Run whole packets until they end; how the last one did.

    ``ends`` (n, 3) gets where each packet begins and ends on the line, and where its set-up words end. A
    packet that starves leaves memory and machine as they were before it; ``begun`` of its set-up words are
    out. ``events`` (k, 3) gets what, how many, and the program's own clocks before; none are noted where it
    is empty.
    """
    kept = np.zeros(len(memory), np.int64)
    while machine.packets < len(ends):
        kept[:] = memory
        bit, count, clocks = machine.bit, machine.count, machine.clocks
        status = _run_packet(words, machine, memory, layout, out, events)
        if status == STARVED:
            memory[:] = kept
            machine.begun = machine.count - count
            machine.bit, machine.count, machine.clocks = bit, count, clocks
            machine.word = machine.word_bits = 0
        if status != WHOLE:
            return status
        ends[machine.packets, 0], ends[machine.packets, 1] = bit, machine.bit
        ends[machine.packets, 2] = machine.count
        machine.packets += 1
    return WHOLE
