# SPDX-License-Identifier: Apache-2.0
"""A scene that is being looked at, and the server of ``quadshade view`` in a thread of its own."""

from __future__ import annotations

import asyncio
import threading

import quadshade
from quadshade.view import Viewed, ViewState
from quadshade.view.board import ViewedBoard
from quadshade.view.server import ViewServer

SMALL = {"width": 64, "height": 48}


def orange_torus() -> Viewed:
    """A scene, with an option that no state sets."""
    material = {"material": "colour=1,0.5,0.1"}
    return Viewed("torus:288", quadshade.load_scene("torus:288"), material, ("--material=colour=1,0.5,0.1",))


class Served:
    """A server in a thread of its own."""

    def __init__(self, viewed: Viewed, board: ViewedBoard | None = None) -> None:
        self.server = ViewServer(viewed, ViewState.read(SMALL), board)
        self._loop = asyncio.new_event_loop()
        self._runner = self._loop.run_until_complete(self.server.start())
        self._thread = threading.Thread(target=self._loop.run_forever)
        self._thread.start()

    def close(self) -> None:
        """End it, and see that nothing is left."""
        asyncio.run_coroutine_threadsafe(self._runner.cleanup(), self._loop).result(20)
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(20)
        self.server.close()
        self._loop.close()
