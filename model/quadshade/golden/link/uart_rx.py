# SPDX-License-Identifier: Apache-2.0
"""The receiver of a serial line, clock by clock (``rtl/link/uart_rx.vhd``)."""

from __future__ import annotations

from dataclasses import dataclass

from quadshade.contract.protocol import BREAK_BITS, PHASE_BITS

EIGHTH = 1 << (PHASE_BITS - 3)
IDLE, CHARACTER, LOW = "idle", "character", "low"


@dataclass
class Outputs:
    """What stands at the outputs in one clock; ``data`` counts where ``valid`` is set."""

    valid: bool = False
    data: int = 0
    framing_error: bool = False
    break_seen: bool = False


class UartRx:
    """8N1: phase from the start bit's edge on, three samples a bit, and the majority."""

    def __init__(self) -> None:
        self._line = [1, 1]
        self.reset()

    def reset(self) -> None:
        """Forget the character; the line's two registers go on."""
        self.outputs = Outputs()
        self._place = IDLE
        self._phase = self._position = self._data = self._low_bits = 0
        self._samples = [1, 1]

    def clock(self, rx: int, phase_step: int) -> None:
        """One clock edge."""
        line, self._line = self._line[1], [rx, self._line[0]]
        self.outputs = Outputs()
        if self._place == IDLE:
            self._position = self._low_bits = 0
            self._phase = phase_step
            if not line:
                self._place = CHARACTER
            return
        before = self._phase // EIGHTH
        self._phase += phase_step
        after = self._phase // EIGHTH % 8
        if self._phase >= 8 * EIGHTH:
            self._phase -= 8 * EIGHTH
            self._position += self._place == CHARACTER
        for index in range(2):
            if before < 3 + index <= after:
                self._samples[index] = line
        if before < 5 <= after:
            self._decide(int(sum(self._samples) + line >= 2))
        if self._place == LOW and line:
            self._place = IDLE

    def _decide(self, value: int) -> None:
        """The value of a bit."""
        if value:
            self._low_bits = 0
        elif self._low_bits < BREAK_BITS:
            self._low_bits += 1
            self.outputs.break_seen = self._low_bits == BREAK_BITS
        if self._place != CHARACTER:
            return
        if self._position == 0:
            if value:
                self._place = IDLE
        elif self._position < 9:
            self._data = self._data >> 1 | value << 7
        else:
            self.outputs.valid, self.outputs.framing_error = bool(value), not value
            self.outputs.data = self._data
            self._place = IDLE if value else LOW
