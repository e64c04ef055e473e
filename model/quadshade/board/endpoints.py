# SPDX-License-Identifier: Apache-2.0
"""A simulated board's end of the line: a pseudo-terminal, or a TCP socket."""

from __future__ import annotations

import contextlib
import fcntl
import os
import pty
import socket
import struct
import tty
from pathlib import Path

from quadshade.errors import QuadshadeError

READ_BYTES = 4096
MAX_WAITING = 1 << 18
"""Bytes to a host that does not read; what is more is lost, as on a wire."""

TCGETS2, TCSETS2 = 0x802C542A, 0x402C542B
TERMIOS2 = struct.Struct("<4IB19s2I")
CBAUD, BOTHER = 0o010017, 0o010000
"""Linux's calls for any baud rate (asm-generic/termbits.h)."""

LOCALHOST = "127.0.0.1"


class Line:
    """
    Bytes to and from whatever host is there.

    Attributes
    ----------
    name : str
      What a host opens.
    """

    name = ""

    def __init__(self) -> None:
        self._waiting = bytearray()

    def readers(self) -> list[int]:
        """Descriptors that are readable where :meth:`take` has something to do."""
        raise NotImplementedError

    def writers(self) -> list[int]:
        """Descriptors that are writable where :meth:`give` can go on."""
        raise NotImplementedError

    def take(self) -> bytes:
        """What has come, without waiting."""
        raise NotImplementedError

    def rate(self) -> int | None:
        """The host's baud rate, where the line tells."""
        return None

    def give(self, data: bytes = b"") -> None:
        """Send as much as goes, keep the rest."""
        self._waiting += data
        descriptor = next(iter(self.writers()), None)
        if descriptor is not None:
            with contextlib.suppress(BlockingIOError, OSError):
                del self._waiting[: os.write(descriptor, self._waiting)]
        del self._waiting[MAX_WAITING:]

    def close(self) -> None:
        """Give the line up."""
        raise NotImplementedError


class PtyLine(Line):
    """
    A pseudo-terminal; a host's baud rate can be asked for.

    Parameters
    ----------
    path : Path, optional
      A link to the terminal, for a name that is known before. What a board left there that was killed is
      replaced.
    baud : int
      Rate that the terminal has until a host sets one.

    Raises
    ------
    QuadshadeError
      There is something else at the path, or no link can be made.
    """

    def __init__(self, path: Path | None = None, baud: int = 1_000_000) -> None:
        super().__init__()
        self._master, self._slave = pty.openpty()
        tty.setraw(self._slave)
        os.set_blocking(self._master, False)
        self._set_rate(baud)
        self._link = path
        # Held open here, the terminal stays when a host closes it.
        self.name = os.ttyname(self._slave)
        if path is not None:
            try:
                self._make_link(path)
            except (OSError, QuadshadeError) as problem:
                self._link = None
                self.close()
                if isinstance(problem, QuadshadeError):
                    raise
                raise QuadshadeError(
                    f"cannot make {path}: {problem.strerror}", "give another --pty"
                ) from None
            self.name = str(path)

    def _make_link(self, path: Path) -> None:
        if path.is_symlink() and not path.readlink().is_relative_to("/dev/pts"):
            raise QuadshadeError(f"{path} is a link to something else", "give another --pty")
        if path.exists() and not path.is_symlink():
            raise QuadshadeError(f"{path} exists", "give another --pty")
        # Moved into place, so that a host that waits for it finds a whole one.
        temporary = path.with_name(f".{path.name}.{os.getpid()}")
        temporary.symlink_to(os.ttyname(self._slave))
        temporary.replace(path)

    def _set_rate(self, baud: int) -> None:
        parts = list(TERMIOS2.unpack(fcntl.ioctl(self._slave, TCGETS2, bytes(TERMIOS2.size))))
        parts[2] = parts[2] & ~CBAUD | BOTHER
        parts[6] = parts[7] = baud
        fcntl.ioctl(self._slave, TCSETS2, TERMIOS2.pack(*parts))

    def rate(self) -> int | None:
        return TERMIOS2.unpack(fcntl.ioctl(self._master, TCGETS2, bytes(TERMIOS2.size)))[7] or None

    def readers(self) -> list[int]:
        return [self._master]

    def writers(self) -> list[int]:
        return [self._master] if self._waiting else []

    def take(self) -> bytes:
        try:
            return os.read(self._master, READ_BYTES)
        except (BlockingIOError, OSError):
            return b""

    def close(self) -> None:
        if self._link is not None:
            with contextlib.suppress(OSError):
                if self._link.readlink() == Path(os.ttyname(self._slave)):
                    self._link.unlink()
        os.close(self._master)
        os.close(self._slave)


