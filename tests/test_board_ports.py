# SPDX-License-Identifier: Apache-2.0
"""Every way to a board that a user can name: pyserial's URLs, RFC 2217 servers, IPv6; and each wrong name."""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest
import serial
from click.testing import CliRunner
from serial.rfc2217 import PortManager

from quadshade.board import Board, BoardSettings, SimulatedBoard
from quadshade.board.endpoints import PtyLine, TcpLine, tcp_address
from quadshade.board.engines import start_engine
from quadshade.cli.main import main
from quadshade.contract.protocol import LinkError
from quadshade.errors import QuadshadeError
from quadshade.link.transport import SerialTransport
from quadshade.scene import fit_camera, load_scene, project
from quadshade.shading.sample import sample

SMALL = BoardSettings(screen_width=16, screen_height=12)


@contextmanager
def simulated(line: PtyLine | TcpLine) -> Iterator[str]:
    """A board in its golden model behind a line; what a host opens."""
    with SimulatedBoard(line, start_engine("model", SMALL)).start() as board:
        yield board.name


class Pty(serial.Serial):
    """A pseudo-terminal, which has no modem lines, as a port that has them."""

    cts = dsr = ri = cd = False

    def _update_dtr_state(self) -> None:
        pass

    _update_rts_state = _update_dtr_state


class Server(threading.Thread):
    """An RFC 2217 server for one host, between a TCP port and a serial one: pyserial's own protocol."""

    def __init__(self, port: str) -> None:
        super().__init__(daemon=True)
        self.serial = Pty(port, 1_000_000, timeout=0.01)
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.url = f"rfc2217://localhost:{self.listener.getsockname()[1]}"
        self.rates: list[int] = []
        self.ended = False

    def write(self, data: bytes) -> None:
        """What the manager answers."""
        self.host.sendall(data)

    def run(self) -> None:
        self.host, _ = self.listener.accept()
        manager = PortManager(self.serial, self)
        sender = threading.Thread(target=self._send, args=(manager,), daemon=True)
        sender.start()
        while not self.ended and (data := self.host.recv(1024)):
            self.serial.write(b"".join(manager.filter(data)))
            self.rates.append(self.serial.baudrate)
        self.ended = True
        sender.join()
        self.serial.close()

    def _send(self, manager: PortManager) -> None:
        while not self.ended:
            if data := self.serial.read(self.serial.in_waiting or 1):
                self.host.sendall(b"".join(manager.escape(data)))

    def hang_up(self) -> None:
        """As a machine that is switched off."""
        self.ended = True
        self.host.shutdown(socket.SHUT_RDWR)
        self.host.close()


def draw(port: str, **options: object) -> np.ndarray:
    """A picture drawn by the board at a port, whose CRC has been checked."""
    with Board(port, notice=str, **options) as board:
        mesh = load_scene("sphere:2x3")
        projected = project(mesh, fit_camera(mesh), 16, 12, board.host_formats)
        board.draw(sample(projected, "quadratic", formats=board.host_formats))
        return board.read()


def run(*arguments: str) -> tuple[int, str]:
    result = CliRunner().invoke(main, list(arguments))
    return result.exit_code, result.output


def test_urls_of_a_local_port_draw_one_picture() -> None:
    pictures = []
    with simulated(PtyLine()) as port:
        for url in (port, f"spy://{port}?file=/dev/null", f"alt://{port}?class=PosixPollSerial"):
            pictures.append(draw(url))
    assert pictures[0].any()
    assert all(np.array_equal(picture, pictures[0]) for picture in pictures)


def test_an_rfc2217_server_draws_and_follows_the_rate() -> None:
    with simulated(PtyLine()) as port:
        server = Server(port)
        server.start()
        assert draw(server.url, baud=500_000).any()
        server.join(10)
    assert not server.is_alive()
    assert server.rates[0] == 1_000_000 and server.rates[-1] == 500_000


def test_info_over_rfc2217() -> None:
    with simulated(PtyLine()) as port:
        server = Server(port)
        server.start()
        code, output = run("info", "--port", server.url)
        assert code == 0, output
        assert f"at {server.url}" in output and "screen_width" in output


