# SPDX-License-Identifier: Apache-2.0
"""Ways to a board: a serial port, a pyserial URL, an open object, or a model in this process."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable
from typing import Any, Protocol

import serial

from quadshade.link.faults import FaultInjector
from quadshade.link.protocol import LinkError

DEFAULT_BAUD = 1_000_000
READ_BYTES = 65536


class Transport(Protocol):
    """What a session needs of a line."""

    def write(self, data: bytes) -> None:
        """Send all of it."""

    def read(self, seconds: float) -> bytes:
        """What has come, after waiting up to some seconds for the first byte; empty if none came."""

    def set_baud(self, baud: int) -> None:
        """Another rate, once everything is sent."""

    def send_break(self) -> None:
        """Bring the board back to its default rate."""

    def close(self) -> None:
        """Give the line up."""


HINTS = {
    errno.ENOENT: "there is no such port; is the board plugged in?",
    errno.EACCES: "no permission; join the group that owns it (`sudo adduser $USER dialout`), log in anew",
    errno.EPERM: "no permission; join the group that owns it (`sudo adduser $USER dialout`), log in anew",
    errno.EBUSY: "another program has it open; close that",
    errno.EWOULDBLOCK: "another program has it open; close that",
}


def _open_error(port: str, problem: Exception) -> LinkError:
    """What is wrong with a port, with a hint."""
    number = getattr(problem, "errno", None)
    if number is None and "exclusively lock" in str(problem):
        number = errno.EBUSY
    if number is None and isinstance(problem, ValueError):
        return LinkError(f"{port} is no port and no URL that pyserial knows", "give a name as /dev/ttyUSB0")
    return LinkError(f"cannot open {port}: {problem}", HINTS.get(number, "is it the right port?"))


class SerialTransport:
    """
    A line through pyserial.

    Parameters
    ----------
    port : str or serial object
      A port's name, a pyserial URL (``socket://host:port``, ``loop://``), or an object that is open already.
    baud : int

    Raises
    ------
    LinkError
      The port is missing, busy, or may not be opened.
    """

    def __init__(self, port: Any, baud: int = DEFAULT_BAUD) -> None:
        self.name = port if isinstance(port, str) else getattr(port, "name", None) or repr(port)
        self._serial = self._open(port, baud) if isinstance(port, str) else port

    @staticmethod
    def _open(port: str, baud: int) -> Any:
        options: dict[str, Any] = {"baudrate": baud, "timeout": 0}
        if "://" not in port:
            options["exclusive"] = True
        try:
            opened = serial.serial_for_url(port, **options)
        except (serial.SerialException, ValueError, OSError) as problem:
            raise _open_error(port, problem) from None
        try:
            opened.set_low_latency_mode(True)
        except (AttributeError, ValueError, OSError, NotImplementedError):
            # A pseudo-terminal or a socket has no latency timer.
            pass
        return opened

    def _do(self, action: Callable[[], Any]) -> Any:
        """An action, with the line's failure as one of the family."""
        try:
            return action()
        except (serial.SerialException, OSError, TypeError) as problem:
            # pyserial raises TypeError where a port was closed while it waited.
            raise LinkError(
                f"the line {self.name} is gone: {problem}", "plug it in and start again"
            ) from None

    def write(self, data: bytes) -> None:
        self._do(lambda: self._serial.write(data))

    def read(self, seconds: float) -> bytes:
        def action() -> bytes:
            self._serial.timeout = seconds
            first = self._serial.read(1)
            self._serial.timeout = 0
            return first + (self._serial.read(READ_BYTES) if first else b"")

        return self._do(action)

    def set_baud(self, baud: int) -> None:
        def action() -> None:
            self._serial.flush()
            self._serial.baudrate = baud

        self._do(action)

    def send_break(self) -> None:
        self._do(lambda: self._serial.send_break(0.01))

    def close(self) -> None:
        self._serial.close()


class MemoryTransport:
    """
    A board in this process.

    Parameters
    ----------
    feed : callable
      Takes bytes of the line and returns those that come back: ``BoardModel.feed``.
    piece : int
      Most bytes that one read gives.
    """

    name = "memory"

    def __init__(self, feed: Callable[[bytes], bytes], piece: int = READ_BYTES) -> None:
        self._feed, self._piece = feed, piece
        self._coming = bytearray()

    def write(self, data: bytes) -> None:
        self._coming += self._feed(data)

    def read(self, seconds: float) -> bytes:
        data = bytes(self._coming[: self._piece])
        del self._coming[: self._piece]
        return data

    def set_baud(self, baud: int) -> None:
        pass

    def send_break(self) -> None:
        pass

    def close(self) -> None:
        pass


class FaultyTransport:
    """
    A line that damages what passes, both ways.

    Parameters
    ----------
    transport : Transport
    rate : float
      Faults a byte.
    seed : int or str

    Attributes
    ----------
    going, coming : FaultInjector
      They count the faults.
    """

    def __init__(self, transport: Transport, rate: float, seed: int | str = 1) -> None:
        self._transport = transport
        self.name = getattr(transport, "name", "line")
        self.going, self.coming = FaultInjector(rate, f"going {seed}"), FaultInjector(rate, f"coming {seed}")

    def write(self, data: bytes) -> None:
        self._transport.write(self.going.damage(data))

    def read(self, seconds: float) -> bytes:
        return self.coming.damage(self._transport.read(seconds))

    def set_baud(self, baud: int) -> None:
        self._transport.set_baud(baud)

    def send_break(self) -> None:
        self._transport.send_break()

    def close(self) -> None:
        self._transport.close()


def open_transport(port: Any = None, baud: int | None = None) -> SerialTransport:
    """
    A port by name, URL or object; ``QUADSHADE_PORT`` and ``QUADSHADE_BAUD`` stand in for what is not given.

    Raises
    ------
    LinkError
      No port is given, or it cannot be opened.
    """
    port = port or os.environ.get("QUADSHADE_PORT")
    if not port:
        raise LinkError("no port is given", "give one, or set QUADSHADE_PORT")
    rate = str(baud or os.environ.get("QUADSHADE_BAUD") or DEFAULT_BAUD)
    if not rate.isdecimal() or not int(rate):
        raise LinkError(f"the baud rate is {rate!r}", "give a whole number")
    return SerialTransport(port, int(rate))
