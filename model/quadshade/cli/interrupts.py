# SPDX-License-Identifier: Apache-2.0
"""Ctrl-C while modules are still being imported."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

INTERRUPTED = 130
"""Exit code after Ctrl-C, as shells have it."""

MESSAGE = "quadshade: interrupted"


@contextmanager
def leave_at_once() -> Iterator[None]:
    """
    Let Ctrl-C end the process within the block, for imports, during which nothing has been written yet.

    Some modules of trimesh catch every exception while they import what is optional: a ``KeyboardInterrupt``
    would be lost there, and the program would go on. A handler of somebody else's stays.
    """
    ours = threading.current_thread() is threading.main_thread()
    if not ours or signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield
        return
    signal.signal(signal.SIGINT, _leave)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def _leave(*_: object) -> None:
    os.write(2, f"{MESSAGE}\n".encode())
    os._exit(INTERRUPTED)
