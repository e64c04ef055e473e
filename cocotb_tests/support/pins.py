# SPDX-License-Identifier: Apache-2.0
"""The host's serial port at a simulated board's pins, bit by bit: a transport for ``quadshade.link``."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import cocotb
from cocotb.task import resume
from cocotb.triggers import Event, FallingEdge, First, Timer

BITS = 10
"""Of a character: start, eight of data, stop."""

BREAK_BITS = 30


class PinsTransport:
    """
    Bytes to ``rx`` and from ``tx``; its methods block a thread of :func:`cocotb.task.bridge`.

    Parameters
    ----------
    dut : cocotb handle
    bit_ns : float
      Length of a bit.
    patience_bits : int
      How long a read of any time-out waits, in simulated time.

    Attributes
    ----------
    framing_errors : int
      Characters from the board without a stop bit.
    """

    name = "pins"

    def __init__(self, dut: Any, bit_ns: float, patience_bits: int = 6000) -> None:
        self.dut, self.bit_ns, self.patience_bits = dut, bit_ns, patience_bits
        self.framing_errors = 0
        self._coming, self._arrived = bytearray(), Event()
        cocotb.start_soon(self._receive())

    def _bits(self, count: float) -> Timer:
        return Timer(round(self.bit_ns * count * 1000), "ps")

    async def _receive(self) -> None:
        """Characters from tx, each from its start bit on, sampled in the middle."""
        while True:
            await FallingEdge(self.dut.tx)
            value = 0
            await self._bits(1.5)
            for index in range(8):
                value |= int(self.dut.tx.value) << index
                await self._bits(1)
            self.framing_errors += not int(self.dut.tx.value)
            self._coming.append(value)
            self._arrived.set()

    async def send(self, data: bytes) -> None:
        """Characters to rx, without gaps."""
        for byte in data:
            line = byte << 1 | 1 << BITS - 1
            for index in range(BITS):
                self.dut.rx.value = line >> index & 1
                await self._bits(1)

    async def arrived(self, most: int | None = None) -> bytes:
        """What has come, or comes in time."""
        if not self._coming:
            self._arrived.clear()
            await First(self._arrived.wait(), self._bits(self.patience_bits))
        data = bytes(self._coming[:most])
        del self._coming[: len(data)]
        return data

    async def low(self, bits: float) -> None:
        """A break of some length."""
        self.dut.rx.value = 0
        await self._bits(bits)
        self.dut.rx.value = 1
        await self._bits(2)

    def write(self, data: bytes) -> None:
        _blocking(self.send)(data)

    def read(self, seconds: float) -> bytes:
        return _blocking(self.arrived)()

    def set_baud(self, baud: int) -> None:
        raise NotImplementedError("the pins' rate is a number of nanoseconds a bit: set bit_ns")

    def send_break(self) -> None:
        _blocking(self.low)(BREAK_BITS)

    def close(self) -> None:
        pass


def _blocking(function: Callable) -> Callable:
    """A coroutine function as one that blocks its thread until the simulation has run it."""
    return resume(function)
