# SPDX-License-Identifier: Apache-2.0
"""``quadshade view``: states against the command line, the server against who should not see it."""

from __future__ import annotations

import asyncio
import json
import shlex
import signal
import struct
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import aiohttp
import numpy as np
import pytest
from click.testing import CliRunner

import quadshade
from quadshade.cli.main import main
from quadshade.errors import QuadshadeError
from quadshade.image import read_picture
from quadshade.view import Viewed, ViewState
from quadshade.view.board import ViewedBoard
from quadshade.view.server import LARGEST_MESSAGE
from tests.support.served_view import SMALL, Served, orange_torus

STATES: tuple[dict[str, Any], ...] = (
    {},
    {"yaw": 200.5, "pitch": -70, "zoom": 2.25, "across": 0.3, "along": -0.2, "exponent": 50},
    {"light": True, "light_x": 0.6, "light_y": -0.3, "shading": "gouraud"},
    {"light": True, "light_x": -1, "light_y": 1, "shading": "quadratic-specular", "exponent": 7},
    {"fit": "least-squares", "zoom": 0.5},
    {"max_error": 2.5},
    {"lod": 150, "shading": "gouraud"},
    {"frame_ms": 90, "baud": 460800, "max_error": 2.5},
    {"shading": "phong"},
)


@pytest.fixture(scope="module")
def viewed() -> Viewed:
    return orange_torus()


@pytest.mark.parametrize("given", STATES)
def test_the_command_line_of_a_state_draws_it(tmp_path: Path, monkeypatch, viewed, given) -> None:
    state = ViewState.read(SMALL | given)
    shown = viewed.show(state, True)
    monkeypatch.chdir(tmp_path)
    words = shlex.split(shown.figures["command"])
    assert words[0] == "quadshade"
    result = CliRunner().invoke(main, [*words[1:], "--engine", "model", "--stats", "stats.json"])
    assert result.exit_code == 0, result.output
    assert (read_picture(Path("picture.png")) == shown.image).all()
    stats = json.loads(Path("stats.json").read_text())
    figures = shown.figures
    assert figures["triangles"] == len(viewed.picture(state).triangles)
    if state.is_reference:
        assert figures["bytes"] is None and figures["largest_error"] == 0
        return
    assert figures["bytes"] == 4 * stats["words"] and figures["clocks"] == stats["clocks"]
    compared = viewed.picture(state).error_to("phong")
    assert figures["largest_error"] == compared.largest_error
    assert figures["rms_error"] == pytest.approx(compared.rms)
    assert figures["line_fps"] == pytest.approx(state.baud / 10 / figures["line_bytes"])
    if state.frame_ms:
        timing = stats["timing"]
        assert 0.95 * timing["deadline"] < timing["clocks_whole"] <= timing["deadline"] == 9_000_000
        # What the line carries in 90 ms at 460800 baud.
        assert 0.95 * 4147 < figures["line_bytes"] <= 4147 and timing["baud"] == 460_800
    assert sum(figures["orders"].values()) == figures["triangles"]


def test_the_first_state_is_the_picture_of_render() -> None:
    viewed = Viewed("sphere:168", quadshade.load_scene("sphere:168"))
    shown = viewed.show(ViewState.read(SMALL), False).image
    expected = quadshade.render("sphere:168", size=(64, 48), engine="model").array
    # The same view by its eye, not by its direction: a vertex may move by a sub-pixel.
    assert np.abs(shown.astype(int) - expected).mean() < 0.5


