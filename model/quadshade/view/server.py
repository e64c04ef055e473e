# SPDX-License-Identifier: Apache-2.0
"""
A page on loopback that shows a scene, and a socket a viewer on which states come and pictures go.

Nothing but the three files of the page is served, under a token that only the printed link has; Host and
Origin must be the server's own. Of the states of a viewer the latest is drawn, the others are dropped.
"""

from __future__ import annotations

import asyncio
import json
import secrets
import struct
from collections.abc import Awaitable, Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
from aiohttp import WSCloseCode, WSMsgType, web

from quadshade.errors import QuadshadeError
from quadshade.view.board import ViewedBoard
from quadshade.view.shown import ERROR_FULL, ORDER_COLOURS, Shown, Viewed
from quadshade.view.state import MAPS, RANGES, WORDS, ViewState

PAGE = Path(__file__).parent / "page"
FILES = {"": "text/html", "view.js": "text/javascript", "view.css": "text/css"}
LARGEST_MESSAGE = 1 << 14
"""Bytes of a state, with room to spare."""

LOOPBACK = "127.0.0.1"
POLICY = "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src data:"


class ViewServer:
    """
    The page of one scene.

    Parameters
    ----------
    viewed : Viewed
    state : ViewState
      What is shown first.
    board : ViewedBoard, optional
      Draws every picture too that stays for a moment.
    token : str, optional
      Part of the link; by default a random one.
    """

    def __init__(
        self, viewed: Viewed, state: ViewState, board: ViewedBoard | None = None, token: str | None = None
    ) -> None:
        self.viewed, self.first, self.board = viewed, state, board
        self.token = token or secrets.token_urlsafe(16)
        self.address = ""
        self.viewers: set[web.WebSocketResponse] = set()
        # One at a time: drawing is the work of one core, whoever looks.
        self._drawing = ThreadPoolExecutor(1, "draw")
        self.drawn = 0

    async def start(self, host: str = LOOPBACK, port: int = 0) -> web.AppRunner:
        """
        Begin to listen.

        Parameters
        ----------
        host : str
        port : int
          0: any free one.

        Returns
        -------
        aiohttp.web.AppRunner
          To be cleaned up in the end.

        Raises
        ------
        QuadshadeError
          An address that cannot be listened at.
        """
        app = web.Application(middlewares=[self._guard], client_max_size=LARGEST_MESSAGE)
        app.router.add_get("/{token}/socket", self._socket)
        app.router.add_get("/{token}/{name:[a-z.]*}", self._file)
        app.on_shutdown.append(self._close_viewers)
        runner = web.AppRunner(app, access_log=None)
        await runner.setup()
        site = web.TCPSite(runner, host, port)
        try:
            await site.start()
        except (OSError, OverflowError) as error:
            await runner.cleanup()
            text = getattr(error, "strerror", None) or str(error)
            raise QuadshadeError(f"cannot listen at {host}:{port}: {text}", "give another --listen") from None
        bound: tuple[str, int] = runner.addresses[0]
        self.address = f"{host}:{bound[1]}"
        return runner

    async def _close_viewers(self, _: web.Application) -> None:
        """Tell the pages that this is the end."""
        for viewer in list(self.viewers):
            await viewer.close(code=WSCloseCode.GOING_AWAY)

    @property
    def link(self) -> str:
        """What a browser opens."""
        return f"http://{self.address}/{self.token}/"

    def close(self) -> None:
        """End the drawing."""
        self._drawing.shutdown(wait=True, cancel_futures=True)
        if self.board is not None:
            self.board.close()

    @web.middleware
    async def _guard(
        self, request: web.Request, handler: Callable[[web.Request], Awaitable[web.StreamResponse]]
    ) -> web.StreamResponse:
        """Refuse who has not the link, another site's page, and a name that only points here."""
        port = self.address.rpartition(":")[2]
        hosts = {self.address, f"localhost:{port}"}
        origin = request.headers.get("Origin")
        token = request.match_info.get("token", "")
        if request.host not in hosts or (origin is not None and origin not in {f"http://{h}" for h in hosts}):
            raise web.HTTPForbidden(text="This page is not for other sites.\n")
        if not secrets.compare_digest(token.encode(), self.token.encode()):
            raise web.HTTPNotFound(text="Open the link that quadshade view has printed.\n")
        response = await handler(request)
        if not response.prepared:
            response.headers["Content-Security-Policy"] = POLICY
            response.headers["Cache-Control"] = "no-store"
            response.headers["Referrer-Policy"] = "no-referrer"
            response.headers["X-Content-Type-Options"] = "nosniff"
        return response

    async def _file(self, request: web.Request) -> web.StreamResponse:
        """One of the page's files."""
        name = request.match_info["name"]
        if name not in FILES:
            raise web.HTTPNotFound(text="There is no such file.\n")
        content = (PAGE / (name or "index.html")).read_text(encoding="utf-8")
        return web.Response(text=content, content_type=FILES[name])

    async def _socket(self, request: web.Request) -> web.StreamResponse:
        """A viewer: states in, pictures out, until the tab is closed."""
        if request.headers.get("Origin") is None:
            raise web.HTTPForbidden(text="A browser says where its page is from.\n")
        socket = web.WebSocketResponse(max_msg_size=LARGEST_MESSAGE, heartbeat=20)
        await socket.prepare(request)
        self.viewers.add(socket)
        latest = Latest()
        painter = asyncio.create_task(self._paint(socket, latest))
        try:
            await socket.send_json({"about": self._about(), "state": self.first.content()})
            async for message in socket:
                if message.type is not WSMsgType.TEXT:
                    await socket.close(code=WSCloseCode.UNSUPPORTED_DATA)
                    break
                try:
                    latest.put(ViewState.read(json.loads(message.data)))
                except QuadshadeError as error:
                    await socket.send_json({"error": str(error)})
                except (ValueError, RecursionError):
                    await socket.send_json({"error": "the page sent no JSON"})
        finally:
            self.viewers.discard(socket)
            painter.cancel()
        return socket

    def _about(self) -> dict[str, object]:
        """What the page has to know once."""
        return {
            "scene": self.viewed.name,
            "triangles": len(self.viewed.mesh),
            "ranges": {name: list(limits) for name, limits in RANGES.items()},
            "words": {name: list(words) for name, words in WORDS.items()},
            "maps": list(MAPS),
            "error_full": ERROR_FULL,
            "order_colours": ORDER_COLOURS.tolist(),
            "board": None if self.board is None else self.board.name,
        }

    async def _paint(self, socket: web.WebSocketResponse, latest: Latest) -> None:
        """Draw what was asked for last; when nothing new comes, measure it and draw it on the board."""
        loop = asyncio.get_running_loop()
        while True:
            state = await latest.get()
            for measure in (False, True):
                if measure and not await latest.is_calm():
                    break
                try:
                    shown = await loop.run_in_executor(self._drawing, self.viewed.show, state, measure)
                except QuadshadeError as error:
                    await socket.send_json({"error": str(error)})
                    break
                self.drawn += 1
                await socket.send_bytes(message_of(shown, state))
            else:
                if self.board is not None:
                    said = await loop.run_in_executor(self._drawing, self.board.draw, state)
                    await socket.send_json({"board": said})


class Latest:
    """A place for one state: a new one takes the place of one that nobody has fetched."""

    def __init__(self) -> None:
        self._state: ViewState | None = None
        self._changed = asyncio.Event()

    def put(self, state: ViewState) -> None:
        """Ask for a state."""
        self._state = state
        self._changed.set()

    async def get(self) -> ViewState:
        """Wait for a state that was not fetched yet."""
        await self._changed.wait()
        self._changed.clear()
        assert self._state is not None
        return self._state

    async def is_calm(self, seconds: float = 0.15) -> bool:
        """Whether nothing new comes for a moment."""
        try:
            await asyncio.wait_for(self._changed.wait(), seconds)
        except TimeoutError:
            return True
        return False


def message_of(shown: Shown, state: ViewState) -> bytes:
    """JSON's length, JSON of figures and state, (height, width, 4) bytes of red, green, blue and 255."""
    height, width = shown.image.shape[:2]
    pixels = np.full((height, width, 4), 255, dtype=np.uint8)
    pixels[..., :3] = shown.image
    text = json.dumps({"figures": shown.figures, "state": state.content()}).encode()
    return struct.pack("<I", len(text)) + text + pixels.tobytes()
