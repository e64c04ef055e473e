# SPDX-License-Identifier: Apache-2.0
"""Parts of the link: a serial port's object, the kinds of faults, session numbers, a line that is lost."""

from __future__ import annotations

import secrets

import pytest
import serial

from quadshade.contract.protocol import LineGoneError, LinkError
from quadshade.golden.board import BoardModel
from quadshade.link.exchange import RECONNECTS
from quadshade.link.faults import MAX_RUN, FaultInjector
from quadshade.link.session import Session
from quadshade.link.transport import BREAK_SECONDS, MemoryTransport, SerialTransport


class Port:
    """What pyserial gives for a port that is no pseudo-terminal, and what was asked of it."""

    port = "/dev/ttyUSB0"

    def __init__(self) -> None:
        self.asked: list[tuple[object, ...]] = []

    def __setattr__(self, name: str, value: object) -> None:
        if name != "asked":
            self.asked.append((name, value))
        super().__setattr__(name, value)

    def set_low_latency_mode(self, on: bool) -> None:
        self.asked.append(("low_latency", on))

    def send_break(self, seconds: float) -> None:
        self.asked.append(("break", seconds))

    def flush(self) -> None:
        self.asked.append(("flush",))

    def write(self, data: bytes) -> None:
        self.asked.append(("write", data))

    def read(self, count: int) -> bytes:
        self.asked.append(("read", count))
        return b"a" if count == 1 else b"bc"


def test_a_break_is_sent_once_and_long_enough() -> None:
    port = Port()
    SerialTransport(port).send_break()
    assert port.asked == [("break", BREAK_SECONDS)]


def test_what_was_written_leaves_before_the_rate_changes() -> None:
    port = Port()
    SerialTransport(port).set_baud(9600)
    assert port.asked == [("flush",), ("baudrate", 9600)]


def test_a_read_waits_for_the_first_byte_only() -> None:
    port = Port()
    assert SerialTransport(port).read(0.5) == b"abc"
    (first, one, second, (what, count)) = port.asked
    assert (first, one, second) == (("timeout", 0.5), ("read", 1), ("timeout", 0))
    assert what == "read" and count > 1


def test_a_port_is_opened_so_that_a_read_does_not_wait(monkeypatch: pytest.MonkeyPatch) -> None:
    given: dict[str, object] = {}
    port = Port()

    def opened(name: str, **options: object) -> Port:
        given.update(options, port=name)
        return port

    monkeypatch.setattr(serial, "serial_for_url", opened)
    SerialTransport("/dev/null", 123)
    assert port.asked == [("low_latency", True)] and given["port"] == "/dev/null"
    assert given["timeout"] == 0 and given["baudrate"] == 123 and given["exclusive"] is True
    assert 0 < given["write_timeout"] <= 60