class TcpLine(Line):
    """
    A TCP port for one host at a time: a second one is shown out at once.

    Parameters
    ----------
    port : int
      0 takes a free one.
    host : str
      Address to listen on.

    Raises
    ------
    QuadshadeError
      The port is in use, or must not be used.
    """

    def __init__(self, port: int = 0, host: str = LOCALHOST) -> None:
        super().__init__()
        try:
            # Of a name with several addresses the first one, as with every server that takes one address.
            family, _, _, _, address = socket.getaddrinfo(
                host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
            )[0]
            # With SO_REUSEADDR.
            self._server = socket.create_server(
                address[:2] if family == socket.AF_INET else address, family=family
            )
        except (OSError, OverflowError, UnicodeError) as problem:
            raise QuadshadeError(
                f"cannot listen on {_address(host, port)}: {problem}", "give another --tcp"
            ) from None
        self._server.setblocking(False)
        self._client: socket.socket | None = None
        self.name = f"socket://{_address(host, self._server.getsockname()[1])}"

    def readers(self) -> list[int]:
        return [one.fileno() for one in (self._server, self._client) if one is not None]

    def writers(self) -> list[int]:
        return [self._client.fileno()] if self._client is not None and self._waiting else []

    def take(self) -> bytes:
        data = b""
        if self._client is not None:
            try:
                data = self._client.recv(READ_BYTES)
                gone = not data
            except BlockingIOError:
                gone = False
            except OSError:
                gone = True
            if gone:
                self._hang_up()
        self._welcome()
        return data

    def _welcome(self) -> None:
        """Let a host in, if none is there."""
        try:
            caller, _ = self._server.accept()
        except OSError:
            return
        if self._client is not None:
            caller.close()
            return
        caller.setblocking(False)
        caller.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._client = caller

    def give(self, data: bytes = b"") -> None:
        # Nobody hears what is said while no host is there.
        if self._client is not None:
            super().give(data)

    def _hang_up(self) -> None:
        if self._client is not None:
            self._client.close()
        self._client = None
        self._waiting.clear()

    def close(self) -> None:
        if self._client is not None:
            self._hang_up()
        self._server.close()


def _address(host: str, port: int) -> str:
    """As a URL has it: an IPv6 address in brackets."""
    return f"[{host}]:{port}" if ":" in host else f"{host}:{port}"


def tcp_address(text: str) -> tuple[str, int]:
    """
    Address and port of ``PORT``, ``ADDRESS:PORT`` or ``[IPV6]:PORT``.

    Raises
    ------
    QuadshadeError
      The port is no number up to 65535, or an IPv6 address has no brackets.
    """
    host, colon, port = text.rpartition(":")
    is_bracketed = host.startswith("[") and host.endswith("]")
    host = host[1:-1] if is_bracketed else host
    if not port.isascii() or not port.isdecimal() or int(port) > 65535 or (colon and not host):
        raise QuadshadeError(
            f"the TCP port is {text!r}", "give a number up to 65535, ADDRESS:PORT or [IPV6-ADDRESS]:PORT"
        )
    if (":" in host) != is_bracketed:
        raise QuadshadeError(f"the address is {text!r}", "write an IPv6 address in brackets, as [::1]:7777")
    return host or LOCALHOST, int(port)
