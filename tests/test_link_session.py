# SPDX-License-Identifier: Apache-2.0
"""Sessions with a model of the board: scenes, damaged lines, boards that are not, ports that are not."""

from __future__ import annotations

import contextlib
import os
import pty
import select
import threading
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from quadshade.contract.formats import Formats
from quadshade.contract.protocol import SEQUENCES, BoardResetError, LinkError, Opcode, Reason
from quadshade.golden.board import BoardModel
from quadshade.link.faults import FaultInjector
from quadshade.link.frames import Frame, FrameParser, enclosed, sealed
from quadshade.link.planes import read_picture
from quadshade.link.session import MAX_WORDS, Session
from quadshade.link.transport import FaultyTransport, MemoryTransport, SerialTransport, open_transport
from quadshade.packing.pack import pack_primitives
from quadshade.scene import load_scene, parse_camera, project
from quadshade.setup.triangle_setup import setup_triangles
from quadshade.shading import DEFAULT_LIGHTS, Material, sample

WIDTH, HEIGHT = 40, 30


@pytest.fixture(scope="module")
def words() -> np.ndarray:
    """Packed words of a sphere."""
    formats = Formats()
    mesh = load_scene("sphere:168")
    projected = project(mesh, parse_camera("", mesh), WIDTH, HEIGHT, formats)
    triangles = sample(projected, "quadratic", DEFAULT_LIGHTS, Material(), formats)
    return pack_primitives(setup_triangles(triangles, formats), formats, 0.0).words


def undamaged(words: np.ndarray) -> np.ndarray:
    """The picture without a line."""
    board = BoardModel(WIDTH, HEIGHT)
    board.drawing.clear(0x302010)
    board.drawing.triangles(words.tolist())
    return board.drawing.plane(0).copy()


def session_with(board: BoardModel, rate: float = 0, seed: int | str = 1, **options: int) -> Session:
    transport = MemoryTransport(board.feed)
    return Session(FaultyTransport(transport, rate, seed) if rate else transport, **options)


def draw(session: Session, words: np.ndarray) -> np.ndarray:
    """A whole picture over a session."""
    session.connect()
    session.clear(0x302010)
    session.triangles(words)
    session.flush()
    return read_picture(session)


