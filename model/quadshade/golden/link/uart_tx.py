# SPDX-License-Identifier: Apache-2.0
"""The transmitter of a serial line, clock by clock (``rtl/link/uart_tx.vhd``)."""

from __future__ import annotations

from quadshade.contract.protocol import PHASE_BITS

WHOLE = 1 << PHASE_BITS


class UartTx:
    """8N1: bits end where the phase overflows; its remainder stays from character to character."""

    def __init__(self) -> None:
        self._bits: list[int] = []
        self._phase = 0

    @property
    def tx(self) -> int:
        """The line."""
        return self._bits[0] if self._bits else 1

    @property
    def busy(self) -> bool:
        """A character is on its way."""
        return bool(self._bits)

    def ready(self, phase_step: int) -> bool:
        """True if the byte that is offered in this clock is taken."""
        return not self._bits or (len(self._bits) == 1 and self._phase + phase_step >= WHOLE)

    def clock(self, offered: int | None, phase_step: int) -> None:
        """One clock edge with a byte (or None) at the input."""
        taken = offered if self.ready(phase_step) else None
        if self._bits:
            self._phase += phase_step
            if self._phase >= WHOLE:
                self._phase -= WHOLE
                del self._bits[0]
        else:
            self._phase = 0
        if taken is not None:
            self._bits = [0, *(taken >> index & 1 for index in range(8)), 1]
