# SPDX-License-Identifier: Apache-2.0
"""A budget of bytes on the line: what a session really sends is no more, and nearly as much."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from click.testing import CliRunner
from cobs import cobs

import quadshade
from quadshade.board import BoardSettings
from quadshade.cli.main import main
from quadshade.contract.formats import Formats
from quadshade.contract.protocol import MAX_PAYLOAD, Opcode
from quadshade.errors import QuadshadeError
from quadshade.golden.board import BoardModel
from quadshade.link.frames import Frame, FrameParser
from quadshade.link.session import Session
from quadshade.link.transport import MemoryTransport
from quadshade.packing import read_frame_file
from quadshade.packing.line import frame_bytes, frames_bytes

DRAWING = (Opcode.CLEAR, Opcode.STATE, Opcode.TRIANGLES)
SIZE = (96, 96)
LEAST_USED = 0.95


class Line:
    """What a board's session writes, and the bytes of the frames that draw."""

    def __init__(self, transport: object) -> None:
        self.transport, self.data = transport, b""

    def __getattr__(self, name: str) -> object:
        return getattr(self.transport, name)

    def write(self, data: bytes) -> None:
        self.data += data
        self.transport.write(data)

    def drawn(self) -> int:
        frames = FrameParser().feed(self.data)
        return sum(len(frame.encode()) for frame in frames if frame.opcode in DRAWING)


def drawn_bytes(core: dict[str, int], **keywords: object) -> int:
    """Bytes that draw a picture on a simulated board, counted on its line."""
    settings = BoardSettings(Formats().with_generics(core), *SIZE)
    with quadshade.Board("sim", settings=settings, engine="model") as board:
        line = Line(board.session.transport)
        board.session.transport = line
        picture = quadshade.render(port=board, size=SIZE, **keywords)
        assert line.drawn() <= picture.stats.adaptive["line_bytes"]
        return line.drawn()


SPECULAR = {"with_shade": 1, "num_channels": 3, "num_specular": 1}
NO_DEPTH = {"with_depth": 0, "depth_bits": 1, "num_channels": 1}


@pytest.mark.parametrize(
    ("scene", "core", "budget", "more"),
    [
        ("torus:288", SPECULAR, 6300, {}),
        ("torus:288", {}, 12000, {"error_measure": "rms"}),
        ("torus:288", {}, 9000, {"error_measure": "rms", "pack_error": 0.0}),
        ("torus:288", {"with_depth": 0}, 9000, {"error_measure": "rms"}),
        ("torus:288", {}, 30000, {"error_measure": "rms", "supersample": 2}),
        ("sphere:168", SPECULAR, 3200, {"error_measure": "rms", "verify": False}),
    ],
    ids=["cosines", "colours", "exact words", "no depth", "four frames", "estimated"],
)
def test_the_line_carries_the_budget(scene: str, core: dict, budget: int, more: dict) -> None:
    used = drawn_bytes(core, scene=scene, exponent=50, budget=f"{budget}line", **more)
    assert LEAST_USED * budget <= used <= budget


def test_more_on_the_line_is_less_error() -> None:
    errors = []
    for budget in (5000, 7000, 10000):
        picture = quadshade.render(
            "torus:288", size=SIZE, engine="model", budget=(budget, "line"), error_measure="rms"
        )
        adaptive = picture.stats.adaptive
        assert LEAST_USED * budget <= adaptive["line_bytes"] <= budget
        errors.append(adaptive["measured_rms"])
    assert errors == sorted(errors, reverse=True) and errors[0] > errors[-1]


def test_a_packed_picture_keeps_it(tmp_path: Path) -> None:
    """With the error of packing that ``pack`` is asked for, not that of a board."""
    for error in (0.0, 0.25):
        path = tmp_path / "packed.qs"
        arguments = ["pack", "torus:288", "-o", path, "--size", "96x96", "--pack-error", error]
        arguments += ["--budget", "7000line", "--error-measure", "rms"]
        run = CliRunner().invoke(main, list(map(str, arguments)))
        assert run.exit_code == 0, run.output
        frame = read_frame_file(path)
        session = Session(MemoryTransport(BoardModel(*SIZE, frame.formats).feed))
        session.connect()
        before = session.statistics["bytes_sent"]
        frame.send(session)
        session.flush()
        used = session.statistics["bytes_sent"] - before
        assert LEAST_USED * 7000 <= used <= 7000
        said = re.search(r"line +at most (\d+) bytes", run.output)
        assert said is not None and used <= int(said[1]) <= 7000


@pytest.mark.parametrize("payload", [4, 240, 244, 248, 500, 504, MAX_PAYLOAD])
def test_a_frame_is_never_longer_than_counted(payload: int) -> None:
    """The longest is one without zeros; COBS adds a byte for every run of 254."""
    worst = Frame(Opcode.TRIANGLES, 1, b"\x01" * payload)
    body = worst.body()
    full = bytes(byte or 1 for byte in body)
    assert len(cobs.encode(full)) + 2 == frame_bytes(payload)
    assert frame_bytes(payload) - 4 - len(full) // 254 <= len(worst.encode()) <= frame_bytes(payload)


@pytest.mark.parametrize("first", [0, 4])
def test_words_fill_frames_before_another_begins(first: int) -> None:
    most = (MAX_PAYLOAD - first) // 4
    for words in (0, 1, most - 1, most, most + 1, 3 * most, 3 * most + 2):
        frames = [min(most, words - at) for at in range(0, words, most)]
        assert frames_bytes(words, first) == sum(frame_bytes(first + 4 * size) for size in frames)


def test_a_budget_that_pays_for_nothing_is_refused() -> None:
    with pytest.raises(QuadshadeError, match=r"the budget is 40 bytes on the line.* takes \d+: give more"):
        quadshade.render("torus:288", size=SIZE, engine="model", budget="40line")
    with pytest.raises(QuadshadeError, match="stream_width is 64"):
        quadshade.render(
            "torus:288", size=SIZE, engine="model", budget="9000line", generics={"stream_width": 64}
        )