class Recorder(MemoryTransport):
    """Notes the frames of set-up words that are sent, in words, and loses those that it is told to."""

    def __init__(self, board: BoardModel) -> None:
        super().__init__(board.feed)
        self.sizes: list[int] = []
        self.asked: list[Opcode] = []
        self.lost = 0

    def write(self, data: bytes) -> None:
        for frame in FrameParser().feed(data):
            self.asked.append(frame.opcode)
            if frame.opcode is Opcode.TRIANGLES:
                self.sizes.append(len(frame.payload) // 4)
        if self.lost:
            self.lost -= 1
        else:
            super().write(data)


def test_frames_are_halved_by_a_loss_and_doubled_by_sixty_five_that_arrive() -> None:
    for clean, size in ((62, MAX_WORDS // 2), (63, MAX_WORDS)):
        board = BoardModel(WIDTH, HEIGHT)
        line = Recorder(board)
        session = Session(line, answer_seconds=0.01)
        session.connect()
        line.lost = 1
        session.triangles(np.zeros(MAX_WORDS, np.uint32))
        session.flush()
        assert line.sizes == [MAX_WORDS, MAX_WORDS // 2, MAX_WORDS // 2]
        for _ in range(clean):
            session.clear()
            session.flush()
        session.triangles(np.zeros(MAX_WORDS, np.uint32))
        session.flush()
        assert line.sizes[3] == size


def test_a_board_that_was_reset_is_noticed_where_numbers_agree() -> None:
    """After 256 frames both begin with number 0 again: the count of frames tells."""
    board = BoardModel(WIDTH, HEIGHT)
    line = Recorder(board)
    session = Session(line, answer_seconds=0.01)
    session.connect()
    for _ in range(SEQUENCES):
        session.clear()
    session.flush()
    line.asked.clear()
    session.check()
    assert line.asked == [Opcode.STATUS]
    board.feed(Frame(Opcode.RESET, 0, bytes(4)).encode())
    line.lost = 1
    session.clear(0x112233)
    with pytest.raises(BoardResetError, match="lost the session"):
        session.flush()
    assert not board.drawing.words


@pytest.mark.parametrize("bits", [2, 8])
def test_a_board_that_counts_in_few_bits_keeps_its_session(bits: int) -> None:
    """As iCEBreaker: its count of frames wraps long before the host's, which is no reset."""
    board = BoardModel(WIDTH, HEIGHT, most_counter_bits=bits)
    line = Recorder(board)
    session = Session(line, answer_seconds=0.01)
    session.connect()
    for _ in range(2 * SEQUENCES + 3):
        session.clear()
    assert session.check()["frames"] == (2 * SEQUENCES + 3) % (1 << bits)
    line.lost = 1
    session.clear(0x112233)
    session.check()
    assert session.statistics["resent"] == 1
    board.feed(Frame(Opcode.RESET, 0, bytes(4)).encode())
    with pytest.raises(BoardResetError, match="lost the session"):
        session.check()


def test_state_arrives_in_as_few_frames_as_hold_it() -> None:
    board = BoardModel(WIDTH, HEIGHT, Formats(with_shade=1, num_channels=2))
    session = session_with(board)
    session.connect()
    before = dict(board.drawing.registers)
    # 253 words a frame, beside the address.
    session.state(5, np.arange(3 * 253, dtype=np.uint32) + 7)
    assert session.check()["frames"] == 3
    assert board.drawing.registers == before | {5 + index: 7 + index for index in range(3 * 253)}


def test_a_scene_arrives(words: np.ndarray) -> None:
    board = BoardModel(WIDTH, HEIGHT)
    session = session_with(board)
    picture = draw(session, words)
    assert (picture != [0x10, 0x20, 0x30]).any(axis=2).mean() > 0.2
    assert np.array_equal(picture, undamaged(words))
    assert session.statistics["recoveries"] == session.statistics["timeouts"] == 0
    assert session.status()["frames"] == board.counts["frames"] > 10
    assert session.identity["screen_width"] == WIDTH


@pytest.mark.parametrize("rate", [1e-5, 1e-4, 1e-3, 1e-2])
def test_damage_costs_time_and_nothing_else(rate: float, words: np.ndarray, seed: int) -> None:
    expected = undamaged(words)
    session = session_with(BoardModel(WIDTH, HEIGHT), rate, seed, retries=200)
    assert np.array_equal(draw(session, words), expected)
    injected = session.transport.going.total + session.transport.coming.total
    assert injected > 0 or rate < 1e-3


def test_a_line_that_is_too_bad_is_said_to_be(words: np.ndarray, seed: int) -> None:
    board = BoardModel(WIDTH, HEIGHT)
    session = session_with(board)
    session.connect()
    session.transport = FaultyTransport(session.transport, 0.3, seed)
    with pytest.raises(LinkError, match="the link is too bad|no answer to"):
        session.triangles(words)
        session.flush()


def test_words_arrive_once_and_in_order(seed: int) -> None:
    board = BoardModel(WIDTH, HEIGHT, words=512)
    session = session_with(board, 3e-3, seed, retries=200)
    session.connect()
    rng = np.random.default_rng(seed)
    sent = rng.integers(0, 1 << 32, 5000, dtype=np.uint32)
    for part in np.array_split(sent, 7):
        session.triangles(part)
        session.state(5, part[:100])
    session.flush()
    assert board.drawing.words == sent.tolist()
    assert [board.drawing.registers[5 + index] for index in range(100)] == part[:100].tolist()
    assert session.statistics["resent"] > 10


def test_credits_are_kept(words: np.ndarray) -> None:
    board = BoardModel(WIDTH, HEIGHT, words=256)
    board.stalled = True
    session = session_with(board, retries=5)
    session.connect()
    with pytest.raises(LinkError, match="the link is too bad"):
        session.triangles(words)
    assert board.counts["overruns"] == 0
    assert board.fifo.free < 256
    assert board.receiver.expected == board.counts["frames"] > 0


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("magic", 0, "no Quadshade board; is it the right port"),
        ("version", 99, "the board speaks version 99 of the protocol, this host 1; use"),
        (
            "definition",
            0x1234,
            r"the board is of no known release \(00001234\), this is .* \([0-9a-f]{8}\); load",
        ),
    ],
)
def test_other_boards_are_named(field: str, value: int, message: str) -> None:
    board = BoardModel(WIDTH, HEIGHT)
    board.identity = {**board.identity, field: value}
    with pytest.raises(LinkError, match=message):
        session_with(board).connect()
    assert board.session == 0


def test_silence_and_noise_are_no_board(seed: int) -> None:
    noise = FaultInjector(1, seed)
    for feed in (lambda data: b"", lambda data: data, lambda data: noise.damage(bytes(9000)) * 3):
        with pytest.raises(LinkError, match="no answer to HELLO"):
            Session(MemoryTransport(feed), retries=3).connect()


def test_a_reset_meanwhile_is_noticed(words: np.ndarray) -> None:
    board = BoardModel(WIDTH, HEIGHT)
    session = session_with(board)
    session.connect()
    session.triangles(words[:2000])
    session_with(board).connect()
    with pytest.raises(LinkError, match="reset meanwhile|too bad"):
        session.triangles(words)
        session.flush()


def test_refusals_are_errors() -> None:
    session = session_with(BoardModel(WIDTH, HEIGHT))
    session.connect()
    with pytest.raises(LinkError, match=Reason.BAD_FIELD.name.lower().replace("_", " ")):
        session.ask(Opcode.FRAME_CRC, [{"reserved": 0, "plane": 7}])


def test_trace_shows_every_frame() -> None:
    lines: list[str] = []
    session = Session(MemoryTransport(BoardModel(WIDTH, HEIGHT).feed), trace=lines.append)
    session.connect()
    session.clear()
    session.flush()
    hello = "> HELLO, < HELLO_ANSWER"
    # The second one tells that no answer is older than RESET.
    wanted = f"{hello}, > RESET, < RESET_ANSWER, {hello}, > CLEAR, < ACK"
    assert ", ".join(" ".join(line.split()[:2]) for line in lines) == wanted


class PtyBoard:
    """A model of the board behind a pseudo-terminal."""

    def __init__(self) -> None:
        self.board = BoardModel(WIDTH, HEIGHT)
        self.master, self.slave = pty.openpty()
        self.name = os.ttyname(self.slave)
        self.running = True
        self.thread = threading.Thread(target=self.run, daemon=True)
        self.thread.start()

    def run(self) -> None:
        while self.running:
            if select.select([self.master], [], [], 0.05)[0]:
                answer = self.board.feed(os.read(self.master, 4096))
                while answer:
                    answer = answer[os.write(self.master, answer) :]

    def stop(self) -> None:
        self.running = False
        self.thread.join()
        os.close(self.slave)
        os.close(self.master)


def test_over_a_pseudo_terminal(words: np.ndarray, monkeypatch: pytest.MonkeyPatch) -> None:
    far = PtyBoard()
    try:
        monkeypatch.setenv("QUADSHADE_PORT", far.name)
        transport = open_transport()
        # A busy machine may take long; nothing is lost, so nothing times out for long.
        session = Session(transport, answer_seconds=20)
        assert np.array_equal(draw(session, words), undamaged(words))
        session.set_baud(115200)
        with pytest.raises(LinkError, match="another program has .* open; close"):
            SerialTransport(far.name)
        transport.close()
        # The next one finds the board as it is.
        again = Session(SerialTransport(far.name), answer_seconds=20)
        assert again.connect(reset=False)["session"] == far.board.session != 0
        again.transport.close()
    finally:
        far.stop()


def test_ports_that_cannot_be_opened(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("QUADSHADE_PORT", raising=False)
    with pytest.raises(LinkError, match="no port is given; give sim, auto or a port"):
        open_transport()
    with pytest.raises(LinkError, match="is the board plugged in"):
        open_transport(str(tmp_path / "missing"))
    with pytest.raises(LinkError, match="is no serial port"):
        open_transport(str(tmp_path))
    (tmp_path / "file").write_text("")
    with pytest.raises(LinkError, match="is no serial port"):
        open_transport(str(tmp_path / "file"))
    for address in ("socket://", "socket://host", "socket://host:99999", "socket://host:x", "socket://:7777"):
        with pytest.raises(LinkError, match="is no address; write socket://HOST:PORT"):
            open_transport(address)
    with pytest.raises(LinkError, match="no URL that pyserial knows"):
        open_transport("nonsense://port")
    with pytest.raises(LinkError, match="baud rate is 'fast'"):
        monkeypatch.setenv("QUADSHADE_BAUD", "fast")
        open_transport("loop://")


ANSWERS = st.builds(
    lambda opcode, sequence, payload: enclosed(
        sealed(bytes([opcode, sequence]) + len(payload).to_bytes(2, "little") + payload)
    ),
    st.sampled_from([int(opcode) for opcode in Opcode] + [0, 0xFF]),
    st.integers(0, 255),
    st.one_of(st.binary(max_size=80), st.sampled_from([bytes(4), bytes(8), bytes(60)])),
)


@given(st.lists(st.one_of(ANSWERS, st.binary(max_size=40)), max_size=12), st.integers(0, 3))
def test_any_answers_raise_no_other_error(answers: list[bytes], good: int) -> None:
    """A board that answers right a few times, and then anything at all, in frames whose CRCs are right."""
    board = BoardModel(8, 8)
    heard = iter([None] * good + answers)

    def feed(data: bytes) -> bytes:
        said = board.feed(data)
        answer = next(heard, b"")
        return said if answer is None else answer

    session = Session(MemoryTransport(feed), answer_seconds=0.0, retries=4)
    with contextlib.suppress(LinkError):
        session.connect()
        session.clear(1)
        session.triangles(np.arange(40, dtype=np.uint32))
        session.flush()
        session.status()
        read_picture(session)