def test_an_rfc2217_server_that_goes_away_is_a_line_that_is_gone() -> None:
    with simulated(PtyLine()) as port:
        server = Server(port)
        server.start()
        line = SerialTransport(server.url)
        server.hang_up()
        end = time.monotonic() + 10
        with pytest.raises(LinkError, match=f"the line {server.url} is gone"):
            while time.monotonic() < end:
                line.read(0.01)
        line.close()


def test_an_rfc2217_server_without_a_board_is_said() -> None:
    line = PtyLine()
    server = Server(line.name)
    server.start()
    code, output = run("info", "--port", server.url, "--timeout", "0.01")
    assert code == 2 and "no answer to HELLO on rfc2217://" in output
    line.close()


def test_a_server_of_another_protocol_is_said() -> None:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        url = f"rfc2217://localhost:{listener.getsockname()[1]}?timeout=0.2"
        code, output = run("info", "--port", url)
    assert code == 2 and output.count("\n") == 1
    assert "Remote does not seem to support RFC2217" in output


@pytest.mark.skipif(not socket.has_ipv6, reason="no IPv6 here")
def test_ipv6() -> None:
    host, port = tcp_address("[::1]:0")
    with simulated(TcpLine(port, host)) as url:
        assert url.startswith("socket://[::1]:")
        assert draw(url).any()


@pytest.mark.parametrize(
    ("text", "address"),
    [
        ("7777", ("127.0.0.1", 7777)),
        ("0.0.0.0:1", ("0.0.0.0", 1)),
        ("localhost:0", ("localhost", 0)),
        ("[::1]:7777", ("::1", 7777)),
        ("[fe80::1%lo]:1", ("fe80::1%lo", 1)),
    ],
)
def test_addresses(text: str, address: tuple[str, int]) -> None:
    assert tcp_address(text) == address


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("::1", "write an IPv6 address in brackets, as"),
        ("::1:7777", "write an IPv6 address in brackets, as"),
        ("[::1]", "the TCP port is '\\[::1\\]'"),
        ("[]:1", "the TCP port is"),
        ("[localhost]:1", "in brackets"),
        (":1", "the TCP port is"),
        ("70000", "give a number up to 65535"),
        ("٣", "give a number up to 65535"),
    ],
)
def test_wrong_addresses(text: str, message: str) -> None:
    with pytest.raises(QuadshadeError, match=message):
        tcp_address(text)


@pytest.mark.parametrize("host", ["nowhere.invalid", "192.0.2.1", "::2", "a" * 70])
def test_addresses_that_are_not_here(host: str) -> None:
    with pytest.raises(QuadshadeError, match="cannot listen on .*; give another --tcp"):
        TcpLine(0, host)


@pytest.mark.parametrize(
    ("port", "message"),
    [
        ("loop://", "no Quadshade board answers on loop://"),
        ("loop://?logging=x", "cannot open loop://?logging=x: 'x'"),
        ("loop://?moon", "cannot open loop://?moon: "),
        ("spy:///dev/ttyUSB99", "there is no port spy:///dev/ttyUSB99"),
        ("spy://", "there is no port spy://"),
        ("alt:///dev/ttyUSB99?class=Moon", "cannot open alt:///dev/ttyUSB99?class=Moon: "),
        ("hwgrep://(", "cannot open hwgrep://(: missing )"),
        ("hwgrep://moon-and-stars", "no ports found matching regexp 'moon-and-stars'"),
        ("socket://[::1", "is no address; write socket://HOST:PORT"),
        ("socket://[::1]:1", "no board listens on socket://[::1]:1"),
        ("rfc2217://localhost", "is no address; write rfc2217://HOST:PORT"),
        ("rfc2217://localhost:1", "no server listens on rfc2217://localhost:1"),
        ("rfc2217://localhost:1?timeout=x", "could not convert string to float"),
        ("RFC2217://localhost", "is no address"),
        ("moon://x", "no URL that pyserial knows"),
        ("/dev/null", "is no serial port"),
    ],
)
def test_wrong_ports(port: str, message: str) -> None:
    code, output = run("info", "--port", port, "--timeout", "0.01")
    assert code == 2 and output.count("\n") == 1, output
    assert message in output and "; " in output


def test_one_program_at_a_time_has_a_port() -> None:
    with simulated(PtyLine()) as port:
        line = SerialTransport(f"spy://{port}?file=/dev/null")
        with pytest.raises(LinkError, match="another program has"):
            SerialTransport(f"alt://{port}")
        line.close()