def test_maps_show_errors_orders_and_triangles(viewed: Viewed) -> None:
    picture = viewed.show(ViewState.read(SMALL), False).image
    errors = viewed.show(ViewState.read(SMALL | {"map": "error"}), False)
    assert errors.figures["largest_error"] is not None
    orders = viewed.show(ViewState.read(SMALL | {"map": "orders", "max_error": 8}), False)
    wires = viewed.show(ViewState.read(SMALL | {"map": "wireframe"}), False).image
    lines = (wires == 255).all(axis=2)
    assert 0.1 < lines.mean() < 0.9 and (wires[~lines] == picture[~lines]).all()
    assert len(orders.figures["orders"]) > 1
    assert not (orders.image == picture).all() and not (errors.image == picture).all()
    exact = viewed.show(ViewState.read(SMALL | {"map": "error", "shading": "phong"}), False).image
    assert len(np.unique(exact.reshape(-1, 3), axis=0)) == 1


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"spin": 1}, "no setting 'spin'"),
        ({"zoom": 0}, "zoom is"),
        ({"zoom": "nan"}, "zoom is"),
        ({"width": 1e9}, "width is"),
        ({"width": 100.5}, "width is"),
        ({"pitch": 90}, "pitch is"),
        ({"exponent": None}, "exponent is"),
        ({"exponent": [1]}, "exponent is"),
        ({"shading": "../x"}, "the shading is"),
        ({"fit": {}}, "the fit is"),
        ({"light": 2}, "light is"),
        ([], "no object"),
    ],
)
def test_a_state_is_checked(given: Any, said: str) -> None:
    with pytest.raises(QuadshadeError, match=said):
        ViewState.read(given)


def test_a_state_is_a_link() -> None:
    state = ViewState.read({"yaw": 3.25, "light": True, "light_x": 0.5, "shading": "gouraud", "width": 320})
    texts = {
        name: str(value).lower() if isinstance(value, bool) else str(value)
        for name, value in state.content().items()
    }
    assert ViewState.read(texts) == state


# The server.


@pytest.fixture(scope="module")
def served(viewed: Viewed) -> Iterator[Served]:
    running = Served(viewed)
    yield running
    running.close()


def read(message: bytes) -> tuple[dict, dict, np.ndarray]:
    """Figures, state and pixels of a binary message."""
    (length,) = struct.unpack_from("<I", message)
    content = json.loads(message[4 : 4 + length])
    state = content["state"]
    pixels = np.frombuffer(message[4 + length :], np.uint8).reshape(state["height"], state["width"], 4)
    return content["figures"], state, pixels


async def fetch(link: str, **headers: str) -> tuple[int, str, dict[str, str]]:
    async with aiohttp.ClientSession() as session, session.get(link, headers=headers) as answer:
        return answer.status, await answer.text(), dict(answer.headers)


def test_only_the_link_opens_the_page(served: Served) -> None:
    link, address = served.server.link, served.server.address
    status, text, headers = asyncio.run(fetch(link))
    assert status == 200 and "view.js" in text
    assert (
        "default-src 'none'" in headers["Content-Security-Policy"] and headers["Cache-Control"] == "no-store"
    )
    assert asyncio.run(fetch(f"{link}view.js"))[0] == 200
    for name in ("state.py", "../state.py", "..%2Fstate.py", "index.html", "view.css.map", "%2e%2e/"):
        assert asyncio.run(fetch(link + name))[0] in (403, 404)
    assert asyncio.run(fetch(f"http://{address}/wrong/"))[0] == 404
    assert asyncio.run(fetch(f"http://{address}/"))[0] in (403, 404)
    assert asyncio.run(fetch(link, Host="evil.example"))[0] == 403
    assert asyncio.run(fetch(link, Origin="http://evil.example"))[0] == 403
    assert served.server.token not in asyncio.run(fetch(f"http://{address}/wrong/"))[1]


async def converse(served: Served, texts: list[str], origin: str | None = "", wait: float = 4) -> list[Any]:
    """Send messages at once and gather all answers until none comes."""
    server = served.server
    headers = {} if origin is None else {"Origin": origin or f"http://{server.address}"}
    answers: list[Any] = []
    address = f"{server.link}socket"
    async with (
        aiohttp.ClientSession() as session,
        session.ws_connect(address, headers=headers, max_msg_size=0) as socket,
    ):
        for text in texts:
            await socket.send_str(text)
        while True:
            message = await socket.receive(wait)
            if message.type is aiohttp.WSMsgType.BINARY:
                answers.append(read(message.data))
                if answers[-1][0]["largest_error"] is not None:
                    return answers
            elif message.type is aiohttp.WSMsgType.TEXT:
                answers.append(json.loads(message.data))
                if "error" in answers[-1]:
                    return answers
            else:
                return [*answers, message.type]
    return answers


