# SPDX-License-Identifier: Apache-2.0
"""``quadshade view``: a scene in the browser."""

from __future__ import annotations

import asyncio
import signal
import webbrowser
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any

import click

from quadshade.cli.interrupts import leave_at_once
from quadshade.cli.options import TitledCommand, add_options, complete_file, is_given, option
from quadshade.cli.port_options import TITLE, port_options, with_board
from quadshade.cli.scene_options import VERIFY_BOARD, verify_options
from quadshade.cli.terminal import reporting
from quadshade.errors import QuadshadeError

if TYPE_CHECKING:
    from quadshade.view.server import ViewServer

DEFAULT_LISTEN = "127.0.0.1:0"


def _address(text: str) -> tuple[str, int]:
    """Host and port of ``--listen``."""
    host, _, port = text.rpartition(":")
    if not host or not port.isascii() or not port.isdecimal() or int(port) > 65535:
        raise QuadshadeError(f"--listen is {text!r}", "write HOST:PORT, e.g. 127.0.0.1:8000; port 0 is any")
    return host, int(port)


@click.command(cls=TitledCommand, short_help="Look at a scene in the browser, with its costs.")
@add_options(
    [
        click.argument("scene", shell_complete=complete_file),
        option("Scene", "--material", default="", metavar="KEY=VALUE,...", help="As for `quadshade render`."),
        option("Scene", "--crease", type=float, metavar="DEGREES", help="As for `quadshade render`."),
        option(
            "Scene",
            "--cull/--no-cull",
            default=True,
            show_default=True,
            help="Drop triangles seen from behind.",
        ),
        option("Page", "--size", metavar="WxH", help="Pixels.  [default: 512x512]"),
        option(
            "Page",
            "--listen",
            default=DEFAULT_LISTEN,
            metavar="HOST:PORT",
            help="Where the page is served; another host than this machine's loopback shows it to others.  "
            f"[default: {DEFAULT_LISTEN}, any free port]",
        ),
        option("Page", "--open/--no-open", "opens", default=True, show_default=True, help="Open a browser."),
    ],
    port_options("Draw every picture that stays for a moment on a board as well"),
    verify_options(TITLE, VERIFY_BOARD, "crc"),
)
def view(scene: str, listen: str, opens: bool, size: str | None, **options: Any) -> None:
    """
    Show SCENE in the browser: drag it, and see what every byte buys.

    Shading, exponent, fit and allowed error under the hand; bytes, clocks, errors and frames a second beside
    the picture. Ctrl-C ends it.

    \b
    quadshade view sphere:690
    quadshade view part.stl --material colour=1,0.5,0.1 --port sim
    """
    host, port = _address(listen)
    with leave_at_once():
        try:
            from quadshade.view.server import ViewServer
        except ModuleNotFoundError as error:
            if error.name != "aiohttp":
                raise
            raise QuadshadeError("aiohttp is not installed", "run `pip install quadshade[view]`") from None
        from quadshade.board import Board
        from quadshade.scene import load_scene
        from quadshade.scene.key_values import parse_size
        from quadshade.view.board import ViewedBoard
        from quadshade.view.shown import Viewed
        from quadshade.view.state import ViewState
    width, height = parse_size(size or "512x512")
    state = ViewState.read({"width": width, "height": height})
    options = with_board(options)
    if options["port"] is None and is_given("verify"):
        raise QuadshadeError("--verify is for a board", "give --port as well")
    keywords = {name: options.pop(name) for name in ("material", "crease", "cull")}
    words = [f"--{name}={keywords[name]}" for name in ("material", "crease") if keywords[name]]
    words += [] if keywords["cull"] else ["--no-cull"]
    crease = keywords["crease"]
    viewed = Viewed(scene, load_scene(scene, crease), keywords | {"crease": None}, tuple(words), crease)
    with ExitStack() as stack, reporting() as reports:
        reports.step(f"drawing {scene} for the first time")
        viewed.show(state, True)
        board = None
        if options["port"] is not None:
            reports.step(f"opening the board at {options['port']}")
            opened = Board(
                options["port"],
                options["baud"],
                faults=options["faults"],
                answer_seconds=options["timeout"],
                trace=options["trace"],
                notice=reports.notice,
            )
            board = ViewedBoard(stack.enter_context(opened), viewed, options["verify"])
        server = ViewServer(viewed, state, board)
        asyncio.run(_serve(server, host, port, opens))


async def _serve(server: ViewServer, host: str, port: int, opens: bool) -> None:
    """Serve until a signal comes."""
    runner = await server.start(host, port)
    ended = asyncio.Event()
    loop = asyncio.get_running_loop()
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        loop.add_signal_handler(number, ended.set)
    try:
        click.echo(f"open {server.link}\nCtrl-C ends it")
        if opens:
            webbrowser.open(server.link)
        await ended.wait()
    finally:
        await runner.cleanup()
        server.close()
