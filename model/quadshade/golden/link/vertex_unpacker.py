# SPDX-License-Identifier: Apache-2.0
"""
Packets that carry vertices to set-up words, as they come: ``vertex_machine.py`` runs the program on them.

``docs/reference/vertices.md`` explains the stream. Corners and edge middles stay in tables from packet to
packet, until parameters are sent anew.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from quadshade.contract.formats import SETUP_WORD_BITS, Formats
from quadshade.contract.vertex_program import MEMORY_WORDS, check_formats
from quadshade.golden.link.vertex_machine import MACHINE, RAW, STARVED, WHOLE, layout_of, run_packets
from quadshade.golden.link.word_unpacker import WordUnpacker

PIECE = 1024
"""Packets run at a time."""


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
      The program's own since the unit was reset, in which neither line nor core makes it wait.
    """

    def __init__(self, formats: Formats) -> None:
        check_formats(formats)
        self._layout = layout_of(formats)
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
        self._events: list[np.ndarray] | None = None
        self._passed: list[np.ndarray] = []

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
        machine = np.zeros(1, MACHINE)[0]
        machine["bit"] = self._skip
        out = np.zeros(PIECE * self.most_words, np.uint32)
        ends = np.zeros((PIECE, 3), np.int64)
        # Each event reads a bit or, of a packet's, gives some.
        noted = 0 if self._events is None else SETUP_WORD_BITS * len(words) + 2 * PIECE * self.most_words + 1
        self.within, self.begun = False, []
        while True:
            if self._passing:
                start = int(machine["bit"])
                at = start // SETUP_WORD_BITS
                piece = words[at : at + self._passing]
                self._passing -= len(piece)
                if self._events is not None:
                    self._passed.append(piece)
                machine["bit"] = end = start + SETUP_WORD_BITS * len(piece)
                given = self.plain.feed(piece)
                if not self._passing:
                    given = np.concatenate([given, self.finished()])
                if len(given):
                    yield start - before, end - before, given
                if self._passing:
                    self.within = True
                    break
            machine["count"] = machine["packets"] = machine["events"] = 0
            events = np.empty((noted, 3), np.int64)
            status = run_packets(words, machine, self.memory, self._layout, out, ends, events)
            if self._events is not None:
                self._events.append(events[: machine["events"]].copy())
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

    def events(self, words: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """
        What the program needs of line and core for words after a reset, and when.

        Parameters
        ----------
        words : (n,) uint32
          Whole packets.

        Returns
        -------
        events : (k, 3) int64
          What, how many, and the program's own clocks before (:func:`run_packets`).
        passed : (m,) uint32
          Packed words that pass.
        """
        self.reset()
        self._events, self._passed = [], []
        for _ in self.packets(words):
            pass
        events, passed = np.concatenate(self._events), self._passed
        self.reset()
        # The first packet's start is waited for at all times.
        events[0, 2] = 0
        return events, np.concatenate([np.zeros(0, np.uint32), *passed])

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
