# SPDX-License-Identifier: Apache-2.0
"""
Packets that carry vertices to set-up words: the program of ``contract/vertex_program.py``, run.

``docs/reference/vertices.md`` explains the stream. Corners and edge middles stay in tables from packet to
packet, until parameters are sent anew.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
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
    check_formats,
    evaluated,
)
from quadshade.golden.link.vertex_alu import GUARD, cut, div, fold, mulf, muli, muli_steps, shift_clocks
from quadshade.golden.link.word_unpacker import WordUnpacker

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

PIECE = 1024
"""Packets run at a time."""


class _Machine:
    """
    Columns of the unit's state, but for its memory.

    ``bit`` is the line's next one; ``word`` is the set-up word that is begun, ``word_bits`` how many of its
    bits are there, ``count`` set-up words are whole; ``packets`` are, ``run`` packed words follow, ``begun``
    set-up words are there of a packet that starved; ``clocks`` is what all took where nothing waited,
    ``put_done`` in which clock the bits before have gone out.
    """

    bit: int
    word: int
    word_bits: int
    count: int
    packets: int
    run: int
    begun: int
    clocks: int
    put_done: int


_MACHINE = record_dtype(_Machine)


class _Layout(NamedTuple):
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


def _layout(formats: Formats) -> _Layout:
    operations, modes, operands, counts, clocks = np.ascontiguousarray(np.array(evaluated(formats)).T)
    return _Layout(
        operations,
        modes,
        operands,
        counts,
        clocks,
        RATIO_FRAC + SAMPLE_FRAC - formats.frac_bits,
        formats.word_width,
    )


@njit(cache=True)
def _line(words: Words32, machine: _Machine) -> Int:
    """The line's next bit, -1 if there is none."""
    if machine.bit >= SETUP_WORD_BITS * len(words):
        return np.int64(-1)
    # A word is fetched in a clock of its own.
    machine.clocks += machine.bit % SETUP_WORD_BITS == 0
    bit = (np.int64(words[machine.bit // SETUP_WORD_BITS]) >> (machine.bit % SETUP_WORD_BITS)) & 1
    machine.bit += 1
    return bit


@njit(cache=True)
def _give(machine: _Machine, value: Int, bits: Int, out: Words32) -> None:
    """More bits of the set-up words, two in a clock from the next one on, as long as two fit."""
    machine.put_done = max(machine.put_done, machine.clocks + 1)
    while bits > 0:
        size = 1 if bits == 1 or machine.word_bits == SETUP_WORD_BITS - 1 else 2
        machine.word = int(machine.word | (value & ((1 << size) - 1)) << machine.word_bits)
        machine.word_bits += size
        machine.put_done += 1
        value >>= size
        bits -= size
        if machine.word_bits == SETUP_WORD_BITS:
            out[machine.count] = machine.word
            machine.count += 1
            machine.word = machine.word_bits = 0


@njit(cache=True)
def _run_packet(words: Words32, machine: _Machine, memory: Ints, layout: _Layout, out: Words32) -> int:
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
            machine.clocks += int(max(value & 63, 1)) + (mode != IMMEDIATE)
            for _ in range(value & 63):
                bit = _line(words, machine)
                if bit < 0:
                    return STARVED
                acc = cut(2 * acc + bit, GUARD)
        elif operation == _ONES:
            acc = np.int64(0)
            while acc < LONGEST_PREFIX:
                bit = _line(words, machine)
                if bit < 0:
                    return STARVED
                machine.clocks += 1
                if bit == 0:
                    break
                acc += 1
        elif operation == _FOLD:
            acc = fold(acc)
        elif operation == _START:
            if machine.count > before:
                return WHOLE
            bit = np.int64(0)
            while bit == 0:
                bit = _line(words, machine)
                if bit < 0:
                    return EMPTY
                machine.clocks += 1
        elif operation == _RAW:
            machine.bit += -machine.bit % SETUP_WORD_BITS
            machine.run = int(acc & LARGEST_RUN)
            return RAW
        elif operation == _PUT:
            machine.clocks = max(machine.clocks, machine.put_done)
            _give(machine, acc, value, out)
        elif operation == _WORD:
            machine.clocks = max(machine.clocks, machine.put_done)
            out[machine.count] = (acc >> layout.word_low) & ((np.int64(1) << layout.word_width) - 1)
            machine.count += 1
        elif operation == _ALIGN:
            _give(machine, np.int64(0), np.int64(-machine.word_bits % SETUP_WORD_BITS), out)
            machine.put_done += 1
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
                machine.clocks += JUMP_CLOCKS
                pc = operand


@njit(cache=True)
def _run(words: Words32, machine: _Machine, memory: Ints, layout: _Layout, out: Words32, ends: Ints) -> int:
    """
    Run whole packets until they end; how the last one did.

    ``ends`` (n, 3) gets where each packet begins and ends on the line, and where its set-up words end. A
    packet that starves leaves memory and machine as they were before it; ``begun`` of its set-up words are
    out.
    """
    kept = np.zeros(len(memory), np.int64)
    while machine.packets < len(ends):
        kept[:] = memory
        bit, count, clocks = machine.bit, machine.count, machine.clocks
        status = _run_packet(words, machine, memory, layout, out)
        if status == STARVED:
            memory[:] = kept
            machine.begun = machine.count - count
            machine.bit, machine.count, machine.clocks = bit, count, clocks
            machine.put_done = 0
            machine.word = machine.word_bits = 0
        if status != WHOLE:
            return status
        ends[machine.packets, 0], ends[machine.packets, 1] = bit, machine.bit
        ends[machine.packets, 2] = machine.count
        machine.packets += 1
    return WHOLE


class VertexUnpacker:
    """
    Unpacks words as they come.

    Parameters
    ----------
    formats : Formats

    Raises
    ------
    QuadshadeError
      Formats for which there is no such unit.

    Attributes
    ----------
    within : bool
      The words so far end within a packet.
    begun : list of int
      Set-up words that the hardware has already put out of a packet whose words are not all there.
    memory : (MEMORY_WORDS,) int64
    clocks : int
      What the unit took since it was reset, where nothing made it wait; but for packed words.
    """

    def __init__(self, formats: Formats) -> None:
        check_formats(formats)
        self._layout = _layout(formats)
        self.plain = WordUnpacker(formats)
        self.most_words = self.plain.most_words + 8
        self.memory = np.zeros(MEMORY_WORDS, np.int64)
        self.reset()

    def reset(self) -> None:
        """Forget a begun packet; the tables stay, but parameters have to be sent anew."""
        self.plain.reset()
        self._rest = np.zeros(0, np.uint32)
        self._skip = self._passing = self.clocks = 0
        self.within = False
        self.begun: list[int] = []

    def finished(self) -> np.ndarray:
        """End a packed packet that was begun, with zeros."""
        given = [np.zeros(0, np.uint32)]
        while self.plain.within:
            given.append(self.plain.feed(np.zeros(8, np.uint32)))
        return np.concatenate(given)

    def packets(self, words: Sequence[int] | np.ndarray) -> Iterator[tuple[int, int, np.ndarray]]:
        """
        Take words, packet by packet; a run of packed words counts as one.

        Parameters
        ----------
        words : (n,) uint32

        Yields
        ------
        start, end : int
          Bits of the packet, counted from the first of these words; a packet may have begun before it.
        setup_words : (m,) uint32
        """
        before = SETUP_WORD_BITS * len(self._rest)
        words = np.concatenate([self._rest, np.asarray(words, np.uint32)])
        machine = np.zeros(1, _MACHINE)[0]
        machine["bit"] = self._skip
        out = np.zeros(PIECE * self.most_words, np.uint32)
        ends = np.zeros((PIECE, 3), np.int64)
        self.within, self.begun = False, []
        while True:
            if self._passing:
                start = int(machine["bit"])
                at = start // SETUP_WORD_BITS
                piece = words[at : at + self._passing]
                self._passing -= len(piece)
                machine["bit"] = end = start + SETUP_WORD_BITS * len(piece)
                given = self.plain.feed(piece)
                if not self._passing:
                    given = np.concatenate([given, self.finished()])
                if len(given):
                    yield start - before, end - before, given
                if self._passing:
                    self.within = True
                    break
            machine["count"] = machine["packets"] = 0
            status = _run(words, machine, self.memory, self._layout, out, ends)
            first = 0
            for start, end, last in ends[: machine["packets"]].tolist():
                yield start - before, end - before, out[first:last].copy()
                first = last
            if status == RAW:
                self._passing = int(machine["run"])
            elif status != WHOLE:
                self.within = status == STARVED
                self.begun = out[first : first + machine["begun"]].tolist() if self.within else []
                break
        self.clocks += int(machine["clocks"])
        done, self._skip = divmod(int(machine["bit"]), SETUP_WORD_BITS)
        self._rest = words[done:]

    def feed(self, words: Sequence[int] | np.ndarray) -> np.ndarray:
        """
        Take words.

        Parameters
        ----------
        words : (n,) uint32

        Returns
        -------
        (m,) uint32
          Set-up words of the packets that are whole now.
        """
        setup_words = [setup_words for _, _, setup_words in self.packets(words)]
        return np.concatenate(setup_words) if setup_words else np.zeros(0, np.uint32)