@pytest.mark.parametrize("kind", FaultInjector.KINDS)
def test_each_kind_of_fault_is_what_its_name_says(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Over many runs: nothing else is changed, and every length and every bit comes up."""
    monkeypatch.setattr(FaultInjector, "KINDS", (kind,))
    sent = bytes(range(200, 250)) * 2
    seen = set()
    for seed in range(1200):
        injector = FaultInjector(1e-9, seed)
        injector._clean = 3
        got = injector.damage(sent)
        assert injector.injected == {kind: 1}
        same = next((i for i, (a, b) in enumerate(zip(sent, got, strict=False)) if a != b), len(got))
        assert same >= 3
        if kind == "flip":
            bits = [a ^ b for a, b in zip(sent, got, strict=True)]
            assert bits[:3] == [0] * 3 and not any(bits[4:]) and bits[3].bit_count() == 1
            seen.add(bits[3])
        elif kind == "drop":
            assert got == sent[:3] + sent[4:]
        elif kind == "double":
            assert got == sent[:4] + sent[3:]
        elif kind == "insert":
            assert got[:3] + got[4:] == sent and len(got) == len(sent) + 1
            seen.add(got[3])
        elif kind == "cut":
            lost = len(sent) - len(got)
            assert got == sent[:3] + sent[3 + lost :]
            seen.add(lost)
        else:
            assert len(got) == len(sent) and got[3 + MAX_RUN :] == sent[3 + MAX_RUN :]
            seen.add(max(i for i, (a, b) in enumerate(zip(sent, got, strict=True)) if a != b) - 2)
    every = {
        "flip": {1 << bit for bit in range(8)},
        "drop": set(),
        "double": set(),
        "cut": set(range(2, MAX_RUN + 1)),
    }
    if kind in every:
        assert seen == every[kind]
    elif kind == "insert":
        assert min(seen) < 5 and max(seen) > 250
    else:
        # A burst's random byte may happen to be the one that was sent, so a run can look shorter.
        assert max(seen) == MAX_RUN and set(range(2, MAX_RUN + 1)) <= seen


def test_gaps_between_faults_have_the_asked_mean() -> None:
    injector = FaultInjector(0.02, 3)
    injector.damage(bytes(200_000))
    # Runs of 21 bytes come with a third of the faults; five standard deviations about the mean.
    expected = 200_000 / (50 + 7)
    assert abs(injector.total - expected) < 5 * expected**0.5
    assert FaultInjector(0, 1).damage(bytes(1000)) == bytes(1000)


def test_a_session_number_is_never_zero(monkeypatch: pytest.MonkeyPatch) -> None:
    """0 is what a board has after its reset."""
    monkeypatch.setattr(secrets, "randbits", lambda bits: 0)
    board = BoardModel(8, 6)
    session = Session(MemoryTransport(board.feed))
    session.connect()
    assert session.number == 1 == session.identity["session"]


class Gone(MemoryTransport):
    """A line that vanishes with every HELLO, for some times."""

    left = 0

    def write(self, data: bytes) -> None:
        if Gone.left:
            Gone.left -= 1
            raise LineGoneError("the line is gone", "plug it in")
        super().write(data)


@pytest.mark.parametrize("times", (1, RECONNECTS, RECONNECTS + 1))
def test_a_line_that_vanishes_is_opened_some_times_again(times: int) -> None:
    board = BoardModel(8, 6)
    session = Session(MemoryTransport(board.feed))
    session.connect()
    session.clear(5)
    opened: list[Gone] = []

    def reopen() -> Gone:
        opened.append(Gone(board.feed))
        return opened[-1]

    session.reopen = reopen
    session.transport = Gone(board.feed)
    Gone.left = times
    if times > RECONNECTS:
        with pytest.raises(LineGoneError):
            session.status()
        assert len(opened) == RECONNECTS
    else:
        assert session.status()["frames"] == board.counts["frames"]
        assert len(opened) == times
        assert session.statistics["reconnects"] == 1
    Gone.left = 0


class RatedLine(MemoryTransport):
    """Notes rates and breaks; at more than ``most`` baud nothing arrives."""

    def __init__(self, board: BoardModel, most: int) -> None:
        super().__init__(board.feed)
        self.most, self.rates, self.breaks = most, list[int](), 0

    def write(self, data: bytes) -> None:
        if not self.rates or self.rates[-1] <= self.most:
            super().write(data)

    def set_baud(self, baud: int) -> None:
        self.rates.append(baud)

    def send_break(self) -> None:
        self.breaks += 1


def test_a_rate_that_is_not_heard_is_taken_back() -> None:
    line = RatedLine(BoardModel(8, 8), most=1_500_000)
    session = Session(line, answer_seconds=0.001, retries=1)
    session.connect()
    session.set_baud(115200)
    assert (line.rates, line.breaks) == ([115200], 0)
    with pytest.raises(LinkError, match="does not answer at 2000000 baud"):
        session.set_baud(2_000_000)
    # The board's rate after a break, in whole steps of its clock's phase.
    assert (line.rates, line.breaks) == ([115200, 2_000_000, 999_999], 1)


def test_a_line_of_one_rate_keeps_it() -> None:
    line = RatedLine(BoardModel(8, 8), most=1_500_000)
    line.fixed_rate = True
    session = Session(line)
    session.connect()
    with pytest.raises(LinkError, match="the baud rate of memory cannot be changed"):
        session.set_baud(115200)
    assert not line.rates


def test_statistics_count_what_passed_the_line() -> None:
    """And an ACK that comes before the answer that is waited for is not lost."""
    line = MemoryTransport(BoardModel(8, 8).feed)
    passed = {"sent": 0, "bytes_sent": 0, "bytes_received": 0}
    write, read = line.write, line.read

    def counted_write(data: bytes) -> None:
        passed["sent"] += 1
        passed["bytes_sent"] += len(data)
        write(data)

    def counted_read(seconds: float) -> bytes:
        data = read(seconds)
        passed["bytes_received"] += len(data)
        return data

    line.write, line.read = counted_write, counted_read
    session = Session(line, answer_seconds=0.01)
    session.connect()
    session.clear()
    assert session.status()["frames"] == 1
    session.flush()
    # Three that begin a session, CLEAR and STATUS, and an answer each.
    assert session.statistics == passed | {"received": 5} and passed["sent"] == 5
