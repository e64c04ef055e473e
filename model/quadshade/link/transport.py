# SPDX-License-Identifier: Apache-2.0
"""Ways to a board: a serial port, a pyserial URL, an open object, or a model in this process."""

from __future__ import annotations

import contextlib
import errno
import os
import socket
import termios
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol
from urllib.parse import urlsplit

import serial

from quadshade.contract.protocol import LineGoneError, LinkError, PortError
from quadshade.link.faults import FaultInjector

DEFAULT_BAUD = 1_000_000
READ_BYTES = 65536


class Transport(Protocol):
    """What a session needs of a line."""

    @property
    def fixed_rate(self) -> bool:
        """The line has no rate: there is none to agree on."""

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


UDEV_RULES = Path(__file__).with_name("60-quadshade.rules")
"""Lets whoever sits at the machine open the boards' ports."""

NO_PERMISSION = (
    "join the group that owns it (`sudo adduser $USER dialout`, then log in anew), or install the rule of"
    f" udev (`sudo cp {UDEV_RULES} /etc/udev/rules.d/`) and plug the board in anew"
)
BUSY = "close the other program; `fuser` names it"
REFUSED = "start one there: `quadshade board --tcp PORT`"

LOCAL_SCHEMES = ("", "spy", "alt", "hwgrep")
"""Schemes of URLs behind which pyserial opens a port of this machine, for one program at a time."""

NETWORK_SCHEMES = ("socket", "rfc2217")
RFC2217 = "rfc2217"
POLL_SECONDS = 0.001
"""So often an RFC 2217 server's bytes are looked for."""

PROBLEMS = {
    errno.ENOENT: ("there is no port {port}", "is the board plugged in?"),
    errno.ENODEV: ("there is no port {port}", "is the board plugged in?"),
    errno.ENXIO: ("there is no port {port}", "is the board plugged in?"),
    errno.EACCES: ("no permission to open {port}", NO_PERMISSION),
    errno.EPERM: ("no permission to open {port}", NO_PERMISSION),
    errno.EBUSY: ("another program has {port} open", BUSY),
    errno.EWOULDBLOCK: ("another program has {port} open", BUSY),
    errno.ECONNREFUSED: ("no board listens on {port}", REFUSED),
    errno.ENOTTY: ("{port} is no serial port", "give the board's, e.g. /dev/ttyUSB0"),
    errno.EINVAL: ("{port} is no serial port", "give the board's, e.g. /dev/ttyUSB0"),
    errno.EISDIR: ("{port} is no serial port", "give the board's, e.g. /dev/ttyUSB0"),
}
"""What is wrong and what to do, by the number of the system's error."""

WRITE_SECONDS = 60.0
"""A line that takes nothing for so long is blocked: its other end neither reads nor hangs up."""

BREAK_SECONDS = 0.01
SLOW_SECONDS = 0.05
"""A pseudo-terminal has no break: for so long it gets a rate at which a 00 is one."""


def _error_number(problem: BaseException | None) -> int | None:
    """The system's number of an error, also where pyserial has wrapped it in one of its own."""
    while problem is not None:
        number = getattr(problem, "errno", None)
        if isinstance(number, int):
            return number
        if "exclusively lock" in str(problem):
            return errno.EBUSY
        if isinstance(problem, termios.error):
            return int(problem.args[0])
        problem = problem.__cause__ or problem.__context__
    return None


def _open_error(port: str, problem: Exception) -> PortError:
    """What is wrong with a port, with a hint."""
    number = _error_number(problem)
    if number == errno.ECONNREFUSED and _scheme(port) == RFC2217:
        return PortError(f"no server listens on {port}", "start one on the machine that has the board")
    if number in PROBLEMS:
        message, hint = PROBLEMS[number]
        return PortError(message.format(port=port), hint)
    if str(problem).startswith("invalid URL, protocol"):
        return PortError(f"{port} is no port and no URL that pyserial knows", "give a name as /dev/ttyUSB0")
    reason = str(problem).removeprefix(f"Could not open port {port}: ") or type(problem).__name__
    return PortError(f"cannot open {port}: {reason}", "is it the right port?")


def _scheme(port: str) -> str:
    """The scheme of a URL in small letters; of a port's name nothing."""
    scheme, colon, _ = port.partition("://")
    return scheme.lower() if colon else ""


def _check_address(port: str) -> None:
    """Refuse a network's URL without host or port, of which pyserial speaks in riddles."""
    scheme = _scheme(port)
    if scheme not in NETWORK_SCHEMES:
        return
    try:
        parts = urlsplit(port)
        is_whole = bool(parts.hostname and parts.port)
    except ValueError:
        is_whole = False
    if not is_whole:
        raise PortError(f"{port} is no address", f"write {scheme}://HOST:PORT, the port from 1 to 65535")


