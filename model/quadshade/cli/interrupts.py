# SPDX-License-Identifier: Apache-2.0
"""Ctrl-C, `kill` and a closed terminal: the program ends at once and leaves nothing behind."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from quadshade.errors import Terminated

ENDING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)

MESSAGE = "quadshade: interrupted"

AGAIN_SECONDS = 0.1
"""After so long an interrupt is repeated that came where Python drops exceptions."""

_received: list[int] = []
_repeats: list[threading.Timer] = []


def exit_code() -> int:
    """Exit code after the signal that has come, as shells have it; 130 after Ctrl-C."""
    return 128 + (_received[-1] if _received else signal.SIGINT)


def is_interrupted() -> bool:
    """Whether a signal has come, within :func:`ending_in_order`."""
    return bool(_received)


@contextmanager
def ending_in_order() -> Iterator[None]:
    """
    Let the signals that end a program raise ``KeyboardInterrupt``, or ``Terminated``, within the block.

    So files and simulators are cleared away whichever signal it is. An exception may arrive where Python can
    only drop it, as in a callback of Numba's compiler: then it is raised again, and nothing is printed.
    A handler of somebody else's stays.
    """
    _received.clear()
    hook = sys.unraisablehook
    try:
        with _handled(_raise):
            yield
    finally:
        sys.unraisablehook = hook
        for timer in _repeats:
            timer.cancel()
        _repeats.clear()


@contextmanager
def leave_at_once() -> Iterator[None]:
    """
    Let these signals end the process within the block, for imports: nothing has been written yet.

    Some modules of trimesh catch every exception while they import what is optional: a ``KeyboardInterrupt``
    would be lost there, and the program would go on. A handler of somebody else's stays.
    """
    with _handled(_leave):
        yield


@contextmanager
def _handled(handler: Callable[[int, object], None]) -> Iterator[None]:
    """Have the signals handled by a function, where nobody else handles or ignores them."""
    known = (signal.default_int_handler, signal.SIG_DFL, _raise, _leave)
    before = {}
    if threading.current_thread() is threading.main_thread():
        before = {number: signal.getsignal(number) for number in ENDING}
        before = {number: one for number, one in before.items() if one in known}
    for number in before:
        signal.signal(number, handler)
    try:
        yield
    finally:
        for number, one in before.items():
            signal.signal(number, one)


def _raise(number: int, _: object) -> None:
    _received.append(number)
    sys.unraisablehook = _dropped
    raise KeyboardInterrupt if number == signal.SIGINT else Terminated


def _dropped(what: Any) -> None:
    """Instead of printing an exception that Python drops: an interrupt comes once more."""
    if issubclass(what.exc_type, KeyboardInterrupt):
        main = threading.main_thread().ident
        again = threading.Timer(AGAIN_SECONDS, signal.pthread_kill, [main, _received[-1]])
        again.daemon = True
        _repeats.append(again)
        again.start()


def _leave(number: int, _: object) -> None:
    os.write(2, f"{MESSAGE}\n".encode())
    os._exit(128 + number)