@pytest.mark.parametrize("origin", [None, "http://evil.example", "null"])
def test_another_site_gets_no_socket(served: Served, origin: str | None) -> None:
    with pytest.raises(aiohttp.WSServerHandshakeError):
        asyncio.run(converse(served, [], origin))


def test_the_latest_state_wins_and_is_measured(served: Served, viewed: Viewed) -> None:
    before = served.server.drawn
    texts = [json.dumps(SMALL | {"yaw": angle}) for angle in range(300)]
    about, *answers = asyncio.run(converse(served, texts))
    assert about["state"] == ViewState.read(SMALL).content() and about["about"]["scene"] == "torus:288"
    figures, state, pixels = answers[-1]
    assert state["yaw"] == 299 and figures["largest_error"] is not None
    assert (pixels[..., :3] == viewed.show(ViewState.read(state), True).image).all()
    assert (pixels[..., 3] == 255).all()
    assert served.server.drawn - before < 100, "a queue has grown"


@pytest.mark.parametrize("text", ["{", '{"spin": 1}', "[1]", '{"width": 99999}', "[" * 9000])
def test_what_is_no_state_is_said(served: Served, text: str) -> None:
    answer = asyncio.run(converse(served, [text]))[-1]
    assert answer["error"] and len(answer["error"]) < 300


def test_a_message_is_bounded(served: Served) -> None:
    assert asyncio.run(converse(served, ["x" * (LARGEST_MESSAGE + 1)]))[-1] is aiohttp.WSMsgType.CLOSE


def test_viewers_leave_nothing_behind(served: Served) -> None:
    async def two() -> None:
        await asyncio.gather(*(converse(served, [json.dumps(SMALL | {"yaw": a})]) for a in (1, 2)))

    asyncio.run(two())
    for _ in range(100):
        if not served.server.viewers:
            break
        threading.Event().wait(0.05)
    assert not served.server.viewers


def test_a_board_draws_it_too_and_a_difference_stops_it(viewed: Viewed, monkeypatch) -> None:
    with quadshade.Board("sim", engine="model") as opened:
        board = ViewedBoard(opened, viewed)
        state = ViewState.read({"width": 48, "height": 40})
        assert board.draw(state) == {"text": "CRC equal, 48x40", "goes_on": True}
        assert board.draw(ViewState.read({"shading": "phong"}))["goes_on"]
        monkeypatch.setattr(type(opened), "verify", lambda *_: 0)
        monkeypatch.setattr(
            type(opened), "read", lambda *_: (_ for _ in ()).throw(QuadshadeError("CRC differs"))
        )
        said = board.draw(state)
        assert not said["goes_on"] and "CRC differs" in said["text"]
        monkeypatch.undo()
        assert board.draw(state) == said


# The command.


def test_the_command_serves_until_it_is_interrupted(tmp_path: Path) -> None:
    words = [sys.executable, "-m", "quadshade", "view", "sphere:24", "--no-open", "--size", "32x32"]
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        line = process.stdout.readline()
        assert line.startswith("open http://127.0.0.1:")
        assert asyncio.run(fetch(line.split()[1]))[0] == 200
        process.send_signal(signal.SIGINT)
        assert process.wait(30) == 0
        assert process.stderr is not None and "Traceback" not in process.stderr.read()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("none.obj",), "cannot read none.obj"),
        (("sphere:24", "--listen", "8000"), "--listen is '8000'"),
        (("sphere:24", "--listen", "127.0.0.1:99999"), "--listen is"),
        (("sphere:24", "--listen", "256.0.0.1:0"), "cannot listen at"),
        (("sphere:24", "--size", "4096x4096"), "width is"),
        (("sphere:24", "--material", "shine=1"), "unknown key 'shine'"),
        (("sphere:24", "--port", "/dev/ttyNONE"), "there is no port"),
    ],
)
def test_bad_input_is_one_line(words: tuple[str, ...], said: str) -> None:
    result = CliRunner().invoke(main, ["view", *words, "--no-open"])
    assert result.exit_code == 2 and said in result.output
    assert len(result.output.strip().splitlines()) == 1