class SerialTransport:
    """
    A line through pyserial.

    Parameters
    ----------
    port : str or serial object
      A port's name, a pyserial URL (``socket://host:port``, ``rfc2217://host:port``, ``spy://port``,
      ``alt://port``, ``hwgrep://regexp``, ``loop://``), or an object that is open already.
    baud : int

    Raises
    ------
    LinkError
      The port is missing, busy, or may not be opened.
    """

    def __init__(self, port: Any, baud: int = DEFAULT_BAUD) -> None:
        self.name = port if isinstance(port, str) else getattr(port, "name", None) or repr(port)
        self._serial = self._open(port, baud) if isinstance(port, str) else port

    @property
    def fixed_rate(self) -> bool:
        """True for a socket: nothing tells the other end of a rate."""
        return _scheme(self.name) == "socket"

    @staticmethod
    def _open(port: str, baud: int) -> Any:
        _check_address(port)
        options: dict[str, Any] = {"baudrate": baud, "timeout": 0}
        if _scheme(port) != RFC2217:
            # pyserial has no time-out for a write there.
            options["write_timeout"] = WRITE_SECONDS
        if _scheme(port) in LOCAL_SCHEMES:
            options["exclusive"] = True
        try:
            opened = serial.serial_for_url(port, **options)
        except Exception as problem:  # noqa: BLE001 - its URLs raise KeyError, re.error, TypeError, ...
            raise _open_error(port, problem) from None
        try:
            opened.set_low_latency_mode(True)
        except (AttributeError, ValueError, OSError, NotImplementedError):
            # A pseudo-terminal or a socket has no latency timer.
            pass
        line = getattr(opened, "_socket", None)
        if line is not None:
            # Frames are small, and must not wait for an acknowledgement of the last one.
            line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        return opened

    def _do(self, action: Callable[[], Any]) -> Any:
        """An action, with the line's failure as one of the family."""
        try:
            return action()
        except serial.SerialTimeoutException:
            raise LinkError(
                f"{self.name} has taken nothing for {WRITE_SECONDS:g} s",
                "reset the board, or plug it in anew",
            ) from None
        except (serial.SerialException, OSError, TypeError) as problem:
            # pyserial raises TypeError where a port was closed while it waited.
            raise LineGoneError(
                f"the line {self.name} is gone: {problem}", "plug it in and start again"
            ) from None

    def write(self, data: bytes) -> None:
        self._do(lambda: self._serial.write(data))

    def read(self, seconds: float) -> bytes:
        def action() -> bytes:
            if _scheme(self.name) == RFC2217:
                return self._poll(seconds)
            self._serial.timeout = seconds
            first = self._serial.read(1)
            self._serial.timeout = 0
            return first + (self._serial.read(READ_BYTES) if first else b"")

        return self._do(action)

    def _poll(self, seconds: float) -> bytes:
        """As :meth:`read`, without another time-out: each would set the port anew, over the network."""
        end = time.monotonic() + seconds
        while True:
            data = b"".join(iter(lambda: self._serial.read(1), b""))
            if data or time.monotonic() >= end:
                return data
            time.sleep(POLL_SECONDS)

    def set_baud(self, baud: int) -> None:
        def action() -> None:
            self._serial.flush()
            self._serial.baudrate = baud

        self._do(action)

    def send_break(self) -> None:
        def action() -> None:
            self._serial.send_break(BREAK_SECONDS)
            # Behind a URL as spy:// it is the port's name that says where it leads.
            if os.path.realpath(str(getattr(self._serial, "port", None) or self.name)).startswith(
                "/dev/pts/"
            ):
                rate, self._serial.baudrate = self._serial.baudrate, self._serial.baudrate // 4
                self._serial.write(b"\0")
                time.sleep(SLOW_SECONDS)
                self._serial.baudrate = rate

        if not self.fixed_rate:
            self._do(action)

    def close(self) -> None:
        # One that is gone may not close any more.
        with contextlib.suppress(serial.SerialException, OSError):
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
      Kept under this name; may be replaced by a line opened anew.
    rate : float
      Faults a byte.
    seed : int or str

    Attributes
    ----------
    going, coming : FaultInjector
      They count the faults.
    """

    def __init__(self, transport: Transport, rate: float, seed: int | str = 1) -> None:
        self.transport = transport
        self.going, self.coming = FaultInjector(rate, f"going {seed}"), FaultInjector(rate, f"coming {seed}")

    @property
    def name(self) -> str:
        """The name of the line behind."""
        return getattr(self.transport, "name", "the line")

    @property
    def fixed_rate(self) -> bool:
        """As that of the line behind."""
        return getattr(self.transport, "fixed_rate", False)

    def write(self, data: bytes) -> None:
        self.transport.write(self.going.damage(data))

    def read(self, seconds: float) -> bytes:
        return self.coming.damage(self.transport.read(seconds))

    def set_baud(self, baud: int) -> None:
        self.transport.set_baud(baud)

    def send_break(self) -> None:
        self.transport.send_break()

    def close(self) -> None:
        self.transport.close()


def baud_of(baud: int | None) -> int | None:
    """
    A rate, or that of ``QUADSHADE_BAUD``, or None.

    Raises
    ------
    LinkError
      The variable is no rate.
    """
    rate = str((os.environ.get("QUADSHADE_BAUD") or "") if baud is None else baud)
    if not rate:
        return None
    if not rate.isdecimal() or not int(rate):
        raise LinkError(f"the baud rate is {rate!r}", "give a whole number")
    return int(rate)


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
        raise LinkError("no port is given", "give sim, auto or a port's name (--port), or set QUADSHADE_PORT")
    if not isinstance(port, str) and not (hasattr(port, "read") and hasattr(port, "write")):
        raise LinkError(
            f"the port is of type {type(port).__name__}", "give a name, a URL or an open serial object"
        )
    return SerialTransport(port, baud_of(baud) or DEFAULT_BAUD)
